//! A path in space: a smooth curve on a surface, by arc length, with the surface's normal along it.
//!
//! It is made from points by a cubic spline, or by straight legs whose corners are rounded, and kept
//! as a table that is even in arc length: cubic Hermite in between, so that position, direction and
//! normal are continuous. What cannot be welded along is refused where it is made: doubled points,
//! kinks, normals that turn over, a path that comes back to itself.

use nalgebra::{DMatrix, Matrix3, SVector, Vector3};

/// Distance of two points below which they are one, m.
const SAME_POINT_DISTANCE: f64 = 1e-4;

/// Least sine between path and normal: below, there is no direction across the seam to speak of.
const NORMAL_SINE_MIN: f64 = 0.1;

/// Least cosine between the normals of neighbouring points.
const LEAST_TURN: f64 = 0.5;

/// Least radius of a bend, m: a tool's shoulder is as wide.
pub(crate) const LEAST_RADIUS: f64 = 0.02;

/// A path that comes nearer to itself than [`SELF_APPROACH_DISTANCE`], m, over a way of more than
/// [`SELF_APPROACH_WAY`], m, leaves open where on it a tool is.
const SELF_APPROACH_DISTANCE: f64 = 0.03;
const SELF_APPROACH_WAY: f64 = 0.1;

/// Way between two entries of the table, m, and the most of them.
const PATH_TABLE_STEP: f64 = 1e-3;
const PATH_TABLE_ENTRIES_MAX: usize = 4096;

/// Points of the table that are looked at for the nearest.
const COARSE: usize = 128;

/// A point of a path: where it is, and the surface's normal there, out of the material. Of any one
/// frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    /// Where, m.
    pub position: Vector3<f64>,
    /// Normal, of any length but 0.
    pub normal: Vector3<f64>,
}

/// How points are joined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Joined {
    /// By a cubic spline through all of them, without a jump of curvature.
    Spline,
    /// By straight legs; corners are arcs of this radius, m. `None`: there is no corner.
    Legs(Option<f64>),
}

/// What a path cannot be made of, as what was expected in its place. Points count from 0.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PathError {
    /// Fewer than two points.
    #[error("at least two points")]
    TooFew,
    /// A point stands where the one before it stands.
    #[error("a point that does not stand where the one before it does")]
    Doubled(usize),
    /// A normal without a direction.
    #[error("a vector that has a direction")]
    NoNormal(usize),
    /// A normal that points along the path.
    #[error("a direction that is not along the path")]
    AlongPath(usize),
    /// A normal that turns over from the one before it.
    #[error("a normal that does not turn over from the one of the point before")]
    TurnsOver(usize),
    /// A corner of legs, by this angle, rad, that is not rounded.
    #[error("a path without corners; it has one of {:.1}° here", angle.to_degrees())]
    Corner {
        /// Which point.
        point: usize,
        /// By how much it turns, rad.
        angle: f64,
    },
    /// Legs that are too short for the arc of a corner.
    #[error("legs that are long enough for the arc of the corner here")]
    ShortLegs(usize),
    /// A bend that no tool can follow.
    #[error(
        "a path that bends with a radius of {:.0} mm or more; it bends with {:.1} mm at {path:.3} m",
        LEAST_RADIUS * 1e3,
        radius * 1e3
    )]
    Bend {
        /// The point that is nearest.
        point: usize,
        /// Where, m.
        path: f64,
        /// How tightly, m.
        radius: f64,
    },
    /// A path that comes back to itself.
    #[error(
        "a path that does not come back to itself; at {path:.3} m it is within {:.0} mm of {other:.3} m",
        SELF_APPROACH_DISTANCE * 1e3
    )]
    Returns {
        /// The point that is nearest.
        point: usize,
        /// Where, m.
        path: f64,
        /// To where, m.
        other: f64,
    },
}

/// A path, from 0 to its length. Beyond its ends it goes on straight.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Between two entries, m.
    step: f64,
    entries: Vec<PathEntry>,
}

/// Position, its derivative by the path, and the normal, of length 1.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PathEntry {
    position: Vector3<f64>,
    slope: Vector3<f64>,
    normal: Vector3<f64>,
}

