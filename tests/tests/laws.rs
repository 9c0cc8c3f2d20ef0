//! The laws that see more, or less, than a wrench: each in a world where its answer is known, and
//! with sensors gone wrong.
//!
//! The world is at rest at all times: encoders stand where set-point and demand put them, and the
//! real tool where springs of the true stiffness let it. What the dynamics make of a law is for
//! `published.rs`.

use nalgebra::{SVector, Vector3};
use proptest::prelude::*;
use std::cell::Cell;
use trueweld_compensators::{
    Adaptive, AdaptiveGains, BuildError, Combined, CombinedGains, Elastostatic, ElastostaticGains,
    Entry, FeedForward, FollowingGains, GainTables, Learning, Observer, ObserverGains,
    OuterIntegral, SeamTracking, Setup, TrackingGains, find, library,
};
use trueweld_core::compensation::{Compensator, DeviationMeasurement, Observation};
use trueweld_core::control::{SensorReadings, Setpoint};
use trueweld_core::{Fault, JointVector, Pose, Robot, Twist, Wrench};
use trueweld_tests::{
    KR500, PERIOD, cases, pose_difference, sensed_at, setpoint_at, vertical_weld_pose, weight,
    weld_wrench, wild,
};

const FEED: f64 = 0.010;
const AHEAD: f64 = 0.020;
const TRACKING: TrackingGains = TrackingGains { rate_rad_s: 8.0, seam_shape_s_m: 0.0 };

/// A cell at rest.
struct World {
    real: Robot<f64>,
    encoder: JointVector<f64>,
    /// Of the seam beside its taught line, m, by path position.
    shape: fn(f64) -> f64,
}

impl World {
    fn new(stiffness: f64) -> Self {
        let encoder = on_the_weld(0.0);
        let real = KR500.with_stiffness_scaled(&SVector::repeat(stiffness)).expect("a robot");
        Self { real, encoder, shape: |_| 0.0 }
    }

    /// One period at a path position; the real tool's deviation from the seam, axes of W.
    fn step(&mut self, law: &mut dyn Compensator<f64>, path: f64, see: bool) -> Twist<f64> {
        let nominal = vertical_weld_pose(path - 0.5);
        let setpoint = Setpoint {
            pose: nominal,
            b_from_w: weld_axes(),
            force: Some(18e3),
            spindle_speed: 0.0,
        };
        let sensed = sensed_at(&KR500, &self.encoder, &weld_wrench());
        let deviation = self.deviation(&nominal);
        let shape =
            |path| Twist { angular: Vector3::zeros(), linear: Vector3::y() * (self.shape)(path) };
        let seen = seam_sensor(&(deviation - shape(path + AHEAD)));
        let observation = Observation {
            path,
            planned: weld_wrench().rotated(&(weld_axes().transpose() * nominal.rotation)),
            measurements: if see { &seen } else { &[] },
            ..Observation::of_robot(&setpoint, &nominal, &sensed)
        };
        let demand = law.demand(&KR500, &observation).expect("a demand");
        let wanted = nominal.displaced(&demand.rotated(&weld_axes()));
        self.encoder = KR500.inverse_near(&wanted, &self.encoder).expect("within reach");
        self.deviation(&nominal) - shape(path)
    }

    fn deviation(&self, nominal: &Pose<f64>) -> Twist<f64> {
        let real = self.real.deflected(&self.encoder, &weld_wrench(), 8).real;
        nominal.error_to(&real).rotated(&weld_axes().transpose())
    }

    /// A whole pass; root mean square of the lateral deviation after the first 0.1 m.
    fn pass(&mut self, law: &mut dyn Compensator<f64>) -> f64 {
        law.reset();
        for _ in 0..200 {
            self.step(law, 0.0, true);
        }
        let along = (0..8333).map(|k| f64::from(k) * FEED * PERIOD);
        let lateral: Vec<f64> = along
            .map(|path| (path, self.step(law, path, true)))
            .filter(|(p, _)| *p > 0.1)
            .map(|(_, d)| d.linear.y)
            .collect();
        (lateral.iter().map(|y| y * y).sum::<f64>() / lateral.len() as f64).sqrt()
    }
}

fn weld_axes() -> nalgebra::Matrix3<f64> {
    // Tool down, seam along +Y of B: x of W along the seam, z into the plate.
    let (x, z) = (Vector3::y(), -Vector3::z());
    nalgebra::Matrix3::from_columns(&[x, z.cross(&x), z])
}

