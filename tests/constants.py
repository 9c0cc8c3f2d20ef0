#!/usr/bin/env python3
"""By how much the answers of the corpus move when a constant that decides is changed by a third.

A share of more than a half is changed by a third of what it is short of one. Changes one constant at a
time in the sources of `trueweld-diagnose`, builds, runs the same cases, and puts it back. Cases run side
by side, one thread each. Run it in a clean clone, from its root:

    python3 tests/constants.py --seed 1 --cases 40 --out out/constants.md
"""

import argparse
import json
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SOURCES = ROOT / "sim-host/diagnose/src"
# What draws, plans or describes decides nothing about what is missing.
OTHER = {"experiment", "evidence", "fleet.rs", "posterior.rs", "explanation.rs", "mountings.rs", "confuse.rs"}
CONSTANT = re.compile(r"^\s*(?:pub(?:\([a-z]+\))? )?const ([A-Z_]+): (f64|usize) = ([0-9._e-]+);", re.M)
RIGHT = {"right", "right-tie", "right-as-calibration", "right-and-more"}


def constants():
    """Name, file, type and value of every number that decides."""
    for file in sorted(SOURCES.rglob("*.rs")):
        if OTHER.isdisjoint(file.relative_to(SOURCES).parts):
            text = file.read_text().split("#[cfg(test)]")[0]
            for name, kind, value in CONSTANT.findall(text):
                yield name, file, kind, float(value.replace("_", ""))


def answers(arguments, folder):
    """Outcome of every case, by name."""
    command = ["cargo", "build", "--quiet", "--package", "trueweld-tests", "--bin", "statistics"]
    subprocess.run(command, cwd=ROOT, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    folder.mkdir(parents=True, exist_ok=True)

    def case(number):
        out = folder / f"{number}.jsonl"
        out.unlink(missing_ok=True)
        command = [target / "debug/statistics", "corpus", "--short", "--seed", str(arguments.seed)]
        command += ["--cases", str(arguments.cases), "--only", str(number)]
        command += ["--out", out, "--table", out.with_suffix(".md")]
        environment = {**os.environ, "RAYON_NUM_THREADS": "1"}
        subprocess.run(command, cwd=ROOT, check=True, env=environment, stderr=subprocess.DEVNULL)
        return [json.loads(line) for line in out.read_text().splitlines()]

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        judged = [one for all in pool.map(case, range(arguments.cases)) for one in all]
    return {one["name"]: one["outcome"] for one in judged}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, default=40)
    parser.add_argument("--only", nargs="*", help="these constants")
    parser.add_argument("--out", type=Path, required=True, help="file for the table, as Markdown")
    arguments = parser.parse_args()
    git = ["git", "status", "--porcelain", "--untracked-files=no", "sim-host"]
    if subprocess.run(git, cwd=ROOT, check=True, capture_output=True).stdout:
        sys.exit("the sources are changed: run this in a clean clone")
    chosen = [c for c in constants() if arguments.only is None or c[0] in arguments.only]
    if unknown := set(arguments.only or []) - {c[0] for c in chosen}:
        sys.exit(f"no constant that decides: {', '.join(sorted(unknown))}")
    folder = arguments.out.parent / "constants"
    before = answers(arguments, folder / "as-they-are")
    lines = ["| constant | value | right | other answers |", "|---|---|---|---|"]
    right = sum(outcome in RIGHT for outcome in before.values())
    lines.append(f"| as they are | | {right} of {len(before)} | |")
    for name, file, kind, value in chosen:
        text = file.read_text()
        for third in (-1 / 3, 1 / 3):
            other = value + third * (1 - value if kind == "f64" and 0.5 < value < 1 else value)
            number = str(max(round(other), 1)) if kind == "usize" else repr(other)
            changed = re.sub(rf"(const {name}: {kind} = )[0-9._e-]+;", rf"\g<1>{number};", text)
            if changed == text:
                continue
            try:
                file.write_text(changed)
                after = answers(arguments, folder / f"{name}-{number}")
            except subprocess.CalledProcessError:
                continue  # The length of a list, which is one with the list.
            finally:
                file.write_text(text)
            right = sum(outcome in RIGHT for outcome in after.values())
            moved = [f"{case}: {before.get(case)} → {outcome}" for case, outcome in after.items()
                     if outcome != before.get(case)]
            lines.append(f"| {name} | {value:g} → {float(number):.4g} | {right} of {len(after)} | {'; '.join(moved)} |")
            print(lines[-1], flush=True)
            arguments.out.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
