//! What is said of registered trackers.

use super::{Scale, counted, listed};
use trueweld_core::Pose;
use trueweld_core::spatial::rotation_vector;
use trueweld_estimate::mistakes::Registered;
use trueweld_logs::register::Mounting;

/// The finding in a sentence or two.
pub(crate) fn headline(registered: &[Registered]) -> String {
    let of = |found: &Registered| {
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
    };
    registered.iter().map(of).collect::<Vec<_>>().join(" ")
}

/// Half of an interval: `± 0.02 mm`.
pub(crate) fn half(scale: &Scale, width: f64) -> String {
    if width > 0.0 { format!("± {}", scale.quantity(width)) } else { String::new() }
}

/// The table `[tracker]` of a `log.toml`.
pub fn table(mounting: &Mounting) -> String {
    let vector = |v: [f64; 3]| format!("[{:.9}, {:.9}, {:.9}]", v[0], v[1], v[2]);
    let pose = |pose: &Pose<f64>, names: [&str; 2]| {
        format!(
            "{} = {}\n{} = {}\n",
            names[0],
            vector(pose.position.into()),
            names[1],
            vector(rotation_vector(&pose.rotation).into())
        )
    };
    format!(
        "[tracker]\n{}{}",
        pose(&mounting.frame, ["base_m", "base_rad"]),
        pose(&mounting.tool, ["point_m", "axes_rad"])
    )
}
