//! The laws: one file each, and the table of them. To add one, write its file, and its module and its
//! line in the table below.

mod adaptive;
mod elastostatic;
mod feed_forward;
mod learning;
mod none;
mod observer;
mod seam_tracking;
mod self_calibrating;

pub use adaptive::{Adaptive, AdaptiveGains};
pub use elastostatic::{Elastostatic, ElastostaticGains};
pub use feed_forward::FeedForward;
pub use learning::{Learning, LearningGains};
pub use none::Uncompensated;
pub use observer::{Observer, ObserverGains};
pub use seam_tracking::{SeamTracking, TrackingGains};
pub use self_calibrating::{SelfCalibrating, SelfCalibratingGains};

use crate::law::Law;
use trueweld_core::Real;

/// Calls the visitor with every law. The table: a new law is one line here.
pub fn for_each<T: Real>(visitor: &mut impl Visitor<T>) {
    visitor.visit::<Uncompensated>();
    visitor.visit::<Elastostatic<T>>();
    visitor.visit::<FeedForward>();
    visitor.visit::<Observer<T>>();
    visitor.visit::<SeamTracking<T, FeedForward>>();
    visitor.visit::<Adaptive<T>>();
    visitor.visit::<Learning<T, FeedForward>>();
    visitor.visit::<SelfCalibrating<T>>();
}

/// What is done with every law of the table.
pub trait Visitor<T: Real> {
    /// Called once a law.
    fn visit<L: Law<T>>(&mut self);
}
