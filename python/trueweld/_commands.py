"""The commands of the program."""

# Written by python/generate.py: do not edit.

from __future__ import annotations

from collections.abc import Sequence

from . import _run
from ._law import LawLike
from ._paths import StrPath
from ._results import (
    CertifyResult,
    CheckResult,
    CompareLawsResult,
    CompareResult,
    DiagnoseResult,
    ImportLogResult,
    ImproveResult,
    PlanResult,
    RecordResult,
    RegisterResult,
    ReplayResult,
    StepResult,
    TuneResult,
    WeldResult,
)
from ._run import Progress

__all__ = [
    "certify",
    "check",
    "compare",
    "compare_laws",
    "diagnose",
    "export_core",
    "export_fmu",
    "import_log",
    "import_urdf",
    "improve",
    "init",
    "new_law",
    "plan",
    "record",
    "register",
    "replay",
    "schema",
    "step",
    "tune",
    "weld",
]


def weld(
    *,
    weld: StrPath | None = None,
    robot: StrPath | None = None,
    model: StrPath | None = None,
    informed: bool = False,
    process: StrPath | None = None,
    control: StrPath | None = None,
    sensors: StrPath | None = None,
    effect: str | Sequence[str] | None = None,
    stiffness_error: float | None = None,
    spindle_rpm: float | None = None,
    period: float | None = None,
    seed: int | None = None,
    controller: str | None = None,
    compensator: LawLike | None = None,
    from_: StrPath | None = None,
    recorded_law: str | None = None,
    recorded_control: StrPath | None = None,
    passes: int | None = None,
    certificate: StrPath | None = None,
    exaggeration: float | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    rrd: StrPath | None = None,
    law_file: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> WeldResult:
    """Simulate a weld and show how far the tool leaves its line.

    As the command ``trueweld weld``.

    :param weld: Weld file (default: the first published sequence).
    :param robot: Robot file (default: KR 500 MT with FSW end effector).
    :param model: Model file: robot, process and effects of the real cell, instead of ``robot`` and
        ``process``.
    :param informed: The controller knows the model file's effects as well: other numbers of its
        robot, such as stiffness and geometry; refused where there are others.
    :param process: Process file (default: lap weld, stringer on 2024-T3 skin).
    :param control: Gains and limits of the controllers (default: tuned for the KR 500 MT).
    :param sensors: Sensor file (default: encoders and force sensor of the KR 500 MT cell).
    :param effect: Physical effect of the real robot that the controller does not know; may be given
        several times.
    :param stiffness_error: Relative error of the joint stiffness that the controller believes in,
        such as 0.1 (default: 0; of compare-laws: 0.2).
    :param spindle_rpm: Speed of the spindle in turns a minute, in the sense of the process file's
        (default: the process file's speed).
    :param period: Control period in seconds (default: the control file's).
    :param seed: Seed of the sensors' noise (default: the sensor file's).
    :param controller: Hybrid force/position controller (default: external).
    :param compensator: Compensation law, or several with + between them; several runs with comma
        between their laws (default: a run without and a run with elastostatic).
    :param from_: Folder of the log of a weld, which is made again: its robot, seam and process, and
        the force on the tool that the model does not explain.
    :param recorded_law: Compensation law that the log was recorded under: its replay is judged by
        the record (default: none).
    :param recorded_control: Control file that the log was recorded under (default: the one that is
        part of the program).
    :param passes: Welds of the same seam one after another, the law kept from one to the next; the
        last one is reported (default: 1).
    :param certificate: Certificate (certify.json) that this weld is made under: refused where it is
        of another cell, law or weld, does not pass, or this is not the weld that was asked for.
    :param exaggeration: Factor by which the recording exaggerates deviations (default: 50).
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param rrd: Write a Rerun recording (open with: rerun FILE).
    :param law_file: File that a law in Python is in: its digest enters the result, which says so
        where none is given.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: WeldResult = _run.call(('weld',), locals())
    return result


def step(
    *,
    weld: StrPath | None = None,
    robot: StrPath | None = None,
    model: StrPath | None = None,
    informed: bool = False,
    process: StrPath | None = None,
    control: StrPath | None = None,
    sensors: StrPath | None = None,
    effect: str | Sequence[str] | None = None,
    stiffness_error: float | None = None,
    spindle_rpm: float | None = None,
    period: float | None = None,
    seed: int | None = None,
    height: float | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    rrd: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> StepResult:
    """Simulate a step of the force set-point with all three controllers.

    As the command ``trueweld step``.

    :param weld: Weld file (default: the first published sequence).
    :param robot: Robot file (default: KR 500 MT with FSW end effector).
    :param model: Model file: robot, process and effects of the real cell, instead of ``robot`` and
        ``process``.
    :param informed: The controller knows the model file's effects as well: other numbers of its
        robot, such as stiffness and geometry; refused where there are others.
    :param process: Process file (default: lap weld, stringer on 2024-T3 skin).
    :param control: Gains and limits of the controllers (default: tuned for the KR 500 MT).
    :param sensors: Sensor file (default: encoders and force sensor of the KR 500 MT cell).
    :param effect: Physical effect of the real robot that the controller does not know; may be given
        several times.
    :param stiffness_error: Relative error of the joint stiffness that the controller believes in,
        such as 0.1 (default: 0; of compare-laws: 0.2).
    :param spindle_rpm: Speed of the spindle in turns a minute, in the sense of the process file's
        (default: the process file's speed).
    :param period: Control period in seconds (default: the control file's).
    :param seed: Seed of the sensors' noise (default: the sensor file's).
    :param height: Height of the step in newtons (default: 11000).
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param rrd: Write a Rerun recording (open with: rerun FILE).
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: StepResult = _run.call(('step',), locals())
    return result


def compare_laws(
    *,
    weld: StrPath | None = None,
    robot: StrPath | None = None,
    model: StrPath | None = None,
    informed: bool = False,
    process: StrPath | None = None,
    control: StrPath | None = None,
    sensors: StrPath | None = None,
    effect: str | Sequence[str] | None = None,
    stiffness_error: float | None = None,
    spindle_rpm: float | None = None,
    period: float | None = None,
    seed: int | None = None,
    laws: Sequence[LawLike] | None = None,
    controller: str | None = None,
    passes: int | None = None,
    requirements: StrPath | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    law_file: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> CompareLawsResult:
    """Show what every compensation law makes of a wrong stiffness, noise, delay and a lost sensor.

    As the command ``trueweld compare-laws``.

    :param weld: Weld file (default: the first published sequence).
    :param robot: Robot file (default: KR 500 MT with FSW end effector).
    :param model: Model file: robot, process and effects of the real cell, instead of ``robot`` and
        ``process``.
    :param informed: The controller knows the model file's effects as well: other numbers of its
        robot, such as stiffness and geometry; refused where there are others.
    :param process: Process file (default: lap weld, stringer on 2024-T3 skin).
    :param control: Gains and limits of the controllers (default: tuned for the KR 500 MT).
    :param sensors: Sensor file (default: encoders and force sensor of the KR 500 MT cell).
    :param effect: Physical effect of the real robot that the controller does not know; may be given
        several times.
    :param stiffness_error: Relative error of the joint stiffness that the controller believes in,
        such as 0.1 (default: 0; of compare-laws: 0.2).
    :param spindle_rpm: Speed of the spindle in turns a minute, in the sense of the process file's
        (default: the process file's speed).
    :param period: Control period in seconds (default: the control file's).
    :param seed: Seed of the sensors' noise (default: the sensor file's).
    :param laws: Compensation laws, comma between them (default: all, without combinations).
    :param controller: Hybrid force/position controller (default: external).
    :param passes: Welds of the seam for laws that learn from one to the next; the last one counts
        (default: 2).
    :param requirements: Requirements, whose lateral limit is drawn (default: those of the lap
        weld).
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param law_file: File that a law in Python is in: its digest enters the result, which says so
        where none is given.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: CompareLawsResult = _run.call(('compare-laws',), locals(), joined=('laws',))
    return result


def certify(
    *,
    compensator: LawLike,
    requirements: StrPath | None = None,
    weld: StrPath | Sequence[StrPath] | None = None,
    trials: int | None = None,
    failure_probability: float | None = None,
    worst: int | None = None,
    passes: int | None = None,
    draws: int | None = None,
    controller: str | None = None,
    robot: StrPath | None = None,
    model: StrPath | None = None,
    informed: bool = False,
    process: StrPath | None = None,
    control: StrPath | None = None,
    sensors: StrPath | None = None,
    effect: str | Sequence[str] | None = None,
    stiffness_error: float | None = None,
    spindle_rpm: float | None = None,
    period: float | None = None,
    seed: int | None = None,
    evidence: StrPath | None = None,
    compare_assumed: bool = False,
    shard: str | None = None,
    merge: StrPath | Sequence[StrPath] | None = None,
    verify: bool = False,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    law_file: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> CertifyResult:
    """Prove by many welds of uncertain cells that a compensation law meets its requirements.

    As the command ``trueweld certify``.

    :param compensator: Compensation law, or several with + between them.
    :param requirements: Requirements (default: those of the lap weld).
    :param weld: Weld file; may be given several times (default: the first published sequence).
    :param trials: Trials of each weld (default: 100).
    :param failure_probability: Show that a weld beyond any limit is rarer than P, by subset
        simulation: begun with the trials, 100 at least, and with as many runs a level.
    :param worst: Runs of the search for the worst cell, of each weld (default: 60).
    :param passes: Welds of one seam in a trial, the law kept; the last one counts (default: 1).
    :param draws: Seed of the draws (default: follows from files and options).
    :param controller: Hybrid force/position controller (default: external).
    :param robot: Robot file (default: KR 500 MT with FSW end effector).
    :param model: Model file: robot, process and effects of the real cell, instead of ``robot`` and
        ``process``.
    :param informed: The controller knows the model file's effects as well: other numbers of its
        robot, such as stiffness and geometry; refused where there are others.
    :param process: Process file (default: lap weld, stringer on 2024-T3 skin).
    :param control: Gains and limits of the controllers (default: tuned for the KR 500 MT).
    :param sensors: Sensor file (default: encoders and force sensor of the KR 500 MT cell).
    :param effect: Physical effect of the real robot that the controller does not know; may be given
        several times.
    :param stiffness_error: Relative error of the joint stiffness that the controller believes in,
        such as 0.1 (default: 0; of compare-laws: 0.2).
    :param spindle_rpm: Speed of the spindle in turns a minute, in the sense of the process file's
        (default: the process file's speed).
    :param period: Control period in seconds (default: the control file's).
    :param seed: Seed of the sensors' noise (default: the sensor file's).
    :param evidence: Evidence folder (default: out/certify).
    :param compare_assumed: Make the trials with what the requirements assume of measured numbers as
        well, to show what the measurement brought.
    :param shard: Make part I of N of the runs, in an evidence folder of its own; no certificate
        yet.
    :param merge: Put shards together that were made with the same options, and do what is left.
    :param verify: Make every run that is kept again, not only one in twenty: each must come out as
        it was kept.
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param law_file: File that a law in Python is in: its digest enters the result, which says so
        where none is given.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: CertifyResult = _run.call(('certify',), locals())
    return result


def tune(
    *,
    weld: StrPath | None = None,
    requirements: StrPath | None = None,
    compensator: LawLike | None = None,
    settle: float | None = None,
    overshoot: float | None = None,
    height: float | None = None,
    robot: StrPath | None = None,
    model: StrPath | None = None,
    informed: bool = False,
    process: StrPath | None = None,
    control: StrPath | None = None,
    sensors: StrPath | None = None,
    effect: str | Sequence[str] | None = None,
    stiffness_error: float | None = None,
    spindle_rpm: float | None = None,
    period: float | None = None,
    seed: int | None = None,
    out: StrPath | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    law_file: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> TuneResult:
    """Find gains for a robot from its model, and confirm them by a step and a weld.

    As the command ``trueweld tune``.

    :param weld: Weld file (default: the first published sequence).
    :param requirements: Requirements file, for its margins (default: those of the lap weld).
    :param compensator: Law that is to be confirmed beside the controllers; the others are tuned and
        told.
    :param settle: Time after which a step of the push is to stay within 5 %, s (default: 0.9).
    :param overshoot: Largest overshoot of the step, over its height (default: 0.25).
    :param height: Height of the step in newtons (default: six tenths of the weld's push).
    :param robot: Robot file (default: KR 500 MT with FSW end effector).
    :param model: Model file: robot, process and effects of the real cell, instead of ``robot`` and
        ``process``.
    :param informed: The controller knows the model file's effects as well: other numbers of its
        robot, such as stiffness and geometry; refused where there are others.
    :param process: Process file (default: lap weld, stringer on 2024-T3 skin).
    :param control: Gains and limits of the controllers (default: tuned for the KR 500 MT).
    :param sensors: Sensor file (default: encoders and force sensor of the KR 500 MT cell).
    :param effect: Physical effect of the real robot that the controller does not know; may be given
        several times.
    :param stiffness_error: Relative error of the joint stiffness that the controller believes in,
        such as 0.1 (default: 0; of compare-laws: 0.2).
    :param spindle_rpm: Speed of the spindle in turns a minute, in the sense of the process file's
        (default: the process file's speed).
    :param period: Control period in seconds (default: the control file's).
    :param seed: Seed of the sensors' noise (default: the sensor file's).
    :param out: Control file to write (default: out/control.toml).
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param law_file: File that a law in Python is in: its digest enters the result, which says so
        where none is given.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: TuneResult = _run.call(('tune',), locals())
    return result


def compare(
    logs: StrPath | Sequence[StrPath],
    *,
    model: StrPath | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    rrd: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> CompareResult:
    """Show how far a model is from measurements, or a log from another, and where.

    Two logs of one experiment are compared with each other where no model is given: is the cell as
    it was?.

    As the command ``trueweld compare``.

    :param logs: Folders of logs or of campaigns.
    :param model: Model file (default: the campaign's).
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param rrd: Write a Rerun recording (open with: rerun FILE).
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: CompareResult = _run.call(('compare',), locals(), positional=('logs',))
    return result


def diagnose(
    logs: StrPath | Sequence[StrPath],
    *,
    model: StrPath | None = None,
    protocol: StrPath | None = None,
    budget: float | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    rrd: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> DiagnoseResult:
    """Find out which physical effect is missing in a model.

    As the command ``trueweld diagnose``.

    :param logs: Folders of logs or of campaigns.
    :param model: Model file (default: the campaign's).
    :param protocol: Write the experiment to make next as a protocol, which `record` tries in a
        simulated cell.
    :param budget: Time after which no new work is begun: the best answer so far is given, and what
        was left undone (default: none).
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param rrd: Write a Rerun recording (open with: rerun FILE).
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: DiagnoseResult = _run.call(('diagnose',), locals(), positional=('logs',))
    return result


def improve(
    logs: StrPath | Sequence[StrPath],
    *,
    out: StrPath,
    model: StrPath | None = None,
    held_out: StrPath | Sequence[StrPath] | None = None,
    budget: float | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    rrd: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> ImproveResult:
    """Add what is missing to a model, refit it, and write it.

    Campaigns of several units of one type (`unit` in campaign.toml): also what they share, how far
    they spread and which is an outlier.

    As the command ``trueweld improve``.

    :param logs: Folders of logs or of campaigns.
    :param out: Where to write the improved model; of several units, the folder for the file of
        each.
    :param model: Model file (default: the campaign's).
    :param held_out: Log or campaign that is judged by and not fitted, of several units each of the
        one that it states; may be given several times (default: blocks in time of the LOGs).
    :param budget: Time after which no new work is begun: the best answer so far is given, and what
        was left undone (default: none).
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param rrd: Write a Rerun recording (open with: rerun FILE).
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: ImproveResult = _run.call(('improve',), locals(), positional=('logs',))
    return result


def register(
    logs: StrPath | Sequence[StrPath],
    *,
    model: StrPath | None = None,
    write: bool = False,
    json: StrPath | None = None,
    html: StrPath | None = None,
    samples: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> RegisterResult:
    """Find where the tracker stands and what it sees of the tool, whatever the size.

    As the command ``trueweld register``.

    :param logs: Folders of logs or of campaigns.
    :param model: Model file (default: the campaign's).
    :param write: Write what was found into the log.toml of each log, as its table [tracker].
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param samples: Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in
        .csv.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: RegisterResult = _run.call(('register',), locals(), positional=('logs',))
    return result


def plan(
    protocol: StrPath,
    *,
    robot: StrPath | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> PlanResult:
    """Show what experiments would tell of each effect, before any is made.

    As the command ``trueweld plan``.

    :param protocol: Protocol file: the cell and the experiments.
    :param robot: Robot file, in place of the protocol's.
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: PlanResult = _run.call(('plan',), locals(), positional=('protocol',))
    return result


def record(
    protocol: StrPath,
    *,
    out: StrPath,
    seed: int | None = None,
    truth: StrPath | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> RecordResult:
    """Record logs of a simulated cell, as a laboratory would.

    As the command ``trueweld record``.

    :param protocol: Protocol file: the cell, its effects, and the logs to record.
    :param out: Folder of the campaign to write; nothing may be in it yet.
    :param seed: Seed of everything random (default: the protocol's).
    :param truth: Also write what was built in, to judge answers by.
    :param json: Write what was recorded as JSON.
    :param html: Write one self-contained HTML page.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: RecordResult = _run.call(('record',), locals(), positional=('protocol',))
    return result


def check(
    files: StrPath | Sequence[StrPath],
    *,
    json: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> CheckResult:
    """Check input files of any kind, and folders of logs and campaigns.

    As the command ``trueweld check``.

    :param files: Files to check: robots, processes, welds, gains, sensors, requirements, models,
        logs, campaigns, protocols; or folders of logs and campaigns, whose files are all checked.
    :param json: Write the verdicts as JSON.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: CheckResult = _run.call(('check',), locals(), positional=('files',))
    return result


def new_law(
    name: str,
    *,
    out: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> str:
    """Write a crate with a law and an effect of your own, beside those of this program.

    As the command ``trueweld new-law``.

    :param name: Name of the law: lower-case letters, digits and hyphens.
    :param out: Folder to write (default: the name).
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: str = _run.call(('new-law',), locals(), positional=('name',))
    return result


def init(
    folder: StrPath,
    *,
    progress: Progress | bool | None = None,
) -> str:
    """Write the folder of a campaign, with what is to be filled in.

    As the command ``trueweld init``.

    :param folder: Folder to write, which must not be there yet.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: str = _run.call(('init',), locals(), positional=('folder',))
    return result


def import_log(
    files: StrPath | Sequence[StrPath],
    *,
    out: StrPath,
    robot: StrPath | None = None,
    kind: str | None = None,
    period: float | None = None,
    yes: bool = False,
    json: StrPath | None = None,
    html: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> ImportLogResult:
    """Propose how files of any make are read as a log, and write its log.toml.

    As the command ``trueweld import-log``.

    :param files: Files of one recording: text, Parquet, NumPy (.npz, .npy), MATLAB (.mat), KUKA
        traces (.dat), ROS 2.
    :param out: Folder of the log, which is made where it is not there.
    :param robot: Robot file, or what import-urdf wrote: signs are told by its limits, its motion
        and its torques.
    :param kind: What was done: static-load, ring-down, free-motion or weld (default: by the
        channels).
    :param period: Time from row to row of the encoders' file, s, where it has none.
    :param yes: Write guesses as if they were known, for programs that check them themselves.
    :param json: Write the proposal as JSON.
    :param html: Write one self-contained HTML page.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: ImportLogResult = _run.call(('import-log',), locals(), positional=('files',))
    return result


def import_urdf(
    urdf: StrPath,
    *,
    out: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> str:
    """Turn a URDF into a robot file; what a URDF cannot know is marked to be filled in.

    As the command ``trueweld import-urdf``.

    :param urdf: URDF of a serial arm with six revolute joints.
    :param out: Robot file to write (default: standard output).
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: str = _run.call(('import-urdf',), locals(), positional=('urdf',))
    return result


def export_core(
    *,
    compensator: LawLike,
    weld: StrPath | None = None,
    robot: StrPath | None = None,
    model: StrPath | None = None,
    informed: bool = False,
    process: StrPath | None = None,
    control: StrPath | None = None,
    sensors: StrPath | None = None,
    effect: str | Sequence[str] | None = None,
    stiffness_error: float | None = None,
    spindle_rpm: float | None = None,
    period: float | None = None,
    seed: int | None = None,
    controller: str | None = None,
    out: StrPath | None = None,
    log: StrPath | None = None,
    law_file: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> str:
    """Write what a controller's core is built from as constants of Rust and C.

    As the command ``trueweld export-core``.

    :param compensator: Compensation law; no combination.
    :param weld: Weld file (default: the first published sequence).
    :param robot: Robot file (default: KR 500 MT with FSW end effector).
    :param model: Model file: robot, process and effects of the real cell, instead of ``robot`` and
        ``process``.
    :param informed: The controller knows the model file's effects as well: other numbers of its
        robot, such as stiffness and geometry; refused where there are others.
    :param process: Process file (default: lap weld, stringer on 2024-T3 skin).
    :param control: Gains and limits of the controllers (default: tuned for the KR 500 MT).
    :param sensors: Sensor file (default: encoders and force sensor of the KR 500 MT cell).
    :param effect: Physical effect of the real robot that the controller does not know; may be given
        several times.
    :param stiffness_error: Relative error of the joint stiffness that the controller believes in,
        such as 0.1 (default: 0; of compare-laws: 0.2).
    :param spindle_rpm: Speed of the spindle in turns a minute, in the sense of the process file's
        (default: the process file's speed).
    :param period: Control period in seconds (default: the control file's).
    :param seed: Seed of the sensors' noise (default: the sensor file's).
    :param controller: Hybrid force/position controller (default: external).
    :param out: Folder for cell.rs and cell.h (default: out/core).
    :param log: New folder for what the core is given and commands in every period of the simulated
        weld, as `replay` reads it.
    :param law_file: File that a law in Python is in: its digest enters the result, which says so
        where none is given.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: str = _run.call(('export-core',), locals())
    return result


def replay(
    core: StrPath,
    log: StrPath,
    *,
    scalar: str | None = None,
    json: StrPath | None = None,
    html: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> ReplayResult:
    """Feed a recorded run of a controller's core to the same core on this machine, and show the first period in which they differ.

    As the command ``trueweld replay``.

    :param core: The core: cell.h of `export-core`, or the folder it is in.
    :param log: Folder with inputs.bin and outputs.bin of the run.
    :param scalar: In what the recorded core computed (default: double).
    :param json: Write the figures as JSON.
    :param html: Write one self-contained HTML page.
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: ReplayResult = _run.call(('replay',), locals(), positional=('core', 'log'))
    return result


def export_fmu(
    *,
    weld: StrPath | None = None,
    robot: StrPath | None = None,
    model: StrPath | None = None,
    informed: bool = False,
    process: StrPath | None = None,
    control: StrPath | None = None,
    sensors: StrPath | None = None,
    effect: str | Sequence[str] | None = None,
    stiffness_error: float | None = None,
    spindle_rpm: float | None = None,
    period: float | None = None,
    seed: int | None = None,
    law: str | None = None,
    plant: bool = False,
    input: str | None = None,
    fmi: str | None = None,
    controller: str | None = None,
    library: StrPath | Sequence[StrPath] | None = None,
    out: StrPath | None = None,
    progress: Progress | bool | None = None,
) -> str:
    """Write a law or the cell as an FMU, for Simulink, OpenModelica and other tools.

    As the command ``trueweld export-fmu``.

    :param weld: Weld file (default: the first published sequence).
    :param robot: Robot file (default: KR 500 MT with FSW end effector).
    :param model: Model file: robot, process and effects of the real cell, instead of ``robot`` and
        ``process``.
    :param informed: The controller knows the model file's effects as well: other numbers of its
        robot, such as stiffness and geometry; refused where there are others.
    :param process: Process file (default: lap weld, stringer on 2024-T3 skin).
    :param control: Gains and limits of the controllers (default: tuned for the KR 500 MT).
    :param sensors: Sensor file (default: encoders and force sensor of the KR 500 MT cell).
    :param effect: Physical effect of the real robot that the controller does not know; may be given
        several times.
    :param stiffness_error: Relative error of the joint stiffness that the controller believes in,
        such as 0.1 (default: 0; of compare-laws: 0.2).
    :param spindle_rpm: Speed of the spindle in turns a minute, in the sense of the process file's
        (default: the process file's speed).
    :param period: Control period in seconds (default: the control file's).
    :param seed: Seed of the sensors' noise (default: the sensor file's).
    :param law: A compensation law with its controller: what the instruments read goes in, torques
        and correction come out.
    :param plant: The cell: torques or a correction go in, what the instruments read comes out.
    :param input: What drives a plant (default: torque).
    :param fmi: Version of FMI (default: 2).
    :param controller: Hybrid force/position controller of a law, and of a plant that a correction
        drives (default: external).
    :param library: Shared library of a platform, built from the sources of this program; may be
        given several times (default: that of this platform, which is in the wheel, or beside the
        program).
    :param out: File to write (default: out/NAME.fmu, with the law's name or plant).
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: str = _run.call(('export-fmu',), locals())
    return result


def schema(
    name: str | None = None,
    *,
    progress: Progress | bool | None = None,
) -> str:
    """Print the JSON Schema of a result, or list the schemas.

    As the command ``trueweld schema``.

    :param name: Name of the schema, as a result has it before the slash (default: list the names).
    :param progress: False shows none; a function is called with what is done now and the share of
        the whole (default: one line, at a terminal or in a notebook).
    """
    result: str = _run.call(('schema',), locals(), positional=('name',))
    return result
