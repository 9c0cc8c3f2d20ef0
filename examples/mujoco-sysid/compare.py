"""Identifies stiffness K and damping D of an arm's joints by trueweld and by mujoco.sysid, and prints Markdown tables.

    pip install 'mujoco[sysid]==4.0.0' scipy
    python examples/mujoco-sysid/compare.py --trueweld target/release/trueweld

Nothing hidden, from three starts; recordings with other noise, simulated here, to count intervals; a hidden backlash.
Every run is one process on one thread. The folder of --out keeps its result; a run that is there is not repeated.
"""

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

import cell
import mujoco
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import savgol_filter

STARTS = (1, 2, 3)
WAYS = ("ten", "coarse", "twelve", "skeleton")
SEEN = [n for n in range(12) if n % 6 < 5]  # K and D of A1 to A5; the tracked point lies on the axis of A6
ONE_THREAD = {name: "1" for name in ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")}


def record(campaign: Path, seed: int, encoder_noise_rad: float, out: Path) -> Path:
    """Simulates the ring-downs of a campaign anew: the same motion of the motors, other noise."""
    rng = np.random.default_rng(1000 + seed)
    robot = cell.read_robot(campaign)
    folder = out / f"recording-{encoder_noise_rad:g}-{seed}"
    model = cell.arm(robot, 1e-4).compile()
    data = mujoco.MjData(model)
    for name in cell.RING_DOWNS:
        times, encoders, _ = cell.read_log(campaign / name)
        motors = savgol_filter(encoders, 9, 3, axis=0)
        steps, control = cell.controls(robot, times, motors, model.opt.timestep)
        rate = cell.rate_at_start(times, motors)
        angles = cell.on_its_springs(model, control[0], rate)
        mujoco.mj_resetData(model, data)
        data.qpos, data.qvel = angles, rate
        path = np.empty((len(steps), 3))
        for n, one in enumerate(control):
            data.ctrl = one
            mujoco.mj_step(model, data)
            path[n] = data.sensordata  # of the state before the step
        tracker = CubicSpline(steps, path)(times) + rng.normal(0, cell.TRACKER_NOISE_M, (len(times), 3))
        rows = np.column_stack([times, motors + rng.normal(0, encoder_noise_rad, motors.shape), tracker])
        (folder / name).mkdir(parents=True, exist_ok=True)
        (folder / name / "log.toml").write_text((campaign / name / "log.toml").read_text())
        head = ",".join(["t_s", *(f"qe{n}_rad" for n in range(1, 7)), "px_m", "py_m", "pz_m"])
        np.savetxt(folder / name / "samples.csv", rows, "%.8f", ",", header=head, comments="")
    for name in ("robot.toml", "process.toml", "model.toml"):
        (folder / name).write_text((campaign / name).read_text())
    return folder


def timed(command: list) -> tuple[float, str]:
    """CPU seconds, user and system, of a command, and what it wrote."""
    before = os.times()
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, env=os.environ | ONE_THREAD)
    after = os.times()
    if done.returncode:
        sys.exit(f"{command}\n{done.stdout}{done.stderr}")
    spent = [t.children_user + t.children_system for t in (before, after)]
    return spent[1] - spent[0], done.stdout


def run_mujoco(campaign: Path, model: Path, way: str) -> dict:
    cpu, text = timed([sys.executable, Path(__file__).with_name("fit.py"), campaign, model, way])
    found = json.loads(text)
    return dict(name=f"mujoco.sysid, {way}", cpu_s=cpu, told={f"mujoco.sysid, {way}": found.pop("told")}, **found)


