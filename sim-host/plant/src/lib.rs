//! The simulated welding cell.
