//! Results for programs: one JSON value a command, SI units, units in the names.

mod diagnose;

pub use diagnose::{diagnose_json, improve_json};

use crate::WeldRun;
use serde_json::{Value, json};
use std::path::Path;
use trueweld_evaluate::{FirstLimit, JudgedFigure, Spread, StepFigures};
use trueweld_measure::residuals::compare::{ChannelComparison, Comparison};
use trueweld_measure::residuals::localize::{Finding, Statistic};
use trueweld_plant::provenance::Provenance;

/// The text of a result's file: the result, and what it is of under `provenance`.
pub fn document(mut result: Value, provenance: &Provenance) -> String {
    result["provenance"] = json!(provenance);
    format!("{result:#}\n")
}

/// Figures of welds, schema `weld-result/1`.
pub fn weld_json(runs: &[WeldRun]) -> Value {
    let runs: Vec<Value> = runs
        .iter()
        .map(|run| {
            let (recording, figures) = (run.recording, run.figures);
            json!({
                "weld": recording.weld,
                "controller": recording.controller,
                "compensator": recording.compensator,
                "seed": recording.seed,
                "lateral_m": spread(&figures.lateral),
                "longitudinal_m": spread(&figures.longitudinal),
                "depth_m": spread(&figures.depth),
                "tilt_rad": spread(&figures.tilt),
                "force_n": {
                    "mean": figures.force.mean,
                    "envelope": figures.force.envelope,
                    "error_rms": figures.force.error_rms,
                },
                "joint_share": figures.joint_share.as_slice(),
                "half_pin_m": recording.half_pin,
                "lateral_before_m": figures.lateral_before,
                "limited_rows": figures.limited_rows,
                "first_limit": figures.first_limit.map(first_limit),
                "verdict": if figures.is_met() { "pass" } else { "fail" },
                "judged": figures.judged.iter().map(judged).collect::<Vec<_>>(),
                "simulated_s": recording.simulated,
                "wall_s": recording.wall,
            })
        })
        .collect();
    json!({ "schema": "weld-result/1", "runs": runs })
}

/// Figures of force steps, schema `step-result/1`. A time that was never reached is `null`.
pub fn step_json(controllers: &[StepFigures]) -> Value {
    let controllers: Vec<Value> = controllers
        .iter()
        .map(|figures| {
            json!({
                "name": figures.controller,
                "first_within_5pct_s": figures.first_within_5pct,
                "settle_5pct_s": figures.settle_5pct,
                "overshoot": figures.overshoot,
                "static_error_n": figures.static_error,
                "ripple_n": figures.ripple,
            })
        })
        .collect();
    json!({ "schema": "step-result/1", "controllers": controllers })
}

