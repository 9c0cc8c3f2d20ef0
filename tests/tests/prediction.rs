//! What a model predicts of a log: the truth is at the noise floor, and what a changed effect has
//! no say in stays as it was.

use std::collections::BTreeMap;
use std::slice;
use trueweld_diagnose::{DiagnosisVerdict, diagnose};
use trueweld_estimate::predict::{ComparedQuantity, Prediction, PreparedLog};
use trueweld_laboratory::{Protocol, Recipe, effect};
use trueweld_logs::log::LogKind;
use trueweld_plant::effects::{Effect, Location, Role, library};
use trueweld_tests::LABORATORY;
use trueweld_tests::corpus::{Ready, ready};

fn campaign(hidden: Option<Effect>) -> Ready {
    let recipe = Recipe { protocol: Protocol::short(), ..Recipe::plain(21) };
    ready(&hidden.into_iter().fold(recipe, Recipe::with_effect)).expect("the campaign is made")
}

/// Welds alone, of a seam this long, m, without a flaw: `noise` as a share of the usual one.
fn clean_welds(noise: f64, welds: usize, seam: f64) -> Ready {
    let protocol = Protocol { postures: 0, rings: 0, free: 0.0, welds, seam, ..Protocol::short() };
    ready(&Recipe { protocol, noise, ..Recipe::plain(77) }).expect("the campaign is made")
}

/// Play in A1, which carries no weight: between two pushes its gap is open.
fn play() -> Effect {
    effect("backlash", Location::Joint(0), &[1.5e-4])
}

/// Of the noise: frames that tilt change where swinging links start by a little.
const LITTLE: f64 = 0.01;

/// Predictions of all logs under a model with these effects.
fn predicted(ready: &Ready, effects: &[Effect]) -> Vec<Prediction> {
    let problem = &ready.problem;
    problem
        .logs
        .iter()
        .map(|e| e.predict(&problem.model, effects, None).expect("it can be driven"))
        .collect()
}

#[test]
fn the_truth_is_at_the_floor_where_a_gap_stands_open() {
    let ready = campaign(Some(play()));
    for (experiment, prediction) in ready.problem.logs.iter().zip(predicted(&ready, &[play()])) {
        let all = prediction.residual.len() as f64;
        let far = prediction.residual.iter().filter(|r| r.abs() > 3.5).count() as f64;
        assert!(
            far < 0.01 * all,
            "{}: {far} of {all} values far from where they were measured",
            experiment.name
        );
        // The moment in which a weld's push closes the gap swings, and a weld's pose is predicted
        // at rest.
        if experiment.kind == LogKind::Weld {
            continue;
        }
        for (channel, score) in scores(experiment, &prediction) {
            assert!(score < 1.15, "{}, {channel}: {score}", experiment.name);
        }
    }
}

/// Scores of the quantities of a log, by their channel.
fn scores(experiment: &PreparedLog, prediction: &Prediction) -> BTreeMap<&'static str, f64> {
    let mut squares: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for (c, r) in experiment.compared.iter().zip(&prediction.residual) {
        let (sum, count) = squares.entry(c.quantity.channel()).or_default();
        *sum += r * r;
        *count += 1.0;
    }
    squares.into_iter().map(|(channel, (sum, count))| (channel, (sum / count).sqrt())).collect()
}

#[test]
fn loads_at_rest_are_predicted_to_a_fiftieth_of_the_noise() {
    // Loads of 6 kN from row to row: the tool turns by two milliradians between them.
    let protocol = Protocol { rings: 0, free: 0.0, welds: 0, ..Protocol::usual() };
    let recipe = Recipe { protocol, noise: 0.02, ..Recipe::plain(5) };
    let ready = ready(&recipe).expect("the campaign is made");
    let predictions = predicted(&ready, &[]);
    for (channel, score) in scores(&ready.problem.logs[0], &predictions[0]) {
        assert!(score < 1.2, "{channel}: {score}");
    }
}

