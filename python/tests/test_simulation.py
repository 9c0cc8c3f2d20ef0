"""A weld step by step, and many side by side."""

from __future__ import annotations

import copy
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import trueweld as tw

pytestmark = pytest.mark.filterwarnings("ignore::trueweld.InputWarning")


class Integral:
    """The integral of what the seam sensor sees across the seam."""

    def __init__(self) -> None:
        self.across_m = 0.0

    def demand(self, readings: tw.Readings) -> list[float]:
        if np.isfinite(readings.lateral_m):
            self.across_m -= 0.02 * readings.lateral_m
        return [0.0, self.across_m, 0.0, 0.0, 0.0, 0.0]


def test_a_law_step_by_step_is_the_law_in_a_weld_to_the_last_bit(place: Path) -> None:
    welded = tw.weld(weld="short.toml", compensator=Integral)
    sim = tw.Simulation(weld="short.toml", plant_step_s=1e-3)
    law, deviations = Integral(), []
    while not sim.done:
        sim.step(law.demand(sim.observe()) if sim.is_corrected else None)
        deviations.append(sim.record["deviation_m"])
    assert np.array_equal(deviations, welded.trajectories[0].deviation_m)


def begun(place: Path, **options: object) -> tw.Simulation:
    sim = tw.Simulation(weld="short.toml", **options)  # type: ignore[arg-type]
    sim.advance(4.0)
    for k in range(20):
        sim.step([0.0, 1e-4 * k, 0.0, 0.0, 0.0, 0.0])
    return sim


@pytest.mark.parametrize("law", ["none", "seam-tracking", Integral])
def test_copies_pickles_and_states_go_on_as_the_simulation_does(law: object, place: Path) -> None:
    sim = begun(place, compensator=law)
    again = tw.Simulation(weld="short.toml", compensator=law)  # type: ignore[arg-type]
    again.restore(sim.state())
    others = [copy.deepcopy(sim), copy.copy(sim), pickle.loads(pickle.dumps(sim)), again]
    sim.advance(1.0)
    for other in others:
        assert other.time_s < sim.time_s
        other.advance(1.0)
        assert np.array_equal(other.cell_state, sim.cell_state)
        assert np.array_equal(other.readings, sim.readings, equal_nan=True)
        assert other.state() == sim.state()


# In another process, whose laws are those of this file.
GO_ON = """
import pathlib, pickle, sys
sys.path.insert(0, sys.argv[1])
sim = pickle.loads(pathlib.Path("sim.pickle").read_bytes())
sim.advance(1.0)
pathlib.Path("state").write_bytes(sim.state())
"""


@pytest.mark.parametrize("law", ["none", "seam-tracking", "elastostatic+learning", Integral])
def test_a_state_goes_on_in_another_process_bit_for_bit(law: object, place: Path) -> None:
    sim = begun(place, compensator=law)
    (place / "sim.pickle").write_bytes(pickle.dumps(sim))
    sim.advance(1.0)
    subprocess.run([sys.executable, "-c", GO_ON, str(Path(__file__).parent)], check=True)
    state = (place / "state").read_bytes()
    assert state == sim.state()
    # It holds what changes now, and not what was done: a later one is no longer.
    early = begun(place, compensator=law)
    sim.advance(1e9)
    assert len(sim.state()) == pytest.approx(len(early.state()), rel=0.05)
    sim.restore(early.state())
    assert sim.periods == early.periods and sim.record.keys() == early.record.keys()
    for name, values in early.record.items():
        assert np.array_equal(sim.record[name], values), name


class Slotted:
    """A law that keeps an array, a slot and a history, and says itself what its state is."""

    __slots__ = ("gains", "history", "__dict__")

    def __init__(self) -> None:
        self.gains = np.array([0.0, 0.02, 0.0, 0.0, 0.0, 0.0])
        self.history: list[float] = []
        self.demanded = np.zeros(6)

    def demand(self, readings: tw.Readings) -> np.ndarray:
        if np.isfinite(readings.lateral_m):
            self.history.append(readings.lateral_m)
            self.demanded = self.demanded - self.gains * np.mean(self.history[-5:])
        return self.demanded


def test_a_law_in_python_keeps_arrays_slots_and_lists(place: Path) -> None:
    sim = begun(place, compensator=Slotted)
    state = sim.state()
    sim.advance(1.0)
    expected = sim.cell_state
    sim.restore(state)
    copied = sim.copy()
    for one in (sim, copied):
        one.advance(1.0)
        assert np.array_equal(one.cell_state, expected)


def test_a_law_that_gives_no_state_is_named(place: Path) -> None:
    class Locked(Integral):
        def __init__(self) -> None:
            super().__init__()
            self.lock = threading.Lock()

    sim = tw.Simulation(weld="short.toml", compensator=Locked)
    for call in (sim.state, sim.copy):
        with pytest.raises(tw.LawError, match="the law python:locked .* state: .*pickle"):
            call()
    sim.advance(3.0)
    assert sim.time_s > 2.9


