//! The weld to make: `weld/1`, a straight one, and `weld/2`, along any path.

use super::{Bounds, FileKind, InputError, InputFile, TomlTable};
use crate::path::{Joined, LEAST_RADIUS, Path, PathError, PathPoint};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::sync::Arc;
use trueweld_core::Twist;

/// How far a stated unit vector's length may be from 1.
const NORMAL_LENGTH_TOLERANCE: f64 = 1e-6;

/// Below this sine between tool axis and path there is no direction across the weld to speak of.
const TOOL_AXIS_SINE_MIN: f64 = 1e-3;

/// Cosine up to which a tool axis counts as square to its path: a tenth of a millimetre a metre.
const TOOL_AXIS_LEAN_MAX: f64 = 1e-4;

/// Most points of a path.
const MOST_POINTS: usize = 1000;

/// How far from the taught seam the real one may lie, m: farther, it is another seam, and no sensor
/// that looks at the one sees the other.
const FARTHEST: f64 = 0.02;

/// A weld.
#[derive(Debug, Clone, PartialEq)]
pub struct Weld {
    /// Start on the plate's surface, in B, m.
    pub start: Vector3<f64>,
    /// End on the plate's surface, in B, m.
    pub end: Vector3<f64>,
    /// Tool axis in B, of length 1, into the material: z of the weld frame W.
    pub tool_axis: Vector3<f64>,
    /// Speed along the weld, m/s.
    pub feed: f64,
    /// Time in which the feed rises from 0, s.
    pub feed_ramp: f64,
    /// Depth force to hold, N; 0 of a weld whose depth is held by position.
    pub force: f64,
    /// Time in which the force rises to it, s.
    pub force_ramp: f64,
    /// Depth of the tool in the material at the start, m.
    pub initial_depth: f64,
    /// Time of pure position control before the force loop closes, s.
    pub settle: f64,
    /// The way of a curved seam, whose ends are `start` and `end`. `None` of a straight one.
    pub path: Option<Arc<Path>>,
    /// By how much the tool leans from the surface's normal, rad: lead about y of W, so that the
    /// spindle follows its tip, and tilt about x.
    pub lean: [f64; 2],
    /// Time under full push before the feed begins, s.
    pub dwell: f64,
    /// Way beyond the seam's end on which the tool goes on welding, m.
    pub run_out: f64,
    /// From where on the feed changes, m, and to what, m/s; `feed` before the first.
    pub feeds: Vec<(f64, f64)>,
    /// Where the seam really lies.
    pub real: RealSeam,
}

/// Where a seam really lies, against where it was taught.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RealSeam {
    /// It as a whole, axes of W at its start: m and rad.
    pub by: Twist<f64>,
    /// Its wave across, on top.
    pub wave: Option<Wave>,
}

/// A wave across a seam, of which the path makes one period in its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// Amplitude, m.
    pub amplitude: f64,
    /// Length, m.
    pub length: f64,
    /// Phase at the seam's start, rad.
    pub phase: f64,
}

impl Wave {
    /// How far across, m, at a path position, m.
    pub fn at(&self, path: f64) -> f64 {
        self.amplitude * (std::f64::consts::TAU * path / self.length + self.phase).sin()
    }
}

impl RealSeam {
    /// A seam where it was taught.
    pub fn as_taught() -> Self {
        Self { by: Twist::zero(), wave: None }
    }

    fn read(table: &TomlTable<'_>) -> Result<Self, InputError> {
        const MOVED_KEYS: [&str; 6] =
            ["shift_x_m", "shift_y_m", "shift_z_m", "turn_x_rad", "turn_y_rad", "turn_z_rad"];
        const WAVE_KEYS: [&str; 3] = ["wave_m", "wave_length_m", "wave_phase_rad"];
        table.only(&[&MOVED_KEYS[..], &WAVE_KEYS].concat())?;
        let mut by = [0.0; 6];
        for (value, key) in by.iter_mut().zip(MOVED_KEYS) {
            *value = table.quantity_or(key, 0.0)?;
        }
        let [x, y, z, turns @ ..] = by;
        let wave = if WAVE_KEYS.iter().any(|key| table.has(key)) {
            Some(Wave {
                amplitude: table.quantity("wave_m")?,
                length: table.quantity("wave_length_m")?,
                phase: table.quantity_or("wave_phase_rad", 0.0)?,
            })
        } else {
            None
        };
        let by = Twist { angular: Vector3::from(turns), linear: Vector3::new(x, y, z) };
        Ok(Self { by, wave })
    }

