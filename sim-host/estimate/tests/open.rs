//! What files leave open: factors of currents, the force in the plane, drives and rotors that no data
//! sheet holds. It is found, fitted or left out, and never taken for physics.

use crate::dirty::{changed, fixture, model, toml};
use trueweld_core::JOINTS;
use trueweld_estimate::fit::calibration::calibrations;
use trueweld_estimate::fit::{FitProblem, FitState, SolverOptions, blocks_of, fit};
use trueweld_estimate::log_faults::find;
use trueweld_estimate::predict::{ComparedQuantity, is_open_factor};
use trueweld_estimate::residuals::compare::{baseline, experiments};
use trueweld_logs::log::{Log, LogNotice};
use trueweld_plant::effects::{Effect, EffectKind, Location};
use trueweld_plant::input::{InputFile, ModelEffect, ModelFile, RobotFile, Scope};

/// The torque of a unit of each joint's current, N·m.
const FACTORS: [f64; JOINTS] = [58.0, -61.5, 40.25, 12.5, 9.75, 8.0];

/// The free motion with its torques as currents whose factors are not stated; of A6 noise alone.
fn currents() -> Log {
    currents_in("A")
}

fn currents_in(unit: &str) -> Log {
    let columns: String = (1..=6)
        .map(|i| format!("\"tm{i}_nm\" = {{ channel = \"tm{i}\", unit = \"{unit}\" }}\n"))
        .collect();
    let text = format!("{}\n[columns]\n{columns}", toml("free"));
    changed("free", &text, &mut |name, k, value| {
        let joint = name.strip_prefix("tm").and_then(|rest| rest[..1].parse::<usize>().ok());
        Some(match joint {
            Some(6) => ((k * 7919) % 101) as f64 / 101.0 - 0.5,
            Some(joint) => value / FACTORS[joint - 1],
            None => value,
        })
    })
}

#[test]
fn factors_of_currents_are_found_and_fitted_with_their_intervals() {
    let (mut logs, model) = ([currents()], model());
    let found = find(&mut logs, &baseline(&model)).unwrap();
    assert!(found.mistakes.is_empty(), "{:?}", found.mistakes);
    let of = |notice: &LogNotice| match notice {
        LogNotice::FactorsFound(found) => found.clone(),
        _ => Vec::new(),
    };
    let factors: Vec<_> = logs[0].notices.iter().flat_map(of).collect();
    assert_eq!(factors.len(), 5);
    for (found, factor) in factors.iter().zip(FACTORS) {
        let interval = found.interval.unwrap();
        // Twice the interval: one in twenty is beyond it.
        assert!((found.factor - factor).abs() < 2.0 * interval, "{found:?}, {factor}");
        // Where all of it is friction, it is known as friction is: to half.
        assert!(interval < factor.abs(), "{found:?}");
    }
    let unknown = LogNotice::FactorUnknown { column: "tm6_nm", unit: "A" };
    assert!(logs[0].notices.contains(&unknown), "{:?}", logs[0].notices);
    assert!(logs[0].samples.motor_torque[5].is_none());

    // What they are off by is fitted, with all other calibrations beside it.
    let problem = FitProblem::new(&model, experiments(&logs, &baseline(&model)).unwrap());
    let point = calibrations(&problem);
    let fitted = fit(&problem, &point, &blocks_of(&problem), &[], SolverOptions::full(0)).unwrap();
    let constants = fitted.point.shared.iter().filter(|effect| is_open_factor(effect.kind));
    let constants: Vec<&Effect> = constants.collect();
    assert_eq!(constants.len(), 5);
    for (effect, factor) in constants.iter().zip(FACTORS) {
        let [k, off] = effect.values[..] else { panic!("{effect:?}") };
        // The recorder's 40 N·m and the model's stiffness leave a few per cent of the smallest.
        assert!((k * (1.0 + off) / factor - 1.0).abs() < 0.05, "{effect:?}, {factor}");
    }
}

