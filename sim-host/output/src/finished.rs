//! What a command has found, as words, files, pages and recordings are made of it.

use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;
use trueweld_core::Robot;
use trueweld_diagnose::discover::Discovery;
use trueweld_diagnose::fleet::Fleet;
use trueweld_diagnose::improve::Improvement;
use trueweld_diagnose::{Detectability, Diagnosis, Explanation, ExplanationReason};
use trueweld_estimate::identify::Identification;
use trueweld_estimate::identify::plan::{PlanOptions, StiffnessPlan};
use trueweld_estimate::log_faults::{Found, Registered};
use trueweld_estimate::residuals::compare::{Comparison, LogComparison, Notice};
use trueweld_evaluate::certify::Certificate;
use trueweld_evaluate::laws::{LawComparison, ScenarioSweep};
use trueweld_evaluate::study::{
    Confirmation, EnvelopePoint, FoundLimit, GlobalSensitivity, LayoutTask, LimitStudy,
    LocalSensitivity, OutOfReach, PlacedPart, Placement, RatedPlacement, SensitivityStudy,
    StudyRun,
};
use trueweld_evaluate::tune::{TunedController, TunedLaw, Tuning};
use trueweld_evaluate::{CoreReplay, RecordedRow, ReplayCheck, StepFigures, WeldFigures};
use trueweld_logs::log::Log;
use trueweld_logs::log::import::Proposal;
use trueweld_logs::pair::LogPair;
use trueweld_plant::input::{ModelFile, Posterior, RobotFile};
use trueweld_plant::provenance::Provenance;
use trueweld_plant::simulate::Recording;

/// Figures of welds over their steady part (full feed, full push).
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[schemars(rename = "WeldResult", deny_unknown_fields)]
pub struct WeldReport<'a> {
    /// What the result is of.
    pub provenance: &'a Provenance,
    /// Every run, in the order of the table.
    pub runs: &'a [WeldRun<'a>],
    /// The recorded weld that is made again.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_log: Option<&'a FromLog>,
    /// Factor by which a recording enlarges deviations.
    #[serde(skip)]
    pub exaggeration: f64,
}

/// What a simulated weld takes from the log of a real one, and how near its replay comes to it.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "FromLogResult", deny_unknown_fields)]
pub struct FromLog {
    /// Folder of the log.
    pub log: String,
    /// Control file that it is taken to be recorded under.
    pub control: String,
    /// Mean speed of the spindle as recorded, rad/s.
    pub spindle_rad_s: f64,
    /// Changes of the feed that the weld file does not state: path position, m, and speed, m/s.
    pub feeds: Vec<(f64, f64)>,
    /// How far across the seam the path was taught from where the model teaches it, m.
    pub taught_offset_m: f64,
    /// Force on the tool that the model does not explain, along x, y and z of W.
    pub disturbance: [AxisDisturbance; 3],
    /// The record beside its simulation.
    pub check: ReplayCheck,
    /// What was recorded of the tool, to draw it.
    #[serde(skip)]
    pub rows: Vec<RecordedRow>,
}

/// Force on the tool that the model does not explain, along one axis.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[schemars(rename = "AxisDisturbanceResult", deny_unknown_fields)]
pub struct AxisDisturbance {
    /// Axis of W.
    pub axis: &'static str,
    /// Root mean square, N.
    pub rms_n: f64,
    /// Root mean square of the noise in it, N.
    pub noise_n: f64,
    /// Whether the simulation is disturbed by it.
    pub taken: bool,
}

/// A recorded run of a core beside the same core on this machine.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[schemars(rename = "CoreReplayResult")]
pub struct CoreReplayReport<'a> {
    /// What came out.
    #[serde(flatten)]
    pub replay: &'a CoreReplay,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// Figures of one weld.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[schemars(rename = "WeldRunResult", deny_unknown_fields)]
pub struct WeldRun<'a> {
    /// What the run left behind.
    #[serde(flatten)]
    pub recording: &'a Recording,
    /// Its figures.
    #[serde(flatten)]
    pub figures: &'a WeldFigures,
    /// The robot, to draw it.
    #[serde(skip)]
    pub robot: &'a Robot<f64>,
    /// Simulated time, s.
    simulated_s: f64,
    /// Time that the simulation took, s: the only figure that differs between equal runs.
    wall_s: f64,
}

impl<'a> WeldRun<'a> {
    /// One finished weld, with what it amounts to and the robot that made it.
    pub fn new(recording: &'a Recording, figures: &'a WeldFigures, robot: &'a Robot<f64>) -> Self {
        let (simulated_s, wall_s) = (recording.simulated, recording.wall);
        Self { recording, figures, robot, simulated_s, wall_s }
    }
}

/// Responses of the controllers to a step of the push.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[schemars(rename = "StepResult", deny_unknown_fields)]
pub struct StepReport<'a> {
    /// What the result is of.
    pub provenance: &'a Provenance,
    /// Every controller.
    #[serde(rename = "controllers")]
    pub runs: &'a [StepRun<'a>],
    /// When the set-point steps, s.
    #[serde(skip)]
    pub at: f64,
    /// By how much, N.
    #[serde(skip)]
    pub height: f64,
}

