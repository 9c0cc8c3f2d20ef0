//! The cell in space: plate, seam and limits, and for every run the arm as it stands and as its
//! encoders say, the way of its tool and the force on it.

use super::shown::{Beside, DrawnRun, micrometres};
use super::signals;
use super::writer::{RecordError, Store, Writer, refused};
use crate::MILLI;
use crate::WeldRun;
use crate::color::LIMIT;
use crate::text::weld::headline;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use re_chunk::TimeColumn;
use re_sdk_types::AsComponents;
use re_sdk_types::archetypes::{
    Arrows3D, Boxes3D, Capsules3D, LineStrips3D, Mesh3D, Points3D, TextDocument, Transform3D,
    ViewCoordinates,
};
use re_sdk_types::components::{Color, FillMode, MediaType};
use re_sdk_types::datatypes::Quaternion;
use std::io::Write;
use trueweld_core::{JOINTS, JointVector, Robot};
use trueweld_plant::simulate::RecordRow;

/// Poses of the arm a simulated second.
const POSES_PER_SECOND: f64 = 4.0;
/// Points of a drawn path.
const PATH_POINTS: usize = 200;
/// Radii of the drawn links from base to wrist, and of the tool, m.
const RADII: [f32; JOINTS] = [0.20, 0.15, 0.13, 0.11, 0.09, 0.07];
/// Half the width of the strip of surface that is drawn under a curved seam, m.
const PLATE: f64 = 0.15;
/// Drawn distance of a path's name from the path, m.
const NAME_DISTANCE: f64 = 0.22;
/// Drawn length of a force, m/N.
const FORCE_LENGTH: f64 = 0.5 / 18_000.0;

/// The nominal seam: places along it, and the axes of W in B there (along, lateral, into the
/// material). Its ends alone, where it is straight.
pub(super) struct DrawnSeam(Vec<(Vector3<f64>, Matrix3<f64>)>);

impl DrawnSeam {
    /// From the nominal poses of a run.
    pub(crate) fn of(rows: &[RecordRow]) -> Option<Self> {
        let (first, last) = (rows.first()?, rows.last()?);
        let places = if rows.iter().all(|row| row.axes == first.axes) { 1 } else { PATH_POINTS };
        let place = |k: usize| {
            let path = last.path * k as f64 / places as f64;
            let row = &rows[rows.partition_point(|row| row.path < path).min(rows.len() - 1)];
            (row.nominal.position, row.axes)
        };
        let ends = |k| if k == 0 { (first.nominal.position, first.axes) } else { place(k) };
        Some(Self((0..=places).map(ends).collect()))
    }

    /// As it was taught.
    pub(crate) fn taught(seam: &trueweld_plant::simulate::Seam) -> Self {
        let place = |k: usize| {
            let path = seam.length * k as f64 / PATH_POINTS as f64;
            (seam.nominal(path).position, seam.axes(path))
        };
        let ends = [place(0), place(PATH_POINTS)];
        let straight = ends[0].1 == ends[1].1;
        Self(if straight { ends.into() } else { (0..=PATH_POINTS).map(place).collect() })
    }

    /// Half way, m, and the axes of W there.
    pub(crate) fn middle(&self) -> (Vector3<f64>, Matrix3<f64>) {
        let n = self.0.len();
        let ((a, _), (b, axes)) = (self.0[(n - 1) / 2], self.0[n / 2]);
        ((a + b) * 0.5, axes)
    }

    /// Points beside it, m: across, and into the material.
    fn line(&self, across: f64, into: f64) -> Vec<[f32; 3]> {
        let beside = |(place, axes): &(Vector3<f64>, Matrix3<f64>)| {
            point(&(place + axes * Vector3::new(0.0, across, into)))
        };
        self.0.iter().map(beside).collect()
    }
}

