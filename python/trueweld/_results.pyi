"""Results, each with the names of its JSON."""

# Written by python/generate.py: do not edit.

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ._records import Record, Result

CLASSES: dict[str, type[Result]]

class Provenance(Record):
    """Everything that a result depends on."""

    @property
    def command(self) -> str:
        """The command, as it is written on the command line."""
    @property
    def effects(self) -> list[EffectRecord]:
        """Effects of the real cell that the controller does not know, or of the model that
        measurements are compared with."""
    @property
    def files(self) -> list[FileDigest]:
        """Every file that was read."""
    @property
    def robot(self) -> str:
        """Name of the robot."""
    @property
    def simulation(self) -> SimulationRecord | None:
        """How the cell was simulated; `None` where measurements were looked at."""
    @property
    def sources(self) -> str:
        """SHA-256 of the sources that the program was built from."""
    @property
    def version(self) -> str:
        """Version of the program."""
    @property
    def warnings(self) -> list[str]:
        """Values of the files that are possible but not plausible."""

class EffectRecord(Record):
    """An effect and its values."""

    @property
    def at(self) -> str:
        """What it is attached to, as files write it; empty for the whole cell."""
    @property
    def id(self) -> str:
        """Identifier of its kind."""
    @property
    def values(self) -> Mapping[str, float]:
        """Values by their names, SI units."""

class SimulationRecord(Record):
    """The options of a simulation."""

    @property
    def control_period_s(self) -> float:
        """Control period, s."""
    @property
    def controllers(self) -> list[str]:
        """Names of the hybrid controllers."""
    @property
    def cores(self) -> list[CoreRecord]:
        """What the cores on a controller are built from, one a weld, where that is certified."""
    @property
    def draws_seed(self) -> int | None:
        """Seed of the drawn cells."""
    @property
    def force_step_n(self) -> float | None:
        """Height of a step of the force set-point, N."""
    @property
    def informed(self) -> bool | None:
        """True where the controller knows the effects of the model file."""
    @property
    def laws(self) -> list[str]:
        """Names of the compensation laws."""
    @property
    def noise_seed(self) -> int:
        """Seed of the sensors' noise in the nominal cell."""
    @property
    def passes(self) -> int:
        """Welds of one seam, the law kept; the last one counts."""
    @property
    def plant_step_s(self) -> float:
        """Longest step of the plant, s."""
    @property
    def spindle_rad_s(self) -> float:
        """Speed of the spindle, positive about the tool's z axis, rad/s."""
    @property
    def stiffness_error(self) -> float:
        """Relative error of the joint stiffness that the controller believes in; where a sweep
        varies it, the error of the other sweeps."""
    @property
    def welds(self) -> list[str]:
        """Names of the welds."""

class CoreRecord(Record):
    """The constants from which a controller's core is built for a weld."""

    @property
    def law(self) -> str:
        """Name of the compensation law."""
    @property
    def sha256(self) -> str:
        """SHA-256 of the constants, as `export-core` prints it and the running core tells it."""
    @property
    def weld(self) -> str:
        """Name of the weld."""

class FileDigest(Record):
    """A file and the digest of its bytes."""

    @property
    def file(self) -> str:
        """Its path as given, or its name where it is embedded in the program."""
    @property
    def role(self) -> str:
        """What it was read as."""
    @property
    def sha256(self) -> str:
        """SHA-256 of its bytes, as `sha256sum` prints it."""

class UncertainRecord(Record):
    """A number that the draws differ in."""

    @property
    def basis(self) -> str:
        """`measured`, together with all others that are, or `assumed`."""
    @property
    def distribution(self) -> Distribution:
        """How it is distributed, in the unit."""
    @property
    def file(self) -> str:
        """The file that says so."""
    @property
    def group(self) -> Group | None:
        """What it is uncertain with."""
    @property
    def number(self) -> str:
        """What it is."""
    @property
    def relative(self) -> bool:
        """Whether it is a share by which the number differs from what the files of the cell
        state."""
    @property
    def source(self) -> str:
        """Who assumed it, or which logs measured it."""
    @property
    def unit(self) -> str:
        """Its unit; `1` for a share or a ratio."""

Distribution = Record

class Group(Record):
    """Numbers that are uncertain together."""

    @property
    def correlation(self) -> float:
        """Correlation of the standard normals behind any two of its numbers; 1: one number moves
        all."""
    @property
    def name(self) -> str:
        """Its name."""

class MeasurementRecord(Record):
    """What was measured of a cell."""

    @property
    def at_bound(self) -> list[str]:
        """Numbers whose values stand at the bound of what is possible."""
    @property
    def campaign_sha256(self) -> str:
        """SHA-256 of the SHA-256 of every file of the logs, in their order."""
    @property
    def logs(self) -> list[str]:
        """Names of the logs."""
    @property
    def not_measured(self) -> list[str]:
        """Numbers of which the logs say next to nothing: they are not among those measured."""
    @property
    def score(self) -> float:
        """Score of the model where nothing was fitted; 1.0 is the noise floor."""
    @property
    def undetermined(self) -> list[str]:
        """Numbers that the logs hardly determine."""

class ReplacedAssumption(Record):
    """What requirements assume of a number that was measured."""

    @property
    def distribution(self) -> Distribution:
        """What was assumed of it."""
    @property
    def number(self) -> str:
        """The number."""
    @property
    def relative(self) -> bool:
        """Whether the distribution is one of shares."""
    @property
    def source(self) -> str:
        """Who assumed it."""

class JudgedRequirement(Record):
    """One requirement, judged."""

    @property
    def achieved(self) -> float | None:
        """What was reached; of draws what all but the allowed share stay within."""
    @property
    def beyond(self) -> int | None:
        """Draws beyond the limit."""
    @property
    def case(self) -> str:
        """Which runs it is judged by: `nominal`, `draws`, `rare`, `worst-case`, `margins` or
        `faults`."""
    @property
    def confidence(self) -> float:
        """Confidence with which it is shown."""
    @property
    def failure_probability(self) -> float | None:
        """Largest probability of a weld beyond the limit that the draws leave open."""
    @property
    def limit(self) -> float:
        """The most that is allowed, of margins the least, in the unit of the key."""
    @property
    def name(self) -> str:
        """Key of the figure."""
    @property
    def reason(self) -> str | None:
        """Why it is not met or not shown."""
    @property
    def verdict(self) -> str:
        """`pass`, `not-shown` or `fail`."""
    @property
    def weld(self) -> str:
        """Name of the weld."""

class WeldEvidence(Record):
    """What the runs of one weld came to."""

    @property
    def bought(self) -> list[BoughtByMeasurement]:
        """What the measurement brought, where that was asked for."""
    @property
    def drives(self) -> list[DriveEvidence]:
        """What the drives gave in the steady part, A1 to A6."""
    @property
    def failed(self) -> list[UnfinishedTrial]:
        """Drawn cells in which no weld was made."""
    @property
    def faults(self) -> list[FaultRun]:
        """Instruments that fail, one at a time."""
    @property
    def held_by_control(self) -> Mapping[str, float] | None:
        """Limits of the requirements, by their keys, that corrections are held to by the control
        file: they show nothing, and are not judged."""
    @property
    def margins(self) -> list[MarginPlace]:
        """The loop along the weld."""
    @property
    def name(self) -> str:
        """Name of the weld."""
    @property
    def nominal(self) -> TrialFigures:
        """The cell as it is believed to be."""
    @property
    def not_required(self) -> list[NotRequiredFigure]:
        """What is not required of these."""
    @property
    def rare(self) -> RareEvidence | None:
        """How rare a weld beyond any limit is, where that was asked for."""
    @property
    def sensitivity(self) -> list[FigureSensitivity]:
        """What the failures follow from: of the requirements that draws were beyond, or of the
        one that came closest to its limit."""
    @property
    def trials(self) -> int:
        """Number of drawn cells."""
    @property
    def weak_points(self) -> list[WeakMargin]:
        """Margins that no requirement limits and that are smaller than is customary."""
    @property
    def worst_case(self) -> WorstCell:
        """The worst cell that a search found."""

TrialFigures = Mapping[str, float] | Record

class UnfinishedTrial(Record):
    """A drawn cell in which no weld was made."""

    @property
    def trial(self) -> int:
        ...
    @property
    def why(self) -> str:
        ...

class RareEvidence(Record):
    """A subset simulation."""

    @property
    def allowed(self) -> float:
        """Probability of a weld beyond a limit that is allowed."""
    @property
    def levels(self) -> list[RareLevel]:
        """Every level."""
    @property
    def probability(self) -> float:
        """The probability; where `reached` is false that of the last level, which failures are
        rarer than."""
    @property
    def reached(self) -> bool:
        """Whether cells beyond a limit were found."""
    @property
    def runs(self) -> int:
        """Runs beside the draws."""
    @property
    def variation(self) -> float:
        """Its coefficient of variation."""

class RareLevel(Record):
    """A level of a subset simulation."""

    @property
    def acceptance(self) -> float:
        """Share of the moves that were accepted."""
    @property
    def cells(self) -> int:
        """Cells."""
    @property
    def correlation(self) -> float:
        """By how much more correlation makes the variance of the share."""
    @property
    def share(self) -> float:
        """Share of them beyond the next level, of the last one beyond a limit."""

class WorstCell(Record):
    """The worst cell that a search found."""

    @property
    def beyond(self) -> int:
        """So many of them are beyond a limit."""
    @property
    def cell(self) -> SampledCell | None:
        """The cell."""
    @property
    def figure(self) -> str:
        """Key of the figure that it is worst in."""
    @property
    def figures(self) -> TrialFigures | None:
        """Its figures."""
    @property
    def numbers(self) -> Mapping[str, float] | None:
        """Its numbers of `[[uncertain]]`, by what they are."""
    @property
    def of_limit(self) -> float | None:
        """That figure over its limit."""
    @property
    def runs(self) -> int:
        """Runs of the search."""

class SampledCell(Record):
    """What a cell turned out to be, relative to what it is believed to be."""

    @property
    def crosstalk(self) -> list[float]:
        """What the force sensor shows along x and y of T per axial force."""
    @property
    def delay(self) -> float:
        """Delay of force sensor and seam sensor, control periods."""
    @property
    def latents(self) -> list[float]:
        """Standard normals behind the numbers of `[[uncertain]]`; none in the nominal cell."""
    @property
    def noise(self) -> int:
        """Seed of the instruments' noise."""
    @property
    def process(self) -> list[float]:
        """Factors on depth stiffness and damping, feed drag, lateral damping, lateral stiffness,
        lateral ratio."""
    @property
    def ripple(self) -> list[float]:
        """Factor on the ripple's amplitude, and what is added to its phases, rad."""
    @property
    def stiffness(self) -> list[float]:
        """Factor on every joint's stiffness."""

class DriveEvidence(Record):
    """What one drive gave in the steady part."""

    @property
    def cells_at_limit(self) -> int:
        """Drawn cells in which it stood at a limit of torque or speed."""
    @property
    def drawn(self) -> DriveLoad:
        """The most in any drawn cell, number by number."""
    @property
    def drive(self) -> str:
        """Which, as in `A1`."""
    @property
    def nominal(self) -> DriveLoad:
        """In the cell as it is believed to be."""