/// One controller's response; "5 %" and overshoot are of the step's height.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[schemars(rename = "StepResponse", deny_unknown_fields)]
pub struct StepRun<'a> {
    /// What the run left behind.
    #[serde(skip)]
    pub recording: &'a Recording,
    /// Its figures.
    #[serde(flatten)]
    pub figures: &'a StepFigures,
}

/// A finished comparison of laws.
#[derive(Debug, Clone, Copy)]
pub struct LawsReport<'a> {
    /// What was compared.
    pub comparison: &'a LawComparison<'a>,
    /// What came out.
    pub sweeps: &'a [ScenarioSweep],
    /// What the lateral deviation is to stay within, RMS, m; `None` where nothing is required.
    pub limit: Option<f64>,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// A finished certification.
#[derive(Debug, Clone)]
pub struct CertifyReport {
    /// What was found.
    pub certificate: Certificate,
    /// Whether the seed was given, in place of the one that follows from the inputs.
    pub seed_given: bool,
    /// What the robot file says of its own numbers, in the comment that it begins with.
    pub robot_grade: String,
    /// The command line that comes to the same.
    pub repeat: String,
}

/// A finished comparison.
#[derive(Debug, Clone, Copy)]
pub struct CompareReport<'a> {
    /// Where the model was read from.
    pub model: &'a Path,
    /// What was found.
    pub comparison: &'a Comparison,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// Two logs that were compared with each other.
#[derive(Debug, Clone, Copy)]
pub struct CompareLogsReport<'a> {
    /// The first and the second log.
    pub logs: &'a [Log; 2],
    /// By how much they differ.
    pub pair: &'a LogPair,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// A finished diagnosis.
#[derive(Clone, Copy)]
pub struct DiagnoseReport<'a> {
    /// The model that was given.
    pub model: &'a ModelFile,
    /// What was found.
    pub diagnosis: &'a Diagnosis,
    /// What is told of it.
    pub explanation: &'a Explanation,
    /// Laws outside the library that were found.
    pub discovered: &'a [Discovery],
    /// The logs under the model as it was given.
    pub before: &'a [LogComparison],
    /// The logs under the model with the best explanation.
    pub after: &'a [LogComparison],
    /// What a person should know besides.
    pub notices: &'a [Notice],
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// A finished improvement.
#[derive(Clone, Copy)]
pub struct ImproveReport<'a> {
    /// The model that was given.
    pub model: &'a ModelFile,
    /// Where the improved model was written.
    pub out: &'a Path,
    /// What was done.
    pub improvement: &'a Improvement,
    /// What the logs leave open of the improved model's numbers; `None` where that was not written.
    pub posterior: Option<&'a Posterior>,
    /// The logs fitted, under the model as it was given.
    pub before: &'a [LogComparison],
    /// The logs fitted, under the improved model.
    pub after: &'a [LogComparison],
    /// The logs held out, under the model as it was given and under the improved one; empty where
    /// stretches of the logs fitted were held out.
    pub held_out: [&'a [LogComparison]; 2],
    /// Why what was found first is believed.
    pub reason: Option<&'a ExplanationReason>,
    /// What a person should know besides.
    pub notices: &'a [Notice],
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// Units of one type, each improved.
#[derive(Clone, Copy)]
pub struct ImproveFleetReport<'a> {
    /// Every unit by its name.
    pub units: &'a [(&'a str, ImproveReport<'a>)],
    /// All of them beside each other.
    pub fleet: &'a Fleet,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

impl ImproveFleetReport<'_> {
    /// The robot of their type.
    pub(crate) fn robot(&self) -> &RobotFile {
        &self.units[0].1.model.robot
    }
}

/// Mistakes that were found.
#[derive(Debug, Clone, Copy)]
pub struct MistakesReport<'a> {
    /// The model that the logs were to be compared with.
    pub model: &'a ModelFile,
    /// What was found.
    pub found: &'a Found,
    /// What the result is of; its command says in which form programs get it.
    pub provenance: &'a Provenance,
}

/// A campaign that was recorded of a simulated cell.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[schemars(rename = "RecordResult", deny_unknown_fields)]
pub struct RecordReport<'a> {
    /// What the result is of; its effects are those of the cell, which the logs' model need not have.
    pub provenance: &'a Provenance,
    /// The campaign's folder.
    pub folder: &'a Path,
    /// Name of the robot.
    #[serde(skip)]
    pub robot: &'a str,
    /// Seed of everything random.
    pub seed: u64,
    /// The logs, in the protocol's order.
    pub logs: &'a [RecordedLog],
}

/// A log that was recorded.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RecordedLog {
    /// Its name.
    pub name: String,
    /// What was done.
    pub kind: &'static str,
    /// Rows.
    pub rows: usize,
    /// Time of the first row and of the last, s.
    pub time_s: [f64; 2],
}

