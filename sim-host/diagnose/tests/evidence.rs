//! The curve that shows an effect, on a campaign that this project did not simulate:
//! `fixtures/campaigns/backlash`, whose README says what is hidden in it.

use trueweld_diagnose::evidence::{EffectCurve, evidence};
use trueweld_estimate::fit::calibration::calibrations;
use trueweld_estimate::fit::{FitProblem, Fitted, SolverOptions, blocks_of, fit};
use trueweld_estimate::residuals::compare::experiments;
use trueweld_logs::campaign::Campaign;
use trueweld_logs::log::Log;
use trueweld_plant::effects::{Effect, EffectKind, Location, LocationKind, Role, library};
use trueweld_plant::input::ModelFile;
use trueweld_plant::robot::Channel;

/// What is hidden: half of the play of A5, rad.
const HALF_GAP: f64 = 2.4e-4;

struct Ready {
    problem: FitProblem,
    logs: Vec<Log>,
    null: Fitted,
}

/// The campaign, or some of its logs, with calibrations fitted in so many steps.
fn ready(of: impl Fn(&str) -> bool, steps: usize) -> Ready {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/campaigns/backlash");
    let campaign = Campaign::read(folder).unwrap();
    let file = ModelFile::read(&campaign.model).unwrap();
    let logs: Vec<Log> = campaign.logs.into_iter().filter(|log| of(&log.name)).collect();
    let ready =
        experiments(&logs, &trueweld_estimate::residuals::compare::baseline(&file)).unwrap();
    let problem = FitProblem::new(&file, ready);
    let point = calibrations(&problem);
    let null =
        fit(&problem, &point, &blocks_of(&problem), &[], SolverOptions::steps(steps, 0)).unwrap();
    Ready { problem, logs, null }
}

/// The fit with an effect beside the calibrations.
fn with(Ready { problem, null, .. }: &Ready, effect: &Effect, steps: usize) -> Option<Fitted> {
    let mut point = null.point.clone();
    point.add(effect.clone());
    let effort = SolverOptions::steps(steps, null.slopes.len());
    fit(problem, &point, &blocks_of(problem), &null.slopes, effort).ok()
}

/// Value of the fitted curve, straight between its points.
fn fitted_at(evidence: &EffectCurve, x: f64) -> f64 {
    let after = evidence.fitted.partition_point(|p| p[0] < x).clamp(1, evidence.fitted.len() - 1);
    let ([x0, y0], [x1, y1]) = (evidence.fitted[after - 1], evidence.fitted[after]);
    y0 + (y1 - y0) * ((x - x0) / (x1 - x0)).clamp(0.0, 1.0)
}

#[test]
fn backlash_shows_as_a_step_of_the_gap_where_the_torque_turns_round() {
    let ready = ready(|_| true, 4);
    let effect = Effect {
        kind: EffectKind::of("backlash").unwrap(),
        at: Location::Joint(4),
        values: vec![1e-4],
    };
    let found = with(&ready, &effect, 5).unwrap();
    let evidence = evidence(&ready.problem, &ready.logs, &ready.null, &found, &effect).unwrap();
    assert_eq!((evidence.x.unit(), evidence.y_unit), ("N·m", "rad"));
    assert!(evidence.points.len() >= 10);

    // The measurements alone, no form assumed: the twist jumps by the whole gap from one side of
    // zero torque to the other. 5 % is what the calibrations beside it leave open.
    let side = |sign: f64| {
        let there = || evidence.points.iter().filter(|p| sign * p.x > 100.0);
        let weight: f64 = there().map(|p| p.error.powi(-2)).sum();
        there().map(|p| p.y * p.error.powi(-2)).sum::<f64>() / weight
    };
    let gap = side(1.0) - side(-1.0);
    assert!((gap - 2.0 * HALF_GAP).abs() < 0.05 * 2.0 * HALF_GAP, "gap of {gap:e}");

    // And the effect's own curve goes through them: what is left is of the size of the errors.
    let apart: Vec<f64> =
        evidence.points.iter().map(|p| (p.y - fitted_at(&evidence, p.x)) / p.error).collect();
    let score = (apart.iter().map(|a| a * a).sum::<f64>() / apart.len() as f64).sqrt();
    assert!(score < 2.0, "points lie {score:.2} errors off the curve: {apart:.1?}");
}

/// An effect of one small step of each of its sizes.
fn of_some_size(kind: &'static EffectKind) -> Effect {
    let at = match kind.place {
        LocationKind::Joint => Location::Joint(4),
        LocationKind::Channel => Location::Channel(Channel::Tracker),
        LocationKind::Cell => Location::Cell,
    };
    let value = |p: &trueweld_plant::effects::Parameter| match p.role {
        Role::Size { step, neutral } => neutral + step,
        Role::PathPosition => 0.08,
        _ => p.neutral(),
    };
    Effect { kind, at, values: kind.parameters.iter().map(value).collect() }
}

#[test]
fn every_effect_has_its_curve() {
    let ready = ready(|name| ["static", "ring-14", "free", "weld-1"].contains(&name), 1);
    for kind in library() {
        let effect = of_some_size(kind);
        let Some(found) = with(&ready, &effect, 0) else { panic!("{} cannot be driven", kind.id) };
        match evidence(&ready.problem, &ready.logs, &ready.null, &found, &effect) {
            Some(evidence) => {
                let finite = |p: &[f64; 2]| p[0].is_finite() && p[1].is_finite();
                assert!(
                    evidence.points.len() > 1 && evidence.fitted.iter().all(finite),
                    "{}",
                    kind.id
                );
                assert!(
                    evidence.points.iter().all(|p| p.y.is_finite() && p.error > 0.0),
                    "{}",
                    kind.id
                );
            }
            // The cell has no second encoders.
            None => assert!(kind.id.starts_with("link-encoder"), "{} shows nothing", kind.id),
        }
    }
}