class DriveLoad(Record):
    """What one drive gives in the steady part of a weld."""

    @property
    def at_speed_limit(self) -> float:
        """Share of the steady part in which the drive stands at its speed limit."""
    @property
    def at_torque_limit(self) -> float:
        """Share of the steady part in which the drive stands at its torque limit."""
    @property
    def speed_share(self) -> float:
        """Largest speed over what the drive may do."""
    @property
    def torque_share(self) -> float:
        """Largest torque over what the drive may give."""

class MarginPlace(Record):
    """The loop at one place of the weld, with one slope of friction."""

    @property
    def channels(self) -> Mapping[str, LoopMargins] | None:
        """Margins of every channel by its name; `null` where the loop is not stable."""
    @property
    def disk(self) -> float:
        """Disk margin of corrections and force all at once."""
    @property
    def draw(self) -> int | None:
        """Index of the drawn cell; `null` for the nominal one."""
    @property
    def drive_disk(self) -> float:
        """Disk margin of all drives at once."""
    @property
    def feed_m_s(self) -> float:
        """Feed there, m/s."""
    @property
    def friction(self) -> str:
        """What the drives' friction is taken for: `viscous`, `at-speed` or `full`."""
    @property
    def held_at_a_limit(self) -> bool:
        """Whether only a limit holds the loop."""
    @property
    def passivity(self) -> LoopPassivity:
        """Damping of the position loop at the tool."""
    @property
    def path_m(self) -> float:
        """Path position, m."""
    @property
    def push_n(self) -> float:
        """Push there, N."""
    @property
    def ramp(self) -> bool:
        """Whether push and feed are still rising, or the tool has come to its end."""
    @property
    def spectral_radius(self) -> float | None:
        """Largest magnitude of a closed-loop pole; `null` where the loop runs away."""

class LoopMargins(Record):
    """Margins of one channel with the others closed; `null` where there is no limit."""

    @property
    def delay_s(self) -> float | None:
        """Smallest further delay, s."""
    @property
    def fall(self) -> float | None:
        """Smallest factor on the gain."""
    @property
    def gain(self) -> float | None:
        """Largest factor on the gain."""
    @property
    def modulus(self) -> float | None:
        """Least distance of the loop from −1: the inverse of the largest sensitivity."""
    @property
    def phase_rad(self) -> float | None:
        """Smallest turn of the phase, either way, rad."""

class LoopPassivity(Record):
    """Damping that the position loop needs at the tool and that is there, N·s/m."""

    @property
    def needed_ns_m(self) -> float | None:
        """That the mechanism must have to be passive with this controller, K T/2 + B."""
    @property
    def there_ns_m(self) -> float | None:
        """That the friction of the drives gives."""

class FaultRun(Record):
    """One instrument that fails for a while."""

    @property
    def draw(self) -> int | None:
        """Index of the drawn cell; `null` for the nominal one."""
    @property
    def failed(self) -> str | None:
        """Why there are none."""
    @property
    def fault(self) -> str:
        """The fault in words."""
    @property
    def figures(self) -> Mapping[str, float] | None:
        """Figures by their keys."""
    @property
    def from_s(self) -> float:
        """When it begins, s."""
    @property
    def name(self) -> str:
        """Name of the fault."""
    @property
    def reported_after_s(self) -> float | None:
        """Time after its beginning at which the controller or the law first reported a fault, s;
        `null` where they did not while it lasted."""
    @property
    def until_s(self) -> float:
        """When it ends, s."""
    @property
    def worst_of_weld(self) -> LimitedFigure | None:
        """The figure of the weld that was the largest share of its limit, in the unit of its
        key."""

class LimitedFigure(Record):
    """A figure of a weld and its limit, SI units."""

    @property
    def limit(self) -> float:
        """The limit."""
    @property
    def name(self) -> str:
        """Its key."""
    @property
    def value(self) -> float:
        """What it came to."""

class NotRequiredFigure(Record):
    """A figure of a fault that is not required, as it would be judged if it were."""

    @property
    def achieved(self) -> float | None:
        """The worst that was reached."""
    @property
    def fault(self) -> str:
        """Name of the fault."""
    @property
    def limit(self) -> float:
        """What it would have to stay within, in the unit of the key."""
    @property
    def name(self) -> str:
        """Key of the figure."""
    @property
    def reason(self) -> str:
        """Why it is not required, as the requirements state it."""

class BoughtByMeasurement(Record):
    """What the trials come to by one requirement where measured numbers are as they are assumed,
    and as they were measured."""

    @property
    def assumed(self) -> DrawnFigure:
        """With what the requirements assume."""
    @property
    def limit(self) -> float:
        """The most that is allowed, in the unit of the key."""
    @property
    def measured(self) -> DrawnFigure:
        """With what was measured."""
    @property
    def name(self) -> str:
        """Key of the figure."""

class DrawnFigure(Record):
    """A figure over drawn cells."""

    @property
    def beyond(self) -> int:
        """Draws beyond the limit."""
    @property
    def failure_probability(self) -> float:
        """Largest probability of a weld beyond the limit that the draws leave open."""
    @property
    def spread(self) -> list[float | None]:
        """Between which 90 % of the draws lie; `null` where they come to no end."""

class FigureSensitivity(Record):
    """What the draws say of a requirement's dependence on the uncertain numbers."""

    @property
    def beyond(self) -> int:
        """Draws beyond its limit."""
    @property
    def explained(self) -> float:
        """Share of the variance of the figure's logarithm that the numbers explain."""
    @property
    def name(self) -> str:
        """Key of the figure."""
    @property
    def numbers(self) -> list[NumberInfluence]:
        """The numbers that matter beyond chance, the most important first."""

class NumberInfluence(Record):
    """What one uncertain number has to do with a figure."""

    @property
    def beyond_without(self) -> int:
        """Draws beyond the limit were the number always in the middle of its range."""
    @property
    def number(self) -> str:
        """The number, or the group that moves together."""
    @property
    def share(self) -> float:
        """Share of the variance of the figure's logarithm."""
    @property
    def trend(self) -> str:
        """How the figure follows it: `grows`, `falls`, `at-ends` or `in-middle`."""

class WeakMargin(Record):
    """A margin that is weak and not limited."""

    @property
    def channel(self) -> str:
        """Where the loop was opened."""
    @property
    def customary(self) -> float:
        """What is customary at least."""
    @property
    def draw(self) -> int | None:
        """Index of the drawn cell; `null` for the nominal one."""
    @property
    def friction(self) -> str:
        """What the drives' friction is taken for: `viscous`, `at-speed` or `full`."""
    @property
    def least(self) -> float:
        """The least along the weld, in the unit of the key."""
    @property
    def name(self) -> str:
        """Key of the margin."""
    @property
    def path_m(self) -> float:
        """Path position, m."""

class CertifyResult(Result):
    """What many welds of uncertain cells show of a compensation law."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def verdict(self) -> str:
        """`pass`, `not-shown` or `fail`, of all requirements together."""
    @property
    def weak(self) -> list[str]:
        """What is weak although no requirement forbids it, in words: margins below what is
        customary, and searched cells beyond a limit. The headline of a pass names them."""
    @property
    def law(self) -> str:
        """Name of the law."""
    @property
    def controller(self) -> str:
        """Name of the hybrid controller."""
    @property
    def passes(self) -> int:
        """Welds of one seam in a trial; the last one counts."""
    @property
    def seed(self) -> int:
        """Seed of the draws."""
    @property
    def seed_given(self) -> bool:
        """Whether the seed was given, in place of the one that follows from the inputs."""
    @property
    def allowed_failure_probability(self) -> float:
        """Share of welds that may be beyond a limit."""
    @property
    def confidence(self) -> float:
        """Confidence with which that is to be shown."""
    @property
    def uncertain(self) -> list[UncertainRecord]:
        """Every number that the draws differ in."""
    @property
    def measurement(self) -> MeasurementRecord | None:
        """What was measured of the cell; `null` where all is assumed."""
    @property
    def replaced(self) -> list[ReplacedAssumption]:
        """What the requirements assume of numbers that were measured: it is not drawn."""
    @property
    def left_out(self) -> list[str]:
        """What the draws take as known although it might not be."""
    @property
    def repeat(self) -> str:
        """The command line that comes to the same."""
    @property
    def kept(self) -> list[FileDigest]:
        """The files in which every run is kept, in the folder of the certificate."""
    @property
    def requirements(self) -> list[JudgedRequirement]:
        """Every requirement of every weld: those of the requirements file, and of every weld
        that it is the one that was asked for."""
    @property
    def welds(self) -> list[WeldEvidence]:
        """What the runs of every weld came to."""
    @property
    def sha256(self) -> str:
        """SHA-256 of all of the above: it finds a certificate that was damaged, or changed
        without computing it anew."""

class CheckedFile(Record):
    """One input file: of which kind it is, or what is wrong with it."""

    @property
    def error(self) -> str | None:
        """What is wrong with it."""
    @property
    def file(self) -> str:
        """The path as it was given."""
    @property
    def kind(self) -> str | None:
        """Its kind."""
    @property
    def notices(self) -> list[str]:
        """What a reader should know of it: how a log was read, and values that are implausible."""
    @property
    def ok(self) -> bool:
        """Whether it is in order."""

class CheckResult(Result):
    """Which input files are in order."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def files(self) -> list[CheckedFile]:
        """Every file, in the order given."""

class ComparedLaw(Record):
    """A law and how often it welds the seam before it counts."""

    @property
    def name(self) -> str:
        """Name of the law."""
    @property
    def passes(self) -> int:
        """Welds of the seam; the last one counts."""

class LawSweep(Record):
    """All laws over one varied quantity."""

    @property
    def results(self) -> list[LawPoints]:
        """Every law's points."""
    @property
    def varied(self) -> str:
        """Key of the quantity in the points."""

class LawPoints(Record):
    """One law over one varied quantity."""

    @property
    def law(self) -> str:
        """Name of the law."""
    @property
    def points(self) -> list[LawPoint]:
        """One weld a value of the quantity."""

class LawPoint(Record):
    """One weld: its figures or why it has none, and the value of what was varied."""

    @property
    def delay_periods(self) -> float | None:
        """Delay of force and seam sensor, control periods."""
    @property
    def failed(self) -> str | None:
        """Why the weld was not made."""
    @property
    def force_sensor_dies(self) -> bool | None:
        """Whether the force sensor dies half-way."""
    @property
    def lateral_max_m(self) -> float | None:
        """Lateral deviation, largest, m."""
    @property
    def lateral_rms_m(self) -> float | None:
        """Lateral deviation, RMS, m."""
    @property
    def lost_share(self) -> float | None:
        """Share of the seam sensor's readings that are lost."""
    @property
    def noise_factor(self) -> float | None:
        """Factor on the noise of force and seam sensor."""
    @property
    def only_in_last_pass(self) -> bool | None:
        """Whether they are lost in the last pass alone."""
    @property
    def side_tilt_rms_rad(self) -> float | None:
        """Tilt across the seam, RMS, rad."""
    @property
    def stiffness_error(self) -> float | None:
        """Error of the believed stiffness, as a share."""
    @property
    def travel_angle_rms_rad(self) -> float | None:
        """Tilt along the seam, RMS, rad."""

