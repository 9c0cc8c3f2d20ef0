//! Compensation laws, one file each, over the core's
//! [`Compensator`](trueweld_core::compensation::Compensator) trait.
//!
//! `no_std`, no allocation: the same code runs in simulation and on the controller.
#![no_std]

mod adaptive;
mod combined;
mod elastostatic;
mod feed_forward;
mod learning;
mod none;
mod observer;
mod outer_integral;
mod seam_tracking;
mod seen;

pub use adaptive::{Adaptive, Prior};
pub use combined::{Combined, CorrectionLimits};
pub use elastostatic::Elastostatic;
pub use feed_forward::FeedForward;
pub use learning::Learning;
pub use none::Uncompensated;
pub use observer::Observer;
pub use outer_integral::{FollowingGains, OuterIntegral};
pub use seam_tracking::{SeamTracking, TrackingGains};
