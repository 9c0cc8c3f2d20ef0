//! The numbers that a fit is free in: logarithms of a file's numbers, so that none changes its sign
//! and a factor of two is as far down as up; and the parts of the ripple in step with sine and cosine
//! of the spindle's angle, to which the force is in proportion.
//!
//! They are effects, because that is what a fit moves; they are in no library and in no file.

use crate::fit::calibration::is_calibration;
use std::f64::consts::{FRAC_PI_2, LN_2};
use trueweld_plant::effects::{
    Action, Effect, EffectKind, Location, LocationKind, Parameter, Role,
};
use trueweld_plant::input::{ModelFile, Ripple};

/// Step of a logarithm in a fit, and how far it goes within one pass.
const LOGARITHM_STEP: f64 = 0.05;
const LOGARITHM_REACH: [f64; 2] = [-1.5, 1.5];

/// The same of a part of the ripple.
const RIPPLE_STEP: f64 = 0.01;
const RIPPLE_REACH: [f64; 2] = [-0.5, 0.5];

static LOGARITHM: [Parameter; 1] =
    [Parameter::size("log", "1", "logarithm of a factor", LOGARITHM_STEP, LOGARITHM_REACH)];

static PART: [Parameter; 2] = [
    Parameter::new("order", "1/turn", "periods per spindle turn", Role::SpindleOrder, [0.1, 20.0]),
    Parameter::size("part", "1", "amplitude", RIPPLE_STEP, RIPPLE_REACH),
];

/// One number of a file, or a part of one.
#[derive(Debug)]
pub(crate) struct Coordinate {
    /// The effect that changes it.
    kind: EffectKind,
    /// Key of the number in its file.
    pub name: &'static str,
    /// Unit of the number.
    pub unit: &'static str,
    /// Standard deviation that it is drawn by to where a pass began; to the value given where the logs
    /// do not tell it; and from which on they do not.
    pub drawn: f64,
    pub given: f64,
    pub untold: f64,
}

/// 95 % of a logarithm of this deviation is a factor of two either way.
const UNTOLD: f64 = 0.35;

const fn number(
    place: LocationKind,
    name: &'static str,
    unit: &'static str,
    action: Action,
) -> Coordinate {
    let kind =
        EffectKind { id: name, place, parameters: &LOGARITHM, action, ..EffectKind::DEFAULT };
    Coordinate { kind, name, unit, drawn: 1.0, given: LN_2, untold: UNTOLD }
}

/// K of a joint.
pub(crate) static STIFFNESS: Coordinate = number(
    LocationKind::Joint,
    "stiffness_nm_rad",
    "N·m/rad",
    Action::Robot(|robot, joint, v| robot.joints[joint].stiffness *= v[0].exp()),
);

/// D of a joint.
pub(crate) static JOINT_DAMPING: Coordinate = number(
    LocationKind::Joint,
    "damping_nms_rad",
    "N·m·s/rad",
    Action::Robot(|robot, joint, v| robot.joints[joint].damping *= v[0].exp()),
);

macro_rules! of_process {
    ($($key:literal, $unit:literal;)*) => {
        [$(number(
            LocationKind::Cell,
            $key,
            $unit,
            Action::Process(|process, v| process.scale($key, v[0].exp())),
        )),*]
    };
}

/// Numbers of the process but for its ripple.
pub(crate) static PROCESS_COORDINATES: [Coordinate; 7] = of_process! {
    "depth_stiffness_n_m", "N/m";
    "depth_damping_ns_m", "N·s/m";
    "feed_drag_ns_m", "N·s/m";
    "lateral_damping_ns_m", "N·s/m";
    "lateral_stiffness_n_m", "N/m";
    "memory_length_m", "m";
    "lateral_ratio", "1";
};

const fn part(name: &'static str, action: Action) -> Coordinate {
    let kind = EffectKind { id: name, parameters: &PART, action, ..EffectKind::DEFAULT };
    Coordinate { kind, name, unit: "1", drawn: 0.3, given: 0.1, untold: 0.1 }
}

/// Parts of the ripple of one order: axial sine and cosine, in-plane sine and cosine.
pub(crate) static RIPPLE: [Coordinate; 4] = [
    part("ripple.axial.sine", Action::Process(|p, v| p.ripple.push(axial(v, 0.0)))),
    part("ripple.axial.cosine", Action::Process(|p, v| p.ripple.push(axial(v, FRAC_PI_2)))),
    part("ripple.in_plane.sine", Action::Process(|p, v| p.ripple.push(in_plane(v, 0.0)))),
    part("ripple.in_plane.cosine", Action::Process(|p, v| p.ripple.push(in_plane(v, FRAC_PI_2)))),
];

fn axial(v: &[f64], phase: f64) -> Ripple {
    Ripple { order: v[0], axial: v[1], in_plane: 0.0, phase }
}

fn in_plane(v: &[f64], phase: f64) -> Ripple {
    Ripple { order: v[0], axial: 0.0, in_plane: v[1], phase }
}

/// A number that is free.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FreeCoordinate {
    pub coordinate: &'static Coordinate,
    pub at: Location,
    /// Order of the ripple that it is a part of.
    pub order: f64,
    /// False for one that is free only because others hang on it.
    pub told: bool,
}

impl FreeCoordinate {
    pub(crate) fn of_joint(coordinate: &'static Coordinate, joint: usize, told: bool) -> Self {
        Self { coordinate, at: Location::Joint(joint), order: 0.0, told }
    }

    pub(crate) fn of_cell(coordinate: &'static Coordinate) -> Self {
        Self { coordinate, at: Location::Cell, order: 0.0, told: true }
    }

    pub(crate) fn of_order(coordinate: &'static Coordinate, order: f64) -> Self {
        Self { order, ..Self::of_cell(coordinate) }
    }

    /// The effect by which the number is moved.
    pub(crate) fn effect(&self, moved: f64) -> Effect {
        let mut effect = self.coordinate.kind.neutral(self.at);
        if let [order, part] = effect.values.as_mut_slice() {
            (*order, *part) = (self.order, moved);
        } else {
            effect.values.fill(moved);
        }
        effect
    }

    /// What is expected of each of the effect's values, where the number is free: 0 for what is not.
    pub(crate) fn expected(&self, deviation: f64) -> Vec<f64> {
        match self.coordinate.kind.parameters.len() {
            1 => vec![deviation],
            _ => vec![0.0, deviation],
        }
    }

    /// The value that a model has of the number.
    pub(crate) fn value(&self, model: &ModelFile) -> f64 {
        let joints = &model.robot.parameters.joints;
        match self.at {
            Location::Joint(j) if std::ptr::eq(self.coordinate, &STIFFNESS) => joints[j].stiffness,
            Location::Joint(j) => joints[j].damping,
            _ => model.process.as_ref().map_or(f64::NAN, |p| p.number(self.coordinate.name)),
        }
    }
}

/// True for a calibration whose place a coordinate takes: it may be a little off only, and these
/// numbers may be off by a factor.
pub(crate) fn is_replaced(effect: &Effect) -> bool {
    is_calibration(effect.kind) && matches!(effect.kind.action, Action::Robot(_))
}