fn on_the_weld(y: f64) -> JointVector<f64> {
    let all = KR500.inverse_all(&vertical_weld_pose(y)).unwrap();
    all.iter()
        .map(|(_, q)| *q)
        .find(|q| KR500.beyond_limits(q).is_none())
        .expect("a branch within the limits")
}

fn measurement(deviation: f64, along: Twist<f64>) -> DeviationMeasurement<f64> {
    DeviationMeasurement { deviation, along, noise: 5e-5, age: 0.0, ahead: AHEAD }
}

fn seam_sensor(deviation: &Twist<f64>) -> [DeviationMeasurement<f64>; 2] {
    let across = Twist { angular: Vector3::z() * AHEAD, linear: Vector3::y() };
    let tilted = Twist { angular: Vector3::x(), linear: Vector3::zeros() };
    [across, tilted].map(|along| measurement(along.to_vector().dot(&deviation.to_vector()), along))
}

fn elastostatic(crosstalk: [f64; 2]) -> Elastostatic<f64> {
    let gains = ElastostaticGains { crosstalk, ..ElastostaticGains::default() };
    Elastostatic::new(&gains, PERIOD).expect("a corner below Nyquist")
}

/// `bandwidth`: rad/s.
fn observer(bandwidth: f64) -> Observer<f64> {
    let gains = ObserverGains { bandwidth_hz: bandwidth / std::f64::consts::TAU };
    Observer::new(&gains, PERIOD).expect("a bandwidth")
}

/// A law as control files without gains have it.
fn built(law: &Entry) -> Box<dyn Compensator<f64>> {
    let setup = Setup::new(PERIOD, 1.0);
    law.build(&GainTables::new(), &setup).expect("defaults suit the period")
}

#[test]
fn feed_forward_is_the_elastostatic_law_of_the_planned_load() {
    let q = on_the_weld(0.2);
    let (setpoint, nominal) = (setpoint_at(&KR500, &q, Some(18e3)), KR500.forward_kinematics(&q));
    let sensed = sensed_at(&KR500, &q, &weld_wrench());
    let planned = weld_wrench().rotated(&(setpoint.b_from_w.transpose() * nominal.rotation));
    let observation =
        Observation { planned, ..Observation::of_robot(&setpoint, &nominal, &sensed) };
    let measured = elastostatic([0.0; 2]).demand(&KR500, &observation).unwrap();
    let planned = FeedForward.demand(&KR500, &observation).unwrap();
    assert!((measured - planned).to_vector().amax() < 1e-12);
}

#[test]
fn calibrated_crosstalk_is_taken_out() {
    let q = on_the_weld(0.2);
    let (setpoint, nominal) = (setpoint_at(&KR500, &q, Some(18e3)), KR500.forward_kinematics(&q));
    let mut sensed = sensed_at(&KR500, &q, &weld_wrench());
    let clean = Observation::of_robot(&setpoint, &nominal, &sensed);
    let wanted = elastostatic([0.0; 2]).demand(&KR500, &clean).unwrap();
    let [x, y] = [0.02, -0.01];
    sensed.wrench.force.x += x * sensed.wrench.force.z;
    sensed.wrench.force.y += y * sensed.wrench.force.z;
    let crossed = Observation::of_robot(&setpoint, &nominal, &sensed);
    let mut law = elastostatic([0.0; 2]);
    let off = (law.demand(&KR500, &crossed).unwrap() - wanted).linear.norm();
    assert!(off > 0.1e-3, "cross-talk of 2 % moves the tool: {off} m");
    let mut law = elastostatic([x, y]);
    assert!((law.demand(&KR500, &crossed).unwrap() - wanted).to_vector().amax() < 1e-12);
}

