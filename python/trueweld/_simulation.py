"""A weld step by step, and many of them on all cores."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Readings
from ._errors import InputWarning
from ._law import Correction, LawLike
from ._paths import StrPath
from ._run import law_name

_Array = npt.NDArray[np.float64]

_JOINTS = tuple(f"a{k}" for k in range(1, 7))

#: Names of the columns of a state.
STATE = tuple(
    f"{name}_{joint}_{unit}"
    for name, unit in (("link", "rad"), ("motor", "rad"), ("link_rate", "rad_s"), ("motor_rate", "rad_s"))
    for joint in _JOINTS
)

#: Names of the columns of the readings. What a seam sensor saw is NaN in a period without a reading.
READINGS = (
    *(f"encoder_{joint}_rad" for joint in _JOINTS),
    *(f"encoder_rate_{joint}_rad_s" for joint in _JOINTS),
    *(f"motor_torque_{joint}_nm" for joint in _JOINTS),
    *(f"force_{axis}_n" for axis in "xyz"),
    *(f"moment_{axis}_nm" for axis in "xyz"),
    "lateral_m",
    "tilt_rad",
)

#: Names of the columns of a deviation, and of a correction.
DEVIATION = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")

_NOTHING = (0.0,) * 6


class Simulation:
    """A weld of a cell that goes on a control period at a time.

    >>> sim = Simulation(weld="fixtures/welds/coupon.toml")
    >>> while not sim.done:
    ...     readings = sim.observe()
    ...     sim.step([0, -0.5 * sim.deviation[1], 0, 0, 0, 0])

    Files and options are those of :func:`weld`. The correction of a step is added to what the law
    demands, and is followed with the bandwidth, rate and size that the control file allows; it acts
    while the force loop is closed. A simulation can be copied (``copy.deepcopy``), pickled, and put
    back to a state; the same corrections give the same bits.
    """

    def __init__(
        self,
        *,
        weld: StrPath | None = None,
        robot: StrPath | None = None,
        model: StrPath | None = None,
        informed: bool = False,
        process: StrPath | None = None,
        control: StrPath | None = None,
        sensors: StrPath | None = None,
        effect: str | Sequence[str] = (),
        stiffness_error: float | None = None,
        spindle_rpm: float | None = None,
        period: float | None = None,
        seed: int | None = None,
        controller: str = "external",
        compensator: LawLike = "none",
        plant_step_s: float = 2e-3,
    ) -> None:
        self._options = {name: value for name, value in locals().items() if name != "self"}
        if model is not None and (robot is not None or process is not None):
            raise ValueError("a model has its robot and process; expected model, or robot and process")
        law = compensator if isinstance(compensator, str) else (law_name(compensator), compensator)
        self._core = _core.CellSimulation(
            [weld, robot, model, process, control, sensors],
            [effect] if isinstance(effect, str) else list(effect),
            [stiffness_error, spindle_rpm, period],
            seed,
            informed,
            controller,
            law,
            plant_step_s,
        )
        for warning in self._core.warnings:
            warnings.warn(warning, InputWarning, stacklevel=2)

    def step(self, correction: Correction | None = None, *, periods: int = 1) -> Readings:
        """One control period, or several with the same correction.

        ``correction``: x, y, z in m, then the rotation about them in rad, axes of W. Gives what the
        instruments show then. Raises where the weld is over.
        """
        if self.done:
            raise RuntimeError("the weld is over; reset() begins another one")
        self._core.step(_six(correction), periods)
        return self.observe()

    def advance(self, duration_s: float) -> Readings:
        """Goes on for a time, s, or to the end of the weld, without a correction."""
        self._core.step(_NOTHING, max(0, round(duration_s / self.period_s)))
        return self.observe()

    def observe(self) -> Readings:
        """What the instruments show at the start of the period that comes: what a law may read."""
        return self._core.observe()

    def reset(self, seed: int | None = None) -> None:
        """To the start of the weld, with noise from a seed (default: that of the options)."""
        self._core.reset(seed)

    @property
    def deviation(self) -> _Array:
        """Real tool against where it should be, axes of W, shape (6,): m, then rad. No law sees it."""
        return self._core.deviation

    @property
    def cell_state(self) -> _Array:
        """Angles and rates on both sides of the gears, shape (24,), in the order of :data:`STATE`."""
        return self._core.cell_state

    @property
    def readings(self) -> _Array:
        """What the instruments show as one array, shape (26,), in the order of :data:`READINGS`."""
        return self._core.readings

    @property
    def record(self) -> dict[str, _Array]:
        """The period that is over: signals by name, axes of W, SI units; empty before the first."""
        record = self._core.record()
        return {} if record is None else {name: np.array(values) for name, values in record}

    @property
    def time_s(self) -> float:
        """Time at the start of the period that comes, s."""
        return self._core.time_s

    @property
    def period_s(self) -> float:
        """Control period, s."""
        return self._core.period_s

    @property
    def path_m(self) -> float:
        """Where the tool is along the seam, m."""
        return self._core.path_m

    @property
    def length_m(self) -> float:
        """Length of the seam, m."""
        return self._core.length_m

    @property
    def phase(self) -> str:
        """Where the weld is in its program."""
        return self._core.phase

    @property
    def is_corrected(self) -> bool:
        """True where a law, and a correction, act: while the force loop is closed."""
        return self._core.is_corrected

    @property
    def done(self) -> bool:
        """True after the last period."""
        return self._core.is_over

    @property
    def periods(self) -> tuple[int, int]:
        """Control periods that are over, and those of the whole weld."""
        return self._core.periods

    @property
    def lateral_tolerance_m(self) -> float:
        """How far beside its line the tool may be, m: of a friction stir weld half the pin."""
        return self._core.lateral_tolerance_m

    @property
    def largest_correction(self) -> tuple[float, float]:
        """The largest correction that the control file allows, m and rad."""
        return self._core.largest_correction

    @property
    def digest(self) -> str:
        """SHA-256 of all that the simulation follows from: files, options, version."""
        return self._core.digest

    def state(self) -> bytes:
        """The state, to go back to by :meth:`restore`, in this process or another one.

        It holds every number that changes, and in front of them the :attr:`digest`. Of a law in
        Python it holds a pickle of what the law keeps: see :class:`Law`.
        """
        return self._core.state()

    def restore(self, state: bytes) -> None:
        """Goes to a state. Refused where cell, weld, law, options or version are others.

        Of a simulation with a law in Python, unpickles what the law kept: take such a state from a
        source that you trust.
        """
        self._core.restore(state)

    def copy(self) -> Simulation:
        """The same weld in the same period, on its own from here on."""
        copied = object.__new__(Simulation)
        copied._options, copied._core = self._options, self._core.copy()
        return copied

    __copy__ = copy

    def __deepcopy__(self, memo: dict[int, Any]) -> Simulation:
        return self.copy()

    def __reduce__(self) -> tuple[Any, ...]:
        return (_restored, (self._options, self.state()))

    def __repr__(self) -> str:
        done, all_ = self.periods
        return f"<Simulation: law {self._core.law}, period {done} of {all_}, {self.phase}>"


def _restored(options: dict[str, Any], state: bytes) -> Simulation:
    simulation = Simulation(**options)
    simulation.restore(state)
    return simulation


def _six(correction: Correction | None) -> Sequence[float]:
    if correction is None:
        return _NOTHING
    values = [float(value) for value in correction]
    if len(values) != 6:
        raise ValueError(f"correction: expected 6 numbers (x, y, z in m, rotation in rad), and there are {len(values)}")
    return values


class Rollout(NamedTuple):
    """Many welds stepped side by side. A row a weld; NaN where a weld was over before."""

    #: Angles and rates, shape (nbatch, nstep, 24), in the order of :data:`STATE`.
    state: _Array
    #: What the instruments showed, shape (nbatch, nstep, 26), in the order of :data:`READINGS`.
    sensordata: _Array
    #: Real tool against where it should be, shape (nbatch, nstep, 6), in the order of
    #: :data:`DEVIATION`.
    deviation: _Array
    #: Periods that were made, shape (nbatch,).
    periods: npt.NDArray[np.intp]


def rollout(
    simulation: Simulation | Sequence[Simulation],
    control: npt.ArrayLike | None = None,
    *,
    nstep: int | None = None,
    every: int = 1,
) -> Rollout:
    """Steps copies of simulations on all cores, without holding Python up.

    ``simulation``: one for all rows, or one a row; they stay as they are. ``control``: a correction
    for every step, of shape (nbatch, nstep, 6); (nstep, 6) is one row for all simulations, None no
    corrections. ``nstep``: control periods where there is no control (default: to the end of the
    weld). ``every``: keeps one step in so many, the last of them.

    The shapes are those of ``mujoco.rollout``.
    """
    simulations = [simulation] if isinstance(simulation, Simulation) else list(simulation)
    if not simulations:
        raise ValueError("there is no simulation; expected one at least")
    if every < 1:
        raise ValueError(f"every={every}: expected a number from 1 up")
    array = None
    if control is not None:
        array = np.ascontiguousarray(control, dtype=np.float64)
        array = array[np.newaxis] if array.ndim == 2 else array
        if array.ndim != 3 or array.shape[2] != 6:
            raise ValueError(f"control: expected the shape (nbatch, nstep, 6), and it is {array.shape}")
        if nstep is not None and nstep != array.shape[1]:
            raise ValueError(f"nstep={nstep}, and control has {array.shape[1]} steps")
    longest = max(of.periods[1] - of.periods[0] for of in simulations)
    state, sensordata, deviation, periods = _core.roll_out(
        [of._core for of in simulations], array, longest if nstep is None else nstep, every
    )
    return Rollout(state, sensordata, deviation, np.array(periods, dtype=np.intp))
