//! Figures of a weld over its steady part (full feed, full force), and whether it is the weld that
//! was asked for.

use crate::figure::{Figure, FigureOf, share_of_limit, within};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use trueweld_core::control::Limited;
use trueweld_core::{JOINTS, JointVector};
use trueweld_plant::input::{Process, Weld};
use trueweld_plant::simulate::{
    HealthWarning, LimitSpan, Phase, RecordRow, Recording, health_warnings, limit_spans,
};

/// Mean, root mean square and largest magnitude of a signal, in the signal's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Root mean square about zero.
    pub rms: f64,
    /// Largest magnitude.
    pub max_abs: f64,
}

impl Spread {
    /// Of a signal; not a number for an empty one.
    pub fn of(signal: impl Iterator<Item = f64>) -> Self {
        let (mut n, mut sum, mut square, mut max_abs) = (0_usize, 0.0, 0.0, 0.0_f64);
        for v in signal {
            n += 1;
            sum += v;
            square += v * v;
            max_abs = larger(max_abs, v.abs());
        }
        let max_abs = if n == 0 { f64::NAN } else { max_abs };
        let n = n as f64;
        Self { mean: sum / n, rms: (square / n).sqrt(), max_abs }
    }
}

/// The larger of two values; not a number where either is none, which `f64::max` would pass over.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// The push in the steady part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ForceFigures {
    /// Mean of the real push, N.
    pub mean: f64,
    /// Largest less smallest real push, N: the width of its envelope.
    pub envelope: f64,
    /// Root mean square of real push less the push asked for, N.
    pub error_rms: f64,
    /// The same of the push that the force sensor reads: what the force loop makes of it.
    pub measured_error_rms: f64,
    /// Mean of the push that the force sensor reads less the mean of the real push, N: what is wrong
    /// with the sensor.
    pub reading_error: f64,
}

/// Parts of a weld beside the steady one, by their names in requirements: at the start, under
/// position control, the tool in the material; while push and feed rise and settle; at the end,
/// while the feed falls and the tool stands.
pub const WELD_PHASES: [&str; 3] = ["start", "rise", "end"];

/// The part that a phase belongs to, by its place in [`WELD_PHASES`]; `None` for the steady one.
fn part(phase: Phase) -> Option<usize> {
    match phase {
        Phase::Settle => Some(0),
        Phase::ForceRamp | Phase::FeedRamp => Some(1),
        Phase::Steady => None,
        Phase::Stop | Phase::Hold => Some(2),
    }
}

/// One part of a weld beside the steady one; not numbers where the weld has not got that part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseFigures {
    /// Across the seam, m.
    pub lateral: Spread,
    /// Along the seam, m.
    pub longitudinal: Spread,
    /// Angle between the real and the nominal tool axis, rad.
    pub tilt: Spread,
    /// Greatest depth below the plate's surface, m.
    pub deepest: f64,
    /// Real push less the push asked for, N; not numbers where none is asked for.
    pub push_error: Spread,
}

impl PhaseFigures {
    fn of<'r>(rows: impl Iterator<Item = &'r RecordRow> + Clone) -> Self {
        let spread = |f: fn(&RecordRow) -> f64| Spread::of(rows.clone().map(f));
        let asked = rows.clone().filter_map(|r| Some(-r.force_w.z - r.force_desired?));
        Self {
            lateral: spread(|r| r.deviation_w.linear.y),
            longitudinal: spread(|r| r.deviation_w.linear.x),
            tilt: spread(|r| r.tilt),
            deepest: rows
                .clone()
                .map(|r| r.deviation_w.linear.z)
                .reduce(larger)
                .unwrap_or(f64::NAN),
            push_error: Spread::of(asked),
        }
    }
}

/// What one drive gives in the steady part of a weld.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DriveLoad {
    /// Largest torque over what the drive may give.
    pub torque_share: f64,
    /// Largest speed over what the drive may do.
    pub speed_share: f64,
    /// Share of the steady part in which the drive stands at its torque limit.
    pub at_torque_limit: f64,
    /// Share of the steady part in which the drive stands at its speed limit.
    pub at_speed_limit: f64,
}

/// Share of a drive's torque or speed from which on it stands at its limit: a torque that is cut off
/// is the limit but for its last digits.
const AT_LIMIT: f64 = 0.999;

