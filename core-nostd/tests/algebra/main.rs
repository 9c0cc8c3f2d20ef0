//! What needs no robot: poses and twists, filters, the PID loop, health signals.

mod filter;
#[cfg(feature = "micromath")]
mod health;
mod pid;
mod spatial;
mod support;
