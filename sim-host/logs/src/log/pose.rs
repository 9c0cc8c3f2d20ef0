//! Poses in the forms that instruments give them: KUKA's A B C, quaternions, rotation matrices, and
//! points of one to three reflectors on the tool.

use super::columns::{ABC, MATRIX, QUATERNION, REFLECTOR_COUNT, reflector};
use super::track::FileTrack;
use crate::channel::LogChannel;
use crate::clock::rigid;
use nalgebra::{DMatrix, DVector, Matrix3, Quaternion, UnitQuaternion, Vector3};
use trueweld_core::Pose;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector, skew};

/// Places of reflectors that are fitted, from so many rows.
const REFLECTOR_FIT_ROWS: usize = 2000;

/// How far from the tool centre point a reflector is expected, m, where nothing says.
const PLACE: f64 = 0.5;

/// Reflectors that lie nearer to a line than this, m, give no pose.
const REFLECTOR_LINE_DISTANCE_MIN: f64 = 5e-3;

/// A rotation from the numbers that stand for it.
type ToMatrix = fn(&[f64]) -> Matrix3<f64>;

/// Turns any form of a rotation in a track into rotation vectors.
pub(super) fn to_rotation_vectors(track: &mut FileTrack) {
    let forms: [(std::ops::Range<usize>, ToMatrix); 3] =
        [(ABC, of_abc), (QUATERNION, of_quaternion), (MATRIX, Matrix3::from_row_slice)];
    let Some((of, rotation)) = forms.into_iter().find(|(of, _)| track.has(of.clone())) else {
        return;
    };
    let rows = track.time().len();
    let columns: Vec<Vec<f64>> =
        of.map(|column| track.columns[column].take().unwrap_or_default()).collect();
    let mut vectors: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::with_capacity(rows));
    let mut values = vec![0.0; columns.len()];
    for k in 0..rows {
        values.iter_mut().zip(&columns).for_each(|(value, column)| *value = column[k]);
        let vector = if values.iter().all(|v| v.is_finite()) {
            rotation_vector(&rotation(&values))
        } else {
            Vector3::repeat(f64::NAN)
        };
        vectors.iter_mut().zip(vector.iter()).for_each(|(column, v)| column.push(*v));
    }
    put(track, LogChannel::Rotation, vectors);
}

/// R = Rz(A) Ry(B) Rx(C).
fn of_abc(v: &[f64]) -> Matrix3<f64> {
    let turn = |axis: Vector3<f64>, angle: f64| rotation_from_vector(&(axis * angle));
    turn(Vector3::z(), v[0]) * turn(Vector3::y(), v[1]) * turn(Vector3::x(), v[2])
}

/// Of a quaternion w, x, y, z.
fn of_quaternion(v: &[f64]) -> Matrix3<f64> {
    let q = Quaternion::new(v[0], v[1], v[2], v[3]);
    *UnitQuaternion::from_quaternion(q).to_rotation_matrix().matrix()
}

fn put(track: &mut FileTrack, channel: LogChannel, vectors: [Vec<f64>; 3]) {
    for (column, values) in channel.columns().zip(vectors) {
        track.columns[column] = Some(values);
    }
}

/// Which reflectors a track has.
pub(super) fn tracked(track: &FileTrack) -> Vec<usize> {
    (0..REFLECTOR_COUNT).filter(|r| track.has(reflector(*r))).collect()
}

/// Points of a track by which a clock can be fitted: the tool centre point's, or the mean of the
/// reflectors'.
pub(super) fn points(track: &FileTrack) -> Option<Vec<Vector3<f64>>> {
    let rows = 0..track.time().len();
    let position = LogChannel::Position.columns();
    if track.has(position.clone()) {
        return Some(rows.map(|k| track.vector(position.start, k)).collect());
    }
    let there = tracked(track);
    let mean = |k: usize| {
        there.iter().map(|r| track.vector(reflector(*r).start, k)).sum::<Vector3<f64>>()
            / there.len() as f64
    };
    (!there.is_empty()).then(|| rows.map(mean).collect())
}

/// Where reflectors sit in T, m.
pub(super) type ReflectorPlaces = [Option<Vector3<f64>>; REFLECTOR_COUNT];