#[test]
fn a_tool_that_hangs_free_in_a_gap_is_where_it_was_seen() {
    // A6 turns about the tool's axis: only its rotation shows where in the gap its link lies.
    let play = effect("backlash", Location::Joint(5), &[2.5e-4]);
    let ready = campaign(Some(play.clone()));
    let predictions = predicted(&ready, slice::from_ref(&play));
    for (experiment, prediction) in ready.problem.logs.iter().zip(&predictions) {
        for (channel, score) in scores(experiment, prediction) {
            assert!(score < 1.3, "{} {channel}: {score}", experiment.name);
        }
    }
    let found = diagnose(&ready.problem, &ready.logs, &|_, _| {}).expect("diagnosed").diagnosis;
    let effects = &found.candidates[0].effects;
    let named: Vec<_> = effects.iter().map(|f| (f.effect.kind.id, f.effect.at)).collect();
    assert_eq!(
        (found.verdict, &named[..]),
        (DiagnosisVerdict::EffectFound, &[("backlash", play.at)][..])
    );
    assert!((effects[0].effect.values[0] / play.values[0] - 1.0).abs() < 0.1, "{effects:?}");
}

/// Scores of the columns of the slow force under the truth, in welds with three times the usual noise: as
/// weighed, and over the noise that the model makes.
fn scores_of_force(hidden: &Effect) -> [[f64; 2]; 3] {
    let mut sums = [[0.0; 3]; 3];
    for seed in [1, 2, 3] {
        let protocol = Protocol { postures: 0, rings: 0, free: 0.0, ..Protocol::usual() };
        let recipe = Recipe { protocol, noise: 3.0, ..Recipe::plain(seed) };
        let ready = ready(&recipe.with_effect(hidden.clone())).expect("the campaign is made");
        let problem = &ready.problem;
        for (experiment, at) in problem.logs.iter().zip(predicted(&ready, slice::from_ref(hidden)))
        {
            let own = at.in_own_noise();
            for ((c, r), own) in experiment.compared.iter().zip(&at.residual).zip(own.iter()) {
                if c.quantity == ComparedQuantity::Force {
                    let sum = &mut sums[usize::from(c.component)];
                    [r * r, own * own, 1.0].iter().zip(sum).for_each(|(one, sum)| *sum += one);
                }
            }
        }
    }
    sums.map(|[as_weighed, own, count]| [as_weighed, own].map(|s| (s / count).sqrt()))
}

#[test]
fn a_firm_plate_makes_as_much_more_of_the_tracker_s_noise_as_is_said() {
    let scores = scores_of_force(&effect("process-stiffness-error", Location::Cell, &[2.45]));
    assert!(scores[2][0] > 1.7, "{scores:?}");
    assert!(scores.iter().all(|[_, own]| (0.8..1.2).contains(own)), "{scores:?}");
}

#[test]
fn a_sensor_that_reads_less_reads_as_much_less_of_the_tracker_s_noise_as_is_said() {
    let scores = scores_of_force(&effect("force-scale", Location::Cell, &[-0.3]));
    let [as_weighed, own] = scores[2];
    assert!(as_weighed < 0.9 && (0.9..1.1).contains(&own), "{scores:?}");
}

/// A ripple of the model's own shakes the tool, which takes a part of the drag away: 130 N in their mean, of
/// 15 N of noise.
#[test]
fn a_ripple_that_the_model_has_takes_from_the_drag_what_it_shakes_the_tool_by() {
    let values = [4.0, 0.14, 0.37, -1.4];
    let ripple = effect("spindle-harmonic", Location::Cell, &values);
    let (mut sums, mut counts) = ([0.0; 3], [0.0; 3]);
    for seed in [1, 2, 3] {
        let protocol = Protocol { postures: 0, rings: 0, free: 0.0, ..Protocol::usual() };
        let recipe = Recipe { protocol, noise: 3.0, ..Recipe::plain(seed) };
        let ready = ready(&recipe.with_effect(ripple.clone())).expect("the campaign is made");
        let predictions = predicted(&ready, slice::from_ref(&ripple));
        for (experiment, at) in ready.problem.logs.iter().zip(&predictions) {
            for (c, r) in experiment.compared.iter().zip(at.in_own_noise().iter()) {
                if c.quantity == ComparedQuantity::Force {
                    sums[usize::from(c.component)] += r * r;
                    counts[usize::from(c.component)] += 1.0;
                }
            }
        }
    }
    let scores = [0, 1, 2].map(|c| f64::sqrt(sums[c] / counts[c]));
    assert!(scores.iter().all(|score| *score < 1.3), "{scores:?}");
}

