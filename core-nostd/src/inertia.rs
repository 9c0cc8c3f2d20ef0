//! Inertia of rigid bodies by their moments of mass: m, ∫ r dm and Σ = ∫ r rᵀ dm about one point.
//!
//! The second moments Σ take the place of the rotational inertia I = tr(Σ)·1 − Σ because what
//! dynamics asks of a body is cheaper in them: turning into other axes, shifting to another point,
//! and the moment of an acceleration field. Source: Wensing, Kim, Slotine, "Linear matrix
//! inequalities for physically consistent inertial parameter identification", RA-L 3(1), 2018
//! (pseudo-inertia).

use crate::lanes::{Lanes, Lanes3};
use crate::scalar::{JOINTS, Real, lit};
use nalgebra::{Matrix3, Vector3};

/// One body about the origin of a frame, in its axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body<T: Real> {
    /// Mass, kg.
    pub mass: T,
    /// First moment m·c, kg·m.
    pub first: Vector3<T>,
    /// Second moments, kg·m².
    pub second: Matrix3<T>,
}

impl<T: Real> Body<T> {
    /// From mass, centre of mass and the inertia about it.
    pub(crate) fn new(mass: T, center_of_mass: &Vector3<T>, inertia: &Matrix3<T>) -> Self {
        let first = center_of_mass * mass;
        let second = Matrix3::from_diagonal_element(inertia.trace() * lit(0.5))
            - (inertia + inertia.transpose()) * lit::<T>(0.5)
            + first * center_of_mass.transpose();
        Self { mass, first, second }
    }

    /// Two bodies about the same point, taken as one.
    pub(crate) fn merged(&self, other: &Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first: self.first + other.first,
            second: self.second + other.second,
        }
    }

    /// Rotational inertia about a unit vector through the point, kg·m².
    pub(crate) fn about(&self, axis: &Vector3<T>) -> T {
        self.second.trace() - axis.dot(&(self.second * axis))
    }
}

/// All links at once, each about its own point, all in axes of the same kind (each its own, or all
/// those of B).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bodies<T: Real> {
    /// Mass, kg.
    pub mass: Lanes<T>,
    /// First moments, kg·m.
    pub first: Lanes3<T>,
    /// Second moments, kg·m².
    pub second: Symmetric<T>,
}

/// A symmetric 3 × 3 matrix for every link, each entry once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Symmetric<T: Real> {
    xx: Lanes<T>,
    yy: Lanes<T>,
    zz: Lanes<T>,
    xy: Lanes<T>,
    xz: Lanes<T>,
    yz: Lanes<T>,
}

/// A 3 × 3 matrix for every link, by columns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Matrices<T: Real> {
    pub x: Lanes3<T>,
    pub y: Lanes3<T>,
    pub z: Lanes3<T>,
}

impl<T: Real> Matrices<T> {
    /// From one matrix a link.
    #[inline(always)]
    pub(crate) fn new(matrices: &[Matrix3<T>; JOINTS]) -> Self {
        Self { x: column(matrices, 0), y: column(matrices, 1), z: column(matrices, 2) }
    }

    /// Matrix times vector, link by link.
    #[inline(always)]
    pub(crate) fn times(&self, v: &Lanes3<T>) -> Lanes3<T> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

/// Column `k` of every link's matrix.
#[inline(always)]
fn column<T: Real>(matrices: &[Matrix3<T>; JOINTS], k: usize) -> Lanes3<T> {
    let mut lanes = Lanes3::from_vectors(&[Vector3::zeros(); JOINTS]);
    for (i, m) in matrices.iter().enumerate() {
        lanes.x.0[i] = m[(0, k)];
        lanes.y.0[i] = m[(1, k)];
        lanes.z.0[i] = m[(2, k)];
    }
    lanes
}

impl<T: Real> Bodies<T> {
    /// From one body a link.
    pub(crate) fn new(links: &[Body<T>; JOINTS]) -> Self {
        let second = |i: usize, j: usize| Lanes(links.each_ref().map(|l| l.second[(i, j)]));
        Self {
            mass: Lanes(links.each_ref().map(|l| l.mass)),
            first: Lanes3::from_vectors(&links.each_ref().map(|l| l.first)),
            second: Symmetric {
                xx: second(0, 0),
                yy: second(1, 1),
                zz: second(2, 2),
                xy: second(0, 1),
                xz: second(0, 2),
                yz: second(1, 2),
            },
        }
    }

