//! What shows each effect: the quantity it acts through and the variables it may follow.

use super::Context;
use super::axis::Axis;
use super::curve::window;
use super::probe::Probe;
use crate::data::log::LogKind;
use crate::predict::Quantity;
use crate::residuals::compare::column_label;
use crate::residuals::localize::joint_name;
use trueweld_core::JOINTS;
use trueweld_plant::effects::formula::PORTS;
use trueweld_plant::effects::{Action, Effect, Location, Role};
use trueweld_plant::robot::Channel;

/// How rows become points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// In order of the variable, all logs together.
    Curve,
    /// In order of time, of the one log in which the effect does most.
    Loop,
    /// In order of time, of one log, from one time to another, s.
    Trace { log: usize, from: f64, to: f64 },
    /// Amplitudes at the orders of the spindle.
    Orders,
}

impl Shape {
    /// True for a row that belongs to the curve.
    pub fn shows(self, log: usize, x: f64) -> bool {
        match self {
            Self::Trace { log: own, from, to } => log == own && x >= from && x < to,
            _ => true,
        }
    }
}

/// Quantities and variables in which an effect may show; the pair in which it shows most is drawn.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct View {
    pub probes: Vec<Probe>,
    pub axes: Vec<Axis>,
    pub shape: Shape,
}

/// Periods of a wave within a joint's range above which it is drawn over one of them.
const FOLDED: f64 = 4.0;

impl View {
    /// How an effect is best shown.
    pub fn of(effect: &Effect, ground: &Context<'_>) -> Self {
        let j = if let Location::Joint(j) = effect.at { j } else { 0 };
        let name = ground.logs.first().map_or(String::new(), |log| joint_name(log, j));
        let joint = |port, sign, what: &str| {
            vec![at_port(port, effect.at, sign, what.replace("{}", &name))]
        };
        let cell = |ports: &[&'static str], what: &str| -> Vec<Probe> {
            let axis = |port: &'static str| port.rsplit_once('-').map_or("", |(_, axis)| axis);
            ports
                .iter()
                .map(|port| at_port(port, Location::Cell, 1.0, format!("{what}{}", axis(port))))
                .collect()
        };
        let own = |what: &str| vec![Probe::Own { parameter: 0, y_name: what.replace("{}", &name) }];
        let process = ["process-force-x", "process-force-y", "process-force-z"];
        let along = "more process force along ";
        let scaled = |terms: &[(&'static str, &'static str)], of: &str| {
            let y_name = format!("relative change of {of}");
            vec![Probe::Port {
                terms: terms.to_vec(),
                at: Location::Cell,
                sign: 1.0,
                y_name,
                unit: "1",
            }]
        };
        let forces = [(process[0], "fx"), (process[1], "fy"), (process[2], "fz")];
        let along_seam = || scaled(&forces[..1], "the force along the seam");
        let all_forces = || scaled(&forces, "the process forces");
        // A change that has come to its end says nothing more: five time constants.
        let time = || {
            let constant = effect.kind.parameters.iter().position(|p| p.name == "time_s");
            vec![constant.map_or(Axis::Time, |k| Axis::TimeTo(5.0 * effect.values[k]))]
        };
        let height = || {
            vec![at_port(
                "surface-height",
                Location::Cell,
                1.0,
                "height of the surface towards the tool".to_owned(),
            )]
        };
        let more_twist = "twist of {} beyond the linear spring's";
        let wave = || {
            let order = effect.kind.parameters.iter().position(|p| p.role == Role::Order);
            let order = order.map_or(1.0, |k| effect.values[k]);
            vec![if order * range(ground, j) > FOLDED * std::f64::consts::TAU {
                Axis::Phase(j, order)
            } else {
                Axis::Angle(j)
            }]
        };
        let curve = |probes, axes| Self { probes, axes, shape: Shape::Curve };
        match effect.kind.id {
            "stiffness-error" | "nonlinear-stiffness" | "backlash" => {
                curve(joint("twist", -1.0, more_twist), vec![Axis::SpringTorque(j)])
            }
            "hysteresis" => Self {
                shape: Shape::Loop,
                ..curve(joint("twist", -1.0, more_twist), vec![Axis::SpringTorque(j)])
            },
            "transmission-error" => curve(joint("twist", 1.0, "error of {}'s gear"), wave()),
            "encoder-offset" => curve(
                joint("twist", 1.0, "angle of {} beyond its encoder's"),
                vec![Axis::Angle(j), Axis::SpringTorque(j)],
            ),
            "wrist-coupling" => curve(
                joint("twist", 1.0, "angle of {} beyond its encoder's"),
                vec![Axis::Angle(j.saturating_sub(1))],
            ),
            "link-encoder-offset" | "link-encoder-ripple" => curve(
                joint("link-encoder", 1.0, "what the second encoder of {} reads more"),
                wave(),
            ),
            "joint-friction" | "stribeck" | "asymmetric-friction" => curve(
                joint("motor-friction", 1.0, "more friction torque of {}"),
                vec![Axis::Rate(j)],
            ),
            "counterbalance-loss" => {
                let a2 = ground.logs.first().map_or(String::new(), |log| joint_name(log, 1));
                let probe = at_port(
                    "link-torque",
                    Location::Joint(1),
                    1.0,
                    format!("more torque on the link of {a2}"),
                );
                curve(vec![probe], vec![Axis::Angle(1)])
            }
            "payload-error" => curve(own("mass that the tool has more"), vec![Axis::Angle(4)]),
            "bearing-tilt" => curve(own("compliance of {}'s bearing to tilt"), vec![Axis::Load]),
            "base-compliance" => curve(own("compliance of the base to tilt"), vec![Axis::Load]),
            "tracker-registration" => curve(
                cell(
                    &["tracker-x", "tracker-y", "tracker-z"],
                    "what the tracker reads more along ",
                ),
                (0..3).map(Axis::Tool).collect(),
            ),
            "thermal-drift" => curve(
                cell(&["tool-shift-x", "tool-shift-y", "tool-shift-z"], "drift of the tool along "),
                time(),
            ),
            "force-crosstalk" => curve(
                cell(
                    &["force-sensor-x", "force-sensor-y"],
                    "what the force sensor reads more along ",
                ),
                vec![Axis::AxialForce],
            ),
            "force-offset" => curve(
                cell(
                    &["force-sensor-x", "force-sensor-y", "force-sensor-z"],
                    "what the force sensor reads more along ",
                ),
                vec![Axis::AxialForce],
            ),
            "channel-delay" => {
                let axes = match effect.at {
                    Location::Channel(Channel::Tracker) => vec![Axis::ToolSpeed],
                    Location::Channel(Channel::Wrench) => vec![Axis::Time],
                    _ => vec![Axis::Rate(0)],
                };
                curve(own("lag of the instrument"), axes)
            }
            "process-stiffness-error" => curve(cell(&process[2..], along), vec![Axis::AxialForce]),
            "drag-error" | "feed-power-law" => curve(along_seam(), vec![Axis::Feed]),
            "advancing-side" => curve(cell(&process[1..2], along), vec![Axis::PushBySpindle]),
            "thermal-softening" => curve(all_forces(), time()),
            "material-step" => curve(all_forces(), vec![Axis::Path]),
            "plate-waviness" => curve(height(), vec![Axis::Path]),
            "fixture-compliance" => curve(height(), vec![Axis::AxialForce]),
            "spindle-harmonic" => {
                Self { probes: Vec::new(), axes: Vec::new(), shape: Shape::Orders }
            }
            _ => match effect.kind.action {
                Action::Expression(formula) => {
                    let port = &formula.definition.port;
                    let y_name = match effect.at {
                        Location::Joint(_) => format!("{} ({name})", port.meaning),
                        _ => port.meaning.to_owned(),
                    };
                    curve(vec![at_port(port.name, effect.at, 1.0, y_name)], every_axis())
                }
                _ => Self::fallback(effect, ground),
            },
        }
    }