/// The plate under a straight seam; under a curved one a strip of the surface.
fn plate(seam: &DrawnSeam) -> Box<dyn AsComponents> {
    let color = Color::from_rgb(198, 203, 210);
    let thickness = 0.02;
    let (middle, axes) = seam.middle();
    let [(start, _), (end, _)] = seam.0[..] else {
        let vertices = [-PLATE, PLATE].map(|across| seam.line(across, 0.003)).concat();
        let n = seam.0.len() as u32;
        let quad = |k: u32| [[k, k + 1, n + k], [k + 1, n + k + 1, n + k]];
        let normals = seam.0.iter().chain(&seam.0).map(|(_, axes)| point(&-axes.column(2)));
        return Box::new(
            Mesh3D::new(vertices)
                .with_vertex_normals(normals)
                .with_triangle_indices((0..n - 1).flat_map(quad))
                .with_albedo_factor(*color),
        );
    };
    let length = (end - start).norm();
    let center = middle + axes.column(2) * (thickness + 0.003);
    Box::new(
        Boxes3D::from_half_sizes([[(0.5 * length + 0.15) as f32, 0.3, thickness as f32]])
            .with_centers([point(&center)])
            .with_quaternions([quaternion(&axes)])
            .with_fill_mode(FillMode::Solid)
            .with_colors([color]),
    )
}

/// What all runs share: plate, seam, the limits of lateral deviation, and the words beside the
/// picture.
pub(super) fn cell<W: Write>(
    writer: &mut Writer<W>,
    runs: &[WeldRun],
    shown: &[DrawnRun],
    exaggeration: f64,
) -> Result<(), RecordError> {
    let Some(first) = shown.first() else {
        return Ok(());
    };
    let Some(seam) = DrawnSeam::of(&first.recording.rows) else {
        return Ok(());
    };
    let of = first.recording;
    surroundings(writer, &seam, (of.half_pin, of.tolerance_name), exaggeration)?;
    let words = TextDocument::new(about(runs, shown, exaggeration));
    writer.fixed(Store::Recording, "/about", &words.with_media_type(MediaType::MARKDOWN))?;
    half_pin(writer, first)
}

/// Plate, seam, and the limits of lateral deviation beside it, m and in words.
pub(super) fn surroundings<W: Write>(
    writer: &mut Writer<W>,
    seam: &DrawnSeam,
    (half_pin, name): (f64, &str),
    exaggeration: f64,
) -> Result<(), RecordError> {
    let mut fixed =
        |entity: &str, what: &dyn AsComponents| writer.fixed(Store::Recording, entity, what);
    fixed("/cell", &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    fixed("/cell/plate", plate(seam).as_ref())?;
    let nominal = LineStrips3D::new([seam.line(0.0, 0.0)])
        .with_radii([0.005])
        .with_colors([Color::from_rgb(40, 40, 40)]);
    fixed("/cell/seam", &nominal)?;
    let limit = half_pin * exaggeration;
    let limits = LineStrips3D::new([limit, -limit].map(|across| seam.line(across, 0.0)))
        .with_radii([0.003])
        .with_colors([signals::rgb(LIMIT)])
        .with_labels([format!("{name}, ±{:.1} mm", half_pin * MILLI)])
        .with_show_labels(false);
    fixed("/cell/half_pin", &limits)?;
    let (last, axes) = seam.0[seam.0.len() - 1];
    let end = Arrows3D::from_vectors([point(&(axes.column(0) * 0.25))])
        .with_origins([point(&last)])
        .with_radii([0.006])
        .with_colors([Color::from_rgb(90, 90, 90)]);
    fixed("/cell/weld_direction", &end)
}

/// The limit of lateral deviation in the plots, over the whole time of a run.
fn half_pin<W: Write>(writer: &mut Writer<W>, shown: &DrawnRun) -> Result<(), RecordError> {
    let (rows, limit) = (&shown.recording.rows, shown.recording.half_pin * MILLI);
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
        return Ok(());
    };
    let Beside::Path(travelled) = &shown.beside else {
        return Ok(());
    };
    let times = [
        TimeColumn::new_duration_secs("time", [first.time, last.time]),
        TimeColumn::new_sequence(
            "path_um",
            [0, travelled.last().map_or(0, |far| micrometres(*far))],
        ),
    ];
    let name = format!("{}, ±{limit:.1}", shown.recording.tolerance_name);
    signals::reference(writer, "/reference/half_pin", &name, LIMIT, times, &[[limit, -limit]; 2])
}

/// The picture in words.
fn about(runs: &[WeldRun], shown: &[DrawnRun], exaggeration: f64) -> String {
    let mut text = format!("**{}**\n\n", headline(runs));
    for (k, run) in shown.iter().enumerate() {
        let color = crate::color::run_in_words(k);
        text += &format!(
            "- {color}: {}; solid where the arm is, wire frame where its encoders say it is\n",
            run.name
        );
    }
    text += &format!(
        "- in space, deviations from the nominal pose are drawn {exaggeration:.0} × too large; plots are to scale\n\
         - way of the tool: green on the seam, red from half the pin's diameter on; green lines: that limit\n\
         - arrows: force of the process on the tool, {:.0} mm a kilonewton\n",
        FORCE_LENGTH * 1e3 * MILLI
    );
    text
}