#[test]
fn the_observer_finds_the_load_of_a_resting_arm_from_its_motors() {
    // At rest the motors carry what the springs do: gravity less the counterbalance less the load.
    let link = on_the_weld(0.1);
    let nominal = KR500.forward_kinematics(&link);
    let frames = KR500.frames(&link);
    let load = Wrench {
        moment: Vector3::new(20.0, -30.0, 10.0),
        force: Vector3::new(900.0, -4000.0, 18e3),
    };
    let torque = KR500.spring_torque_at_rest(&frames, &link, &load);
    let encoder = link + torque.component_div(KR500.stiffness());
    let setpoint = setpoint_at(&KR500, &link, Some(18e3));
    let sensed =
        SensorReadings { motor_torque: torque, ..sensed_at(&KR500, &encoder, &Wrench::zero()) };
    let mut law = observer(30.0);
    let demand = law.demand(&KR500, &Observation::of_robot(&setpoint, &nominal, &sensed)).unwrap();
    assert!((law.link(&KR500, &encoder) - link).amax() < 1e-12);
    let found = law.wrench(&KR500, &encoder).unwrap();
    assert!((found - load).to_vector().amax() < 1e-6, "{found:?}");
    // It demands just the pose that the encoders have: the real tool is where it should be.
    let there = setpoint.pose.displaced(&demand.rotated(&setpoint.b_from_w));
    assert!(pose_difference(&there, &KR500.forward_kinematics(&encoder)) < 1e-9);
}

#[test]
fn the_observer_follows_a_load_with_its_bandwidth() {
    let link = on_the_weld(0.1);
    let (nominal, setpoint) =
        (KR500.forward_kinematics(&link), setpoint_at(&KR500, &link, Some(18e3)));
    let rest = weight(&KR500, &link);
    let mut law = observer(10.0);
    let mut see = |torque: JointVector<f64>| {
        let sensed =
            SensorReadings { motor_torque: torque, ..sensed_at(&KR500, &link, &Wrench::zero()) };
        law.demand(&KR500, &Observation::of_robot(&setpoint, &nominal, &sensed)).unwrap();
        law.spring_torque()
    };
    see(rest);
    let mut torque = rest;
    torque[1] += 1000.0;
    let mut last = rest;
    for k in 1..=50 {
        last = see(torque);
        let expected = 1000.0 * (1.0 - (-10.0 * PERIOD * f64::from(k)).exp());
        assert!((last[1] - rest[1] - expected).abs() < 1e-6, "{k}");
    }
    assert!((last[1] - torque[1]).abs() < 3.0);
}

#[test]
fn a_seam_sensor_corrects_what_a_wrong_stiffness_leaves() {
    for stiffness in [0.7, 1.3] {
        let left = World::new(stiffness).pass(&mut FeedForward);
        assert!(left > 0.5e-3, "feed-forward alone is off by the stiffness: {left} m");
        let mut law = SeamTracking::new(FeedForward, &TRACKING, PERIOD).unwrap();
        let left = World::new(stiffness).pass(&mut law);
        // What is left: look-ahead times the yaw that nobody sees, 20 mm × 1 mrad.
        assert!(left < 0.03e-3, "{left} m at {stiffness}");
    }
}

#[test]
fn a_lost_sensor_leaves_the_correction_where_it_was() {
    let mut world = World::new(0.7);
    let mut law = SeamTracking::new(FeedForward, &TRACKING, PERIOD).unwrap();
    for _ in 0..500 {
        world.step(&mut law, 0.3, true);
    }
    let before = world.step(&mut law, 0.3, true).linear.y;
    for _ in 0..1000 {
        let now = world.step(&mut law, 0.3, false).linear.y;
        assert!((now - before).abs() < 1e-9, "{now} m, before {before} m");
    }
}

#[test]
fn preview_follows_a_seam_that_bends_where_the_tool_is() {
    // A seam that swings 0.5 mm to either side over 100 mm. Taken for the tool's own deviation it
    // is followed 20 mm too early.
    let swing = |path: f64| 0.5e-3 * (path * std::f64::consts::TAU / 0.1).sin();
    let follow = |shape: f64| {
        let mut world = World { shape: swing, ..World::new(1.0) };
        let gains = TrackingGains { seam_shape_s_m: shape, ..TRACKING };
        world.pass(&mut SeamTracking::new(FeedForward, &gains, PERIOD).unwrap())
    };
    let (early, in_time) = (follow(0.0), follow(1e4));
    // sin(2π s/0.1) against the same 20 mm on: 2 sin(2π 0.02/0.1 / 2) / √2 of the amplitude.
    assert!((early - 0.416e-3).abs() < 0.03e-3, "{early} m");
    assert!(in_time < 0.1e-3, "{in_time} m");
}

