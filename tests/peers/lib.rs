//! Nothing of its own: the benchmark beside it is all.
