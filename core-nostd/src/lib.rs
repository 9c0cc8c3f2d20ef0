//! What runs on the controller: the rigid and elastic mechanics of a six-axis arm, hybrid
//! force/position control and the compensation of the tool's deviation.
//!
//! `no_std`, no allocation, no `unsafe`, no panic (shown by the program in `tests/embedded`, which
//! would not link otherwise); every type has a fixed size and every function is generic over the
//! scalar ([`Real`]: `f32` on the controller, `f64` on the host). The core knows no file, no clock
//! and no simulator.
#![no_std]

pub mod compensation;
pub mod control;
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
pub mod pid;
pub mod rnea;
pub mod robot;
pub mod scalar;
mod solve;
pub mod spatial;
pub mod stiffness;

pub use error::{Fault, KinematicsError, ModelError};
pub use inverse_kinematics::Branch;
pub use jacobian::Jacobian;
pub use kinematics::{Displacement, Frames};
pub use robot::{
    Counterbalance, Friction, JointParameters, Robot, RobotParameters, ToolParameters,
};
pub use scalar::{JOINTS, JointVector, Real};
pub use spatial::{Pose, Twist, Wrench};
pub use stiffness::Deflection;