#[test]
fn a_current_in_another_unit_than_the_first_log_s_is_left_out_and_told() {
    let mut logs = [currents(), currents_in("%")];
    find(&mut logs, &baseline(&model())).unwrap();
    assert!(logs[0].samples.motor_torque[..5].iter().all(Option::is_some));
    assert!(logs[1].samples.motor_torque.iter().all(Option::is_none));
    let other = LogNotice::FactorOfAnotherUnit { column: "tm1_nm", unit: "%", other: "A" };
    assert!(logs[1].notices.contains(&other), "{:?}", logs[1].notices);
    // Of A6 neither shows its factor.
    let unknown = LogNotice::FactorUnknown { column: "tm6_nm", unit: "%" };
    assert!(logs[1].notices.contains(&unknown), "{:?}", logs[1].notices);
}

#[test]
fn a_factor_that_the_model_states_is_taken() {
    let kind = EffectKind::of("torque-constant").unwrap();
    let mut given = model();
    let effect = Effect { kind, at: Location::Joint(0), values: vec![1.25 * FACTORS[0], 0.0] };
    given.effects.push(ModelEffect { effect, scope: Scope::Campaign });
    let mut logs = [currents()];
    find(&mut logs, &baseline(&given)).unwrap();
    let factor = logs[0].origin.currents[0].unwrap().factor.unwrap();
    assert_eq!(factor, 1.25 * FACTORS[0]);
}

#[test]
fn the_depth_force_alone_is_compared_as_what_it_is_and_nothing_that_needs_the_others() {
    let force_of = |compared: &[ComparedQuantity]| compared.contains(&ComparedQuantity::Force);
    let read = |alone: Option<&str>| {
        let log = changed("weld-1", &toml("weld-1"), &mut |name, _, value| match alone {
            Some("") if ["fx_n", "fy_n"].contains(&name) => None,
            Some("0") if ["fx_n", "fy_n"].contains(&name) => Some(0.0),
            _ => Some(value),
        });
        let mut logs = [log];
        let found = find(&mut logs, &baseline(&model())).unwrap();
        assert!(found.mistakes.is_empty(), "{:?}", found.mistakes);
        let model = model();
        let problem = FitProblem::new(&model, experiments(&logs, &baseline(&model)).unwrap());
        let point = FitState::empty(1);
        let at =
            problem.logs[0].predict(&problem.model, &point.effects(&problem, 0), None).unwrap();
        let quantities: Vec<_> = problem.logs[0].compared.iter().map(|c| c.quantity).collect();
        assert!(force_of(&quantities));
        let pairs = problem.logs[0].compared.iter().zip(at.residual);
        let pairs: Vec<_> = pairs.map(|(c, r)| (c.quantity, c.component, c.measured, r)).collect();
        (pairs, logs[0].notices.clone())
    };
    let (whole, _) = read(None);
    let depth = |pairs: &[(ComparedQuantity, u8, f64, f64)]| -> Vec<[f64; 2]> {
        let of = pairs.iter().filter(|(q, c, ..)| *q == ComparedQuantity::Force && *c == 2);
        of.map(|(_, _, measured, residual)| [*measured, *residual]).collect()
    };
    let score =
        |of: &[[f64; 2]]| (of.iter().map(|[_, r]| r * r).sum::<f64>() / of.len() as f64).sqrt();
    for alone in ["", "0"] {
        let (pairs, notices) = read(Some(alone));
        assert!(notices.contains(&LogNotice::ForceInPart(vec!["fz_n"])), "{notices:?}");
        let of_plane = |(quantity, component, ..): &(ComparedQuantity, u8, f64, f64)| {
            let force = !matches!(quantity, ComparedQuantity::Moment);
            (force && *component != 2) || *quantity == ComparedQuantity::Position
        };
        assert!(!pairs.iter().any(of_plane));
        // The same readings are compared. What is left of them differs a little: one component tells
        // the start of channel and spindle, not three.
        let (own, same) = (depth(&pairs), depth(&whole));
        assert_eq!(own.len(), same.len());
        assert!(own.iter().zip(&same).all(|([a, _], [b, _])| a == b));
        assert!((score(&own) - score(&same)).abs() < 0.2, "{} {}", score(&own), score(&same));
        assert!((score(&own) - 1.0).abs() < 0.25, "{}", score(&own));
    }
}