#[test]
fn the_adaptive_law_learns_compliances_from_a_tracker_and_keeps_them() {
    let truth = JointVector::from([0.75, 1.2, 1.3, 0.8, 1.25, 0.7]);
    let real = KR500.with_stiffness_scaled(&truth).unwrap();
    let mut law = Adaptive::new(&AdaptiveGains::default(), PERIOD).unwrap();
    let prior: Vec<f64> = law.compliance().iter().map(|(_, d)| *d).collect();
    let mut encoder = on_the_weld(0.0);
    // A tracker sees the whole pose all along; loads turn, so that every joint is asked.
    for k in 0..6000 {
        let path = f64::from(k) * FEED * PERIOD;
        let nominal = vertical_weld_pose(path - 0.4);
        let turn = f64::from(k) * 0.01;
        let load = Wrench {
            moment: Vector3::new(300.0 * turn.cos(), 300.0 * turn.sin(), 500.0),
            force: Vector3::new(4e3 * turn.sin(), 4e3 * turn.cos(), -18e3),
        };
        let setpoint = Setpoint {
            pose: nominal,
            b_from_w: weld_axes(),
            force: Some(18e3),
            spindle_speed: 0.0,
        };
        let in_t = load.rotated(&(nominal.rotation.transpose() * weld_axes()));
        let sensed = sensed_at(&KR500, &encoder, &in_t);
        let deviation = nominal
            .error_to(&real.deflected(&encoder, &in_t, 8).real)
            .rotated(&weld_axes().transpose())
            .to_vector();
        let seen: Vec<DeviationMeasurement<f64>> = (0..6)
            .map(|i| {
                let mut along = SVector::<f64, 6>::zeros();
                along[i] = 1.0;
                measurement(deviation[i], Twist::from_vector(&along))
            })
            .collect();
        let observation = Observation {
            path,
            planned: load,
            measurements: &seen,
            ..Observation::of_robot(&setpoint, &nominal, &sensed)
        };
        let demand = law.demand(&KR500, &observation).unwrap();
        encoder = KR500
            .inverse_near(&nominal.displaced(&demand.rotated(&weld_axes())), &encoder)
            .unwrap();
        for ((_, deviation), prior) in law.compliance().iter().zip(&prior) {
            assert!(
                deviation.is_finite() && *deviation <= prior * (1.0 + 1e-9),
                "{deviation} above the prior {prior}"
            );
        }
    }
    law.reset();
    for (i, (found, deviation)) in law.compliance().iter().enumerate() {
        let expected = 1.0 / truth[i] - 1.0;
        assert!(
            (found - expected).abs() < 0.03,
            "A{}: {found} ± {deviation}, true {expected}",
            i + 1
        );
    }
}

#[test]
fn nothing_is_learned_of_the_robot_where_the_tool_stands() {
    let mut world = World::new(0.7);
    let mut law = Adaptive::new(&AdaptiveGains::default(), PERIOD).unwrap();
    let before = law.compliance();
    for _ in 0..2000 {
        world.step(&mut law, 0.3, true);
    }
    assert_eq!(before, law.compliance());
}

#[test]
fn a_frozen_law_learns_nothing_that_stays() {
    let mut adaptive = Adaptive::new(&AdaptiveGains::default(), PERIOD).unwrap();
    adaptive.freeze();
    let before = adaptive.compliance();
    let left = World::new(0.7).pass(&mut adaptive);
    assert_eq!(before, adaptive.compliance());
    // Feed-forward alone is off by more than 0.5 mm; offsets reach three times as far as is
    // believed of them, and no farther.
    assert!(left < 0.25e-3, "its offsets go on following: {left} m");
    let mut learning = Learning::new(FeedForward, 1.0, 1.0, PERIOD).unwrap();
    learning.freeze();
    let [first, second] = [(); 2].map(|()| World::new(0.7).pass(&mut learning));
    assert!(first > 0.5e-3 && first == second, "{first} m, then {second} m");
}

#[test]
fn a_second_pass_needs_no_sensor_to_be_better() {
    for stiffness in [0.7, 1.3] {
        let mut law = Learning::new(FeedForward, 1.0, 1.0, PERIOD).unwrap();
        let first = World::new(stiffness).pass(&mut law);
        let second = World::new(stiffness).pass(&mut law);
        assert!(first > 0.5e-3 && second < 0.03e-3, "{first} m, then {second} m");
    }
}

/// Demands what it is told across the seam, or fails.
struct Told<'a>(&'a Cell<Result<f64, Fault>>);

