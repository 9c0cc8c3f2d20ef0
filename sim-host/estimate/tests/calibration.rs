//! What is calibrated is what the logs can show: a sensor that no log has is no parameter of a fit.

use trueweld_estimate::fit::FitProblem;
use trueweld_estimate::fit::calibration::calibrations;
use trueweld_estimate::residuals::compare::{baseline, experiments};
use trueweld_logs::campaign::Campaign;
use trueweld_logs::log::Log;
use trueweld_plant::effects::force_crosstalk;
use trueweld_plant::input::ModelFile;

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
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/campaigns/backlash");
    let campaign = Campaign::read(folder).unwrap();
    let file = ModelFile::read(&campaign.model).unwrap();
    let mut logs: Vec<Log> = campaign
        .logs
        .into_iter()
        .filter(|l| ["static", "free"].contains(&l.name.as_str()))
        .collect();
    let (ids, crosstalk) = tried(&logs, &file);
    assert!(crosstalk && ids.contains(&"force-offset"), "{ids:?}");

    for log in &mut logs {
        (log.samples.force, log.samples.moment) = (None, None);
    }
    let (ids, crosstalk) = tried(&logs, &file);
    assert!(!crosstalk && !ids.contains(&"force-offset"), "{ids:?}");
    assert!(ids.contains(&"tracker-registration") && ids.contains(&"stiffness-error"), "{ids:?}");
}
