//! How far a model is from its logs, channel by channel, and under which conditions it fails.

pub mod compare;
pub mod error;
pub mod finding;
pub mod localize;
pub mod single_load;
