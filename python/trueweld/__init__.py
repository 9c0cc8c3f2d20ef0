"""Keeps a robot's tool true while the robot bends under it.

>>> import trueweld as tw
>>> welds = tw.weld(compensator="elastostatic")         # a weld, simulated
>>> welds.runs[0].lateral_m.max_abs                     # names are those of the JSON, SI units
>>> welds.trajectories[0].link_rad                       # arrays, (time, joint)

Every command of the program is a function: :func:`weld`, :func:`compare`, :func:`diagnose`,
:func:`improve`, :func:`certify`, ``study.limits``, ``identify.stiffness`` and so on. Results print as
the program prints them and show as its page in a notebook. A law of one's own is any object with a
method ``demand(readings)``; a weld goes on step by step in a :class:`Simulation`.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from . import _core
from ._commands import (
    certify,
    check,
    compare,
    compare_laws,
    diagnose,
    export_core,
    export_fmu,
    import_log,
    import_urdf,
    improve,
    init,
    new_law,
    plan,
    record,
    register,
    replay,
    schema,
    step,
    tune,
    weld,
)
from ._core import Log, Readings
from ._errors import ArgumentError, CommandError, InputError, InputWarning, LawError, TrueweldError
from ._extras import needed
from ._law import Law
from ._log import read_log
from ._records import Record, Result
from ._simulation import Rollout, Simulation, rollout
from ._table import Table, Trajectory

if TYPE_CHECKING:
    from . import effects, fixtures, gym, identify, study

__version__ = _core.VERSION.split(" ", 1)[0]

__all__ = [
    "ArgumentError",
    "CommandError",
    "InputError",
    "InputWarning",
    "Law",
    "LawError",
    "Log",
    "Readings",
    "Record",
    "Result",
    "Rollout",
    "Simulation",
    "Table",
    "Trajectory",
    "TrueweldError",
    "certify",
    "check",
    "compare",
    "compare_laws",
    "diagnose",
    "effects",
    "export_core",
    "export_fmu",
    "fixtures",
    "gym",
    "identify",
    "import_log",
    "import_urdf",
    "improve",
    "init",
    "new_law",
    "read_log",
    "plan",
    "record",
    "register",
    "replay",
    "rollout",
    "schema",
    "step",
    "study",
    "tune",
    "weld",
]

# Read when they are asked for: a script that welds needs none of them.
_LAZY = {"effects", "fixtures", "gym", "identify", "study"}


def __getattr__(name: str) -> Any:
    if name == "gym":
        needed("gymnasium", "gym")
    if name in _LAZY:
        return importlib.import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_LAZY})
