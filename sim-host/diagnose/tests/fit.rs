//! Fits end where the gradient says so, wherever they start; a diagnosis keeps to its time.

use std::time::Instant;
use trueweld_diagnose::{Incomplete, diagnose};
use trueweld_estimate::encoder_noise;
use trueweld_estimate::fit::calibration::{calibrations, expected};
use trueweld_estimate::fit::{
    FitProblem, FitState, Fitted, SolverOptions, Termination, blocks_of, chi_square, fit,
};
use trueweld_estimate::residuals::compare::{baseline, experiments};
use trueweld_logs::campaign::Campaign;
use trueweld_logs::log::Log;
use trueweld_plant::effects::{Effect, EffectKind, Location};
use trueweld_plant::input::ModelFile;

/// Some logs of a campaign with play in A5, and the model without it.
fn ready(of: impl Fn(&str) -> bool) -> (FitProblem, Vec<Log>) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/campaigns/backlash");
    let campaign = Campaign::read(folder).unwrap();
    let file = ModelFile::read(&campaign.model).unwrap();
    let logs: Vec<Log> = campaign.logs.into_iter().filter(|log| of(&log.name)).collect();
    let ready = experiments(&logs, &baseline(&file)).unwrap();
    (FitProblem::new(&file, ready), logs)
}

#[test]
fn a_fit_arrives_at_the_same_point_from_either_side() {
    let (problem, _) = ready(|name| name == "static");
    let from = |relative: f64, effort: SolverOptions| -> Fitted {
        let mut point = FitState::empty(problem.logs.len());
        for joint in 0..3 {
            let kind = EffectKind::of("stiffness-error").unwrap();
            let at = Location::Joint(joint);
            point.add(Effect { kind, at, values: vec![relative] });
        }
        fit(&problem, &point, &blocks_of(&problem), &[], effort).unwrap()
    };
    let [below, above] = [-0.2, 0.3].map(|relative| from(relative, SolverOptions::full(0)));
    assert_eq!([below.termination, above.termination], [Termination::Converged; 2]);
    // Both gradients promise less than half a unit more, inflated as the residuals are.
    let trust = below.cost / below.residuals.iter().map(|p| p.residual.len()).sum::<usize>() as f64;
    assert!((below.cost - above.cost).abs() < trust.max(1.0), "{} {}", below.cost, above.cost);
    assert_eq!(from(0.3, SolverOptions::steps(1, 0)).termination, Termination::StepLimit);
    let hopeless = SolverOptions { goal: 0.5 * below.cost, ..SolverOptions::full(0) };
    assert_eq!(from(0.3, hopeless).termination, Termination::Unpromising);
}

/// Static loads of two days of the cell with play in A5, what the tracker saw longer by a share.
fn two_days(longer: [f64; 2]) -> FitProblem {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/campaigns/backlash");
    let days = [(folder.to_owned(), "static"), (format!("{folder}/holdout"), "static-2")];
    let file = ModelFile::read(format!("{folder}/model.toml")).unwrap();
    let mut logs = Vec::new();
    for ((folder, name), longer) in days.iter().zip(longer) {
        let campaign = Campaign::read(folder).unwrap();
        let mut log = campaign.logs.into_iter().find(|log| log.name == *name).unwrap();
        log.samples.position.iter_mut().flatten().for_each(|p| *p *= 1.0 + longer);
        logs.push(log);
    }
    let ready = experiments(&logs, &baseline(&file)).unwrap();
    FitProblem::new(&file, ready)
}

#[test]
fn what_no_other_log_foretells_is_told_by_leaving_logs_out() {
    // Sum of squares as given, and from the other log.
    let squares = |problem: &FitProblem, kind: &str, places: std::ops::Range<usize>| {
        let mut point = FitState::empty(problem.logs.len());
        for joint in places {
            let kind = EffectKind::of(kind).unwrap();
            point.add_expected(kind.neutral(Location::Joint(joint)), &expected(kind));
        }
        let given =
            fit(problem, &point, &blocks_of(problem), &[], SolverOptions::steps(0, 0)).unwrap();
        let fitted =
            fit(problem, &point, &blocks_of(problem), &[], SolverOptions::full(0)).unwrap();
        [chi_square(&given.residuals), fitted.held_out_logs(problem)]
    };
    // A tracker whose scale is another one on either day: links mounted otherwise make up for it in the
    // postures of a day, and for the opposite of it on the next.
    let [given, logs] = squares(&two_days([4e-4, -4e-4]), "geometry-error", 0..6);
    assert!(logs > given, "{given} {logs}");
    // The play of A5 is the cell's.
    let [given, logs] = squares(&two_days([0.0, 0.0]), "backlash", 4..5);
    assert!(logs < 0.5 * given, "{given} {logs}");
}

#[test]
fn a_diagnosis_whose_time_is_up_says_what_it_left_undone() {
    let (mut problem, logs) = ready(|name| name == "static");
    problem.deadline = Some(Instant::now());
    let found = diagnose(&problem, &logs, &|_, _| ()).unwrap();
    let late = &found.diagnosis;
    assert!(late.candidates.is_empty());
    assert!(
        late.incomplete.iter().any(|undone| matches!(undone, Incomplete::Search)),
        "{:?}",
        late.incomplete
    );
    // The calibrations stand where nothing is known of them.
    assert_eq!(found.fits.null.point.free.len(), calibrations(&problem).free.len());
}

#[test]
fn noise_of_the_encoders_counts_with_its_square_and_most_where_an_arm_rings() {
    let covariance_at = |factor: f64| {
        let (_, mut logs) = ready(|name| name.starts_with("ring"));
        for level in logs.iter_mut().flat_map(|log| log.noise.encoder.iter_mut()).flatten() {
            level.deviation *= factor;
        }
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/campaigns/backlash");
        let file = ModelFile::read(format!("{folder}/model.toml")).unwrap();
        let problem = FitProblem::new(&file, experiments(&logs, &baseline(&file)).unwrap());
        let mut point = FitState::empty(logs.len());
        let kind = EffectKind::of("damping-error").unwrap();
        point.add(Effect { kind, at: Location::Joint(2), values: vec![0.0] });
        let fitted =
            fit(&problem, &point, &blocks_of(&problem), &[], SolverOptions::full(0)).unwrap();
        let prior = &fitted.linear.prior;
        let driven = encoder_noise::covariance(&problem, &logs, &fitted, prior).unwrap()[(0, 0)];
        let white = fitted.linear.solve(None, 0.0, None).unwrap().deviations()[0].powi(2);
        (driven, white)
    };
    let [(none, _), (usual, white), (twice, _)] = [0.0, 1.0, 2.0].map(covariance_at);
    assert_eq!(none, 0.0);
    assert!(usual > 0.5 * white, "{usual} {white}");
    assert!((twice / usual / 4.0 - 1.0).abs() < 0.2, "{twice} {usual}");
}