def run_trueweld(program: str, campaign: Path, model: Path, tool: str, base: Path) -> dict:
    command = [program, *tool.split(), "-q", "--model", model, "--json", f"{base}.full.json"]
    command += ["--out", f"{base}.toml"] if tool == "improve" else []
    cpu, text = timed(command + [campaign / name for name in cell.RING_DOWNS])
    found = json.loads(Path(f"{base}.full.json").read_text())
    given = cell.stiffness_and_damping(cell.read_robot(model.parent))
    name, told = f"`{tool}`, {model.stem}", {}
    if tool == "identify damping":
        numbers = [(p["name"], p["at"], p) for p in found["parameters"] if p["identifiable"]]
        told[name] = table(numbers, np.zeros(12), np.ones(12))
        told[name][0, 6:] = np.where(np.isnan(told[name][0, 6:]), given[6:], told[name][0, 6:])
        score = [found["score_before"], found["score"]]
    elif tool == "improve":
        last = found["steps"][-1]
        numbers = [(e["effect"], e["at"], e["parameters"].get("relative")) for e in last["calibration"]]
        told[f"{name}, model"] = table(numbers, given, given)
        kept = np.isnan(told[f"{name}, model"][0])  # by the model that it writes
        told[f"{name}, model"][0, kept] = given[kept]
        numbers = [(p["effect"], p["at"], p) for p in found["posterior"]]
        told[f"{name}, posterior"] = table(numbers, given, given)
        score = [found["steps"][0]["score"], last["score"]]
    else:
        score = [found["score_before"], found["score_after"]]
    told = {column: x.tolist() for column, x in told.items()}
    return dict(name=name, cpu_s=cpu, told=told, score=score, says=text.partition("\nModel ")[0])