impl RecordedLog {
    /// Of a log as it was read again.
    pub fn of(log: &Log) -> Self {
        let time = &log.samples.time;
        Self {
            name: log.name.clone(),
            kind: log.kind.name(),
            rows: time.len(),
            time_s: [time[0], time[time.len() - 1]],
        }
    }
}

/// What experiments would show, before they are made.
#[derive(Clone, Copy)]
pub struct PlanReport<'a> {
    /// The model of the cell.
    pub model: &'a ModelFile,
    /// The experiments, in the protocol's order.
    pub logs: &'a [RecordedLog],
    /// What they would show.
    pub detectability: &'a Detectability,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// Trackers that were registered.
#[derive(Debug, Clone, Copy)]
pub struct RegisterReport<'a> {
    /// The model whose base and tool they are registered to.
    pub model: &'a ModelFile,
    /// What was found.
    pub registered: &'a [Registered],
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// Numbers of a cell that were identified.
#[derive(Debug, Clone, Copy)]
pub struct IdentifyReport<'a> {
    /// The model as it was given.
    pub model: &'a ModelFile,
    /// What was found.
    pub found: &'a Identification,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// Loads that are to tell the stiffness.
#[derive(Debug, Clone, Copy)]
pub struct StiffnessPlanReport<'a> {
    /// The model of the robot.
    pub model: &'a ModelFile,
    /// The loads.
    pub plan: &'a StiffnessPlan,
    /// What the laboratory has.
    pub options: &'a PlanOptions,
    /// The protocol that is written.
    pub out: &'a Path,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// Gains that were found for a robot.
#[derive(Debug, Clone, Copy)]
pub struct TuneReport<'a> {
    /// The gains, and what they are worth.
    pub tuning: &'a Tuning,
    /// Name of the law that is to be confirmed beside the controllers.
    pub law: &'a str,
    /// The control file that is written.
    pub out: &'a Path,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

impl TuneReport<'_> {
    /// The law that is to be confirmed; `None` where it was not tuned.
    pub fn law(&self) -> Option<&TunedLaw> {
        self.tuning.laws.iter().find(|tuned| tuned.law.name() == self.law)
    }

    /// Whether the runs confirm all controllers and the law.
    pub fn is_confirmed(&self) -> bool {
        let controllers = self.tuning.controllers.iter().all(TunedController::is_confirmed);
        controllers && self.law().is_none_or(TunedLaw::is_confirmed)
    }
}

/// The published study's steps and welds, and welds near collinear axes 4 and 6.
#[derive(Debug, Clone, Copy)]
pub struct StudyPaperReport<'a> {
    /// The published steps, one a controller.
    pub steps: &'a [StepRun<'a>],
    /// When the set-point steps, s.
    pub at: f64,
    /// By how much, N.
    pub height: f64,
    /// The published welds: tool vertical, tool inclined.
    pub welds: &'a [WeldRun<'a>],
    /// Welds at several distances: tool vertical, tool inclined.
    pub envelopes: [&'a [EnvelopePoint]; 2],
    /// Their length, m.
    pub length: f64,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// A finished study of where a part is put.
#[derive(Debug, Clone, Copy)]
pub struct StudyLayoutReport<'a> {
    /// What was asked.
    pub task: &'a LayoutTask<'a>,
    /// Every placement of the family's grid.
    pub grid: &'a [RatedPlacement],
    /// Figures that the front is of, by their places in the table.
    pub front_of: &'a [usize],
    /// Placements of the grid that no other one is better than in all of them.
    pub front: &'a [&'a PlacedPart],
    /// The part where its files have it.
    pub filed: &'a Result<Confirmation, OutOfReach>,
    /// The part where it is best put.
    pub chosen: &'a Confirmation,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// A finished study of how far a weld can be driven.
#[derive(Debug, Clone, Copy)]
pub struct StudyLimitsReport<'a> {
    /// What was asked.
    pub study: &'a LimitStudy<'a>,
    /// Length welded, m.
    pub length: f64,
    /// Place by place, the weld's own first.
    pub places: &'a [LimitsAt],
    /// Places asked for that the arm does not reach.
    pub out_of_reach: usize,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// How far a weld can be driven at one place.
#[derive(Debug, Clone)]
pub struct LimitsAt {
    /// Where.
    pub at: Placement,
    /// What was driven, and how far it can be.
    pub limits: Vec<FoundLimit>,
}

/// A finished study of what a weld's figures depend on.
#[derive(Debug, Clone, Copy)]
pub struct StudySensitivityReport<'a> {
    /// The study.
    pub study: &'a SensitivityStudy<'a>,
    /// Length welded, m.
    pub length: f64,
    /// Every run of the design, in its order.
    pub runs: &'a [StudyRun],
    /// Indices.
    pub global: &'a GlobalSensitivity,
    /// Derivatives.
    pub local: &'a LocalSensitivity,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// How files of unknown make are proposed to be read.
#[derive(Debug, Clone, Copy)]
pub struct ImportReport<'a> {
    /// What is proposed.
    pub proposal: &'a Proposal,
    /// The `log.toml` that says it.
    pub out: &'a Path,
    /// What the result is of.
    pub provenance: &'a Provenance,
}
