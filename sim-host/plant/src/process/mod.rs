//! The welding process: a macroscopic visco-elastic model with ripple locked to the spindle.
//!
//! With p the TCP and s the nominal surface point in W, d = (p − s)·z, d₊ = max(d, 0), e = F_d /
//! reference force:
//!
//! ```text
//! F_d = max(0, k_z d₊ + b_z ḋ·[d > 0])                                 along −z
//! F_f = c_x v_x e                                                       along −x
//! F_l = r F_f sgn(ω) + (c_y v_y + k_y (y − y_m)) e,  ẏ_m = (y − y_m)|v_x|/L   along −y
//! ```
//!
//! each × (1 + Σ aₙ sin(nφ + ψₙ)), φ̇ = ω; axial amplitudes for F_d, in-plane ones for F_f and F_l.
//! No moment at the TCP.

use crate::input::Process;
use crate::robot::{Ports, ProcessPoint};
use nalgebra::{Matrix3, Vector3};

/// Force on a tool that presses with `push`, N, moves along the seam at `feed`, m/s, and stands on
/// the line: what a weld is planned with. Mean over a turn of the spindle, in axes of W, N.
pub fn planned(process: &Process, push: f64, feed: f64) -> Vector3<f64> {
    let still = Process { ripple: Vec::new(), ..process.clone() };
    let position = Vector3::z() * (push / process.depth_stiffness);
    reaction(&still, &Ports::default(), 0.0, &position, &(Vector3::x() * feed), 0.0, 0.0).force
}

/// What the process does to the tool at one instant, in axes of W.
#[derive(Debug, Clone, Copy)]
pub struct Reaction {
    /// Force on the tool, N.
    pub force: Vector3<f64>,
    /// −∂F/∂p of the baseline and of its drag's factors, N/m: what an implicit integrator needs of
    /// the contact.
    pub stiffness: Matrix3<f64>,
    /// −∂F/∂ṗ of the same, N·s/m.
    pub damping: Matrix3<f64>,
    /// ẏ_m, m/s.
    pub channel_rate: f64,
}

/// Force of the process on the tool. `position` and `velocity` of the TCP in W (origin at the start
/// of the seam, on the nominal surface); `channel` y_m, m; `spindle_angle` φ, rad.
#[inline]
pub fn reaction(
    process: &Process,
    ports: &Ports,
    time: f64,
    position: &Vector3<f64>,
    velocity: &Vector3<f64>,
    channel: f64,
    spindle_angle: f64,
) -> Reaction {
    let channel_rate = (position.y - channel) * velocity.x.abs() / process.memory_length;
    let mut at = ProcessPoint {
        time,
        position: *position,
        velocity: *velocity,
        spindle_angle,
        spindle: process.spindle,
        depth_force: 0.0,
    };
    let surface: f64 = ports.surface.iter().map(|t| t.surface(&at)).sum();
    let depth = position.z + surface;
    // A surface that gives way by F_d/k: F_d = k_z (d − F_d/k) + b_z ḋ, solved for F_d.
    let give: f64 = ports.surface.iter().map(|t| t.surface_compliance()).sum();
    let share = 1.0 / (1.0 + process.depth_stiffness * give);
    let push = share * (process.depth_stiffness * depth + process.depth_damping * velocity.z);
    // A depth that is not a number makes a force that is not, and the run ends; it must not pass
    // for no contact.
    let depth_force = if depth <= 0.0 || push < 0.0 { 0.0 } else { push };
    if depth_force == 0.0 {
        return Reaction {
            force: Vector3::zeros(),
            stiffness: Matrix3::zeros(),
            damping: Matrix3::zeros(),
            channel_rate,
        };
    }
    at.depth_force = depth_force;
    let (mut axial, mut in_plane) = (1.0, 1.0);
    for r in &process.ripple {
        let wave = (r.order * spindle_angle + r.phase).sin();
        axial += r.axial * wave;
        in_plane += r.in_plane * wave;
    }
    let e = depth_force / process.reference_force;
    let (mut drag, mut exponent) = (process.feed_drag, 1.0);
    for term in &ports.process {
        drag *= term.drag(&at);
        exponent += term.drag_exponent(&at);
    }
    let feed = drag * velocity.x * e;
    let turn = process.lateral_ratio * process.spindle.signum();
    let across =
        process.lateral_damping * velocity.y + process.lateral_stiffness * (position.y - channel);
    let lateral =
        turn * feed + across * e + ports.process.iter().map(|t| t.lateral_force(&at)).sum::<f64>();
    let mut force = -Vector3::new(feed * in_plane, lateral * in_plane, depth_force * axial);
    for term in &ports.process {
        force = term.process_force(&at, force);
    }

    // Drag and lateral force scale with e, so depth enters all three rows; feed enters the lateral
    // one through r.
    let per_force = 1.0 / process.reference_force;
    let by_depth = Vector3::new(
        drag * velocity.x * per_force * in_plane,
        (turn * drag * velocity.x + across) * per_force * in_plane,
        axial,
    );
    let mut stiffness = Matrix3::zeros();
    stiffness.set_column(2, &(by_depth * process.depth_stiffness * share));
    stiffness[(1, 1)] = process.lateral_stiffness * e * in_plane;
    let mut damping = Matrix3::zeros();
    damping.set_column(2, &(by_depth * process.depth_damping * share));
    damping[(0, 0)] = exponent * drag * e * in_plane;
    damping[(1, 0)] = turn * exponent * drag * e * in_plane;
    damping[(1, 1)] = process.lateral_damping * e * in_plane;
    Reaction { force, stiffness, damping, channel_rate }
}
