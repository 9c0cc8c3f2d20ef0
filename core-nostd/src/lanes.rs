//! One number, or one vector, for every link at once.
//!
//! What the links ask of dynamics is the same for all six, apart from sums along the chain. Written
//! over all links at once, every operation is six independent ones that the compiler puts into
//! vector registers, whatever their width. It finds them from what a function stores: the stages of
//! the dynamics are therefore functions of their own and not inlined, which is measured to be a
//! fifth faster than one large function (`benches/rigid_body.rs`).

use crate::scalar::{JOINTS, Real};
use core::ops::{Add, Mul, Neg, Sub};
use nalgebra::Vector3;

/// A number for every link, A1's first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lanes<T: Real>(pub [T; JOINTS]);

/// A vector for every link, by components.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lanes3<T: Real> {
    pub x: Lanes<T>,
    pub y: Lanes<T>,
    pub z: Lanes<T>,
}

impl<T: Real> Lanes<T> {
    /// The same for every link.
    #[inline(always)]
    pub(crate) fn splat(v: T) -> Self {
        Self([v; JOINTS])
    }

    #[inline(always)]
    fn with(mut self, other: &Self, f: impl Fn(T, T) -> T) -> Self {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a = f(*a, *b);
        }
        self
    }

    /// Sum over this link and all inward of it.
    #[inline(always)]
    pub(crate) fn sum_from_base(mut self) -> Self {
        for i in 1..JOINTS {
            self.0[i] += self.0[i - 1];
        }
        self
    }

    /// Sum over this link and all outward of it.
    #[inline(always)]
    pub(crate) fn sum_from_tool(mut self) -> Self {
        for i in (1..JOINTS).rev() {
            self.0[i - 1] += self.0[i];
        }
        self
    }

    /// Every link's value moved to the link outward of it; `first` to link 1.
    #[inline(always)]
    pub(crate) fn moved_outward(&self, first: T) -> Self {
        let mut moved = [first; JOINTS];
        moved[1..].copy_from_slice(&self.0[..JOINTS - 1]);
        Self(moved)
    }

    /// Every link's value moved to the link inward of it; `last` to the last link.
    #[inline(always)]
    pub(crate) fn moved_inward(&self, last: T) -> Self {
        let mut moved = [last; JOINTS];
        moved[..JOINTS - 1].copy_from_slice(&self.0[1..]);
        Self(moved)
    }
}

macro_rules! by_lane {
    ($trait:ident, $method:ident) => {
        impl<T: Real> $trait for Lanes<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.with(&other, |a, b| a.$method(b))
            }
        }
    };
}
by_lane!(Add, add);
by_lane!(Sub, sub);
by_lane!(Mul, mul);

impl<T: Real> Neg for Lanes<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|v| -v))
    }
}

impl<T: Real> Lanes3<T> {
    /// From one vector a link.
    #[inline(always)]
    pub(crate) fn from_vectors(vectors: &[Vector3<T>; JOINTS]) -> Self {
        let mut all = Self {
            x: Lanes::splat(T::zero()),
            y: Lanes::splat(T::zero()),
            z: Lanes::splat(T::zero()),
        };
        for (i, v) in vectors.iter().enumerate() {
            all.x.0[i] = v.x;
            all.y.0[i] = v.y;
            all.z.0[i] = v.z;
        }
        all
    }

    /// `v` for the last link, zero for the others.
    #[inline(always)]
    pub(crate) fn last(v: &Vector3<T>) -> Self {
        let mut vectors = [Vector3::zeros(); JOINTS];
        vectors[JOINTS - 1] = *v;
        Self::from_vectors(&vectors)
    }

    /// The vector of link `i`.
    #[inline(always)]
    pub(crate) fn vector(&self, i: usize) -> Vector3<T> {
        Vector3::new(self.x.0[i], self.y.0[i], self.z.0[i])
    }

    /// Link `i`'s vector, for every link.
    #[inline(always)]
    pub(crate) fn only(&self, i: usize) -> Self {
        self.map(|l| Lanes::splat(l.0[i]))
    }

    #[inline(always)]
    fn map(&self, f: impl Fn(&Lanes<T>) -> Lanes<T>) -> Self {
        Self { x: f(&self.x), y: f(&self.y), z: f(&self.z) }
    }

    /// `self × other`, link by link.
    #[inline(always)]
    pub(crate) fn cross(&self, o: &Self) -> Self {
        Self {
            x: self.y * o.z - self.z * o.y,
            y: self.z * o.x - self.x * o.z,
            z: self.x * o.y - self.y * o.x,
        }
    }

    /// `self · other`, link by link.
    #[inline(always)]
    pub(crate) fn dot(&self, o: &Self) -> Lanes<T> {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// As [`Lanes::sum_from_base`].
    #[inline(always)]
    pub(crate) fn sum_from_base(&self) -> Self {
        self.map(|l| l.sum_from_base())
    }

    /// As [`Lanes::sum_from_tool`].
    #[inline(always)]
    pub(crate) fn sum_from_tool(&self) -> Self {
        self.map(|l| l.sum_from_tool())
    }

    /// As [`Lanes::moved_outward`].
    #[inline(always)]
    pub(crate) fn moved_outward(&self, first: &Vector3<T>) -> Self {
        Self {
            x: self.x.moved_outward(first.x),
            y: self.y.moved_outward(first.y),
            z: self.z.moved_outward(first.z),
        }
    }

    /// As [`Lanes::moved_inward`].
    #[inline(always)]
    pub(crate) fn moved_inward(&self, last: &Vector3<T>) -> Self {
        Self {
            x: self.x.moved_inward(last.x),
            y: self.y.moved_inward(last.y),
            z: self.z.moved_inward(last.z),
        }
    }
}

impl<T: Real> Add for Lanes3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl<T: Real> Sub for Lanes3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl<T: Real> Mul<Lanes<T>> for Lanes3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, k: Lanes<T>) -> Self {
        Self { x: self.x * k, y: self.y * k, z: self.z * k }
    }
}
