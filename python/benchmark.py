"""Measures what the package costs: the table of overheads in docs/python.md.

    python -P python/benchmark.py [WELDS]

Times are of the processor, of all threads and of programs that are started, so that they do not
depend on what else the machine does. The welds on all cores are timed by the clock, in turn with the
program's: compare them within one run. WELDS: how many short welds are rolled out (1000).
"""

from __future__ import annotations

import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import trueweld as tw

REPEATS = 7

# Draws that change next to nothing: the program then makes the same welds again and again.
REQUIREMENTS = """schema = "requirements/1"
failure_probability = 0.1
confidence = 0.9
[limits]
lateral_max_m = 0.0024
[uncertainty]
stiffness = 0.1
process = 0.0
ripple = 0.0
crosstalk = 0.0
delay_periods = [1.0, 1.0]
"""


def processor_s() -> float:
    """Time of the processor so far, s: of this process and of those that it started and that ended."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(of.ru_utime + of.ru_stime for of in used)


def seconds(work: Callable[[], object], repeats: int = REPEATS, inner: int = 1) -> float:
    """Least time of the processor for some work, done `inner` times in a row."""
    times = []
    for _ in range(repeats):
        begun = processor_s()
        for _ in range(inner):
            work()
        times.append((processor_s() - begun) / inner)
    return min(times)


def in_turn(works: dict[str, Callable[[], object]], repeats: int = 2) -> dict[str, float]:
    """Least time by the clock for each work, done in turn: what else the machine does meets all."""
    times: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(repeats):
        for name, work in works.items():
            begun = time.perf_counter()
            work()
            times[name].append(time.perf_counter() - begun)
    return {name: min(each) for name, each in times.items()}


def short_weld(folder: Path) -> Path:
    """The first published weld, 60 mm of it."""
    text = tw.fixtures.path("welds/published-vertical.toml").read_text(encoding="utf-8")
    text = re.sub(r"(?m)^start_m = .*$", "start_m = [1.700, -1.000, 0.500]", text)
    text = re.sub(r"(?m)^end_m = .*$", "end_m = [1.700, -0.940, 0.500]", text)
    path = folder / "short.toml"
    path.write_text(text, encoding="utf-8")
    return path


def show(what: str, value: float, unit: str) -> None:
    """Prints a row of the table."""
    print(f"{what:60} {value:10.3g} {unit}", flush=True)


def main() -> None:
    """Measures, and prints the table."""
    welds = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    folder = Path(tempfile.mkdtemp())
    weld = short_weld(folder)

    def python(code: str) -> float:
        return seconds(lambda: subprocess.run([sys.executable, "-c", code], check=True))

    bare, with_numpy = python("pass"), python("import numpy")
    show("import, with NumPy's", 1e3 * (python("import trueweld") - bare), "ms")
    show("of it NumPy's", 1e3 * (with_numpy - bare), "ms")

    show("a call (check of one file)", 1e3 * seconds(lambda: tw.check(weld), inner=50), "ms")
    program = shutil.which("trueweld", path=str(Path(sys.executable).parent))
    assert program
    check = [program, "check", str(weld)]
    show("the same by the program", 1e3 * seconds(lambda: subprocess.run(check, capture_output=True, check=True)), "ms")

    sim = tw.Simulation(weld=weld)
    periods = sim.periods[1]

    def stepped() -> None:
        sim.reset()
        while not sim.done:
            sim.step()

    def advanced() -> None:
        sim.reset()
        sim.advance(1e9)

    each, whole = seconds(stepped, 3), seconds(advanced, 3)
    show("a step of 12 ms, simulated", 1e6 * whole / periods, "µs")
    show("beside it, of a call of step() in Python", 1e6 * (each - whole) / periods, "µs")
    show("a copy of a simulation", 1e6 * seconds(sim.copy, inner=1000), "µs")

    state = sim.state()
    show("a state, taken", 1e6 * seconds(sim.state, inner=1000), "µs")
    show("a state, gone to", 1e6 * seconds(lambda: sim.restore(state), inner=1000), "µs")

    def nothing(readings: tw.Readings) -> list[float]:
        return [0.0] * 6

    def feed_forward(readings: tw.Readings) -> np.ndarray:
        return readings.feed_forward()

    class Followed:
        outer_integral = 0.4
        demand = staticmethod(feed_forward)

    options = {"weld": weld, "progress": False}
    rust = seconds(lambda: tw.weld(compensator="none", **options), 5)
    own = seconds(lambda: tw.weld(compensator=nothing, **options), 5)
    show("a period of a law in Python that returns six zeros", 1e6 * (own - rust) / periods, "µs")
    rust = seconds(lambda: tw.weld(compensator="feed-forward", **options), 5)
    own = seconds(lambda: tw.weld(compensator=Followed(), **options), 5)
    show("a period of feed-forward in Python, beside that in Rust", 1e6 * (own - rust) / periods, "µs")

    simulations = [tw.Simulation(weld=weld, compensator="feed-forward", seed=seed) for seed in range(welds)]
    (folder / "requirements.toml").write_text(REQUIREMENTS, encoding="utf-8")
    certify = [
        program,
        "certify",
        "--compensator",
        "feed-forward",
        "--weld",
        str(weld),
        "--trials",
        str(welds),
        "--worst",
        "0",
        "--requirements",
        str(folder / "requirements.toml"),
        "--evidence",
        str(folder / "out"),
        "-q",
    ]

    def certified() -> None:
        # Runs that are kept are not made again.
        shutil.rmtree(folder / "out", ignore_errors=True)
        subprocess.run(certify, capture_output=True, check=False)

    works = {
        f"a rollout of {welds} welds of 60 mm, by the clock": lambda: tw.rollout(simulations, every=100),
        "as many by the program (certify), by the clock": certified,
    }
    print(f"on {os.cpu_count()} cores, with a load of {os.getloadavg()[0]:.1f} before")
    for name, clocked in in_turn(works).items():
        show(name, clocked, "s")


if __name__ == "__main__":
    main()
