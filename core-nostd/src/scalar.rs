//! The scalar every formula of the core is written over.

use nalgebra::{RealField, SVector};

/// Number of actuated joints: the six revolute axes of a serial arm.
pub const JOINTS: usize = 6;

/// A real scalar: `f32` on the controller, `f64` on the host, dual numbers for derivatives.
pub trait Real: RealField + Copy {}
impl<T: RealField + Copy> Real for T {}

/// One value a joint, A1 first. Units are those of the quantity it holds: rad, rad/s, N·m …
pub type JointVector<T> = SVector<T, JOINTS>;

/// Converts a literal of the formulas (never a physical parameter) to the scalar in use.
#[inline(always)]
pub fn lit<T: Real>(value: f64) -> T {
    nalgebra::convert(value)
}

/// `value` held within `reach` of `center`. A reach that is negative or NaN counts as zero, where
/// `clamp` would panic.
#[inline]
pub(crate) fn held<T: Real>(value: T, center: T, reach: T) -> T {
    let reach = reach.max(T::zero());
    let (low, high) = (center - reach, center + reach);
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

/// True where every entry is a finite number.
#[inline]
pub fn all_finite<'a, T: Real>(values: impl IntoIterator<Item = &'a T>) -> bool {
    values.into_iter().all(|v| v.is_finite())
}
