//! Rotations, poses and displacements: closed-form identities, in both precisions.

use crate::support::{cases, cast, number, pose_difference, within};
use nalgebra::{Matrix3, SVector, Vector3};
use proptest::prelude::*;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector, skew};
use trueweld_core::{Pose, Real, Twist, Wrench};

/// Machine epsilon of the scalar.
fn epsilon<T: Real>() -> f64 {
    number(T::default_epsilon())
}

fn direction() -> impl Strategy<Value = Vector3<f64>> {
    within(Vector3::repeat(1.0))
        .prop_filter("too short", |v| v.norm() > 0.1)
        .prop_map(|v| v.normalize())
}

/// An angle of any size that matters: across (0, π), within 1e-12 … 1e-1 of 0, and within the same
/// of π.
fn angle() -> impl Strategy<Value = f64> {
    let small = || (-12.0..-1.0_f64).prop_map(|e| 10.0_f64.powf(e));
    prop_oneof![
        0.0..core::f64::consts::PI,
        small(),
        small().prop_map(|a| core::f64::consts::PI - a)
    ]
}

fn pose() -> impl Strategy<Value = Pose<f64>> {
    (direction(), 0.0..core::f64::consts::PI, within(Vector3::repeat(3.0))).prop_map(
        |(axis, angle, position)| Pose {
            rotation: rotation_from_vector(&(axis * angle)),
            position,
        },
    )
}

fn round_trip<T: Real>(axis: &Vector3<f64>, angle: f64) {
    let r = cast::<T, 3, 1>(&(axis * angle));
    let m = rotation_from_vector(&r);
    // Entries of a few products each, whose terms reach 2 near half a turn: measured 8 ε.
    let skewed = number((m * m.transpose() - Matrix3::identity()).amax()) / epsilon::<T>();
    assert!(skewed < 16.0, "not orthogonal by {skewed} ε at {angle:e}");
    assert!(number((m.determinant() - T::one()).abs()) < 16.0 * epsilon::<T>(), "not proper");
    // A rotation leaves its own axis alone.
    assert!(number((m * r - r).norm()) <= 8.0 * epsilon::<T>() * angle);
    let back = rotation_vector(&m);
    // At π the axis is defined but for its sign, and rounding may choose either.
    let off = (back - r).norm().min((back + r).norm());
    let off = number(if angle > 3.0 { off } else { (back - r).norm() });
    // Relative to the angle: near 0 the vector must keep its digits, near π the axis must.
    assert!(
        off <= 8.0 * epsilon::<T>() * angle.max(1e-12),
        "log(exp) is off by {off:e} at {angle:e}"
    );
    let again = rotation_from_vector(&back);
    assert!(number((again - m).amax()) <= 16.0 * epsilon::<T>(), "exp(log) is off at {angle:e}");
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn exponential_and_logarithm_undo_each_other(axis in direction(), angle in angle()) {
        round_trip::<f64>(&axis, angle);
        round_trip::<f32>(&axis, angle);
    }

    #[test]
    fn rotation_agrees_with_the_axis_angle_form_of_another_library(axis in direction(), angle in angle()) {
        let other = nalgebra::Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(axis), angle);
        let off = (rotation_from_vector(&(axis * angle)) - other.matrix()).amax();
        prop_assert!(off < 8.0 * f64::EPSILON, "off by {off:e}");
    }

    #[test]
    fn skew_is_the_cross_product(a in within(Vector3::repeat(5.0)), b in within(Vector3::repeat(5.0))) {
        // Each entry is one rounded difference of two rounded products of up to 25.
        prop_assert!((skew(&a) * b - a.cross(&b)).amax() <= 100.0 * f64::EPSILON);
        prop_assert_eq!(skew(&a), -skew(&a).transpose());
    }

    #[test]
    fn poses_form_a_group(a in pose(), b in pose(), c in pose(), p in within(Vector3::repeat(3.0))) {
        // Metres up to 12, some tens of operations: 1e-13 is 40 ε of that.
        prop_assert!(pose_difference(&((a * b) * c), &(a * (b * c))) < 1e-13);
        prop_assert!(pose_difference(&(a * a.inverse()), &Pose::identity()) < 1e-13);
        prop_assert!(pose_difference(&(a.inverse() * a), &Pose::identity()) < 1e-13);
        prop_assert!(pose_difference(&(a * Pose::identity()), &a) == 0.0);
        let one_by_one = a.transform_point(&b.transform_point(&p));
        prop_assert!(((a * b).transform_point(&p) - one_by_one).amax() < 1e-13);
    }

    #[test]
    fn displacement_and_error_undo_each_other(a in pose(), b in pose(), by in within(SVector::repeat(1.5))) {
        let there = a.displaced(&a.error_to(&b));
        prop_assert!(pose_difference(&there, &b) < 1e-13, "displaced by its error a pose misses the target");
        // Rotation vectors up to √3 · 1.5 < π are unique.
        let by = Twist::from_vector(&by);
        let back = a.error_to(&a.displaced(&by));
        prop_assert!((back.to_vector() - by.to_vector()).amax() < 1e-13);
    }

    #[test]
    fn power_does_not_depend_on_the_axes(v in within(SVector::<f64, 6>::repeat(2.0)), w in within(SVector::<f64, 6>::repeat(2.0)),
                                         a in pose()) {
        let power = v.dot(&w);
        let turned = Twist::from_vector(&v).rotated(&a.rotation).to_vector()
            .dot(&Wrench::from_vector(&w).rotated(&a.rotation).to_vector());
        // Six products of up to 4, each factor itself a sum of three.
        prop_assert!((power - turned).abs() < 100.0 * f64::EPSILON);
    }
}

#[test]
fn half_turns_about_the_axes_are_exact() {
    for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
        let m: Matrix3<f64> = axis * axis.transpose() * 2.0 - Matrix3::identity();
        assert_eq!(rotation_vector(&m).abs(), axis * core::f64::consts::PI);
    }
    assert_eq!(rotation_vector(&Matrix3::<f64>::identity()), Vector3::zeros());
}
