//! Compensation without a plant: bounds that hold for any demand, and the elastostatic law where
//! its answer is known.

use nalgebra::{SVector, Vector3};
use proptest::prelude::*;
use trueweld_compensators::{Elastostatic, ElastostaticGains, Setup, Uncompensated, library};
use trueweld_core::compensation::{
    Compensated, Compensator, CorrectionLoop, DeviationMeasurement, LoopLimits, Observation,
};
use trueweld_core::control::{
    External, ForceSensorLimits, HybridController, Parallel, STUCK, SensorReadings, Setpoint,
};
use trueweld_core::spatial::rotation_from_vector;
use trueweld_core::{Fault, JOINTS, JointVector, Pose, Robot, Twist, Wrench};
use trueweld_plant::simulate::real_inverse_near;
use trueweld_tests::{
    KR500, PERIOD, PLACES, cases, external_gains, force_gains, joint_gains, kr500_parameters,
    pose_difference, regular_configuration, seen, sensed_at, setpoint_at, spoil,
    vertical_weld_pose, weight, weld_wrench, wild,
};

const LATERAL: LoopLimits<f64> = LoopLimits { bandwidth: 3.0, size: 0.010, rate: 0.005 };
const ORIENTATION: LoopLimits<f64> = LoopLimits { bandwidth: 3.0, size: 0.02, rate: 0.01 };

/// Norms are formed, divided and multiplied again: a few roundings.
const ROUNDING: f64 = 1.0 + 1e-14;

/// Plays a script of demands, one a period; kind 0 fails.
struct ScriptedBy(Vec<([f64; 6], u8)>, usize);

impl Compensator<f64> for ScriptedBy {
    fn reset(&mut self) {
        self.1 = 0;
    }

    fn demand(&mut self, _: &Robot<f64>, _: &Observation<'_, f64>) -> Result<Twist<f64>, Fault> {
        let (demand, kind) = self.0[self.1];
        self.1 += 1;
        if kind == 0 { Err(Fault::Compensation) } else { Ok(Twist::from_vector(&demand.into())) }
    }
}

/// Where the encoders have to be for the real tool to stand at `pose` under gravity and `wrench`.
fn fake_pose(q: &JointVector<f64>, wrench: &Wrench<f64>) -> Pose<f64> {
    KR500.forward_kinematics(&KR500.fake_target(q, wrench))
}

fn on_the_weld(y: f64) -> JointVector<f64> {
    let all = KR500.inverse_all(&vertical_weld_pose(y)).unwrap();
    all.iter()
        .map(|(_, q)| *q)
        .find(|q| KR500.beyond_limits(q).is_none())
        .expect("a branch within the limits")
}

fn parallel() -> Parallel<f64> {
    Parallel::new(joint_gains(), force_gains(), PERIOD)
}

fn check_limits(before: &Twist<f64>, after: &Twist<f64>) {
    assert!(after.is_finite());
    assert!(after.linear.norm() <= LATERAL.size * ROUNDING, "lateral {} m", after.linear.norm());
    assert!(
        after.angular.norm() <= ORIENTATION.size * ROUNDING,
        "orientation {} rad",
        after.angular.norm()
    );
    // The difference of two numbers of up to 0.02 is known to 4e-18.
    let moved = (after.linear - before.linear).norm();
    assert!(
        moved <= LATERAL.rate * PERIOD * ROUNDING + 1e-17,
        "lateral moved {moved} m in one period"
    );
    let turned = (after.angular - before.angular).norm();
    assert!(
        turned <= ORIENTATION.rate * PERIOD * ROUNDING + 1e-17,
        "orientation turned {turned} rad"
    );
    assert_eq!(after.linear.z, 0.0, "depth belongs to the force loop");
}

fn elastostatic(wrench_filter_hz: f64) -> Elastostatic<f64> {
    Elastostatic::new(&ElastostaticGains { wrench_filter_hz, crosstalk: [0.0; 2] }, PERIOD)
        .expect("a corner below Nyquist")
}

