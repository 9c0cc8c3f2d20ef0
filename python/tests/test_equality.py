"""A function gives the bytes that the program writes: JSON and page, of every command."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import trueweld as tw
from trueweld import _core, _plot

CAMPAIGN = "fixtures/campaigns/backlash"
MODEL = f"{CAMPAIGN}/model.toml"
STATIC = f"{CAMPAIGN}/static"
ROBOT = "fixtures/robots/kr500-mt.toml"

# Commands with a result: what is called, and the same for the command line. `{out}` is a folder that
# each of both has for itself.
SHORT: dict[tuple[str, ...], tuple[Callable[[str], tw.Result], list[str]]] = {
    ("weld",): (
        lambda out: tw.weld(weld="short.toml", effect=["backlash:A5:half_gap_rad=1e-4"], stiffness_error=0.1),
        ["--weld", "short.toml", "--effect", "backlash:A5:half_gap_rad=1e-4", "--stiffness-error", "0.1"],
    ),
    ("step",): (lambda out: tw.step(weld="short.toml", height=-2000.0), ["--weld", "short.toml", "--height", "-2000"]),
    ("compare-laws",): (
        lambda out: tw.compare_laws(weld="short.toml", laws=["none", "feed-forward"], passes=1),
        ["--weld", "short.toml", "--laws", "none,feed-forward", "--passes", "1"],
    ),
    ("certify",): (
        lambda out: tw.certify(
            compensator="feed-forward",
            weld="short.toml",
            requirements="requirements.toml",
            trials=3,
            worst=0,
            evidence=f"{out}/evidence",
        ),
        [
            "--compensator",
            "feed-forward",
            "--weld",
            "short.toml",
            "--requirements",
            "requirements.toml",
            "--trials",
            "3",
            "--worst",
            "0",
            "--evidence",
            "{out}/evidence",
        ],
    ),
    ("study", "layout"): (
        lambda out: tw.study.layout(weld="short.toml", x="1.5:1.9:0.2", z="0.5", turn="0", compensator="none"),
        ["--weld", "short.toml", "--x", "1.5:1.9:0.2", "--z", "0.5", "--turn", "0", "--compensator", "none"],
    ),
    ("study", "limits"): (
        lambda out: tw.study.limits(weld="short.toml", requirements="requirements.toml", what="force"),
        ["--weld", "short.toml", "--requirements", "requirements.toml", "--what", "force"],
    ),
    ("study", "sensitivity"): (
        lambda out: tw.study.sensitivity(weld="short.toml", requirements="uncertain.toml", rows=8),
        ["--weld", "short.toml", "--requirements", "uncertain.toml", "--rows", "8"],
    ),
    ("compare",): (lambda out: tw.compare(STATIC, model=MODEL), ["--model", MODEL, STATIC]),
    ("diagnose",): (lambda out: tw.diagnose(STATIC, model=MODEL), ["--model", MODEL, STATIC]),
    ("improve",): (
        lambda out: tw.improve(STATIC, model=MODEL, out="improved.toml"),
        ["--model", MODEL, STATIC, "--out", "improved.toml"],
    ),
    ("identify", "stiffness"): (
        lambda out: tw.identify.stiffness([STATIC], model=MODEL),
        ["--model", MODEL, STATIC],
    ),
    ("identify", "damping"): (
        lambda out: tw.identify.damping(f"{CAMPAIGN}/ring-14", model=MODEL),
        ["--model", MODEL, f"{CAMPAIGN}/ring-14"],
    ),
    ("register",): (lambda out: tw.register("fixtures/campaigns/tracker-moved"), ["fixtures/campaigns/tracker-moved"]),
    ("record",): (
        lambda out: tw.record("protocol.toml", out="recorded", seed=5),
        ["protocol.toml", "--out", "recorded", "--seed", "5"],
    ),
    ("plan",): (lambda out: tw.plan("protocol.toml"), ["protocol.toml"]),
    ("check",): (lambda out: tw.check([ROBOT, "short.toml"]), [ROBOT, "short.toml"]),
    ("import-log",): (
        lambda out: tw.import_log(["fixtures/raw/krc.csv", "fixtures/raw/tracker.txt"], robot=ROBOT, out="imported"),
        ["fixtures/raw/krc.csv", "fixtures/raw/tracker.txt", "--robot", ROBOT, "--out", "imported"],
    ),
}
LONG: dict[tuple[str, ...], tuple[Callable[[str], tw.Result], list[str]]] = {
    ("identify", "process"): (
        lambda out: tw.identify.process("fixtures/campaigns/nothing-missing"),
        ["fixtures/campaigns/nothing-missing"],
    ),
    ("study", "paper"): (lambda out: tw.study.paper(), []),
    ("tune",): (
        lambda out: tw.tune(weld="short.toml", requirements="margins.toml", out="control.toml"),
        ["--weld", "short.toml", "--requirements", "margins.toml", "--out", "control.toml"],
    ),
}

# Commands that print or write files alone.
TEXTS = {("new-law",), ("init",), ("import-urdf",), ("export-core",), ("export-fmu",), ("schema",)}

# Commands that speak with a robot for as long as it runs: the program alone has them.
ROBOTS = {("rsi-robot",), ("rsi-compensate",)}

# Commands whose files another one makes: the tests of the program have them.
OF_RECORDED_RUNS = {("replay",)}

REQUIREMENTS = """schema = "requirements/1"
failure_probability = 0.5
confidence = 0.8
[limits]
lateral_max_m = 0.0024
[uncertainty]
stiffness = {stiffness}
process = {process}
ripple = 0.0
crosstalk = 0.0
delay_periods = [1.0, 1.0]
"""


@pytest.fixture
def files(place: Path) -> Path:
    (place / "requirements.toml").write_text(REQUIREMENTS.format(stiffness=0.3, process=0.3))
    (place / "uncertain.toml").write_text(REQUIREMENTS.format(stiffness=0.3, process=0.0))
    (place / "margins.toml").write_text(
        REQUIREMENTS.format(stiffness=0.3, process=0.3) + "[margins]\nplaces = 2\ngain_margin = 1.01\n"
    )
    protocol = (place / "fixtures/protocols/unknown-stiffness.toml").read_text()
    (place / "protocol.toml").write_text(protocol.replace('"../', '"fixtures/'))
    return place


def without_clock(text: str) -> str:
    """The text without the time that a run took on this machine, the one thing that differs."""
    return re.sub(r'"wall_s": [0-9.e-]+', '"wall_s": 0', text)


def has_picture(result: tw.Result) -> None:
    """Draws the result's picture, where it has one."""
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("agg")
    name = result["schema"].split("/")[0]
    if name in _plot._WITHOUT:
        with pytest.raises(NotImplementedError, match="no picture"):
            result.plot()
        return
    figure = result.plot()
    figure.canvas.draw()
    assert figure.axes[0].has_data() and figure.axes[0].get_title(loc="left")


