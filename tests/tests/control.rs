//! The three hybrid controllers without a plant: what they command for what they are told, above
//! all when they are told nonsense.

use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use trueweld_core::control::{DriveCommand, Limited, SensorReadings, Setpoint};
use trueweld_core::{Fault, JOINTS, JointVector, Wrench};
use trueweld_tests::{
    AnyController, KR500, PERIOD, PLACES, cases, controllers, external_gains, force_gains,
    joint_gains, regular_configuration, seen, sensed_at, setpoint_at, spoil, weight, wild, wrench,
};

/// Every number finite, every torque within its drive.
fn check(command: &DriveCommand<f64>, name: &str) {
    for i in 0..JOINTS {
        let limit = KR500.parameters().joints[i].max_torque;
        assert!(
            command.torque[i].abs() <= limit,
            "{name}: joint {i} is given {} N·m",
            command.torque[i]
        );
    }
    for number in [command.force_error, command.depth_correction, command.push] {
        assert!(number.is_finite(), "{name}: {command:?}");
    }
}

/// The three controllers, started at rest at `q`.
fn started(q: &JointVector<f64>) -> [(&'static str, AnyController<f64>); 3] {
    controllers().map(|(name, mut controller)| {
        controller.start(&KR500, q, &weight(&KR500, q));
        (name, controller)
    })
}

/// An honest situation at `q`: the tool pressed with `force` N along the depth axis, as the
/// set-point asks.
fn pressed(q: &JointVector<f64>, force: f64) -> (Setpoint<f64>, SensorReadings<f64>) {
    let wrench = Wrench { moment: Vector3::zeros(), force: Vector3::new(0.0, 0.0, -force) };
    (setpoint_at(&KR500, q, Some(force)), sensed_at(&KR500, q, &wrench))
}

/// What a number that is none must be called, by its place.
fn expected_fault(place: usize) -> Option<Fault> {
    match place {
        0..12 => Some(Fault::Encoder(place % 6)),
        12..18 => None,
        18..24 => Some(Fault::Force),
        _ => Some(Fault::Setpoint),
    }
}

proptest! {
    #![proptest_config(cases(1500))]

    #[test]
    fn nonsense_never_becomes_torque(
        q in regular_configuration(),
        cycles in prop::collection::vec(prop::collection::vec((0..PLACES, wild()), 0..4), 1..6),
    ) {
        for (name, mut controller) in started(&q) {
            for wrong in &cycles {
                let (mut setpoint, mut sensed) = pressed(&q, 5e3);
                for (place, value) in wrong {
                    spoil(&mut setpoint, &mut sensed, *place, *value);
                }
                check(&controller.cycle(&KR500, &setpoint, &sensed), name);
            }
            let (setpoint, sensed) = pressed(&q, 5e3);
            check(&controller.cycle(&KR500, &setpoint, &sensed), name);
        }
    }

    #[test]
    fn every_number_at_once(q in regular_configuration(), values in prop::collection::vec(wild(), 2 * PLACES)) {
        for (name, mut controller) in started(&q) {
            for half in values.chunks(PLACES) {
                let (mut setpoint, mut sensed) = pressed(&q, 5e3);
                for (place, value) in half.iter().enumerate() {
                    spoil(&mut setpoint, &mut sensed, place, *value);
                }
                // Half of the cases get past the first check, the encoders'.
                if half[0] > 0.0 {
                    sensed.encoder = q;
                    sensed.encoder_rate.fill(0.0);
                }
                check(&controller.cycle(&KR500, &setpoint, &sensed), name);
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn a_number_that_is_none_is_called_what_it_is_and_leaves_no_trace(
        q in regular_configuration(), place in 0..PLACES,
        bad in prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
    ) {
        let (setpoint, sensed) = pressed(&q, 5e3);
        let (mut wrong_setpoint, mut wrong_sensed) = (setpoint, sensed);
        spoil(&mut wrong_setpoint, &mut wrong_sensed, place, bad);
        for ((name, mut controller), (_, mut twin)) in started(&q).into_iter().zip(started(&q)) {
            let before = controller.cycle(&KR500, &setpoint, &sensed);
            prop_assert_eq!(before.fault, None);
            twin.cycle(&KR500, &setpoint, &sensed);
            let command = controller.cycle(&KR500, &wrong_setpoint, &wrong_sensed);
            check(&command, name);
            prop_assert_eq!(command.fault, expected_fault(place), "{}, place {}", name, place);
            if command.fault == Some(Fault::Force) {
                // Blind: push and depth correction stay where they were.
                prop_assert_eq!(command.push, before.push);
                prop_assert_eq!(command.depth_correction, before.depth_correction);
            }
            // With the signal back all goes on as in a twin that never lost it. The set-points are
            // met, so the one cycle the twin has less is no cycle of motion; what rounding there is
            // in the error (1e-15) times K_i T is below 1e-6 N·m.
            let (back, other) =
                (controller.cycle(&KR500, &setpoint, &sensed), twin.cycle(&KR500, &setpoint, &sensed));
            prop_assert_eq!(back.fault, None, "{} stays faulty", name);
            prop_assert!((back.torque - other.torque).amax() < 1e-6, "{name} remembers the fault");
        }
    }

    #[test]
    fn rest_is_held_by_weight_alone(q in regular_configuration()) {
        let (setpoint, sensed) = (setpoint_at(&KR500, &q, None), sensed_at(&KR500, &q, &Wrench::zero()));
        let weight = weight(&KR500, &q);
        for (name, mut controller) in started(&q) {
            for _ in 0..20 {
                let command = controller.cycle(&KR500, &setpoint, &sensed);
                // ΔX of a pose to itself is R Rᵀ − 1 of rounding, 1e-16 rad; times K_p up to 3e6
                // N·m/rad and J⁻¹ up to some 10/m.
                let off = seen("torque at rest", (command.torque - weight).amax());
                prop_assert!(off < 1e-6, "{name}: {off:e} N·m beside the weight");
                prop_assert_eq!((command.fault, command.limited), (None, Limited::default()), "{}", name);
            }
        }
    }

    #[test]
    fn closing_the_force_loop_at_the_force_there_is_does_not_bump(q in regular_configuration(), force in 100.0..18e3_f64) {
        let (setpoint, sensed) = pressed(&q, force);
        for (name, mut controller) in controllers() {
            // The drives hold the push beside the weight, as after a start under load.
            let push = Wrench { moment: Vector3::zeros(), force: setpoint.depth_axis() * force };
            let held = weight(&KR500, &q) + KR500.frames(&q).joint_torque(&push);
            prop_assume!((0..JOINTS).all(|i| held[i].abs() < KR500.parameters().joints[i].max_torque));
            controller.start(&KR500, &q, &held);
            let open = controller.cycle(&KR500, &Setpoint { force: None, ..setpoint }, &sensed);
            // Without a reading in the first closed period the push is that of the start.
            let mut blind = sensed;
            blind.wrench.force.x = f64::NAN;
            let unseen = controller.cycle(&KR500, &setpoint, &blind);
            prop_assert_eq!(unseen.fault, Some(Fault::Force));
            prop_assert!((unseen.torque - held).amax() < 1e-6, "{name} bumps by {:e} while blind", (unseen.torque - held).amax());
            let closed = controller.cycle(&KR500, &setpoint, &sensed);
            // As at rest, and 5e4 N·m handed over to rounding.
            prop_assert!((open.torque - held).amax() < 1e-6);
            prop_assert!((closed.torque - held).amax() < 1e-6, "{name} bumps by {:e}", (closed.torque - held).amax());
            // The push that is seen is formed by a rotation there and back.
            prop_assert!(closed.force_error.abs() < 1e-10);
        }
    }

    #[test]
    fn too_little_force_pushes_harder(q in regular_configuration(), less in 100.0..2e3_f64) {
        for (name, mut controller) in started(&q) {
            let (setpoint, mut sensed) = pressed(&q, 5e3);
            let even = controller.cycle(&KR500, &setpoint, &sensed);
            sensed.wrench.force.z += less;
            let weak = controller.cycle(&KR500, &setpoint, &sensed);
            prop_assume!(!even.limited.any() && !weak.limited.any());
            prop_assert!((weak.force_error - less).abs() < 1e-9);
            // The torque added does positive work on a tool that moves along z of W.
            let into = KR500.frames(&q).jacobian().0.lu()
                .solve(&Wrench { moment: Vector3::zeros(), force: setpoint.depth_axis() }.to_vector()).unwrap();
            let work = into.dot(&(weak.torque - even.torque));
            prop_assert!(work > 0.0, "{name}: {work}");
            if name != "external" {
                // J⁻ᵀ(Γ − Γ₀) along z is the change of push: K_pf Δf + K_if Δf T.
                let g = force_gains::<f64>();
                let expected = less * (g.kp + g.ki * PERIOD);
                prop_assert!((work - expected).abs() < 1e-5 && (weak.push - even.push - expected).abs() < 1e-8);
            } else {
                let g = external_gains::<f64>();
                // As hard as where the gains were tuned: less where arm and material are stiffer.
                let compliance = KR500.cartesian_compliance(&KR500.frames(&q).jacobian());
                let n = Wrench { moment: Vector3::zeros(), force: setpoint.depth_axis() }.to_vector();
                let scale = g.tuned_stiffness * (1.0 / g.material_stiffness + n.dot(&(compliance * n)));
                let expected = less * scale.clamp(0.5, 2.0) * (g.kp + g.ki * PERIOD);
                prop_assert!((weak.depth_correction - expected).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn force_branches_stay_within_their_correction(q in regular_configuration(), forces in prop::collection::vec(-1e6..1e6_f64, 1..30)) {
        for (name, mut controller) in started(&q) {
            let mut before = 0.0;
            for force in &forces {
                let (setpoint, mut sensed) = pressed(&q, 5e3);
                sensed.wrench.force.z = *force;
                let command = controller.cycle(&KR500, &setpoint, &sensed);
                check(&command, name);
                if name == "external" {
                    let (size, g) = (command.depth_correction, external_gains::<f64>());
                    prop_assert!(size.abs() <= g.max_correction);
                    // One rounding of the difference.
                    prop_assert!((size - before).abs() <= g.max_rate * PERIOD * (1.0 + 1e-12));
                    before = size;
                } else {
                    prop_assert!((command.push - 5e3).abs() <= force_gains::<f64>().max_correction * (1.0 + 1e-12));
                }
            }
        }
    }

    #[test]
    fn faults_of_the_arm_are_named(q in regular_configuration(), joint in 0..JOINTS, up in any::<bool>(),
                                   rate in -0.5..0.5_f64, w in wrench()) {
        let sign = if up { 1.0 } else { -1.0 };
        let p = KR500.parameters();
        for (name, mut controller) in started(&q) {
            // A jump of more than twice what the drive can do.
            let (setpoint, mut sensed) = pressed(&q, 5e3);
            sensed.wrench = w;
            sensed.encoder[joint] += sign * 2.01 * p.joints[joint].max_rate * PERIOD;
            sensed.encoder_rate[joint] = rate;
            let command = controller.cycle(&KR500, &setpoint, &sensed);
            prop_assert_eq!(command.fault, Some(Fault::Encoder(joint)), "{}", name);
            // The safe command: weight at the last good angles, and a brake.
            let mut expected = weight(&KR500, &q);
            expected[joint] -= joint_gains::<f64>().kd[joint] * rate;
            let limit = p.joints[joint].max_torque;
            expected[joint] = expected[joint].clamp(-limit, limit);
            prop_assert!((command.torque - expected).amax() < 1e-9, "{name}: {} for {expected}", command.torque);
            // A move the drive can do is none.
            sensed.encoder = q;
            sensed.encoder[joint] += sign * 0.9 * p.joints[joint].max_rate * PERIOD;
            prop_assume!(KR500.beyond_limits(&sensed.encoder).is_none());
            prop_assert_eq!(controller.cycle(&KR500, &setpoint, &sensed).fault, None, "{}", name);
        }
        // Outside a limit.
        let mut outside = q;
        outside[joint] = p.joints[joint].limits[usize::from(up)] + sign * 0.01;
        let (setpoint, sensed) = pressed(&outside, 5e3);
        for (name, mut controller) in started(&outside) {
            let command = controller.cycle(&KR500, &setpoint, &sensed);
            prop_assert_eq!(command.fault, Some(Fault::Limit(joint)), "{}", name);
            check(&command, name);
        }
        // Axes 4 and 6 in line.
        let mut singular = q;
        singular[4] = 1e-6 * rate;
        let (setpoint, sensed) = pressed(&singular, 5e3);
        for (name, mut controller) in started(&singular) {
            let command = controller.cycle(&KR500, &setpoint, &sensed);
            prop_assert_eq!(command.fault, Some(Fault::Singular), "{}", name);
            check(&command, name);
        }
    }

    #[test]
    fn lost_encoders_do_not_lock_a_moving_arm(q in regular_configuration(), joint in 0..JOINTS) {
        // Ten periods without a joint's encoder while it coasts at a third of its speed.
        let p = KR500.parameters();
        for (name, mut controller) in started(&q) {
            let mut at = q;
            for _ in 0..10 {
                at[joint] += 0.3 * p.joints[joint].max_rate * PERIOD * if q[joint] > 0.0 { -1.0 } else { 1.0 };
                let (setpoint, mut sensed) = pressed(&at, 5e3);
                sensed.encoder[joint] = f64::NAN;
                prop_assert_eq!(controller.cycle(&KR500, &setpoint, &sensed).fault, Some(Fault::Encoder(joint)));
            }
            prop_assume!(at[4].sin().abs() > 0.05);
            let (setpoint, sensed) = pressed(&at, 5e3);
            prop_assert_eq!(controller.cycle(&KR500, &setpoint, &sensed).fault, None, "{}", name);
        }
    }

    #[test]
    fn a_lost_set_point_does_not_lock_a_moving_arm(q in regular_configuration(), joint in 0..JOINTS) {
        // Ten periods without a set-point while the arm coasts at half speed, then the set-point is
        // back.
        let p = KR500.parameters();
        let mut at = q;
        for (name, mut controller) in started(&q) {
            at = q;
            for _ in 0..10 {
                at[joint] += 0.5 * p.joints[joint].max_rate * PERIOD * if q[joint] > 0.0 { -1.0 } else { 1.0 };
                let (mut setpoint, sensed) = pressed(&at, 5e3);
                setpoint.pose.position.x = f64::NAN;
                prop_assert_eq!(controller.cycle(&KR500, &setpoint, &sensed).fault, Some(Fault::Setpoint));
            }
            prop_assume!(at[4].sin().abs() > 0.05);
            let (setpoint, sensed) = pressed(&at, 5e3);
            prop_assert_eq!(controller.cycle(&KR500, &setpoint, &sensed).fault, None, "{}", name);
        }
        prop_assert!(at != q);
    }

    #[test]
    fn a_lateral_error_is_answered_by_its_stiffness(q in regular_configuration(), across in -1e-3..1e-3_f64) {
        // ΔX across the weld: Γ − weight = (K_p + K_i T) J⁻¹ΔX in the first period, whatever the
        // scheme.
        let (mut setpoint, sensed) = pressed(&q, 5e3);
        let shift = setpoint.b_from_w.column(1) * across;
        setpoint.pose.position += shift;
        setpoint.force = None;
        let shift: Vector3<f64> = shift;
        let joint = KR500.frames(&q).jacobian().0.lu()
            .solve(&trueweld_core::Twist { angular: Vector3::zeros(), linear: shift }.to_vector()).unwrap();
        let g = joint_gains::<f64>();
        let expected = weight(&KR500, &q) + (g.kp + g.ki * PERIOD).component_mul(&joint);
        for (name, mut controller) in started(&q) {
            let command = controller.cycle(&KR500, &setpoint, &sensed);
            prop_assume!(!command.limited.any());
            prop_assert!((command.torque - expected).amax() < 1e-5, "{name}");
        }
    }

    #[test]
    fn selection_takes_depth_from_the_position_branch(q in regular_configuration(), deep in -1e-3..1e-3_f64) {
        // (2.2) with S: a depth error alone changes nothing once the force loop is closed; (2.3)
        //       answers it.
        let (setpoint, sensed) = pressed(&q, 5e3);
        let mut deeper = setpoint;
        deeper.pose.position += setpoint.depth_axis() * deep;
        let change = |which: usize| {
            let torque = |s: &Setpoint<f64>| started(&q)[which].1.cycle(&KR500, s, &sensed).torque;
            (torque(&deeper) - torque(&setpoint)).amax()
        };
        prop_assert!(change(0) < 1e-6, "parallel answers depth with {} N·m", change(0));
        prop_assert!(change(1) > 1e4 * deep.abs(), "superposed answers depth with {} N·m", change(1));
    }
}

#[test]
fn a_finite_set_point_that_is_no_rotation_is_a_fault() {
    let q = JointVector::from([0.1, -1.2, 1.6, 0.3, 0.8, 0.2]);
    let mirrored = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
    let sheared = Matrix3::identity() + Matrix3::from_element(0.01);
    let scaled = [0.0, 1e-300, 0.99, 1.01, 3.0, 1e150, 1e300].map(|s| Matrix3::identity() * s);
    for wrong in scaled.into_iter().chain([mirrored, sheared, Matrix3::from_element(1.0)]) {
        for (name, mut controller) in started(&q) {
            let (good, sensed) = pressed(&q, 5e3);
            let mut setpoints = [good; 2];
            setpoints[0].pose.rotation *= wrong;
            setpoints[1].b_from_w *= wrong;
            for setpoint in setpoints {
                let command = controller.cycle(&KR500, &setpoint, &sensed);
                assert_eq!(command.fault, Some(Fault::Setpoint), "{name}: {wrong}");
                check(&command, name);
            }
            assert_eq!(controller.cycle(&KR500, &good, &sensed).fault, None, "{name}");
        }
    }
}