proptest! {
    #![proptest_config(cases(500))]

    #[test]
    fn a_loop_keeps_its_limits_for_any_demand(demands in prop::collection::vec(prop::array::uniform3(wild()), 1..60)) {
        let mut follower = CorrectionLoop::<f64, 3>::new(ORIENTATION, PERIOD);
        let mut before = SVector::zeros();
        for demand in demands {
            let demand = SVector::from(demand);
            let (now, held) = follower.follow(&demand);
            let (zero, size) = (Vector3::zeros(), Twist { angular: now, linear: Vector3::zeros() });
            check_limits(&Twist { angular: before, linear: zero }, &size);
            prop_assert_eq!(&now, follower.correction());
            if demand.iter().any(|d| !d.is_finite()) {
                prop_assert!(now == before && held, "a demand that is no number was followed");
            }
            before = now;
        }
    }

    #[test]
    fn a_loop_within_its_limits_is_a_first_order_lag(target in -1e-6..1e-6_f64, steps in 1..200_i32) {
        let mut follower = CorrectionLoop::<f64, 2>::new(LATERAL, PERIOD);
        let demand = SVector::from([target, -target]);
        for _ in 0..steps {
            prop_assert!(!follower.follow(&demand).1);
        }
        // c(t) = demand (1 − e^(−ωt)), exactly at the samples.
        let expected = demand * (1.0 - (-LATERAL.bandwidth * PERIOD * f64::from(steps)).exp());
        prop_assert!((follower.correction() - expected).amax() < 1e-19 + 1e-13 * target.abs());
        follower.reset();
        prop_assert!(follower.correction().amax() == 0.0);
    }
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn a_compensated_controller_keeps_its_limits_for_any_law(
        q in regular_configuration(),
        script in prop::collection::vec((prop::array::uniform6(wild()), 0..4_u8), 1..20),
    ) {
        let (setpoint, sensed) = (setpoint_at(&KR500, &q, Some(0.0)), sensed_at(&KR500, &q, &Wrench::zero()));
        let mut before = Twist::zero();
        let mut robot = Compensated::new(parallel(), ScriptedBy(script.clone(), 0), LATERAL, ORIENTATION, PERIOD);
        robot.start(&KR500, &q, &weight(&KR500, &q));
        for (k, (_, kind)) in script.iter().enumerate() {
            let sensed = trembling(&sensed, k);
            let command = robot.cycle(&KR500, &Observation::of_robot(&setpoint, &setpoint.pose, &sensed));
            let now = robot.correction();
            check_limits(&before, &now);
            if *kind == 0 {
                prop_assert_eq!(command.fault, Some(Fault::Compensation));
                prop_assert_eq!(now, before, "a law that failed was followed");
            } else {
                prop_assert_eq!(command.fault, None);
            }
            for i in 0..JOINTS {
                prop_assert!(command.torque[i].abs() <= KR500.parameters().joints[i].max_torque);
            }
            before = now;
        }
    }

    #[test]
    fn elastostatic_survives_nonsense(
        q in regular_configuration(),
        cycles in prop::collection::vec(prop::collection::vec((0..PLACES, wild()), 0..3), 1..6),
        nominal in prop::option::of((0..12_usize, wild())),
    ) {
        let w = weld_wrench();
        let mut robot = Compensated::new(
            External::new(joint_gains(), external_gains(), PERIOD),
            elastostatic(4.0), LATERAL, ORIENTATION, PERIOD,
        );
        let at = KR500.fake_target(&q, &w);
        prop_assume!(KR500.beyond_limits(&at).is_none());
        robot.start(&KR500, &at, &weight(&KR500, &at));
        let pose = KR500.forward_kinematics(&q);
        for wrong in &cycles {
            let (mut setpoint, mut sensed) = (setpoint_at(&KR500, &at, Some(18e3)), sensed_at(&KR500, &at, &w));
            for (place, value) in wrong {
                spoil(&mut setpoint, &mut sensed, *place, *value);
            }
            let mut wanted = pose;
            match nominal {
                Some((place @ 0..9, value)) => wanted.rotation[place] = value,
                Some((place, value)) => wanted.position[place - 9] = value,
                None => {}
            }
            let before = robot.correction();
            let command = robot.cycle(&KR500, &Observation::of_robot(&setpoint, &wanted, &sensed));
            check_limits(&before, &robot.correction());
            for i in 0..JOINTS {
                prop_assert!(command.torque[i].abs() <= KR500.parameters().joints[i].max_torque);
            }
        }
    }

    #[test]
    fn elastostatic_demand_puts_the_real_tool_on_its_nominal_pose(q in regular_configuration()) {
        let w = weld_wrench();
        let nominal = KR500.forward_kinematics(&q);
        let mut law = elastostatic(4.0);
        // Taught without any load: the set-point is the nominal pose itself.
        let setpoint = Setpoint { pose: nominal, b_from_w: nominal.rotation, force: Some(18e3), spindle_speed: 0.0 };
        let sensed = sensed_at(&KR500, &q, &w);
        let demand = law.demand(&KR500, &Observation::of_robot(&setpoint, &nominal, &sensed)).unwrap();
        let corrected = setpoint.pose.displaced(&demand.rotated(&setpoint.b_from_w));
        let encoder = KR500.inverse_near(&corrected, &q);
        prop_assume!(encoder.is_ok());
        let real = KR500.deflected(&encoder.unwrap(), &w, 8).real;
        // As the fake target itself, 1e-9 m, with an inverse kinematics more.
        let off = seen("real tool from nominal", pose_difference(&real, &nominal));
        prop_assert!(off < 1e-9, "{off:e} m from the nominal pose");
    }

    #[test]
    fn elastostatic_asks_for_nothing_where_nothing_bends(q in regular_configuration()) {
        // Set-point taught under gravity, no wrench.
        let nominal = KR500.forward_kinematics(&q);
        let pose = fake_pose(&q, &Wrench::zero());
        let setpoint = Setpoint { pose, b_from_w: pose.rotation, force: Some(0.0), spindle_speed: 0.0 };
        let sensed = sensed_at(&KR500, &KR500.fake_target(&q, &Wrench::zero()), &Wrench::zero());
        prop_assume!(KR500.beyond_limits(&sensed.encoder).is_none());
        let mut law = elastostatic(4.0);
        let demand = law.demand(&KR500, &Observation::of_robot(&setpoint, &nominal, &sensed)).unwrap();
        // An inverse kinematics there and back: rounding at 3.5 m.
        prop_assert!(seen("demand without load", demand.to_vector().amax()) < 1e-12);
    }
}