def test_planned_loads_have_a_picture(files: Path) -> None:
    has_picture(tw.identify.stiffness([], model=MODEL, plan="planned.toml"))


def check(command: tuple[str, ...], files: Path, program: Any) -> None:
    cases = SHORT | LONG
    call, flags = cases[command]
    both = {}
    for who in ("python", "program"):
        for made in ("recorded", "imported"):
            if (files / made).exists():
                (files / made).rename(files / f"{made}-by-python")
        out = files / who
        out.mkdir()
        if who == "python":
            result = call(who)
            has_picture(result)
            both[who] = (result.to_json(), result.to_html() if result._forms["page"] else None, result.status)
        else:
            words = [flag.replace("{out}", who) for flag in flags]
            page = [] if both["python"][1] is None or command == ("import-log",) else ["--html", "program/page.html"]
            quiet = [] if command in {("check",), ("import-log",)} else ["-q"]
            ended = program(*command, *words, "--json", "program/result.json", *page, *quiet)
            assert ended.returncode in (0, 1), ended.stderr
            read = (out / "result.json").read_text(encoding="utf-8")
            shown = (out / "page.html").read_text(encoding="utf-8") if page else None
            both[who] = (read, shown, ended.returncode)
    (of_python, page, status), (of_program, shown, code) = both["python"], both["program"]
    assert without_clock(of_python) == without_clock(of_program)
    assert page == shown or command == ("import-log",), "of a log there is no page in the program"
    assert status == code


@pytest.mark.parametrize("command", SHORT, ids="-".join)
def test_a_function_gives_the_bytes_of_the_program(command: tuple[str, ...], files: Path, program: Any) -> None:
    check(command, files, program)


@pytest.mark.long
@pytest.mark.parametrize("command", LONG, ids="-".join)
def test_a_function_that_takes_minutes_gives_the_bytes_of_the_program(
    command: tuple[str, ...], files: Path, program: Any
) -> None:
    check(command, files, program)


def test_every_command_is_compared() -> None:
    commands = {tuple(of["names"]) for of in _core.describe_commands()}
    assert commands == {*SHORT, *LONG, *TEXTS, *ROBOTS, *OF_RECORDED_RUNS}


def test_commands_without_a_result_write_the_files_of_the_program(files: Path, program: Any) -> None:
    assert tw.schema("weld-result") == program("schema", "weld-result").stdout
    assert tw.schema() == program("schema").stdout
    assert tw.import_urdf("fixtures/robots/arm6.urdf") == program("import-urdf", "fixtures/robots/arm6.urdf").stdout
    for who, call in (
        (
            "python",
            lambda out: (
                tw.init(f"{out}-cell"),
                tw.export_core(compensator="none", out=f"{out}-core"),
                tw.new_law("mine", out=f"{out}-law"),
            ),
        ),
        (
            "program",
            lambda out: (
                program("init", f"{out}-cell"),
                program("export-core", "--compensator", "none", "--out", f"{out}-core"),
                program("new-law", "mine", "--out", f"{out}-law"),
            ),
        ),
    ):
        call(who)
    for folder in ("cell", "core", "law"):
        written = {
            path.relative_to(files / f"python-{folder}"): path.read_bytes()
            for path in (files / f"python-{folder}").rglob("*")
            if path.is_file()
        }
        assert written, folder
        for path, text in written.items():
            assert (files / f"program-{folder}" / path).read_bytes().replace(b"program-", b"python-") == text, path


def test_the_program_answers_as_one(program: Any) -> None:
    assert program("--version").stdout.startswith("trueweld ")
    assert program("weld", "--passes", "0").returncode == 2
    missing = program("weld", "--weld", "gone.toml")
    assert missing.returncode == 1 and "gone.toml" in missing.stderr
