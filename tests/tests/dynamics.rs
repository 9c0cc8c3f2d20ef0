//! The dynamics of the rigid arm against one another and against energy: nothing here knows how
//! they are computed.

use nalgebra::SymmetricEigen;
use proptest::prelude::*;
use trueweld_core::{JOINTS, JointVector, Robot, Wrench};
use trueweld_tests::{
    KR500, acceleration, cases, cast, cast_wrench, configuration, kr500, number, rate, seen, wrench,
};

/// Torques a drive can give, N·m, whole range.
fn torque() -> impl Strategy<Value = JointVector<f64>> {
    trueweld_tests::within(JointVector::from_fn(|i, _| KR500.parameters().joints[i].max_torque))
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn inertia_matrix_is_symmetric_and_positive_definite(q in configuration()) {
        let m = KR500.crba(&KR500.frames(&q));
        prop_assert_eq!(m, m.transpose());
        let least = SymmetricEigen::new(m).eigenvalues.min();
        // M's least eigenvalue is below the least inertia about A6 alone (4.5 kg·m²) but physically
        // far from zero.
        prop_assert!(seen("1/least inertia", 1.0 / least) < 10.0 && least < 4.6, "least eigenvalue {least}");
        let single = kr500::<f32>();
        prop_assert!(SymmetricEigen::new(single.crba(&single.frames(&cast(&q)))).eigenvalues.min() > 0.1);
    }

    #[test]
    fn inverse_dynamics_is_inertia_and_bias(q in configuration(), v in rate(), a in acceleration(), w in wrench()) {
        let frames = KR500.frames(&q);
        let whole = KR500.rnea(&frames, &v, &a, &w);
        let parts = KR500.crba(&frames) * a + KR500.nonlinear_effects(&frames, &v) - frames.jacobian().0.transpose() * w.to_vector();
        // Torques up to 1e5 N·m, some tens of operations: measured 2e-11 N·m, one ε of that.
        prop_assert!(seen("rnea", (whole - parts).amax()) < 1e-9, "off by {:e} N·m", (whole - parts).amax());
        // Without motion what is left of the bias is gravity.
        let still = KR500.nonlinear_effects(&frames, &JointVector::zeros());
        prop_assert!((still - KR500.gravity_torque(&frames)).amax() < 1e-10);
    }

    #[test]
    fn bias_is_quadratic_in_the_rates(q in configuration(), v in rate()) {
        let frames = KR500.frames(&q);
        let velocity = |v: JointVector<f64>| KR500.nonlinear_effects(&frames, &v) - KR500.gravity_torque(&frames);
        // Coriolis and centrifugal torques have degree two: doubled rates, fourfold torque; turned
        // round, the same.
        prop_assert!((velocity(v * 2.0) - velocity(v) * 4.0).amax() < 1e-9);
        prop_assert!((velocity(-v) - velocity(v)).amax() < 1e-9);
    }

    #[test]
    fn velocity_torques_follow_from_the_inertia_matrix(q in configuration(), v in rate()) {
        // Lagrange: h = Ṁ v − ½ ∂(vᵀ M v)/∂q, by central differences. Gyroscopic torques do no
        // work, so that the energy balance below is blind to them; this is not.
        let h = 1e-5;
        let inertia = |q: JointVector<f64>| KR500.crba(&KR500.frames(&q));
        let kinetic = |q: JointVector<f64>| KR500.kinetic_energy(&KR500.frames(&q), &v);
        let unit = |i: usize| JointVector::from_fn(|k, _| if k == i { h } else { 0.0 });
        let gradient = JointVector::from_fn(|i, _| (kinetic(q + unit(i)) - kinetic(q - unit(i))) / (2.0 * h));
        let swept = (inertia(q + v * h) - inertia(q - v * h)) * v / (2.0 * h);
        let frames = KR500.frames(&q);
        let off = (KR500.nonlinear_effects(&frames, &v) - KR500.gravity_torque(&frames) - (swept - gradient)).amax();
        // Terms of up to 1e4: rounding 1e4 ε/h = 2e-7, truncation some 1e3 h² = 1e-7; measured
        // 9e-8.
        prop_assert!(seen("Lagrange", off) < 1e-6, "off by {off:e} N·m");
    }

    #[test]
    fn bearing_loads_carry_the_drive_torque(q in configuration(), v in rate(), a in acceleration(), w in wrench()) {
        let frames = KR500.frames(&q);
        let loads = KR500.joint_loads(&frames, &v, &a, &w);
        let torque = KR500.rnea(&frames, &v, &a, &w);
        for i in 0..JOINTS {
            prop_assert!((frames.axis[i].dot(&loads[i].moment) - torque[i]).abs() < 1e-9);
        }
        // At rest the foot carries the whole weight less what the environment carries.
        let rest = KR500.joint_loads(&frames, &JointVector::zeros(), &JointVector::zeros(), &w)[0];
        let p = KR500.parameters();
        let mass: f64 = p.joints.iter().map(|j| j.mass).sum::<f64>() + p.tool.mass;
        prop_assert!((rest.force + p.gravity * mass + w.force).amax() < 1e-10 * 18e3);
    }

    #[test]
    fn gravity_torque_is_the_gradient_of_potential_energy(q in configuration()) {
        // The drives hold the arm up: torque g = +∂V/∂q. By central differences.
        let h = 1e-5;
        let g = KR500.gravity_torque(&KR500.frames(&q));
        for i in 0..JOINTS {
            let mut step = JointVector::zeros();
            step[i] = h;
            let energy = |q: JointVector<f64>| KR500.potential_energy(&KR500.frames(&q));
            let slope = (energy(q + step) - energy(q - step)) / (2.0 * h);
            // V up to 3e4 J: rounding 3e4 ε/h = 7e-7, truncation g h²/6 = 4e-7.
            prop_assert!(seen("gravity gradient", (slope - g[i]).abs()) < 5e-6, "joint {i}: {slope} against {}", g[i]);
        }
    }

    #[test]
    fn forward_dynamics_undoes_inverse_dynamics(q in configuration(), v in rate(), a in acceleration(), w in wrench()) {
        let frames = KR500.frames(&q);
        let torque = KR500.rnea(&frames, &v, &a, &w);
        let back = KR500.forward_dynamics(&frames, &v, &torque, &w).unwrap();
        // 1e5 N·m known to ε over the least eigenvalue of M, 1.6 kg·m²: 1e5 ε/1.6 = 1e-11; measured
        // 8e-13.
        prop_assert!(seen("f64 forward of inverse", (back - a).amax()) < 1e-11, "off by {:e} rad/s²", (back - a).amax());

        let robot = kr500::<f32>();
        let (q, v, a, w) = (cast(&q), cast(&v), cast(&a), cast_wrench(&w));
        let frames = robot.frames(&q);
        let back = robot.forward_dynamics(&frames, &v, &robot.rnea(&frames, &v, &a, &w), &w).unwrap();
        // The same in f32 is 7e-3; measured 6e-4 rad/s².
        let off = seen("f32 forward of inverse", number((back - a).amax()));
        prop_assert!(off < 7e-3, "f32 is off by {off:e} rad/s²");
    }
}

