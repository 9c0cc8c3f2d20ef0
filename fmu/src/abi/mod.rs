//! What importers call: the functions of FMI 2.0 and 3.0. All `unsafe` of this crate is here.
//!
//! Every function takes what C can give: a null pointer is an error, and so is what the instance
//! refuses. No panic leaves: one that happens is an error, and the instance takes no more steps.

mod common;
mod component;
pub mod fmi2;
pub mod fmi3;
mod pointer;