def table(numbers: Iterable[tuple[str, str, dict]], offset: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Value, low and high of the twelve numbers; NaN where none is told."""
    told = np.full((3, 12), np.nan)
    for name, at, number in numbers:
        if name.startswith(("stiffness-error", "damping")):
            n = cell.JOINTS.index(at) + 6 * name.startswith("damping")
            told[:, n] = offset[n] + scale[n] * np.array([number[key] for key in ("value", "low", "high")])
    return told


def run(given: argparse.Namespace, campaign: Path, start: int, tools: dict[str, tuple[str, ...]]) -> list[dict]:
    """One run for each tool and state of the calibrations, from its file if it was made before."""
    found = []
    for tool, calibrations in tools.items():
        for state in calibrations:
            base = given.out / f"{campaign.name}-{start}-{state}-{tool.replace(' ', '-')}"
            kept = Path(f"{base}.json")
            if not kept.exists():
                model = cell.write_start(campaign, start, given.out) / f"{state}.toml"
                if tool in WAYS:
                    result = run_mujoco(campaign, model, tool)
                else:
                    result = run_trueweld(given.trueweld, campaign, model, tool, base)
                kept.write_text(json.dumps(result))
                print(f"{base.name}: {result['cpu_s']:.1f} s of CPU", file=sys.stderr)
            found.append(json.loads(kept.read_text()))
    return found


def columns(runs: list[dict], truth: np.ndarray) -> dict[str, np.ndarray]:
    """Of each column: runs × (value, low, high) × 12, in % off the truth."""
    names = dict.fromkeys(name for run in runs for name in run["told"])
    return {
        name: 100 * (np.array([run["told"][name] for run in runs if name in run["told"]], float) / truth - 1)
        for name in names
    }


def print_table(head: list[str], rows: Iterable[list[str]]) -> None:
    for row in (head, ["---"] * len(head), *rows):
        print("| " + " | ".join(row) + " |")
    print()


def number(x: float) -> str:
    places = 2 if abs(x) < 1 else 1 if abs(x) < 10 else 0
    return f"{x:.{places}f}".replace("-", "−")


def print_times(runs: list[dict]) -> None:
    rows = []
    for name in dict.fromkeys(run["name"] for run in runs):
        of = [run for run in runs if run["name"] == name]
        spent = sorted(run["cpu_s"] for run in of)
        score = " → ".join(f"{x:.4g}" for x in of[0]["score"] or ()) or "–"
        iterations = ", ".join("{} of {}".format(*r["iterations"]) for r in of if "iterations" in r) or "–"
        bounds = f" ({spent[0]:.1f}–{spent[-1]:.1f})" if len(spent) > 1 else ""
        rows.append([name, f"{np.median(spent):.1f}{bounds}", score, iterations])
    print_table(["", "CPU time, s", "score", "iterations to within 0.1 % of the last cost"], rows)


def print_errors(told: dict[str, np.ndarray]) -> None:
    """Error and half-width of the 95 % interval, from the first run; bold where the interval misses the truth."""
    for kind, part in (("K", range(6)), ("D", range(6, 12))):
        rows = []
        for name, runs in told.items():
            cells = []
            for value, low, high in runs[0].T[part]:
                text = f"{number(value)} ± {number((high - low) / 2)}"
                cells.append("–" if np.isnan(low) else text if low <= 0 <= high else f"**{text}**")
            if set(cells) != {"–"}:
                rows.append([name, *cells])
        print_table([f"{kind}, %", *cell.JOINTS], rows)


def print_starts(told: dict[str, np.ndarray]) -> None:
    """How far values from several starts are apart, and what is told from some starts only."""
    rows = []
    for name, runs in told.items():
        value, low, high = runs[:, :, SEEN].transpose(1, 0, 2)
        stated = ~np.isnan(low)
        apart = np.where(stated.all(axis=0), 2 * np.ptp(value, axis=0) / (high - low).mean(axis=0), 0)
        worst = int(np.argmax(apart))
        values = ", ".join(map(number, value[:, worst]))
        some = ", ".join(cell.PARAMETERS[SEEN[n]] for n in range(10) if 0 < stated[:, n].sum() < len(runs))
        kept = np.nanmax(np.abs(np.where(stated, 0, value)))
        far = f"{cell.PARAMETERS[SEEN[worst]]}: {values}"
        rows.append([name, far, number(apart[worst]), some or "–", number(kept) if kept else "–"])
    head = ["farthest apart, %", "in half-widths", "told from some starts only", "kept as given, up to % off"]
    print_table(["", *head], rows)


def print_intervals(told: dict[str, np.ndarray]) -> None:
    """How many intervals hold the truth; errors and half-widths as root mean squares."""
    rows = []
    for name, runs in told.items():
        row = [name]
        for kind in "KD":
            value, low, high = runs[:, :, [n for n in SEEN if cell.PARAMETERS[n][0] == kind]].transpose(1, 0, 2)
            stated = ~np.isnan(low)
            row.append(f"{((low <= 0) & (high >= 0)).sum()} of {stated.sum()}" if stated.any() else "–")
            for x in (value, (high - low) / 2):
                by_joint = [c[s] for c, s in zip(x.T, stated.T, strict=True)]
                row.append(" ".join(number(np.sqrt(np.mean(c**2))) if len(c) else "–" for c in by_joint))
        rows.append(row)
    print_table(["", *(f"{kind} {what}" for kind in "KD" for what in ("held", "error, %", "half-width, %"))], rows)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--trueweld", default="trueweld", help="the program")
    options.add_argument("--out", type=Path, default=Path("out/mujoco-sysid"), help="folder for what is written")
    options.add_argument("--recordings", type=int, default=6, help="how many to simulate for counting intervals")
    options.add_argument("--encoder-noise", type=float, default=2e-6, help="of these, in rad")
    given = options.parse_args()
    clear, backlash = cell.CAMPAIGNS / "nothing-missing", cell.CAMPAIGNS / "backlash"
    truth = cell.stiffness_and_damping(cell.read_robot(clear))
    both = ("free", "known")
    trueweld = {"improve": both, "identify damping": both}

    print("Nothing hidden. Errors are from start 1.\n")
    found = [r for start in STARTS for r in run(given, clear, start, {way: both[:1] for way in WAYS} | trueweld)]
    print_times(found)
    print_errors(columns(found, truth))
    print_starts(columns(found, truth))

    noise = f"encoder noise {1e6 * given.encoder_noise:g} µrad"
    print(f"{given.recordings} recordings simulated anew, {noise}, from start 1: A1 to A5.\n")
    found = []
    for seed in range(1, given.recordings + 1):
        found += run(given, record(clear, seed, given.encoder_noise, given.out), 1, {"ten": both[:1]} | trueweld)
    print_intervals(columns(found, truth))

    print("Backlash hidden at A5, from start 1.\n")
    found = run(given, backlash, 1, {"ten": both[:1], "twelve": both[:1], "diagnose": both, "improve": both})
    print_times(found)
    print_errors(columns(found, truth))
    for one in found:
        if "says" in one:
            print(f"{one['name']}:\n\n{one['says']}\n")


if __name__ == "__main__":
    main()