class CompareLawsResult(Result):
    """Compensation laws on one weld, over a wrong stiffness, noise, delay and lost sensors."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def weld(self) -> str:
        """Name of the weld."""
    @property
    def controller(self) -> str:
        """Name of the hybrid controller."""
    @property
    def seed(self) -> int:
        """Seed of the sensors' noise."""
    @property
    def control_period_s(self) -> float:
        """Control period, s."""
    @property
    def stiffness_error_where_not_varied(self) -> float:
        """Error of the believed stiffness in the sweeps of something else, as a share."""
    @property
    def lateral_rms_limit_m(self) -> float | None:
        """What the lateral deviation is to stay within, RMS, m."""
    @property
    def laws(self) -> list[ComparedLaw]:
        """The laws, in the order of all results."""
    @property
    def sweeps(self) -> list[LawSweep]:
        """What was varied, one quantity after the other."""

class PairClock(Record):
    """A clock against another: time = offset + (1 + drift) · the other's."""

    @property
    def deviation(self) -> list[float]:
        """Standard deviations of offset, s, and drift."""
    @property
    def drift(self) -> float:
        """What it gains, s per s."""
    @property
    def left_m(self) -> float:
        """Root mean square of what is left between the tool's paths by the encoders, m."""
    @property
    def offset_s(self) -> float:
        """Offset, s."""

class MovedTracker(Record):
    """A tracker that stands elsewhere than before."""

    @property
    def position_m(self) -> list[float]:
        """Shift at the base's origin, m."""
    @property
    def rotation_rad(self) -> list[float]:
        """Rotation vector, rad."""
    @property
    def turned(self) -> bool:
        """False where the points tell no turn: a shift alone."""

class DifferentChannel(Record):
    """By how much logs differ in a channel."""

    @property
    def columns(self) -> list[DifferentColumn]:
        """Each column."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def noise(self) -> float | None:
        """What noise alone makes of it; null where it is not known."""
    @property
    def rms(self) -> float:
        """Root mean square of the difference."""
    @property
    def score(self) -> float | None:
        """How many times the noise it is; null where that is not known."""
    @property
    def unit(self) -> str:
        """Unit of the figures."""

class DifferentColumn(Record):
    """By how much logs differ in a column."""

    @property
    def follows(self) -> FollowedVariable | None:
        """What explains most of it beside its mean; null where nothing does."""
    @property
    def largest(self) -> float:
        """Its largest magnitude."""
    @property
    def largest_at_s(self) -> float:
        """When that was, in the first log, s."""
    @property
    def mean(self) -> float:
        """Its mean."""
    @property
    def mean_interval(self) -> float | None:
        """Half the 95 % interval of the mean, from ten stretches of the log; null of a single
        row."""
    @property
    def name(self) -> str:
        """Axis or joint."""
    @property
    def noise(self) -> float | None:
        """What noise alone makes of the difference; null where it is not known."""
    @property
    def rms(self) -> float:
        """Root mean square of the difference."""
    @property
    def samples(self) -> int:
        """Values that were compared."""

class FollowedVariable(Record):
    """What a difference follows."""

    @property
    def joint(self) -> str | None:
        """The joint, of a direction."""
    @property
    def share(self) -> float:
        """Share of the squared difference that it explains."""
    @property
    def size(self) -> float:
        """Change of the difference from begin to end of the log, for a value of 1, from standing
        to moving, or from no payload to the largest; in the channel's unit."""
    @property
    def variable(self) -> str:
        """`time`, `value` (the column's own, the mean of both logs), `direction` of a joint's
        motion, or `payload`."""

class CompareLogsResult(Result):
    """By how much two logs of one experiment differ: the second less the first."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def logs(self) -> list[str]:
        """Folders of the first and the second log."""
    @property
    def kind(self) -> str:
        """What was done."""
    @property
    def rows(self) -> int:
        """Rows that are compared."""
    @property
    def unmatched(self) -> list[int]:
        """Rows of each log that the other does not have."""
    @property
    def clock(self) -> PairClock | None:
        """The second log's clock against the first's; null of loads at rest."""
    @property
    def tracker(self) -> MovedTracker | None:
        """How the second tracker stands in the first's frame, which is taken out; null without
        one."""
    @property
    def channels(self) -> list[DifferentChannel]:
        """Every channel that both logs have."""

class FileMistake(Record):
    """A gross mistake in the files."""

    @property
    def at(self) -> str:
        """What it is in: joints by their names, columns of the wrench (`Fx`), or `encoders`,
        `torque`, `wrench`, `tracker`, `time`, `spindle`, `payload`."""
    @property
    def change(self) -> str:
        """The line to write; several where it takes several."""
    @property
    def change_in(self) -> str:
        """Where the line belongs."""
    @property
    def channel(self) -> str:
        """The channel that it is in."""
    @property
    def evidence(self) -> MistakeEvidence:
        """What shows it."""
    @property
    def logs(self) -> list[str]:
        """Names of the logs that it is in."""
    @property
    def sentence(self) -> str:
        """The same in words."""
    @property
    def what(self) -> str:
        """`sign`, `zero`, `exchanged`, `coupling`, `unit`, `gear-side`, `tracker-frame`, `time-
        unit`, `wrench-side`, `wrench-axes`, `wrench-point` or `payload`."""

class MistakeEvidence(Record):
    """What a residual is as the files are, and with the mistake undone."""

    @property
    def channel(self) -> str:
        """Channel that is compared."""
    @property
    def rms_after(self) -> float | None:
        """Root mean square with the mistake undone."""
    @property
    def rms_before(self) -> float | None:
        """Root mean square as the files are."""
    @property
    def unit(self) -> str:
        """Unit of both figures."""

class ComparedLog(Record):
    """A model against one log."""

    @property
    def channels(self) -> list[ComparedChannel]:
        """Every channel that is compared."""
    @property
    def kind(self) -> str:
        """Kind of the log."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def path(self) -> str:
        """The log's folder."""
    @property
    def samples(self) -> int:
        """Number of compared samples."""
    @property
    def score(self) -> float | None:
        """As the whole's."""

class ComparedChannel(Record):
    """A model against one channel of a log, or one column of it; figures in `unit`."""

    @property
    def accuracy(self) -> float | None:
        """Root mean square of what predictions may be off by; 0 where they are to be as exact as
        the noise."""
    @property
    def columns(self) -> list[ComparedChannel]:
        """The columns."""
    @property
    def label(self) -> str | None:
        """What people call a column."""
    @property
    def max(self) -> float | None:
        """Largest magnitude of measured less predicted."""
    @property
    def name(self) -> str:
        """Name of the channel; of a column, with its number from 0."""
    @property
    def noise(self) -> float | None:
        """Root mean square of what the noise leaves in the difference."""
    @property
    def noise_is(self) -> str:
        """Whether the logs state the noise: `stated` or `estimated`."""
    @property
    def rmse(self) -> float | None:
        """Root mean square of measured less predicted."""
    @property
    def samples(self) -> int:
        """Number of compared samples."""
    @property
    def score(self) -> float | None:
        """As the whole's."""
    @property
    def unit(self) -> str:
        """Unit of the figures."""

class ResidualFinding(Record):
    """A condition that the residual of one channel follows."""

    @property
    def category(self) -> str | None:
        """Name of the category where it shows most."""
    @property
    def channel(self) -> str:
        """The channel."""
    @property
    def curve(self) -> ResidualCurve:
        """The residual over the condition."""
    @property
    def high(self) -> float | None:
        """See `low`."""
    @property
    def how(self) -> str:
        """Whether the `mean` or the `size` of the residual follows the condition."""
    @property
    def kind(self) -> str:
        """Kind of the logs."""
    @property
    def logs(self) -> list[str]:
        """Names of the logs."""
    @property
    def low(self) -> float | None:
        """Where it shows most: range of the condition, or the category's number twice."""
    @property
    def map(self) -> ResidualMapData | None:
        """Two conditions that it follows together, where one does not do."""
    @property
    def p(self) -> float | None:
        """How often chance does as much."""
    @property
    def samples_there(self) -> float | None:
        """Share of the samples where it shows most."""
    @property
    def score(self) -> float | None:
        """Score of this channel in these logs."""
    @property
    def sentence(self) -> str:
        """The same in words."""
    @property
    def share(self) -> float | None:
        """Share of the squared residual that follows it."""
    @property
    def share_by_chance(self) -> float | None:
        """Share that chance gives."""
    @property
    def share_there(self) -> float | None:
        """Share of the squared residual where it shows most."""
    @property
    def similar(self) -> list[str]:
        """Conditions that it follows nearly as much."""
    @property
    def unit(self) -> str:
        """Its unit; empty for categories."""
    @property
    def variable(self) -> str:
        """The condition."""

class ResidualCurve(Record):
    """A residual over a condition."""

    @property
    def categories(self) -> list[str]:
        """Names of the categories; empty where the condition is a number."""
    @property
    def error(self) -> list[float | None]:
        """Standard errors of `y`."""
    @property
    def x(self) -> list[float | None]:
        ...
    @property
    def x_name(self) -> str:
        ...
    @property
    def x_unit(self) -> str:
        ...
    @property
    def y(self) -> list[float | None]:
        ...
    @property
    def y_name(self) -> str:
        ...
    @property
    def y_unit(self) -> str:
        ...

class ResidualMapData(Record):
    """A mean residual over two conditions."""

    @property
    def mean(self) -> list[list[float | None]]:
        """By y, then by x; null where there are too few rows."""
    @property
    def p(self) -> float | None:
        """How often chance does as much."""
    @property
    def series(self) -> str:
        """The column."""
    @property
    def share(self) -> float | None:
        """Share of the squared residual that follows both."""
    @property
    def share_by_chance(self) -> float | None:
        """Share that chance gives."""
    @property
    def unit(self) -> str:
        ...
    @property
    def x(self) -> ResidualMapAxis:
        ...
    @property
    def y(self) -> ResidualMapAxis:
        ...

class ResidualMapAxis(Record):
    """The bins of one condition."""

    @property
    def categories(self) -> list[str]:
        """Names of the categories; empty where the condition is a number."""
    @property
    def name(self) -> str:
        ...
    @property
    def unit(self) -> str:
        ...
    @property
    def values(self) -> list[float | None]:
        """Mean of the condition in each bin."""

class RegisteredTracker(Record):
    """A tracker's frame and what it sees of the tool."""

    @property
    def base(self) -> RegisteredPose:
        """The robot's base seen by the tracker."""
    @property
    def left_m(self) -> float | None:
        """Root mean square of what is left of the positions, m."""
    @property
    def left_rad(self) -> float | None:
        """Root mean square of what is left of the rotations, rad."""
    @property
    def logs(self) -> list[str]:
        """Names of the logs."""
    @property
    def poses(self) -> int:
        """Poses that it rests on."""
    @property
    def table(self) -> str:
        """The table for `log.toml`."""
    @property
    def tool(self) -> RegisteredPose:
        """The tracked point and its axes in the tool frame."""