/// Angles, rates and the work that torque and wrench have done, after one step.
fn step(
    robot: &Robot<f64>,
    state: (JointVector<f64>, JointVector<f64>, f64),
    torque: &JointVector<f64>,
    force: &Wrench<f64>,
    h: f64,
) -> (JointVector<f64>, JointVector<f64>, f64) {
    // Runge–Kutta of order four on (q, v, ∫ power).
    let slope = |q: JointVector<f64>, v: JointVector<f64>| {
        let frames = robot.frames(&q);
        let a = robot.forward_dynamics(&frames, &v, torque, force).unwrap();
        let power = v.dot(torque) + frames.twist(&v).to_vector().dot(&force.to_vector());
        (v, a, power)
    };
    let (q, v, work) = state;
    let k1 = slope(q, v);
    let k2 = slope(q + k1.0 * (h / 2.0), v + k1.1 * (h / 2.0));
    let k3 = slope(q + k2.0 * (h / 2.0), v + k2.1 * (h / 2.0));
    let k4 = slope(q + k3.0 * h, v + k3.1 * h);
    (
        q + (k1.0 + k2.0 * 2.0 + k3.0 * 2.0 + k4.0) * (h / 6.0),
        v + (k1.1 + k2.1 * 2.0 + k3.1 * 2.0 + k4.1) * (h / 6.0),
        work + (k1.2 + 2.0 * k2.2 + 2.0 * k3.2 + k4.2) * (h / 6.0),
    )
}

proptest! {
    #![proptest_config(cases(20))]

    #[test]
    fn energy_gained_is_work_done(q in configuration(), v in rate(), torque in torque(), w in wrench()) {
        // A tenth of full load over 50 ms: d/dt (T + V) = vᵀτ + (twist)ᵀw.
        let (torque, w) = (torque * 0.1, w * 0.1);
        let energy = |q: &JointVector<f64>, v: &JointVector<f64>| {
            let frames = KR500.frames(q);
            KR500.kinetic_energy(&frames, v) + KR500.potential_energy(&frames)
        };
        let mut state = (q, v, 0.0);
        for _ in 0..100 {
            state = step(&KR500, state, &torque, &w, 5e-4);
        }
        let gained = energy(&state.0, &state.1) - energy(&q, &v);
        // Energies of 1e3–1e4 J; rounding over 100 steps and the integrator's own error are
        // measured at 1.7e-9 J.
        prop_assert!(seen("energy", (gained - state.2).abs()) < 1e-7, "gained {gained} J, work {} J", state.2);
    }
}
