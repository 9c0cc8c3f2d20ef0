//! Why an effect was found: the curve that the measurements draw of it, beside the curve that it
//! draws itself.
//!
//! Every effect acts through some quantity of the plant: a twist of a joint, a friction torque, a
//! force on the tool. What the data ask of that quantity is found without the effect's form: with s
//! the slope of the residual r, taken without the effect, by a constant at the same port (`probe`),
//! the rows of one stretch of the variable that matters ask for
//!
//! ```text
//! y = −Σ s·r / Σ s²
//! ```
//!
//! The fitted curve is the same projection of what the effect takes away from r. So both stand in
//! the same terms, and no equation of an effect is written a second time. An effect through which
//! nothing can be projected shows the channel that it mends most. The calibrations stay as they
//! were fitted beside the effect. Left out: whether the effect is believed, which is for a
//! diagnosis to say.

mod axis;
mod context;
mod curve;
mod probe;
mod view;

pub use context::{Abscissa, EffectCurve, Ordinate};
pub(crate) use probe::constant;

use context::EvidenceContext;
use curve::BinRow;
use probe::Probe;
use trueweld_estimate::fit::{
    EffectScope, FitProblem, FitState, Fitted, Residuals, Slopes, residuals,
};
use trueweld_logs::log::Log;
use trueweld_plant::effects::Effect;
use view::{CurveShape, View};

/// The curve that shows one effect of a fit.
///
/// `logs` belong to the logs of `problem`, place by place; `null` is the fit with calibrations
/// alone, `found` the one that `effect` was found in. `None` where the logs show nothing of the
/// effect. It costs one prediction of every log without the effect, and one for each quantity that
/// the effect may show in, three at most.
pub fn evidence(
    problem: &FitProblem,
    logs: &[Log],
    null: &Fitted,
    found: &Fitted,
    effect: &Effect,
) -> Option<EffectCurve> {
    let fits = |r: &Residuals| r.len() == logs.len() && problem.logs.len() == logs.len();
    let of = place(&found.point, effect)?;
    let bare = taken_out(&found.point, of);
    let without = residuals(problem, &bare).ok()?;
    if !fits(&without) || !fits(&found.residuals) || !fits(&null.residuals) {
        return None;
    }
    let ctx = EvidenceContext {
        problem,
        logs,
        found,
        of,
        bare: &bare,
        without: &without,
        null: &null.residuals,
    };
    let view = View::of(found.point.effect(of), &ctx);
    draw(&ctx, &view).or_else(|| draw(&ctx, &View::fallback(found.point.effect(of), &ctx)))
}

/// Where a point has the effect.
fn place(point: &FitState, effect: &Effect) -> Option<EffectScope> {
    let is = |e: &Effect| e.place() == effect.place();
    let of_log =
        |log: usize| point.per_log[log].iter().position(is).map(|i| EffectScope::Log(log, i));
    point
        .shared
        .iter()
        .position(is)
        .map(EffectScope::Shared)
        .or_else(|| (0..point.per_log.len()).find_map(of_log))
}

/// The point without that effect, also where every log has it with values of its own.
fn taken_out(point: &FitState, of: EffectScope) -> FitState {
    let own = point.effect(of).place();
    let stays = |e: &Effect| e.place() != own;
    let mut point = point.clone();
    point.shared.retain(stays);
    point.per_log.iter_mut().for_each(|effects| effects.retain(stays));
    // Indices of effects have changed; residuals do not ask for what is free.
    point.free.clear();
    point
}

/// The view's curve, through the quantity and over the variable in which the effect stands out
/// most.
fn draw(ctx: &EvidenceContext<'_>, view: &View) -> Option<EffectCurve> {
    if view.shape == CurveShape::Orders {
        return curve::orders(ctx);
    }
    let mut best: Option<(f64, &Probe, Abscissa, Vec<BinRow>)> = None;
    let slopes: Vec<Option<Slopes>> = view.probes.iter().map(|probe| probe.slopes(ctx)).collect();
    for (k, probe) in view.probes.iter().enumerate() {
        let Some(slopes) = probe::apart(ctx, &slopes, k) else {
            continue;
        };
        for axis in &view.axes {
            let Some(values) = axis.values(ctx) else {
                continue;
            };
            let mut rows = curve::rows(ctx, probe, &slopes, &values, view.shape);
            curve::sort(&mut rows, view.shape);
            let explained = curve::explained(&rows, view.shape);
            if explained > best.as_ref().map_or(0.0, |b| b.0) {
                best = Some((explained, probe, *axis, rows));
            }
        }
    }
    let (_, probe, x, rows) = best?;
    let (points, fitted) = curve::points(&rows, view.shape, probe.sign())?;
    Some(EffectCurve { x, y: probe.shown(), y_unit: probe.y_unit(ctx), points, fitted })
}