class RegisteredPose(Record):
    """A rigid motion with the half-widths of its 95 % intervals."""

    @property
    def position_interval_m(self) -> list[float]:
        """Half-widths of the position, m."""
    @property
    def position_m(self) -> list[float]:
        """Position, m."""
    @property
    def rotation_interval_rad(self) -> list[float]:
        """Half-widths of the rotation, rad."""
    @property
    def rotation_rad(self) -> list[float]:
        """Rotation vector, rad."""

class CompareResult(Result):
    """A model against measurements."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def mistakes(self) -> list[FileMistake]:
        """Mistakes in the files; where there are any, nothing else was looked for."""
    @property
    def model(self) -> str:
        """The model file."""
    @property
    def score(self) -> float | None:
        """√mean((residual/noise)²) over all samples; 1 is the noise floor."""
    @property
    def samples(self) -> int:
        """Number of compared samples."""
    @property
    def logs(self) -> list[ComparedLog]:
        """Every log."""
    @property
    def worst(self) -> list[ResidualFinding]:
        """What the residuals follow, worst first."""
    @property
    def notices(self) -> list[str]:
        """What a reader should know although nothing is wrong."""
    @property
    def registered(self) -> list[RegisteredTracker]:
        """Trackers that stood elsewhere, and were registered first."""

class ChannelErrorFigures(Record):
    """Error of one channel over all logs."""

    @property
    def accuracy(self) -> float:
        """What predictions may be off by; 0 where they are to be as exact as the noise."""
    @property
    def channel(self) -> str:
        """`tcp_position`, `tcp_rotation`, `motor_torque`, `link_encoder`, `force` or `moment`."""
    @property
    def noise(self) -> float:
        """Root mean square of the noise in the difference."""
    @property
    def ripple(self) -> bool:
        """True for the force's amplitudes at the spindle's orders, false for what is slower."""
    @property
    def rmse(self) -> float | None:
        """Root mean square of measured less predicted."""
    @property
    def samples(self) -> int:
        ...
    @property
    def unit(self) -> str:
        """Unit of the figures."""

class DiagnosisCandidate(Record):
    """One explanation."""

    @property
    def effects(self) -> list[FittedEffectValues]:
        """Its effects."""
    @property
    def evidence(self) -> EffectCurveData | None:
        """The curve that shows the first of its effects that has one."""
    @property
    def evidence_nats(self) -> float | None:
        """Evidence for it against none: the difference of the log scores on rows left out of the
        fit, less the logarithm of how many were tried, nats."""
    @property
    def evidence_of_effects(self) -> list[EffectCurveData | None]:
        """The curve of each effect."""
    @property
    def explanation(self) -> str:
        """The same in words."""
    @property
    def holdout_score_after(self) -> float | None:
        """Score on rows left out of the fit, with it."""
    @property
    def holdout_score_before(self) -> float | None:
        """Score on rows left out of the fit, without it."""
    @property
    def indistinguishable(self) -> list[EffectPlace]:
        """Effects that the data do not tell from it."""
    @property
    def left(self) -> float | None:
        """Share of what is above the noise floor that it leaves."""
    @property
    def probability(self) -> float | None:
        """How likely it is."""

class FittedEffectValues(Record):
    """An effect with its fitted values."""

    @property
    def at(self) -> str:
        """What it is at."""
    @property
    def effect(self) -> str:
        """The effect."""
    @property
    def implausible(self) -> bool | None:
        """True for a calibration that is larger than any, or at the bound of its range."""
    @property
    def log(self) -> str | None:
        """The log, where it is of one alone."""
    @property
    def parameters(self) -> Mapping[str, FittedValue]:
        """Its parameters by name."""

class FittedValue(Record):
    """A fitted value with its 95 % interval."""

    @property
    def high(self) -> float | None:
        ...
    @property
    def low(self) -> float | None:
        ...
    @property
    def unit(self) -> str:
        ...
    @property
    def value(self) -> float | None:
        ...

class EffectPlace(Record):
    """An effect and what it is at: a joint, an instrument, or nothing for the whole cell."""

    @property
    def at(self) -> str:
        ...
    @property
    def effect(self) -> str:
        ...

class EffectCurveData(Record):
    """What the measurements show of an effect, and the effect as fitted."""

    @property
    def error(self) -> list[float | None]:
        """Standard errors of `y`."""
    @property
    def fitted_x(self) -> list[float | None]:
        ...
    @property
    def fitted_y(self) -> list[float | None]:
        ...
    @property
    def title(self) -> str:
        ...
    @property
    def x(self) -> list[float | None]:
        ...
    @property
    def x_name(self) -> str:
        ...
    @property
    def x_unit(self) -> str:
        ...
    @property
    def y(self) -> list[float | None]:
        ...
    @property
    def y_name(self) -> str:
        ...
    @property
    def y_unit(self) -> str:
        ...

class DiscoveredLaw(Record):
    """A law outside the library: what is added at a port of the plant, over variables of the
    logs."""

    @property
    def at(self) -> str:
        """A joint's name, or nothing for the whole cell."""
    @property
    def curve(self) -> DiscoveredCurve:
        """The free curve."""
    @property
    def explanation(self) -> str:
        """The same in words."""
    @property
    def expression(self) -> str | None:
        """The formula; null where the curve itself is the law."""
    @property
    def history(self) -> bool:
        """True for a loop: it depends on the way that the variable has come, and the curve is
        over the way since a reversal."""
    @property
    def holdout_score_after(self) -> float | None:
        """Score on rows left out of the fit, with it."""
    @property
    def holdout_score_before(self) -> float | None:
        """Score on rows left out of the fit, of the model as given."""
    @property
    def indistinguishable(self) -> list[DiscoveredPlace]:
        """Laws that the data do not tell from it."""
    @property
    def left(self) -> float | None:
        """Share of what is above the noise floor that it leaves."""
    @property
    def like(self) -> list[FittedEffectValues]:
        """Effects of the library that are like it, and whose form does not hold."""
    @property
    def over(self) -> list[str]:
        """Variables of the port, that of the curve first."""
    @property
    def parameters(self) -> Mapping[str, FittedValue]:
        """Values of the formula, or of the curve at its places."""
    @property
    def port(self) -> str:
        """The port, as an effect of one's own names it."""
    @property
    def times(self) -> str:
        """What the curve is multiplied by, an expression over the port's variables."""

class DiscoveredCurve(Record):
    """A free curve with its 95 % band."""

    @property
    def high(self) -> list[float | None]:
        ...
    @property
    def level(self) -> float | None:
        """Half the 95 % interval of what all values have in common, where that is most of the
        band's width: a constant that calibrations make as well."""
    @property
    def low(self) -> list[float | None]:
        ...
    @property
    def surface(self) -> DiscoveredSurface | None:
        """The surface whose curve in the middle of its second variable this is; null where the
        law is over one variable."""
    @property
    def x(self) -> list[float]:
        ...
    @property
    def x_name(self) -> str:
        ...
    @property
    def x_unit(self) -> str:
        ...
    @property
    def y(self) -> list[float]:
        ...
    @property
    def y_name(self) -> str:
        ...
    @property
    def y_unit(self) -> str:
        ...

class DiscoveredSurface(Record):
    """A free surface with its 95 % band: a row over `x` of the curve for each value of the
    second variable."""

    @property
    def across(self) -> list[float]:
        ...
    @property
    def across_name(self) -> str:
        ...
    @property
    def across_unit(self) -> str:
        ...
    @property
    def high(self) -> list[list[float | None]]:
        ...
    @property
    def low(self) -> list[list[float | None]]:
        ...
    @property
    def y(self) -> list[list[float]]:
        ...

class DiscoveredPlace(Record):
    """Where a law may act, and what it may depend on."""

    @property
    def at(self) -> str:
        """A joint's name, or nothing for the whole cell."""
    @property
    def history(self) -> bool:
        """True for a loop: it depends on the way that the variable has come, and the curve is
        over the way since a reversal."""
    @property
    def over(self) -> list[str]:
        """Variables of the port, that of the curve first."""
    @property
    def port(self) -> str:
        """The port, as an effect of one's own names it."""
    @property
    def times(self) -> str:
        """What the curve is multiplied by, an expression over the port's variables."""

class PortPlace(Record):
    """A port of the plant, at a place."""

    @property
    def at(self) -> str:
        """A joint's name, or nothing for the whole cell."""
    @property
    def port(self) -> str:
        """The port, as an effect of one's own names it."""

class LinkMountings(Record):
    """What logs fix of how links are mounted: combinations of the values of `geometry-error`."""

    @property
    def fixed(self) -> list[MountingCombination]:
        """Combinations that they fix, the best known first."""
    @property
    def open(self) -> int:
        """Number of combinations that the logs leave open."""
    @property
    def values(self) -> int:
        """Number of values."""

class MountingCombination(Record):
    """A combination of values, each over its expected deviation."""

    @property
    def deviation(self) -> float | None:
        """Its standard deviation, as a share of the expected one."""
    @property
    def terms(self) -> list[MountingTerm]:
        """Its values, the largest weight first."""
    @property
    def value(self) -> float | None:
        """What it is, in expected deviations."""

class MountingTerm(Record):
    """The part of one value in a combination."""

    @property
    def at(self) -> str:
        ...
    @property
    def parameter(self) -> str:
        ...
    @property
    def weight(self) -> float | None:
        ...

class PlannedExperiment(Record):
    """An experiment to make next."""

    @property
    def kind(self) -> str:
        """Kind of log to record."""
    @property
    def minutes(self) -> float:
        """Time that it takes, minutes."""
    @property
    def reason(self) -> str:
        """Which explanations it separates."""
    @property
    def rows(self) -> list[PlanPoint]:
        """Set points in order."""
    @property
    def separation(self) -> float | None:
        """Expected separation of the first two explanations, standard deviations."""
    @property
    def steps(self) -> list[str]:
        """What to do, in order."""
    @property
    def title(self) -> str:
        """What is done, in a line."""

class PlanPoint(Record):
    """One set point of a planned experiment."""

    @property
    def encoder_rad(self) -> list[float]:
        ...
    @property
    def force_n(self) -> list[float]:
        """Force on the tool, tool axes, N."""
    @property
    def moment_nm(self) -> list[float]:
        """Moment on the tool at its centre point, tool axes, N·m."""
    @property
    def payload_kg(self) -> float:
        ...
    @property
    def t_s(self) -> float:
        ...

class DetectionLimit(Record):
    """The smallest size of an effect that the logs would have shown."""

    @property
    def at(self) -> str:
        ...
    @property
    def effect(self) -> str:
        ...
    @property
    def parameter(self) -> str:
        """The parameter that is its size."""
    @property
    def unit(self) -> str:
        ...
    @property
    def value(self) -> float | None:
        ...