impl DriveLoad {
    /// The larger of each number.
    pub(crate) fn most(&self, other: &Self) -> Self {
        Self {
            torque_share: self.torque_share.max(other.torque_share),
            speed_share: self.speed_share.max(other.speed_share),
            at_torque_limit: self.at_torque_limit.max(other.at_torque_limit),
            at_speed_limit: self.at_speed_limit.max(other.at_speed_limit),
        }
    }

    /// What each drive gives in the steady part, and the share of it in which any of them stands at
    /// a limit.
    pub(crate) fn all(recording: &Recording) -> ([Self; JOINTS], f64) {
        let Recording { rows, period, max_torque, max_rate, .. } = recording;
        let steady = rows.iter().filter(|row| row.phase == Phase::Steady).count().max(1);
        let each = 1.0 / steady as f64;
        let (mut loads, mut at_limit) = ([Self::default(); JOINTS], 0.0);
        for pair in rows.windows(2).filter(|pair| pair[1].phase == Phase::Steady) {
            let torque = pair[1].torque.abs().component_div(max_torque);
            let rate = (pair[1].motor - pair[0].motor) / *period;
            let speed = rate.abs().component_div(max_rate);
            for (joint, load) in loads.iter_mut().enumerate() {
                let (torque, speed) = (torque[joint], speed[joint]);
                load.torque_share = larger(load.torque_share, torque);
                load.speed_share = larger(load.speed_share, speed);
                load.at_torque_limit += if torque > AT_LIMIT { each } else { 0.0 };
                load.at_speed_limit += if speed > AT_LIMIT { each } else { 0.0 };
            }
            let held = torque.amax().max(speed.amax()) > AT_LIMIT;
            at_limit += if held { each } else { 0.0 };
        }
        (loads, at_limit)
    }
}

/// How far the tool left its line in the steady part of one weld.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct WeldFigures {
    /// Deviation across the seam, m.
    #[serde(rename = "lateral_m")]
    pub lateral: Spread,
    /// Deviation along the seam, m.
    #[serde(rename = "longitudinal_m")]
    pub longitudinal: Spread,
    /// Depth below the plate's surface, m.
    #[serde(rename = "depth_m")]
    pub depth: Spread,
    /// Angle between the real and the nominal tool axis, rad.
    #[serde(rename = "tilt_rad")]
    pub tilt: Spread,
    /// Its part across the seam, about x of W, rad.
    #[serde(skip)]
    pub side_tilt: Spread,
    /// Its part along the seam, about y of W, rad: what the travel angle is off by.
    #[serde(skip)]
    pub travel_angle: Spread,
    /// Push on the plate, N.
    #[serde(rename = "force_n")]
    pub force: ForceFigures,
    // What the torsion that the process adds to a joint displaces, over the deviation less the
    // correction, both averaged along the seam with the sign of that difference. To first order the
    // shares sum to 1.
    /// Share of each joint's twist in the lateral deviation, A1 to A6.
    #[schemars(with = "Vec<f64>")]
    pub joint_share: [f64; JOINTS],
    /// Half the pin's diameter, m: what the lateral deviation is to stay within.
    pub half_pin_m: f64,
    /// Largest correction of the set-point in the whole run: translation in m, rotation in rad.
    #[serde(skip)]
    pub correction: [f64; 2],
    // From the closing of the force loop to full feed.
    /// Largest lateral deviation before the steady part, m.
    pub lateral_before_m: f64,
    /// The parts beside the steady one, in the order of [`WELD_PHASES`].
    #[serde(skip)]
    pub phases: [PhaseFigures; 3],
    /// Rows of the recording at a limit or with a fault.
    pub limited_rows: usize,
    /// Where the run first was at a limit or faulted.
    pub first_limit: Option<FirstLimit>,
    /// What was at a limit, the longest first.
    pub limits: Vec<LimitSpan>,
    /// What the drives gave in the steady part, A1 to A6.
    #[schemars(with = "Vec<DriveLoad>")]
    pub drives: [DriveLoad; JOINTS],
    /// Time in the steady part in which a drive stood at its torque or its speed limit, s.
    pub at_limit_s: f64,
    /// What the watch beside the law warned of, the first first.
    pub health: Vec<HealthWarning>,
    /// `pass` where every figure of `judged` is within its tolerance, else `fail`.
    #[serde(rename = "verdict", serialize_with = "verdict")]
    #[schemars(with = "String")]
    pub met: bool,
    /// Whether it is the weld that was asked for, figure by figure.
    #[schemars(with = "Vec<JudgedFigure>")]
    pub judged: [JudgedFigure; 8],
}

