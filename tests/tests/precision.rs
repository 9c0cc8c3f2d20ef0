//! Single against double precision: the controller computes in `f32`, and this is what that costs.
//!
//! Both precisions are given the same inputs, rounded to `f32` once, so that what is compared is
//! the arithmetic.

use nalgebra::{SVector, Vector3};
use proptest::prelude::*;
use trueweld_compensators::{
    Elastostatic, ElastostaticGains, FeedForward, Law, SeamTracking, Setup, TrackingGains, Visitor,
    for_each,
};
use trueweld_core::compensation::{Compensator, DeviationMeasurement, Observation};
use trueweld_core::control::{SensorReadings, Setpoint};
use trueweld_core::scalar::lit;
use trueweld_core::{JOINTS, JointVector, Pose, Real, Twist, Wrench};
use trueweld_tests::{
    KR500, PERIOD, cases, cast, cast_pose, cast_wrench, controllers, kr500, number,
    pose_difference, regular_configuration, seen, weight, weld_wrench, widen, within,
};

fn cast_setpoint<T: Real>(s: &Setpoint<f64>) -> Setpoint<T> {
    Setpoint {
        pose: cast_pose(&s.pose),
        b_from_w: cast(&s.b_from_w),
        force: s.force.map(nalgebra::convert),
        spindle_speed: nalgebra::convert(s.spindle_speed),
    }
}

fn cast_sensed<T: Real>(s: &SensorReadings<f64>) -> SensorReadings<T> {
    SensorReadings {
        encoder: cast(&s.encoder),
        encoder_rate: cast(&s.encoder_rate),
        motor_torque: cast(&s.motor_torque),
        wrench: cast_wrench(&s.wrench),
    }
}

/// Each number rounded to f32 and widened again.
fn rounded<const R: usize, const C: usize>(
    m: &nalgebra::SMatrix<f64, R, C>,
) -> nalgebra::SMatrix<f64, R, C> {
    widen(&cast::<f32, R, C>(m))
}

/// A welding situation: the arm bent by the weld, a set-point some millimetres off, and slow rates.
fn situation(
    q: &JointVector<f64>,
    off: &SVector<f64, 6>,
    rate: &JointVector<f64>,
    load: f64,
) -> (Setpoint<f64>, SensorReadings<f64>) {
    let encoder = rounded(q);
    let actual = KR500.forward_kinematics(&encoder);
    let exact = actual.displaced(&Twist::from_vector(off));
    let pose = Pose { rotation: rounded(&exact.rotation), position: rounded(&exact.position) };
    let wrench = Wrench::from_vector(&rounded(&(weld_wrench() * load).to_vector()));
    (
        Setpoint {
            pose,
            b_from_w: rounded(&actual.rotation),
            force: Some(18e3),
            spindle_speed: -62.5,
        },
        SensorReadings {
            encoder,
            encoder_rate: rounded(rate),
            motor_torque: rounded(&weight(&KR500, &encoder)),
            wrench,
        },
    )
}

/// A seam sensor 20 mm ahead that misses the seam by so much.
fn measurements<T: Real>(miss: f64) -> [DeviationMeasurement<T>; 2] {
    let across = Twist { angular: Vector3::z() * lit::<T>(0.02), linear: Vector3::y() };
    let tilted = Twist { angular: Vector3::x(), linear: Vector3::zeros() };
    let ahead = lit(0.02);
    [
        DeviationMeasurement {
            deviation: lit(f64::from(miss as f32)),
            along: across,
            noise: lit(5e-5),
            age: T::zero(),
            ahead,
        },
        DeviationMeasurement {
            deviation: T::zero(),
            along: tilted,
            noise: lit(1e-3),
            age: T::zero(),
            ahead,
        },
    ]
}