def test_a_state_of_something_else_is_refused(place: Path) -> None:
    sim = begun(place)
    for state in (
        b"",
        b"trueweld-state/2",
        b"x" * 100,
        sim.state()[:-1],
        damaged(sim.state()),
        begun(place, seed=7).state(),
        begun(place, effect="backlash:A5:half_gap_rad=1e-4").state(),
    ):
        with pytest.raises(ValueError, match="no state of this simulation"):
            sim.restore(state)


def damaged(state: bytes) -> bytes:
    return state[:-100] + bytes([state[-100] ^ 1]) + state[-99:]


def test_a_reset_begins_the_same_weld_or_one_with_other_noise(place: Path) -> None:
    sim = tw.Simulation(weld="short.toml")
    sim.advance(3.0)
    first = sim.readings
    sim.reset()
    sim.advance(3.0)
    assert np.array_equal(sim.readings, first, equal_nan=True)
    sim.reset(seed=99)
    sim.advance(3.0)
    assert not np.array_equal(sim.readings, first, equal_nan=True)


def test_wrong_corrections_are_refused(place: Path) -> None:
    sim = tw.Simulation(weld="short.toml")
    for wrong in ([0.0] * 5, [float("nan")] * 6, [np.inf] * 6, "abcdef", 3.0):
        with pytest.raises((ValueError, TypeError)):
            sim.step(wrong)  # type: ignore[arg-type]
    sim.advance(1e9)
    with pytest.raises(RuntimeError, match="over"):
        sim.step()
    with pytest.raises(ValueError, match="no law"):
        tw.Simulation(compensator="elastostatik")
    with pytest.raises(ValueError, match="controller"):
        tw.Simulation(controller="extern")
    with pytest.raises(tw.InputError):
        tw.Simulation(weld="gone.toml")


def test_a_correction_is_held_within_what_the_control_file_allows(place: Path) -> None:
    sim = tw.Simulation(weld="short.toml")
    sim.advance(3.0)
    for _ in range(200):
        sim.step([0.0, 1e6, 0.0, 0.0, 0.0, 0.0])
    lateral, _ = sim.largest_correction
    assert np.linalg.norm(sim.record["correction_m"]) <= lateral * (1 + 1e-12)


def test_a_rollout_is_the_simulations_one_by_one(place: Path) -> None:
    sim = begun(place)
    rng = np.random.default_rng(1)
    control = np.zeros((3, 40, 6))
    control[:, :, 1] = 1e-4 * rng.standard_normal((3, 40))
    before = sim.state()
    out = tw.rollout(sim, control)
    assert sim.state() == before, "the simulation itself stays"
    assert out.state.shape == (3, 40, 24) and out.sensordata.shape == (3, 40, 26) and out.deviation.shape == (3, 40, 6)
    for row in range(3):
        one = sim.copy()
        for k in range(40):
            one.step(control[row, k])
            assert np.array_equal(out.state[row, k], one.cell_state)
        assert np.array_equal(out.deviation[row, -1], one.deviation)
    # One row for all, several simulations, every tenth step, to the end of the weld.
    many = tw.rollout([sim, begun(place, seed=3)], control[0])
    assert np.array_equal(many.state[0], out.state[0]) and not np.array_equal(many.state[1], out.state[0])
    whole = tw.rollout(sim, every=10)
    left = sim.periods[1] - sim.periods[0]
    assert whole.state.shape[1] == left // 10 and list(whole.periods) == [left]
    beyond = tw.rollout(sim, nstep=left + 20, every=10)
    assert np.isnan(beyond.state[0, -1]).all() and list(beyond.periods) == [left]


def test_a_rollout_says_what_does_not_fit(place: Path) -> None:
    sim = tw.Simulation(weld="short.toml")
    for control in (np.zeros((2, 6, 5)), np.zeros(6), np.full((1, 3, 6), np.nan)):
        with pytest.raises(ValueError):
            tw.rollout(sim, control)
    with pytest.raises(ValueError):
        tw.rollout([sim, sim], np.zeros((3, 5, 6)))
    with pytest.raises(ValueError):
        tw.rollout([])


def test_many_threads_may_share_a_simulation_with_a_law_in_python(place: Path) -> None:
    sim = tw.Simulation(weld="short.toml", compensator=Integral)
    threads = [threading.Thread(target=sim.advance, args=(1.0,)) for _ in range(4)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        _ = sim.deviation
    for thread in threads:
        thread.join()
    assert sim.time_s == pytest.approx(4.0, abs=0.05)


def test_python_runs_on_while_rust_works() -> None:
    done = threading.Event()
    thread = threading.Thread(
        target=lambda: (tw.weld(weld=tw.fixtures.path("welds/coupon.toml"), compensator="none"), done.set())
    )
    thread.start()
    ticks = 0
    while not done.wait(0.005):
        ticks += 1
    thread.join()
    assert ticks > 20


@pytest.mark.skipif(os.name != "posix", reason="sends a signal to itself")
@pytest.mark.parametrize("what", ["weld", "rollout"])
def test_control_c_stops(what: str) -> None:
    sim = tw.Simulation()
    call = {"weld": tw.weld, "rollout": lambda: tw.rollout([sim] * 50, every=1000)}[what]
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        call()
    assert time.monotonic() - begun < 10
