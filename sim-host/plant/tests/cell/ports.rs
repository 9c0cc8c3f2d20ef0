//! Every named port of the plant: a term put there acts as its port says, and nothing else changes.
//! Then the library's effects, by their equations.

use crate::cell::KR500;
use crate::cell::support::{Fixtures, free_cell, law};
use nalgebra::Vector3;
use trueweld_core::{JointVector, Wrench};
use trueweld_plant::cell::State;
use trueweld_plant::effects::{Effect, Location, library};
use trueweld_plant::integrate::rest;
use trueweld_plant::robot::{
    Channel, Drives, JointState, Port, ProcessPoint, Readings, Term, ValueDerivative,
};
use trueweld_plant::simulate::{ControllerKind, WeldProgram, run};

const POSTURE: [f64; 6] = [0.286, -0.932, 1.944, 0.1, 0.559, 0.286];

/// One term that answers at every port, so that the port alone decides what it does.
#[derive(Debug)]
struct Everything;

impl Term for Everything {
    fn torsion(&self, _: &JointState) -> f64 {
        1e-4
    }
    fn stiffness(&self, _: f64) -> f64 {
        2.0
    }
    fn damping(&self) -> f64 {
        3.0
    }
    fn spring_torque(&self, _: &JointState) -> f64 {
        7.0
    }
    fn friction(&self, _: &JointState) -> ValueDerivative {
        ValueDerivative { value: 11.0, slope: 0.0 }
    }
    fn link_torque(&self, _: &JointState, counterbalance: f64) -> f64 {
        -0.5 * counterbalance
    }
    fn link_angle(&self) -> f64 {
        2e-4
    }
    fn tilt(&self, moment: &Vector3<f64>, axis: &Vector3<f64>) -> Vector3<f64> {
        (moment - axis * axis.dot(moment)) * 2e-8
    }
    fn process_force(&self, _: &ProcessPoint, force: Vector3<f64>) -> Vector3<f64> {
        force * 1.5
    }
    fn surface(&self, _: &ProcessPoint) -> f64 {
        1e-4
    }
    fn sense(&self, readings: &mut Readings) {
        readings.force.x += 100.0;
    }
    fn delay(&self, channel: Channel) -> f64 {
        if channel == Channel::Wrench { 0.024 } else { 0.0 }
    }
}

fn moving() -> Drives {
    Drives {
        link: JointVector::from(POSTURE),
        link_rate: JointVector::repeat(0.01),
        motor: JointVector::from(POSTURE).add_scalar(1e-3),
        motor_rate: JointVector::repeat(0.02),
    }
}

fn with(port: Port) -> trueweld_plant::cell::Cell {
    free_cell(&KR500, Some((port, Box::new(Everything))))
}

#[test]
fn spring_port_changes_the_spring_of_its_joint_alone() {
    let (bare, term) = (free_cell(&KR500, None), with(Port::SpringTorque(2)));
    let change =
        term.robot.spring_torque(&moving(), &[]) - bare.robot.spring_torque(&moving(), &[]);
    let (k, d) = (KR500.stiffness()[2], KR500.damping()[2]);
    let expected = 2.0 * k * 1.1e-3 + 3.0 * d * 0.01 + 7.0 - (k * 1e-3 + d * 0.01);
    for i in 0..6 {
        let wanted = if i == 2 { expected } else { 0.0 };
        assert!(
            (change[i] - wanted).abs() < 1e-6,
            "A{}: {} N·m, expected {wanted}",
            i + 1,
            change[i]
        );
    }
}

#[test]
fn angle_port_shifts_the_twist() {
    let (bare, term) = (free_cell(&KR500, None), with(Port::JointToLinkAngle(4)));
    let change =
        term.robot.spring_torque(&moving(), &[]) - bare.robot.spring_torque(&moving(), &[]);
    assert!((change[4] - KR500.stiffness()[4] * 2e-4).abs() < 1e-6);
    assert_eq!(change.remove_row(4).amax(), 0.0);
}

#[test]
fn friction_and_link_ports_add_their_torque() {
    let (bare, friction, link) =
        (free_cell(&KR500, None), with(Port::MotorFriction(3)), with(Port::LinkTorque(1)));
    for i in 0..6 {
        let change = friction.robot.friction(&moving(), i, 0.0, &[], 0.0).value
            - bare.robot.friction(&moving(), i, 0.0, &[], 0.0).value;
        assert!((change - if i == 3 { 11.0 } else { 0.0 }).abs() < 1e-9);
    }
    let halved = bare.robot.link_torque(&moving(), &[]) * 0.5;
    assert!((link.robot.link_torque(&moving(), &[]) - halved).amax() < 1e-9);
}

