//! Rare failures by subset simulation, beside plain draws.

use crate::support::{Workspace, requirements};
use serde_json::Value;
use std::fs;

const CERTIFY: [&str; 12] = [
    "certify",
    "--compensator",
    "seam-tracking",
    "--weld",
    "short.toml",
    "--requirements",
    "r.toml",
    "--worst",
    "0",
    "-q",
    "--evidence",
    "kept",
];

fn arguments<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&CERTIFY[..], more].concat()
}

fn of_case<'a>(certificate: &'a Value, case: &str) -> Vec<&'a Value> {
    let requirements = certificate["requirements"].as_array().unwrap();
    requirements.iter().filter(|r| r["case"] == case).collect()
}

#[test]
fn rare_failures_begin_with_the_draws_and_go_on_where_they_were_stopped() {
    let place = Workspace::new();
    fs::write(place.path().join("r.toml"), requirements(0.05, 0.95, 1.5e-4)).unwrap();
    place.run(&arguments(&["--trials", "100"]));
    let plain = place.json("kept/certify.json");
    assert!(of_case(&plain, "rare").is_empty());
    let asked = arguments(&["--trials", "100", "--failure-probability", "1e-2"]);
    place.run(&asked);
    let certificate = place.json("kept/certify.json");
    assert_eq!(of_case(&certificate, "draws"), of_case(&plain, "draws"));
    let rare = &certificate["welds"][0]["rare"];
    let levels = rare["levels"].as_array().unwrap();
    assert_eq!(rare["runs"].as_u64().unwrap() as usize, 90 * (levels.len() - 1), "{rare}");
    let product: f64 = levels.iter().map(|level| level["share"].as_f64().unwrap()).product();
    assert!((rare["probability"].as_f64().unwrap() - product).abs() < 1e-12 && product > 0.0);
    // Of the plain draws as many are beyond as the bounds allow.
    let [judged] = of_case(&certificate, "rare")[..] else { panic!("{certificate}") };
    let bound = judged["failure_probability"].as_f64().unwrap();
    assert!(bound >= product && judged["limit"] == 1.0, "{judged}");
    let beyond = of_case(&plain, "draws")[0]["beyond"].as_u64().unwrap();
    assert!(beyond < 10 || product > 0.03, "{beyond} of 100, {product}");

    let whole = place.bytes("kept/rare-short.jsonl");
    let lines = whole.iter().filter(|byte| **byte == b'\n').count();
    assert_eq!(lines, 1 + 90 * (levels.len() - 1));
    if lines > 1 {
        // As after an interruption: half of the runs, and a piece of a line.
        fs::write(place.path().join("kept/rare-short.jsonl"), &whole[..whole.len() / 2]).unwrap();
        place.run(&asked);
        assert_eq!(place.bytes("kept/rare-short.jsonl"), whole);
        assert_eq!(place.json("kept/certify.json"), certificate);
    }
}

#[test]
fn what_cannot_be_shown_is_refused() {
    let place = Workspace::new();
    fs::write(place.path().join("r.toml"), requirements(0.05, 0.95, 1.5e-4)).unwrap();
    let told = place.refused(&arguments(&["--trials", "99", "--failure-probability", "1e-4"]));
    assert!(told.contains("expected --trials 100 or more"), "{told}");
    for wrong in ["0", "0.7", "nan", "-1e-3", "rarely"] {
        let option = format!("--failure-probability={wrong}");
        let told = place.refused(&arguments(&[&option]));
        assert!(told.contains("expected a"), "{told}");
    }
}
