"""Welds as environments of Gymnasium, one at a time or many side by side. Needs the extra ``gym``.

>>> env = gymnasium.make("trueweld/Weld-v0", weld="fixtures/welds/coupon.toml")

An action is a correction, from -1 to 1 of the largest that the control file allows. An observation is
what the instruments show, scaled; the real deviation, which no instrument of the robot sees, is in
``info["deviation_m"]`` and makes the reward.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from . import _core
from ._simulation import READINGS, Simulation

__all__ = ["WeldEnv", "WeldVectorEnv"]

_Observation = npt.NDArray[np.float32]

# Of a simulation that broke off: worse than any weld that came to its end.
_BROKEN_REWARD = -1000.0

_COLUMN = {name: k for k, name in enumerate(READINGS)}
_FORCE = slice(_COLUMN["force_x_n"], _COLUMN["force_z_n"] + 1)
_MOMENT = slice(_COLUMN["moment_x_nm"], _COLUMN["moment_z_nm"] + 1)
_RATE = slice(_COLUMN["encoder_rate_a1_rad_s"], _COLUMN["encoder_rate_a6_rad_s"] + 1)
_LATERAL, _TILT = _COLUMN["lateral_m"], _COLUMN["tilt_rad"]

# What the readings are divided by: N, N·m, rad/s, rad. Beyond them they are held at 1.
_SCALES = {"force": 4e4, "moment": 4e3, "rate": 0.1, "tilt": 0.02}

_DIRECTIONS = ("x", "y", "rx", "ry", "rz")


class _Task:
    """What both environments share: spaces, scales, rewards."""

    def __init__(self, simulation: Simulation, directions: tuple[str, ...], periods: int) -> None:
        unknown = [name for name in directions if name not in _DIRECTIONS]
        if unknown or not directions:
            raise ValueError(f"directions {directions}: expected some of {_DIRECTIONS}")
        if periods < 1:
            raise ValueError(f"periods={periods}: expected a number from 1 up")
        self.columns = [["x", "y", "z", "rx", "ry", "rz"].index(name) for name in directions]
        lateral, orientation = simulation.largest_correction
        self.largest = np.array([orientation if "r" in name else lateral for name in directions])
        self.tolerance = simulation.lateral_tolerance_m
        self.length = simulation.length_m
        self.periods = periods
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (len(directions),), np.float32)
        # Path, seam sensor across and in tilt, force, moment, rates, the last action.
        size = 1 + 2 + 3 + 3 + 6 + len(directions)
        self.observation_space = gymnasium.spaces.Box(-1.0, 1.0, (size,), np.float32)

    def corrections(self, actions: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
        """Corrections of the actions, a row each."""
        corrections = np.zeros((len(actions), 6))
        corrections[:, self.columns] = np.clip(actions, -1.0, 1.0) * self.largest
        return corrections

    def observation(
        self, path_m: float, readings: npt.NDArray[Any], seen: npt.NDArray[Any], action: npt.NDArray[Any]
    ) -> _Observation:
        """`seen`: the last readings of the seam sensor, which has none in most periods."""
        new = readings[[_LATERAL, _TILT]]
        seen[:] = np.where(np.isfinite(new), new, seen)
        parts = (
            [path_m / self.length],
            seen / [self.tolerance, _SCALES["tilt"]],
            readings[_FORCE] / _SCALES["force"],
            readings[_MOMENT] / _SCALES["moment"],
            readings[_RATE] / _SCALES["rate"],
            action,
        )
        return np.clip(np.concatenate(parts), -1.0, 1.0).astype(np.float32)

    def reward(self, deviation: npt.NDArray[Any]) -> float:
        """0 on the seam, -1 where the tool is beside it by the tolerance."""
        return -float((deviation[1] / self.tolerance) ** 2)


def _begin(simulation: Simulation, seed: int) -> None:
    """To where the force loop closes: before that a correction does nothing."""
    simulation.reset(seed)
    while not simulation.is_corrected and not simulation.done:
        simulation.step()


def _info(simulation: Simulation, deviation: npt.NDArray[Any]) -> dict[str, Any]:
    return {"deviation_m": deviation[:3].copy(), "deviation_rad": deviation[3:].copy(), "time_s": simulation.time_s}


class WeldEnv(gymnasium.Env[_Observation, npt.NDArray[np.float32]]):
    """One weld an episode.

    ``directions``: the directions of W that an action corrects, of x, y, rx, ry and rz;
    ``periods``: control periods a step; ``options``: those of :class:`trueweld.Simulation`, of which
    a law makes the action an addition to what it demands. The end of the weld terminates an episode,
    as a weld does that breaks off; nothing truncates one.
    """

    metadata = {"render_modes": []}

    def __init__(self, *, directions: tuple[str, ...] = ("y",), periods: int = 4, **options: Any) -> None:
        self.simulation = Simulation(**options)
        self._task = _Task(self.simulation, tuple(directions), periods)
        self.action_space = self._task.action_space
        self.observation_space = self._task.observation_space
        self._seen = np.zeros(2)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[_Observation, dict[str, Any]]:
        """A new weld, at the moment at which the force loop closes."""
        super().reset(seed=seed)
        _begin(self.simulation, int(self.np_random.integers(2**32)))
        self._seen[:] = 0.0
        action = np.zeros(len(self._task.columns))
        return self._observation(action), _info(self.simulation, self.simulation.deviation)

    def step(self, action: npt.NDArray[np.float32]) -> tuple[_Observation, float, bool, bool, dict[str, Any]]:
        """So many control periods with one correction."""
        correction = self._task.corrections(np.asarray(action)[np.newaxis])[0]
        broken = None
        try:
            self.simulation.step(correction, periods=self._task.periods)
        except RuntimeError:
            broken = self.simulation._core.broken
            if broken is None:
                raise
        deviation = self.simulation.deviation
        info = _info(self.simulation, deviation)
        reward = self._task.reward(deviation)
        if broken is not None:
            reward, info["broken"] = _BROKEN_REWARD, broken
        done = self.simulation.done or broken is not None
        return self._observation(np.asarray(action)), reward, done, False, info

    def _observation(self, action: npt.NDArray[Any]) -> _Observation:
        return self._task.observation(self.simulation.path_m, self.simulation.readings, self._seen, action)


class WeldVectorEnv(VectorEnv[Any, Any, Any]):
    """Many welds side by side, stepped in Rust on all cores.

    As :class:`WeldEnv`; each has noise of its own. A weld that is over begins anew in the next step
    (``AutoresetMode.NEXT_STEP``).
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self, num_envs: int, *, directions: tuple[str, ...] = ("y",), periods: int = 4, **options: Any
    ) -> None:
        if num_envs < 1:
            raise ValueError(f"num_envs={num_envs}: expected a number from 1 up")
        first = Simulation(**options)
        self.num_envs = num_envs
        self.simulations = [first, *(first.copy() for _ in range(num_envs - 1))]
        self._task = _Task(first, tuple(directions), periods)
        self.single_action_space = self._task.action_space
        self.single_observation_space = self._task.observation_space
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._seen = np.zeros((num_envs, 2))
        self._over = np.zeros(num_envs, dtype=bool)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """New welds; with a number as seed, weld k has the seed k above it."""
        super().reset(seed=seed if isinstance(seed, int) else None)
        seeds: list[int | None]
        if isinstance(seed, list):
            seeds = seed
        else:
            seeds = [None if seed is None else seed + k for k in range(self.num_envs)]
        for k, own in enumerate(seeds):
            self._begin(k, own)
        actions = np.zeros((self.num_envs, len(self._task.columns)))
        readings = np.stack([simulation.readings for simulation in self.simulations])
        deviations = np.stack([simulation.deviation for simulation in self.simulations])
        self._over[:] = False
        return self._observations(readings, actions), self._infos(deviations)

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """So many control periods with a correction each; what was over begins anew instead."""
        actions = np.array(actions, dtype=np.float64)
        fresh = self._over.copy()
        for k in np.flatnonzero(fresh):
            self._begin(int(k), None)
            actions[k] = 0.0
        corrections = self._task.corrections(actions)
        going = np.flatnonzero(~fresh)
        readings = np.stack([simulation.readings for simulation in self.simulations])
        deviations = np.stack([simulation.deviation for simulation in self.simulations])
        over = np.zeros(self.num_envs, dtype=bool)
        if len(going):
            stepped = _core.step_all([self.simulations[k]._core for k in going], corrections[going], self._task.periods)
            readings[going], deviations[going], over[going] = stepped
        rewards = np.array([self._task.reward(deviation) for deviation in deviations])
        for k in np.flatnonzero(over):
            if self.simulations[k]._core.broken is not None:
                rewards[k] = _BROKEN_REWARD
        rewards[fresh] = 0.0
        self._over = over
        truncated = np.zeros(self.num_envs, dtype=bool)
        return self._observations(readings, actions), rewards, over.copy(), truncated, self._infos(deviations)

    def _begin(self, k: int, seed: int | None) -> None:
        if seed is None:
            own = int(self.np_random.integers(2**32))
        else:
            own = int(np.random.default_rng(seed).integers(2**32))
        _begin(self.simulations[k], own)
        self._seen[k] = 0.0

    def _observations(self, readings: npt.NDArray[Any], actions: npt.NDArray[Any]) -> Any:
        rows = zip(self.simulations, readings, self._seen, actions, strict=True)
        return np.stack([self._task.observation(of.path_m, read, seen, action) for of, read, seen, action in rows])

    def _infos(self, deviations: npt.NDArray[Any]) -> dict[str, Any]:
        there = np.ones(self.num_envs, dtype=bool)
        return {"deviation_m": deviations[:, :3].copy(), "_deviation_m": there}


gymnasium.register(id="trueweld/Weld-v0", entry_point=WeldEnv)