#[test]
fn frame_ports_tilt_under_the_moment_they_carry() {
    let q = JointVector::from(POSTURE);
    let push = Wrench { moment: Vector3::zeros(), force: Vector3::new(0.0, 0.0, 18e3) };
    let bare = free_cell(&KR500, None).robot.frames(&q, &push, 0.0).tcp;
    for (port, pivot) in
        [(Port::LinkFrame(0), Vector3::zeros()), (Port::BaseFrame, Vector3::zeros())]
    {
        let tcp = with(port).robot.frames(&q, &push, 0.0).tcp;
        // Moment at the foot: the push at its lever, and gravity of all links; the tilt about the
        // horizontal axes.
        let gravity = Vector3::new(0.0, 0.0, -9.80665);
        let still = JointVector::zeros();
        let loads = KR500.joint_loads(&KR500.frames(&q), &still, &still, &push);
        let moment: Vector3<f64> = -loads[0].moment;
        assert!(moment.norm() > 1e4 && gravity.z < 0.0);
        let mut tilt = moment * 2e-8;
        tilt.z = 0.0;
        let expected = tilt.cross(&(bare.position - pivot));
        let moved = tcp.position - bare.position;
        // Base: the test's term has no axis to leave out, so that its z part shows as well.
        let across = if port == Port::BaseFrame {
            (moment * 2e-8).cross(&(bare.position - pivot))
        } else {
            expected
        };
        assert!(
            (moved - across).norm() < 1e-3 * across.norm(),
            "{port:?}: {moved} against {across}"
        );
        // A push upwards must lift the tool.
        assert!(moved.z > 0.0, "{port:?}: {moved}");
    }
}

#[test]
fn process_and_surface_ports_act_on_the_force() {
    let fixtures = Fixtures::of("vertical");
    let react = |port: Option<Port>, depth: f64| {
        let mut cell = fixtures.cell(&[]);
        if let Some(port) = port {
            cell.robot.ports.install(port, Box::new(Everything)).expect("room");
        }
        let at = Vector3::new(0.1, 0.0, depth);
        let v = Vector3::new(0.01, 0.0, 0.0);
        trueweld_plant::process::reaction(&cell.process, &cell.robot.ports, 1.0, &at, &v, 0.0, 0.3)
            .force
    };
    let bare = react(None, 5e-4);
    assert!((react(Some(Port::ProcessForce), 5e-4) - bare * 1.5).norm() < 1e-9);
    assert!((react(Some(Port::PlateSurface), 5e-4) - react(None, 6e-4)).norm() < 1e-9);
}

#[test]
fn sensor_and_time_ports_change_what_the_controller_sees_and_when() {
    let fixtures = Fixtures::of("vertical");
    let program = WeldProgram::ForceStep { height: 3e3, hold: 0.2, length: 0.3 };
    let sensed = |port: Option<Port>| {
        let mut cell = fixtures.cell(&[]);
        if let Some(port) = port {
            cell.robot.ports.install(port, Box::new(Everything)).expect("room");
        }
        let mut sensors = fixtures.sensors.clone();
        (
            sensors.force.noise_force,
            sensors.force.filter,
            sensors.force.delay,
            sensors.force.resolution,
        ) = (0.0, 0.0, 0.0, 0.0);
        let none = law("none");
        let scenario = fixtures.scenario(&cell, program, ControllerKind::EXTERNAL, &none);
        run(&trueweld_plant::simulate::Scenario { sensors: &sensors, ..scenario }, |_| {})
            .expect("runs")
            .rows
    };
    let bare = sensed(None);
    // Ideal instruments read the truth.
    assert!(bare.iter().all(|r| (r.force_sensed_w - r.force_w).norm() < 1e-6));
    // x of T is −y of W here: the term's 100 N in T.
    let shifted = sensed(Some(Port::SensorChannel(Channel::Tracker)));
    assert!(shifted.iter().all(|r| ((r.force_sensed_w - r.force_w).norm() - 100.0).abs() < 1e-6));
    // 24 ms late: the sensed push is the true one of two control periods before.
    let late = sensed(Some(Port::TimeBase));
    for pair in late.windows(3).skip(3) {
        assert!(
            (pair[2].force_sensed_w.z - pair[0].force_w.z).abs() < 1.0,
            "at {} s",
            pair[2].time
        );
    }
}

