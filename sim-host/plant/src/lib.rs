//! The simulated welding cell: input files, effects, elastic robot, process, sensors, integrators
//! and the multi-rate loop that joins them.

pub mod cell;
pub mod effects;
pub mod input;
pub mod integrate;
pub mod process;
pub mod provenance;
pub mod random;
pub mod robot;
pub mod sensors;
pub mod simulate;
