//! Simulated welds, force steps and laws; and the check of input files.

use super::finite;
use crate::{LawsReport, StepReport, WeldReport, WeldRun};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_compensators::Entry;
use trueweld_evaluate::laws::{NoFigures, ScenarioChange, ScenarioSweep, VariedQuantity};
use trueweld_evaluate::{DriveLoad, FirstLimit, ForceFigures, JudgedFigure, Spread, WeldFigures};
use trueweld_plant::provenance::Provenance;
use trueweld_plant::simulate::{HealthWarning, HealthWarningKind, LimitSpan, Recording};

/// Figures of welds over their steady part (full feed, full push).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeldResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "weld-result/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// Every run, in the order of the table.
    pub runs: Vec<WeldRunResult>,
}

/// Figures of one weld.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeldRunResult {
    /// Name of the weld.
    pub weld: String,
    /// Name of the hybrid controller.
    pub controller: String,
    /// Name of the compensation law.
    pub compensator: String,
    /// Seed of the sensors' noise.
    pub seed: u64,
    /// Deviation across the seam, m.
    pub lateral_m: Spread,
    /// Deviation along the seam, m.
    pub longitudinal_m: Spread,
    /// Depth below the plate's surface, m.
    pub depth_m: Spread,
    /// Angle between the real and the nominal tool axis, rad.
    pub tilt_rad: Spread,
    /// Push on the plate, N.
    pub force_n: ForceFigures,
    /// Share of each joint's twist in the lateral deviation, A1 to A6.
    pub joint_share: Vec<f64>,
    /// Half the pin's diameter, m: what the lateral deviation is to stay within.
    pub half_pin_m: f64,
    /// Largest lateral deviation before the steady part, m.
    pub lateral_before_m: f64,
    /// Rows of the recording at a limit or with a fault.
    pub limited_rows: usize,
    /// Where the run first was at a limit or faulted.
    pub first_limit: Option<FirstLimitResult>,
    /// What was at a limit, the longest first.
    pub limits: Vec<LimitSpanResult>,
    /// What the drives gave in the steady part, A1 to A6.
    pub drives: Vec<DriveLoad>,
    /// Time in the steady part in which a drive stood at its torque or its speed limit, s.
    pub at_limit_s: f64,
    /// What the watch beside the law warned of, the first first.
    pub health: Vec<HealthWarningResult>,
    /// `pass` where every figure of `judged` is within its tolerance, else `fail`.
    pub verdict: String,
    /// Whether it is the weld that was asked for, figure by figure.
    pub judged: Vec<JudgedFigureResult>,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// Time that the simulation took, s: the only figure that differs between equal runs.
    pub wall_s: f64,
}

/// Where a run first was at a limit or faulted, and what was held.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FirstLimitResult {
    /// Time, s.
    pub time_s: f64,
    /// Where the run was in its program.
    pub phase: String,
    /// The torque of some drive.
    pub torque: bool,
    /// What the force loop adds.
    pub force_loop: bool,
    /// The compensation.
    pub compensation: bool,
    /// The fault, if there was one.
    pub fault: Option<String>,
}

/// How long something was at a limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitSpanResult {
    /// What: `torque of A1`, `force loop`, `compensation` or the fault.
    pub what: String,
    /// For how long, s.
    pub time_s: f64,
    /// When first, s.
    pub first_s: f64,
    /// Where the run was in its program then.
    pub phase: String,
}

/// A warning of the watch beside the law.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HealthWarningResult {
    /// What: `spindle line of order 1 climbs` or `A1 rings`.
    pub what: String,
    /// When first, s.
    pub first_s: f64,
    /// Where the run was in its program then.
    pub phase: String,
    /// For how long, s.
    pub time_s: f64,
    /// Of a spindle's line: its largest amplitude in the push, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_n: Option<f64>,
    /// Of a spindle's line: what was usual, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub usual_n: Option<f64>,
    /// Of a drive: largest RMS of its rate, rad/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_rad_s: Option<f64>,
    /// Of a drive: the frequency at which it rings, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
}

/// A figure of a weld against what it is to be, in the unit of its key.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JudgedFigureResult {
    /// Key of the figure.
    pub figure: String,
    /// What it came to.
    pub value: Option<f64>,
    /// What it is to be.
    pub expected: f64,
    /// How far from that it may be.
    pub tolerance: f64,
    /// Whether it is within that.
    pub met: bool,
}

impl WeldResult {
    pub(crate) fn of(report: &WeldReport<'_>) -> Self {
        Self {
            schema: "weld-result/1".to_owned(),
            provenance: report.provenance.clone(),
            runs: report.runs.iter().map(WeldRunResult::of).collect(),
        }
    }
}

