//! What property tests share: cases, random numbers, conversions between scalars.

// Public in one of the crates that take it.
#![allow(unreachable_pub)]

use nalgebra::SVector;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use trueweld_core::{Pose, Real};

/// The same numbers in another scalar, each rounded once.
pub fn cast<T: Real, const R: usize, const C: usize>(
    m: &nalgebra::SMatrix<f64, R, C>,
) -> nalgebra::SMatrix<T, R, C> {
    m.map(nalgebra::convert)
}

/// The same numbers in double precision, exactly.
pub fn widen<T: Real, const R: usize, const C: usize>(
    m: &nalgebra::SMatrix<T, R, C>,
) -> nalgebra::SMatrix<f64, R, C> {
    m.map(|x| number(x))
}

/// The same number in double precision, exactly.
pub fn number<T: Real>(x: T) -> f64 {
    nalgebra::convert_ref_unchecked::<T, f64>(&x)
}

/// Largest difference of two poses, m and rad: position, and the entries of the rotation matrices.
pub fn pose_difference<T: Real>(a: &Pose<T>, b: &Pose<T>) -> f64 {
    (widen(&a.position) - widen(&b.position))
        .amax()
        .max((widen(&a.rotation) - widen(&b.rotation)).amax())
}

/// An angle brought into [−π, π] by whole turns, rad.
pub fn wrapped(angle: f64) -> f64 {
    angle - (angle / core::f64::consts::TAU).round() * core::f64::consts::TAU
}

/// Settings of a property test: so many cases from a fixed seed, so that every run tries the same
/// ones.
pub fn cases(count: u32) -> Config {
    Config {
        cases: count,
        rng_seed: RngSeed::Fixed(2010),
        failure_persistence: None,
        ..Config::default()
    }
}

/// A vector with every entry within ± its bound.
pub fn within<const N: usize>(bound: SVector<f64, N>) -> impl Strategy<Value = SVector<f64, N>> {
    prop::array::uniform::<_, N>(-1.0..=1.0_f64)
        .prop_map(move |x| bound.component_mul(&SVector::from(x)))
}

/// Passes `value` on, and prints it where it is the largest seen of its kind: `--nocapture` shows
/// what a tolerance rests on.
pub fn seen(what: &'static str, value: f64) -> f64 {
    use std::{collections::BTreeMap, sync::Mutex};
    static LARGEST: Mutex<BTreeMap<&str, f64>> = Mutex::new(BTreeMap::new());
    let mut largest = LARGEST.lock().expect("no test panics while it holds this");
    let before = largest.entry(what).or_insert(0.0);
    if value > *before {
        *before = value;
        println!("{what}: {value:.1e}");
    }
    value
}

/// Any bit pattern of a number, with those that hurt most often: NaN, infinities, the ends of the
/// range.
pub fn wild() -> impl Strategy<Value = f64> {
    let bad = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        f64::MIN,
        1e200,
        -1e200,
        1e20,
        -1e20,
        0.0,
        -0.0,
    ];
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits),
        prop::sample::select(bad.to_vec()),
        -10.0..10.0_f64
    ]
}
