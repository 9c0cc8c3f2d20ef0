//! The functions that importers call, called as they call them.

mod abi;
mod package;