impl Path {
    /// The path through points.
    ///
    /// # Errors
    /// [`PathError`].
    pub fn new(points: &[PathPoint], joined: Joined) -> Result<Self, PathError> {
        let points = checked(points)?;
        let track = match joined {
            Joined::Spline => PathTrack::spline(&points),
            Joined::Legs(radius) => PathTrack::legs(&points, radius)?,
        };
        let path = track.table();
        path.check(&points)?;
        Ok(path)
    }

    /// Its length, m.
    pub fn length(&self) -> f64 {
        self.step * (self.entries.len() - 1) as f64
    }

    /// Where it is `path` m from its start, and its axes there: x along it, z into the surface, y =
    /// z × x.
    pub fn at(&self, path: f64) -> (Vector3<f64>, Matrix3<f64>) {
        let PathEntry { position, slope, normal } = self.entry(path);
        let x = slope.normalize();
        let z = -(normal - x * x.dot(&normal)).normalize();
        (position, Matrix3::from_columns(&[x, z.cross(&x), z]))
    }

    /// How far along the path the point is that is nearest to `point`, m; below 0 or beyond its
    /// length where the point is before its start or behind its end.
    pub fn nearest(&self, point: &Vector3<f64>) -> f64 {
        let stride = (self.entries.len() / COARSE).max(1);
        let far = |k: usize| (self.entries[k].position - point).norm_squared();
        let last = self.entries.len() - 1;
        let coarse = (0..last).step_by(stride).chain([last]);
        let (nearest, _) = coarse
            .map(|k| (k, far(k)))
            .fold((0, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best });
        let mut path = nearest as f64 * self.step;
        for _ in 0..20 {
            let PathEntry { position, slope, .. } = self.entry(path);
            let by = (point - position).dot(&slope) / slope.norm_squared();
            path += by;
            if by.is_nan() || by.abs() <= 1e-13 {
                break;
            }
        }
        path
    }

    /// The path displaced point by point: `by` gives, from the path position, m, a way in its axes
    /// there. Its position stays what it was on this one.
    pub fn displaced(&self, by: impl Fn(f64) -> Vector3<f64>) -> Self {
        const H: f64 = 1e-5;
        let place = |path: f64| {
            let (position, axes) = self.at(path);
            position + axes * by(path)
        };
        let entries = self.entries.iter().enumerate().map(|(k, entry)| {
            let path = k as f64 * self.step;
            PathEntry {
                position: place(path),
                slope: (place(path + H) - place(path - H)) / (2.0 * H),
                normal: entry.normal,
            }
        });
        Self { step: self.step, entries: entries.collect() }
    }

    /// The first `length` m of the path, to a millimetre.
    #[must_use]
    pub fn first(&self, length: f64) -> Self {
        let count = ((length / self.step).round() as usize).clamp(1, self.entries.len() - 1);
        Self { step: self.step, entries: self.entries[..=count].to_vec() }
    }

    /// The path in another frame.
    pub fn moved(
        &self,
        move_point: impl Fn(&Vector3<f64>) -> Vector3<f64>,
        turn: &Matrix3<f64>,
    ) -> Self {
        let entries = self.entries.iter().map(|entry| PathEntry {
            position: move_point(&entry.position),
            slope: turn * entry.slope,
            normal: turn * entry.normal,
        });
        Self { step: self.step, entries: entries.collect() }
    }

    /// A straight path of a length, m, from `start` along x of `axes`, z into the surface.
    pub fn straight(start: &Vector3<f64>, axes: &Matrix3<f64>, length: f64) -> Self {
        let count = steps(length);
        let step = length / count as f64;
        let [x, z] = [0, 2].map(|k| axes.column(k).into_owned());
        let at =
            |k: usize| PathEntry { position: start + x * (step * k as f64), slope: x, normal: -z };
        Self { step, entries: (0..=count).map(at).collect() }
    }

    /// Places along the path where it is looked at, m: evenly, ends included.
    fn places(&self, most: usize) -> Vec<f64> {
        let count = most.min(self.entries.len() - 1);
        (0..=count).map(|k| self.length() * k as f64 / count as f64).collect()
    }

