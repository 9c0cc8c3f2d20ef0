//! Gains for a robot.

use super::finite;
use crate::TuneReport;
use crate::words::tune::{limits, told};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_evaluate::ArmAt;
use trueweld_evaluate::tune::{Rating, TunedController, TunedLaw, WeldOutcome};
use trueweld_plant::provenance::Provenance;

/// Gains that were found for a robot, and what they are worth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TuneResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "tune/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// The control file that was written.
    pub out: String,
    /// Whether the runs confirm all controllers, and the law that was asked for.
    pub confirmed: bool,
    /// What limits the loops and the arm, in words.
    pub limits: Vec<String>,
    /// Height of the step of the push, N.
    pub step_n: f64,
    /// The controllers.
    pub controllers: Vec<TunedControllerResult>,
    /// The laws, on top of the external controller.
    pub laws: Vec<TunedLawResult>,
    /// The arm along the weld.
    pub arm: Vec<ArmPlace>,
}

/// A controller with its gains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TunedControllerResult {
    /// Its name.
    pub name: String,
    /// Whether margins, step and weld are as asked.
    pub confirmed: bool,
    /// Time after which the push stays within 5 % of the step, s.
    pub settle_5pct_s: Option<f64>,
    /// Overshoot over the step's height.
    pub overshoot: Option<f64>,
    /// Mean push less set-point at the end of the step, N.
    pub static_error_n: Option<f64>,
    /// Everything that is asked of it.
    pub ratings: Vec<RatingResult>,
    /// The weld without compensation.
    pub weld: TunedWeld,
}

/// A law with its gains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TunedLawResult {
    /// Its name.
    pub name: String,
    /// Whether the margins are kept and the weld is the one that was asked for.
    pub confirmed: bool,
    /// Everything that is asked of it.
    pub ratings: Vec<RatingResult>,
    /// The weld.
    pub weld: TunedWeld,
}

/// Something that is asked, and what was reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RatingResult {
    /// What, where, with the numbers.
    pub what: String,
    /// What was reached, SI units.
    pub value: Option<f64>,
    /// What is asked: of margins the least, of others the most.
    pub asked: f64,
    /// How much of what is allowed is used up: at most 1 where it is met.
    pub used: Option<f64>,
    /// Whether it is met.
    pub met: bool,
}

/// A weld with the gains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TunedWeld {
    /// Largest lateral deviation in the steady part, m.
    pub lateral_max_m: Option<f64>,
    /// RMS of the push's error in the steady part, N.
    pub push_error_rms_n: Option<f64>,
    /// What stood at a limit.
    pub limits: Vec<String>,
    /// Why it was not made.
    pub failed: Option<String>,
}

/// The arm at one place of the weld.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmPlace {
    /// Path position, m.
    pub path_m: f64,
    /// Lowest natural frequency with the motors locked, rad/s.
    pub mode_rad_s: f64,
    /// Stiffness that the tool meets along its axis, N/m.
    pub stiffness_n_m: f64,
    /// Torque of each drive over what it may give.
    pub torque: Vec<f64>,
    /// Speed of each joint over what it may do.
    pub speed: Vec<f64>,
    /// Correction that the planned load asks for, m.
    pub correction_m: f64,
    /// The same in orientation, rad.
    pub correction_rad: f64,
}

impl TuneResult {
    pub(crate) fn of(report: &TuneReport<'_>) -> Self {
        let tuning = report.tuning;
        Self {
            schema: "tune/1".to_owned(),
            provenance: report.provenance.clone(),
            out: report.out.display().to_string(),
            confirmed: report.is_confirmed(),
            limits: limits(report),
            step_n: tuning.response.height,
            controllers: tuning.controllers.iter().map(TunedControllerResult::of).collect(),
            laws: tuning.laws.iter().map(TunedLawResult::of).collect(),
            arm: tuning.arm.iter().map(ArmPlace::of).collect(),
        }
    }
}

impl TunedControllerResult {
    fn of(tuned: &TunedController) -> Self {
        let step = tuned.step.as_ref();
        Self {
            name: tuned.controller.name().to_owned(),
            confirmed: tuned.is_confirmed(),
            settle_5pct_s: step.and_then(|step| step.settle_5pct),
            overshoot: step.map(|step| step.overshoot),
            static_error_n: step.map(|step| step.static_error),
            ratings: tuned.ratings().map(RatingResult::of).collect(),
            weld: TunedWeld::of(&tuned.weld),
        }
    }
}

impl TunedLawResult {
    fn of(tuned: &TunedLaw) -> Self {
        Self {
            name: tuned.law.name().to_owned(),
            confirmed: tuned.is_confirmed(),
            ratings: tuned.margins.iter().map(RatingResult::of).collect(),
            weld: TunedWeld::of(&tuned.weld),
        }
    }
}

impl RatingResult {
    fn of(rating: &Rating) -> Self {
        Self {
            what: told(rating),
            value: finite(rating.value),
            asked: rating.asked,
            used: finite(rating.used),
            met: rating.is_met(),
        }
    }
}

impl TunedWeld {
    fn of(weld: &WeldOutcome) -> Self {
        let figures = weld.as_ref().ok();
        let limits = figures.map_or(&[][..], |figures| &figures.limits);
        Self {
            lateral_max_m: figures.and_then(|figures| finite(figures.lateral.max_abs)),
            push_error_rms_n: figures.and_then(|figures| finite(figures.force.error_rms)),
            limits: limits.iter().map(|span| span.kind.to_string()).collect(),
            failed: weld.as_ref().err().cloned(),
        }
    }
}

impl ArmPlace {
    fn of(at: &ArmAt) -> Self {
        Self {
            path_m: at.path,
            mode_rad_s: at.mode,
            stiffness_n_m: at.stiffness,
            torque: at.torque.as_slice().to_vec(),
            speed: at.speed.as_slice().to_vec(),
            correction_m: at.correction[0],
            correction_rad: at.correction[1],
        }
    }
}
