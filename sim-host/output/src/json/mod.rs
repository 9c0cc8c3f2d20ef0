//! Results for programs: a type for each file, read as it is written. SI units, units in the keys.
//!
//! What does not exist (a time that was never reached, a bound that the data do not give) is
//! `null`. The schemas of all files are in `docs/schema`; [`schemas`] makes them.

mod certify;
mod compare;
mod diagnose;
mod discover;
mod effects;
mod identify;
mod import;
mod improve;
mod mistake;
mod mistakes;
mod mountings;
mod record;
mod register;
mod simulation;
mod study;
mod tune;

pub use certify::{
    BoughtByMeasurement, CertifyResult, DrawnFigure, DriveEvidence, FaultRun, JudgedRequirement,
    LoopMargins, LoopPassivity, MarginPlace, MeasurementRecord, TrialFigures, UncertainRecord,
    UnfinishedTrial, WeldEvidence, WorstCell,
};
pub use compare::{
    CompareResult, ComparedChannel, ComparedLog, ResidualCurve, ResidualFinding, ResidualMapAxis,
    ResidualMapData,
};
pub use diagnose::{
    ConfusablePair, DetectionLimit, DiagnoseResult, DiagnosisCandidate, PlanPoint,
    PlannedExperiment,
};
pub use discover::{DiscoveredCurve, DiscoveredLaw, DiscoveredPlace};
pub use effects::{EffectCurveData, EffectPlace, FittedEffectValues, FittedValue};
pub use identify::{
    DecrementDamping, ExpectedStiffness, IdentifiedMode, IdentifiedNumber, IdentifyResult,
    PlannedStiffnessLoad, StiffnessOverTorque, StiffnessPlanResult, StiffnessPoint, WeldSection,
};
pub use import::{ImportResult, ImportedColumn, ImportedFile};
pub use improve::{AddedStep, ImproveResult, PosteriorNumber, RejectedStep};
pub use mistake::{FileMistake, MistakeEvidence};
pub use mistakes::MistakesResult;
pub use mountings::{LinkMountings, MountingCombination, MountingTerm};
pub use record::{RecordResult, RecordedLog};
pub use register::{RegisterResult, RegisteredPose, RegisteredTracker};
pub use simulation::{
    CheckResult, CheckedFile, ComparedLaw, FirstLimitResult, JudgedFigureResult, LawPoint,
    LawPoints, LawSweep, LawsResult, LimitSpanResult, StepResponse, StepResult, WeldResult,
    WeldRunResult,
};
pub use study::{
    AllowedFigure, ConfirmedPlacement, ConfirmedWeldResult, EnvelopeResult, InputDerivative,
    InputIndices, LimitResult, LimitRun, PlaceLimits, PlacementFigures, PublishedStatement,
    SensitivityFigure, StudyInput, StudyLayoutResult, StudyLimitsResult, StudyPaperResult,
    StudySensitivityResult,
};
pub use tune::{
    ArmPlace, RatingResult, TuneResult, TunedControllerResult, TunedLawResult, TunedWeld,
};

use schemars::{JsonSchema, Schema, schema_for};
use serde::Serialize;

/// The name of every schema, which a file has as its `schema`, without its version; and the schema.
pub fn schemas() -> Vec<(&'static str, Schema)> {
    fn of<T: JsonSchema>(name: &'static str) -> (&'static str, Schema) {
        (name, schema_for!(T))
    }
    vec![
        of::<WeldResult>("weld-result"),
        of::<StepResult>("step-result"),
        of::<LawsResult>("compare-laws"),
        of::<CertifyResult>("certify"),
        of::<TuneResult>("tune"),
        of::<StudyLayoutResult>("study-layout"),
        of::<StudyLimitsResult>("study-limits"),
        of::<StudyPaperResult>("study-paper"),
        of::<StudySensitivityResult>("study-sensitivity"),
        of::<CompareResult>("compare"),
        of::<DiagnoseResult>("diagnose"),
        of::<ImproveResult>("improve"),
        of::<RecordResult>("record"),
        of::<RegisterResult>("register"),
        of::<ImportResult>("import-log"),
        of::<IdentifyResult>("identify"),
        of::<StiffnessPlanResult>("identify-plan"),
        of::<CheckResult>("check"),
    ]
}

/// The text of a file.
pub fn text(result: &impl Serialize) -> String {
    let text = serde_json::to_string_pretty(result);
    text.expect("numbers, texts and lists are written as JSON") + "\n"
}

/// A number that JSON can hold: `None` for what is infinite or no number.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
