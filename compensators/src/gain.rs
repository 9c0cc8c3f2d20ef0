//! Checks of gains.

use core::fmt;
use trueweld_core::Real;

/// A gain that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GainError {
    /// Name of the gain, as in the control file.
    pub key: &'static str,
    /// What it must be.
    pub expected: &'static str,
}

impl fmt::Display for GainError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` is out of range; expected {}", self.key, self.expected)
    }
}

impl core::error::Error for GainError {}

/// An error that names the gain, unless the condition holds.
///
/// # Errors
/// The condition does not hold.
pub fn require(
    condition: bool,
    key: &'static str,
    expected: &'static str,
) -> Result<(), GainError> {
    if condition { Ok(()) } else { Err(GainError { key, expected }) }
}

/// Above zero and finite.
pub(crate) fn positive(value: impl Real, key: &'static str) -> Result<(), GainError> {
    require(value.is_finite() && value > nalgebra::zero(), key, "a number above 0")
}

/// What a gain of at most 1 must be.
pub(crate) const AT_MOST_ONE: &str = "a number above 0 and at most 1";

/// What a gain of at most 10 must be.
pub(crate) const AT_MOST_TEN: &str = "a number above 0 and at most 10";

/// A control period.
pub(crate) fn usable_period(period: impl Real) -> Result<(), GainError> {
    positive(period, "period_s")
}

/// Declares the gains of a law, each with its default.
macro_rules! gains {
    ($(#[$about:meta])* pub struct $name:ident {
        $($(#[$of:meta])* pub $key:ident: $kind:ty = $default:expr,)+
    }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[cfg_attr(feature = "configuration", derive(serde::Serialize, serde::Deserialize))]
        pub struct $name {
            $($(#[$of])* pub $key: $kind,)+
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($key: $default),+ }
            }
        }
    };
}
pub(crate) use gains;
