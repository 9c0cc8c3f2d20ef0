//! The elastic robot and its contact as a physical system: energy, rest, the rigid limit, and the
//! accuracy of the default integrator.

use crate::cell::KR500;
use crate::cell::numbers::seen;
use crate::cell::support::{Fixtures, free_cell, law};
use nalgebra::Vector3;
use trueweld_core::{JointVector, Robot, Wrench};
use trueweld_plant::cell::{Cell, State};
use trueweld_plant::integrate::{Integrator, Stepper, Tolerance, rest};
use trueweld_plant::robot::{Port, ProcessPoint, Term};
use trueweld_plant::simulate::{
    ControllerKind, RecordRow, Scenario, Seam, WeldProgram, run, start_angles,
};

/// A posture in the middle of the first weld.
const POSTURE: [f64; 6] = [0.286, -0.932, 1.944, 0.1, 0.559, 0.286];

fn advance(
    cell: &Cell,
    integrator: Integrator,
    mut state: State,
    torque: &JointVector<f64>,
    h: f64,
    n: usize,
) -> State {
    let mut stepper = Stepper::new(integrator);
    for k in 0..n {
        let t = k as f64 * h;
        let at = cell.evaluate(t, &state);
        state = stepper.advance(cell, t, &state, &at, torque, h).expect("finite");
    }
    state
}

fn altered(change: impl FnOnce(&mut trueweld_core::RobotParameters<f64>)) -> Robot<f64> {
    let mut parameters = KR500.parameters().clone();
    change(&mut parameters);
    Robot::new(parameters).expect("still a robot")
}

#[test]
fn without_friction_and_damping_the_free_arm_keeps_its_energy() {
    let model = altered(|p| {
        p.friction.viscous.fill(0.0);
        p.friction.coulomb.fill(0.0);
        p.joints.iter_mut().for_each(|j| j.damping = 0.0);
    });
    let cell = free_cell(&model, None);
    // Dropped from rest, springs slack: it falls and rings.
    let q = JointVector::from(POSTURE);
    let start = State::at_rest(&q, &q, 0.0);
    let energy = |s: &State| cell.robot.energy(&s.drives());
    let torque = JointVector::zeros();
    // Energy exchanged in one second: some kilojoules of 9 kN·m turning through tenths of a radian.
    let exchanged = {
        let end = advance(
            &cell,
            Integrator::DormandPrince(Tolerance::REFERENCE),
            start,
            &torque,
            0.01,
            100,
        );
        let frames = cell.robot.model.frames(&end.drives().link);
        let fallen = cell.robot.model.potential_energy(&frames)
            - cell.robot.model.potential_energy(&cell.robot.model.frames(&q));
        let drift = (energy(&end) - energy(&start)).abs() / fallen.abs();
        // Local error 1e-9 a step over some thousand steps; seen 1e-11.
        assert!(seen("reference: energy drift in 1 s over what was exchanged", drift) < 1e-8);
        fallen.abs()
    };
    let end = advance(&cell, Integrator::LinearlyImplicit, start, &torque, 1e-3, 1000);
    let drift = (energy(&end) - energy(&start)).abs() / exchanged;
    // Third order at 1 ms: (ωh)³ of the 12 Hz modes that carry the ringing is 4e-4 a radian,
    // damping; seen 6e-6 in all.
    assert!(seen("default: energy drift in 1 s over what was exchanged", drift) < 1e-4);
}

#[test]
fn dampers_and_friction_take_exactly_the_energy_that_is_missing() {
    let cell = free_cell(&KR500, None);
    let q = JointVector::from(POSTURE);
    let mut state = State::at_rest(&q, &q, 0.0);
    let energy = |s: &State| cell.robot.energy(&s.drives());
    let power = |s: &State| -> f64 {
        let d = s.drives();
        let friction = |i| cell.robot.friction(&d, i, 0.0, &[], 0.0).value;
        let twist_rate = d.motor_rate - d.link_rate;
        let damper = KR500.damping().dot(&twist_rate.component_mul(&twist_rate));
        damper + (0..6).map(|i| friction(i) * d.motor_rate[i]).sum::<f64>()
    };
    let start = energy(&state);
    let h = 1e-4;
    let mut lost = 0.0;
    for _ in 0..2000 {
        let before = power(&state);
        state = advance(
            &cell,
            Integrator::DormandPrince(Tolerance::REFERENCE),
            state,
            &JointVector::zeros(),
            h,
            1,
        );
        lost += 0.5 * h * (before + power(&state));
    }
    // The trapezoid over 0.1 ms of power that changes with 1/375 s (friction turning round) and the
    // modes: 1e-3.
    let mismatch = (start - energy(&state) - lost).abs() / lost;
    assert!(lost > 1.0, "the fall must have cost something: {lost} J");
    assert!(seen("energy balance with dampers and friction, mismatch over loss", mismatch) < 1e-3);
}