/// One run's arm and the force on it, of the rows from `from` on, and its tool's path. `largest`: its
/// lateral deviation, m.
pub(super) fn arm<W: Write>(
    writer: &mut Writer<W>,
    robot: &Robot<f64>,
    shown: &DrawnRun,
    [exaggeration, largest]: [f64; 2],
    from: usize,
) -> Result<(), RecordError> {
    let recording = shown.recording;
    let rows = &recording.rows;
    let every = ((1.0 / POSES_PER_SECOND / recording.period.max(1e-9)).round() as usize).max(1);

    for (which, solid) in [("real", true), ("encoders", false)] {
        for link in 0..JOINTS {
            let entity = format!("/{}/cell/{which}/a{}", shown.root, link + 1);
            if from == 0
                && let Some(shape) = shape(robot, link, shown.color, solid)
            {
                writer.fixed(Store::Recording, &entity, &shape)?;
            }
        }
    }
    for range in signals::chunks(rows, from) {
        let last = range.end - 1;
        let picked: Vec<usize> = range.filter(|k| k % every == 0 || *k == last).collect();
        let times = || shown.times(picked.iter().copied());
        // Angles that hold the nominal pose; where it has none that are unique, the encoders' own
        // stand for them.
        let drawn: Vec<[JointVector<f64>; 2]> = picked
            .iter()
            .map(|k| {
                let row = &rows[*k];
                let nominal = robot.inverse_near(&row.nominal, &row.motor).unwrap_or(row.motor);
                [row.link, row.motor].map(|q| nominal + (q - nominal) * exaggeration)
            })
            .collect();
        for (which, pick) in [("real", 0), ("encoders", 1)] {
            let frames: Vec<_> = drawn.iter().map(|q| robot.frames(&q[pick])).collect();
            for link in 0..JOINTS {
                let entity = format!("/{}/cell/{which}/a{}", shown.root, link + 1);
                let poses = Transform3D::update_fields()
                    .with_many_translation(frames.iter().map(|f| point(&f.origin[link])))
                    .with_many_quaternion(frames.iter().map(|f| quaternion(&f.rotation[link])))
                    .columns_of_unit_batches()
                    .map_err(refused)?;
                writer.columns(&entity, picked.len(), times(), poses)?;
            }
            if which == "real" {
                let forces = Arrows3D::update_fields()
                    .with_origins(frames.iter().map(|f| point(&f.tcp.position)))
                    .with_vectors(
                        picked
                            .iter()
                            .map(|k| &rows[*k])
                            .map(|row| point(&(row.axes * row.force_w * FORCE_LENGTH))),
                    )
                    .columns_of_unit_batches()
                    .map_err(refused)?;
                writer.columns(
                    &format!("/{}/cell/force", shown.root),
                    picked.len(),
                    times(),
                    forces,
                )?;
            }
        }
    }
    let [r, g, b] = shown.color;
    let style =
        Arrows3D::update_fields().with_colors([Color::from_rgb(r, g, b)]).with_radii([0.008]);
    writer.fixed(Store::Recording, &format!("/{}/cell/force", shown.root), &style)?;
    let name = format!("{}: up to {:.1} mm", shown.name, largest * MILLI);
    way(writer, shown, &name, exaggeration)
}