impl WeldRunResult {
    fn of(run: &WeldRun) -> Self {
        let WeldRun { recording, figures, .. } = run;
        Self {
            weld: recording.weld.clone(),
            controller: recording.controller.to_owned(),
            compensator: recording.compensator.clone(),
            seed: recording.seed,
            lateral_m: figures.lateral,
            longitudinal_m: figures.longitudinal,
            depth_m: figures.depth,
            tilt_rad: figures.tilt,
            force_n: figures.force,
            joint_share: figures.joint_share.as_slice().to_vec(),
            half_pin_m: recording.half_pin,
            lateral_before_m: figures.lateral_before,
            limited_rows: figures.limited_rows,
            first_limit: figures.first_limit.map(FirstLimitResult::of),
            limits: LimitSpanResult::all(&figures.limits, recording),
            drives: figures.drives.to_vec(),
            at_limit_s: figures.at_limit,
            health: HealthWarningResult::all(figures, recording),
            verdict: if figures.is_met() { "pass" } else { "fail" }.to_owned(),
            judged: figures.judged.iter().map(JudgedFigureResult::of).collect(),
            simulated_s: recording.simulated,
            wall_s: recording.wall,
        }
    }
}

impl LimitSpanResult {
    fn all(limits: &[LimitSpan], recording: &Recording) -> Vec<Self> {
        let of = |span: &LimitSpan| Self {
            what: span.kind.to_string(),
            time_s: span.rows as f64 * recording.period,
            first_s: span.first,
            phase: span.phase.name().to_owned(),
        };
        limits.iter().map(of).collect()
    }
}

impl HealthWarningResult {
    fn all(figures: &WeldFigures, recording: &Recording) -> Vec<Self> {
        let of = |warning: &HealthWarning| {
            let [line, drive] = match warning.kind {
                HealthWarningKind::SpindleLine { amplitude, usual, .. } => {
                    [Some([amplitude, usual]), None]
                }
                HealthWarningKind::Ringing { rate, frequency, .. } => {
                    [None, Some([rate, frequency])]
                }
            };
            Self {
                what: warning.kind.to_string(),
                first_s: warning.first,
                phase: warning.phase.name().to_owned(),
                time_s: warning.rows as f64 * recording.period,
                amplitude_n: line.map(|[amplitude, _]| amplitude),
                usual_n: line.map(|[_, usual]| usual),
                rate_rad_s: drive.map(|[rate, _]| rate),
                frequency_hz: drive.map(|[_, frequency]| frequency),
            }
        };
        figures.health.iter().map(of).collect()
    }
}

impl FirstLimitResult {
    fn of(first: FirstLimit) -> Self {
        Self {
            time_s: first.time,
            phase: first.phase.name().to_owned(),
            torque: first.limited.torque,
            force_loop: first.limited.force_loop,
            compensation: first.limited.compensation,
            fault: first.fault.map(|fault| format!("{fault:?}")),
        }
    }
}

impl JudgedFigureResult {
    fn of(judged: &JudgedFigure) -> Self {
        Self {
            figure: judged.figure.key.to_owned(),
            value: finite(judged.value),
            expected: judged.expected,
            tolerance: judged.tolerance,
            met: judged.is_met(),
        }
    }
}

/// Responses of the controllers to a step of the push.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StepResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "step-result/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// Every controller.
    pub controllers: Vec<StepResponse>,
}

/// One controller's response; "5 %" and overshoot are of the step's height.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StepResponse {
    /// Name of the controller.
    pub name: String,
    /// First time within 5 % of the set-point, s.
    pub first_within_5pct_s: Option<f64>,
    /// Time from which the push stays within 5 % of the set-point, s.
    pub settle_5pct_s: Option<f64>,
    /// Overshoot as a share of the step.
    pub overshoot: f64,
    /// Mean push less set-point over the last half second, N.
    pub static_error_n: f64,
    /// Largest departure from that mean, N.
    pub ripple_n: f64,
    /// What stood at a limit, the longest first; left out where nothing did.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<LimitSpanResult>,
}

impl StepResult {
    pub(crate) fn of(report: &StepReport<'_>) -> Self {
        let controllers = report.runs.iter().map(|run| StepResponse {
            name: run.figures.controller.to_owned(),
            first_within_5pct_s: run.figures.first_within_5pct,
            settle_5pct_s: run.figures.settle_5pct,
            overshoot: run.figures.overshoot,
            static_error_n: run.figures.static_error,
            ripple_n: run.figures.ripple,
            limits: LimitSpanResult::all(&run.figures.limits, run.recording),
        });
        Self {
            schema: "step-result/1".to_owned(),
            provenance: report.provenance.clone(),
            controllers: controllers.collect(),
        }
    }
}

/// Compensation laws on one weld, over a wrong stiffness, noise, delay and lost sensors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LawsResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "compare-laws/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// Name of the weld.
    pub weld: String,
    /// Name of the hybrid controller.
    pub controller: String,
    /// Seed of the sensors' noise.
    pub seed: u64,
    /// Control period, s.
    pub control_period_s: f64,
    /// Error of the believed stiffness in the sweeps of something else, as a share.
    pub stiffness_error_where_not_varied: f64,
    /// What the lateral deviation is to stay within, RMS, m.
    pub lateral_rms_limit_m: Option<f64>,
    /// The laws, in the order of all results.
    pub laws: Vec<ComparedLaw>,
    /// What was varied, one quantity after the other.
    pub sweeps: Vec<LawSweep>,
}

