//! What the arm is at one place of a weld, from kinematics and statics alone: reserves, stiffness,
//! where the load takes the tool. Gains are made from it, and places for a part are chosen by it.
//!
//! Left out: motion. The tool stands on its line under the planned force, and the joints turn as
//! fast as the feed has them.

use nalgebra::{Vector3, Vector6};
use schemars::JsonSchema;
use serde::Serialize;
use trueweld_core::{JOINTS, JointParameters, JointVector, Robot, Twist, Wrench};
use trueweld_plant::input::{Process, Weld};
use trueweld_plant::process::planned;
use trueweld_plant::simulate::{Seam, TaughtOffset, encoder_offset};

/// A weld where it is, and the arm that makes it.
#[derive(Debug, Clone, Copy)]
pub struct PlacedSeam<'a> {
    /// The arm as the controller believes in it.
    pub robot: &'a Robot<f64>,
    /// The process as the weld is planned with it.
    pub planned: &'a Process,
    /// The weld.
    pub weld: &'a Weld,
    /// Its seam.
    pub seam: &'a Seam,
}

/// The arm at one place of the weld.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "ArmPlace", deny_unknown_fields)]
pub struct ArmAt {
    /// Path position, m.
    pub path_m: f64,
    /// Joint angles that hold the tool on its line, rad.
    #[serde(skip)]
    pub posture: JointVector<f64>,
    /// Inertia that each drive moves, rotor and links, kg·m².
    #[serde(skip)]
    pub inertia: JointVector<f64>,
    /// Lowest natural frequency with the motors locked, rad/s.
    pub mode_rad_s: f64,
    // Arm and material in series.
    /// Stiffness that the tool meets along its axis, N/m.
    pub stiffness_n_m: f64,
    /// Stiffness of the arm along each axis of W by itself, N/m: 1/(nᵀ J K⁻¹ Jᵀ n).
    #[serde(skip)]
    pub cartesian: Vector3<f64>,
    /// Inertia of the drives along the tool's axis, kg.
    #[serde(skip)]
    pub mass: f64,
    // In the steady part, with its friction.
    /// Torque of each drive over what it may give.
    #[schemars(with = "Vec<f64>")]
    pub torque: [f64; JOINTS],
    // At full feed.
    /// Speed of each joint over what it may do.
    #[schemars(with = "Vec<f64>")]
    pub speed: [f64; JOINTS],
    /// Where the planned load takes a tool that nothing corrects, from its line, axes of W: m and
    /// rad. Along z the force loop presses as deep as it needs.
    #[serde(skip)]
    pub displacement: Twist<f64>,
    /// Correction that the planned load asks for, m.
    pub correction_m: f64,
    /// The same in orientation, rad.
    pub correction_rad: f64,
    /// Angle between the axes of A4 and A6, at most a right angle, rad: 0 where they are collinear.
    #[serde(skip)]
    pub collinearity: f64,
    /// Least angle between a joint and an end of its range, rad.
    #[serde(skip)]
    pub to_limit: f64,
}

impl ArmAt {
    /// The arm `path` m along a seam in a posture that holds the tool there. `taught`: from the
    /// nominal pose to that of the encoders as the path was taught. `None` in a
    /// singular posture.
    pub fn of(
        of: &PlacedSeam<'_>,
        path: f64,
        posture: &JointVector<f64>,
        taught: &TaughtOffset,
    ) -> Option<Self> {
        let PlacedSeam { robot, planned: process, weld, seam } = *of;
        let frames = robot.frames(posture);
        let w = seam.axes(path);
        let z = w.column(2).into_owned();
        let inertia = robot.rotor_inertia() + robot.crba(&frames).diagonal();
        let mode = robot.natural_frequencies(&frames)?[0];
        let lever = frames.joint_torque(&Wrench { moment: Vector3::zeros(), force: z });
        let compliance =
            Vector3::from_fn(|k, _| robot.compliance_along(&frames, &w.column(k).into_owned()));
        let feed = weld.feed_at(path);
        let force = planned(process, weld.force, feed);
        let load = Wrench { moment: Vector3::zeros(), force: w * force };
        let along = w.column(0) * feed;
        let twist = Vector6::new(0.0, 0.0, 0.0, along.x, along.y, along.z);
        let rate = frames.jacobian().0.lu().solve(&twist)?;
        let spring = robot.spring_torque_at_rest(&frames, posture, &load);
        let parameters = robot.parameters();
        let friction = &parameters.friction;
        let rated = |of: fn(&JointParameters<f64>) -> f64| {
            JointVector::from_fn(|i, _| of(&parameters.joints[i]))
        };
        let lost = friction.coulomb + friction.viscous.component_mul(&rate.abs());
        let to_t = frames.tcp.rotation.transpose();
        let motor = robot.fake_target(posture, &load.rotated(&to_t));
        let asked =
            encoder_offset(robot, seam, path, &motor) - taught.in_b(&w).rotated(&w.transpose());
        let (a4, a6) = (frames.axis[3], frames.axis[JOINTS - 1]);
        let to_limit = parameters.joints.iter().zip(posture.iter()).map(|(joint, angle)| {
            let [low, high] = joint.limits;
            (angle - low).min(high - angle)
        });
        Some(Self {
            path_m: path,
            posture: *posture,
            inertia,
            mode_rad_s: mode,
            stiffness_n_m: (process.model.depth_stiffness().recip() + compliance.z).recip(),
            cartesian: compliance.map(f64::recip),
            mass: lever.component_mul(&lever).component_div(&inertia).sum().recip(),
            torque: (spring.abs() + lost).component_div(&rated(|joint| joint.max_torque)).into(),
            speed: rate.abs().component_div(&rated(|joint| joint.max_rate)).into(),
            displacement: -asked,
            correction_m: asked.linear.x.hypot(asked.linear.y),
            correction_rad: asked.angular.norm(),
            collinearity: a4.cross(&a6).norm().atan2(a4.dot(&a6).abs()),
            to_limit: to_limit.fold(f64::INFINITY, f64::min),
        })
    }
}
