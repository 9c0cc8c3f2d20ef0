//! What a number in a file must be.

use super::quantity::{Judgement, Quantity, quantity};

/// No quantity of a welding cell in SI units is larger than this; beyond it products overflow.
const QUANTITY_MAX: f64 = 1e12;

/// What a number must be. Every number must also be finite and at most 10¹² in magnitude, a product
/// of two quantities at most its square.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bounds<'k> {
    /// The possible range of a [`Quantity`], by its key.
    Of(&'k str),
    /// The possible range of this quantity.
    In(&'k Quantity),
    /// Any finite number.
    Any,
    /// Any finite product of two quantities, such as a covariance.
    Product,
    /// Above zero.
    Positive,
    /// Zero or above.
    NonNegative,
    /// From the first to the second.
    Between(f64, f64),
    /// Above zero, and at most this: a larger one is most likely in another unit.
    PositiveUpTo(f64),
    /// Zero or above, and at most this: a larger one is most likely in another unit.
    UpTo(f64),
}

impl Bounds<'_> {
    /// Largest magnitude.
    pub(super) fn largest(self) -> f64 {
        if self == Self::Product { QUANTITY_MAX * QUANTITY_MAX } else { QUANTITY_MAX }
    }

    pub(super) fn hold(self, x: f64) -> bool {
        x.is_finite()
            && x.abs() <= self.largest()
            && match self {
                Self::Of(key) => quantity(key).is_some_and(|q| q.judge(x) != Judgement::Impossible),
                Self::In(quantity) => quantity.judge(x) != Judgement::Impossible,
                Self::Between(low, high) => (low..=high).contains(&x),
                Self::Any | Self::Product => true,
                Self::Positive => x > 0.0,
                Self::NonNegative => x >= 0.0,
                Self::PositiveUpTo(top) => x > 0.0 && x <= top,
                Self::UpTo(top) => (0.0..=top).contains(&x),
            }
    }

    pub(super) fn describe(self, unit: Option<&str>) -> String {
        let unit = unit.map(|u| format!(" in {u}")).unwrap_or_default();
        match self {
            Self::Of(key) => quantity(key)
                .map_or(format!("a quantity of the table, not {key}"), Quantity::expected),
            Self::In(quantity) => quantity.expected(),
            Self::Between(low, high) => format!("a number from {low:?} to {high:?}{unit}"),
            Self::Any | Self::Product => format!("a finite number{unit}"),
            Self::Positive => format!("a number above 0{unit}"),
            Self::NonNegative => format!("a number not below 0{unit}"),
            Self::PositiveUpTo(top) => format!("a number above 0 and at most {top}{unit}"),
            Self::UpTo(top) => format!("a number from 0 to {top}{unit}"),
        }
    }
}
