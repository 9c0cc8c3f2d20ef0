"""Results, each with the names of its JSON: the names are in the stub."""

# Written by python/generate.py: do not edit.

from __future__ import annotations

from ._records import Result


class CertifyResult(Result):
    """What many welds of uncertain cells show of a compensation law."""

    __slots__ = ()


class CheckResult(Result):
    """Which input files are in order."""

    __slots__ = ()


class CompareLawsResult(Result):
    """Compensation laws on one weld, over a wrong stiffness, noise, delay and lost sensors."""

    __slots__ = ()


class CompareLogsResult(Result):
    """By how much two logs of one experiment differ: the second less the first."""

    __slots__ = ()


class CompareResult(Result):
    """A model against measurements."""

    __slots__ = ()


class DiagnoseResult(Result):
    """Which physical effect is missing in a model."""

    __slots__ = ()


class IdentifyPlanResult(Result):
    """Loads that are to tell the stiffness."""

    __slots__ = ()


class IdentifyResult(Result):
    """Numbers of a cell that were identified from logs."""

    __slots__ = ()


class ImportLogResult(Result):
    """How files of unknown make are proposed to be read."""

    __slots__ = ()


class ImproveFleetResult(Result):
    """Units of one type: what each has, and what they share."""

    __slots__ = ()


class ImproveResult(Result):
    """A model improved."""

    __slots__ = ()


class PlanResult(Result):
    """What experiments would show of each effect."""

    __slots__ = ()


class RecordResult(Result):
    """A campaign that was recorded of a simulated cell."""

    __slots__ = ()


class RegisterResult(Result):
    """Where trackers stand."""

    __slots__ = ()


class ReplayResult(Result):
    """A recorded run of a core beside the same core on this machine."""

    __slots__ = ()


class StepResult(Result):
    """Responses of the controllers to a step of the push."""

    __slots__ = ()


class StudyLayoutResult(Result):
    """Where a part is best put, and what it is worth there by full runs."""

    __slots__ = ()


class StudyLimitsResult(Result):
    """The largest push, feed and offset that keep requirements, at one place or several."""

    __slots__ = ()


class StudyPaperResult(Result):
    """The published statements beside ours, and the push near collinear axes."""

    __slots__ = ()


class StudySensitivityResult(Result):
    """Derivatives and Sobol indices of a weld's figures by what is not known of a cell."""

    __slots__ = ()


class TuneResult(Result):
    """Gains that were found for a robot, and what they are worth."""

    __slots__ = ()


class WeldResult(Result):
    """Figures of welds over their steady part (full feed, full push)."""

    __slots__ = ()


CLASSES: dict[str, type[Result]] = {
    "certify": CertifyResult,
    "check": CheckResult,
    "compare-laws": CompareLawsResult,
    "compare-logs": CompareLogsResult,
    "compare": CompareResult,
    "diagnose": DiagnoseResult,
    "identify-plan": IdentifyPlanResult,
    "identify": IdentifyResult,
    "import-log": ImportLogResult,
    "improve-fleet": ImproveFleetResult,
    "improve": ImproveResult,
    "plan": PlanResult,
    "record": RecordResult,
    "register": RegisterResult,
    "replay": ReplayResult,
    "step-result": StepResult,
    "study-layout": StudyLayoutResult,
    "study-limits": StudyLimitsResult,
    "study-paper": StudyPaperResult,
    "study-sensitivity": StudySensitivityResult,
    "tune": TuneResult,
    "weld-result": WeldResult,
}