    fn entry(&self, path: f64) -> PathEntry {
        let last = self.entries.len() - 1;
        let beyond = |end: &PathEntry, by: f64| PathEntry {
            position: end.position + end.slope * by,
            ..*end
        };
        // Not a number is before the start, and stays what it is.
        if path.is_nan() || path <= 0.0 {
            return beyond(&self.entries[0], path);
        }
        let length = self.length();
        if path >= length {
            return beyond(&self.entries[last], path - length);
        }
        let k = ((path / self.step) as usize).min(last - 1);
        let (a, b) = (&self.entries[k], &self.entries[k + 1]);
        let u = path / self.step - k as f64;
        let (u2, u3) = (u * u, u * u * u);
        let h = self.step;
        let way = b.position - a.position;
        PathEntry {
            position: a.position
                + way * (3.0 * u2 - 2.0 * u3)
                + a.slope * (h * (u3 - 2.0 * u2 + u))
                + b.slope * (h * (u3 - u2)),
            slope: way * (6.0 * (u - u2) / h)
                + a.slope * (3.0 * u2 - 4.0 * u + 1.0)
                + b.slope * (3.0 * u2 - 2.0 * u),
            normal: a.normal + (b.normal - a.normal) * u,
        }
    }

    /// Refuses bends that are too tight and a path that comes back to itself.
    fn check(&self, points: &[PathPoint]) -> Result<(), PathError> {
        let point = |path: f64| {
            let (here, _) = self.at(path);
            let far = |p: &PathPoint| (p.position - here).norm_squared();
            let nearest = points.iter().enumerate().min_by(|a, b| far(a.1).total_cmp(&far(b.1)));
            nearest.map_or(0, |(k, _)| k)
        };
        for (k, pair) in self.entries.windows(2).enumerate() {
            let path = (k as f64 + 0.5) * self.step;
            let turn = |a: &Vector3<f64>, b: &Vector3<f64>| a.angle(b);
            let angle =
                turn(&pair[0].slope, &pair[1].slope).max(turn(&pair[0].normal, &pair[1].normal));
            let radius = self.step / angle;
            if radius.is_nan() || radius < LEAST_RADIUS * (1.0 - 1e-3) {
                return Err(PathError::Bend { point: point(path), path, radius });
            }
            let [slope, normal] = [pair[0].slope, pair[0].normal];
            let sine = slope.cross(&normal).norm() / (slope.norm() * normal.norm());
            if sine.is_nan() || sine < NORMAL_SINE_MIN {
                return Err(PathError::AlongPath(point(path)));
            }
        }
        let places: Vec<(f64, Vector3<f64>)> =
            self.places(4 * COARSE).into_iter().map(|s| (s, self.at(s).0)).collect();
        for (k, (path, here)) in places.iter().enumerate() {
            let back = places[..k].iter().find(|(s, there)| {
                path - s > SELF_APPROACH_WAY && (here - there).norm() < SELF_APPROACH_DISTANCE
            });
            if let Some((other, _)) = back {
                return Err(PathError::Returns { point: point(*path), path: *path, other: *other });
            }
        }
        Ok(())
    }
}

fn steps(length: f64) -> usize {
    ((length / PATH_TABLE_STEP).ceil() as usize).clamp(16, PATH_TABLE_ENTRIES_MAX)
}

/// Points that a path can be made of, with normals of length 1.
fn checked(points: &[PathPoint]) -> Result<Vec<PathPoint>, PathError> {
    if points.len() < 2 {
        return Err(PathError::TooFew);
    }
    let mut checked: Vec<PathPoint> = Vec::with_capacity(points.len());
    for (k, point) in points.iter().enumerate() {
        let normal = point.normal.try_normalize(1e-9).filter(|n| n.norm().is_finite());
        let normal = normal.ok_or(PathError::NoNormal(k))?;
        if let Some(before) = checked.last() {
            let apart = (point.position - before.position).norm();
            if apart.is_nan() || apart <= SAME_POINT_DISTANCE {
                return Err(PathError::Doubled(k));
            }
            if before.normal.dot(&normal) < LEAST_TURN {
                return Err(PathError::TurnsOver(k));
            }
        }
        checked.push(PathPoint { normal, ..*point });
    }
    for (k, pair) in checked.windows(2).enumerate() {
        let along = (pair[1].position - pair[0].position).normalize();
        if let Some(end) =
            (0..2).find(|end| along.cross(&pair[*end].normal).norm() < NORMAL_SINE_MIN)
        {
            return Err(PathError::AlongPath(k + end));
        }
    }
    Ok(checked)
}

/// A path by some parameter.
enum PathTrack {
    /// Knots, and position (1 to 3) and normal (4 to 6) there with their second derivatives.
    Spline(Vec<(f64, [SVector<f64, 6>; 2])>),
    /// Legs and arcs one behind the other, by way; and the normals at these ways.
    Legs { pieces: Vec<(f64, PathPiece)>, normals: Vec<(f64, Vector3<f64>)> },
}

