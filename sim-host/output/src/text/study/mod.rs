//! What is said of studies.

pub(crate) mod layout;
pub(crate) mod limits;
pub(crate) mod paper;
pub(crate) mod sensitivity;
