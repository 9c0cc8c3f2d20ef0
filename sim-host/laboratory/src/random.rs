//! Streams of random numbers: one for each thing drawn, so that a change of one leaves the others
//! as they were.

// Those from [`REGISTRATION`] on have a log's number added.
pub(crate) const NUISANCE: u64 = 1;
pub(crate) const OUT_OF_LIBRARY: u64 = 2;
pub(crate) const GEOMETRY: u64 = 3;
/// Of the library's first effect; the others have their place in its table added.
pub(crate) const DRAW: u64 = 100;
pub(crate) const REGISTRATION: u64 = 1000;
pub(crate) const PLAN: u64 = 2000;
pub(crate) const NOISE: u64 = 3000;
/// Of the corpus: what is drawn for one case.
pub(crate) const CASE: u64 = 4000;
