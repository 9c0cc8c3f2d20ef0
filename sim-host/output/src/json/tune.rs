//! Gains for a robot.

use super::{finite, result};
use crate::TuneReport;
use crate::text::tune::{criterion, limits};
use trueweld_evaluate::ArmAt;
use trueweld_evaluate::tune::{Rating, TunedController, TunedLaw, WeldOutcome};
use trueweld_plant::provenance::Provenance;
use trueweld_plant::simulate::LimitKind;

result! {
    /// Gains that were found for a robot, and what they are worth.
    TuneResult of (report: &TuneReport<'_>) with {
        let tuning = report.tuning;
    } {
        /// What the result is of.
        provenance: Provenance = report.provenance.clone(),
        /// The control file that was written.
        out: String = report.out.display().to_string(),
        /// Whether the runs confirm all controllers, and the law that was asked for.
        confirmed: bool = report.is_confirmed(),
        /// What limits the loops and the arm, in words.
        limits: Vec<String> = limits(report),
        /// Height of the step of the push, N.
        step_n: f64 = tuning.response.height,
        /// The controllers.
        controllers: Vec<TunedControllerResult> =
            tuning.controllers.iter().map(TunedControllerResult::of).collect(),
        /// The laws, on top of the external controller.
        laws: Vec<TunedLawResult> = tuning.laws.iter().map(TunedLawResult::of).collect(),
        /// The arm along the weld.
        arm: Vec<ArmAt> = tuning.arm.clone(),
    }
}

result! {
    /// A controller with its gains.
    TunedControllerResult of (tuned: &TunedController) with {
        let step = tuned.step.as_ref();
    } {
        /// Its name.
        name: &'static str = tuned.controller.name(),
        /// Whether margins, step and weld are as asked.
        confirmed: bool = tuned.is_confirmed(),
        /// Time after which the push stays within 5 % of the step, s.
        settle_5pct_s: Option<f64> = step.and_then(|step| step.settle_5pct_s),
        /// Overshoot over the step's height.
        overshoot: Option<f64> = step.map(|step| step.overshoot),
        /// Mean push less set-point at the end of the step, N.
        static_error_n: Option<f64> = step.map(|step| step.static_error_n),
        /// Everything that is asked of it.
        ratings: Vec<RatingResult> = tuned.ratings().map(RatingResult::of).collect(),
        /// The weld without compensation.
        weld: TunedWeld = TunedWeld::of(&tuned.weld),
    }
}

result! {
    /// A law with its gains.
    TunedLawResult of (tuned: &TunedLaw) {
        /// Its name.
        name: String = tuned.law.name().to_owned(),
        /// Whether the margins are kept and the weld is the one that was asked for.
        confirmed: bool = tuned.is_confirmed(),
        /// Everything that is asked of it.
        ratings: Vec<RatingResult> = tuned.margins.iter().map(RatingResult::of).collect(),
        /// The weld.
        weld: TunedWeld = TunedWeld::of(&tuned.weld),
    }
}

result! {
    /// Something that is asked, and what was reached.
    RatingResult of (rating: &Rating) {
        /// What, where, with the numbers.
        what: String = criterion(rating),
        /// What was reached, SI units.
        value: Option<f64> = finite(rating.value),
        /// What is asked: of margins the least, of others the most.
        asked: f64 = rating.asked,
        /// How much of what is allowed is used up: at most 1 where it is met.
        used: Option<f64> = finite(rating.used),
        /// Whether it is met.
        met: bool = rating.is_met(),
    }
}

result! {
    /// A weld with the gains.
    TunedWeld of (weld: &WeldOutcome) with {
        let figures = weld.as_ref().ok();
        let limits = figures.map_or(&[][..], |figures| &figures.limits);
    } {
        /// Largest lateral deviation in the steady part, m.
        lateral_max_m: Option<f64> = figures.and_then(|f| finite(f.lateral.max_abs)),
        /// RMS of the push's error in the steady part, N.
        push_error_rms_n: Option<f64> = figures.and_then(|f| finite(f.force.error_rms)),
        /// What stood at a limit.
        limits: Vec<LimitKind> = limits.iter().map(|span| span.kind).collect(),
        /// Why it was not made.
        failed: Option<String> = weld.as_ref().err().cloned(),
    }
}
