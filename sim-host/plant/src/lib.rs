//! The simulated welding cell.

pub mod input;