class ConfusablePair(Record):
    """Two effects that the logs hardly tell apart."""

    @property
    def alike(self) -> float | None:
        """Correlation of what they do to the measurements."""
    @property
    def first(self) -> EffectPlace:
        ...
    @property
    def second(self) -> EffectPlace:
        ...
    @property
    def told_apart_from_limit_times(self) -> float | None:
        """From so many times the detection limit on they are told apart."""

class DiagnoseResult(Result):
    """Which physical effect is missing in a model."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def mistakes(self) -> list[FileMistake]:
        """Mistakes in the files; where there are any, nothing else was looked for."""
    @property
    def model(self) -> str:
        """The model file."""
    @property
    def verdict(self) -> str:
        """`adequate`, `effect-found` or `unknown-effect`."""
    @property
    def explained(self) -> str | None:
        """`all` of what was above noise and accuracy, a `part`, or `nothing`."""
    @property
    def sentence(self) -> str:
        """The verdict in words."""
    @property
    def score_before(self) -> float | None:
        """Score of the model as given."""
    @property
    def score_calibrated(self) -> float | None:
        """Score with calibrations alone."""
    @property
    def score_after(self) -> float | None:
        """Score with the best explanation and the calibrations that count."""
    @property
    def errors_before(self) -> list[ChannelErrorFigures]:
        """Errors by channel of the model as given."""
    @property
    def errors_calibrated(self) -> list[ChannelErrorFigures]:
        """The same with calibrations alone, on rows left out of the fit."""
    @property
    def errors_after(self) -> list[ChannelErrorFigures]:
        """The same with the best explanation and the calibrations that count."""
    @property
    def candidates(self) -> list[DiagnosisCandidate]:
        """Explanations that were fitted, most evidence first."""
    @property
    def discovered(self) -> list[DiscoveredLaw]:
        """Laws outside the library that were found; then the score after is with the first of
        them."""
    @property
    def ports_alike(self) -> list[PortPlace]:
        """Ports at which laws outside the library explain the logs about as well, where the
        library's explanations are too uncertain beside them to be named."""
    @property
    def calibration(self) -> list[FittedEffectValues]:
        """Calibrations that are off."""
    @property
    def mountings(self) -> LinkMountings | None:
        """What the logs fix of how links are mounted; null where they see no postures."""
    @property
    def next_experiment(self) -> PlannedExperiment | None:
        """What to record next."""
    @property
    def unexplained(self) -> list[ResidualFinding]:
        """What the residual follows that is left."""
    @property
    def limits(self) -> list[DetectionLimit]:
        """The smallest size of each effect that these logs would have shown."""
    @property
    def confusable(self) -> list[ConfusablePair]:
        """Effects that these logs hardly tell apart."""
    @property
    def undone(self) -> list[str]:
        """What there was no time for, and fits that did not arrive, in words."""
    @property
    def notices(self) -> list[str]:
        """What a reader should know although nothing is wrong."""
    @property
    def registered(self) -> list[RegisteredTracker]:
        """Trackers that stood elsewhere, and were registered first."""

class PlannedStiffnessLoad(Record):
    """A load at a posture."""

    @property
    def force_base_n(self) -> list[float] | None:
        """Largest push, base axes; null for a payload."""
    @property
    def payload_kg(self) -> float | None:
        """Heaviest payload; null for a push."""
    @property
    def posture_deg(self) -> list[float]:
        ...

class ExpectedStiffness(Record):
    """How well the stiffness of a joint will be told."""

    @property
    def at(self) -> str:
        """The joint."""
    @property
    def by_hand_half_share(self) -> float | None:
        """The same of as many loads picked by hand."""
    @property
    def half_share(self) -> float | None:
        """Half of the 95 % interval over the value; null where it is not told."""

class IdentifyPlanResult(Result):
    """Loads that are to tell the stiffness."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def model(self) -> str:
        """The model file."""
    @property
    def out(self) -> str:
        """The protocol that was written."""
    @property
    def sentence(self) -> str:
        """The finding in words."""
    @property
    def loads(self) -> list[PlannedStiffnessLoad]:
        """The loads, in order."""
    @property
    def expected(self) -> list[ExpectedStiffness]:
        """What they tell of each joint."""

class IdentifiedNumber(Record):
    """One number of a file."""

    @property
    def at(self) -> str:
        """The joint it is of; empty for one of the whole cell."""
    @property
    def given(self) -> float | None:
        """The value given; null where there was none."""
    @property
    def high(self) -> float | None:
        """Upper end of the 95 % interval."""
    @property
    def identifiable(self) -> bool:
        """False where the logs do not tell it."""
    @property
    def low(self) -> float | None:
        """Lower end of the 95 % interval."""
    @property
    def name(self) -> str:
        """Its key in the file."""
    @property
    def unit(self) -> str:
        """Unit."""
    @property
    def value(self) -> float:
        """The value found; the one given where the logs do not tell it."""

class StiffnessOverTorque(Record):
    """Stiffness of one joint over its torque."""

    @property
    def at(self) -> str:
        """The joint."""
    @property
    def chance(self) -> float | None:
        """Probability that a linear spring shows as much."""
    @property
    def linear(self) -> bool:
        """Whether the logs leave it possible that the spring is linear."""
    @property
    def origin_nm(self) -> float:
        """Torque that the curve is reckoned from, N·m."""
    @property
    def points(self) -> list[StiffnessPoint]:
        """The points, by torque."""

class StiffnessPoint(Record):
    """One point of it."""

    @property
    def high(self) -> float | None:
        ...
    @property
    def low(self) -> float | None:
        ...
    @property
    def stiffness_nm_rad(self) -> float | None:
        """Secant from the origin."""
    @property
    def torque_nm(self) -> float:
        ...

class IdentifiedMode(Record):
    """A mode of the arm, motors locked."""

    @property
    def damping_ratio(self) -> float:
        """Damping over critical damping."""
    @property
    def decay_1_s(self) -> list[float]:
        """c = (2/T) ln(A₁/A₂) by the tracker alone, 1/s, and its 95 % interval."""
    @property
    def fitted_decay_1_s(self) -> float:
        """c by the identified damping, 1/s."""
    @property
    def log(self) -> str:
        """The ring-down."""
    @property
    def natural_hz(self) -> float:
        """Eigenfrequency of the identified M and K, Hz."""
    @property
    def seen_hz(self) -> list[float]:
        """Damped frequency seen by the tracker, Hz, and its 95 % interval."""
    @property
    def shares(self) -> list[float]:
        """Share of the mode's energy in each joint's spring."""

class DecrementDamping(Record):
    """Damping of a joint by the logarithmic decrements of the modes."""

    @property
    def at(self) -> str:
        ...
    @property
    def high(self) -> float:
        ...
    @property
    def low(self) -> float:
        ...
    @property
    def unit(self) -> str:
        ...
    @property
    def value(self) -> float:
        ...

class WeldSection(Record):
    """A part of a weld."""

    @property
    def lasts_s(self) -> float:
        """How long it is, s."""
    @property
    def log(self) -> str:
        """The log."""
    @property
    def part(self) -> str:
        """`standing`, `feed-change` or `steady`."""
    @property
    def samples(self) -> int:
        """Values compared in it."""
    @property
    def score(self) -> float:
        """√mean((residual/noise)²) of its forces."""

class IdentifyResult(Result):
    """Numbers of a cell that were identified from logs."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def model(self) -> str:
        """The model file."""
    @property
    def target(self) -> str:
        """`stiffness`, `damping` or `process`."""
    @property
    def sentence(self) -> str:
        """The finding in words."""
    @property
    def fits(self) -> bool:
        """False where residuals are well above the noise: something is missing in the model, and
        the intervals do not hold the truth."""
    @property
    def score(self) -> float | None:
        """√mean((residual/noise)²) with the numbers found."""
    @property
    def score_before(self) -> float | None:
        """The same with the numbers given."""
    @property
    def samples(self) -> int:
        """Compared values."""
    @property
    def logs(self) -> list[str]:
        """Names of the logs used."""
    @property
    def left_out(self) -> list[str]:
        """Names of the logs that show nothing of it."""
    @property
    def parameters(self) -> list[IdentifiedNumber]:
        """The numbers."""
    @property
    def correlation(self) -> list[list[float | None]]:
        """Correlation of the numbers' logarithms, in the order of `parameters`, row by row."""
    @property
    def curves(self) -> list[StiffnessOverTorque]:
        """Stiffness over torque."""
    @property
    def modes(self) -> list[IdentifiedMode]:
        """Modes seen in ring-downs."""
    @property
    def decrements(self) -> list[DecrementDamping]:
        """Damping of each joint by the logarithmic decrements alone."""
    @property
    def sections(self) -> list[WeldSection]:
        """How well the forces are met in the parts of every weld."""
    @property
    def notices(self) -> list[str]:
        """What a reader should know although nothing is wrong."""
    @property
    def registered(self) -> list[RegisteredTracker]:
        """Trackers that stood elsewhere, and were registered first."""

class ImportedFile(Record):
    """A file."""

    @property
    def clock(self) -> str | None:
        """Name of its clock; null for the log's own."""
    @property
    def drift(self) -> float | None:
        """Drift that was fitted, s per s."""
    @property
    def offset_s(self) -> float | None:
        """Offset that was fitted, s."""
    @property
    def path(self) -> str:
        """Its path."""
    @property
    def period_s(self) -> float | None:
        """Period of the rows, s."""
    @property
    def rows(self) -> int:
        """Rows that were looked at."""

class ImportedColumn(Record):
    """A column."""

    @property
    def channel(self) -> str | None:
        """The channel; null where it is left out."""
    @property
    def doubts(self) -> list[str]:
        """What is only a guess: channel, unit, sign, factor."""
    @property
    def factor(self) -> float | None:
        """What values are multiplied by."""
    @property
    def file(self) -> str:
        """Path of its file."""
    @property
    def header(self) -> str:
        """Its header."""
    @property
    def left_out(self) -> str | None:
        """Why it is left out; null where it is mapped."""
    @property
    def unit(self) -> str | None:
        """The unit."""