/// A campaign with friction in a gear that carries the arm, and what the truth leaves of it: score of
/// each channel of each log.
fn left_where_a_gear_remembers() -> Vec<(LogKind, &'static str, f64)> {
    let loop_of_a3 = effect("hysteresis", Location::Joint(2), &[1677.0, 8e-5]);
    let ready = ready(&Recipe::plain(7).with_effect(loop_of_a3.clone())).expect("it is made");
    let predictions = predicted(&ready, &[loop_of_a3]);
    let of_log = |(experiment, prediction): (&PreparedLog, &Prediction)| {
        let kind = experiment.kind;
        scores(experiment, prediction).into_iter().map(move |(channel, s)| (kind, channel, s))
    };
    ready.problem.logs.iter().zip(&predictions).flat_map(of_log).collect()
}

#[test]
fn noise_hardly_makes_a_gear_forget() {
    // Its loop is 200 µrad high: a hundredth of it is six times the noise of a second encoder.
    for (kind, channel, score) in left_where_a_gear_remembers() {
        let most = match (kind, channel) {
            (LogKind::FreeMotion, "link_encoder") => 7.0,
            (LogKind::FreeMotion | LogKind::Weld, "tcp_position") => 2.2,
            _ => 1.5,
        };
        assert!(score < most, "{} {channel}: {score}", kind.name());
    }
}

#[test]
#[ignore = "fails: what noise is left in a free motion and in a weld's push still turns a gear round a little"]
fn the_truth_is_at_the_floor_where_a_gear_remembers() {
    for (kind, channel, score) in left_where_a_gear_remembers() {
        assert!(score < 1.5, "{} {channel}: {score}", kind.name());
    }
}

#[test]
fn a_prediction_beside_another_is_the_same_as_by_itself() {
    let ready = campaign(None);
    for known in [Vec::new(), vec![play()]] {
        let before = predicted(&ready, &known);
        for (kind, seed) in library().flat_map(|kind| (1..=4).map(move |seed| (kind, seed))) {
            // What files leave open is not drawn.
            let at_a_joint = || {
                let at = Location::Joint(seed as usize);
                let mut effect = kind.neutral(at);
                for (value, parameter) in effect.values.iter_mut().zip(kind.parameters) {
                    if let Role::Size { step, .. } = parameter.role {
                        *value += 2.0 * step;
                    }
                }
                effect
            };
            let drawn = LABORATORY.draw(kind.id, 1.0, &Protocol::short(), seed);
            let added = drawn.unwrap_or_else(at_a_joint);
            let effects = [known.clone(), vec![added.clone()]].concat();
            let alone = predicted(&ready, &effects);
            for ((experiment, at), alone) in ready.problem.logs.iter().zip(&before).zip(&alone) {
                let beside = experiment.predict(&ready.problem.model, &effects, Some((at, &added)));
                let beside = beside.expect("it can be driven");
                let apart = beside
                    .residual
                    .iter()
                    .zip(&alone.residual)
                    .map(|(a, b)| (a - b).abs())
                    .fold(0.0, f64::max);
                assert!(
                    apart < LITTLE,
                    "{}, {} beside {known:?}: {apart}",
                    experiment.name,
                    kind.id
                );
            }
        }
    }
}

#[test]
fn a_joint_that_sticks_does_not_fit_clean_welds_better() {
    // It would keep from the pose what noise of the moment makes its gear twist by.
    let ready = clean_welds(1.0, 4, 0.3);
    let sticks = effect("hysteresis", Location::Joint(5), &[1e4, 1e-5]);
    let squares = |effects: &[Effect]| -> f64 {
        let residuals = predicted(&ready, effects).into_iter().flat_map(|at| at.residual);
        residuals.map(|r| r * r).sum()
    };
    let fall = squares(&[]) - squares(&[sticks]);
    assert!(fall < 4.0, "{fall}");
}