#[test]
fn elastostatic_recovers_from_a_glitch() {
    let (q, w) = (on_the_weld(-0.5), weld_wrench());
    let nominal = KR500.forward_kinematics(&q);
    let setpoint = Setpoint {
        pose: nominal,
        b_from_w: nominal.rotation,
        force: Some(18e3),
        spindle_speed: 0.0,
    };
    let demand = |law: &mut Elastostatic<f64>, wrench: Wrench<f64>| {
        let sensed: SensorReadings<f64> = sensed_at(&KR500, &q, &wrench);
        law.demand(&KR500, &Observation::of_robot(&setpoint, &nominal, &sensed))
    };
    let mut law = elastostatic(4.0);
    let good = demand(&mut law, w).unwrap();
    for (glitch, places) in [(f64::NAN, 0..6), (f64::INFINITY, 0..6), (f64::MAX, 5..6)] {
        for place in places {
            let mut wrong = w.to_vector();
            wrong[place] = glitch;
            let answers = [(); 20].map(|()| demand(&mut law, Wrench::from_vector(&wrong)));
            // Numbers at the end of the range overflow in the filter sooner or later; the law must
            // say so and not keep what came of them.
            assert!(answers.contains(&Err(Fault::Force)));
            assert!(glitch == f64::MAX || answers.iter().all(|a| *a == Err(Fault::Force)));
            // 1e308 N dies away by e^(−√½·2π·4 Hz·T) = 0.81 a period: 3500 periods to 1e-9 N, or at
            // once by restart.
            let periods = if glitch == f64::MAX { 3500 } else { 3 };
            let after = (0..periods).map(|_| demand(&mut law, w)).last().unwrap().unwrap();
            assert!(
                (after - good).to_vector().amax() < 1e-12,
                "{glitch} in channel {place} is still remembered"
            );
        }
    }
}

