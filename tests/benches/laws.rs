//! Time that each compensation law takes of a control period, in the scalar of the controller and
//! in that of the host.
//!
//! Every period brings two readings of a seam sensor, the most a law has to do. The load turns and
//! the path goes on, so that no branch is taken every time.

use core::hint::black_box;
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Vector3;
use trueweld_compensators::{
    Adaptive, Combined, CorrectionLimits, Elastostatic, FeedForward, FollowingGains, Learning,
    Observer, OuterIntegral, Prior, SeamTracking, TrackingGains,
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
                sightings: &seen,
                ..Observation::of_robot(&setpoint, &nominal, &sensed)
            };
            law.demand(&robot, black_box(&observation))
        });
    });
}

fn laws<T: Real>(criterion: &mut Criterion, scalar: &str) {
    let name = |law: &str| format!("{scalar}/{law}");
    let period = lit::<T>(PERIOD);
    let elastostatic = || Elastostatic::new(lit::<T>(5.0), period).expect("a corner below Nyquist");
    let tracking = TrackingGains { rate: lit(10.0), shape: lit(25.0) };
    let tracker = || SeamTracking::new(FeedForward, tracking, period).expect("a rate");
    let following = FollowingGains { rate: lit(8.0), size: lit(2e-3) };
    let followed = OuterIntegral::new(tracker(), following, period).expect("a rate");
    let prior =
        Prior { compliance: lit(0.3), force: lit(0.3), tilt: lit(5e-4), lateral: lit(5e-4) };
    let authority =
        CorrectionLimits { displacement: lit(5e-3), rotation: lit(0.08), fade: lit(0.5) };
    let combined = Combined::new(tracker(), elastostatic(), [true; 6], authority, period)
        .expect("an authority");
    law(criterion, &name("elastostatic"), elastostatic());
    law::<T, _>(criterion, &name("feed-forward"), FeedForward);
    law(criterion, &name("observer"), Observer::new(lit(30.0), period).expect("a bandwidth"));
    law(criterion, &name("seam-tracking"), tracker());
    law(criterion, &name("seam-tracking with outer integral"), followed);
    law(criterion, &name("adaptive"), Adaptive::new(prior, period).expect("a prior"));
    law(
        criterion,
        &name("learning"),
        Learning::new(FeedForward, lit(2.0), lit(1.0), period).expect("a length"),
    );
    law(criterion, &name("seam-tracking, elastostatic to fall back on"), combined);
}

fn all(criterion: &mut Criterion) {
    laws::<f32>(criterion, "f32");
    laws::<f64>(criterion, "f64");
}

criterion_group!(benches, all);
criterion_main!(benches);