/// A straight leg from a point in a direction; or an arc about a centre, from one end of which
/// `across` points from the centre, and `along` along it.
enum PathPiece {
    Leg { from: Vector3<f64>, along: Vector3<f64> },
    Arc { center: Vector3<f64>, across: Vector3<f64>, along: Vector3<f64>, radius: f64 },
}

impl PathTrack {
    /// The not-a-knot cubic spline over the chords; a parabola through three points.
    fn spline(points: &[PathPoint]) -> Self {
        let n = points.len();
        let mut knots = vec![0.0; n];
        for k in 1..n {
            knots[k] = knots[k - 1] + (points[k].position - points[k - 1].position).norm();
        }
        let value = |p: &PathPoint| {
            SVector::<f64, 6>::from_iterator(p.position.iter().chain(p.normal.iter()).copied())
        };
        let values: Vec<_> = points.iter().map(value).collect();
        let h = |k: usize| knots[k + 1] - knots[k];
        let mut matrix = DMatrix::<f64>::zeros(n, n);
        let mut right = DMatrix::<f64>::zeros(n, 6);
        for k in 1..n - 1 {
            matrix[(k, k - 1)] = h(k - 1);
            matrix[(k, k)] = 2.0 * (h(k - 1) + h(k));
            matrix[(k, k + 1)] = h(k);
            let slopes =
                (values[k + 1] - values[k]) / h(k) - (values[k] - values[k - 1]) / h(k - 1);
            right.set_row(k, &(slopes * 6.0).transpose());
        }
        match n {
            2 => {
                matrix[(0, 0)] = 1.0;
                matrix[(1, 1)] = 1.0;
            }
            3 => {
                for (row, other) in [(0, 1), (2, 1)] {
                    matrix[(row, row)] = 1.0;
                    matrix[(row, other)] = -1.0;
                }
            }
            _ => {
                for (row, first) in [(0, 0), (n - 1, n - 3)] {
                    matrix[(row, first)] = h(first + 1);
                    matrix[(row, first + 1)] = -(h(first) + h(first + 1));
                    matrix[(row, first + 2)] = h(first);
                }
            }
        }
        // Regular for distinct points, which these are.
        let bend = matrix.lu().solve(&right).unwrap_or_else(|| DMatrix::zeros(n, 6));
        let bend = |k: usize| SVector::<f64, 6>::from_iterator(bend.row(k).iter().copied());
        Self::Spline((0..n).map(|k| (knots[k], [values[k], bend(k)])).collect())
    }

    fn legs(points: &[PathPoint], radius: Option<f64>) -> Result<Self, PathError> {
        let n = points.len();
        let along: Vec<Vector3<f64>> =
            points.windows(2).map(|p| (p[1].position - p[0].position).normalize()).collect();
        let length = |k: usize| (points[k + 1].position - points[k].position).norm();
        // Angle at every point, and how much of its legs its arc takes.
        let mut cut = vec![(0.0, 0.0); n];
        for k in 1..n - 1 {
            let angle = along[k - 1].angle(&along[k]);
            if angle > 1e-9 {
                let radius = radius.ok_or(PathError::Corner { point: k, angle })?;
                cut[k] = (angle, radius * (0.5 * angle).tan());
                if cut[k - 1].1 + cut[k].1 > length(k - 1) || cut[k].1 > length(k) {
                    return Err(PathError::ShortLegs(k));
                }
            }
        }
        if cut[n - 2].1 > length(n - 2) {
            return Err(PathError::ShortLegs(n - 2));
        }
        let (mut pieces, mut normals) = (Vec::new(), vec![(0.0, points[0].normal)]);
        let mut way = 0.0;
        for k in 0..n - 1 {
            let from = points[k].position + along[k] * cut[k].1;
            let leg = length(k) - cut[k].1 - cut[k + 1].1;
            if leg > 0.0 {
                pieces.push((way, PathPiece::Leg { from, along: along[k] }));
                way += leg;
            }
            let (angle, taken) = cut[k + 1];
            let mut middle = way;
            if angle > 0.0 {
                let radius = radius.unwrap_or(LEAST_RADIUS);
                let inward = (along[k + 1] - along[k] * angle.cos()).normalize();
                let start = points[k + 1].position - along[k] * taken;
                let arc = PathPiece::Arc {
                    center: start + inward * radius,
                    across: -inward,
                    along: along[k],
                    radius,
                };
                pieces.push((way, arc));
                middle += 0.5 * radius * angle;
                way += radius * angle;
            }
            normals.push((middle, points[k + 1].normal));
        }
        Ok(Self::Legs { pieces, normals })
    }