#[test]
fn elastostatic_starts_without_a_transient_and_lags_by_its_declared_delay() {
    let (q, w) = (on_the_weld(0.0), weld_wrench());
    let nominal = KR500.forward_kinematics(&q);
    let setpoint = Setpoint {
        pose: nominal,
        b_from_w: nominal.rotation,
        force: Some(18e3),
        spindle_speed: 0.0,
    };
    let mut law = elastostatic(4.0);
    let demand = |law: &mut Elastostatic<f64>, scale: f64| {
        let sensed = sensed_at(&KR500, &q, &(w * scale));
        law.demand(&KR500, &Observation::of_robot(&setpoint, &nominal, &sensed))
            .unwrap()
            .to_vector()
    };
    let first = demand(&mut law, 1.0);
    for _ in 0..100 {
        // A filter of gain one at rest, with 1e-13 of rounding on 10 mm.
        assert!((demand(&mut law, 1.0) - first).amax() < 1e-14);
    }
    // A slow ramp of the load from full comes out as the load `delay` ago.
    let per_period = 1e-5;
    let mut last = first;
    for k in 1..=400 {
        last = demand(&mut law, 1.0 + per_period * f64::from(k));
    }
    let ago = 1.0 + per_period * (400.0 - law.delay() / PERIOD);
    let mut fresh = elastostatic(4.0);
    assert!((demand(&mut fresh, ago) - last).amax() < 1e-13);
    // After a reset nothing of the old wrench is left.
    law.reset();
    assert!((demand(&mut law, 0.5) - demand(&mut { elastostatic(4.0) }, 0.5)).amax() < 1e-16);
}

#[test]
fn elastostatic_lateral_demand_is_of_the_published_size() {
    // Up to 5 mm of lateral deviation at 18/4/1 kN (Bres et al. 2010): the law must ask for as
    // much.
    let q = on_the_weld(-1.0);
    let pose = fake_pose(&q, &Wrench::zero());
    let nominal = KR500.forward_kinematics(&q);
    let setpoint =
        Setpoint { pose, b_from_w: nominal.rotation, force: Some(18e3), spindle_speed: 0.0 };
    let sensed = sensed_at(&KR500, &q, &weld_wrench());
    let mut law = elastostatic(4.0);
    let observation = Observation::of_robot(&setpoint, &nominal, &sensed);
    let demand = law.demand(&KR500, &observation).unwrap();
    println!("demanded at the start of the weld: {:.2} mm", demand.linear.transpose() * 1e3);
    assert!((0.5e-3..8e-3).contains(&demand.linear.y.abs()), "{} m across", demand.linear.y);
}

#[test]
fn what_the_law_cannot_do_is_said() {
    let q = on_the_weld(0.0);
    let setpoint = setpoint_at(&KR500, &q, Some(18e3));
    let sensed = sensed_at(&KR500, &q, &weld_wrench());
    let mut law = elastostatic(4.0);
    let mut ask = |nominal: &Pose<f64>, sensed: &SensorReadings<f64>| {
        law.demand(&KR500, &Observation::of_robot(&setpoint, nominal, sensed))
    };
    let far = Pose { position: Vector3::new(9.0, 0.0, 0.0), ..setpoint.pose };
    assert_eq!(ask(&far, &sensed), Err(Fault::Compensation));
    let none = Pose { position: Vector3::new(f64::NAN, 0.0, 0.0), ..setpoint.pose };
    assert_eq!(ask(&none, &sensed), Err(Fault::Compensation));
    let mut blind = sensed;
    blind.wrench.moment.y = f64::NAN;
    assert_eq!(ask(&setpoint.pose, &blind), Err(Fault::Force));
    assert!(ask(&setpoint.pose, &sensed).is_ok());
    let above_nyquist = ElastostaticGains { wrench_filter_hz: 50.0, crosstalk: [0.0; 2] };
    assert_eq!(
        Elastostatic::new(&above_nyquist, PERIOD).err().map(|error| error.key),
        Some("wrench_filter_hz")
    );
}

#[test]
fn uncompensated_is_the_bare_controller() {
    let q = on_the_weld(0.3);
    let (mut bare, mut on_top) =
        (parallel(), Compensated::new(parallel(), Uncompensated, LATERAL, ORIENTATION, PERIOD));
    bare.start(&KR500, &q, &weight(&KR500, &q));
    on_top.start(&KR500, &q, &weight(&KR500, &q));
    let mut sensed = sensed_at(&KR500, &q, &weld_wrench());
    let setpoint = setpoint_at(&KR500, &q, Some(18e3));
    for k in 0..50 {
        sensed.encoder[0] = q[0] + 1e-4 * f64::from(k).sin();
        sensed.wrench.force.z += 1.0;
        let (a, b) = (
            bare.cycle(&KR500, &setpoint, &sensed),
            on_top.cycle(&KR500, &Observation::of_robot(&setpoint, &setpoint.pose, &sensed)),
        );
        assert_eq!(a, b);
    }
}

