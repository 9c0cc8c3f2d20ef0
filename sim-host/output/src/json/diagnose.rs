//! A diagnosis and an improvement for programs.

use super::finding;
use crate::diagnosed::{Diagnosed, Improved, REMAINS};
use crate::words::effects::explanation;
use serde_json::{Map, Value, json};
use trueweld_measure::diagnose::evidence::EffectCurve;
use trueweld_measure::diagnose::{Candidate, Diagnosis, FittedEffect, Reason};
use trueweld_measure::experiment::Plan;
use trueweld_measure::residuals::compare::LogComparison;
use trueweld_measure::residuals::localize::foremost;
use trueweld_plant::effects::{Effect, EffectKind, Location};
use trueweld_plant::input::RobotFile;

/// A diagnosis, schema `diagnose/1`. `at` is empty for an effect of the whole cell; a bound that
/// the data do not give is `null`.
pub fn diagnose_json(diagnosed: &Diagnosed<'_>) -> Value {
    let Diagnosed { diagnosis, account, .. } = diagnosed;
    let robot = &diagnosed.model.robot;
    let candidates: Vec<Value> = diagnosis
        .candidates
        .iter()
        .enumerate()
        .map(|(k, c)| candidate(c, account.reasons.get(k), diagnosis, robot))
        .collect();
    let limits: Vec<Value> = diagnosis
        .limits
        .iter()
        .map(|limit| {
            let parameter = &limit.kind.parameters[limit.parameter];
            let mut value = place(limit.kind, limit.at, robot);
            value["parameter"] = parameter.name.into();
            value["value"] = json!(limit.value);
            value["unit"] = parameter.unit.into();
            value
        })
        .collect();
    let confusable: Vec<Value> = diagnosis
        .confusable
        .iter()
        .map(|pair| {
            json!({
                "first": place(pair.first.0, pair.first.1, robot),
                "second": place(pair.second.0, pair.second.1, robot),
                "alike": pair.alike,
                "told_apart_from_limit_times": pair.factor(),
            })
        })
        .collect();
    json!({
        "schema": "diagnose/1",
        "model": diagnosed.model.path.display().to_string(),
        "verdict": diagnosis.verdict.name(),
        "sentence": diagnosed.headline(),
        "score_before": diagnosis.score_before,
        "score_calibrated": trueweld_measure::diagnose::score(&diagnosis.null.at),
        "score_after": diagnosed.score_after(),
        "candidates": candidates,
        "calibration": diagnosis.calibration.iter().map(|f| found(f, robot, diagnosed.before)).collect::<Vec<_>>(),
        "next_experiment": account.next_experiment.as_ref().map(plan),
        "unexplained": unexplained(diagnosis),
        "limits": limits,
        "confusable": confusable,
    })
}

/// An improvement, schema `improve/1`.
pub fn improve_json(improved: &Improved<'_>) -> Value {
    let improvement = improved.improvement;
    let robot = &improved.model.robot;
    let all = |list: &[FittedEffect]| {
        list.iter().map(|f| found(f, robot, improved.before)).collect::<Vec<_>>()
    };
    let steps: Vec<Value> = improvement
        .steps
        .iter()
        .map(|step| {
            json!({
                "added": all(&step.added),
                "score": step.score,
                "holdout_score": step.held_out,
                "effects": all(&step.effects),
                "calibration": all(&step.calibration),
            })
        })
        .collect();
    let rejected: Vec<Value> = improvement
        .rejected
        .iter()
        .map(|r| json!({ "added": all(&r.added), "holdout_score": r.held_out, "why": r.why }))
        .collect();
    json!({
        "schema": "improve/1",
        "model": improved.model.path.display().to_string(),
        "out": improved.out.display().to_string(),
        "verdict": improvement.verdict.name(),
        "sentence": improved.headline(),
        "steps": steps,
        "rejected": rejected,
        "held_out": improvement.held_out_logs,
        "unexplained": unexplained(&improvement.diagnosis),
    })
}

fn candidate(
    c: &Candidate,
    reason: Option<&Reason>,
    diagnosis: &Diagnosis,
    robot: &RobotFile,
) -> Value {
    let curves: Vec<Value> = reason
        .iter()
        .flat_map(|r| &r.evidence)
        .map(|e| e.as_ref().map_or(Value::Null, evidence))
        .collect();
    let others: Vec<Value> = c
        .others(&diagnosis.candidates)
        .iter()
        .map(|effect| place(effect.kind, effect.at, robot))
        .collect();
    json!({
        "effects": c.effects.iter().map(|f| found(f, robot, &[])).collect::<Vec<_>>(),
        "holdout_score_before": c.held_out_before,
        "holdout_score_after": c.held_out_after,
        "probability": c.probability,
        "left": c.left,
        "indistinguishable": others,
        "explanation": reason.map_or(String::new(), |reason| {
            explanation(c, &diagnosis.candidates, reason, robot)
        }),
        "evidence": curves.iter().find(|curve| !curve.is_null()).unwrap_or(&Value::Null),
        "evidence_of_effects": curves,
    })
}