    /// How far the seam is at most from where it was taught, and where, m. `reach`: from the start to
    /// points of the seam, by path.
    fn farthest(&self, reach: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
        let wave = self.wave.map_or(0.0, |wave| wave.amplitude.abs());
        let off = |(path, reach): (f64, f64)| {
            (path, self.by.linear.norm() + self.by.angular.norm() * reach + wave)
        };
        reach.map(off).fold((0.0, 0.0), |most, at| if at.1 > most.1 { at } else { most })
    }
}

impl InputFile for Weld {
    const KIND: FileKind = FileKind::Weld;

    fn from_root(root: &TomlTable<'_>) -> Result<Self, InputError> {
        match root.text("schema")?.text {
            "weld/1" => Self::straight(root),
            _ => Self::along_path(root),
        }
    }
}

impl Weld {
    /// Speed along the weld at a path position, m/s, but for its rise and fall at the ends.
    pub fn feed_at(&self, path: f64) -> f64 {
        let now = self.feeds.iter().rev().find(|(from, _)| path >= *from);
        now.map_or(self.feed, |(_, feed)| *feed)
    }

    /// A `weld/1`.
    fn straight(root: &TomlTable<'_>) -> Result<Self, InputError> {
        root.only(&[
            "schema",
            "start_m",
            "end_m",
            "tool_axis",
            "feed_m_s",
            "feed_ramp_s",
            "held",
            "force_n",
            "force_ramp_s",
            "initial_depth_m",
            "settle_s",
        ])?;
        let start = root.vector("start_m")?;
        let end = root.vector("end_m")?;
        let axis = root.vector("tool_axis")?;
        let path = end - start;
        if path.norm() < 1e-6 {
            let help = "A weld needs a length: move `end_m` away from `start_m`.";
            return Err(root.wrong("end_m", "a point other than `start_m`", help));
        }
        if (axis.norm() - 1.0).abs() > NORMAL_LENGTH_TOLERANCE {
            let expected = format!("a vector of length 1, not {}", axis.norm());
            let help = match axis.try_normalize(1e-12) {
                Some(unit) => {
                    format!("In the same direction: [{}, {}, {}].", unit.x, unit.y, unit.z)
                }
                None => "It points along the tool, into the material.".to_owned(),
            };
            return Err(root.wrong("tool_axis", &expected, help));
        }
        let tool_axis = axis.normalize();
        if tool_axis.cross(&path.normalize()).norm() < TOOL_AXIS_SINE_MIN {
            let expected = "a direction that is not parallel to the path from `start_m` to `end_m`";
            return Err(root.wrong(
                "tool_axis",
                expected,
                "It points along the tool, into the material.",
            ));
        }
        // A seam is square to its axis, and would miss its end by as much.
        let leans = tool_axis.dot(&path.normalize()).abs();
        if leans > TOOL_AXIS_LEAN_MAX {
            let expected = format!(
                "a direction square to the path from `start_m` to `end_m`, not {:.2}° from it",
                leans.asin().to_degrees()
            );
            let help = "A tool that leans along the path has `lead_deg` in schema weld/2.";
            return Err(root.wrong("tool_axis", &expected, help));
        }
        let [force, force_ramp] = push(root)?;
        Ok(Self {
            start,
            end,
            tool_axis,
            feed: root.quantity("feed_m_s")?,
            feed_ramp: root.quantity("feed_ramp_s")?,
            force,
            force_ramp,
            initial_depth: root.quantity("initial_depth_m")?,
            settle: root.quantity("settle_s")?,
            path: None,
            lean: [0.0; 2],
            dwell: 0.0,
            run_out: 0.0,
            feeds: Vec::new(),
            real: RealSeam::as_taught(),
        })
    }

