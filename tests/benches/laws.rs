//! Time that each compensation law takes of a control period, in the scalar of the controller and
//! in that of the host.
//!
//! Every period brings two readings of a seam sensor, the most a law has to do. The load turns and
//! the path goes on, so that no branch is taken every time.

use core::hint::black_box;
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Vector3;
use trueweld_compensators::{
    Combined, CombinedGains, Elastostatic, FeedForward, Law, SeamTracking, Setup, Visitor, for_each,
};
use trueweld_core::compensation::{Compensator, DeviationMeasurement, Observation};
use trueweld_core::scalar::lit;
use trueweld_core::{JointVector, Real, Twist, Wrench};
use trueweld_tests::{PERIOD, cast_wrench, kr500, sensed_at, setpoint_at, weld_wrench};

fn law<T: Real, L: Compensator<T>>(criterion: &mut Criterion, name: &str, mut law: L) {
    let robot = kr500::<T>();
    let q = JointVector::from([0.2, -0.9, 1.5, 0.3, 0.8, -0.4].map(lit::<T>));
    let (setpoint, nominal) =
        (setpoint_at(&robot, &q, Some(lit(18e3))), robot.forward_kinematics(&q));
    let load: Wrench<T> = cast_wrench(&weld_wrench());
    let across = Twist { angular: Vector3::z() * lit::<T>(0.02), linear: Vector3::y() };
    let tilted = Twist { angular: Vector3::x(), linear: Vector3::zeros() };
    let mut k = 0.0_f64;
    criterion.bench_function(name, |bencher| {
        bencher.iter(|| {
            k += 1.0;
            let turn = (0.7 * k).sin();
            let seen = [across, tilted].map(|along| DeviationMeasurement {
                deviation: lit(1e-4 * turn),
                along,
                noise: lit(5e-5),
                age: lit(PERIOD),
                ahead: lit(0.02),
            });
            let sensed = sensed_at(&robot, &q, &(load * lit(1.0 + 0.01 * turn)));
            let observation = Observation {
                path: lit((1.2e-4 * k) % 2.0),
                planned: load,
                measurements: &seen,
                ..Observation::of_robot(&setpoint, &nominal, &sensed)
            };
            law.demand(&robot, black_box(&observation))
        });
    });
}

/// Benches every law of the table with its defaults.
struct Bench<'a> {
    criterion: &'a mut Criterion,
    scalar: &'static str,
}

impl<T: Real> Visitor<T> for Bench<'_> {
    fn visit<L: Law<T>>(&mut self) {
        law::<T, _>(self.criterion, &format!("{}/{}", self.scalar, L::NAME), built::<T, L>());
    }
}

fn built<T: Real, L: Law<T>>() -> L::Built {
    let setup = Setup::new(lit(PERIOD), lit(2.0));
    L::build(&L::Gains::default(), &setup).expect("defaults suit the period")
}

fn laws<T: Real>(criterion: &mut Criterion, scalar: &'static str) {
    for_each::<T>(&mut Bench { criterion, scalar });
    let tracking = built::<T, SeamTracking<T, FeedForward>>();
    let stand_by = built::<T, Elastostatic<T>>();
    let combined = Combined::new(tracking, stand_by, &CombinedGains::default(), lit(PERIOD))
        .expect("limits above 0");
    law(criterion, &format!("{scalar}/seam-tracking+elastostatic"), combined);
}

fn all(criterion: &mut Criterion) {
    laws::<f32>(criterion, "f32");
    laws::<f64>(criterion, "f64");
}

criterion_group!(benches, all);
criterion_main!(benches);