class ImportLogResult(Result):
    """How files of unknown make are proposed to be read."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def out(self) -> str:
        """The `log.toml` that was written."""
    @property
    def kind(self) -> str:
        """What was probably done: a kind of log."""
    @property
    def kind_sure(self) -> bool:
        """Whether only this kind fits, or it was given."""
    @property
    def period_open(self) -> bool:
        """Whether no column is the time of the encoders, so that the period of the rows is to be
        stated."""
    @property
    def missing(self) -> list[str]:
        """Channels that the kind needs and no column is."""
    @property
    def files(self) -> list[ImportedFile]:
        """The files."""
    @property
    def columns(self) -> list[ImportedColumn]:
        """Their columns."""

class FleetUnit(Record):
    """A unit."""

    @property
    def result(self) -> ImproveFleetImproveResult:
        """What `improve` finds of it alone."""
    @property
    def unit(self) -> str:
        """Its name."""

class ImproveFleetImproveResult(Record):
    """A model improved."""

    @property
    def discovered(self) -> list[DiscoveredLaw]:
        """Laws outside the library that were found."""
    @property
    def explained(self) -> str | None:
        """`all` of what was above noise and accuracy, a `part`, or `nothing`."""
    @property
    def held_out(self) -> list[str]:
        """Names of the logs that were held out."""
    @property
    def mistakes(self) -> list[FileMistake]:
        """Mistakes in the files; where there are any, nothing else was looked for."""
    @property
    def model(self) -> str:
        """The model file."""
    @property
    def not_measured(self) -> list[str]:
        """Numbers that were fitted and of which the logs say next to nothing."""
    @property
    def notices(self) -> list[str]:
        """What a reader should know although nothing is wrong."""
    @property
    def out(self) -> str:
        """The improved model file."""
    @property
    def posterior(self) -> list[PosteriorNumber]:
        """What the logs leave open of every number that they measure; their covariance stands in
        the improved model file."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def registered(self) -> list[RegisteredTracker]:
        """Trackers that stood elsewhere, and were registered first."""
    @property
    def rejected(self) -> list[RejectedStep]:
        """Steps that were tried and not kept."""
    @property
    def sentence(self) -> str:
        """The result in words."""
    @property
    def steps(self) -> list[AddedStep]:
        """Steps that were kept, the model as given first."""
    @property
    def undone(self) -> list[str]:
        """What there was no time for, and fits that did not arrive, in words."""
    @property
    def unexplained(self) -> list[ResidualFinding]:
        """What the residual follows that is left."""
    @property
    def verdict(self) -> str:
        """`adequate`, `effect-found` or `unknown-effect`."""

class AddedStep(Record):
    """A step of an improvement."""

    @property
    def added(self) -> list[FittedEffectValues]:
        """Effects that it added."""
    @property
    def calibration(self) -> list[FittedEffectValues]:
        """The calibrations beside them."""
    @property
    def effects(self) -> list[FittedEffectValues]:
        """All effects of the model at this step."""
    @property
    def holdout_errors(self) -> list[ChannelErrorFigures]:
        """Errors there, by channel."""
    @property
    def holdout_score(self) -> float | None:
        """Score where nothing was fitted."""
    @property
    def indistinguishable(self) -> list[EffectPlace]:
        """Effects that the data do not tell from those that it added."""
    @property
    def score(self) -> float | None:
        """Score on the logs fitted."""

class RejectedStep(Record):
    """A step that was not kept."""

    @property
    def added(self) -> list[FittedEffectValues]:
        """Effects that it would have added; none for a recalibration."""
    @property
    def holdout_score(self) -> float | None:
        """Score where nothing was fitted, with it."""
    @property
    def why(self) -> str:
        """Why it was not kept."""

class PosteriorNumber(Record):
    """A number of the cell with its 95 % interval, every calibration free beside it."""

    @property
    def at(self) -> str:
        ...
    @property
    def at_bound(self) -> bool:
        """True where the value is at the bound of what is possible: the interval ends there."""
    @property
    def between_logs(self) -> float:
        """Standard deviation from log to log, in the unit; 0 for a number of the cell."""
    @property
    def effect(self) -> str:
        ...
    @property
    def high(self) -> float:
        ...
    @property
    def low(self) -> float:
        ...
    @property
    def parameter(self) -> str:
        ...
    @property
    def unit(self) -> str:
        ...
    @property
    def value(self) -> float:
        ...

class FleetEffectValues(Record):
    """An effect over all units."""

    @property
    def at(self) -> str:
        """What it is at."""
    @property
    def effect(self) -> str:
        """The effect."""
    @property
    def parameters(self) -> list[FleetParameterValues]:
        """Its parameters."""
    @property
    def shared(self) -> bool:
        """True where every unit has it."""
    @property
    def units(self) -> list[str]:
        """Of each unit: `named` by its own logs, `measured` to be there although they do not
        name it, `absent`, or `unknown`."""

class FleetParameterValues(Record):
    """A parameter over all units."""

    @property
    def mean(self) -> float | None:
        """Mean of the type, by the units that have the effect; null of fewer than two."""
    @property
    def mean_interval(self) -> list[float] | None:
        """95 % interval of the mean."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def spread(self) -> float | None:
        """Standard deviation between units, beyond what their own uncertainty makes."""
    @property
    def spread_interval(self) -> list[float] | None:
        """95 % interval of the spread."""
    @property
    def unit(self) -> str:
        """Unit of all numbers but distance and probability."""
    @property
    def units(self) -> list[FleetValue | None]:
        """Each unit's value; null where its logs say next to nothing of it."""

class FleetValue(Record):
    """A value of a unit, by its own logs alone: not drawn towards the mean of the type."""

    @property
    def distance(self) -> float | None:
        """Distance from the mean of the other units over what it varies by; null of fewer than
        three."""
    @property
    def high(self) -> float:
        ...
    @property
    def low(self) -> float:
        ...
    @property
    def probability(self) -> float | None:
        """Probability that a unit of the type is as far away."""
    @property
    def value(self) -> float:
        ...

class OutlyingUnit(Record):
    """A unit unlike the others."""

    @property
    def reasons(self) -> list[str]:
        """Why."""
    @property
    def unit(self) -> str:
        """Its name."""

class ImproveFleetResult(Result):
    """Units of one type: what each has, and what they share."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def sentence(self) -> str:
        """The result in words."""
    @property
    def units(self) -> list[FleetUnit]:
        """Every unit."""
    @property
    def effects(self) -> list[FleetEffectValues]:
        """Effects that any unit has."""
    @property
    def calibration(self) -> list[FleetEffectValues]:
        """Calibrations of the cell that count in any unit; those that a log or a day has of its
        own stand in each unit's result."""
    @property
    def outliers(self) -> list[OutlyingUnit] | None:
        """Units unlike the others; null of two units, where nothing can say which is the odd
        one."""

class ImproveResult(Result):
    """A model improved."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def mistakes(self) -> list[FileMistake]:
        """Mistakes in the files; where there are any, nothing else was looked for."""
    @property
    def model(self) -> str:
        """The model file."""
    @property
    def out(self) -> str:
        """The improved model file."""
    @property
    def verdict(self) -> str:
        """`adequate`, `effect-found` or `unknown-effect`."""
    @property
    def explained(self) -> str | None:
        """`all` of what was above noise and accuracy, a `part`, or `nothing`."""
    @property
    def sentence(self) -> str:
        """The result in words."""
    @property
    def steps(self) -> list[AddedStep]:
        """Steps that were kept, the model as given first."""
    @property
    def rejected(self) -> list[RejectedStep]:
        """Steps that were tried and not kept."""
    @property
    def discovered(self) -> list[DiscoveredLaw]:
        """Laws outside the library that were found."""
    @property
    def held_out(self) -> list[str]:
        """Names of the logs that were held out."""
    @property
    def unexplained(self) -> list[ResidualFinding]:
        """What the residual follows that is left."""
    @property
    def undone(self) -> list[str]:
        """What there was no time for, and fits that did not arrive, in words."""
    @property
    def posterior(self) -> list[PosteriorNumber]:
        """What the logs leave open of every number that they measure; their covariance stands in
        the improved model file."""
    @property
    def not_measured(self) -> list[str]:
        """Numbers that were fitted and of which the logs say next to nothing."""
    @property
    def notices(self) -> list[str]:
        """What a reader should know although nothing is wrong."""
    @property
    def registered(self) -> list[RegisteredTracker]:
        """Trackers that stood elsewhere, and were registered first."""

class RecordedLog(Record):
    """A log that was recorded."""

    @property
    def kind(self) -> str:
        """What was done."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def rows(self) -> int:
        """Rows."""
    @property
    def time_s(self) -> list[float]:
        """Time of the first row and of the last, s."""

class DetectableEffect(Record):
    """An effect that experiments would show."""

    @property
    def at(self) -> str:
        ...
    @property
    def best_log(self) -> str | None:
        """The experiment that alone would show the smallest; null where it takes several."""
    @property
    def effect(self) -> str:
        ...
    @property
    def parameter(self) -> str:
        """The parameter that is its size."""
    @property
    def unit(self) -> str:
        ...
    @property
    def value(self) -> float | None:
        ...

class PlanResult(Result):
    """What experiments would show of each effect."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def logs(self) -> list[RecordedLog]:
        """The experiments, in the protocol's order."""
    @property
    def shown(self) -> list[DetectableEffect]:
        """Effects that they would show."""
    @property
    def not_shown(self) -> list[EffectPlace]:
        """Effects of which they would show nothing, at any plausible size."""
    @property
    def confusable(self) -> list[ConfusablePair]:
        """Effects that they would hardly tell apart."""

class RecordResult(Result):
    """A campaign that was recorded of a simulated cell."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of; its effects are those of the cell, which the logs' model need
        not have."""
    @property
    def folder(self) -> str:
        """The campaign's folder."""
    @property
    def seed(self) -> int:
        """Seed of everything random."""
    @property
    def logs(self) -> list[RecordedLog]:
        """The logs, in the protocol's order."""

class RegisterResult(Result):
    """Where trackers stand."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def model(self) -> str:
        """The model file."""
    @property
    def trackers(self) -> list[RegisteredTracker]:
        """Every tracker that was found."""

CoreScalar = str

class CoreDifference(Record):
    """A period in which the two cores differ."""

    @property
    def index(self) -> int:
        """Joint from 0, or axis of the correction (three of the rotation, then three of the
        displacement); 0 of a fault."""
    @property
    def output(self) -> CoreOutput:
        """What differs."""
    @property
    def period(self) -> int:
        """The period, from 0."""
    @property
    def readings(self) -> CoreReadings:
        """What the core was given."""
    @property
    def recorded(self) -> float:
        """As recorded: N·m, m or rad; of a fault the status."""
    @property
    def replayed(self) -> float:
        """As computed here, in the same unit; of a fault 1 where there is one, else 0."""
    @property
    def time_s(self) -> float:
        """Its time since the first, s."""

CoreOutput = str

class CoreReadings(Record):
    """What a core was given in a period."""

    @property
    def encoder_rad(self) -> list[float]:
        """Encoder angles, rad."""
    @property
    def encoder_rate_rad_s(self) -> list[float]:
        """Encoder rates, rad/s."""
    @property
    def force_n(self) -> float | None:
        """Push asked for, N; nothing before the force loop is closed."""
    @property
    def measurements(self) -> int:
        """How many measurements came from outside the robot."""
    @property
    def motor_torque_nm(self) -> list[float]:
        """Motor torques, N·m."""
    @property
    def path_m(self) -> float:
        """Path position, m."""
    @property
    def wrench(self) -> list[float]:
        """Force sensor in T: moments, N·m, then forces, N."""

class ReplayResult(Result):
    """A recorded run of a core beside the same core on this machine."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def law(self) -> str:
        """Law of the core."""
    @property
    def digest(self) -> str:
        """SHA-256 of its constants, in hexadecimal digits."""
    @property
    def scalar(self) -> CoreScalar:
        """In what it computed."""
    @property
    def periods(self) -> int:
        """Periods that were compared."""
    @property
    def period_s(self) -> float:
        """Control period, s."""
    @property
    def differing(self) -> int:
        """Periods in which some bit differs."""
    @property
    def first(self) -> CoreDifference | None:
        """The first of them."""
    @property
    def torque_share_max(self) -> float:
        """Largest difference of a torque over the drive's limit, in any period."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""

class StepResponse(Record):
    """One controller's response; "5 %" and overshoot are of the step's height."""

    @property
    def first_within_5pct_s(self) -> float | None:
        """First time within 5 % of the set-point, s."""
    @property
    def limits(self) -> list[LimitSpanResult]:
        """What stood at a limit, the longest first; left out where nothing did."""
    @property
    def name(self) -> str:
        """Name of the controller."""
    @property
    def overshoot(self) -> float:
        """Overshoot as a share of the step."""
    @property
    def ripple_n(self) -> float:
        """Largest departure from that mean, N."""
    @property
    def settle_5pct_s(self) -> float | None:
        """Time from which the push stays within 5 % of the set-point, s."""
    @property
    def static_error_n(self) -> float:
        """Mean push less set-point over the last half second, N."""

class LimitSpanResult(Record):
    """How long something was at a limit."""

    @property
    def first_s(self) -> float:
        """When first, s."""
    @property
    def phase(self) -> str:
        """Where the run was in its program then."""
    @property
    def time_s(self) -> float:
        """For how long, s."""
    @property
    def what(self) -> str:
        """What: `torque of A1`, `force loop`, `compensation` or the fault."""

class StepResult(Result):
    """Responses of the controllers to a step of the push."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def controllers(self) -> list[StepResponse]:
        """Every controller."""