    /// A `weld/2`.
    fn along_path(root: &TomlTable<'_>) -> Result<Self, InputError> {
        root.only(&[
            "schema",
            "joined",
            "corner_radius_m",
            "part",
            "point",
            "lead_deg",
            "tilt_deg",
            "feed_m_s",
            "feed_ramp_s",
            "feed",
            "held",
            "force_n",
            "force_ramp_s",
            "initial_depth_m",
            "settle_s",
            "dwell_s",
            "run_out_m",
            "real_seam",
        ])?;
        let tables = root.tables("point")?;
        let points = Self::points(root, &tables)?;
        let joined = joined(root)?;
        let path = Path::new(&points, joined).map_err(|why| at_fault(root, &tables, &why))?;
        let [first, .., last] = points.as_slice() else {
            return Err(at_fault(root, &tables, &PathError::TooFew));
        };
        // A line through two points with one normal is a straight seam and nothing else.
        let axis = -first.normal.normalize();
        let along = (last.position - first.position).normalize();
        let is_straight = points.len() == 2
            && first.normal == last.normal
            && along.dot(&axis).abs() < NORMAL_LENGTH_TOLERANCE;
        let (length, (_, start)) = (path.length(), path.at(0.0));
        let or_none = |key| root.quantity_or(key, 0.0);
        let feed = root.quantity("feed_m_s")?;
        let feed_ramp = root.quantity("feed_ramp_s")?;
        let run_out = or_none("run_out_m")?;
        let [force, force_ramp] = push(root)?;
        let real = root.optional_table("real_seam", |table| {
            let real = RealSeam::read(table)?;
            let reach = |k: usize| {
                let s = length * k as f64 / 100.0;
                (s, (path.at(s).0 - first.position).norm())
            };
            let (place, off) = real.farthest((0..=100).map(reach));
            if off > FARTHEST {
                let message = format!(
                    "puts the seam {:.1} mm off at {place:.3} m along it; expected at most {:.0} mm",
                    off * 1e3,
                    FARTHEST * 1e3
                );
                return Err(table.error(
                    &message,
                    "Farther off it is another seam: teach it where it is, with [part] and [[point]].",
                ));
            }
            Ok(real)
        })?;
        Ok(Self {
            start: first.position,
            end: last.position,
            tool_axis: if is_straight { axis } else { start.column(2).into_owned() },
            feeds: feeds(root, feed, feed_ramp, length)?,
            feed,
            feed_ramp,
            force,
            force_ramp,
            initial_depth: root.quantity("initial_depth_m")?,
            settle: root.quantity("settle_s")?,
            path: (!is_straight).then(|| Arc::new(path)),
            lean: [or_none("lead_deg")?.to_radians(), or_none("tilt_deg")?.to_radians()],
            dwell: or_none("dwell_s")?,
            run_out,
            real: real.unwrap_or_else(RealSeam::as_taught),
        })
    }

    /// The points of a path, from the part's frame into B.
    fn points(
        root: &TomlTable<'_>,
        tables: &[TomlTable<'_>],
    ) -> Result<Vec<PathPoint>, InputError> {
        let part = root.optional_table("part", |part| {
            part.only(&["position_m", "abc_deg"])?;
            let [a, b, c] = part.quantities::<3>("abc_deg")?.map(f64::to_radians);
            let turn = Rotation3::from_euler_angles(c, b, a).into_inner();
            Ok((part.vector("position_m")?, turn))
        })?;
        let (position, rotation) = part.unwrap_or((Vector3::zeros(), Matrix3::identity()));
        if tables.len() > MOST_POINTS {
            let expected = format!("at most {MOST_POINTS} [[point]] tables");
            return Err(root.wrong_key("point", &expected, "A spline needs far fewer."));
        }
        let read = |table: &TomlTable<'_>| {
            table.only(&["at_m", "normal"])?;
            Ok(PathPoint {
                position: position + rotation * table.vector("at_m")?,
                normal: rotation * Vector3::from(table.numbers::<3>("normal", Bounds::Any)?),
            })
        };
        tables.iter().map(read).collect()
    }
}

/// The push and the time in which it rises, N and s; zeros where the depth is held by position.
fn push(root: &TomlTable<'_>) -> Result<[f64; 2], InputError> {
    const PUSH_KEYS: [&str; 2] = ["force_n", "force_ramp_s"];
    if !root.has("held") {
        return Ok([root.quantity(PUSH_KEYS[0])?, root.quantity(PUSH_KEYS[1])?]);
    }
    if root.text("held")?.text != "position" {
        let help = "Without the key a force loop holds `force_n`.";
        return Err(root.wrong("held", "\"position\"", help));
    }
    match PUSH_KEYS.into_iter().find(|key| root.has(key)) {
        Some(key) => {
            let help = "Leave it out, or `held`: a depth is held by position or by a force.";
            Err(root.wrong_key(key, "no such key beside held = \"position\"", help))
        }
        None => Ok([0.0; 2]),
    }
}

