//! Fits end where the gradient says so, wherever they start; a diagnosis keeps to its time.

use std::time::Instant;
use trueweld_measure::data::campaign::Campaign;
use trueweld_measure::data::log::Log;
use trueweld_measure::diagnose::{Undone, diagnose};
use trueweld_measure::encoder_noise;
use trueweld_measure::fit::calibration::calibrations;
use trueweld_measure::fit::{Effort, End, FitProblem, FitState, Fitted, blocks_of, fit};
use trueweld_measure::residuals::compare::{baseline, experiments};
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
    let (bench, _) = ready(|name| name == "static");
    let from = |relative: f64, effort: Effort| -> Fitted {
        let mut point = FitState::empty(bench.experiments.len());
        for joint in 0..3 {
            let kind = EffectKind::of("stiffness-error").unwrap();
            let at = Location::Joint(joint);
            point.add(Effect { kind, at, values: vec![relative] });
        }
        fit(&bench, &point, &blocks_of(&bench), &[], effort).unwrap()
    };
    let [below, above] = [-0.2, 0.3].map(|relative| from(relative, Effort::full(0)));
    assert_eq!([below.end, above.end], [End::Arrived; 2]);
    // Both gradients promise less than half a unit more, inflated as the residuals are.
    let trust = below.cost / below.at.iter().map(|p| p.residual.len()).sum::<usize>() as f64;
    assert!((below.cost - above.cost).abs() < trust.max(1.0), "{} {}", below.cost, above.cost);
    assert_eq!(from(0.3, Effort::steps(1, 0)).end, End::Limit);
    let hopeless = Effort { goal: 0.5 * below.cost, ..Effort::full(0) };
    assert_eq!(from(0.3, hopeless).end, End::Hopeless);
}

#[test]
fn a_diagnosis_whose_time_is_up_says_what_it_left_undone() {
    let (mut bench, logs) = ready(|name| name == "static");
    bench.deadline = Some(Instant::now());
    let late = diagnose(&bench, &logs, &|_, _| ()).unwrap();
    assert!(late.candidates.is_empty());
    assert!(late.undone.iter().any(|undone| matches!(undone, Undone::Search)), "{:?}", late.undone);
    // The calibrations stand where nothing is known of them.
    assert_eq!(late.null.point.free.len(), calibrations(&bench).free.len());
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
        let bench = FitProblem::new(&file, experiments(&logs, &baseline(&file)).unwrap());
        let mut point = FitState::empty(logs.len());
        let kind = EffectKind::of("damping-error").unwrap();
        point.add(Effect { kind, at: Location::Joint(2), values: vec![0.0] });
        let fitted = fit(&bench, &point, &blocks_of(&bench), &[], Effort::full(0)).unwrap();
        let prior = &fitted.linear.prior;
        let driven = encoder_noise::covariance(&bench, &logs, &fitted, prior).unwrap()[(0, 0)];
        let white = fitted.linear.solve(None, 0.0, None).unwrap().deviations()[0].powi(2);
        (driven, white)
    };
    let [(none, _), (usual, white), (twice, _)] = [0.0, 1.0, 2.0].map(covariance_at);
    assert_eq!(none, 0.0);
    assert!(usual > 0.5 * white, "{usual} {white}");
    assert!((twice / usual / 4.0 - 1.0).abs() < 0.2, "{twice} {usual}");
}