#[test]
fn backlash_lets_the_link_go_until_the_gap_is_taken_up() {
    let fixtures = Fixtures::of("vertical");
    let gap = 2e-4;
    let cell = fixtures.cell(&["backlash:A5:half_gap_rad=2e-4"]);
    let bare = fixtures.cell(&[]);
    let q = JointVector::from(POSTURE);
    // Across the tool, so that A5 carries it: 4 kN·m against the 120 N·m that would only take up
    // the gap.
    for force in [-6e3, 6e3] {
        let wrench = Wrench { moment: Vector3::zeros(), force: Vector3::new(force, 0.0, 0.0) };
        let loose = rest::under_wrench(&cell, &q, &wrench).expect("rest");
        let tight = rest::under_wrench(&bare, &q, &wrench).expect("rest");
        // The link goes by b further the way its torque already pushes it, give or take what the
        // moved load adds: F·L/K = 6 kN · 0.69 m / 0.6 MN·m/rad = 1 % of it.
        let more = loose - tight;
        let expected = gap * (tight[4] - q[4]).signum();
        assert!((more[4] - expected).abs() < 3e-2 * gap, "{force} N: {more}");
        assert!(more.remove_row(4).amax() < 0.05 * gap, "{force} N: {more}");
    }
}

#[test]
fn joint_friction_costs_the_motor_its_torque_and_leaves_the_tool() {
    let fixtures = Fixtures::of("vertical");
    let motion = |cell: &trueweld_plant::cell::Cell| {
        let mut state =
            State::at_rest(&JointVector::from(POSTURE), &JointVector::from(POSTURE), 0.0);
        state.0[18] = 0.1;
        cell.evaluate(0.0, &state).rates
    };
    let cell = fixtures.cell(&["joint-friction:A1:coulomb_nm=500,viscous_nms_rad=1000"]);
    let change = motion(&cell) - motion(&fixtures.cell(&[]));
    // 500 N·m + 1000 · 0.1 rad/s on 2400 kg·m².
    assert!((change[18] + 600.0 / 2400.0).abs() < 1e-9, "{change}");
    assert_eq!(change.remove_row(18).amax(), 0.0);
}

#[test]
fn effects_are_read_or_refused_with_what_was_expected() {
    let robot = Fixtures::of("vertical").robot;
    let good = Effect::parse("backlash:A5:half_gap_rad=2e-4", &robot).expect("good");
    assert_eq!(
        (good.kind.id, good.at, good.values.as_slice()),
        ("backlash", Location::Joint(4), &[2e-4][..])
    );
    for (text, says) in [
        ("backlash", "ID:AT:NAME=VALUE"),
        ("slack:A5:half_gap_rad=1", "expected one of stiffness-error"),
        ("backlash:A9:half_gap_rad=1e-4", "A1, A2, A3, A4, A5, A6"),
        ("backlash::half_gap_rad=1e-4", "A1, A2, A3, A4, A5, A6"),
        ("backlash:A5:gap=1e-4", "half_gap_rad (rad"),
        ("backlash:A5:half_gap_rad=tiny", "not a number"),
        ("backlash:A5:half_gap_rad=NaN", "not finite"),
        ("joint-friction:A1:coulomb_nm=3", "viscous_nms_rad is missing"),
        ("backlash:A5:half_gap_rad=1e-4,half_gap_rad=1e-4", "given twice"),
    ] {
        let error = Effect::parse(text, &robot).expect_err(text).to_string();
        assert!(error.contains(says), "{text}: {error}");
    }
}

#[test]
fn every_effect_of_the_table_is_described_and_its_ranges_are_ranges() {
    for kind in library() {
        assert!(
            !kind.equation.is_empty() && !kind.shows.is_empty() && !kind.parameters.is_empty(),
            "{}",
            kind.id
        );
        assert!(kind.parameters.iter().all(|p| p.low < p.high), "{}", kind.id);
        assert_eq!(library().filter(|k| k.id == kind.id).count(), 1, "{} stands twice", kind.id);
    }
}
