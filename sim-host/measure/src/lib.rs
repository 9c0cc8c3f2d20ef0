//! Measurements judge the model: logs, comparison, diagnosis of missing effects, improvement.
//!
//! The rooms, in the order in which data pass through them:
//!
//! | room | holds |
//! |---|---|
//! | [`data`] | logs, campaigns of logs, their noise, filters |
//! | [`predict`] | what a model predicts of a log's channels |
//! | [`fit`] | effects fitted to logs by their residuals; calibrations |
//! | [`residuals`] | how far a model is from its logs, and under which conditions |
//! | [`diagnose`] | which effect is missing, and the curve that shows it |
//! | [`experiment`] | what to record next |
//! | [`improve`] | a model with what was found, step by step |

pub mod data;
pub mod diagnose;
pub mod experiment;
pub mod fit;
pub mod improve;
pub mod predict;
pub mod residuals;