class AllowedFigure(Record):
    """The most, or the least, that a figure may be."""

    @property
    def at_least(self) -> bool:
        """True where it is the least."""
    @property
    def figure(self) -> str:
        """Its key."""
    @property
    def limit(self) -> float:
        """The limit, SI units."""

class ConfirmedPlacement(Record):
    """A placement with its full runs."""

    @property
    def margins(self) -> Mapping[str, float]:
        """The least of every margin of the loop, at both ends and in the middle of every seam,
        SI units."""
    @property
    def statics(self) -> PlacementFigures:
        """By statics."""
    @property
    def welds(self) -> list[ConfirmedWeldResult]:
        """Full runs."""

class PlacementFigures(Record):
    """A placement and what statics have of it."""

    @property
    def deviation_limiting(self) -> str:
        """The figure that takes it."""
    @property
    def deviation_share(self) -> float:
        """The largest share that deviation and tilt take of what they are allowed: what is made
        least where all reserves are kept."""
    @property
    def figures(self) -> Mapping[str, float]:
        """Figures by their keys, the worst of all seams, SI units."""
    @property
    def limiting(self) -> str:
        """The figure that takes it."""
    @property
    def placement(self) -> Placement:
        """Where."""
    @property
    def postures(self) -> list[str]:
        """The arm's posture at every seam."""
    @property
    def share(self) -> float:
        """The largest share of what is allowed."""

class Placement(Record):
    """Where a part is put."""

    @property
    def incline_rad(self) -> float:
        """Turn of the part about the first seam's direction, rad: positive takes the tool axis
        towards y of W."""
    @property
    def roll_rad(self) -> float:
        """Turn of the tool about its own axis, against how the robot's file has it, rad."""
    @property
    def turn_rad(self) -> float:
        """Turn about the vertical through the middle, from where the file has the part, rad."""
    @property
    def x_m(self) -> float:
        """Middle of the seams in B, m."""
    @property
    def y_m(self) -> float:
        """Likewise."""
    @property
    def z_m(self) -> float:
        """Likewise."""

class ConfirmedWeldResult(Record):
    """A full run."""

    @property
    def failed(self) -> str | None:
        """Why there are no figures."""
    @property
    def lateral_max_m(self) -> float | None:
        """Largest lateral deviation, m."""
    @property
    def lateral_rms_m(self) -> float | None:
        """Lateral deviation, RMS, m."""
    @property
    def law(self) -> str:
        """Name of the law."""
    @property
    def limits(self) -> list[str]:
        """What stood at a limit, the longest first."""
    @property
    def longitudinal_max_m(self) -> float | None:
        """Largest deviation along the seam, m."""
    @property
    def met(self) -> bool:
        """Whether it is the weld that was asked for."""
    @property
    def push_envelope_n(self) -> float | None:
        """Largest less smallest push, N."""
    @property
    def seam(self) -> int:
        """Number of the seam, from 1."""
    @property
    def tilt_max_rad(self) -> float | None:
        """Largest tilt, rad."""

class StudyLayoutResult(Result):
    """Where a part is best put, and what it is worth there by full runs."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def allowed(self) -> list[AllowedFigure]:
        """What is allowed."""
    @property
    def placements(self) -> int:
        """Placements of the grid."""
    @property
    def reached(self) -> int:
        """Those that the arm reaches."""
    @property
    def within(self) -> int:
        """Those within all that is allowed."""
    @property
    def filed(self) -> ConfirmedPlacement | None:
        """Where the files have the part; `null` where the arm does not reach it."""
    @property
    def filed_out_of_reach(self) -> str | None:
        """Why it does not."""
    @property
    def chosen(self) -> ConfirmedPlacement:
        """The best placement."""
    @property
    def front_of(self) -> list[str]:
        """Figures that the front is of."""
    @property
    def front(self) -> list[PlacementFigures]:
        """Placements of the grid that no other one is better than in all of them."""

class PlaceLimits(Record):
    """The limits at one place."""

    @property
    def limits(self) -> list[LimitResult]:
        """What was driven."""
    @property
    def placement(self) -> Placement:
        """Where."""

class LimitResult(Record):
    """How far something can be driven."""

    @property
    def because(self) -> str:
        """What limits, in words."""
    @property
    def beyond(self) -> float | None:
        """The value just beyond it that does not; `null` where the whole range keeps them."""
    @property
    def driven(self) -> str:
        """What: `force_n`, `feed_m_s` or `offset_m`."""
    @property
    def kept_again(self) -> float | None:
        """Requirements are kept again at this value beyond the edge."""
    @property
    def largest(self) -> float | None:
        """The largest value that keeps the requirements, SI units; `null` where none looked at
        does."""
    @property
    def nominal(self) -> float:
        """What the weld's file states of it."""
    @property
    def runs(self) -> list[LimitRun]:
        """Every run."""

class LimitRun(Record):
    """One run."""

    @property
    def failed(self) -> str | None:
        """Why there are no figures."""
    @property
    def figure(self) -> str | None:
        """The figure that takes the largest share of its limit."""
    @property
    def limits(self) -> list[str]:
        """What stood at a limit, the longest first."""
    @property
    def share(self) -> float | None:
        """That share; `null` where the run came to no end."""
    @property
    def value(self) -> float:
        """Value of what is driven, SI units."""

class StudyLimitsResult(Result):
    """The largest push, feed and offset that keep requirements, at one place or several."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def length_m(self) -> float:
        """Length that was welded, m."""
    @property
    def places(self) -> list[PlaceLimits]:
        """Place by place, the weld's own first."""
    @property
    def out_of_reach(self) -> int:
        """Places asked for that the arm does not reach."""

class PublishedStatement(Record):
    """A published statement."""

    @property
    def agrees(self) -> bool | None:
        """Whether ours agrees; `null` where nothing measurable is published."""
    @property
    def ours(self) -> str:
        """Ours, in words."""
    @property
    def published(self) -> str:
        """As published, in words."""
    @property
    def tuned(self) -> bool:
        """True where the gains were searched for it, so that it confirms nothing of the model."""
    @property
    def what(self) -> str:
        """What it is of."""

class EnvelopeResult(Record):
    """One weld at one distance."""

    @property
    def collinearity_rad(self) -> float | None:
        """Least angle between the axes of A4 and A6 over the steady part, rad."""
    @property
    def envelope_n(self) -> float | None:
        """Largest less smallest push over the steady part, N."""
    @property
    def failed(self) -> str | None:
        """Why there are no figures."""
    @property
    def lateral_max_m(self) -> float | None:
        """Largest lateral deviation, m."""
    @property
    def limit(self) -> str | None:
        """What stood at a limit for longest; `null` where nothing did."""
    @property
    def weld(self) -> str:
        """`vertical` or `inclined`."""
    @property
    def x_m(self) -> float:
        """Distance of the seam's middle along x of B, m."""

class StudyPaperResult(Result):
    """The published statements beside ours, and the push near collinear axes."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def statements(self) -> list[PublishedStatement]:
        """What is published, and what comes out here."""
    @property
    def envelopes(self) -> list[EnvelopeResult]:
        """Welds at several distances, vertical and inclined."""

class StudyInput(Record):
    """An input of the indices."""

    @property
    def name(self) -> str:
        """Its name."""
    @property
    def numbers(self) -> int:
        """How many numbers it moves together."""

class SensitivityFigure(Record):
    """What one figure depends on."""

    @property
    def derivatives(self) -> list[InputDerivative]:
        """Derivatives, the largest first."""
    @property
    def figure(self) -> str:
        """Its key, the unit at its end."""
    @property
    def indices(self) -> list[InputIndices]:
        """Indices, the largest total first."""
    @property
    def mean(self) -> float | None:
        """Its mean over the cells."""
    @property
    def middle(self) -> float | None:
        """Its value in the cell in the middle of what is not known."""
    @property
    def standard_deviation(self) -> float | None:
        """Its standard deviation over the cells."""

class InputIndices(Record):
    """The indices of one input."""

    @property
    def first(self) -> WithInterval:
        """Share of the variance that the input makes by itself."""
    @property
    def input(self) -> str:
        """The input."""
    @property
    def total(self) -> WithInterval:
        """Share that it makes with all others."""

class WithInterval(Record):
    """A number with its 95 % interval."""

    @property
    def high(self) -> float:
        """Upper end."""
    @property
    def low(self) -> float:
        """Lower end."""
    @property
    def value(self) -> float:
        """As estimated."""

class InputDerivative(Record):
    """The derivative by one input."""

    @property
    def derivative(self) -> Derivative | None:
        """Per standard deviation of the input, in the figure's unit; `null` where a run came to
        no end."""
    @property
    def input(self) -> str:
        """The input."""

class Derivative(Record):
    """The derivative of a figure by an input, per standard deviation of the input, in the
    figure's unit."""

    @property
    def smooth(self) -> bool:
        """Both agree, or the derivative is small beside the figure's largest one."""
    @property
    def value(self) -> float:
        """By the smaller step."""
    @property
    def wider(self) -> float:
        """By the step twice as large."""

class StudySensitivityResult(Result):
    """Derivatives and Sobol indices of a weld's figures by what is not known of a cell."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def length_m(self) -> float:
        """Length that was welded, m."""
    @property
    def seed(self) -> int:
        """Seed of the design."""
    @property
    def rows(self) -> int:
        """Rows of the design that count."""
    @property
    def rows_dropped(self) -> int:
        """Rows left out since one of their runs came to no end."""
    @property
    def runs(self) -> int:
        """Runs of the design."""
    @property
    def inputs(self) -> list[StudyInput]:
        """Inputs of the indices."""
    @property
    def figures(self) -> list[SensitivityFigure]:
        """Figure by figure."""

class TunedControllerResult(Record):
    """A controller with its gains."""

    @property
    def confirmed(self) -> bool:
        """Whether margins, step and weld are as asked."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def overshoot(self) -> float | None:
        """Overshoot over the step's height."""
    @property
    def ratings(self) -> list[RatingResult]:
        """Everything that is asked of it."""
    @property
    def settle_5pct_s(self) -> float | None:
        """Time after which the push stays within 5 % of the step, s."""
    @property
    def static_error_n(self) -> float | None:
        """Mean push less set-point at the end of the step, N."""
    @property
    def weld(self) -> TunedWeld:
        """The weld without compensation."""