#[test]
fn authority_goes_across_the_seam_first() {
    let q = on_the_weld(0.0);
    let (setpoint, sensed) =
        (setpoint_at(&KR500, &q, Some(18e3)), sensed_at(&KR500, &q, &weld_wrench()));
    // (along, across) demanded, and what is left of it within 10 mm.
    for (demanded, given) in [
        ([3e-3, 4e-3], [3e-3, 4e-3]),
        ([0.1, 8e-3], [6e-3, 8e-3]),
        ([-0.1, -6e-3], [-8e-3, -6e-3]),
        ([5e-3, 0.02], [0.0, 0.01]),
    ] {
        let demand = [0.0, 0.0, 0.0, demanded[0], demanded[1], 0.0];
        let script = ScriptedBy(vec![(demand, 1); 2000], 0);
        let mut robot = Compensated::new(parallel(), script, LATERAL, ORIENTATION, PERIOD);
        robot.start(&KR500, &q, &weight(&KR500, &q));
        for k in 0..2000 {
            robot.cycle(
                &KR500,
                &Observation::of_robot(&setpoint, &setpoint.pose, &trembling(&sensed, k)),
            );
        }
        let reached = robot.correction().linear.xy();
        assert!(
            (reached - nalgebra::Vector2::from(given)).norm() < 1e-9,
            "{demanded:?}: {reached}"
        );
    }
}

/// A live sensor's readings, no two in a row alike; far below what shows.
fn trembling(sensed: &SensorReadings<f64>, k: usize) -> SensorReadings<f64> {
    let mut sensed = *sensed;
    sensed.wrench.moment.z += 1e-9 * (k % 2) as f64;
    sensed
}

#[test]
fn a_force_sensor_that_stands_still_is_not_believed() {
    let q = on_the_weld(0.0);
    let (setpoint, live) =
        (setpoint_at(&KR500, &q, Some(18e3)), sensed_at(&KR500, &q, &weld_wrench()));
    let law = elastostatic(4.0);
    let external = External::new(joint_gains(), external_gains(), PERIOD);
    let mut robot = Compensated::new(external, law, LATERAL, ORIENTATION, PERIOD);
    robot.start(&KR500, &q, &weight(&KR500, &q));
    let mut cycle = |sensed: &SensorReadings<f64>| {
        robot.cycle(&KR500, &Observation::of_robot(&setpoint, &setpoint.pose, sensed))
    };
    for k in 0..100 {
        assert_eq!(cycle(&trembling(&live, k)).fault, None);
    }
    // Dropped to zero: 18 kN are missing, and the loop presses on, until it is seen that nothing
    // moves.
    let dead = SensorReadings { wrench: Wrench::zero(), ..live };
    let believed: Vec<f64> = (1..STUCK)
        .map(|_| {
            let command = cycle(&dead);
            assert_eq!(command.fault, None);
            command.depth_correction
        })
        .collect();
    let held = *believed.last().unwrap();
    for _ in 0..1000 {
        let command = cycle(&dead);
        assert_eq!((command.fault, command.depth_correction), (Some(Fault::Force), held));
    }
    assert_eq!(cycle(&live).fault, None, "a reading that differs is believed at once");
}

#[test]
fn a_reading_that_the_force_sensor_cannot_give_moves_nothing() {
    let range = ForceSensorLimits { force: 30e3, moment: 3e3, disagreement: 0.0 };
    let q = on_the_weld(0.0);
    let (setpoint, live) =
        (setpoint_at(&KR500, &q, Some(18e3)), sensed_at(&KR500, &q, &weld_wrench()));
    // Channels of the wrench, and what they read once.
    for (channel, value) in [(4, 30e3), (4, 1e6), (5, -1e30), (3, f64::MAX), (0, 3e3), (2, -1e9)] {
        let external = External::new(joint_gains(), external_gains(), PERIOD);
        let mut robot = Compensated::new(external, elastostatic(4.0), LATERAL, ORIENTATION, PERIOD)
            .with_force_sensor_limits(range);
        robot.start(&KR500, &q, &weight(&KR500, &q));
        for k in 0..200 {
            let mut sensed = trembling(&live, k);
            if k == 100 {
                let mut wrench = sensed.wrench.to_vector();
                wrench[channel] = value;
                sensed.wrench = Wrench::from_vector(&wrench);
            }
            let before = robot.correction();
            let command =
                robot.cycle(&KR500, &Observation::of_robot(&setpoint, &setpoint.pose, &sensed));
            assert_eq!(command.fault, (k == 100).then_some(Fault::Force), "{value} in {channel}");
            assert!(k != 100 || robot.correction() == before, "{value} in {channel}");
        }
    }
}

