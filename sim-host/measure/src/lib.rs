//! Measurements judge the model: logs, comparison, diagnosis of missing effects, improvement.

pub mod calibrate;
pub mod campaign;
pub mod compare;
pub mod diagnose;
pub mod evidence;
pub mod fir;
pub mod fit;
pub mod improve;
pub mod localize;
pub mod log;
pub mod noise;
pub mod per_log;
pub mod plan;
pub mod predict;