    fn end(&self) -> f64 {
        match self {
            Self::Spline(knots) => knots.last().map_or(0.0, |knot| knot.0),
            Self::Legs { normals, .. } => normals.last().map_or(0.0, |normal| normal.0),
        }
    }

    /// Position, its derivative by the parameter, and normal.
    fn at(&self, t: f64) -> PathEntry {
        match self {
            Self::Spline(knots) => {
                let k = knots.partition_point(|knot| knot.0 <= t).clamp(1, knots.len() - 1) - 1;
                let (from, [a, bend_a]) = &knots[k];
                let (to, [b, bend_b]) = &knots[k + 1];
                let h = to - from;
                let (p, q) = ((to - t) / h, (t - from) / h);
                let value = a * p
                    + b * q
                    + (bend_a * (p * p * p - p) + bend_b * (q * q * q - q)) * (h * h / 6.0);
                let slope = (b - a) / h
                    + (bend_b * (3.0 * q * q - 1.0) - bend_a * (3.0 * p * p - 1.0)) * (h / 6.0);
                PathEntry {
                    position: value.fixed_rows::<3>(0).into_owned(),
                    slope: slope.fixed_rows::<3>(0).into_owned(),
                    normal: value.fixed_rows::<3>(3).into_owned(),
                }
            }
            Self::Legs { pieces, normals } => {
                let k = pieces.partition_point(|piece| piece.0 <= t).max(1) - 1;
                let (from, piece) = &pieces[k];
                let by = t - from;
                let (position, slope) = match piece {
                    PathPiece::Leg { from, along } => (from + along * by, *along),
                    PathPiece::Arc { center, across, along, radius } => {
                        let (sin, cos) = (by / radius).sin_cos();
                        (
                            center + (across * cos + along * sin) * *radius,
                            along * cos - across * sin,
                        )
                    }
                };
                let k = normals.partition_point(|n| n.0 <= t).clamp(1, normals.len() - 1) - 1;
                let ((from, a), (to, b)) = (normals[k], normals[k + 1]);
                PathEntry { position, slope, normal: a + (b - a) * ((t - from) / (to - from)) }
            }
        }
    }

