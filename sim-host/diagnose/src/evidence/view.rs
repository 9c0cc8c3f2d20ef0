//! What shows each effect: the quantity it acts through and the variables it may follow.

use super::context::{Abscissa, EvidenceContext, Ordinate};
use super::probe::Probe;
use trueweld_core::JOINTS;
use trueweld_estimate::predict::ComparedQuantity;
use trueweld_logs::log::LogKind;
use trueweld_plant::effects::curve::{Curve, CurveAxis, ShownQuantity};
use trueweld_plant::effects::formula::PORTS;
use trueweld_plant::effects::{Effect, Location, Role};
use trueweld_plant::robot::Channel;

/// Longest stretch of a swinging log that is shown as it was, s.
const WINDOW: f64 = 0.4;

/// How rows become points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CurveShape {
    /// In order of the variable, all logs together.
    Curve,
    /// In order of time, of the one log in which the effect does most.
    Loop,
    /// In order of time, of one log, from one time to another, s.
    Trace { log: usize, from: f64, to: f64 },
    /// Amplitudes at the orders of the spindle.
    Orders,
}

impl CurveShape {
    /// True for a row that belongs to the curve.
    pub(crate) fn shows(self, log: usize, x: f64) -> bool {
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
    pub axes: Vec<Abscissa>,
    pub shape: CurveShape,
}

/// Periods of a wave within a joint's range above which it is drawn over one of them.
const FOLDED: f64 = 4.0;

impl View {
    /// How an effect is best shown.
    pub(crate) fn of(effect: &Effect, ctx: &EvidenceContext<'_>) -> Self {
        let (quantities, axes, shape) = match effect.kind.curve {
            Curve::Column => return Self::fallback(effect, ctx),
            Curve::SpindleOrders => {
                return Self { probes: Vec::new(), axes: Vec::new(), shape: CurveShape::Orders };
            }
            Curve::Quantity(quantities, axes) => (quantities, axes, CurveShape::Curve),
            Curve::Loop(quantities, axes) => (quantities, axes, CurveShape::Loop),
        };
        let axes = match axes {
            [] => every_axis(),
            axes => axes.iter().map(|axis| of_effect(*axis, effect, ctx)).collect(),
        };
        Self { probes: quantities.iter().map(|q| probe(q, effect)).collect(), axes, shape }
    }

    /// The column that the effect mends most, over what it follows there; where the links swing, as
    /// it was recorded.
    pub(crate) fn fallback(effect: &Effect, ctx: &EvidenceContext<'_>) -> Self {
        let Some((log, quantity, component)) = most_improved(ctx) else {
            return Self { probes: Vec::new(), axes: Vec::new(), shape: CurveShape::Curve };
        };
        let shown = Ordinate::Column { quantity, component, without: effect.kind.id };
        let probes = vec![Probe::Column { quantity, component, shown }];
        let swings = ctx.problem.logs[log].kind == LogKind::RingDown;
        match window(ctx, log, quantity, component).filter(|_| swings) {
            Some((from, to)) => Self {
                probes,
                axes: vec![Abscissa::Time],
                shape: CurveShape::Trace { log, from, to },
            },
            None => Self { probes, axes: every_axis(), shape: CurveShape::Curve },
        }
    }
}

/// What the quantity of an effect's curve is asked of the data by.
fn probe(quantity: &ShownQuantity, effect: &Effect) -> Probe {
    let named = |name: &'static str, at: Location| {
        Ordinate::Named(name, if let Location::Joint(j) = at { j } else { 0 })
    };
    match *quantity {
        ShownQuantity::Port { port, joint, sign, name } => {
            let unit = PORTS.iter().find(|p| p.name == port).map_or("", |p| p.unit);
            let at = joint.map_or(effect.at, Location::Joint);
            Probe::Port { terms: vec![(port, "1")], at, sign, shown: named(name, at), unit }
        }
        ShownQuantity::Factor { terms, name } => Probe::Port {
            terms: terms.to_vec(),
            at: effect.at,
            sign: 1.0,
            shown: named(name, effect.at),
            unit: "1",
        },
        ShownQuantity::Parameter { index, name } => {
            Probe::Own { parameter: index, shown: named(name, effect.at) }
        }
    }
}