/// Where a run first was at a limit or faulted, and what was held.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "FirstLimitResult", deny_unknown_fields)]
pub struct FirstLimit {
    /// Time, s.
    pub time_s: f64,
    /// Where the run was in its program.
    pub phase: Phase,
    /// The torque of some drive.
    pub torque: bool,
    /// What the force loop adds.
    pub force_loop: bool,
    /// The compensation.
    pub compensation: bool,
    /// The fault, if there was one.
    pub fault: Option<String>,
}

impl FirstLimit {
    /// Of a whole run; `None` where there was none.
    pub fn of(recording: &Recording) -> Option<Self> {
        let &RecordRow { time: time_s, phase, limited, fault, .. } =
            recording.rows.iter().find(|r| held(r))?;
        let Limited { torque, force_loop, compensation } = limited;
        let fault = fault.map(|fault| format!("{fault:?}"));
        Some(Self { time_s, phase, torque, force_loop, compensation, fault })
    }
}

/// A figure of a weld against what it is to be, in the unit of its key.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "JudgedFigureResult", deny_unknown_fields)]
pub struct JudgedFigure {
    /// Key of the figure.
    pub figure: Figure,
    // Of deviations the largest, of push and speed the mean.
    /// What it came to.
    #[schemars(with = "Option<f64>")]
    pub value: f64,
    /// What it is to be.
    pub expected: f64,
    /// How far from that it may be.
    pub tolerance: f64,
    /// Whether it is within that.
    pub met: bool,
}

impl JudgedFigure {
    /// How far it is from what it is to be.
    pub fn off(&self) -> f64 {
        (self.value - self.expected).abs()
    }

    /// How much of its tolerance that takes up: above 1 where it is not met.
    pub fn share(&self) -> f64 {
        share_of_limit(self.off(), 0.0, self.tolerance)
    }
}

/// Places of figures in [`WeldFigures::judged`].
const DEPTH_FIGURE: usize = 2;
const PUSH_FIGURE: usize = 3;
const SPEED_FIGURE: usize = 4;
const DRIVE_TORQUE_FIGURE: usize = 6;
const DRIVE_SPEED_FIGURE: usize = 7;

/// Share by which the mean push and the mean speed may be off: the band within which a force step
/// counts as settled.
const STEADY_BAND: f64 = 0.05;

/// Largest tilt of the tool, rad: half a degree, the tolerance in use (`fixtures/requirements`).
const TILT: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// What the files of a weld ask of it: within what it is the weld that was asked for.
///
/// Lateral: within half the pin, or the joint line of a butt weld is missed. Along the seam: within
/// a pin, so that the weld begins and ends where it is to. Depth: within half a pin of where the
/// process as planned bears the push, whether the tool sinks or is lifted off. Push and speed: within
/// the band in which a force step counts as settled. Tilt: the tolerance in use. Drives: below their
/// limits of torque and speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AskedWeld {
    /// Half the pin's diameter, m.
    pub half_pin: f64,
    /// Push of the weld program, N.
    pub force: f64,
    /// Depth at which the process as planned bears that push, m.
    pub planned_depth: f64,
}

/// Figures that decide whether it is the weld that was asked for, by their keys in
/// [`WELD_FIGURES`], in the order of [`WeldFigures::judged`].
pub const ASKED_FIGURES: [&str; 8] = [
    "lateral_max_m",
    "longitudinal_max_m",
    "depth_error_max_m",
    "push_error_mean_n",
    "speed_error_share",
    "tilt_max_rad",
    "torque_share_max",
    "speed_share_max",
];

impl AskedWeld {
    /// Of a weld as it is planned.
    pub fn new(weld: &Weld, planned: &Process) -> Self {
        Self {
            half_pin: planned.model.lateral_tolerance(),
            force: weld.force,
            planned_depth: planned.depth_under(weld.force),
        }
    }