/// The way of the real tool over the plate while it moves along the seam, coloured by its lateral
/// deviation, with `name` beside it.
fn way<W: Write>(
    writer: &mut Writer<W>,
    shown: &DrawnRun,
    name: &str,
    exaggeration: f64,
) -> Result<(), RecordError> {
    let recording = shown.recording;
    let moving: Vec<&RecordRow> =
        recording.rows.iter().filter(|r| crate::path::moving(r.phase)).collect();
    // Means over many turns of the spindle, whose ripple would alias with the points.
    let chunks = || moving.chunks(moving.len().div_ceil(PATH_POINTS).max(1));
    let (points, lateral): (Vec<[f32; 3]>, Vec<f64>) = chunks()
        .map(|rows| {
            let share = 1.0 / rows.len() as f64;
            let nominal: Vector3<f64> = rows.iter().map(|r| r.nominal.position * share).sum();
            let off: Vector3<f64> = rows.iter().map(|r| r.deviation_w.linear * share).sum();
            // Just above the plate: the depth of the tool is a signal, not part of this picture.
            let drawn = Vector3::new(off.x * exaggeration, off.y * exaggeration, -0.004);
            (point(&(nominal + rows[rows.len() / 2].axes * drawn)), off.y)
        })
        .unzip();
    // On the side that the tool is on, so that the names of two runs stand apart.
    let at = 3 * points.len() / 4;
    if let (Some(point), Some(off), Some(rows)) =
        (points.get(at), lateral.get(at), chunks().nth(at))
    {
        let aside = (rows[0].axes.column(1) * NAME_DISTANCE.copysign(*off)).map(|v| v as f32);
        let name = Points3D::new([std::array::from_fn::<_, 3, _>(|i| point[i] + aside[i])])
            .with_radii([0.0])
            .with_labels([name])
            .with_colors([Color::from_rgb(255, 255, 255)]);
        writer.fixed(Store::Recording, &format!("/{}/cell/name", shown.root), &name)?;
    }
    let pieces: Vec<[[f32; 3]; 2]> = points.windows(2).map(|w| [w[0], w[1]]).collect();
    let colors = lateral.iter().skip(1).map(|y| grade(y.abs() / recording.half_pin));
    let line = LineStrips3D::new(pieces).with_colors(colors).with_radii([0.009]);
    writer.fixed(Store::Recording, &format!("/{}/cell/path", shown.root), &line)
}

/// Green at 0, yellow at one half, red from 1 on.
fn grade(of_limit: f64) -> Color {
    let u = of_limit.clamp(0.0, 1.0);
    let (from, to, t) = if u < 0.5 {
        ([0.0, 158.0, 90.0], [235.0, 190.0, 0.0], 2.0 * u)
    } else {
        ([235.0, 190.0, 0.0], [200.0, 0.0, 30.0], 2.0 * u - 1.0)
    };
    let [r, g, b] = std::array::from_fn(|i| (from[i] + (to[i] - from[i]) * t) as u8);
    Color::from_rgb(r, g, b)
}

/// One link as a capsule to the next frame; the last one with the tool. `None` where two frames
/// coincide.
fn shape(
    robot: &Robot<f64>,
    link: usize,
    [r, g, b]: crate::color::Rgb,
    solid: bool,
) -> Option<Capsules3D> {
    let parameters = robot.parameters();
    let tool = &parameters.tool;
    let (ends, radii) = match parameters.joints.get(link + 1) {
        Some(next) => (vec![[Vector3::zeros(), next.origin]], vec![RADII[link]]),
        None => {
            let tcp = tool.flange_offset + tool.tcp_from_flange;
            // The spindle ends a little before the pin's tip, which alone is in the material.
            let shoulder = tool.flange_offset + tool.tcp_from_flange * 0.85;
            (
                vec![
                    [Vector3::zeros(), tool.flange_offset],
                    [tool.flange_offset, shoulder],
                    [shoulder, tcp],
                ],
                vec![0.09, 0.06, 0.02],
            )
        }
    };
    let (mut lengths, mut starts, mut turns, mut thick) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for ([start, end], radius) in ends.iter().zip(radii) {
        let way: Vector3<f64> = end - start;
        if way.norm() < 1e-6 {
            continue;
        }
        let turn = Rotation3::rotation_between(&Vector3::z(), &way).unwrap_or_else(|| {
            Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
        });
        lengths.push(way.norm() as f32);
        starts.push(point(start));
        turns.push(quaternion(turn.matrix()));
        thick.push(radius);
    }
    if lengths.is_empty() {
        return None;
    }
    let shape = Capsules3D::from_lengths_and_radii(lengths, thick)
        .with_translations(starts)
        .with_quaternions(turns);
    Some(if solid {
        shape.with_fill_mode(FillMode::Solid).with_colors([Color::from_rgb(r, g, b)])
    } else {
        shape
            .with_fill_mode(FillMode::TransparentFillMajorWireframe)
            .with_line_radii([0.002])
            .with_colors([Color::from_unmultiplied_rgba(r, g, b, 120)])
    })
}

fn point(p: &Vector3<f64>) -> [f32; 3] {
    [p.x as f32, p.y as f32, p.z as f32]
}

fn quaternion(rotation: &Matrix3<f64>) -> Quaternion {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    Quaternion::from_xyzw([q.i as f32, q.j as f32, q.k as f32, q.w as f32])
}