struct Laws<T: Real>(Vec<(&'static str, Box<dyn Compensator<T>>)>);

impl<T: Real> Visitor<T> for Laws<T> {
    fn visit<L: Law<T>>(&mut self) {
        let setup = Setup::new(lit(PERIOD), lit(2.0));
        let law = L::build(&L::Gains::default(), &setup).expect("defaults suit the period");
        self.0.push((L::NAME, Box::new(law)));
    }
}

/// Every law of the table, and what its defaults leave idle: preview of the seam's shape.
fn laws<T: Real>() -> Vec<(&'static str, Box<dyn Compensator<T>>)> {
    let mut laws = Laws(Vec::new());
    for_each(&mut laws);
    let gains = TrackingGains { rate_rad_s: 10.0, seam_shape_s_m: 25.0 };
    let preview = SeamTracking::new(FeedForward, &gains, lit(PERIOD)).expect("gains in range");
    laws.0.push(("seam-tracking with preview", Box::new(preview)));
    laws.0
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn one_cycle_of_each_controller(
        q in regular_configuration(),
        off in within(SVector::from([1e-3, 1e-3, 1e-3, 5e-3, 5e-3, 5e-3])),
        rate in within(JointVector::repeat(0.02)),
        load in 0.5..1.0_f64,
    ) {
        let single = kr500::<f32>();
        let (setpoint, sensed) = situation(&q, &off, &rate, load);
        let started = weight(&KR500, &sensed.encoder);
        for ((name, mut wide), (_, mut narrow)) in controllers::<f64>().into_iter().zip(controllers::<f32>()) {
            wide.start(&KR500, &sensed.encoder, &started);
            narrow.start(&single, &cast(&sensed.encoder), &cast(&started));
            let share = |wide: &JointVector<f64>, narrow: &JointVector<f32>| {
                let apart = widen(narrow) - wide;
                (0..JOINTS).map(|i| apart[i].abs() / KR500.parameters().joints[i].max_torque).fold(0.0, f64::max)
            };
            let (setpoint32, sensed32) = (cast_setpoint::<f32>(&setpoint), cast_sensed::<f32>(&sensed));
            let (a, b) = (wide.cycle(&KR500, &setpoint, &sensed), narrow.cycle(&single, &setpoint32, &sensed32));
            prop_assert_eq!(a.fault, b.fault, "{}", name);
            // A pose at 3.5 m is known to 2–4e-7 m in f32; through J⁻¹ (up to some 10 rad/m) and
            // K_p (3e6 N·m/rad) that is up to 10 N·m of drives that give 29 kN·m: measured 1.8e-4
            // of the limit.
            let off = seen("torque of the first cycle, share of the drive's limit", share(&a.torque, &b.torque));
            prop_assert!(off < 5e-4, "{name}: f32 is off by {off:e} of the limit");
            prop_assert!((a.force_error - number(b.force_error)).abs() < 0.05, "{name}: force error");
            prop_assert!((a.push - number(b.push)).abs() < 0.1, "{name}: push");
            prop_assert!((a.depth_correction - number(b.depth_correction)).abs() < 1e-8, "{name}: depth");

            // The second cycle adds K_d d/dt: the same error of a pose difference, over a period of
            // 12 ms. The arm has moved on by a period. Measured 1.9e-3 of the limit.
            let mut next = sensed;
            next.encoder = rounded(&(sensed.encoder + rate * PERIOD));
            let (a, b) = (wide.cycle(&KR500, &setpoint, &next), narrow.cycle(&single, &setpoint32, &cast_sensed(&next)));
            let off = seen("torque of the second cycle, share of the drive's limit", share(&a.torque, &b.torque));
            prop_assert!(off < 5e-3, "{name}: f32 is off by {off:e} of the limit in the second cycle");
        }
    }

    #[test]
    fn the_elastostatic_law(q in regular_configuration(), load in 0.0..1.0_f64) {
        let single = kr500::<f32>();
        let (setpoint, sensed) = situation(&q, &SVector::zeros(), &JointVector::zeros(), load);
        let nominal = setpoint.pose;
        let mut wide = Elastostatic::new(&ElastostaticGains::default(), PERIOD).unwrap();
        let mut narrow = Elastostatic::new(&ElastostaticGains::default(), PERIOD as f32).unwrap();
        let a = wide.demand(&KR500, &Observation::of_robot(&setpoint, &nominal, &sensed)).unwrap();
        let (setpoint32, sensed32) = (cast_setpoint::<f32>(&setpoint), cast_sensed::<f32>(&sensed));
        let nominal32 = cast_pose(&nominal);
        let b = narrow
            .demand(&single, &Observation::of_robot(&setpoint32, &nominal32, &sensed32))
            .unwrap();
        // Inverse kinematics and forward again: the pose's own 2e-6 m near the rim of the regular
        // region; measured 1.1e-6.
        let linear = seen("elastostatic demand, m", (widen(&b.linear) - a.linear).amax());
        let angular = seen("elastostatic demand, rad", (widen(&b.angular) - a.angular).amax());
        prop_assert!(linear < 4e-6 && angular < 4e-6, "{linear:e} m, {angular:e} rad");
    }

    #[test]
    fn every_law(q in regular_configuration(), load in 0.1..1.0_f64, miss in -1e-3..1e-3_f64) {
        let single = kr500::<f32>();
        let (setpoint, sensed) = situation(&q, &SVector::zeros(), &JointVector::zeros(), load);
        let (setpoint32, sensed32) = (cast_setpoint::<f32>(&setpoint), cast_sensed::<f32>(&sensed));
        let (nominal, nominal32) = (setpoint.pose, cast_pose(&setpoint.pose));
        let planned = weld_wrench() * load;
        let seen_by = measurements::<f64>(miss);
        let seen_by32 = measurements::<f32>(miss);
        for ((name, mut wide), (_, mut narrow)) in laws::<f64>().into_iter().zip(laws::<f32>()) {
            // A second of even feed, the sensor seeing the same: what is learned of it included.
            for k in 0..80 {
                let path = 0.2 + 1.2e-4 * f64::from(k);
                let a = wide.demand(&KR500, &Observation {
                    path,
                    planned,
                    measurements: &seen_by,
                    ..Observation::of_robot(&setpoint, &nominal, &sensed)
                });
                let b = narrow.demand(&single, &Observation {
                    path: path as f32,
                    planned: cast_wrench(&planned),
                    measurements: &seen_by32,
                    ..Observation::of_robot(&setpoint32, &nominal32, &sensed32)
                });
                let (a, b) = (a.unwrap(), b.unwrap());
                // The pose's own 2e-6 m near the rim of the regular region, and for laws that learn
                // what they make of it.
                let linear = seen(name, (widen(&b.linear) - a.linear).amax());
                let angular = (widen(&b.angular) - a.angular).amax();
                prop_assert!(linear < 1e-5 && angular < 1e-5, "{name}, period {k}: {linear:e} m, {angular:e} rad");
            }
        }
    }

    #[test]
    fn the_predicted_deflection(q in regular_configuration(), load in 0.0..1.0_f64) {
        let q = rounded(&q);
        let wide = KR500.deflected(&q, &(weld_wrench() * load), 5);
        let single = kr500::<f32>();
        let narrow = single.deflected(&cast(&q), &cast_wrench(&(weld_wrench() * load)), 3);
        let off = seen("real pose, m", pose_difference(&cast_pose(&wide.real), &narrow.real));
        // A pose at 3.5 m in f32, ulp 2.4e-7: measured 7e-7.
        prop_assert!(off < 2e-6, "{off:e} m");
        let displaced = (widen(&narrow.displacement().to_vector()) - wide.displacement().to_vector()).amax();
        let displaced = seen("displacement, m", displaced);
        prop_assert!(displaced < 2e-6, "{displaced:e} m");
    }
}

#[test]
fn gravity_feed_forward_in_single_precision_is_far_below_friction() {
    // The least Coulomb friction of any drive, 80 N·m, hides what f32 gets wrong in the weight by a
    // factor of 1e3.
    let single = kr500::<f32>();
    let q = JointVector::from([0.3, -0.9, 1.4, 0.5, 0.9, -0.2]);
    let off = (widen(&weight(&single, &cast(&q))) - weight(&KR500, &q)).amax();
    assert!(off < 0.08, "{off} N·m");
    assert_eq!(
        Vector3::from(cast::<f32, 3, 1>(&KR500.parameters().gravity)),
        single.parameters().gravity
    );
}
