//! The table of all laws.

use crate::law::Law;
use crate::{Adaptive, Elastostatic, FeedForward, Learning, Observer, SeamTracking, Uncompensated};
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
}

/// What is done with every law of the table.
pub trait Visitor<T: Real> {
    /// Called once a law.
    fn visit<L: Law<T>>(&mut self);
}
