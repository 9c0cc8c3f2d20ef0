//! What is said of studies.

pub(crate) mod paper;
pub(crate) mod sensitivity;
