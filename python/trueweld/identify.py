"""Stiffness, damping or process of a cell from logs."""

# Written by python/generate.py: do not edit.

from __future__ import annotations

from collections.abc import Sequence

from . import _run
from ._paths import StrPath
from ._results import (
    IdentifyResult,
)
from ._run import Progress

__all__ = [
    "damping",
    "process",
    "stiffness",
]


def stiffness(
    logs: StrPath | Sequence[StrPath] | None = None,
    *,
    model: StrPath | None = None,
    plan: StrPath | None = None,
    loads: int | None = None,
    payload: float | None = None,
    push: float | None = None,
    noise: float | None = None,
    out: StrPath | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> IdentifyResult:
    """Stiffness of the joints, from loads at rest.

    With ``plan`` it chooses postures and loads instead, and writes them as a protocol for `record`.

    As the command ``trueweld identify stiffness``.

    :param logs: Folders of logs or of campaigns.
    :param model: Model file (default: the campaign's).
    :param plan: Choose the loads that tell the stiffness best, and write them as a protocol.
    :param loads: Loads to choose (default: 6).
    :param payload: Heaviest payload on the flange, kg (default: 500).
    :param push: Largest push against a fixture, N (default: 6000).
    :param noise: Noise of a reflector's coordinate, m (default: 0.00003).
    :param out: Where to write the robot file with the numbers found.
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: IdentifyResult = _run.call(('identify', 'stiffness'), locals(), positional=('logs',))
    return result


def damping(
    logs: StrPath | Sequence[StrPath],
    *,
    model: StrPath | None = None,
    out: StrPath | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> IdentifyResult:
    """Damping of the joints, from ring-downs after a brake's stop.

    As the command ``trueweld identify damping``.

    :param logs: Folders of logs or of campaigns.
    :param model: Model file (default: the campaign's).
    :param out: Where to write the robot file, or the process file, with the numbers found.
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: IdentifyResult = _run.call(('identify', 'damping'), locals(), positional=('logs',))
    return result


def process(
    logs: StrPath | Sequence[StrPath],
    *,
    model: StrPath | None = None,
    out: StrPath | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> IdentifyResult:
    """The welding process with its ripple, from the forces of welds.

    As the command ``trueweld identify process``.

    :param logs: Folders of logs or of campaigns.
    :param model: Model file (default: the campaign's).
    :param out: Where to write the robot file, or the process file, with the numbers found.
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: IdentifyResult = _run.call(('identify', 'process'), locals(), positional=('logs',))
    return result