    /// The most that a figure, by its key without a phase, comes to in the weld that was asked for;
    /// `None` where that leaves it open.
    pub fn most(&self, key: &str) -> Option<f64> {
        Some(match key {
            "lateral_rms_m" | "lateral_max_m" | "lateral_before_m" => self.half_pin,
            "longitudinal_max_m" => 2.0 * self.half_pin,
            "depth_rms_m" | "depth_error_max_m" => self.half_pin,
            "depth_max_m" => self.planned_depth + self.half_pin,
            // Of a weld that is held by position, no push is asked for.
            "push_error_mean_n" if self.force == 0.0 => return None,
            "push_error_mean_n" => STEADY_BAND * self.force,
            "speed_error_share" => STEADY_BAND,
            "tilt_rms_rad" | "tilt_max_rad" | "side_tilt_rms_rad" | "travel_angle_rms_rad" => TILT,
            "torque_share_max" | "speed_share_max" => AT_LIMIT,
            "at_limit_s" => 0.0,
            _ => return None,
        })
    }
}

/// A figure of one of [`WELD_PHASES`]: key, what is said before and behind the phase, unit, value.
macro_rules! of_phase {
    (start: $($figure:tt)+) => {
        of_phase!(0, "start.", " at the start, ", $($figure)+)
    };
    (rise: $($figure:tt)+) => {
        of_phase!(1, "rise.", " while push and feed rise, ", $($figure)+)
    };
    (end: $($figure:tt)+) => {
        of_phase!(2, "end.", " at the end, ", $($figure)+)
    };
    (
        $number:literal, $phase:literal, $when:literal,
        $key:literal, $what:literal, $which:literal, $unit:literal, $($value:ident).+
    ) => {
        FigureOf::new(concat!($phase, $key), concat!($what, $when, $which), $unit, |f| {
            f.phases[$number].$($value).+
        })
    };
}

/// Figures of a weld that requirements may limit: of the steady part and of the whole run, then with
/// the name of the phase before a dot those of [`WELD_PHASES`].
pub static WELD_FIGURES: [FigureOf<WeldFigures>; 37] = [
    FigureOf::new("lateral_rms_m", "lateral, RMS", "m", |f| f.lateral.rms),
    FigureOf::new("lateral_max_m", "lateral, largest", "m", |f| f.lateral.max_abs),
    FigureOf::new("longitudinal_max_m", "along the seam, largest", "m", |f| f.longitudinal.max_abs),
    // Depth is what the push makes it: how far it wanders from its mean, and how far it is from where
    // the process as planned bears the push.
    FigureOf::new("depth_rms_m", "depth about its mean, RMS", "m", |f| {
        (f.depth.rms.powi(2) - f.depth.mean.powi(2)).max(0.0).sqrt()
    }),
    FigureOf::new("depth_error_max_m", "depth off the planned, largest", "m", |f| {
        f.judged[DEPTH_FIGURE].off()
    }),
    FigureOf::new("tilt_rms_rad", "tilt, RMS", "rad", |f| f.tilt.rms),
    FigureOf::new("tilt_max_rad", "tilt, largest", "rad", |f| f.tilt.max_abs),
    FigureOf::new("side_tilt_rms_rad", "tilt across the seam, RMS", "rad", |f| f.side_tilt.rms),
    FigureOf::new("travel_angle_rms_rad", "tilt along the seam, RMS", "rad", |f| {
        f.travel_angle.rms
    }),
    FigureOf::new("push_error_rms_n", "push, RMS of its error", "N", |f| f.force.error_rms),
    FigureOf::new("push_error_mean_n", "push, error of its mean", "N", |f| {
        f.judged[PUSH_FIGURE].off()
    }),
    // Of the loop by what it reads, and of the instrument: a loop holds what its sensor shows.
    FigureOf::new("measured_push_error_rms_n", "push as measured, RMS of its error", "N", |f| {
        f.force.measured_error_rms
    }),
    FigureOf::new("push_reading_error_n", "force sensor, error of the mean push", "N", |f| {
        f.force.reading_error.abs()
    }),
    FigureOf::new("speed_error_share", "speed, error of its mean", "1", |f| {
        f.judged[SPEED_FIGURE].off() / f.judged[SPEED_FIGURE].expected
    }),
    FigureOf::new("torque_share_max", "torque of a drive, largest", "1", |f| {
        f.judged[DRIVE_TORQUE_FIGURE].off()
    }),
    FigureOf::new("speed_share_max", "speed of a drive, largest", "1", |f| {
        f.judged[DRIVE_SPEED_FIGURE].off()
    }),
    FigureOf::new("at_limit_s", "time at a limit of a drive", "s", |f| f.at_limit_s),
    FigureOf::new("lateral_before_m", "lateral before the steady part", "m", |f| {
        f.lateral_before_m
    }),
    FigureOf::new("correction_m", "correction, translation", "m", |f| f.correction[0]),
    FigureOf::new("correction_rad", "correction, rotation", "rad", |f| f.correction[1]),
    of_phase!(start: "lateral_rms_m", "lateral", "RMS", "m", lateral.rms),
    of_phase!(start: "lateral_max_m", "lateral", "largest", "m", lateral.max_abs),
    of_phase!(start: "tilt_max_rad", "tilt", "largest", "rad", tilt.max_abs),
    of_phase!(start: "depth_max_m", "depth", "greatest", "m", deepest),
    of_phase!(rise: "lateral_rms_m", "lateral", "RMS", "m", lateral.rms),
    of_phase!(rise: "lateral_max_m", "lateral", "largest", "m", lateral.max_abs),
    of_phase!(rise: "tilt_max_rad", "tilt", "largest", "rad", tilt.max_abs),
    of_phase!(rise: "depth_max_m", "depth", "greatest", "m", deepest),
    of_phase!(rise: "push_error_rms_n", "push", "RMS of its error", "N", push_error.rms),
    of_phase!(rise: "push_error_max_n", "push", "largest error", "N", push_error.max_abs),
    of_phase!(end: "lateral_rms_m", "lateral", "RMS", "m", lateral.rms),
    of_phase!(end: "lateral_max_m", "lateral", "largest", "m", lateral.max_abs),
    of_phase!(end: "longitudinal_max_m", "along the seam", "largest", "m", longitudinal.max_abs),
    of_phase!(end: "tilt_max_rad", "tilt", "largest", "rad", tilt.max_abs),
    of_phase!(end: "depth_max_m", "depth", "greatest", "m", deepest),
    of_phase!(end: "push_error_rms_n", "push", "RMS of its error", "N", push_error.rms),
    of_phase!(end: "push_error_max_n", "push", "largest error", "N", push_error.max_abs),
];

