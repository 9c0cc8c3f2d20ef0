//! How a joint turns its link.

use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// How a joint turns its link: about a coordinate axis of the link frame, as nearly all arms do, or
/// about any other.
///
/// The value beside a coordinate axis is its sense, +1 or −1. A rotation about a coordinate axis
/// mixes two columns of a matrix only, which more than halves the work. Decided once, when the
/// robot is built, by the numbers given: for dual numbers the derivatives to an aligned axis'
/// direction are not carried.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Axis<T: Real> {
    X(T),
    Y(T),
    Z(T),
    Oblique(Vector3<T>),
}

impl<T: Real> Axis<T> {
    /// From the unit vector of the axis in the link frame.
    pub(crate) fn new(axis: &Vector3<T>) -> Self {
        match [axis.x, axis.y, axis.z].map(|v| !v.is_zero()) {
            [true, false, false] => Self::X(axis.x.signum()),
            [false, true, false] => Self::Y(axis.y.signum()),
            [false, false, true] => Self::Z(axis.z.signum()),
            _ => Self::Oblique(*axis),
        }
    }

    /// The link's rotation, from its parent's and the sine and cosine of the joint angle.
    #[inline(always)]
    pub(crate) fn turn(&self, parent: &Matrix3<T>, s: T, c: T) -> Matrix3<T> {
        let (x, y, z) = (parent.column(0), parent.column(1), parent.column(2));
        match self {
            Self::X(sense) => {
                let s = s * *sense;
                Matrix3::from_columns(&[x.into_owned(), y * c + z * s, z * c - y * s])
            }
            Self::Y(sense) => {
                let s = s * *sense;
                Matrix3::from_columns(&[x * c - z * s, y.into_owned(), z * c + x * s])
            }
            Self::Z(sense) => {
                let s = s * *sense;
                Matrix3::from_columns(&[x * c + y * s, y * c - x * s, z.into_owned()])
            }
            Self::Oblique(axis) => parent * rodrigues(axis, s, c),
        }
    }

    /// The axis in the outer frame, given the link's rotation in it.
    #[inline(always)]
    pub(crate) fn direction(&self, rotation: &Matrix3<T>) -> Vector3<T> {
        match self {
            Self::X(sense) => rotation.column(0) * *sense,
            Self::Y(sense) => rotation.column(1) * *sense,
            Self::Z(sense) => rotation.column(2) * *sense,
            Self::Oblique(axis) => rotation * axis,
        }
    }
}

/// Rotation about a unit axis by Rodrigues' formula, from the angle's sine and cosine.
#[inline(always)]
fn rodrigues<T: Real>(axis: &Vector3<T>, s: T, c: T) -> Matrix3<T> {
    let v = T::one() - c;
    let (x, y, z) = (axis.x, axis.y, axis.z);
    let (vx, vy, vz) = (v * x, v * y, v * z);
    let (sx, sy, sz) = (s * x, s * y, s * z);
    Matrix3::new(
        vx * x + c,
        vx * y - sz,
        vx * z + sy,
        vx * y + sz,
        vy * y + c,
        vy * z - sx,
        vx * z - sy,
        vy * z + sx,
        vz * z + c,
    )
}
