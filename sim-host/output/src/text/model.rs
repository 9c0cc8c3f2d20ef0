//! Comments of an improved model file: where each number comes from.

use trueweld_diagnose::FittedEffect;
use trueweld_diagnose::improve::{EffectOrigin, Improvement};
use trueweld_estimate::fit::calibration::is_calibration;
use trueweld_logs::log::Log;
use trueweld_plant::input::{Comments, EffectComments, ModelFile};

/// Comments of the model that `improvement` made of `given` with `logs`. `origins`: of its effects,
/// in order.
pub fn model_comments(
    improvement: &Improvement,
    given: &ModelFile,
    logs: &[Log],
    origins: &[EffectOrigin],
) -> Comments {
    let names = logs.iter().map(|l| l.name.as_str()).collect::<Vec<_>>().join(", ");
    let judged = match improvement.held_out_logs.as_slice() {
        [] => "every tenth of each log, predicted from the rest".to_owned(),
        held_out => held_out.join(", "),
    };
    let (first, last) = (improvement.first(), improvement.last());
    Comments {
        file: format!(
            "Improved by trueweld from {}, fitted to {names}. Score {:.3} before, {:.3} now; where nothing was fitted ({judged}) {:.3} \
             before, {:.3} now. 1.0 is the noise floor.",
            given.path.display(),
            first.score,
            last.score,
            first.held_out,
            last.held_out,
        ),
        posterior: "What the logs leave open of the model's numbers, jointly: `certify --model` draws from it. Every \
                    calibration is free in it, as are friction, the tool's mass and gains of the process. Belongs to these \
                    effects and files: a change of them breaks the seal, `sha256`."
            .to_owned(),
        effects: origins.iter().map(|origin| comments(origin, &names, logs)).collect(),
    }
}

fn comments(origin: &EffectOrigin, names: &str, logs: &[Log]) -> EffectComments {
    match origin {
        EffectOrigin::Given => {
            EffectComments { effect: "As given.".to_owned(), parameters: Vec::new() }
        }
        EffectOrigin::FoundBefore => EffectComments {
            effect: "As given, or by what the model's masses and friction need, before the fit."
                .to_owned(),
            parameters: Vec::new(),
        },
        EffectOrigin::Fitted(found) => {
            let sort = if is_calibration(found.effect.kind) { "Calibration" } else { "Effect" };
            EffectComments {
                effect: format!("{sort}, fitted to {names}; 95 % intervals beside the values."),
                parameters: (0..found.interval.len()).map(|k| bounds(found, k)).collect(),
            }
        }
        EffectOrigin::PerLog(all) => {
            let parameter = |v: usize| {
                let one = |f: &FittedEffect| match f.log {
                    Some(log) => format!("{} in {}", readable(f.effect.values[v]), logs[log].name),
                    None => bounds(f, v),
                };
                all.iter().map(one).collect::<Vec<_>>().join(", ")
            };
            let count = all.first().map_or(0, |f| f.effect.values.len());
            let (shared, scatter) = match all.as_slice() {
                [one] if one.log.is_none() => ("alike in", "95 % interval beside the value"),
                _ => ("fitted to each of", "below the mean"),
            };
            EffectComments {
                effect: format!(
                    "Each log has its own, {shared} {names}; {scatter}. Another log's is fitted to it; what logs differ by stands in \
                     [posterior], between_logs."
                ),
                parameters: (0..count).map(parameter).collect(),
            }
        }
        EffectOrigin::Renewed => EffectComments {
            effect: format!(
                "Each log has its own, nothing to be seen in {names}: the instrument is zeroed at all joints together."
            ),
            parameters: Vec::new(),
        },
    }
}

/// The 95 % interval of a value.
fn bounds(found: &FittedEffect, k: usize) -> String {
    let [low, high] = found.interval[k];
    match found.is_fitted(k) {
        true => format!("{} to {}", readable(low), readable(high)),
        false => "not in the data".to_owned(),
    }
}

fn readable(value: f64) -> String {
    format!("{value:.4e}")
}