impl WeldFigures {
    /// Figures of one recording. `None` where the run never reached its steady part.
    pub fn of(recording: &Recording) -> Option<Self> {
        let steady: Vec<&RecordRow> =
            recording.rows.iter().filter(|r| r.phase == Phase::Steady).collect();
        if steady.is_empty() {
            return None;
        }
        let spread = |f: fn(&RecordRow) -> f64| Spread::of(steady.iter().map(|r| f(r)));
        let push: fn(&RecordRow) -> f64 = |r| -r.force_w.z;
        let (low, high) = steady
            .iter()
            .map(|r| push(r))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let error_of = |push: fn(&RecordRow) -> f64| {
            Spread::of(steady.iter().map(|r| push(r) - r.force_desired.unwrap_or(0.0)))
        };
        let (error, measured) = (error_of(push), error_of(|r| -r.force_sensed_w.z));
        let (mut by_joint, mut uncorrected) = (JointVector::zeros(), 0.0);
        for row in &steady {
            let lateral = row.deviation_w.linear.y - row.correction_w.linear.y;
            by_joint += row.lateral_by_joint * lateral.signum();
            uncorrected += lateral.abs();
        }
        let lateral = spread(|r| r.deviation_w.linear.y);
        let longitudinal = spread(|r| r.deviation_w.linear.x);
        let depth = spread(|r| r.deviation_w.linear.z);
        let tilt = spread(|r| r.tilt);
        let mean_push = spread(|r| -r.force_w.z).mean;
        let (drives, at_limit) = DriveLoad::all(recording);
        let before =
            recording.rows.iter().filter(|r| matches!(r.phase, Phase::ForceRamp | Phase::FeedRamp));
        let judged = judged(recording, &steady, [lateral, longitudinal, tilt], mean_push, &drives);
        Some(Self {
            lateral,
            longitudinal,
            depth,
            tilt,
            side_tilt: spread(|r| r.deviation_w.angular.x),
            travel_angle: spread(|r| r.deviation_w.angular.y),
            force: ForceFigures {
                mean: mean_push,
                envelope: high - low,
                error_rms: error.rms,
                measured_error_rms: measured.rms,
                reading_error: measured.mean - error.mean,
            },
            joint_share: if uncorrected > 0.0 { by_joint / uncorrected } else { by_joint }.into(),
            half_pin_m: recording.half_pin,
            correction: [
                Spread::of(recording.rows.iter().map(|r| r.correction_w.linear.norm())).max_abs,
                Spread::of(recording.rows.iter().map(|r| r.correction_w.angular.norm())).max_abs,
            ],
            lateral_before_m: Spread::of(before.map(|r| r.deviation_w.linear.y)).max_abs,
            phases: [0, 1, 2].map(|k| {
                PhaseFigures::of(recording.rows.iter().filter(|r| part(r.phase) == Some(k)))
            }),
            limited_rows: recording.rows.iter().filter(|r| held(r)).count(),
            first_limit: FirstLimit::of(recording),
            limits: limit_spans(recording),
            health: health_warnings(&recording.rows, recording.period),
            met: judged.iter().all(|judged| judged.met),
            judged,
            drives,
            at_limit_s: at_limit * steady.len() as f64 * recording.period,
        })
    }
}