/// A model against measurements, schema `compare/1`. `model`: where the model was read from.
pub fn compare_json(model: &Path, comparison: &Comparison) -> Value {
    let logs: Vec<Value> = comparison
        .logs
        .iter()
        .map(|log| {
            json!({
                "path": log.path.display().to_string(),
                "name": log.name,
                "kind": log.kind.name(),
                "score": log.score,
                "samples": log.samples,
                "channels": log.channels.iter().map(channel).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({
        "schema": "compare/1",
        "model": model.display().to_string(),
        "score": comparison.score,
        "samples": comparison.samples,
        "logs": logs,
        "worst": comparison.worst.iter().map(finding).collect::<Vec<_>>(),
        "notices": comparison.notices,
    })
}

fn channel(channel: &ChannelComparison) -> Value {
    let mut value = json!({
        "name": channel.name,
        "unit": channel.unit,
        "rmse": channel.rmse,
        "max": channel.max,
        "noise": channel.noise,
        "noise_is": if channel.stated { "stated" } else { "estimated" },
        "score": channel.score,
        "samples": channel.samples,
    });
    if !channel.label.is_empty() {
        value["label"] = channel.label.clone().into();
    }
    if !channel.columns.is_empty() {
        value["columns"] = channel.columns.iter().map(self::channel).collect();
    }
    value
}

/// What a residual goes with: one entry of `worst` in `compare/1`.
pub fn finding(finding: &Finding) -> Value {
    let curve = &finding.curve;
    let column = |of: fn(&trueweld_measure::residuals::localize::CurvePoint) -> f64| {
        curve.points.iter().map(of).collect::<Vec<f64>>()
    };
    json!({
        "kind": finding.kind.name(),
        "channel": finding.channel,
        "logs": finding.logs,
        "score": finding.score,
        "variable": finding.variable,
        "unit": finding.unit,
        "low": finding.low,
        "high": finding.high,
        "category": (!finding.category.is_empty()).then_some(&finding.category),
        "how": match finding.how { Statistic::Mean => "mean", Statistic::Size => "size" },
        "share": finding.share,
        "share_by_chance": finding.by_chance,
        "p": finding.p,
        "share_there": finding.share_there,
        "samples_there": finding.samples_there,
        "similar": finding.similar,
        "sentence": finding.sentence,
        "curve": {
            "x_name": curve.x_name,
            "x_unit": curve.x_unit,
            "categories": curve.categories,
            "y_name": curve.y_name,
            "y_unit": curve.y_unit,
            "x": column(|p| p.x),
            "y": column(|p| p.y),
            "error": column(|p| p.error),
        },
    })
}

/// A figure of a weld against what it is to be.
fn judged(judged: &JudgedFigure) -> Value {
    json!({
        "figure": judged.figure.key,
        "value": judged.value,
        "expected": judged.expected,
        "tolerance": judged.tolerance,
        "met": judged.is_met(),
    })
}

fn first_limit(first: FirstLimit) -> Value {
    json!({
        "time_s": first.time,
        "phase": first.phase.name(),
        "torque": first.limited.torque,
        "force_loop": first.limited.force_loop,
        "compensation": first.limited.compensation,
        "fault": first.fault.map(|fault| format!("{fault:?}")),
    })
}

fn spread(s: &Spread) -> Value {
    json!({ "mean": s.mean, "rms": s.rms, "max_abs": s.max_abs })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;

    #[test]
    fn a_weld_has_its_schema_its_keys_and_its_numbers() {
        let welds = sample::welds(200);
        let value = weld_json(&welds.runs());
        assert_eq!(value["schema"], "weld-result/1");
        let run = &value["runs"][0];
        assert_eq!(run["weld"], "vertical");
        assert_eq!(run["controller"], "external");
        assert_eq!(run["compensator"], "none");
        assert_eq!(run["seed"], 7);
        let figures = &welds.figures[0];
        for (key, spread) in [
            ("lateral_m", figures.lateral),
            ("longitudinal_m", figures.longitudinal),
            ("depth_m", figures.depth),
            ("tilt_rad", figures.tilt),
        ] {
            assert_eq!(run[key]["mean"], spread.mean);
            assert_eq!(run[key]["rms"], spread.rms);
            assert_eq!(run[key]["max_abs"], spread.max_abs);
        }
        assert_eq!(run["force_n"]["mean"], figures.force.mean);
        assert_eq!(run["force_n"]["envelope"], figures.force.envelope);
        assert_eq!(run["force_n"]["error_rms"], figures.force.error_rms);
        assert_eq!(run["joint_share"].as_array().map(Vec::len), Some(6));
        assert_eq!(run["simulated_s"], welds.recordings[0].simulated);
        assert_eq!(run["wall_s"], welds.recordings[0].wall);
        assert_eq!(value["runs"][1]["compensator"], "elastostatic");
    }

    #[test]
    fn a_step_has_its_schema_and_a_null_where_it_never_settles() {
        let mut figures = sample::steps().figures;
        figures[0].settle_5pct = None;
        let value = step_json(&figures);
        assert_eq!(value["schema"], "step-result/1");
        let first = &value["controllers"][0];
        assert_eq!(first["name"], "parallel");
        assert!(first["settle_5pct_s"].is_null());
        assert_eq!(first["overshoot"], figures[0].overshoot);
        assert_eq!(first["static_error_n"], figures[0].static_error);
        assert_eq!(first["ripple_n"], figures[0].ripple);
    }

    #[test]
    fn a_comparison_has_its_schema_its_channels_and_where_it_fails() {
        let value = compare_json(Path::new("model.toml"), &sample::comparison());
        assert_eq!(value["schema"], "compare/1");
        assert_eq!(value["score"], 2.72);
        let log = &value["logs"][0];
        assert_eq!(
            (&log["path"], &log["kind"], &log["score"]),
            (&"campaign/free".into(), &"free-motion".into(), &2.72.into())
        );
        let channel = &log["channels"][0];
        for (key, expected) in [
            ("name", Value::from("tcp_position")),
            ("unit", "m".into()),
            ("rmse", (3e-5 * 2.72).into()),
            ("max", 2e-4.into()),
            ("noise", 3e-5.into()),
            ("noise_is", "stated".into()),
            ("score", 2.72.into()),
        ] {
            assert_eq!(channel[key], expected, "{key}");
        }
        assert_eq!(channel["columns"][0]["name"], "tcp_position[0]");
        let worst = &value["worst"][0];
        assert_eq!(
            (&worst["variable"], &worst["share"]),
            (&"sign of A5's spring torque".into(), &0.62.into())
        );
        assert_eq!(worst["curve"]["y"], json!([0.0, 2e-4]));
    }
}