/// The variable that an effect's curve names, of its joint and with its values.
fn of_effect(axis: CurveAxis, effect: &Effect, ctx: &EvidenceContext<'_>) -> Abscissa {
    let j = if let Location::Joint(j) = effect.at { j } else { 0 };
    match axis {
        CurveAxis::Time => Abscissa::Time,
        // A change that has come to its end says nothing more: five time constants.
        CurveAxis::TimeTo { constant } => Abscissa::TimeTo(5.0 * effect.values[constant]),
        CurveAxis::SpringTorque => Abscissa::SpringTorque(j),
        CurveAxis::Angle => {
            let order = effect.kind.parameters.iter().position(|p| p.role == Role::Order);
            let order = order.map_or(1.0, |k| effect.values[k]);
            if order * range(ctx, j) > FOLDED * std::f64::consts::TAU {
                Abscissa::Phase(j, order)
            } else {
                Abscissa::Angle(j)
            }
        }
        CurveAxis::AngleBefore => Abscissa::Angle(j.saturating_sub(1)),
        CurveAxis::AngleOf(j) => Abscissa::Angle(j),
        CurveAxis::Rate => Abscissa::Rate(j),
        CurveAxis::Path => Abscissa::Path,
        CurveAxis::Feed => Abscissa::Feed,
        CurveAxis::AxialForce => Abscissa::AxialForce,
        CurveAxis::PushBySpindle => Abscissa::PushBySpindle,
        CurveAxis::Load => Abscissa::Load,
        CurveAxis::Tool(i) => Abscissa::Tool(i),
        CurveAxis::OfInstrument => match effect.at {
            Location::Channel(Channel::Tracker) => Abscissa::ToolSpeed,
            Location::Channel(Channel::Wrench) => Abscissa::Time,
            _ => Abscissa::Rate(0),
        },
    }
}

fn every_axis() -> Vec<Abscissa> {
    let of_joints = (0..JOINTS)
        .flat_map(|j| [Abscissa::Angle(j), Abscissa::SpringTorque(j), Abscissa::Rate(j)]);
    let of_cell =
        [Abscissa::Time, Abscissa::Path, Abscissa::Feed, Abscissa::AxialForce, Abscissa::Load];
    of_joints.chain(of_cell).collect()
}

/// Range that a joint's angle covers in all logs, rad.
fn range(ctx: &EvidenceContext<'_>, joint: usize) -> f64 {
    let angles = ctx.logs.iter().flat_map(|log| log.samples.encoder.iter().map(|q| q[joint]));
    let (low, high) =
        angles.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), q| (l.min(q), h.max(q)));
    (high - low).max(0.0)
}

/// Log and column whose sum of squares the effect lowers most, calibrations alone set beside it.
fn most_improved(ctx: &EvidenceContext<'_>) -> Option<(usize, ComparedQuantity, u8)> {
    let mut falls: Vec<((usize, ComparedQuantity, u8), f64)> = Vec::new();
    for (log, experiment) in ctx.problem.logs.iter().enumerate() {
        let (null, with) = (&ctx.null[log].residual, &ctx.found.residuals[log].residual);
        for (k, c) in experiment.compared.iter().enumerate() {
            if matches!(c.quantity, ComparedQuantity::Ripple { .. }) {
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

/// The stretch of a log, as a range of time, in which one column shows most of the effect.
fn window(
    ctx: &EvidenceContext<'_>,
    log: usize,
    quantity: ComparedQuantity,
    component: u8,
) -> Option<(f64, f64)> {
    let time = &ctx.logs.get(log)?.samples.time;
    let experiment = &ctx.problem.logs[log];
    let (without, with) = (&ctx.without[log].residual, &ctx.found.residuals[log].residual);
    let (first, last) = (*time.first()?, *time.last()?);
    let windows = ((last - first) / WINDOW).ceil().max(1.0) as usize;
    let mut done = vec![0.0; windows];
    for (k, c) in experiment
        .compared
        .iter()
        .enumerate()
        .filter(|(_, c)| c.quantity == quantity && c.component == component)
    {
        let place = ((time.get(c.row)? - first) / WINDOW) as usize;
        done[place.min(windows - 1)] += (without[k] - with[k]).powi(2);
    }
    let most = (0..windows).max_by(|a, b| done[*a].total_cmp(&done[*b]))? as f64;
    Some((most * WINDOW, (most + 1.0) * WINDOW))
}
