//! A link that is not mounted where the robot file has it.

use nalgebra::Vector3;
use trueweld_core::{JOINTS, Pose, RobotParameters};

/// Mounts the link behind a joint, 0 = A1, off by a small rigid motion p' = R p + t in that link's
/// frame: its mass, the tool and all later joints go with it; the joint's own axis stays.
///
/// The frames of later links turn by R, so that at angles of 0 they are parallel to the link that
/// is mounted off and not to B.
pub fn mount(robot: &mut RobotParameters<f64>, joint: usize, motion: &Pose<f64>) {
    let turn = &motion.rotation;
    for (k, link) in robot.joints.iter_mut().enumerate().skip(joint) {
        link.center_of_mass = turn * link.center_of_mass;
        link.inertia = turn * link.inertia * turn.transpose();
        if k == joint {
            link.center_of_mass += motion.position;
        } else {
            link.axis = turn * link.axis;
            link.origin = turn * link.origin;
        }
    }
    let tool = &mut robot.tool;
    for vector in [
        &mut tool.flange_offset,
        &mut tool.com_from_flange,
        &mut tool.tcp_from_flange,
        &mut tool.z_axis,
        &mut tool.y_axis,
    ] {
        *vector = turn * *vector;
    }
    tool.inertia = turn * tool.inertia * turn.transpose();
    let next: &mut Vector3<f64> = match joint + 1 {
        JOINTS => &mut tool.flange_offset,
        next => &mut robot.joints[next].origin,
    };
    *next += motion.position;
}