    /// The column that the effect mends most, over what it follows there; where the links swing, as
    /// it was recorded.
    pub fn fallback(effect: &Effect, ground: &Context<'_>) -> Self {
        let Some((log, quantity, component)) = most_improved(ground) else {
            return Self { probes: Vec::new(), axes: Vec::new(), shape: Shape::Curve };
        };
        let label =
            ground.logs.get(log).map_or(String::new(), |l| column_label(l, quantity, component));
        let read = format!(
            "{}[{label}] beyond what is predicted without {}",
            quantity.channel(),
            effect.kind.id
        );
        let probes = vec![Probe::Column { quantity, component, y_name: read }];
        let swings = ground.bench.experiments[log].kind == LogKind::RingDown;
        match window(ground, log, quantity, component).filter(|_| swings) {
            Some((from, to)) => {
                Self { probes, axes: vec![Axis::Time], shape: Shape::Trace { log, from, to } }
            }
            None => Self { probes, axes: every_axis(), shape: Shape::Curve },
        }
    }
}

/// A constant at one port.
fn at_port(port: &'static str, at: Location, sign: f64, y_name: String) -> Probe {
    let unit = PORTS.iter().find(|p| p.name == port).map_or("", |p| p.unit);
    Probe::Port { terms: vec![(port, "1")], at, sign, y_name, unit }
}

fn every_axis() -> Vec<Axis> {
    let of_joints =
        (0..JOINTS).flat_map(|j| [Axis::Angle(j), Axis::SpringTorque(j), Axis::Rate(j)]);
    let of_cell = [Axis::Time, Axis::Path, Axis::Feed, Axis::AxialForce, Axis::Load];
    of_joints.chain(of_cell).collect()
}

/// Range that a joint's angle covers in all logs, rad.
fn range(ground: &Context<'_>, joint: usize) -> f64 {
    let angles = ground.logs.iter().flat_map(|log| log.samples.encoder.iter().map(|q| q[joint]));
    let (low, high) =
        angles.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), q| (l.min(q), h.max(q)));
    (high - low).max(0.0)
}

/// Log and column whose sum of squares the effect lowers most, calibrations alone set beside it.
fn most_improved(ground: &Context<'_>) -> Option<(usize, Quantity, u8)> {
    let mut falls: Vec<((usize, Quantity, u8), f64)> = Vec::new();
    for (log, experiment) in ground.bench.experiments.iter().enumerate() {
        let (null, with) = (&ground.null[log].residual, &ground.found.at[log].residual);
        for (k, c) in experiment.compared.iter().enumerate() {
            if matches!(c.quantity, Quantity::Ripple { .. }) {
                continue;
            }
            let column = (log, c.quantity, c.component);
            let fall = null[k] * null[k] - with[k] * with[k];
            match falls.iter_mut().find(|(known, _)| *known == column) {
                Some((_, sum)) => *sum += fall,
                None => falls.push((column, fall)),
            }
        }
    }
    falls.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|f| f.0)
}
