"""Studies of a cell."""

# Written by python/generate.py: do not edit.

from __future__ import annotations

from collections.abc import Sequence

from . import _run
from ._law import LawLike
from ._paths import StrPath
from ._results import (
    StudyLayoutResult,
    StudyLimitsResult,
    StudyPaperResult,
    StudySensitivityResult,
)
from ._run import Progress

__all__ = [
    "layout",
    "limits",
    "paper",
    "sensitivity",
]


def layout(
    *,
    weld: StrPath | Sequence[StrPath] | None = None,
    robot: StrPath | None = None,
    model: StrPath | None = None,
    informed: bool = False,
    process: StrPath | None = None,
    control: StrPath | None = None,
    sensors: StrPath | None = None,
    effect: str | Sequence[str] | None = None,
    stiffness_error: float | None = None,
    spindle_rpm: float | None = None,
    period: float | None = None,
    seed: int | None = None,
    x: str | None = None,
    y: str | None = None,
    z: str | None = None,
    turn: str | None = None,
    incline: str | None = None,
    roll: str | None = None,
    allow: str | Sequence[str] | None = None,
    front: str | Sequence[str] | None = None,
    compensator: LawLike | None = None,
    controller: str | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    rrd: StrPath | None = None,
    law_file: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> StudyLayoutResult:
    """Find where a part is best put, and the arm's posture there.

    As the command ``trueweld study layout``.

    :param weld: Weld file; several are seams of one part, which move together (default: the first
        published sequence).
    :param robot: Robot file (default: KR 500 MT with FSW end effector).
    :param model: Model file: robot, process and effects of the real cell, instead of ``robot`` and
        ``process``.
    :param informed: The controller knows the model file's effects as well: other numbers of its
        robot, such as stiffness and geometry; refused where there are others.
    :param process: Process file (default: lap weld, stringer on 2024-T3 skin).
    :param control: Gains and limits of the controllers (default: tuned for the KR 500 MT).
    :param sensors: Sensor file (default: encoders and force sensor of the KR 500 MT cell).
    :param effect: Physical effect of the real robot that the controller does not know; may be given
        several times.
    :param stiffness_error: Relative error of the joint stiffness that the controller believes in,
        such as 0.1 (default: 0; of compare-laws: 0.2).
    :param spindle_rpm: Speed of the spindle in turns a minute, in the sense of the process file's
        (default: the process file's speed).
    :param period: Control period in seconds (default: the control file's).
    :param seed: Seed of the sensors' noise (default: the sensor file's).
    :param x: Where the middle of the seams may be along x of B, in metres (default: 0.6 m to either
        side of where the file has it, by 0.1 m).
    :param y: Likewise along y (default: as the file has it).
    :param z: Likewise along z (default: from 0.3 m below to 0.9 m above the file's, by 0.1 m).
    :param turn: Turn of the part about the vertical, in degrees (default: −90:90:30).
    :param incline: Inclination of the part about the first seam, in degrees (default: as the file
        has it).
    :param roll: Turn of the tool about its own axis, in degrees (default: as the robot's file has
        it).
    :param allow: What is allowed of a figure, such as torque_share=0.8; may be given several times.
    :param front: Figures that the front is of, comma between them (default:
        lateral_max_m,torque_share,tilt_max_rad).
    :param compensator: Law that the full runs are made with, beside those without (default: seam-
        tracking, where the cell has the sensor).
    :param controller: Hybrid force/position controller (default: external).
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param rrd: Write a Rerun recording (open with: rerun FILE).
    :param law_file: File that a law in Python is in: its digest enters the result, which says so
        where none is given.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: StudyLayoutResult = _run.call(('study', 'layout'), locals(), joined=('front',))
    return result


def limits(
    *,
    weld: StrPath | None = None,
    robot: StrPath | None = None,
    model: StrPath | None = None,
    informed: bool = False,
    process: StrPath | None = None,
    control: StrPath | None = None,
    sensors: StrPath | None = None,
    effect: str | Sequence[str] | None = None,
    stiffness_error: float | None = None,
    spindle_rpm: float | None = None,
    period: float | None = None,
    seed: int | None = None,
    compensator: LawLike | None = None,
    controller: str | None = None,
    requirements: StrPath | None = None,
    what: str | Sequence[str] | None = None,
    most_force: float | None = None,
    most_feed: float | None = None,
    most_offset: float | None = None,
    length: float | None = None,
    x: str | None = None,
    z: str | None = None,
    passes: int | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    law_file: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> StudyLimitsResult:
    """Find the largest push, feed and offset of the seam that keep requirements, and what limits them.

    As the command ``trueweld study limits``.

    :param weld: Weld file (default: the first published sequence).
    :param robot: Robot file (default: KR 500 MT with FSW end effector).
    :param model: Model file: robot, process and effects of the real cell, instead of ``robot`` and
        ``process``.
    :param informed: The controller knows the model file's effects as well: other numbers of its
        robot, such as stiffness and geometry; refused where there are others.
    :param process: Process file (default: lap weld, stringer on 2024-T3 skin).
    :param control: Gains and limits of the controllers (default: tuned for the KR 500 MT).
    :param sensors: Sensor file (default: encoders and force sensor of the KR 500 MT cell).
    :param effect: Physical effect of the real robot that the controller does not know; may be given
        several times.
    :param stiffness_error: Relative error of the joint stiffness that the controller believes in,
        such as 0.1 (default: 0; of compare-laws: 0.2).
    :param spindle_rpm: Speed of the spindle in turns a minute, in the sense of the process file's
        (default: the process file's speed).
    :param period: Control period in seconds (default: the control file's).
    :param seed: Seed of the sensors' noise (default: the sensor file's).
    :param compensator: Compensation law, or several with + between them (default: seam-tracking).
    :param controller: Hybrid force/position controller (default: external).
    :param requirements: Requirements, whose [limits] are to be kept (default: those of the lap
        weld).
    :param what: What is driven (default: force, feed, offset).
    :param most_force: Largest push, in newtons (default: twice the weld's).
    :param most_feed: Largest feed, in metres a second (default: three times the weld's); feeds
        along the seam change in proportion.
    :param most_offset: Largest offset of the seam to either side, in metres (default: 0.01).
    :param length: Length to weld, from the start of the seam, in metres (default: the whole seam).
    :param x: Places of the seam's middle along x of B besides its own, in metres.
    :param z: Likewise along z.
    :param passes: Welds of one seam, the law kept; the last one counts (default: 1).
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param law_file: File that a law in Python is in: its digest enters the result, which says so
        where none is given.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: StudyLimitsResult = _run.call(('study', 'limits'), locals(), joined=('what',))
    return result


def sensitivity(
    *,
    weld: StrPath | None = None,
    robot: StrPath | None = None,
    model: StrPath | None = None,
    informed: bool = False,
    process: StrPath | None = None,
    control: StrPath | None = None,
    sensors: StrPath | None = None,
    effect: str | Sequence[str] | None = None,
    stiffness_error: float | None = None,
    spindle_rpm: float | None = None,
    period: float | None = None,
    seed: int | None = None,
    compensator: LawLike | None = None,
    controller: str | None = None,
    requirements: StrPath | None = None,
    length: float | None = None,
    rows: int | None = None,
    margins: bool = False,
    draws: int | None = None,
    evidence: StrPath | None = None,
    shard: str | None = None,
    merge: StrPath | Sequence[StrPath] | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    law_file: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> StudySensitivityResult:
    """Show which of the uncertain numbers of a cell a weld's figures follow from.

    As the command ``trueweld study sensitivity``.

    :param weld: Weld file (default: the first published sequence).
    :param robot: Robot file (default: KR 500 MT with FSW end effector).
    :param model: Model file: robot, process and effects of the real cell, instead of ``robot`` and
        ``process``.
    :param informed: The controller knows the model file's effects as well: other numbers of its
        robot, such as stiffness and geometry; refused where there are others.
    :param process: Process file (default: lap weld, stringer on 2024-T3 skin).
    :param control: Gains and limits of the controllers (default: tuned for the KR 500 MT).
    :param sensors: Sensor file (default: encoders and force sensor of the KR 500 MT cell).
    :param effect: Physical effect of the real robot that the controller does not know; may be given
        several times.
    :param stiffness_error: Relative error of the joint stiffness that the controller believes in,
        such as 0.1 (default: 0; of compare-laws: 0.2).
    :param spindle_rpm: Speed of the spindle in turns a minute, in the sense of the process file's
        (default: the process file's speed).
    :param period: Control period in seconds (default: the control file's).
    :param seed: Seed of the sensors' noise (default: the sensor file's).
    :param compensator: Compensation law, or several with + between them (default: none).
    :param controller: Hybrid force/position controller (default: external).
    :param requirements: Requirements, which say what is uncertain (default: those of the lap weld).
    :param length: Length to weld, from the start of the seam, in metres; a whole seam is welded
        where it is shorter (default: 0.3).
    :param rows: Rows of the design: each has a run for every input and two more (default: 128).
    :param margins: The margins of the loop in the middle of the seam as well.
    :param draws: Seed of the design (default: 1).
    :param evidence: Keep the runs in this folder: a study that was stopped goes on there, and ends
        with them as a table with a manifest.
    :param shard: Make part I of N of the runs, in an evidence folder of its own; no result yet.
    :param merge: Put shards together that were made with the same options.
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param law_file: File that a law in Python is in: its digest enters the result, which says so
        where none is given.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: StudySensitivityResult = _run.call(('study', 'sensitivity'), locals())
    return result


def paper(
    *,
    robot: StrPath | None = None,
    model: StrPath | None = None,
    informed: bool = False,
    process: StrPath | None = None,
    control: StrPath | None = None,
    sensors: StrPath | None = None,
    effect: str | Sequence[str] | None = None,
    stiffness_error: float | None = None,
    spindle_rpm: float | None = None,
    period: float | None = None,
    seed: int | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> StudyPaperResult:
    """Show the figures of the published study beside ours, on one page.

    As the command ``trueweld study paper``.

    :param robot: Robot file (default: KR 500 MT with FSW end effector).
    :param model: Model file: robot, process and effects of the real cell, instead of ``robot`` and
        ``process``.
    :param informed: The controller knows the model file's effects as well: other numbers of its
        robot, such as stiffness and geometry; refused where there are others.
    :param process: Process file (default: lap weld, stringer on 2024-T3 skin).
    :param control: Gains and limits of the controllers (default: tuned for the KR 500 MT).
    :param sensors: Sensor file (default: encoders and force sensor of the KR 500 MT cell).
    :param effect: Physical effect of the real robot that the controller does not know; may be given
        several times.
    :param stiffness_error: Relative error of the joint stiffness that the controller believes in,
        such as 0.1 (default: 0; of compare-laws: 0.2).
    :param spindle_rpm: Speed of the spindle in turns a minute, in the sense of the process file's
        (default: the process file's speed).
    :param period: Control period in seconds (default: the control file's).
    :param seed: Seed of the sensors' noise (default: the sensor file's).
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: StudyPaperResult = _run.call(('study', 'paper'), locals())
    return result