class RatingResult(Record):
    """Something that is asked, and what was reached."""

    @property
    def asked(self) -> float:
        """What is asked: of margins the least, of others the most."""
    @property
    def met(self) -> bool:
        """Whether it is met."""
    @property
    def used(self) -> float | None:
        """How much of what is allowed is used up: at most 1 where it is met."""
    @property
    def value(self) -> float | None:
        """What was reached, SI units."""
    @property
    def what(self) -> str:
        """What, where, with the numbers."""

class TunedWeld(Record):
    """A weld with the gains."""

    @property
    def failed(self) -> str | None:
        """Why it was not made."""
    @property
    def lateral_max_m(self) -> float | None:
        """Largest lateral deviation in the steady part, m."""
    @property
    def limits(self) -> list[str]:
        """What stood at a limit."""
    @property
    def push_error_rms_n(self) -> float | None:
        """RMS of the push's error in the steady part, N."""

class TunedLawResult(Record):
    """A law with its gains."""

    @property
    def confirmed(self) -> bool:
        """Whether the margins are kept and the weld is the one that was asked for."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def ratings(self) -> list[RatingResult]:
        """Everything that is asked of it."""
    @property
    def weld(self) -> TunedWeld:
        """The weld."""

class ArmPlace(Record):
    """The arm at one place of the weld."""

    @property
    def correction_m(self) -> float:
        """Correction that the planned load asks for, m."""
    @property
    def correction_rad(self) -> float:
        """The same in orientation, rad."""
    @property
    def mode_rad_s(self) -> float:
        """Lowest natural frequency with the motors locked, rad/s."""
    @property
    def path_m(self) -> float:
        """Path position, m."""
    @property
    def speed(self) -> list[float]:
        """Speed of each joint over what it may do."""
    @property
    def stiffness_n_m(self) -> float:
        """Stiffness that the tool meets along its axis, N/m."""
    @property
    def torque(self) -> list[float]:
        """Torque of each drive over what it may give."""

class TuneResult(Result):
    """Gains that were found for a robot, and what they are worth."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def out(self) -> str:
        """The control file that was written."""
    @property
    def confirmed(self) -> bool:
        """Whether the runs confirm all controllers, and the law that was asked for."""
    @property
    def limits(self) -> list[str]:
        """What limits the loops and the arm, in words."""
    @property
    def step_n(self) -> float:
        """Height of the step of the push, N."""
    @property
    def controllers(self) -> list[TunedControllerResult]:
        """The controllers."""
    @property
    def laws(self) -> list[TunedLawResult]:
        """The laws, on top of the external controller."""
    @property
    def arm(self) -> list[ArmPlace]:
        """The arm along the weld."""

class WeldRunResult(Record):
    """Figures of one weld."""

    @property
    def at_limit_s(self) -> float:
        """Time in the steady part in which a drive stood at its torque or its speed limit, s."""
    @property
    def compensator(self) -> str:
        """Name of the compensation law."""
    @property
    def controller(self) -> str:
        """Name of the hybrid controller."""
    @property
    def depth_m(self) -> Spread:
        """Depth below the plate's surface, m."""
    @property
    def drives(self) -> list[DriveLoad]:
        """What the drives gave in the steady part, A1 to A6."""
    @property
    def first_limit(self) -> FirstLimitResult | None:
        """Where the run first was at a limit or faulted."""
    @property
    def force_n(self) -> ForceFigures:
        """Push on the plate, N."""
    @property
    def half_pin_m(self) -> float:
        """Half the pin's diameter, m: what the lateral deviation is to stay within."""
    @property
    def health(self) -> list[HealthWarningResult]:
        """What the watch beside the law warned of, the first first."""
    @property
    def joint_share(self) -> list[float]:
        """Share of each joint's twist in the lateral deviation, A1 to A6."""
    @property
    def judged(self) -> list[JudgedFigureResult]:
        """Whether it is the weld that was asked for, figure by figure."""
    @property
    def lateral_before_m(self) -> float:
        """Largest lateral deviation before the steady part, m."""
    @property
    def lateral_m(self) -> Spread:
        """Deviation across the seam, m."""
    @property
    def limited_rows(self) -> int:
        """Rows of the recording at a limit or with a fault."""
    @property
    def limits(self) -> list[LimitSpanResult]:
        """What was at a limit, the longest first."""
    @property
    def longitudinal_m(self) -> Spread:
        """Deviation along the seam, m."""
    @property
    def seed(self) -> int:
        """Seed of the sensors' noise."""
    @property
    def simulated_s(self) -> float:
        """Simulated time, s."""
    @property
    def tilt_rad(self) -> Spread:
        """Angle between the real and the nominal tool axis, rad."""
    @property
    def verdict(self) -> str:
        """`pass` where every figure of `judged` is within its tolerance, else `fail`."""
    @property
    def wall_s(self) -> float:
        """Time that the simulation took, s: the only figure that differs between equal runs."""
    @property
    def weld(self) -> str:
        """Name of the weld."""

class Spread(Record):
    """Mean, root mean square and largest magnitude of a signal, in the signal's unit."""

    @property
    def max_abs(self) -> float:
        """Largest magnitude."""
    @property
    def mean(self) -> float:
        """Mean."""
    @property
    def rms(self) -> float:
        """Root mean square about zero."""

class ForceFigures(Record):
    """The push in the steady part."""

    @property
    def envelope(self) -> float:
        """Largest less smallest real push, N: the width of its envelope."""
    @property
    def error_rms(self) -> float:
        """Root mean square of real push less the push asked for, N."""
    @property
    def mean(self) -> float:
        """Mean of the real push, N."""
    @property
    def measured_error_rms(self) -> float:
        """The same of the push that the force sensor reads: what the force loop makes of it."""
    @property
    def reading_error(self) -> float:
        """Mean of the push that the force sensor reads less the mean of the real push, N: what
        is wrong with the sensor."""

class FirstLimitResult(Record):
    """Where a run first was at a limit or faulted, and what was held."""

    @property
    def compensation(self) -> bool:
        """The compensation."""
    @property
    def fault(self) -> str | None:
        """The fault, if there was one."""
    @property
    def force_loop(self) -> bool:
        """What the force loop adds."""
    @property
    def phase(self) -> str:
        """Where the run was in its program."""
    @property
    def time_s(self) -> float:
        """Time, s."""
    @property
    def torque(self) -> bool:
        """The torque of some drive."""

class HealthWarningResult(Record):
    """A warning of the watch beside the law."""

    @property
    def amplitude_n(self) -> float | None:
        """Of a spindle's line: its largest amplitude in the push, N."""
    @property
    def first_s(self) -> float:
        """When first, s."""
    @property
    def frequency_hz(self) -> float | None:
        """Of a drive: the frequency at which it rings, Hz."""
    @property
    def phase(self) -> str:
        """Where the run was in its program then."""
    @property
    def rate_rad_s(self) -> float | None:
        """Of a drive: largest RMS of its rate, rad/s."""
    @property
    def time_s(self) -> float:
        """For how long, s."""
    @property
    def usual_n(self) -> float | None:
        """Of a spindle's line: what was usual, N."""
    @property
    def what(self) -> str:
        """What: `spindle line of order 1 climbs` or `A1 rings`."""

class JudgedFigureResult(Record):
    """A figure of a weld against what it is to be, in the unit of its key."""

    @property
    def expected(self) -> float:
        """What it is to be."""
    @property
    def figure(self) -> str:
        """Key of the figure."""
    @property
    def met(self) -> bool:
        """Whether it is within that."""
    @property
    def tolerance(self) -> float:
        """How far from that it may be."""
    @property
    def value(self) -> float | None:
        """What it came to."""

class FromLogResult(Record):
    """What a simulated weld takes from the log of a real one, and how near its replay comes to
    it."""

    @property
    def check(self) -> ReplayCheckResult:
        """The record beside its simulation."""
    @property
    def control(self) -> str:
        """Control file that it is taken to be recorded under."""
    @property
    def disturbance(self) -> list[AxisDisturbanceResult]:
        """Force on the tool that the model does not explain, along x, y and z of W."""
    @property
    def feeds(self) -> list[list[Any]]:
        """Changes of the feed that the weld file does not state: path position, m, and speed,
        m/s."""
    @property
    def log(self) -> str:
        """Folder of the log."""
    @property
    def spindle_rad_s(self) -> float:
        """Mean speed of the spindle as recorded, rad/s."""
    @property
    def taught_offset_m(self) -> float:
        """How far across the seam the path was taught from where the model teaches it, m."""

class AxisDisturbanceResult(Record):
    """Force on the tool that the model does not explain, along one axis."""

    @property
    def axis(self) -> str:
        """Axis of W."""
    @property
    def noise_n(self) -> float:
        """Root mean square of the noise in it, N."""
    @property
    def rms_n(self) -> float:
        """Root mean square, N."""
    @property
    def taken(self) -> bool:
        """Whether the simulation is disturbed by it."""

class ReplayCheckResult(Record):
    """A recorded weld beside the simulation of the law that it was recorded under."""

    @property
    def compensator(self) -> str:
        """The law."""
    @property
    def lateral_apart_m(self) -> Spread:
        """Recorded less simulated deviation across the seam, m."""
    @property
    def recorded(self) -> TrackFiguresResult:
        """By the log's tracker and force sensor."""
    @property
    def replayed(self) -> TrackFiguresResult:
        """As simulated."""

class TrackFiguresResult(Record):
    """Figures of a recorded weld, or of its simulation at the same places."""

    @property
    def bent_m(self) -> Spread:
        """The deviation less that: what the load bends, m."""
    @property
    def depth_m(self) -> Spread:
        """Depth below the plate's surface, m."""
    @property
    def encoder_lateral_m(self) -> Spread:
        """The same by the encoders alone, as if nothing bent, m: what was commanded, not what it
        became."""
    @property
    def feed_m_s(self) -> float:
        """Mean speed along the seam, m/s."""
    @property
    def lateral_m(self) -> Spread:
        """Deviation across the seam, m."""
    @property
    def push_n(self) -> float:
        """Mean push, N."""

class WeldResult(Result):
    """Figures of welds over their steady part (full feed, full push)."""

    @property
    def schema(self) -> str:
        """Name and version of this format."""
    @property
    def provenance(self) -> Provenance:
        """What the result is of."""
    @property
    def runs(self) -> list[WeldRunResult]:
        """Every run, in the order of the table."""
    @property
    def from_log(self) -> FromLogResult | None:
        """The recorded weld that is made again."""