#[test]
fn stiffer_springs_approach_the_rigid_arm() {
    let q = JointVector::from(POSTURE);
    let torque = JointVector::from([3e3, -2e3, 1e3, 200.0, -100.0, 50.0]);
    let frictionless = |factor: f64| {
        altered(|p| {
            p.friction.viscous.fill(0.0);
            p.friction.coulomb.fill(0.0);
            p.joints.iter_mut().for_each(|j| {
                j.stiffness *= factor;
                j.damping *= factor.sqrt();
            });
        })
    };
    // Rigid: (M + I_m) q̈ = Γ + τ_cb − g from rest; over 20 ms the acceleration hardly changes.
    let frames = KR500.frames(&q);
    let inertia = KR500.crba(&frames) + nalgebra::Matrix6::from_diagonal(KR500.rotor_inertia());
    let mut load = torque - KR500.gravity_torque(&frames);
    load[1] += KR500.counterbalance_torque(q[1]);
    let acceleration = inertia.cholesky().expect("positive definite").solve(&load);
    let span = 0.02;
    let rigid = q + acceleration * (0.5 * span * span);
    let error = |factor: f64| {
        let cell = free_cell(&frictionless(factor), None);
        let start = State::at_rest(&q, &q, 0.0);
        let end = advance(
            &cell,
            Integrator::DormandPrince(Tolerance::REFERENCE),
            start,
            &torque,
            span,
            1,
        );
        (end.drives().link - rigid).amax()
    };
    let (soft, stiff) = (error(1e2), error(1e4));
    // Twist is load over K: a hundred times stiffer, a hundred times nearer, until the rigid
    // prediction's own neglect of the changing posture shows.
    assert!(stiff < soft / 30.0, "×1e2: {soft:e} rad, ×1e4: {stiff:e} rad");
    // 13 kN·m on 6.2e10 N·m/rad twist the drive by 2e-7 rad; the link follows the motor to less
    // than that.
    assert!(seen("elastic against rigid at K × 1e4, rad", stiff) < 2e-7);
}

/// The process' force whatever the tool does: the published load.
#[derive(Debug)]
struct ConstantForce(Vector3<f64>);

impl Term for ConstantForce {
    fn process_force(&self, _: &ProcessPoint, _: Vector3<f64>) -> Vector3<f64> {
        self.0
    }
}

#[test]
fn static_deflection_is_where_the_ringing_plant_comes_to_rest() {
    // Motors that cannot move: the locked-motor arm.
    let model = altered(|p| p.joints.iter_mut().for_each(|j| j.rotor_inertia = 1e17));
    let load = Vector3::new(-4e3, 1e3, -18e3);
    let fixtures = Fixtures::of("vertical");
    let mut cell = fixtures.cell(&[]);
    cell.robot.model = model;
    cell.robot.ports.install(Port::ProcessForce, Box::new(ConstantForce(load))).expect("room");
    let q = start_angles(&KR500, &Seam::of(&fixtures.weld)).expect("reach");
    // The plate 50 mm above the tool, so that it stays in contact wherever the load takes it.
    cell.seam.b_from_w.position.z += 0.05;
    let start = State::at_rest(&q, &q, 0.0);
    let rung =
        advance(&cell, Integrator::LinearlyImplicit, start, &JointVector::zeros(), 1e-3, 20_000);
    let wrench = Wrench { moment: Vector3::zeros(), force: cell.seam.b_from_w.rotation * load };
    let at_rest = rest::under_wrench(&cell, &q, &wrench).expect("an equilibrium");
    let tool = |link: &JointVector<f64>| KR500.forward_kinematics(link).position;
    let deflection = tool(&at_rest) - tool(&q);
    let gap = (tool(&rung.drives().link) - tool(&at_rest)).norm();
    assert!(
        deflection.norm() > 5e-3,
        "the published load bends the arm by millimetres: {deflection}"
    );
    assert!(seen("static solver against the plant at rest, m", gap) < 1e-6);
    // And the core's prediction, which iterates on the loaded pose, is the same equilibrium.
    let in_t = wrench.rotated(&KR500.forward_kinematics(&at_rest).rotation.transpose());
    let predicted = KR500.deflected(&q, &in_t, 6);
    assert!(
        seen(
            "core's prediction against the static solver, m",
            (predicted.real.position - tool(&at_rest)).norm()
        ) < 1e-9
    );
}