    /// The same bodies in other axes, about the same points.
    #[inline(always)]
    pub(crate) fn turned(&self, rotation: &Matrices<T>) -> Self {
        let s = &self.second;
        let Matrices { x, y, z } = *rotation;
        // R Σ Rᵀ = zz·1 + x uᵀ + u xᵀ + y vᵀ + v yᵀ: the isotropic part does not turn, which leaves
        // five numbers.
        let half = Lanes::splat(lit(0.5));
        let u = x * ((s.xx - s.zz) * half) + y * s.xy + z * s.xz;
        let v = y * ((s.yy - s.zz) * half) + z * s.yz;
        let twice = |l: Lanes<T>| l + l;
        let second = Symmetric {
            xx: s.zz + twice(x.x * u.x + y.x * v.x),
            yy: s.zz + twice(x.y * u.y + y.y * v.y),
            zz: s.zz + twice(x.z * u.z + y.z * v.z),
            xy: x.x * u.y + u.x * x.y + y.x * v.y + v.x * y.y,
            xz: x.x * u.z + u.x * x.z + y.x * v.z + v.x * y.z,
            yz: x.y * u.z + u.y * x.z + y.y * v.z + v.y * y.z,
        };
        Self { mass: self.mass, first: rotation.times(&self.first), second }
    }

    /// The same bodies about other points; `d`: from those points to the present ones.
    #[inline(always)]
    pub(crate) fn shifted(&self, d: &Lanes3<T>) -> Self {
        let s = &self.second;
        // Σ + d fᵀ + f dᵀ + m d dᵀ.
        let md = *d * self.mass;
        let u = self.first + md * Lanes::splat(lit(0.5));
        let twice = |l: Lanes<T>| l + l;
        let second = Symmetric {
            xx: s.xx + twice(d.x * u.x),
            yy: s.yy + twice(d.y * u.y),
            zz: s.zz + twice(d.z * u.z),
            xy: s.xy + d.x * u.y + u.x * d.y,
            xz: s.xz + d.x * u.z + u.x * d.z,
            yz: s.yz + d.y * u.z + u.y * d.z,
        };
        Self { mass: self.mass, first: self.first + md, second }
    }

    /// Each link with all links outward of it as one body; all about the same point.
    #[inline(always)]
    pub(crate) fn sum_from_tool(&self) -> Self {
        let s = &self.second;
        Self {
            mass: self.mass.sum_from_tool(),
            first: self.first.sum_from_tool(),
            second: Symmetric {
                xx: s.xx.sum_from_tool(),
                yy: s.yy.sum_from_tool(),
                zz: s.zz.sum_from_tool(),
                xy: s.xy.sum_from_tool(),
                xz: s.xz.sum_from_tool(),
                yz: s.yz.sum_from_tool(),
            },
        }
    }
}

impl<T: Real> Symmetric<T> {
    /// I·v with I = tr(Σ)·1 − Σ: moment of a unit rotational acceleration.
    #[inline(always)]
    pub(crate) fn inertia_times(&self, v: &Lanes3<T>) -> Lanes3<T> {
        Lanes3 {
            x: (self.yy + self.zz) * v.x - self.xy * v.y - self.xz * v.z,
            y: (self.xx + self.zz) * v.y - self.xy * v.x - self.yz * v.z,
            z: (self.xx + self.yy) * v.z - self.xz * v.x - self.yz * v.y,
        }
    }

    /// ∫ r × (A r) dm: moment that the acceleration field A r asks for. It is the axial part of A
    /// Σ.
    #[inline(always)]
    pub(crate) fn moment_of(&self, a: &Matrices<T>) -> Lanes3<T> {
        let Matrices { x, y, z } = a;
        let (xy, yx) = (
            x.x * self.xy + y.x * self.yy + z.x * self.yz,
            x.y * self.xx + y.y * self.xy + z.y * self.xz,
        );
        let (xz, zx) = (
            x.x * self.xz + y.x * self.yz + z.x * self.zz,
            x.z * self.xx + y.z * self.xy + z.z * self.xz,
        );
        let (yz, zy) = (
            x.y * self.xz + y.y * self.yz + z.y * self.zz,
            x.z * self.xy + y.z * self.yy + z.z * self.yz,
        );
        Lanes3 { x: zy - yz, y: xz - zx, z: yx - xy }
    }
}