fn verdict<S: Serializer>(met: &bool, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(if *met { "pass" } else { "fail" })
}

fn held(row: &RecordRow) -> bool {
    row.limited.any() || row.fault.is_some()
}

/// How far the real tool went along the seam, and how far it was to go, m.
fn ways(steady: &[&RecordRow], first: &RecordRow, last: &RecordRow) -> [f64; 2] {
    if steady.iter().all(|row| row.axes == first.axes) {
        let along = last.nominal.position - first.nominal.position;
        let real = last.real.position - first.real.position;
        return [real.dot(&along) / along.norm(), along.norm()];
    }
    let step = |pair: &[&RecordRow]| {
        (pair[1].real.position - pair[0].real.position).dot(&pair[0].axes.column(0))
    };
    [steady.windows(2).map(step).sum(), last.path - first.path]
}

/// The figures of [`ASKED_FIGURES`] as people read them, against what an [`AskedWeld`] is to be.
fn judged(
    recording: &Recording,
    steady: &[&RecordRow],
    [lateral, longitudinal, tilt]: [Spread; 3],
    push: f64,
    drives: &[DriveLoad; JOINTS],
) -> [JudgedFigure; 8] {
    let planned = recording.planned_depth;
    // A cut that is held by position has the axial force that it was planned with, to the same share
    // of its whole force.
    let (asked_push, of_position) = match (recording.force, recording.planned_force) {
        (0.0, force) => (-force.z, STEADY_BAND * force.norm()),
        (push, _) => (push, f64::NAN),
    };
    let asked =
        AskedWeld { half_pin: recording.half_pin, force: recording.force, planned_depth: planned };
    let depths = steady.iter().map(|r| r.deviation_w.linear.z);
    let depth = depths.fold(planned, |farthest, depth| {
        // Not a number is farthest of all.
        if (depth - planned).abs() <= (farthest - planned).abs() { farthest } else { depth }
    });
    let (first, last) = (steady[0], steady[steady.len() - 1]);
    let time = last.time - first.time;
    let [speed, feed] = ways(steady, first, last).map(|length| length / time);
    let most = |share: fn(&DriveLoad) -> f64| drives.iter().map(share).fold(0.0, f64::max);
    // As people read it: key, label, unit, value, what it is to be, and the unit of its tolerance.
    let figures = [
        ("lateral_max_m", "lateral, largest", "m", lateral.max_abs, 0.0, 1.0),
        ("longitudinal_max_m", "along the seam, largest", "m", longitudinal.max_abs, 0.0, 1.0),
        ("depth_m", "depth farthest from the planned", "m", depth, planned, 1.0),
        ("push_mean_n", "push, mean", "N", push, asked_push, 1.0),
        ("speed_mean_m_s", "speed along the seam, mean", "m/s", speed, feed, feed),
        ("tilt_max_rad", "tilt, largest", "rad", tilt.max_abs, 0.0, 1.0),
        ("torque_share_max", "torque of a drive, largest", "1", most(|d| d.torque_share), 0.0, 1.0),
        ("speed_share_max", "speed of a drive, largest", "1", most(|d| d.speed_share), 0.0, 1.0),
    ];
    std::array::from_fn(|k| {
        let (key, label, unit, value, expected, of) = figures[k];
        let tolerance = asked.most(ASKED_FIGURES[k]).map_or(of_position, |most| most * of);
        let met = within((value - expected).abs(), tolerance);
        JudgedFigure { figure: Figure { key, label, unit }, value, expected, tolerance, met }
    })
}
