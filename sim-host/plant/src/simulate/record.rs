//! What a simulated run leaves behind: one row a control period, and what the run was.

use crate::{named, serialize_as_text};
use nalgebra::{Matrix3, Vector3};
use schemars::JsonSchema;
use serde::Serialize;
use trueweld_core::control::Limited;
use trueweld_core::monitor::HealthSignals;
use trueweld_core::{Fault, JointVector, Pose, Twist};

named! {
    /// Where the run was in its program.
    #[derive(PartialOrd, Ord)]
    pub enum Phase {
        /// Pure position control, tool in the material, waiting for rest.
        Settle = "settle under position control",
        /// Force loop closed, push rising to its working value.
        ForceRamp = "force loop closed, force rising",
        /// Feed rising to its working value.
        FeedRamp = "feed rising",
        /// Full feed and full force: the steady part, which the figures are taken over.
        Steady = "steady",
        /// Feed falling to zero at the end of the seam.
        Stop = "feed falling",
        /// Standing with the force held: at the end of the seam, and after a step of the force.
        Hold = "standing, force held",
    }
}

serialize_as_text!(Phase::name);

/// The cell at one instant. Poses and positions in B, everything named `…_w` in axes of the weld
/// frame W (x along the weld, y lateral, z depth into the material).
#[derive(Debug, Clone, Copy)]
pub struct RecordRow {
    /// Time, s.
    pub time: f64,
    /// Where the run is in its program.
    pub phase: Phase,
    /// Path position, m.
    pub path: f64,
    /// Axes of W in B there, of the seam as it really lies.
    pub axes: Matrix3<f64>,
    /// Where the real tool should be: on the plate's surface, square to it.
    pub nominal: Pose<f64>,
    /// Where the real tool is.
    pub real: Pose<f64>,
    /// Where the encoders say it is.
    pub encoder_pose: Pose<f64>,
    /// Real tool against nominal: linear (longitudinal, lateral, depth) in m, angular as a rotation
    /// vector, rad.
    pub deviation_w: Twist<f64>,
    /// Angle between real and nominal tool axis, rad.
    pub tilt: f64,
    /// Lateral deviation by the torsion that the process adds to each joint, m: to first order, the
    /// displacement by its torsion less that by the torsion which the same posture has with the
    /// tool free. Their sum is the lateral deviation before correction, `deviation_w` less
    /// `correction_w`, but for the change of gravity's part along the seam, terms of second order
    /// and the position loop's error.
    pub lateral_by_joint: JointVector<f64>,
    /// Real force of the process on the tool, N.
    pub force_w: Vector3<f64>,
    /// The same as the sensor gives it (noise, filter, delay), N.
    pub force_sensed_w: Vector3<f64>,
    /// Push asked for along z of W, N; `None` before the force loop is closed.
    pub force_desired: Option<f64>,
    /// Real joint angles θ, rad.
    pub link: JointVector<f64>,
    /// Encoder angles θ_E, rad, as the motor stands (before quantisation).
    pub motor: JointVector<f64>,
    /// Motor torque Γ, N·m.
    pub torque: JointVector<f64>,
    /// Spindle angle, rad.
    pub spindle_angle: f64,
    /// Force error as the controller sees it, N.
    pub force_error: f64,
    /// Depth that the external force loop adds, m.
    pub depth_correction: f64,
    /// Push that the force branch adds (parallel and superposed controllers), N.
    pub push: f64,
    /// Compensation in force on the set-point, axes of W.
    pub correction_w: Twist<f64>,
    /// What was held at a limit.
    pub limited: Limited,
    /// What the watch beside the law sees of the machine.
    pub health: HealthSignals,
    /// Fault of the controller or the law in this period.
    pub fault: Option<Fault>,
}

impl RecordRow {
    /// Torsion of every drive, θ_E − θ, rad.
    pub fn torsion(&self) -> JointVector<f64> {
        self.motor - self.link
    }
}

/// One simulated run.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Recording {
    // Its file's stem, or "vertical" for the embedded default.
    /// Name of the weld.
    pub weld: String,
    /// Name of the hybrid controller.
    pub controller: &'static str,
    /// Name of the compensation law.
    pub compensator: String,
    /// Rows in time order, `period` apart.
    #[serde(skip)]
    pub rows: Vec<RecordRow>,
    /// Time between rows, s.
    #[serde(skip)]
    pub period: f64,
    /// How far beside its line the tool may be, m: of a friction stir weld half the pin's diameter.
    #[serde(skip)]
    pub half_pin: f64,
    /// What that is, in words.
    #[serde(skip)]
    pub tolerance_name: &'static str,
    /// Push of the weld program, N.
    #[serde(skip)]
    pub force: f64,
    /// Force on the tool that the process as planned has at that push and the weld's feed, mean over a
    /// turn, axes of W, N.
    #[serde(skip)]
    pub planned_force: Vector3<f64>,
    /// Depth at which the process as planned bears that push, m.
    #[serde(skip)]
    pub planned_depth: f64,
    /// Largest torque of each drive, N·m.
    #[serde(skip)]
    pub max_torque: JointVector<f64>,
    /// Largest speed of each drive, at the joint, rad/s.
    #[serde(skip)]
    pub max_rate: JointVector<f64>,
    /// Seed of the sensors' noise.
    pub seed: u64,
    /// Simulated time, s.
    #[serde(skip)]
    pub simulated: f64,
    /// Time the simulation took, s.
    #[serde(skip)]
    pub wall: f64,
}
