//! Compensation laws, one file each, over the core's [`Compensator`](trueweld_core::compensation::Compensator) trait.
//!
//! `no_std`, no allocation: the same code runs in simulation and on the controller.
#![no_std]

mod elastostatic;
mod none;

pub use elastostatic::Elastostatic;
pub use none::Uncompensated;