/// Fits where the reflectors sit in T, together with the frame that they are seen in: p = R (x + X
/// b) + c. `poses`: of the tool by the encoders, at the track's rows; NaN where it is not known.
/// Gives the places with those that were known before.
pub(super) fn fit_places(
    track: &FileTrack,
    poses: &[Pose<f64>],
    known: &ReflectorPlaces,
) -> Option<ReflectorPlaces> {
    let there = tracked(track);
    let rows: Vec<usize> = (0..poses.len())
        .filter(|k| poses[*k].position.sum().is_finite())
        .filter(|k| there.iter().all(|r| track.vector(reflector(*r).start, *k).sum().is_finite()))
        .collect();
    let rows: Vec<usize> =
        rows.iter().copied().step_by((rows.len() / REFLECTOR_FIT_ROWS).max(1)).collect();
    if rows.len() < 4 {
        return None;
    }
    let seen = |r: usize, k: usize| track.vector(reflector(r).start, k);
    let mut places: Vec<Vector3<f64>> =
        there.iter().map(|r| known[*r].unwrap_or_else(Vector3::zeros)).collect();
    let path: Vec<Vector3<f64>> = rows.iter().map(|k| poses[*k].position).collect();
    let mean: Vec<Vector3<f64>> = rows
        .iter()
        .map(|k| there.iter().map(|r| seen(*r, *k)).sum::<Vector3<f64>>() / there.len() as f64)
        .collect();
    let (mut turn, mut shift) = rigid(&path, &mean)?;
    let unknowns = 6 + 3 * there.len();
    for _ in 0..40 {
        let mut normal = DMatrix::<f64>::zeros(unknowns, unknowns);
        let mut right = DVector::<f64>::zeros(unknowns);
        let (mut squares, mut count) = (0.0, 0.0);
        for k in &rows {
            let pose = &poses[*k];
            for (i, r) in there.iter().enumerate() {
                let point = turn * (pose.position + pose.rotation * places[i]);
                let left = seen(*r, *k) - point - shift;
                squares += left.norm_squared();
                count += 3.0;
                let mut design = DMatrix::<f64>::zeros(3, unknowns);
                design.view_mut((0, 0), (3, 3)).copy_from(&Matrix3::identity());
                design.view_mut((0, 3), (3, 3)).copy_from(&-skew(&point));
                design.view_mut((0, 6 + 3 * i), (3, 3)).copy_from(&(turn * pose.rotation));
                normal += design.transpose() * &design;
                right += design.transpose() * left;
            }
        }
        // What the motion does not tell stays near the tool centre point.
        let variance = (squares / count).max(1e-12);
        for (i, r) in there.iter().enumerate() {
            let deviation: f64 = if known[*r].is_some() { 1e-9 } else { PLACE };
            let weight = variance / deviation.powi(2);
            for c in 0..3 {
                let at = 6 + 3 * i + c;
                normal[(at, at)] += weight;
                if known[*r].is_none() {
                    right[at] -= weight * places[i][c];
                }
            }
        }
        let change = normal.cholesky()?.solve(&right);
        let of = |at: usize| Vector3::new(change[at], change[at + 1], change[at + 2]);
        let small = rotation_from_vector(&of(3));
        // The turn is about the frame's origin, which the shift does not turn with.
        shift += of(0);
        turn = small * turn;
        for (i, place) in places.iter_mut().enumerate() {
            *place += of(6 + 3 * i);
        }
        if !change.iter().all(|c| c.is_finite()) {
            return None;
        }
        if change.norm() < 1e-9 {
            break;
        }
    }
    let mut all = *known;
    for (r, place) in there.iter().zip(places) {
        all[*r] = Some(place);
    }
    Some(all)
}

/// True where three places span a triangle that a pose can be told from.
pub(super) fn span_a_plane(places: &ReflectorPlaces) -> bool {
    let [Some(a), Some(b), Some(c)] = places else {
        return false;
    };
    let sides = [b - a, c - a, c - b];
    let longest = sides.iter().map(Vector3::norm).fold(0.0, f64::max);
    (b - a).cross(&(c - a)).norm() > REFLECTOR_LINE_DISTANCE_MIN * longest
}

