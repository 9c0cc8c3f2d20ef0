//! What is calibrated is what the logs can show: a sensor that no log has is no parameter of a fit.

use nalgebra::DVector;
use std::collections::BTreeMap;
use trueweld_estimate::fit::calibration::calibrations;
use trueweld_estimate::fit::{
    FitProblem, SLOPE_STEP, SolverOptions, blocks_of, fit, residuals, slopes, unit,
};
use trueweld_estimate::residuals::compare::{baseline, experiments};
use trueweld_logs::campaign::Campaign;
use trueweld_logs::log::Log;
use trueweld_plant::effects::{Effect, EffectKind, Location, force_crosstalk};
use trueweld_plant::input::{Comments, ModelFile};

/// The model of a recorded campaign, and those of its logs.
fn recorded(names: &[&str]) -> (ModelFile, Vec<Log>) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/campaigns/backlash");
    let campaign = Campaign::read(folder).unwrap();
    let file = ModelFile::read(&campaign.model).unwrap();
    let logs = campaign.logs.into_iter().filter(|log| names.contains(&log.name.as_str()));
    (file, logs.collect())
}

/// Identifiers of the calibrations that are fitted to logs, and whether a cross-talk of the force
/// sensor is tried.
fn tried(logs: &[Log], file: &ModelFile) -> (Vec<&'static str>, bool) {
    let problem = FitProblem::new(file, experiments(logs, &baseline(file)).unwrap());
    let point = calibrations(&problem);
    let ids = point.free.iter().map(|free| point.effect(free.of).kind.id).collect();
    let crosstalk = force_crosstalk::effect([0.01, 0.0]);
    (ids, problem.logs.iter().any(|e| e.concerns(&crosstalk)))
}

#[test]
fn without_a_force_sensor_nothing_of_it_is_fitted_or_looked_for() {
    let (file, mut logs) = recorded(&["static", "free"]);
    let (ids, crosstalk) = tried(&logs, &file);
    assert!(crosstalk && ids.contains(&"force-offset"), "{ids:?}");

    for log in &mut logs {
        (log.samples.force, log.samples.moment) = (None, None);
    }
    let (ids, crosstalk) = tried(&logs, &file);
    assert!(!crosstalk && !ids.contains(&"force-offset"), "{ids:?}");
    assert!(ids.contains(&"tracker-registration") && ids.contains(&"stiffness-error"), "{ids:?}");
}

/// The model of a campaign in which more is known than its file says.
fn with_known(file: &ModelFile, known: &str) -> ModelFile {
    let text = file.to_toml(file.path.parent().unwrap(), &Comments::default()) + known;
    ModelFile::parse(&text, &file.path).unwrap()
}

#[test]
fn what_is_known_without_the_logs_is_not_fitted_and_what_remains_is_known_better() {
    let (file, logs) = recorded(&["static"]);
    let deviation = |file: &ModelFile, id: &str, joint: usize| -> Option<f64> {
        let problem = FitProblem::new(file, experiments(&logs, &baseline(file)).unwrap());
        let blocks = blocks_of(&problem);
        let fitted =
            fit(&problem, &calibrations(&problem), &blocks, &[], SolverOptions::steps(1, 0));
        let fitted = fitted.unwrap();
        let is = |e: &Effect| e.kind.id == id && e.at == Location::Joint(joint);
        let index = fitted.point.free.iter().position(|f| is(fitted.point.effect(f.of)))?;
        let kind = EffectKind::of(id).unwrap();
        Some(
            fitted.linear.solve(None, 0.0, None).unwrap().deviations()[index]
                * unit(&kind.parameters[0], 0.0),
        )
    };
    let zeros = with_known(&file, "\n[[known]]\nid = \"encoder-offset\"\n");
    let one = "\n[[known]]\nid = \"encoder-offset\"\nat = \"A2\"\n\
               deviation = { offset_rad = 1e-6 }\n";
    let one = with_known(&file, one);
    assert!(deviation(&file, "encoder-offset", 0).is_some());
    assert!(deviation(&zeros, "encoder-offset", 0).is_none());
    assert!(deviation(&one, "encoder-offset", 0).is_some());
    let of_a2 = [&file, &one].map(|file| deviation(file, "encoder-offset", 1).unwrap());
    assert!(of_a2[1] <= 1e-6 && of_a2[1] < 0.1 * of_a2[0], "{of_a2:?}");
    let stiffness = [&file, &one, &zeros].map(|f| deviation(f, "stiffness-error", 1).unwrap());
    assert!(stiffness[0] > stiffness[1] && stiffness[1] > stiffness[2], "{stiffness:?}");
}

#[test]
fn slopes_of_calibrations_are_what_residuals_change_by() {
    let (file, logs) = recorded(&["free"]);
    let problem = FitProblem::new(&file, experiments(&logs, &baseline(&file)).unwrap());
    let point = calibrations(&problem);
    let at = residuals(&problem, &point).unwrap();
    let told = slopes(&problem, &point, &point.free, &at, SLOPE_STEP);
    for (k, free) in point.free.iter().enumerate() {
        let beside = |u: f64| {
            let step = DVector::from_fn(point.free.len(), |own, _| if own == k { u } else { 0.0 });
            residuals(&problem, &point.moved(&step)).unwrap().swap_remove(0).residual
        };
        let [above, below] = [0.5, -0.5].map(beside);
        let mut squares = BTreeMap::new();
        for (row, compared) in problem.logs[0].compared.iter().enumerate() {
            let (real, told) =
                (above[row] - below[row], told[k][0].as_ref().map_or(0.0, |s| s[row]));
            let sum: &mut [f64; 2] = squares.entry(compared.quantity).or_default();
            *sum = [sum[0] + real.powi(2), sum[1] + (real - told).powi(2)];
        }
        for (quantity, [real, off]) in squares {
            let effect = point.effect(free.of);
            let share = (off / real.max(1.0)).sqrt();
            assert!(share < 0.1, "{} {:?} {quantity:?}: {share}", effect.kind.id, effect.at);
        }
    }
}