/// Means over each weld of the first two lines of the force: what was measured, and what a model with
/// these effects leaves of it, N.
fn lines_of_force(ready: &Ready, effects: &[Effect]) -> Vec<[f64; 2]> {
    let mut means = Vec::new();
    for (experiment, prediction) in ready.problem.logs.iter().zip(predicted(ready, effects)) {
        let mut lines: BTreeMap<(u8, u8, bool), [f64; 3]> = BTreeMap::new();
        for (c, r) in experiment.compared.iter().zip(&prediction.residual) {
            if let ComparedQuantity::Ripple { order: order @ (1 | 2), sine } = c.quantity {
                let sums = lines.entry((order, c.component, sine)).or_default();
                let values = [c.measured, r * c.deviation, 1.0];
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            }
        }
        assert_eq!(lines.len(), 12, "{}: two orders, three directions", experiment.name);
        for (line, [measured, left, n]) in lines {
            println!(
                "{} {line:?}: {:.2} N, {:.2} N are left",
                experiment.name,
                measured / n,
                left / n
            );
            means.push([measured / n, left / n]);
        }
    }
    means
}

#[test]
fn the_force_at_the_spindle_s_orders_is_predicted() {
    // The laboratory integrates a weld in steps of 0.5 ms, and its motors hold their torque for 12
    // ms, which no encoder shows: some tenths of a newton, of 50 N and more.
    const LEFT: f64 = 0.5;
    let means = lines_of_force(&clean_welds(1e-3, 2, 0.05), &[]);
    assert!(means.iter().any(|[measured, _]| measured.abs() > 10.0), "{means:?}");
    for [measured, left] in means {
        assert!(left.abs() < LEFT, "{left} N of {measured}");
    }
}

#[test]
fn a_gear_that_remembers_is_stiffer_at_the_spindle_s_orders() {
    // Its slope is taken for the one that a motion far smaller than its loop has.
    const LEFT: f64 = 0.6;
    let hidden = effect("hysteresis", Location::Joint(1), &[2400.0, 1e-4]);
    let protocol =
        Protocol { postures: 0, rings: 0, free: 0.0, welds: 2, seam: 0.05, ..Protocol::short() };
    let recipe = Recipe { protocol, noise: 1e-3, ..Recipe::plain(77) }.with_effect(hidden.clone());
    let ready = ready(&recipe).expect("the campaign is made");
    let power = |means: &[[f64; 2]]| means.iter().map(|[_, left]| left * left).sum::<f64>();
    let [without, with] =
        [&[][..], &[hidden]].map(|effects| power(&lines_of_force(&ready, effects)));
    assert!(with < LEFT * LEFT * without, "{} N left of {} N", with.sqrt(), without.sqrt());
}

#[test]
fn quiet_instruments_find_no_effect_in_a_clean_weld() {
    // At a tenth of the noise a pose is seen to a micrometre, which links that stand under their
    // load miss: that may be said, but it has no name.
    for (noise, expected) in [
        (0.3, &[DiagnosisVerdict::Adequate][..]),
        (0.1, &[DiagnosisVerdict::Adequate, DiagnosisVerdict::UnknownEffect]),
    ] {
        let ready = clean_welds(noise, 1, 0.02);
        let found = diagnose(&ready.problem, &ready.logs, &|_, _| {}).expect("diagnosed").diagnosis;
        let named: Vec<_> = found.candidates.iter().map(|c| c.effects[0].effect.kind.id).collect();
        assert!(expected.contains(&found.verdict), "at {noise} times the noise: {named:?}");
    }
}

#[test]
fn what_is_left_of_each_direction_of_the_slow_force_is_as_large_as_its_noise() {
    let ready = clean_welds(1.0, 2, 0.2);
    for (experiment, prediction) in ready.problem.logs.iter().zip(predicted(&ready, &[])) {
        for direction in 0..3 {
            let of_it = experiment.compared.iter().zip(&prediction.residual);
            let of_it = of_it.filter(|(compared, _)| {
                compared.quantity == ComparedQuantity::Force && compared.component == direction
            });
            let left: Vec<f64> = of_it.map(|(_, left)| *left).collect();
            let mean = left.iter().map(|r| r * r).sum::<f64>() / left.len() as f64;
            println!("{} {direction}: {mean:.3} of {}", experiment.name, left.len());
            // Over twelve welds it is 0.5 to 1.95. A noise that is taken twice, or goes with a push
            // that was not measured, makes 6 and more.
            assert!((0.3..2.5).contains(&mean), "{} {direction}: {mean}", experiment.name);
        }
    }
}
