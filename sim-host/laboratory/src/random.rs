//! Streams of random numbers: one for each thing drawn, so that a change of one leaves the others
//! as they were.

// Those from [`REGISTRATION_STREAM`] on have a log's number added.
pub(crate) const NUISANCE_STREAM: u64 = 1;
pub(crate) const OUT_OF_LIBRARY_STREAM: u64 = 2;
pub(crate) const GEOMETRY_STREAM: u64 = 3;
/// Of the library's first effect; the others have their place in its table added.
pub(crate) const DRAW_STREAM: u64 = 100;
pub(crate) const REGISTRATION_STREAM: u64 = 1000;
pub(crate) const PLAN_STREAM: u64 = 2000;
pub(crate) const NOISE_STREAM: u64 = 3000;
/// Of the corpus: what is drawn for one case.
pub(crate) const CASE_STREAM: u64 = 4000;