impl Compensator<f64> for Told<'_> {
    fn reset(&mut self) {}

    fn demand(&mut self, _: &Robot<f64>, _: &Observation<'_, f64>) -> Result<Twist<f64>, Fault> {
        self.0.get().map(|y| Twist { angular: Vector3::zeros(), linear: Vector3::new(0.0, y, 0.0) })
    }
}

#[test]
fn the_outer_integral_makes_up_for_what_the_position_loop_lacks() {
    let q = on_the_weld(0.0);
    let (setpoint, load) = (setpoint_at(&KR500, &q, Some(18e3)), weld_wrench());
    let nominal = KR500.forward_kinematics(&q);
    let asked = Cell::new(Ok(1e-3));
    let following = FollowingGains { rate: 5.0, along: 5.0, size: 0.4e-3 };
    let mut law = OuterIntegral::new(Told(&asked), &following, PERIOD).unwrap();
    let mut ask = |stands: f64| {
        let there = setpoint.pose.displaced(
            &(Twist { linear: Vector3::y() * stands, ..Twist::zero() }).rotated(&setpoint.b_from_w),
        );
        let sensed = sensed_at(&KR500, &KR500.inverse_near(&there, &q).unwrap(), &load);
        law.demand(&KR500, &Observation::of_robot(&setpoint, &nominal, &sensed))
            .map(|demand| demand.linear)
    };
    // Drives that stand where they are told to, but for a lack of 0.3 mm: it is gone with the time
    // constant 1/μ.
    let lack = 0.3e-3;
    let mut told = 1e-3;
    for k in 1..=200 {
        told = ask(told - lack).unwrap().y;
        let left = lack * (1.0 - 5.0 * PERIOD).powi(k);
        assert!((told - lack - 1e-3 + left).abs() < 1e-8, "{told} m in period {k}");
    }
    // Drives that never come: held at its size, and nothing along the depth.
    for _ in 0..1000 {
        let demand = ask(0.0).unwrap();
        assert!(
            demand.z == 0.0
                && (demand - Vector3::new(0.0, 1e-3, 0.0)).norm() < following.size * (1.0 + 1e-9)
        );
    }
    asked.set(Err(Fault::Force));
    assert_eq!(ask(0.0), Err(Fault::Force), "a law without a demand has nothing to be followed");
}

#[test]
fn a_combination_goes_over_without_a_bump_and_within_its_authority() {
    let q = on_the_weld(0.0);
    let (setpoint, nominal) = (setpoint_at(&KR500, &q, Some(18e3)), KR500.forward_kinematics(&q));
    let sensed = sensed_at(&KR500, &q, &weld_wrench());
    let observation = Observation::of_robot(&setpoint, &nominal, &sensed);
    let gains = CombinedGains { max_translation_m: 5e-3, ..CombinedGains::default() };
    let (owner, other) = (Cell::new(Ok(3e-3)), Cell::new(Ok(1e-3)));
    let mut law = Combined::new(Told(&owner), Told(&other), &gains, PERIOD).unwrap();
    let mut ask = || law.demand(&KR500, &observation).map(|demand| demand.linear.y);
    assert_eq!(ask(), Ok(3e-3));
    // The owner fails and comes back: each time the output goes on from where it was, and the 2 mm
    // fade with their time constant.
    let most = 2e-3 * (1.0 - (-PERIOD / gains.fade_s).exp()) * (1.0 + 1e-9);
    let mut before = 3e-3;
    for (told, goal) in [(Err(Fault::Force), 1e-3), (Ok(3e-3), 3e-3)] {
        owner.set(told);
        for k in 0..400 {
            let y = ask().unwrap();
            assert!((y - before).abs() <= most, "{} m in period {k}", y - before);
            before = y;
        }
        assert!((before - goal).abs() < 2e-5);
    }
    // Neither may go further than the whole may, and with both gone the loops are told.
    owner.set(Ok(9e-3));
    assert!((ask().unwrap() - 5e-3).abs() < 1e-12);
    owner.set(Err(Fault::Force));
    other.set(Err(Fault::Compensation));
    assert_eq!(ask(), Err(Fault::Force));
}

