//! What may be a little off in any cell without anything being missing from the model: stiffness
//! and damping, where encoders were zeroed and a tracker registered, a sensor's zero. Fitted under
//! every hypothesis, reported apart.

use crate::data::log::LogKind;
use crate::fit::{EffectScope, FitProblem, FitState};
use crate::predict::Quantity;
use trueweld_plant::effects::{Effect, EffectKind, Location, Role};

/// One kind of calibration.
struct Calibration {
    id: &'static str,
    /// Expected size of each parameter, one standard deviation.
    expected: &'static [f64],
    /// True where every log has its own.
    each_log: bool,
}

/// Nobody knows a robot's stiffness to better than a tenth, nor its damping to better than a third.
/// What is zeroed or registered anew is good to about what the instruments are.
const CALIBRATIONS: &[Calibration] = &[
    Calibration { id: "stiffness-error", expected: &[0.1], each_log: false },
    Calibration { id: "damping-error", expected: &[0.3], each_log: false },
    Calibration { id: "encoder-offset", expected: &[1e-4], each_log: true },
    Calibration { id: "link-encoder-offset", expected: &[1e-4], each_log: true },
    Calibration {
        id: "tracker-registration",
        expected: &[1e-4, 1e-4, 1e-4, 5e-5, 5e-5, 5e-5],
        each_log: true,
    },
    Calibration { id: "force-offset", expected: &[30.0, 30.0, 30.0], each_log: true },
];

/// True for an effect that is a calibration of what the model has.
pub fn is_calibration(kind: &EffectKind) -> bool {
    CALIBRATIONS.iter().any(|c| c.id == kind.id)
}

/// Expected size of each of a calibration's values, one standard deviation.
pub fn expected(id: &str) -> Vec<f64> {
    CALIBRATIONS.iter().find(|c| c.id == id).map_or(Vec::new(), |c| c.expected.to_vec())
}

/// The library's effect of that name.
///
/// # Panics
/// Where there is none.
pub(crate) fn kind(id: &str) -> &'static EffectKind {
    EffectKind::of(id).unwrap_or_else(|| panic!("no effect {id}"))
}

/// An effect that does nothing yet.
pub(crate) fn nothing(kind: &'static EffectKind, at: Location) -> Effect {
    let value = |p: &trueweld_plant::effects::Parameter| match p.role {
        Role::Size { neutral, .. } => neutral,
        Role::Reciprocal { .. } => p.high,
        Role::Shape(starts) => starts[0],
        Role::Order | Role::SpindleOrder | Role::Wavelength | Role::PathPosition => p.low,
        Role::Phase => 0.0,
    };
    Effect { kind, at, values: kind.parameters.iter().map(value).collect() }
}

/// Places that a kind of effect may be at.
pub(crate) fn places(kind: &EffectKind) -> Vec<Location> {
    use trueweld_plant::effects::LocationKind;
    use trueweld_plant::robot::Channel;
    match kind.place {
        LocationKind::Joint => (0..6).map(Location::Joint).collect(),
        LocationKind::Channel => {
            [Channel::Tracker, Channel::Wrench, Channel::MotorTorque, Channel::LinkEncoder]
                .map(Location::Channel)
                .to_vec()
        }
        LocationKind::Cell => vec![Location::Cell],
    }
}

/// Effects with values of their own in every log of a bench, all free.
pub fn per_log(bench: &FitProblem, effects: &[Effect]) -> FitState {
    let mut point = FitState::empty(bench.experiments.len());
    for effect in effects {
        let expected = match expected(effect.kind.id) {
            none if none.is_empty() => vec![f64::INFINITY; effect.values.len()],
            expected => expected,
        };
        for (log, experiment) in bench.experiments.iter().enumerate() {
            if experiment.concerns(effect) {
                point.add_to_log(log, effect.clone(), &expected);
            }
        }
    }
    point
}

/// The calibrations that these logs can show anything of, all at nothing, after what is fitted
/// afresh in each log anyway.
pub fn calibrations(bench: &FitProblem) -> FitState {
    let mut point = per_log(bench, &bench.per_log);
    let moving =
        bench.experiments.iter().any(|e| matches!(e.kind, LogKind::RingDown | LogKind::FreeMotion));
    // Those in proportion to which the residuals are come first: their slopes are taken once.
    for c in CALIBRATIONS
        .iter()
        .filter(|c| c.each_log)
        .chain(CALIBRATIONS.iter().filter(|c| !c.each_log))
    {
        let kind = kind(c.id);
        for at in places(kind) {
            if c.each_log {
                if bench.per_log.iter().any(|e| (e.kind.id, e.at) == (c.id, at)) {
                    continue;
                }
                for log in 0..bench.experiments.len() {
                    if shows(bench, log, c.id, at) {
                        point.add_to_log(log, nothing(kind, at), c.expected);
                    }
                }
            } else if c.id != "damping-error" || moving {
                point.add(nothing(kind, at), c.expected[0]);
            }
        }
    }
    point
}

/// Free values of a point that belong to one log each: those come first.
pub fn of_logs(point: &FitState) -> usize {
    point.free.iter().filter(|f| matches!(f.of, EffectScope::Log(..))).count()
}

/// True where a log's channels can show a calibration of its own.
fn shows(bench: &FitProblem, log: usize, id: &str, at: Location) -> bool {
    let experiment = &bench.experiments[log];
    let has = |q: Quantity| experiment.compared.iter().any(|c| c.quantity == q);
    let joint = |at: Location| if let Location::Joint(i) = at { i } else { 0 };
    match id {
        "link-encoder-offset" => experiment
            .compared
            .iter()
            .any(|c| c.quantity == Quantity::LinkEncoder && usize::from(c.component) == joint(at)),
        "tracker-registration" => has(Quantity::Position),
        "force-offset" => {
            experiment.kind == LogKind::Weld || experiment.kind == LogKind::StaticLoad
        }
        _ => has(Quantity::Position) || has(Quantity::LinkEncoder),
    }
}
