//! What runs on the controller: the rigid and elastic mechanics of a six-axis arm, hybrid
//! force/position control and the compensation of the tool's deviation.
//!
//! `no_std`, no allocation, no `unsafe`, no panic (shown by the program in `tests/embedded`, which
//! would not link otherwise); every type has a fixed size and every function is generic over the
//! scalar ([`Real`]: `f32` on the controller, `f64` on the host). The core knows no file, no clock
//! and no simulator.
//!
//! Layers, bottom up:
//!
//! * [`spatial`], [`scalar`], [`ldlt`]: poses, twists, wrenches, joint vectors, linear algebra;
//! * [`robot`]: the immutable model, checked once when it is built ([`Robot::new`]);
//! * [`kinematics`], [`inverse_kinematics`], [`jacobian`]: where the tool is; [`Frames`] is computed
//!   once for a posture and shared;
//! * [`rnea`], [`crba`], [`stiffness`]: rigid-body dynamics, torsion of the drives, the loaded pose;
//! * [`filter`], [`pid`], [`control`]: hybrid force/position controllers, states as `Copy` structs;
//! * [`compensation`]: a law's correction on top of a controller;
//! * [`state`]: what changes while they run, taken out and put back.
//!
//! One control period: a law sees the instruments, the corrected set-point goes to the controller.
//! Where the loaded tool is, the model says:
//!
//! ```
//! use trueweld_core::compensation::{Compensated, Compensator, Observation};
//! use trueweld_core::control::External;
//! use trueweld_core::{JointVector, Pose, Robot};
//!
//! /// Motor torques, N·m, and the pose of the loaded tool.
//! fn period<L: Compensator<f32>>(
//!     robot: &Robot<f32>,
//!     controller: &mut Compensated<f32, External<f32>, L>,
//!     observation: &Observation<'_, f32>,
//! ) -> (JointVector<f32>, Pose<f32>) {
//!     let command = controller.cycle(robot, observation);
//!     let sensed = observation.sensed;
//!     (command.torque, robot.deflected(&sensed.encoder, &sensed.wrench, 3).real)
//! }
//! ```
#![no_std]

mod axis;
pub mod compensation;
pub mod control;
mod counterbalance;
pub mod crba;
pub mod error;
pub mod filter;
#[cfg(feature = "micromath")]
pub mod health;
mod inertia;
pub mod inverse_kinematics;
pub mod jacobian;
pub mod kinematics;
mod lanes;
pub mod ldlt;
#[cfg(feature = "micromath")]
pub mod monitor;
pub mod pid;
pub mod rnea;
pub mod robot;
pub mod scalar;
mod solve;
pub mod spatial;
pub mod state;
pub mod stiffness;

pub use counterbalance::{COUNTERBALANCE_POINTS, COUNTERBALANCE_TERMS, Counterbalance};
pub use error::{Fault, KinematicsError, ModelError};
pub use inverse_kinematics::Branch;
pub use jacobian::Jacobian;
pub use kinematics::{Displacement, Frames};
pub use robot::{Friction, JointParameters, Robot, RobotParameters, ToolParameters, smooth_sign};
pub use scalar::{JOINTS, JointVector, Real};
pub use spatial::{Pose, Twist, Wrench};
pub use stiffness::Deflection;
