#!/usr/bin/env python3
"""By how much the answers of the corpus move when a constant that decides is changed by a third.

A share of more than a half is changed by a third of what it is short of one. Changes constants in the
sources of `trueweld-diagnose`, several together, builds, runs the same cases, and puts them back; where
answers move, halves of those constants are changed, down to one, and the cases that moved run again.
Cases run side by side, one thread each. Run it in a clean clone, from its root:

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


class Corpus:
    """The cases, and where their answers go."""

    def __init__(self, seed, cases, folder):
        self.seed, self.cases, self.folder, self.builds = seed, cases, folder, 0

    def answers(self, numbers):
        """Outcome of each of some cases, by number, with the sources as they are; `None` where they
        do not build."""
        command = ["cargo", "build", "--quiet", "--package", "trueweld-tests", "--bin", "statistics"]
        if subprocess.run(command, cwd=ROOT, stderr=subprocess.DEVNULL).returncode:
            return None
        target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
        folder = self.folder / str(self.builds)
        folder.mkdir(parents=True, exist_ok=True)
        self.builds += 1

        def outcome(number):
            out = folder / f"{number}.jsonl"
            out.unlink(missing_ok=True)
            command = [target / "debug/statistics", "corpus", "--short", "--seed", str(self.seed)]
            command += ["--cases", str(self.cases), "--only", str(number)]
            command += ["--out", out, "--table", out.with_suffix(".md")]
            environment = {**os.environ, "RAYON_NUM_THREADS": "1"}
            subprocess.run(command, cwd=ROOT, check=True, env=environment, stderr=subprocess.DEVNULL)
            return [json.loads(line)["outcome"] for line in out.read_text().splitlines()]

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            return dict(zip(numbers, pool.map(outcome, numbers)))

    def moved(self, changes, before):
        """Which constants move answers, and these: pairs of changes and of answers by case."""
        files = {file: file.read_text() for _, file, _, _ in changes}
        try:
            for name, file, kind, number in changes:
                declared = rf"(const {name}: {kind} = )[0-9._e-]+;"
                file.write_text(re.sub(declared, rf"\g<1>{number};", file.read_text()))
            after = self.answers(list(before))
        finally:
            for file, text in files.items():
                file.write_text(text)
        other = {case: before[case] for case in before if after and after[case] != before[case]}
        if after is not None and not other:
            return []
        if len(changes) == 1:
            # What does not build is the length of a list, which is one with the list.
            return [(changes, {case: (before[case], after[case]) for case in other})] if after else []
        half = len(changes) // 2
        halves = (changes[:half], changes[half:])
        parts = [one for part in halves for one in self.moved(part, other or before)]
        together = {case: (before[case], after[case]) for case in other}
        for _, cases in parts:
            together = {case: pair for case, pair in together.items() if case not in cases}
        return parts + ([(changes, together)] if together else [])


def third(value, kind, sign):
    """A number changed by a third, as it is written."""
    other = value + sign / 3 * (1 - value if kind == "f64" and 0.5 < value < 1 else value)
    return str(max(round(other), 1)) if kind == "usize" else repr(other)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, default=40)
    parser.add_argument("--together", type=int, default=8, help="constants that are changed at once")
    parser.add_argument("--only", nargs="*", help="these constants")
    parser.add_argument("--out", type=Path, required=True, help="file for the table, as Markdown")
    arguments = parser.parse_args()
    git = ["git", "status", "--porcelain", "--untracked-files=no", "sim-host"]
    if subprocess.run(git, cwd=ROOT, check=True, capture_output=True).stdout:
        sys.exit("the sources are changed: run this in a clean clone")
    chosen = [c for c in constants() if arguments.only is None or c[0] in arguments.only]
    if unknown := set(arguments.only or []) - {c[0] for c in chosen}:
        sys.exit(f"no constant that decides: {', '.join(sorted(unknown))}")
    corpus = Corpus(arguments.seed, arguments.cases, arguments.out.parent / "constants")
    before = corpus.answers(range(arguments.cases))
    if before is None:
        sys.exit("the sources do not build")
    cases = [outcome for all in before.values() for outcome in all]
    right = sum(outcome in RIGHT for outcome in cases)
    lines = [f"{len(chosen)} constants, seed {arguments.seed}: {right} of {len(cases)} right as they are.", ""]
    lines += ["| constants | changed to | answers that move |", "|---|---|---|"]
    arguments.out.write_text("\n".join(lines) + "\n")
    values = {(name, file): value for name, file, _, value in chosen}
    for sign in (-1, 1):
        changes = [(name, file, kind, third(value, kind, sign)) for name, file, kind, value in chosen]
        changes = [c for c in changes if float(c[3]) != values[c[:2]]]
        for k in range(0, len(changes), arguments.together):
            for group, answers in corpus.moved(changes[k:k + arguments.together], before):
                names = ", ".join(f"{name} ({values[name, file]:g})" for name, file, _, _ in group)
                numbers = ", ".join(f"{float(number):.4g}" for *_, number in group)
                said = "; ".join(f"{case}: {', '.join(a)} → {', '.join(b)}" for case, (a, b) in answers.items())
                lines.append(f"| {names} | {numbers} | {said} |")
                print(lines[-1], flush=True)
                arguments.out.write_text("\n".join(lines) + "\n")
            print(f"{'up' if sign > 0 else 'down'}: {min(k + arguments.together, len(changes))} of {len(changes)}", flush=True)


if __name__ == "__main__":
    main()
