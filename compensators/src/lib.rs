//! Compensation laws, one file each, over the core's [`Compensator`] trait.
//!
//! A law's file holds its equations, its gains with their defaults, and an implementation of
//! [`Law`]: name, summary, what it needs, how it is built. [`for_each`] is the table of all laws,
//! one line each, beside their modules. `no_std`, no allocation: the same code runs in simulation
//! and on the controller. With the feature `configuration`, `RunningCore` is robot model, controller
//! and law built from one `Configuration` of plain constants. With the feature `host`, `Entry` is a
//! law with its type erased, found by name and built from a table of gains.
//!
//! ```
//! use trueweld_compensators::{FeedForward, Law, SeamTracking, Setup, TrackingGains};
//!
//! let setup = Setup::new(0.012, 2.0);
//! let gains = TrackingGains { rate_rad_s: 2.0, ..TrackingGains::default() };
//! let law = SeamTracking::<f64, FeedForward>::build(&gains, &setup);
//! assert!(law.is_ok());
//! let wrong = TrackingGains { rate_rad_s: -2.0, ..gains };
//! let error = SeamTracking::<f64, FeedForward>::build(&wrong, &setup).err();
//! assert_eq!(error.map(|e| e.key), Some("rate_rad_s"));
//! ```
//!
//! [`Compensator`]: trueweld_core::compensation::Compensator
#![cfg_attr(not(feature = "host"), no_std)]

mod by_compliance;
mod combined;
#[cfg(feature = "configuration")]
mod configuration;
mod deviation_history;
#[cfg(feature = "host")]
mod entry;
mod estimate;
mod gain;
#[cfg(feature = "configuration")]
mod gain_numbers;
#[cfg(feature = "host")]
mod header;
mod law;
mod laws;
mod outer_integral;
#[cfg(feature = "configuration")]
mod running_core;
#[cfg(feature = "host")]
mod source;

pub use combined::{Combined, CombinedGains};
#[cfg(feature = "configuration")]
pub use configuration::{
    CONFIGURATION_VERSION, Configuration, ConfigurationError, ControlNumbers, JointNumbers,
    LawNumbers, LimitNumbers, RobotNumbers, Scheme,
};
#[cfg(feature = "host")]
pub use entry::{
    BuildError, Entry, GainTables, LawInstallError, OwnedLaw, find, find_among, install, library,
    may_be_name,
};
pub use gain::{GainError, require};
#[cfg(feature = "configuration")]
pub use gain_numbers::{Character, GAIN_VALUES, GAINS, GainNumbers, NAME_BYTES, Name};
#[cfg(feature = "host")]
pub use header::HeaderError;
pub use law::{GainSet, Law, Needs, NoGains, Setup};
pub use laws::*;
pub use outer_integral::{FollowingGains, OuterIntegral};
#[cfg(feature = "configuration")]
pub use running_core::{Hybrid, RunningCore};