#[test]
fn a_force_sensor_that_the_drives_contradict_is_not_believed_until_they_agree() {
    let limits = ForceSensorLimits { disagreement: 5e3, ..ForceSensorLimits::unknown() };
    let q = on_the_weld(0.0);
    let setpoint = setpoint_at(&KR500, &q, Some(18e3));
    let load = weld_wrench();
    let frames = KR500.frames(&q);
    let borne = KR500.spring_torque_at_rest(&frames, &q, &load.rotated(&frames.tcp.rotation));
    // The sensor shows noise alone in some periods, and in others the push and noise.
    let shown = |k: usize, alive: bool| {
        let noise = 25.0 * ((k * 7 % 13) as f64 - 6.0) / 6.0;
        let mut wrench = if alive { load } else { Wrench::zero() };
        wrench.force.add_scalar_mut(noise);
        wrench
    };
    let faults = |torque: JointVector<f64>, dead: core::ops::Range<usize>| {
        let external = External::new(joint_gains(), external_gains(), PERIOD);
        let mut robot = Compensated::new(external, elastostatic(4.0), LATERAL, ORIENTATION, PERIOD)
            .with_force_sensor_limits(limits);
        robot.start(&KR500, &q, &weight(&KR500, &q));
        let mut faults = Vec::new();
        for k in 0..300 {
            let wrench = shown(k, !dead.contains(&k));
            let sensed = SensorReadings { motor_torque: torque, ..sensed_at(&KR500, &q, &wrench) };
            let observation = Observation::of_robot(&setpoint, &setpoint.pose, &sensed);
            let before = robot.correction();
            if robot.cycle(&KR500, &observation).fault == Some(Fault::Force) {
                assert_eq!(robot.correction(), before, "period {k}");
                faults.push(k);
            }
        }
        faults
    };
    let late = 100 + usize::from(STUCK) - 1;
    assert_eq!(faults(borne, 100..200), (late..200).collect::<Vec<_>>());
    // Drives that are 20 % off, and those whose torque nobody knows, contradict nothing.
    let none: Vec<usize> = Vec::new();
    assert_eq!(faults(borne * 1.2, 0..0), none);
    assert_eq!(faults(JointVector::zeros(), 100..200), none);
    assert_eq!(faults(JointVector::repeat(f64::NAN), 100..200), none);
    // A push that is read and not borne is none either.
    let idle = KR500.spring_torque_at_rest(&frames, &q, &Wrench::zero());
    assert_eq!(faults(idle, 0..0), (late - 100..300).collect::<Vec<_>>());
}

#[test]
fn a_path_that_is_wrong_for_a_period_is_a_fault_and_soon_over_under_every_law() {
    // What is no number; and faster than the arm can move from where the path was, 12 mm.
    let beyond = 0.012 + 1.01 * KR500.largest_tool_speed() * PERIOD;
    let q = on_the_weld(0.0);
    let (setpoint, live) =
        (setpoint_at(&KR500, &q, Some(18e3)), sensed_at(&KR500, &q, &weld_wrench()));
    let nominal = setpoint.pose;
    let measurements = [DeviationMeasurement {
        deviation: 1e-4,
        along: Twist { linear: Vector3::y(), ..Twist::zero() },
        noise: 5e-5,
        age: PERIOD,
        ahead: 0.02,
    }];
    for entry in library() {
        for wrong in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, f64::MAX, -f64::MAX, beyond] {
            let mut law =
                entry.build(&Default::default(), &Setup::new(PERIOD, 1.0)).expect("its defaults");
            let mut robot =
                Compensated::new(parallel(), law.as_mut(), LATERAL, ORIENTATION, PERIOD);
            robot.start(&KR500, &q, &weight(&KR500, &q));
            for k in 0..300 {
                let sensed = trembling(&live, k);
                let observation = Observation {
                    path: if k == 100 { wrong } else { 1.2e-4 * k as f64 },
                    measurements: &measurements,
                    ..Observation::of_robot(&setpoint, &nominal, &sensed)
                };
                let fault = robot.cycle(&KR500, &observation).fault;
                let expected = (100..102).contains(&k).then_some(Fault::Compensation);
                assert_eq!(fault, expected, "{}: {wrong} at {k}", entry.name());
            }
        }
    }
}

