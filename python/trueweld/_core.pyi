"""The module in Rust."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ._paths import StrPath

_Array = npt.NDArray[np.float64]

VERSION: str
SOURCES: str

def run_program(arguments: Sequence[str]) -> int: ...
def run_command(
    arguments: Sequence[str],
    laws: Sequence[tuple[str, Any]],
    law_file: StrPath | None,
    progress: Callable[[str, float], object] | None,
) -> CommandOutcome: ...
def describe_commands() -> list[dict[str, Any]]: ...
def read_log(folder: StrPath) -> Log: ...
def roll_out(
    simulations: Sequence[CellSimulation], corrections: _Array | None, periods: int, every: int
) -> tuple[_Array, _Array, _Array, list[int]]: ...
def step_all(
    simulations: Sequence[CellSimulation], corrections: _Array, periods: int
) -> tuple[_Array, _Array, list[bool]]: ...

class CommandOutcome:
    @property
    def status(self) -> int: ...
    @property
    def text(self) -> str: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def results(self) -> list[FoundResult]: ...

class FoundResult:
    @property
    def schema(self) -> str: ...
    @property
    def json(self) -> str: ...
    @property
    def headline(self) -> str | None: ...
    @property
    def samples(self) -> ResultTable | None: ...
    def page(self) -> str | None: ...

class ResultTable:
    @staticmethod
    def from_columns(columns: Sequence[tuple[str, Any]]) -> ResultTable: ...
    @property
    def names(self) -> list[str]: ...
    def __len__(self) -> int: ...
    def __getitem__(self, name: str) -> Any: ...
    def matrix(self, names: Sequence[str], first: int, end: int) -> _Array: ...
    def sections(self, names: Sequence[str]) -> list[tuple[list[str], int, int]]: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

class Readings:
    """What a law sees in one control period.

    Arrays are new ones, in SI units. Frames: B base, T tool, W weld (x along the weld, y across it, z
    into the material).
    """

    @property
    def time_s(self) -> float:
        """Time since the law was first asked in this weld, s."""
    @property
    def period_s(self) -> float:
        """Control period, s."""
    @property
    def path_m(self) -> float:
        """Where the tool is along the seam, m."""
    @property
    def encoder_rad(self) -> _Array:
        """Encoder angles, rad, shape (6,)."""
    @property
    def encoder_rate_rad_s(self) -> _Array:
        """Encoder rates, rad/s, shape (6,)."""
    @property
    def motor_torque_nm(self) -> _Array:
        """Motor torque of the last period, seen from the joint, N·m, shape (6,)."""
    @property
    def force_n(self) -> _Array:
        """Force on the tool by the force sensor, N, axes of T, shape (3,)."""
    @property
    def moment_nm(self) -> _Array:
        """Moment on the tool at its tip by the force sensor, N·m, axes of T, shape (3,)."""
    @property
    def planned_force_n(self) -> _Array:
        """Force on the tool that the weld was planned with, N, axes of W, shape (3,)."""
    @property
    def push_n(self) -> float:
        """Push into the material that is asked for, N; NaN where none is."""
    @property
    def spindle_rad_s(self) -> float:
        """Speed of the spindle, rad/s."""
    @property
    def b_from_w(self) -> _Array:
        """Axes of W in B, shape (3, 3): a column an axis."""
    @property
    def nominal_rotation(self) -> _Array:
        """Where the real tool should be: its axes in B, shape (3, 3)."""
    @property
    def nominal_position_m(self) -> _Array:
        """Where the real tool should be: its tip in B, m, shape (3,)."""
    @property
    def encoder_deviation(self) -> _Array:
        """How far the encoders' pose lies from the nominal one, axes of W, shape (6,): m, then rad."""
    @property
    def lateral_m(self) -> float:
        """The seam sensor's newest reading across the seam, m; NaN in a period without one."""
    @property
    def tilt_rad(self) -> float:
        """The seam sensor's newest reading of the tilt, rad; NaN in a period without one."""
    @property
    def measurements(self) -> list[tuple[float, _Array, float, float, float]]:
        """Every reading of the deviation from outside the robot in this period: deviation, direction
        (6,), noise, age_s, ahead_m."""
    def feed_forward(self) -> _Array:
        """The demand of the law `feed-forward` in this period, shape (6,)."""

class Log:
    """A recorded log: its rows in SI units, in the frames of its files. What was not recorded is None;
    of one joint alone, NaN."""

    @property
    def name(self) -> str: ...
    @property
    def kind(self) -> str:
        """What was done: static-load, ring-down, free-motion or weld."""
    @property
    def robot(self) -> str: ...
    @property
    def period_s(self) -> float | None: ...
    @property
    def files(self) -> list[str]: ...
    @property
    def notices(self) -> list[str]: ...
    @property
    def warnings(self) -> list[str]: ...
    def __len__(self) -> int: ...
    @property
    def time_s(self) -> _Array: ...
    @property
    def encoder_rad(self) -> _Array:
        """Encoder angles, rad, shape (time, joint)."""
    @property
    def link_encoder_rad(self) -> _Array | None:
        """Angles by second encoders behind the gears, rad, shape (time, joint)."""
    @property
    def motor_torque_nm(self) -> _Array | None:
        """Motor torques seen from the joints, N·m, shape (time, joint)."""
    @property
    def force_n(self) -> _Array | None:
        """Force on the tool, N, axes of T, shape (time, 3)."""
    @property
    def moment_nm(self) -> _Array | None:
        """Moment on the tool at its tip, N·m, axes of T, shape (time, 3)."""
    @property
    def tracker_m(self) -> _Array | None:
        """Position of the tool by the tracker, m, in B, shape (time, 3)."""
    @property
    def tracker_rad(self) -> _Array | None:
        """Rotation of the tool by the tracker, rad, in B, shape (time, 3)."""
    @property
    def spindle_rad_s(self) -> _Array | None:
        """Speed of the spindle, positive about the tool's z axis, rad/s, shape (time,)."""

class CellSimulation:
    def __new__(
        cls,
        files: Sequence[StrPath | None],
        effects: Sequence[str],
        numbers: Sequence[float | None],
        seed: int | None,
        informed: bool,
        controller: str,
        law: str | tuple[str, Any],
        plant_step_s: float,
    ) -> CellSimulation: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def deviation(self) -> _Array: ...
    @property
    def cell_state(self) -> _Array: ...
    @property
    def readings(self) -> _Array: ...
    @property
    def time_s(self) -> float: ...
    @property
    def period_s(self) -> float: ...
    @property
    def path_m(self) -> float: ...
    @property
    def length_m(self) -> float: ...
    @property
    def phase(self) -> str: ...
    @property
    def law(self) -> str: ...
    @property
    def digest(self) -> str: ...
    @property
    def is_corrected(self) -> bool: ...
    @property
    def is_over(self) -> bool: ...
    @property
    def broken(self) -> str | None: ...
    @property
    def periods(self) -> tuple[int, int]: ...
    @property
    def lateral_tolerance_m(self) -> float: ...
    @property
    def largest_correction(self) -> tuple[float, float]: ...
    def step(self, correction: Sequence[float], periods: int) -> int: ...
    def reset(self, seed: int | None = None) -> None: ...
    def copy(self) -> CellSimulation: ...
    def observe(self) -> Readings: ...
    def record(self) -> list[tuple[str, list[float]]] | None: ...
    def state(self) -> bytes: ...
    def restore(self, state: bytes) -> None: ...