/// The robot with some drives rigid and some rotors unknown.
fn with_open_drives(rigid: &[usize], unknown: &[usize]) -> RobotFile {
    let path = fixture("nothing-missing/robot.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let mut joint = None;
    let line = |line: &str| {
        if line.trim() == "[[joint]]" {
            joint = Some(joint.map_or(0, |joint: usize| joint + 1));
        }
        let of = |key: &str, joints: &[usize]| {
            line.starts_with(key) && joint.is_some_and(|joint| joints.contains(&joint))
        };
        match line {
            _ if of("stiffness_nm_rad", rigid) => "stiffness_nm_rad = \"rigid\"".to_owned(),
            _ if of("damping_nms_rad", rigid) => String::new(),
            _ if of("rotor_inertia", unknown) => "rotor_inertia_kg_m2 = \"unknown\"".to_owned(),
            _ => line.to_owned(),
        }
    };
    let text: Vec<String> = text.lines().map(line).collect();
    RobotFile::parse(&text.join("\n"), "robot.toml").unwrap()
}

/// What an arm gives more than its file says is no mistake in the wrench that shows it.
#[test]
fn a_wrench_is_not_wrong_where_a_drive_that_is_called_rigid_bends() {
    let model = ModelFile { robot: with_open_drives(&[0, 3], &[]), ..model() };
    for name in ["weld-1", "weld-2"] {
        let mut log = changed(name, &toml(name), &mut |_, _, value| Some(value));
        log.robot = model.robot.clone();
        let found = find(&mut [log], &baseline(&model)).unwrap();
        assert!(found.mistakes.is_empty(), "{name}: {:?}", found.mistakes);
    }
}

#[test]
fn a_rigid_drive_has_no_spring_to_fit_and_an_unknown_rotor_is_fitted() {
    let given = model();
    let robot = with_open_drives(&[0, 3], &[1]);
    let model = ModelFile { robot, ..given.clone() };
    let log = changed("free", &toml("free"), &mut |_, _, value| Some(value));
    let problem = FitProblem::new(&model, experiments(&[log], &baseline(&model)).unwrap());
    let point = calibrations(&problem);
    let has = |id: &str, joint: usize| {
        point.shared.iter().any(|e| e.kind.id == id && e.at == Location::Joint(joint))
    };
    for joint in 0..JOINTS {
        let rigid = [0, 3].contains(&joint);
        assert_eq!(has("stiffness-error", joint), !rigid, "{joint}");
        assert_eq!(has("damping-error", joint), !rigid, "{joint}");
        assert_eq!(has("rotor-inertia-error", joint), joint == 1);
    }
    for (id, of_spring) in
        [("nonlinear-stiffness", true), ("backlash", true), ("joint-friction", false)]
    {
        let kind = EffectKind::of(id).unwrap();
        assert_eq!(problem.is_known(kind, Location::Joint(3)), of_spring, "{id}");
        assert!(!problem.is_known(kind, Location::Joint(4)), "{id}");
    }
    // Whether it bends after all is a hypothesis.
    let bends = EffectKind::of("drive-compliance").unwrap();
    assert!(!problem.is_known(bends, Location::Joint(3)));
    assert!(problem.is_known(bends, Location::Joint(4)));
    let fitted = fit(&problem, &point, &blocks_of(&problem), &[], SolverOptions::full(0)).unwrap();
    let rotor = fitted.point.shared.iter().find(|e| e.kind.id == "rotor-inertia-error").unwrap();
    let found = model.robot.parameters.joints[1].rotor_inertia * (1.0 + rotor.values[0]);
    let real = given.robot.parameters.joints[1].rotor_inertia;
    // What 40 N·m of noise leaves of it in this motion, and the prior draws it by less.
    assert!((found / real - 1.0).abs() < 0.1, "{found}, {real}");
}