proptest! {
    #[test]
    fn no_posture_moves_the_tool_faster_than_the_bound(q in regular_configuration()) {
        // Every joint at its largest speed, each either way.
        for signs in 0..64_u32 {
            let rate = JointVector::from_fn(|i, _| {
                let sign = if signs >> i & 1 == 0 { 1.0 } else { -1.0 };
                sign * KR500.parameters().joints[i].max_rate
            });
            let speed = KR500.frames(&q).twist(&rate).linear.norm();
            prop_assert!(speed <= KR500.largest_tool_speed() * ROUNDING);
        }
    }
}

#[test]
fn correction_waits_for_the_force_loop_and_moves_the_set_point() {
    let (q, w) = (on_the_weld(0.0), weld_wrench());
    let nominal = KR500.forward_kinematics(&q);
    let at = KR500.fake_target(&q, &Wrench::zero());
    let open = setpoint_at(&KR500, &at, None);
    let sensed = sensed_at(&KR500, &at, &w);
    let law = elastostatic(4.0);
    let mut robot = Compensated::new(parallel(), law, LATERAL, ORIENTATION, PERIOD);
    robot.start(&KR500, &at, &weight(&KR500, &at));
    for _ in 0..10 {
        assert_eq!(
            robot.cycle(&KR500, &Observation::of_robot(&open, &nominal, &sensed)).fault,
            None
        );
        assert_eq!(robot.correction(), Twist::zero());
    }
    let closed = Setpoint { force: Some(18e3), ..open };
    for k in 0..2000 {
        let sensed = trembling(&sensed, k);
        robot.cycle(&KR500, &Observation::of_robot(&closed, &nominal, &sensed));
    }
    // Long after, the correction is the demand but for depth and the limits' slack: e^(−3·24) is
    // nothing.
    let mut fresh = elastostatic(4.0);
    let observation = Observation::of_robot(&closed, &nominal, &sensed);
    let demand = fresh.demand(&KR500, &observation).unwrap();
    let mut expected = demand;
    expected.linear.z = 0.0;
    assert!(expected.linear.norm() < LATERAL.size && expected.angular.norm() < ORIENTATION.size);
    assert!((robot.correction() - expected).to_vector().amax() < 1e-12);
    // A new weld starts with nothing corrected.
    robot.start(&KR500, &at, &weight(&KR500, &at));
    assert_eq!(robot.correction(), Twist::zero());
}

#[test]
fn no_law_takes_back_what_teaching_put_right() {
    // The fourth axis off by 1 mm and 1 mrad, all joints a fifth stiffer than the model's.
    let mut parameters = kr500_parameters::<f64>();
    let joint = &mut parameters.joints[3];
    joint.origin.y += 1e-3;
    joint.axis = rotation_from_vector(&(Vector3::y() * 1e-3)) * joint.axis;
    parameters.joints.iter_mut().for_each(|joint| joint.stiffness *= 1.2);
    let real = Robot::new(parameters).expect("a robot");
    // Free of load it stands on the nominal pose, and that is where the set-point is taught.
    let nominal = vertical_weld_pose(-0.5);
    let link = real_inverse_near(&real, &KR500, &nominal, &on_the_weld(-0.5)).expect("in reach");
    let torque = weight(&real, &link);
    let encoder = link + torque.component_div(real.stiffness());
    let setpoint = setpoint_at(&KR500, &encoder, Some(0.0));
    let off = nominal.error_to(&setpoint.pose).to_vector().amax();
    assert!(off > 0.5e-3, "the model is off by {off} m or rad there");
    for entry in library() {
        let mut law =
            entry.build(&Default::default(), &Setup::new(PERIOD, 1.0)).expect("its defaults");
        let mut robot = Compensated::new(parallel(), law.as_mut(), LATERAL, ORIENTATION, PERIOD);
        robot.start(&KR500, &encoder, &torque);
        for k in 0..200 {
            let at_rest = sensed_at(&KR500, &encoder, &Wrench::zero());
            let sensed = SensorReadings { motor_torque: torque, ..trembling(&at_rest, k) };
            robot.cycle(&KR500, &Observation::of_robot(&setpoint, &nominal, &sensed));
        }
        // Second order: the weight of an arm that is turned by 1 mrad.
        let corrected = robot.correction().to_vector().amax();
        assert!(corrected < 0.01 * off, "{}: {corrected} m or rad", entry.name());
    }
}