/// Turns the points of reflectors whose places are known into what the tracker saw of the tool:
/// with three its pose, and with fewer one point, whose place in T is given.
pub(super) fn to_tool(track: &mut FileTrack, places: &ReflectorPlaces) -> Option<Vector3<f64>> {
    let there = tracked(track);
    let rows = track.time().len();
    let known: Vec<Vector3<f64>> = there.iter().filter_map(|r| places[*r]).collect();
    let mut position: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::with_capacity(rows));
    let mut rotation: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::new());
    let target = (there.len() < REFLECTOR_COUNT)
        .then(|| known.iter().sum::<Vector3<f64>>() / known.len().max(1) as f64);
    let push = |columns: &mut [Vec<f64>; 3], v: Vector3<f64>| {
        columns.iter_mut().zip(v.iter()).for_each(|(column, v)| column.push(*v));
    };
    for k in 0..rows {
        let seen: Vec<Vector3<f64>> =
            there.iter().map(|r| track.vector(reflector(*r).start, k)).collect();
        let whole = seen.iter().all(|p| p.sum().is_finite());
        if target.is_some() {
            push(&mut position, seen.iter().sum::<Vector3<f64>>() / seen.len().max(1) as f64);
            continue;
        }
        let pose = if whole { rigid(&known, &seen) } else { None };
        push(&mut position, pose.map_or(Vector3::repeat(f64::NAN), |(_, shift)| shift));
        let turned = pose.map(|(turn, _)| rotation_vector(&turn));
        push(&mut rotation, turned.unwrap_or(Vector3::repeat(f64::NAN)));
    }
    (0..REFLECTOR_COUNT).flat_map(reflector).for_each(|column| track.columns[column] = None);
    put(track, LogChannel::Position, position);
    if target.is_none() {
        put(track, LogChannel::Rotation, rotation);
    }
    target
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::columns::MAPPABLE_COLUMNS;

    fn track(columns: &[(usize, Vec<f64>)]) -> FileTrack {
        let mut all = vec![None; MAPPABLE_COLUMNS];
        for (column, values) in columns {
            all[*column] = Some(values.clone());
        }
        all[0] = Some((0..columns[0].1.len()).map(|k| k as f64).collect());
        FileTrack { clock: None, columns: all, rounding: vec![0.0; MAPPABLE_COLUMNS] }
    }

    fn vectors(track: &FileTrack, channel: LogChannel) -> Vec<Vector3<f64>> {
        (0..track.time().len()).map(|k| track.vector(channel.columns().start, k)).collect()
    }

    #[test]
    fn every_form_of_a_rotation_is_the_same_rotation() {
        // KUKA: A about z, B about the new y, C about the new x.
        let (a, b, c) = (0.7, -0.4, 2.1);
        let (sa, ca, sb, cb, sc, cc) =
            (f64::sin(a), f64::cos(a), f64::sin(b), f64::cos(b), f64::sin(c), f64::cos(c));
        let matrix = [
            ca * cb,
            ca * sb * sc - sa * cc,
            ca * sb * cc + sa * sc,
            sa * cb,
            sa * sb * sc + ca * cc,
            sa * sb * cc - ca * sc,
            -sb,
            cb * sc,
            cb * cc,
        ];
        let expected = rotation_vector(&Matrix3::from_row_slice(&matrix));
        let quaternion = UnitQuaternion::from_matrix(&Matrix3::from_row_slice(&matrix));
        let q = quaternion.quaternion();
        let forms: [(usize, Vec<f64>); 3] = [
            (ABC.start, vec![a, b, c]),
            (QUATERNION.start, vec![-q.w, -q.i, -q.j, -q.k]),
            (MATRIX.start, matrix.to_vec()),
        ];
        for (first, values) in forms {
            let columns: Vec<(usize, Vec<f64>)> =
                values.iter().enumerate().map(|(i, v)| (first + i, vec![*v])).collect();
            let mut track = track(&columns);
            to_rotation_vectors(&mut track);
            let found = vectors(&track, LogChannel::Rotation)[0];
            assert!((found - expected).norm() < 1e-9, "{found} {expected}");
        }
    }

    #[test]
    fn three_reflectors_give_the_pose_and_their_places_are_found() {
        let places = [
            Vector3::new(0.12, 0.02, -0.05),
            Vector3::new(-0.08, 0.10, -0.02),
            Vector3::new(0.0, -0.11, 0.06),
        ];
        let turn = rotation_from_vector(&Vector3::new(0.2, -0.1, 2.3));
        let shift = Vector3::new(4.0, -1.0, 0.3);
        let poses: Vec<Pose<f64>> = (0..60)
            .map(|k| {
                let t = f64::from(k);
                let vector = Vector3::new(
                    0.5 * (0.3 * t).sin(),
                    0.4 * (0.7 * t).cos(),
                    0.6 * (0.2 * t).sin(),
                );
                Pose {
                    position: Vector3::new(1.5 + 0.4 * (0.5 * t).cos(), 0.3 * (0.4 * t).sin(), 1.0),
                    rotation: rotation_from_vector(&vector),
                }
            })
            .collect();
        let mut columns = Vec::new();
        for (r, place) in places.iter().enumerate() {
            let seen: Vec<Vector3<f64>> = poses
                .iter()
                .map(|pose| turn * (pose.position + pose.rotation * place) + shift)
                .collect();
            for c in 0..3 {
                columns.push((reflector(r).start + c, seen.iter().map(|p| p[c]).collect()));
            }
        }
        let mut track = track(&columns);
        let found = fit_places(&track, &poses, &[None; 3]).expect("places");
        for (found, place) in found.iter().zip(&places) {
            assert!((found.expect("a place") - place).norm() < 1e-6, "{found:?}");
        }
        assert!(span_a_plane(&found));
        assert_eq!(to_tool(&mut track, &found), None);
        let position = vectors(&track, LogChannel::Position);
        let rotation = vectors(&track, LogChannel::Rotation);
        for (k, pose) in poses.iter().enumerate() {
            assert!((position[k] - (turn * pose.position + shift)).norm() < 1e-6);
            let turned = (turn * pose.rotation).tr_mul(&rotation_from_vector(&rotation[k]));
            assert!(rotation_vector(&turned).norm() < 1e-6);
        }
    }
}
