//! The rigid arm against another engine: 24 states of the KR 500 MT computed by Pinocchio 4.1.0.
//!
//! Every quantity is judged relative to the largest entry of its vector or matrix.

use nalgebra::SMatrix;
use trueweld_core::{JointVector, Real, Wrench};
use trueweld_tests::{golden, kr500, number, relative};

/// Largest relative differences over the states: pose, J, M, rnea, bias, gravity, Jᵀw, forward
/// dynamics.
fn worst<T: Real>() -> [f64; 8] {
    let robot = kr500::<T>();
    let mut worst = [0.0_f64; 8];
    for s in golden::<T>() {
        let frames = robot.frames(&s.q);
        // At the zero pose with v = 0 nothing moves and the floor of 1 (m, N·m, kg·m²) stands in
        // for the norm.
        fn off<T: Real, const R: usize, const C: usize>(
            a: &SMatrix<T, R, C>,
            b: &SMatrix<T, R, C>,
        ) -> f64 {
            relative(a, b, 1.0)
        }
        let forward = robot
            .forward_dynamics(&frames, &s.v, &s.forward_torque, &Wrench::zero())
            .expect("M is definite");
        let here = [
            off(&frames.tcp.position, &s.tcp.position)
                .max(off(&frames.tcp.rotation, &s.tcp.rotation)),
            off(&frames.jacobian().0, &s.jacobian),
            off(&robot.crba(&frames), &s.mass_matrix),
            off(&robot.rnea(&frames, &s.v, &s.a, &Wrench::zero()), &s.rnea),
            off(&robot.nonlinear_effects(&frames, &s.v), &s.bias),
            off(&robot.gravity_torque(&frames), &s.gravity),
            off(&frames.joint_torque(&s.wrench), &s.wrench_torque),
            off(&forward, &s.forward_acceleration),
        ];
        for (w, h) in worst.iter_mut().zip(here) {
            assert!(h.is_finite());
            *w = w.max(h);
        }
    }
    println!(
        "pose, J, M, rnea, bias, gravity, Jᵀw, forward dynamics: {:?}",
        worst.map(|w| format!("{w:.1e}"))
    );
    worst
}

#[test]
fn agrees_with_pinocchio_in_double_precision() {
    // The requirement: 1e-9. (Rounding of 6 chained rotations and of M's condition number would
    // allow 1e-11.)
    for (i, off) in worst::<f64>().into_iter().enumerate() {
        assert!(off < 1e-9, "quantity {i} is off by {off:e}");
    }
}

#[test]
fn agrees_with_pinocchio_in_single_precision() {
    let worst = worst::<f32>();
    // Inputs rounded to f32, six chained rotations, cancelling sums of some tens of terms: measured
    // up to 6 ε (gravity, 6.7e-7); three times that is granted to other libraries' sines.
    let rounding = 18.0 * number(f32::EPSILON);
    for (i, off) in worst[..7].iter().enumerate() {
        assert!(*off < rounding, "quantity {i} is off by {off:e}");
    }
    // Forward dynamics multiplies that by the condition of M (1e3 and more, but mostly a matter of
    // unequal links, which Cholesky does not suffer from): measured 14 ε.
    assert!(worst[7] < 3.0 * rounding, "forward dynamics is off by {:e}", worst[7]);
}

#[test]
fn wrench_enters_as_its_joint_torque() {
    // rnea with the golden wrench = rnea without it − Pinocchio's Jᵀw: one sum more than above.
    let robot = kr500::<f64>();
    for s in golden::<f64>() {
        let frames = robot.frames(&s.q);
        let expected: JointVector<f64> = s.rnea - s.wrench_torque;
        let off = relative(&robot.rnea(&frames, &s.v, &s.a, &s.wrench), &expected, 1.0);
        assert!(off < 1e-9, "off by {off:e}");
    }
}
