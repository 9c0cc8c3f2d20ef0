"""Recorded logs."""

from __future__ import annotations

import warnings

from . import _core
from ._core import Log
from ._errors import InputWarning
from ._paths import StrPath


def read_log(folder: StrPath) -> Log:
    """Reads the log in a folder, whose ``log.toml`` says how its files are read.

    Gives its rows in SI units, as arrays of shape (time, joint). :func:`import_log` writes a
    ``log.toml`` for files as instruments wrote them.
    """
    log = _core.read_log(folder)
    for warning in log.warnings:
        warnings.warn(warning, InputWarning, stacklevel=2)
    return log
