//! Units of one type are improved together, and what is not a fleet is refused.

use crate::support::{Workspace, fixture};
use serde_json::Value;
use std::fs;

/// Records loads at rest of a cell whose spring of A2 is not linear, as a campaign of a unit.
fn record(place: &Workspace, unit: &str, seed: &str) {
    record_day(place, (unit, unit), seed);
}

fn record_day(place: &Workspace, (unit, folder): (&str, &str), seed: &str) {
    let day = fs::read_to_string(fixture("protocols/laboratory-day.toml")).unwrap();
    let (loads, _) = day.split_once("[[log]]\nname = \"stop-123\"").unwrap();
    let spring =
        "[[effect]]\nid = \"nonlinear-stiffness\"\nat = \"A2\"\ngain = 0.5\ntwist_rad = 4e-4\n";
    let loads = loads.replace("\"../", &format!("\"{}/", fixture("")));
    fs::write(place.path().join("day.toml"), format!("{loads}\n{spring}")).unwrap();
    place.done(&["record", "day.toml", "--out", folder, "--seed", seed]);
    change(place, folder, "campaign.toml", "model = ", &format!("unit = \"{unit}\"\nmodel = "));
}

fn change(place: &Workspace, folder: &str, file: &str, from: &str, to: &str) {
    let path = place.path().join(folder).join(file);
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{text}");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
}

#[test]
fn two_units_are_laid_beside_each_other_and_none_is_called_the_odd_one() {
    let place = Workspace::new();
    record(&place, "one", "1");
    record(&place, "two", "2");
    record_day(&place, ("two", "two-later"), "12");
    let mut fleet =
        vec!["improve", "one", "two", "--out", "models", "--json", "f.json", "--html", "f.html"];
    fleet.extend(["--held-out", "two-later"]);
    let told = place.done(&fleet);
    assert!(told.contains("Of two units nothing says which is the odd one."), "{told}");
    let value: Value = serde_json::from_slice(&place.bytes("f.json")).unwrap();
    assert_eq!(value["schema"], "improve-fleet/1");
    assert_eq!(value["outliers"], Value::Null);
    for (k, unit) in ["one", "two"].iter().enumerate() {
        assert_eq!(value["units"][k]["unit"], *unit);
        let held_out = value["units"][k]["result"]["held_out"].as_array().unwrap();
        // A unit whose later day is held out is judged by it, the other by its own logs' blocks.
        assert_eq!(!held_out.is_empty(), *unit == "two", "{held_out:?}");
        // The model of a unit is that of its result, and is one that its logs can be compared with.
        place.done(&["compare", "--model", &format!("models/{unit}.toml"), unit]);
    }
    assert!(String::from_utf8(place.bytes("f.html")).unwrap().contains("<table"));
}

#[test]
fn what_is_no_fleet_is_refused_in_a_sentence_that_says_why() {
    let place = Workspace::new();
    for (unit, seed) in [("one", "1"), ("two", "2"), ("three", "3"), ("four", "4"), ("five", "5")] {
        record(&place, unit, seed);
    }
    fs::create_dir(place.path().join("empty")).unwrap();
    change(&place, "three", "campaign.toml", "unit = \"three\"\n", "");
    change(&place, "four", "robot.toml", "name = \"", "name = \"Another ");
    change(&place, "five", "robot.toml", "13.0e6", "13.5e6");
    record(&place, "six", "1");
    record(&place, "seven", "7");
    change(&place, "seven", "campaign.toml", "unit = \"seven\"", "unit = \"../seven\"");
    let cases: &[(&[&str], &[&str])] = &[
        (&["improve", "one", "three"], &["three/campaign.toml", "expected `unit = "]),
        (&["improve", "one", "two", "one/loads"], &["one/loads", "expected `unit = "]),
        (&["improve", "one", "two", "one"], &["one/loads", "given twice"]),
        (&["improve", "one", "two", "empty"], &["empty", "holds neither"]),
        (&["improve", "one", "four"], &["four/loads", "a log of another robot"]),
        (
            &["improve", "one", "five"],
            &["five/model.toml", "its robot differs", "the same numbers"],
        ),
        (&["improve", "one", "six"], &["six/loads", "its rows are those of the log"]),
        (&["improve", "one", "seven"], &["seven/campaign.toml", "letters, digits"]),
        (
            &["improve", "one", "two", "--held-out", "two"],
            &["--held-out two/loads", "also among those to be fitted"],
        ),
        (
            &["improve", "one", "two", "--held-out", "five"],
            &["--held-out five", "the unit five", "one, two"],
        ),
        (&["improve", "one", "two", "--held-out", "one/loads"], &["one/loads", "no unit"]),
        (&["improve", "one", "two", "--samples", "s.csv"], &["--samples: expected none"]),
        (&["improve", "one", "two", "--out", "day.toml"], &["day.toml"]),
        (&["compare", "one", "two"], &["two/campaign.toml", "expected one of one"]),
        (&["diagnose", "one", "two"], &["two/campaign.toml", "expected one of one"]),
    ];
    for (arguments, expected) in cases {
        let out = match arguments {
            ["improve", ..] if !arguments.contains(&"--out") => &["--out", "models"][..],
            _ => &[],
        };
        let message = place.refused(&[arguments, out].concat());
        for words in *expected {
            assert!(message.contains(words), "{arguments:?}: {words} in: {message}");
        }
    }
}
