//! Poses, twists and wrenches. A 6-vector always has its angular part first, and says so by its
//! type.
//!
//! Frames by letter: B base, F flange, T tool, W weld. A pose is named `b_from_t`: it takes
//! coordinates in T to coordinates in B, and composes as `b_from_t = b_from_f * f_from_t`.

use crate::scalar::{Real, lit};
use core::ops::{Add, Mul, Neg, Sub};
use nalgebra::{Matrix3, SVector, Vector3};

/// The cross-product matrix of v, so that `skew(v) * x == v × x`.
#[inline]
pub fn skew<T: Real>(v: &Vector3<T>) -> Matrix3<T> {
    let o = T::zero();
    Matrix3::new(o, -v.z, v.y, v.z, o, -v.x, -v.y, v.x, o)
}

/// Rotation matrix of a rotation vector (axis × angle, rad): Rodrigues' formula.
pub fn rotation_from_vector<T: Real>(r: &Vector3<T>) -> Matrix3<T> {
    let angle2 = r.norm_squared();
    let k = skew(r);
    // sin(a)/a and (1 − cos a)/a², by series where the quotients lose digits (error below a⁴/120).
    let (s, c) = if angle2 < lit(1e-4) {
        (
            T::one() - angle2 / lit(6.0) * (T::one() - angle2 / lit(20.0)),
            lit::<T>(0.5) - angle2 / lit(24.0) * (T::one() - angle2 / lit(30.0)),
        )
    } else {
        let a = angle2.sqrt();
        let half = (a * lit(0.5)).sin();
        (a.sin() / a, lit::<T>(2.0) * half * half / angle2)
    };
    Matrix3::identity() + k * s + k * k * c
}

/// Rotation vector (axis × angle, rad, angle in [0, π]) of a rotation matrix, accurate at 0 and at
/// π.
pub fn rotation_vector<T: Real>(m: &Matrix3<T>) -> Vector3<T> {
    // Through the quaternion whose largest component is formed by addition only (Shepperd 1978).
    let one = T::one();
    let trace = m.m11 + m.m22 + m.m33;
    let (w, v) = if trace > T::zero() {
        (one + trace, Vector3::new(m.m32 - m.m23, m.m13 - m.m31, m.m21 - m.m12))
    } else if m.m11 >= m.m22 && m.m11 >= m.m33 {
        (m.m32 - m.m23, Vector3::new(one + m.m11 - m.m22 - m.m33, m.m12 + m.m21, m.m13 + m.m31))
    } else if m.m22 >= m.m33 {
        (m.m13 - m.m31, Vector3::new(m.m12 + m.m21, one + m.m22 - m.m11 - m.m33, m.m23 + m.m32))
    } else {
        (m.m21 - m.m12, Vector3::new(m.m13 + m.m31, m.m23 + m.m32, one + m.m33 - m.m11 - m.m22))
    };
    let (w, v) = if w < T::zero() { (-w, -v) } else { (w, v) };
    let n = v.norm();
    if n <= w * lit(1e-20) {
        return Vector3::zeros();
    }
    v * (lit::<T>(2.0) * n.atan2(w) / n)
}

/// How far the entries of a rotation matrix may be off: digits lost in single precision or in a file
/// are fewer.
const ORTHONORMAL: f64 = 1e-3;

/// True for a rotation matrix: orthonormal and right-handed. False where a number is not finite.
pub fn is_rotation<T: Real>(m: &Matrix3<T>) -> bool {
    let [x, y, z] = [m.column(0), m.column(1), m.column(2)];
    let most = lit::<T>(ORTHONORMAL);
    let off = |value: T| (value - T::one()).abs();
    off(x.norm_squared()) <= most
        && off(y.norm_squared()) <= most
        && x.dot(&y).abs() <= most
        && (x.cross(&y) - z).norm_squared() <= most * most
}

/// A rigid motion: position and orientation of one frame in another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose<T: Real> {
    /// Rotation matrix; its columns are the axes of the inner frame in the outer one.
    pub rotation: Matrix3<T>,
    /// Origin of the inner frame in the outer one, m.
    pub position: Vector3<T>,
}

impl<T: Real> Pose<T> {
    /// The pose of a frame in itself.
    pub fn identity() -> Self {
        Self { rotation: Matrix3::identity(), position: Vector3::zeros() }
    }

    /// The inverse motion: `b_from_t.inverse()` is `t_from_b`.
    #[inline]
    pub fn inverse(&self) -> Self {
        let r = self.rotation.transpose();
        Self { rotation: r, position: -(r * self.position) }
    }