#[test]
fn the_default_integrator_stays_within_a_micrometre_of_the_reference_over_a_whole_weld() {
    let fixtures = Fixtures::of("vertical");
    let cell = fixtures.cell(&[]);
    // Encoders and force sensor without steps: a reading that falls to the other side of a step,
    // for a difference in the last digit, moves the closed loop by more than both integrators'
    // errors (1.4 µm at 2 µrad, at any plant step).
    let mut sensors = fixtures.sensors.clone();
    sensors.encoder_resolution = [0.0; 6];
    sensors.force.resolution = 0.0;
    let law = law("elastostatic");
    let scenario = Scenario {
        sensors: &sensors,
        ..fixtures.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law)
    };
    let exact =
        Scenario { integrator: Integrator::DormandPrince(Tolerance::REFERENCE), ..scenario };
    // Single welds are stepped at 1 ms, certification and the comparison of laws at 2 ms.
    let coarse = Scenario { plant_step: 2e-3, ..scenario };
    let [fine, coarse, exact] = std::thread::scope(|scope| {
        [scenario, coarse, exact]
            .map(|scenario| scope.spawn(move || run(&scenario, |_| {}).expect("runs")))
            .map(|run| run.join().expect("no panic"))
    });
    let said = [
        (
            "1 ms against the reference over a weld, m RMS",
            "1 ms against the reference over a weld, N RMS",
        ),
        (
            "2 ms against the reference over a weld, m RMS",
            "2 ms against the reference over a weld, N RMS",
        ),
    ];
    for ((metres, newtons), recording) in said.into_iter().zip([fine, coarse]) {
        assert_eq!(recording.rows.len(), exact.rows.len());
        let rms = |apart: &dyn Fn(&RecordRow, &RecordRow) -> f64| {
            let pairs = recording.rows.iter().zip(&exact.rows);
            (pairs.map(|(a, b)| apart(a, b).powi(2)).sum::<f64>() / exact.rows.len() as f64).sqrt()
        };
        let place = rms(&|a, b| (a.real.position - b.real.position).norm());
        assert!(seen(metres, place) < 1e-6);
        let push = rms(&|a, b| a.force_w.z - b.force_w.z);
        assert!(seen(newtons, push) < 1.0);
    }
}

#[test]
fn a_drag_that_is_steep_at_rest_does_not_chatter() {
    // As the push rises the tool creeps before its feed begins. An integrator that takes the drag for
    // the linear one goes to and fro over the standing point: a mean force of nothing, and a force of
    // a thousand newtons whenever it is recorded.
    let mut fixtures = Fixtures::of("coupon");
    fixtures.sensors.encoder_resolution = [0.0; 6];
    fixtures.sensors.force.resolution = 0.0;
    fixtures.weld.end = fixtures.weld.start + 0.02 * (fixtures.weld.end - fixtures.weld.start);
    let cell = fixtures.cell(&["feed-power-law::exponent=0.5"]);
    let law = law("elastostatic");
    let scenario = Scenario {
        plant_step: 5e-4,
        ..fixtures.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law)
    };
    let exact =
        Scenario { integrator: Integrator::DormandPrince(Tolerance::REFERENCE), ..scenario };
    let [recording, exact] = std::thread::scope(|scope| {
        [scenario, exact]
            .map(|scenario| scope.spawn(move || run(&scenario, |_| {}).expect("runs")))
            .map(|run| run.join().expect("no panic"))
    });
    let pairs = || recording.rows.iter().zip(&exact.rows);
    let farthest = |apart: &dyn Fn(&RecordRow, &RecordRow) -> f64| {
        pairs().map(|(a, b)| apart(a, b)).fold(0.0, f64::max)
    };
    let place = farthest(&|a, b| (a.real.position - b.real.position).norm());
    let force = farthest(&|a, b| (a.force_w - b.force_w).xy().norm());
    println!("{} rows: {place} m, {force} N at most", exact.rows.len());
    assert!(place < 1e-5 && force < 50.0, "{place} m, {force} N");
}