/// A law and how often it welds the seam before it counts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparedLaw {
    /// Name of the law.
    pub name: String,
    /// Welds of the seam; the last one counts.
    pub passes: usize,
}

/// All laws over one varied quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LawSweep {
    /// Key of the quantity in the points.
    pub varied: String,
    /// Every law's points.
    pub results: Vec<LawPoints>,
}

/// One law over one varied quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LawPoints {
    /// Name of the law.
    pub law: String,
    /// One weld a value of the quantity.
    pub points: Vec<LawPoint>,
}

/// One weld: its figures or why it has none, and the value of what was varied.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LawPoint {
    /// Lateral deviation, RMS, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral_rms_m: Option<f64>,
    /// Lateral deviation, largest, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral_max_m: Option<f64>,
    /// Tilt across the seam, RMS, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub side_tilt_rms_rad: Option<f64>,
    /// Tilt along the seam, RMS, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub travel_angle_rms_rad: Option<f64>,
    /// Why the weld was not made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
    /// Error of the believed stiffness, as a share.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness_error: Option<f64>,
    /// Factor on the noise of force and seam sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_factor: Option<f64>,
    /// Delay of force and seam sensor, control periods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_periods: Option<f64>,
    /// Share of the seam sensor's readings that are lost.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost_share: Option<f64>,
    /// Whether they are lost in the last pass alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub only_in_last_pass: Option<bool>,
    /// Whether the force sensor dies half-way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_sensor_dies: Option<bool>,
}

impl LawsResult {
    pub(crate) fn of(report: &LawsReport<'_>) -> Self {
        let comparison = report.comparison;
        let scenario = &comparison.scenario;
        let law = |law: &Entry| ComparedLaw {
            name: law.name().to_owned(),
            passes: comparison.passes_of(law),
        };
        let sweep = |sweep: &ScenarioSweep| {
            let changes = sweep.quantity.changes();
            let laws = comparison.laws.iter().zip(&sweep.points);
            let results = laws.map(|(law, points)| LawPoints {
                law: law.name().to_owned(),
                points: changes.iter().zip(points).map(|(c, p)| LawPoint::of(*c, p)).collect(),
            });
            LawSweep { varied: key(sweep.quantity).to_owned(), results: results.collect() }
        };
        Self {
            schema: "compare-laws/1".to_owned(),
            provenance: report.provenance.clone(),
            weld: scenario.name.to_owned(),
            controller: scenario.controller.name().to_owned(),
            seed: scenario.seed,
            control_period_s: scenario.control.period,
            stiffness_error_where_not_varied: comparison.stiffness_error,
            lateral_rms_limit_m: report.limit,
            laws: comparison.laws.iter().map(law).collect(),
            sweeps: report.sweeps.iter().map(sweep).collect(),
        }
    }
}

impl LawPoint {
    fn of(change: ScenarioChange, point: &Result<WeldFigures, NoFigures>) -> Self {
        let figure = |of: fn(&WeldFigures) -> f64| point.as_ref().ok().map(of);
        let figures = Self {
            lateral_rms_m: figure(|f| f.lateral.rms),
            lateral_max_m: figure(|f| f.lateral.max_abs),
            side_tilt_rms_rad: figure(|f| f.side_tilt.rms),
            travel_angle_rms_rad: figure(|f| f.travel_angle.rms),
            failed: point.as_ref().err().map(ToString::to_string),
            ..Self::default()
        };
        let lost = |share: f64, last: bool, force: bool| Self {
            lost_share: Some(share),
            only_in_last_pass: Some(last),
            force_sensor_dies: Some(force),
            ..figures.clone()
        };
        match change {
            ScenarioChange::StiffnessError(error) => {
                Self { stiffness_error: Some(error), ..figures }
            }
            ScenarioChange::Noise(factor) => Self { noise_factor: Some(factor), ..figures },
            ScenarioChange::Delay(periods) => Self { delay_periods: Some(periods), ..figures },
            ScenarioChange::Lost(share) => lost(share, false, false),
            ScenarioChange::DeadInLastPass => lost(1.0, true, false),
            ScenarioChange::ForceSensorDies => lost(0.0, false, true),
        }
    }
}

/// The quantity's key in the points.
fn key(quantity: VariedQuantity) -> &'static str {
    match quantity {
        VariedQuantity::StiffnessError => "stiffness_error",
        VariedQuantity::Noise => "noise_factor",
        VariedQuantity::Delay => "delay_periods",
        VariedQuantity::Lost => "lost_share",
    }
}

/// Which input files are in order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CheckResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "check/1"))]
    pub schema: String,
    /// Every file, in the order given.
    pub files: Vec<CheckedFile>,
}

impl CheckResult {
    /// Of these files.
    pub fn new(files: Vec<CheckedFile>) -> Self {
        Self { schema: "check/1".to_owned(), files }
    }
}

/// One input file: of which kind it is, or what is wrong with it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CheckedFile {
    /// The path as it was given.
    pub file: String,
    /// Whether it is in order.
    pub ok: bool,
    /// Its kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// What is wrong with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// What a reader should know of it: how a log was read, and values that are implausible.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notices: Vec<String>,
}