    /// The table that is even in arc length.
    fn table(&self) -> Path {
        /// Chords an entry by which the arc length is measured.
        const CHORDS: usize = 8;
        let end = self.end();
        let count = steps(end);
        let fine = count * CHORDS;
        let at = |k: usize| end * k as f64 / fine as f64;
        let mut ways = vec![0.0; fine + 1];
        let mut before = self.at(0.0).position;
        for k in 1..=fine {
            let here = self.at(at(k)).position;
            ways[k] = ways[k - 1] + (here - before).norm();
            before = here;
        }
        let step = ways[fine] / count as f64;
        let entry = |k: usize| {
            let way = step * k as f64;
            let next = ways.partition_point(|w| *w <= way).clamp(1, fine);
            let share = (way - ways[next - 1]) / (ways[next] - ways[next - 1]);
            let entry = self.at(end * ((next - 1) as f64 + share) / fine as f64);
            PathEntry { slope: entry.slope.normalize(), normal: entry.normal.normalize(), ..entry }
        };
        Path { step, entries: (0..=count).map(entry).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::{Joined, Path, PathError, PathPoint};
    use nalgebra::Vector3;

    const RADIUS: f64 = 2.0;

    /// Points of an arc about the y axis, normals away from it.
    fn arc(points: usize, angle: f64) -> Vec<PathPoint> {
        let at = |k: usize| {
            let (sin, cos) = (angle * k as f64 / (points - 1) as f64).sin_cos();
            let normal = Vector3::new(sin, 0.0, cos);
            PathPoint { position: normal * RADIUS, normal }
        };
        (0..points).map(at).collect()
    }

    fn at(x: f64, y: f64) -> PathPoint {
        PathPoint { position: Vector3::new(x, y, 0.0), normal: Vector3::z() }
    }

    /// Points δ = 0.05 rad apart: a cubic spline is off by some δ⁴/24 of the radius where it ends, its
    /// direction by some δ³/4.
    #[test]
    fn a_spline_through_points_of_an_arc_is_the_arc() {
        let path = Path::new(&arc(11, 0.5), Joined::Spline).unwrap();
        assert!((path.length() - 0.5 * RADIUS).abs() < 2e-6, "{}", path.length());
        for share in [0.0, 0.13, 0.5, 0.77, 1.0] {
            let (position, axes) = path.at(share * path.length());
            let (sin, cos) = (0.5 * share).sin_cos();
            assert!((position - Vector3::new(sin, 0.0, cos) * RADIUS).norm() < 3e-6);
            assert!((axes.column(0) - Vector3::new(cos, 0.0, -sin)).norm() < 4e-5);
            assert!((axes.column(2) + Vector3::new(sin, 0.0, cos)).norm() < 4e-5);
            assert!((axes.determinant() - 1.0).abs() < 1e-12);
        }
    }

    /// The foot of a perpendicular, within the rounding of metres.
    #[test]
    fn the_nearest_place_is_the_foot_of_the_perpendicular() {
        let path = Path::new(&arc(6, 0.5), Joined::Spline).unwrap();
        for (s, by) in [(0.002, [1e-3, -2e-3]), (0.4321, [5e-3, 3e-3]), (0.99, [-4e-3, 1e-2])] {
            let (position, axes) = path.at(s);
            let point = position + axes.column(1) * by[0] + axes.column(2) * by[1];
            assert!((path.nearest(&point) - s).abs() < 1e-9, "{s}");
        }
        let (end, axes) = path.at(path.length());
        let behind = end + axes.column(0) * 0.02;
        assert!((path.nearest(&behind) - path.length() - 0.02).abs() < 1e-12);
    }

    /// Way along two legs of 100 mm less what the arc of a right angle saves of its corner.
    #[test]
    fn a_corner_is_an_arc() {
        let corner = [at(0.0, 0.0), at(0.1, 0.0), at(0.1, 0.1)];
        let path = Path::new(&corner, Joined::Legs(Some(0.03))).unwrap();
        let expected = 0.2 - 0.06 + 0.03 * std::f64::consts::FRAC_PI_2;
        assert!((path.length() - expected).abs() < 1e-6, "{}", path.length());
        let (middle, _) = path.at(0.5 * path.length());
        let center = Vector3::new(0.07, 0.03, 0.0);
        assert!(((middle - center).norm() - 0.03).abs() < 1e-7);
    }

    #[test]
    fn what_cannot_be_welded_along_is_refused_at_its_point() {
        let spline = |points: &[PathPoint]| Path::new(points, Joined::Spline).unwrap_err();
        assert_eq!(spline(&[at(0.0, 0.0)]), PathError::TooFew);
        assert_eq!(spline(&[at(0.0, 0.0), at(0.1, 0.0), at(0.1, 0.0)]), PathError::Doubled(2));
        let normal = |points: [PathPoint; 3], normal| {
            let mut points = points;
            points[1].normal = normal;
            spline(&points)
        };
        let line = [at(0.0, 0.0), at(0.1, 0.0), at(0.2, 0.0)];
        assert_eq!(normal(line, Vector3::zeros()), PathError::NoNormal(1));
        assert_eq!(normal(line, Vector3::new(f64::NAN, 0.0, 1.0)), PathError::NoNormal(1));
        assert_eq!(normal(line, -Vector3::z()), PathError::TurnsOver(1));
        assert_eq!(normal(line, Vector3::new(1.0, 0.0, 0.05)), PathError::TurnsOver(1));
        let corner = [at(0.0, 0.0), at(0.1, 0.0), at(0.1, 0.1)];
        let kink = Path::new(&corner, Joined::Legs(None)).unwrap_err();
        assert!(matches!(kink, PathError::Corner { point: 1, .. }), "{kink}");
        let wide = Path::new(&corner, Joined::Legs(Some(0.2))).unwrap_err();
        assert_eq!(wide, PathError::ShortLegs(1));
        let back = spline(&[at(0.0, 0.0), at(0.1, 0.0), at(0.11, 0.0), at(0.02, 0.001)]);
        assert!(matches!(back, PathError::Bend { .. }), "{back}");
        let ring = spline(&arc(40, 2.0 * std::f64::consts::PI));
        assert!(matches!(ring, PathError::Returns { .. }), "{ring}");
    }
}
