//! The simulated welding cell: input files, effects, elastic robot, process, sensors, integrators and the multi-rate
//! loop that joins them.

pub mod simulate;