/// `joined` and `corner_radius_m`.
fn joined(root: &TomlTable<'_>) -> Result<Joined, InputError> {
    let radius = root.optional("corner_radius_m", TomlTable::quantity)?;
    match (root.text("joined")?.text, radius) {
        ("spline", None) => Ok(Joined::Spline),
        ("spline", Some(_)) => Err(root.wrong_key(
            "corner_radius_m",
            "no such key beside joined = \"spline\"",
            "A spline has no corners.",
        )),
        ("legs", radius) => {
            if radius.is_some_and(|radius| radius < LEAST_RADIUS) {
                let expected = format!("at least {LEAST_RADIUS} m");
                return Err(root.wrong(
                    "corner_radius_m",
                    &expected,
                    "A tool's shoulder cannot turn on less.",
                ));
            }
            Ok(Joined::Legs(radius))
        }
        _ => Err(root.wrong(
            "joined",
            "\"spline\" or \"legs\"",
            "A spline passes smoothly through all points; legs are straight, with rounded corners.",
        )),
    }
}

/// What a path cannot be made of, at its place in the file.
fn at_fault(root: &TomlTable<'_>, tables: &[TomlTable<'_>], why: &PathError) -> InputError {
    let (point, key, help) = match *why {
        PathError::TooFew => {
            let help = "Write two [[point]] tables or more, each with at_m and normal.";
            return root.wrong_key("point", "at least two points", help);
        }
        PathError::Doubled(point) => (point, "at_m", "Leave one of the two out."),
        PathError::NoNormal(point) => (
            point,
            "normal",
            "It points out of the material, square to the surface; its length does not matter.",
        ),
        PathError::AlongPath(point) => {
            (point, "normal", "It points out of the material, square to the surface.")
        }
        PathError::TurnsOver(point) => (
            point,
            "normal",
            "All normals point out of the material. A surface that turns by more than 60° from point to point needs \
             points in between.",
        ),
        PathError::Corner { point, .. } => {
            (point, "at_m", "Add corner_radius_m, or join the points by a spline.")
        }
        PathError::ShortLegs(point) => (point, "at_m", "Make corner_radius_m smaller."),
        PathError::Bend { point, .. } => (
            point,
            "at_m",
            "No tool follows a bend of less than 20 mm: look for a point or a normal that is off, or out of order.",
        ),
        PathError::Returns { point, .. } => {
            (point, "at_m", "Where on it the tool is would not be known: weld it as two seams.")
        }
    };
    match tables.get(point) {
        Some(table) => table.wrong(key, &why.to_string(), help),
        None => root.wrong_key("point", &why.to_string(), help),
    }
}

/// The `[[feed]]` tables: where the feed changes, and to what. A change takes as long as the rise from
/// standstill does for as much.
fn feeds(
    root: &TomlTable<'_>,
    first: f64,
    ramp: f64,
    length: f64,
) -> Result<Vec<(f64, f64)>, InputError> {
    let tables = root.optional("feed", TomlTable::tables)?.unwrap_or_default();
    let rate = first / ramp.max(f64::MIN_POSITIVE);
    let way = |from: f64, to: f64| (to * to - from * from).abs() / (2.0 * rate);
    // Where the last change, or the rise, is over.
    let (mut ends, mut before) = (way(0.0, first), first);
    let mut feeds = Vec::with_capacity(tables.len());
    for table in &tables {
        table.only(&["from_m", "feed_m_s"])?;
        let (from, feed) = (table.quantity("from_m")?, table.quantity("feed_m_s")?);
        let falls = length - way(feed, 0.0) - way(before, feed);
        if from < ends || from > falls {
            let expected = format!(
                "a place from {ends:.4} to {falls:.4} m, where the change before it is over and this one has room"
            );
            return Err(table.wrong(
                "from_m",
                &expected,
                "Changes stand in their order; each takes as long as the rise from standstill does for as much.",
            ));
        }
        ends = from + way(before, feed);
        before = feed;
        feeds.push((from, feed));
    }
    Ok(feeds)
}
