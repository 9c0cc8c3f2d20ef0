//! The seam: its weld frame W along the way, as it was taught and as it really lies, and where a
//! tool is in that frame.
//!
//! W(s) has its origin on the surface `s` m along the seam, x along it, z into the material, y = z ×
//! x. A straight seam has one W but for the origin; along a curved one W turns with it, and what is
//! stated in axes of W is in those of the place. The real seam keeps the way of the taught one: `s`
//! names the same place on both.

use crate::input::{Wave, Weld};
use crate::path::Path;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;
use trueweld_core::spatial::rotation_from_vector;
use trueweld_core::{Pose, Twist};

/// A weld's line and its frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Seam {
    /// The weld frame W in B at the start: x along the seam, z into the material.
    pub b_from_w: Pose<f64>,
    /// Length, m.
    pub length: f64,
    /// The tool's lead and tilt: from its axes as they lean to those of one that stands square.
    /// `None` where it does.
    lean: Option<Matrix3<f64>>,
    /// The way of a curved seam.
    path: Option<Arc<Path>>,
}

/// A place seen from a seam.
#[derive(Debug, Clone, Copy)]
pub struct SeamPosition {
    /// Path position, across the seam, and depth, m.
    pub position: Vector3<f64>,
    /// Axes of W in B there.
    pub axes: Matrix3<f64>,
}

impl From<Pose<f64>> for Seam {
    /// A straight seam without an end from a frame W.
    fn from(b_from_w: Pose<f64>) -> Self {
        Self { b_from_w, length: f64::INFINITY, lean: None, path: None }
    }
}

impl Seam {
    /// The seam of a weld as it was taught.
    pub fn of(weld: &Weld) -> Self {
        let along = weld.end - weld.start;
        let z = weld.tool_axis;
        // Square to the tool axis, should the path not be exactly.
        let x = (along - z * z.dot(&along)).normalize();
        let b_from_w =
            Pose { rotation: Matrix3::from_columns(&[x, z.cross(&x), z]), position: weld.start };
        let straight = Self { b_from_w, length: along.norm(), lean: lean(weld.lean), path: None };
        straight.along(weld.path.clone())
    }

    /// The seam of a weld as it really lies.
    pub fn real(weld: &Weld) -> Self {
        let taught = Self::of(weld);
        let moved =
            if weld.real.by == Twist::zero() { taught } else { taught.displaced(&weld.real.by) };
        match weld.real.wave {
            Some(wave) => moved.waved(&wave),
            None => moved,
        }
    }

    /// This seam along a path.
    fn along(self, path: Option<Arc<Path>>) -> Self {
        let Some(path) = path else { return self };
        let (position, rotation) = path.at(0.0);
        let b_from_w = Pose { position, rotation };
        Self { b_from_w, length: path.length(), path: Some(path), ..self }
    }

    /// The seam as a whole moved and turned about its start, axes of W there: m and rad.
    pub fn displaced(&self, by: &Twist<f64>) -> Self {
        let before = self.b_from_w;
        let b_from_w = before.displaced(&by.rotated(&before.rotation));
        let turn = b_from_w.rotation * before.rotation.transpose();
        let moved = |p: &Vector3<f64>| b_from_w.position + turn * (p - before.position);
        let path = self.path.as_ref().map(|path| Arc::new(path.moved(moved, &turn)));
        Self { b_from_w, path, ..self.clone() }
    }

    /// The seam with a wave across it.
    pub fn waved(&self, wave: &Wave) -> Self {
        let (start, axes) = (&self.b_from_w.position, &self.b_from_w.rotation);
        let straight = || Arc::new(Path::straight(start, axes, self.length));
        let path = self.path.clone().unwrap_or_else(straight);
        let waved = path.displaced(|s| Vector3::y() * wave.at(s));
        self.clone().along(Some(Arc::new(waved)))
    }

    /// True where W is the same along the whole seam.
    pub fn is_straight(&self) -> bool {
        self.path.is_none()
    }

    /// W in B at a path position, m.
    pub fn frame(&self, path: f64) -> Pose<f64> {
        match &self.path {
            None => Pose {
                position: self.b_from_w.transform_point(&Vector3::new(path, 0.0, 0.0)),
                ..self.b_from_w
            },
            Some(way) => {
                let (position, rotation) = way.at(path);
                Pose { position, rotation }
            }
        }
    }

    /// Axes of W in B at a path position, m.
    pub fn axes(&self, path: f64) -> Matrix3<f64> {
        match &self.path {
            None => self.b_from_w.rotation,
            Some(way) => way.at(path).1,
        }
    }

    /// Nominal tool pose at a path position: on the surface, z of T along z of W, y of T along the
    /// seam, turned by lead and tilt.
    pub fn nominal(&self, path: f64) -> Pose<f64> {
        let Pose { position, rotation } = self.frame(path);
        let w = self.lean.map_or(rotation, |lean| rotation * lean);
        let (x, z) = (w.column(0).into_owned(), w.column(2).into_owned());
        Pose { rotation: Matrix3::from_columns(&[x.cross(&z), x, z]), position }
    }

    /// Where a point of B is along the seam, across it and below the surface, with the axes of W
    /// there.
    #[inline]
    pub fn place(&self, point: &Vector3<f64>) -> SeamPosition {
        match &self.path {
            None => {
                let axes = self.b_from_w.rotation;
                let t_w = axes.transpose();
                SeamPosition { position: t_w * (point - self.b_from_w.position), axes }
            }
            Some(way) => {
                let path = way.nearest(point);
                let (origin, axes) = way.at(path);
                let mut position = axes.tr_mul(&(point - origin));
                position.x = path;
                SeamPosition { position, axes }
            }
        }
    }

    /// How far across the seam a point of B lies, m.
    pub fn across(&self, point: &Vector3<f64>) -> f64 {
        match &self.path {
            None => self.b_from_w.inverse().transform_point(point).y,
            Some(_) => self.place(point).position.y,
        }
    }

    /// How far the seam lies across W at `path` where W has gone on straight by `ahead`, m: its
    /// curvature across. 0 of a straight seam.
    pub fn bend(&self, path: f64, ahead: f64) -> f64 {
        if self.is_straight() {
            return 0.0;
        }
        let here = self.frame(path);
        (self.frame(path + ahead).position - here.position).dot(&here.rotation.column(1))
    }
}

/// From axes of a tool that leans to those of one that stands square to the surface, seen in W: by
/// lead about y of W, by tilt about x.
fn lean([lead, tilt]: [f64; 2]) -> Option<Matrix3<f64>> {
    let leans = lead != 0.0 || tilt != 0.0;
    leans.then(|| {
        rotation_from_vector(&(Vector3::y() * lead)) * rotation_from_vector(&(Vector3::x() * tilt))
    })
}
