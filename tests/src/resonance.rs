//! The spindle's ripple on the arm's modes: welds and steps of force with the spindle at some
//! speed, and what of them is locked to it.

use crate::cell::{Fixtures, law};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use trueweld_core::Robot;
use trueweld_core::control::{ExternalGains, JointGains};
use trueweld_evaluate::StepFigures;
use trueweld_plant::input::Process;
use trueweld_plant::simulate::{
    ControllerKind, Phase, RecordRow, Recording, Scenario, Seam, WeldProgram, run, start_angles,
};

/// The first weld with the spindle at so many turns a minute and the external force loop so many
/// times faster than tuned.
///
/// With a stiff position loop, 40 rad/s, under either controller: it holds the drives, so that the
/// arm swings on its springs. The slower ones of the fixture give way, and damp what is shown here.
pub fn fixtures(rpm: f64, faster: f64) -> Fixtures {
    let mut fixtures = Fixtures::of("vertical");
    fixtures.process.spindle = -rpm * TAU / 60.0;
    let stiff = stiff(&fixtures.control.parallel.joint);
    fixtures.control.external.joint = stiff;
    fixtures.control.parallel.joint = stiff;
    let force = &mut fixtures.control.external.force;
    force.kp *= faster;
    force.ki *= faster;
    force.max_rate *= faster;
    fixtures
}

/// The position loop of parallel control at 40 rad/s, where the fixture has 28: what its search for
/// the published step ended with.
pub fn stiff(joint: &JointGains<f64>) -> JointGains<f64> {
    let faster = 40.0_f64 / 28.0;
    JointGains {
        kp: joint.kp * faster.powi(2),
        ki: joint.ki * faster.powi(2),
        kd: joint.kd * faster,
    }
}

/// A run whose controller is told the spindle's rate, or is not.
fn recorded(
    fixtures: &Fixtures,
    controller: ControllerKind,
    program: WeldProgram,
    told: bool,
) -> Option<Recording> {
    let cell = fixtures.cell(&[]);
    let spindle = if told { fixtures.process.spindle } else { 0.0 };
    let planned = Process { spindle, ..fixtures.process.clone() };
    let none = law("none");
    run(
        &Scenario { planned: &planned, ..fixtures.scenario(&cell, program, controller, &none) },
        |_| {},
    )
    .ok()
}

/// Amplitudes at the spindle's first order in the steady part of a short weld.
#[derive(Debug)]
pub struct Lines {
    /// Of the push, N.
    pub push: f64,
    /// Across the seam, m.
    pub lateral: f64,
    /// Of the side tilt, rad.
    pub tilt: f64,
    /// Of the drives along the tool axis, m.
    pub drives: f64,
    /// Of the depth that the external force loop adds, m.
    pub correction: f64,
    /// Largest less smallest push, N.
    pub envelope: f64,
}

/// 180 mm of weld: ten seconds of steady part, so that a window over it tells lines 0.2 Hz apart.
pub fn weld(rpm: f64, controller: ControllerKind, faster: f64, told: bool) -> Lines {
    lines(fixtures(rpm, faster), controller, told)
}

/// The push's line in such a weld under external control, N, mean over three seeds of the instruments:
/// one by itself is off by a twentieth.
pub fn mean_push(rpm: f64, faster: f64) -> f64 {
    let push = |seed| {
        let mut fixtures = fixtures(rpm, faster);
        fixtures.sensors.seed = seed;
        lines(fixtures, ControllerKind::EXTERNAL, true).push
    };
    (1..=3).map(push).sum::<f64>() / 3.0
}

fn lines(mut fixtures: Fixtures, controller: ControllerKind, told: bool) -> Lines {
    fixtures.weld.end.y = fixtures.weld.start.y + 0.18;
    let recording = recorded(&fixtures, controller, WeldProgram::Weld, told).expect("the run ends");
    let rows: Vec<&RecordRow> =
        recording.rows.iter().filter(|r| r.phase == Phase::Steady).collect();
    let push = |r: &RecordRow| -r.force_w.z;
    let (low, high) =
        rows.iter().fold((f64::MAX, f64::MIN), |(l, h), r| (l.min(push(r)), h.max(push(r))));
    Lines {
        push: line(&rows, push),
        lateral: line(&rows, |r| r.deviation_w.linear.y),
        tilt: line(&rows, |r| r.deviation_w.angular.x),
        drives: line(&rows, |r| r.encoder_pose.position.z),
        correction: line(&rows, |r| r.depth_correction),
        envelope: high - low,
    }
}

/// Amplitude at the spindle's first order, through a Hann window: the slow drift along the seam
/// does not leak into it.
fn line(rows: &[&RecordRow], signal: impl Fn(&RecordRow) -> f64) -> f64 {
    let n = rows.len() as f64;
    let window = |k: usize| 1.0 - (TAU * (k as f64 + 0.5) / n).cos();
    let mean = rows.iter().enumerate().map(|(k, r)| window(k) * signal(r)).sum::<f64>() / n;
    let (mut sine, mut cosine) = (0.0, 0.0);
    for (k, row) in rows.iter().enumerate() {
        let value = window(k) * (signal(row) - mean);
        sine += value * row.spindle_angle.sin();
        cosine += value * row.spindle_angle.cos();
    }
    2.0 * sine.hypot(cosine) / n
}

/// The published step of 11 kN under external control; `None` where the loop does not come to rest.
pub fn step(fixtures: &Fixtures, told: bool) -> Option<StepFigures> {
    let program = WeldProgram::ForceStep { height: 11e3, hold: 1.0, length: 3.0 };
    let recording = recorded(fixtures, ControllerKind::EXTERNAL, program, told)?;
    let figures = StepFigures::of(&recording, fixtures.weld.settle + 1.0, 11e3)?;
    let sound = recording.rows.iter().all(|r| r.fault.is_none()) && figures.settle_5pct_s.is_some();
    sound.then_some(figures)
}

/// The first weld started so far along its seam, m: the posture of that place.
pub fn started_at(path: f64, mut fixtures: Fixtures) -> Fixtures {
    fixtures.weld.start.y += path;
    fixtures
}

/// Gains that do not follow the posture: beside a material this soft the arm is rigid.
pub fn unscaled(mut fixtures: Fixtures) -> Fixtures {
    let force = &mut fixtures.control.external.force;
    *force = ExternalGains { material_stiffness: 1.0, tuned_stiffness: 1.0, ..*force };
    fixtures
}

/// Stiffness that the tool meets along its axis, so far along the seam, N/m.
pub fn stiffness(robot: &Robot<f64>, fixtures: &Fixtures, path: f64) -> f64 {
    let seam = Seam::of(&fixtures.weld);
    let start = start_angles(robot, &seam).expect("within reach");
    let q = robot.inverse_near(&seam.nominal(path), &start).expect("within reach");
    let z: Vector3<f64> = seam.b_from_w.rotation.column(2).into();
    1.0 / (1.0 / fixtures.process.model.depth_stiffness()
        + robot.compliance_along(&robot.frames(&q), &z))
}

/// Largest factor on the gains with which the step of 11 kN still comes to rest.
pub fn usable(told: bool, fixtures: impl Fn(f64) -> Fixtures) -> f64 {
    let (mut low, mut high) = (1.0_f64, 16.0_f64);
    for _ in 0..7 {
        let middle = (low * high).sqrt();
        if step(&fixtures(middle), told).is_some() { low = middle } else { high = middle }
    }
    low
}
