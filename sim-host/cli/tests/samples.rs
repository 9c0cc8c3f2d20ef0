//! `--samples`: the table that other programs read is what the figures are made of.

use crate::support::{Workspace, fixture};
use serde_json::Value;
use std::collections::BTreeMap;

/// The fields of a line; a comma between quotes separates nothing.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    for (k, part) in line.split('"').enumerate() {
        let mut pieces = part.split(|c| c == ',' && k % 2 == 0);
        let last = fields.len() - 1;
        fields[last] += pieces.next().unwrap_or_default();
        fields.extend(pieces.map(str::to_owned));
    }
    fields
}

/// The columns of a CSV file, by their names.
fn columns(place: &Workspace, file: &str) -> BTreeMap<String, Vec<String>> {
    let text = String::from_utf8(place.bytes(file)).unwrap();
    let mut lines = text.lines().map(fields);
    let mut columns: Vec<(String, Vec<String>)> =
        lines.next().unwrap().into_iter().map(|name| (name, Vec::new())).collect();
    for fields in lines {
        assert_eq!(fields.len(), columns.len());
        columns.iter_mut().zip(fields).for_each(|((_, column), field)| column.push(field));
    }
    columns.into_iter().collect()
}

fn numbers(column: &[String]) -> Vec<f64> {
    column.iter().map(|field| field.parse().unwrap_or(f64::NAN)).collect()
}

#[test]
fn residuals_over_their_noise_are_the_score() {
    let place = Workspace::new();
    let campaign = fixture("campaigns/backlash");
    let (model, log) = (format!("{campaign}/model.toml"), format!("{campaign}/static"));
    let all = ["--model", &model, &log, "-q", "--json", "c.json", "--samples", "c.csv"];
    let said = place.done(&[&["compare"][..], &all].concat());
    assert!(said.contains("wrote c.csv"), "{said}");
    let of = columns(&place, "c.csv");
    let [measured, predicted, residual, noise] =
        ["measured", "predicted", "residual", "noise"].map(|name| numbers(&of[name]));
    let count = residual.len();
    let square = |k: usize| (residual[k] / noise[k]).powi(2);
    let score = ((0..count).map(square).sum::<f64>() / count as f64).sqrt();
    let value = place.json("c.json");
    // The same sum in another order.
    assert!((score / value["score"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{score}");
    assert_eq!(value["samples"], count);
    // Each is rounded once.
    let rounding = |k: usize| f64::EPSILON * (measured[k].abs() + predicted[k].abs());
    assert!((0..count).all(|k| (measured[k] - predicted[k] - residual[k]).abs() <= rounding(k)));
    for (name, word) in [("model", "given"), ("log", "static"), ("kind", "static-load")] {
        assert!(of[name].iter().all(|field| field == word), "{name}");
    }
}

#[test]
fn a_weld_is_there_signal_by_signal() {
    let place = Workspace::new();
    let all = ["weld", "--weld", "short.toml", "-q", "--json", "w.json", "--samples", "w.csv"];
    place.done(&all);
    let of = columns(&place, "w.csv");
    let value = place.json("w.json");
    for run in value["runs"].as_array().unwrap() {
        let picked: Vec<usize> = (0..of["law"].len())
            .filter(|k| run["compensator"] == of["law"][*k].as_str() && of["phase"][*k] == "steady")
            .collect();
        let largest = |name: &str| {
            let column = numbers(&of[name]);
            picked.iter().map(|k| column[*k].abs()).fold(0.0, f64::max)
        };
        let figure = |name: &str| run[name]["max_abs"].as_f64().unwrap();
        assert_eq!(largest("deviation_lateral_m"), figure("lateral_m"));
        assert_eq!(largest("deviation_depth_m"), figure("depth_m"));
        assert_eq!(largest("tilt_rad"), figure("tilt_rad"));
        assert!(largest("torque_a2_nm") > 0.0 && largest("force_z_n") > 15_000.0);
    }
    // Before the force loop is closed no push is asked for.
    assert_eq!(of["push_desired_n"][0], "");
}

#[test]
fn steps_laws_and_certificates_are_tables_too() {
    let place = Workspace::new();
    place.done(&["step", "--weld", "short.toml", "-q", "--samples", "s.csv"]);
    let of = columns(&place, "s.csv");
    for controller in ["parallel", "superposed", "external"] {
        assert!(of["controller"].iter().any(|field| field == controller), "{controller}");
    }
    let laws = ["compare-laws", "--weld", "short.toml", "--laws", "none", "-q"];
    let more = ["--html", "l.html", "--json", "l.json", "--samples", "l.csv"];
    place.done(&[&laws[..], &more].concat());
    let value = place.json("l.json");
    let points = |sweep: &Value| sweep["results"][0]["points"].as_array().unwrap().clone();
    let all: Vec<f64> = value["sweeps"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(points)
        .map(|point| point["lateral_rms_m"].as_f64().unwrap())
        .collect();
    assert_eq!(numbers(&columns(&place, "l.csv")["lateral_rms_m"]), all);
}

#[test]
fn what_cannot_be_written_is_refused_before_anything_is_read() {
    let place = Workspace::new();
    let campaign = fixture("campaigns/backlash");
    let commands: [&[&str]; 9] = [
        &["weld", "--weld", "gone.toml"],
        &["step", "--weld", "gone.toml"],
        &["compare-laws", "--weld", "gone.toml"],
        &["certify", "--compensator", "none", "--weld", "gone.toml", "--evidence", "e"],
        &["compare", "gone"],
        &["diagnose", "gone"],
        &["improve", "gone", "--out", "improved.toml"],
        &["check", "gone.toml"],
        &["import-urdf", "gone.urdf"],
    ];
    for command in commands {
        let all: &[&str] = match command[0] {
            "check" => &["--json"],
            "import-urdf" => &["--out"],
            "compare-laws" | "certify" => &["--json", "--html", "--samples"],
            _ if cfg!(feature = "rerun") => &["--json", "--html", "--samples", "--rrd"],
            _ => &["--json", "--html", "--samples"],
        };
        for flag in all {
            // No process writes files there, whoever runs it.
            for (target, why) in
                [("/proc/x.csv", "cannot be written into"), ("absent/x.csv", "there is none")]
            {
                let message = place.refused(&[command, &[flag, target]].concat());
                let expected = format!("{flag}: cannot write {target}: ");
                assert!(message.contains(&expected) && message.contains(why), "{message}");
            }
        }
    }
    for (flag, target) in [("--evidence", "/proc/e"), ("--evidence", "short.toml/e")] {
        let all = ["certify", "--compensator", "none", "--weld", "gone.toml", flag, target];
        let message = place.refused(&all);
        assert!(message.contains(&format!("{flag}: cannot write {target}: ")), "{message}");
    }
    let message = place.refused(&["improve", &campaign, "--out", "/proc/improved.toml"]);
    assert!(message.contains("--out: cannot write /proc/improved.toml: "), "{message}");
    let message = place.refused(&["compare", "gone", "--samples", "samples.txt"]);
    assert!(message.contains("expected a name that ends in .csv or .parquet"), "{message}");
}