/// An effect with its fitted values; the log, where it is of one alone.
fn found(found: &FittedEffect, robot: &RobotFile, logs: &[LogComparison]) -> Value {
    let mut value = place(found.effect.kind, found.effect.at, robot);
    let parameters: Map<String, Value> = found
        .effect
        .kind
        .parameters
        .iter()
        .enumerate()
        .map(|(k, p)| {
            let [low, high] = found.interval[k];
            let one = json!({ "value": found.effect.values[k], "low": low, "high": high, "unit": p.unit });
            (p.name.to_owned(), one)
        })
        .collect();
    value["parameters"] = parameters.into();
    if let Some(log) = found.log.and_then(|log| logs.get(log)) {
        value["log"] = log.name.clone().into();
    }
    value
}

fn place(kind: &'static EffectKind, at: Location, robot: &RobotFile) -> Value {
    let effect = Effect { kind, at, values: Vec::new() };
    json!({ "effect": kind.id, "at": effect.at_name(robot) })
}

fn evidence(e: &EffectCurve) -> Value {
    let column = |of: fn(&trueweld_measure::residuals::localize::CurvePoint) -> f64| {
        e.points.iter().map(of).collect::<Vec<f64>>()
    };
    json!({
        "title": e.title,
        "x_name": e.x_name,
        "x_unit": e.x_unit,
        "y_name": e.y_name,
        "y_unit": e.y_unit,
        "x": column(|p| p.x),
        "y": column(|p| p.y),
        "error": column(|p| p.error),
        "fitted_x": e.fitted.iter().map(|p| p[0]).collect::<Vec<_>>(),
        "fitted_y": e.fitted.iter().map(|p| p[1]).collect::<Vec<_>>(),
    })
}

fn plan(plan: &Plan) -> Value {
    let rows: Vec<Value> = plan
        .rows
        .iter()
        .map(|row| {
            json!({
                "t_s": row.time,
                "encoder_rad": row.encoder,
                "force_n": row.force,
                "moment_nm": row.moment,
                "payload_kg": row.payload,
            })
        })
        .collect();
    json!({
        "kind": plan.kind.name(),
        "title": plan.title,
        "steps": plan.steps,
        "reason": plan.reason,
        "separation": plan.separation,
        "minutes": plan.minutes,
        "rows": rows,
    })
}

fn unexplained(diagnosis: &Diagnosis) -> Vec<Value> {
    foremost(&diagnosis.unexplained, REMAINS).into_iter().map(finding).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;
    use std::path::Path;
    use trueweld_measure::diagnose::Verdict;

    #[test]
    fn a_diagnosis_has_its_schema_its_candidates_and_no_bound_that_is_not_known() {
        let mut parts = sample::diagnosis(Verdict::EffectFound);
        parts.diagnosis.candidates[0].indistinguishable = vec![1];
        parts.account.next_experiment = Some(sample::plan());
        let value = diagnose_json(&parts.diagnosed());
        assert_eq!(
            (&value["schema"], &value["verdict"]),
            (&"diagnose/1".into(), &"effect-found".into())
        );
        assert_eq!(value["score_before"], 3.79);
        let [best, second] = [0, 1].map(|k| &value["candidates"][k]);
        let effect = &best["effects"][0];
        assert_eq!((&effect["effect"], &effect["at"]), (&"backlash".into(), &"A5".into()));
        let gap = &effect["parameters"]["half_gap_rad"];
        assert_eq!((&gap["value"], &gap["unit"]), (&2.4e-4.into(), &"rad".into()));
        assert!(gap["low"].as_f64() < Some(2.4e-4) && gap["high"].as_f64() > Some(2.4e-4));
        assert_eq!(
            (&best["holdout_score_before"], &best["holdout_score_after"]),
            (&3.79.into(), &1.015.into())
        );
        assert_eq!(best["indistinguishable"], json!([{ "effect": "hysteresis", "at": "A5" }]));
        assert_eq!(best["evidence"]["y_unit"], "rad");
        assert_eq!(best["evidence"]["x"].as_array().map(Vec::len), Some(7));
        assert!(second["evidence"].is_null());
        assert!(second["effects"][0]["parameters"]["torque_nm"]["low"].is_null());
        assert_eq!(value["calibration"][0]["log"], "free");
        assert_eq!(value["next_experiment"]["steps"][0], "Hang 20 kg on the flange.");
        assert_eq!(value["unexplained"][0]["share"], 0.62);
        assert_eq!(value["limits"][0]["parameter"], "half_gap_rad");
        parts.account.next_experiment = None;
        assert!(diagnose_json(&parts.diagnosed())["next_experiment"].is_null());
    }

    #[test]
    fn an_improvement_has_its_schema_and_its_steps() {
        let parts = sample::diagnosis(Verdict::EffectFound);
        let improvement = sample::improvement(parts.diagnosis);
        let improved = Improved {
            model: &parts.model,
            out: Path::new("improved.toml"),
            improvement: &improvement,
            before: &parts.before,
            after: &parts.after,
        };
        let value = improve_json(&improved);
        assert_eq!(
            (&value["schema"], &value["verdict"]),
            (&"improve/1".into(), &"effect-found".into())
        );
        let steps = value["steps"].as_array().unwrap();
        assert_eq!((&steps[0]["added"], &steps[0]["score"]), (&json!([]), &3.79.into()));
        assert_eq!(
            (&steps[1]["added"][0]["effect"], &steps[1]["holdout_score"]),
            (&"backlash".into(), &1.07.into())
        );
        assert!(value["rejected"][0]["holdout_score"].is_null());
        assert_eq!(value["held_out"], json!(["weld-3"]));
    }
}
