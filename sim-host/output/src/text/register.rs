//! What is said of registered trackers.

use super::{Scale, counted, listed};
use nalgebra::Vector3;
use trueweld_core::spatial::rotation_vector;
use trueweld_estimate::log_faults::Registered;
use trueweld_logs::register::Mounting;

/// The finding in a sentence or two.
pub(crate) fn headline(registered: &[Registered]) -> String {
    registered.iter().map(tracker).collect::<Vec<_>>().join(" ")
}

fn tracker(found: &Registered) -> String {
    let (position, angle) = (Scale::small("m"), Scale::small("rad"));
    let registration = &found.registration;
    let turn = rotation_vector(&registration.mounting.frame.rotation).norm();
    format!(
        "{}: the tracker stands {:.4} m from the robot's base, turned by {:.3}°; {} of {} and {} are left.",
        listed(&found.logs, "and"),
        registration.mounting.frame.position.norm(),
        turn.to_degrees(),
        counted(registration.poses, "pose"),
        position.quantity(registration.left[0]),
        angle.quantity(registration.left[1])
    )
}

/// Half of an interval: `± 0.02 mm`.
pub(crate) fn half(scale: &Scale, width: f64) -> String {
    if width > 0.0 { format!("± {}", scale.quantity(width)) } else { String::new() }
}

/// The table `[tracker]` of a `log.toml`.
pub fn table(mounting: &Mounting) -> String {
    let Mounting { frame, tool } = mounting;
    let lines = [
        ("base_m", frame.position),
        ("base_rad", rotation_vector(&frame.rotation)),
        ("point_m", tool.position),
        ("axes_rad", rotation_vector(&tool.rotation)),
    ];
    let line = |(name, v): (&str, Vector3<f64>)| {
        format!("{name} = [{:.9}, {:.9}, {:.9}]\n", v[0], v[1], v[2])
    };
    format!("[tracker]\n{}", lines.map(line).concat())
}