#[test]
fn laws_are_combined_by_their_names() {
    let by_name = find("elastostatic+feed-forward").unwrap();
    assert!(by_name.name() == "elastostatic+feed-forward" && by_name.needs().force_sensor);
    // The elastostatic law owns rx and y, the planned load is half of the measured one.
    let table = toml::from_str("first_owns = [\"rx\", \"y\"]").unwrap();
    let gains = GainTables::from([(by_name.name().to_owned(), table)]);
    let mut law = by_name.build(&gains, &Setup::new(PERIOD, 1.0)).unwrap();
    let q = on_the_weld(0.2);
    let (setpoint, nominal) = (setpoint_at(&KR500, &q, Some(18e3)), KR500.forward_kinematics(&q));
    let sensed = sensed_at(&KR500, &q, &weld_wrench());
    let observation = Observation {
        planned: weld_wrench().rotated(&(setpoint.b_from_w.transpose() * nominal.rotation)) * 0.5,
        ..Observation::of_robot(&setpoint, &nominal, &sensed)
    };
    let ask = |law: &mut dyn Compensator<f64>| law.demand(&KR500, &observation).unwrap();
    let [measured, planned] =
        ["elastostatic", "feed-forward"].map(|name| ask(built(&find(name).unwrap()).as_mut()));
    let both = ask(law.as_mut()).to_vector();
    let [measured, planned] = [measured, planned].map(|demand| demand.to_vector());
    for (k, both) in both.iter().enumerate() {
        assert_eq!(*both, if [0, 4].contains(&k) { measured[k] } else { planned[k] }, "{k}");
    }
    assert!(measured != planned);

    assert_eq!(find("elastostatic+feed-forwrd").err(), Some("feed-forwrd"));
    assert_eq!(find("elastostatic+").err(), Some(""));
    let error = built_with(&by_name, "max_rotation_rad = -1.0").unwrap_err();
    assert_eq!(error.key, Some("max_rotation_rad"));
}

fn built_with(law: &Entry, gains: &str) -> Result<(), BuildError> {
    let gains = GainTables::from([(law.name().to_owned(), toml::from_str(gains).unwrap())]);
    law.build(&gains, &Setup::new(PERIOD, 1.0)).map(|_| ())
}

#[test]
fn every_law_has_a_name_of_its_own_and_refuses_gains_out_of_range() {
    for (k, law) in library().iter().enumerate() {
        assert!(library()[..k].iter().all(|other| other.name() != law.name()));
        for (key, default) in law.defaults() {
            if default.is_float() {
                let error = built_with(law, &format!("{key} = -1.0")).unwrap_err();
                assert_eq!((error.law.as_str(), error.key), (law.name(), Some(key.as_str())));
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(20))]

    #[test]
    fn whatever_the_sensors_say_demands_are_numbers_and_good_readings_bring_them_back(
        script in prop::collection::vec((wild(), wild(), wild(), 0..4_u8), 1..40),
    ) {
        for law in library().iter().filter(|law| law.needs().seam_sensor) {
            let mut law = built(law);
            let q = on_the_weld(0.0);
            let (setpoint, nominal) = (setpoint_at(&KR500, &q, Some(18e3)), KR500.forward_kinematics(&q));
            let sensed = sensed_at(&KR500, &q, &weld_wrench());
            let plain = Observation {
                planned: weld_wrench().rotated(&(setpoint.b_from_w.transpose() * nominal.rotation)),
                ..Observation::of_robot(&setpoint, &nominal, &sensed)
            };
            for (k, (value, other, third, kind)) in script.iter().enumerate() {
                let mut wrong = seam_sensor(&Twist::zero());
                match kind {
                    0 => wrong[0].deviation = *value,
                    1 => (wrong[0].age, wrong[1].noise) = (*value, *other),
                    2 => (wrong[0].ahead, wrong[0].along.linear.y) = (*value, *other),
                    _ => wrong[1].deviation = *third,
                }
                let path = if k % 3 == 0 { 0.1 } else { 0.1 + 1e-4 * k as f64 };
                let observation = Observation { measurements: &wrong, path, ..plain };
                let demand = law.demand(&KR500, &observation);
                prop_assert!(demand.is_ok_and(|d| d.is_finite()), "{:?} after {:?}", demand, wrong);
            }
            // What was learned of nonsense goes when good readings come: with this weld, or with
            // the next pass.
            law.reset();
            let mut world = World::new(1.0);
            for _ in 0..400 {
                world.step(law.as_mut(), 0.2, true);
            }
            law.reset();
            let off = (0..400).map(|_| world.step(law.as_mut(), 0.2, true)).last().expect("some steps");
            prop_assert!(off.linear.y.abs() < 0.1e-3, "{} m", off.linear.y);
        }
    }
}