    /// A point of the inner frame, in the outer frame, m.
    #[inline]
    pub fn transform_point(&self, p: &Vector3<T>) -> Vector3<T> {
        self.rotation * p + self.position
    }

    /// The small motion that takes `self` to `target`, in axes of the outer frame, rotation about
    /// the inner frame's origin: ΔX of (2.2) with `self` the actual and `target` the desired pose.
    #[inline]
    pub fn error_to(&self, target: &Self) -> Twist<T> {
        Twist {
            angular: rotation_vector(&(target.rotation * self.rotation.transpose())),
            linear: target.position - self.position,
        }
    }

    /// Moves the pose by a finite displacement given as a twist in axes of the outer frame, the
    /// rotation about the inner frame's origin: the inverse of [`error_to`](Self::error_to).
    #[inline]
    pub fn displaced(&self, by: &Twist<T>) -> Self {
        Self {
            rotation: rotation_from_vector(&by.angular) * self.rotation,
            position: self.position + by.linear,
        }
    }

    /// True where all twelve numbers are finite.
    pub fn is_finite(&self) -> bool {
        crate::scalar::all_finite(self.rotation.iter().chain(self.position.iter()))
    }

    /// True where the position is finite and the rotation is one.
    pub fn is_rigid(&self) -> bool {
        is_rotation(&self.rotation) && crate::scalar::all_finite(self.position.iter())
    }
}

impl<T: Real> Mul for Pose<T> {
    type Output = Self;
    #[inline]
    fn mul(self, inner: Self) -> Self {
        Self {
            rotation: self.rotation * inner.rotation,
            position: self.transform_point(&inner.position),
        }
    }
}

macro_rules! six_vector {
    ($(#[$doc:meta])* $name:ident, $(#[$first_doc:meta])* $first:ident, $(#[$second_doc:meta])* $second:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name<T: Real> {
            $(#[$first_doc])*
            pub $first: Vector3<T>,
            $(#[$second_doc])*
            pub $second: Vector3<T>,
        }

        impl<T: Real> $name<T> {
            /// All six entries zero.
            #[inline]
            pub fn zero() -> Self {
                Self { $first: Vector3::zeros(), $second: Vector3::zeros() }
            }

            /// As one column, angular part first.
            #[inline]
            pub fn to_vector(&self) -> SVector<T, 6> {
                let (a, b) = (&self.$first, &self.$second);
                SVector::<T, 6>::new(a.x, a.y, a.z, b.x, b.y, b.z)
            }

            /// From one column, angular part first.
            #[inline]
            pub fn from_vector(v: &SVector<T, 6>) -> Self {
                Self { $first: Vector3::new(v[0], v[1], v[2]), $second: Vector3::new(v[3], v[4], v[5]) }
            }

            /// The same quantity in other axes (same reference point): both parts multiplied by
            /// `rotation`.
            #[inline]
            pub fn rotated(&self, rotation: &Matrix3<T>) -> Self {
                Self { $first: rotation * self.$first, $second: rotation * self.$second }
            }

            /// True where all six numbers are finite.
            pub fn is_finite(&self) -> bool {
                crate::scalar::all_finite(self.$first.iter().chain(self.$second.iter()))
            }
        }

        impl<T: Real> Add for $name<T> {
            type Output = Self;
            #[inline]
            fn add(self, o: Self) -> Self {
                Self { $first: self.$first + o.$first, $second: self.$second + o.$second }
            }
        }

        impl<T: Real> Sub for $name<T> {
            type Output = Self;
            #[inline]
            fn sub(self, o: Self) -> Self {
                Self { $first: self.$first - o.$first, $second: self.$second - o.$second }
            }
        }

        impl<T: Real> Neg for $name<T> {
            type Output = Self;
            #[inline]
            fn neg(self) -> Self {
                Self { $first: -self.$first, $second: -self.$second }
            }
        }

        impl<T: Real> Mul<T> for $name<T> {
            type Output = Self;
            #[inline]
            fn mul(self, k: T) -> Self {
                Self { $first: self.$first * k, $second: self.$second * k }
            }
        }
    };
}

six_vector!(
    /// Velocity of a frame, or a small displacement of it, at a stated point and in stated axes.
    Twist,
    /// Angular velocity, rad/s (displacement: rotation vector, rad).
    angular,
    /// Velocity of the reference point, m/s (displacement: m).
    linear
);

six_vector!(
    /// Moment and force on a body, at a stated point and in stated axes.
    Wrench,
    /// Moment about the reference point, N·m.
    moment,
    /// Force, N.
    force
);
