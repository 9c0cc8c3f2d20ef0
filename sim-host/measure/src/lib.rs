//! Measurements judge the model: logs, comparison, diagnosis of missing effects, improvement.

pub mod afresh;
pub mod band;
pub mod calibrate;
pub mod campaign;
pub mod compare;
pub mod diagnose;
pub mod evidence;
pub mod fit;
pub mod improve;
pub mod localize;
pub mod log;
pub mod noise;
pub mod plan;
pub mod predict;
