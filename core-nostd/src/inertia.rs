//! Inertia of a rigid body by its moments of mass: m, ∫ r dm and Σ = ∫ r rᵀ dm about the origin of its link frame.
//!
//! The second moments Σ take the place of the rotational inertia I = tr(Σ)·1 − Σ because what dynamics asks of a body
//! is cheaper in them: turning into other axes, shifting to another point, and the moment of an acceleration field.
//! Source: Wensing, Kim, Slotine, "Linear matrix inequalities for physically consistent inertial parameter
//! identification", RA-L 3(1), 2018 (pseudo-inertia).

use crate::scalar::{Real, lit};
use nalgebra::{Matrix3, Vector3};

/// A body about one point, in the axes of one frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body<T: Real> {
    /// Mass, kg.
    pub mass: T,
    /// First moment m·c, kg·m.
    pub first: Vector3<T>,
    /// Second moments, kg·m².
    pub second: SecondMoments<T>,
}

/// ∫ r rᵀ dm, kg·m²: a symmetric matrix, each entry once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SecondMoments<T: Real> {
    xx: T,
    yy: T,
    zz: T,
    xy: T,
    xz: T,
    yz: T,
}

impl<T: Real> Body<T> {
    /// From mass, centre of mass and the inertia about it.
    pub fn new(mass: T, center_of_mass: &Vector3<T>, inertia: &Matrix3<T>) -> Self {
        let half_trace = inertia.trace() * lit(0.5);
        let first = center_of_mass * mass;
        let s = first * center_of_mass.transpose() - inertia;
        let second = SecondMoments {
            xx: s.m11 + half_trace,
            yy: s.m22 + half_trace,
            zz: s.m33 + half_trace,
            xy: (s.m12 + s.m21) * lit(0.5),
            xz: (s.m13 + s.m31) * lit(0.5),
            yz: (s.m23 + s.m32) * lit(0.5),
        };
        Self { mass, first, second }
    }

    /// Two bodies about the same point, taken as one.
    #[inline(always)]
    pub fn merged(&self, other: &Self) -> Self {
        let (a, b) = (&self.second, &other.second);
        Self {
            mass: self.mass + other.mass,
            first: self.first + other.first,
            second: SecondMoments {
                xx: a.xx + b.xx,
                yy: a.yy + b.yy,
                zz: a.zz + b.zz,
                xy: a.xy + b.xy,
                xz: a.xz + b.xz,
                yz: a.yz + b.yz,
            },
        }
    }

    /// The same body in other axes, about the same point.
    #[inline(always)]
    pub fn turned(&self, rotation: &Matrix3<T>) -> Self {
        let s = &self.second;
        let (x, y, z) = (rotation.column(0), rotation.column(1), rotation.column(2));
        // R Σ Rᵀ = zz·1 + x uᵀ + u xᵀ + y vᵀ + v yᵀ: the isotropic part does not turn, which leaves five numbers.
        let half = lit::<T>(0.5);
        let u = x * ((s.xx - s.zz) * half) + y * s.xy + z * s.xz;
        let v = y * ((s.yy - s.zz) * half) + z * s.yz;
        let diagonal = |i: usize| {
            let sum = x[i] * u[i] + y[i] * v[i];
            s.zz + sum + sum
        };
        let across = |i: usize, j: usize| x[i] * u[j] + u[i] * x[j] + y[i] * v[j] + v[i] * y[j];
        let second = SecondMoments {
            xx: diagonal(0),
            yy: diagonal(1),
            zz: diagonal(2),
            xy: across(0, 1),
            xz: across(0, 2),
            yz: across(1, 2),
        };
        Self { mass: self.mass, first: rotation * self.first, second }
    }

    /// The same body about another point; `d`: from that point to the present one.
    #[inline(always)]
    pub fn shifted(&self, d: &Vector3<T>) -> Self {
        let s = &self.second;
        let md = d * self.mass;
        // Σ + d fᵀ + f dᵀ + m d dᵀ.
        let u = self.first + md * lit::<T>(0.5);
        let twice = |v: T| v + v;
        let second = SecondMoments {
            xx: s.xx + twice(d.x * u.x),
            yy: s.yy + twice(d.y * u.y),
            zz: s.zz + twice(d.z * u.z),
            xy: s.xy + d.x * u.y + u.x * d.y,
            xz: s.xz + d.x * u.z + u.x * d.z,
            yz: s.yz + d.y * u.z + u.y * d.z,
        };
        Self { mass: self.mass, first: self.first + md, second }
    }
}

impl<T: Real> SecondMoments<T> {
    /// I·v: angular momentum, or moment, of a rotation about the point.
    #[inline(always)]
    pub fn inertia_times(&self, v: &Vector3<T>) -> Vector3<T> {
        Vector3::new(
            (self.yy + self.zz) * v.x - self.xy * v.y - self.xz * v.z,
            (self.xx + self.zz) * v.y - self.xy * v.x - self.yz * v.z,
            (self.xx + self.yy) * v.z - self.xz * v.x - self.yz * v.y,
        )
    }

    /// ∫ r × (A r) dm: moment about the point that the acceleration field A r asks for.
    #[inline(always)]
    pub fn moment_of(&self, a: &Matrix3<T>) -> Vector3<T> {
        // The axial part of A Σ.
        let xy = a.m11 * self.xy + a.m12 * self.yy + a.m13 * self.yz;
        let yx = a.m21 * self.xx + a.m22 * self.xy + a.m23 * self.xz;
        let xz = a.m11 * self.xz + a.m12 * self.yz + a.m13 * self.zz;
        let zx = a.m31 * self.xx + a.m32 * self.xy + a.m33 * self.xz;
        let yz = a.m21 * self.xz + a.m22 * self.yz + a.m23 * self.zz;
        let zy = a.m31 * self.xy + a.m32 * self.yy + a.m33 * self.yz;
        Vector3::new(zy - yz, xz - zx, yx - xy)
    }
}
