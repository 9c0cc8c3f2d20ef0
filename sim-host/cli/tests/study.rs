//! Studies from the command line.

use crate::support::Workspace;
use std::fs;

/// Requirements that call the stiffness uncertain and nothing else.
fn workspace() -> Workspace {
    let place = Workspace::new();
    place.requirements(|key, _| {
        let none = ["process", "ripple", "crosstalk"].contains(&key);
        match key {
            "delay_periods" => Some("delay_periods = [1.0, 1.0]\n".to_owned()),
            _ if none => Some(format!("{key} = 0.0\n")),
            _ => None,
        }
    });
    place
}

const SWEEP: [&str; 9] = [
    "study",
    "sensitivity",
    "--weld",
    "short.toml",
    "--requirements",
    "requirements.toml",
    "--rows",
    "8",
    "-q",
];

#[test]
fn shards_of_a_study_make_the_bytes_of_one_on_any_number_of_threads() {
    let place = workspace();
    let with = |more: &[&'static str]| [&SWEEP[..], more].concat();
    let one = with(&["--evidence", "one", "--json", "one.json", "--html", "one.html"]);
    let output = place.run_with(&one, &[("RAYON_NUM_THREADS", "1")]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    place.done(&with(&["--evidence", "a", "--shard", "1/2"]));
    let refused =
        place.refused(&with(&["--evidence", "all", "--merge", "a", "--html", "all.html"]));
    assert!(refused.contains("1 of 2 shards not given"), "{refused}");
    place.done(&with(&["--evidence", "b", "--shard", "2/2"]));
    let merge =
        ["--evidence", "all", "--merge", "a", "b", "--json", "all.json", "--html", "all.html"];
    place.done(&with(&merge));
    assert!(place.bytes("one.json") == place.bytes("all.json"));
    assert!(place.bytes("one.html") == place.bytes("all.html"));
    for name in ["runs.jsonl", "manifest.json"] {
        assert!(
            place.bytes(&format!("one/{name}")) == place.bytes(&format!("all/{name}")),
            "{name}"
        );
    }
    // Cut off in the middle, it goes on and ends with the same bytes.
    let whole = place.bytes("one/runs.jsonl");
    fs::write(place.path().join("one/runs.jsonl"), &whole[..whole.len() / 2]).unwrap();
    place.done(&one);
    assert!(place.bytes("one/runs.jsonl") == whole);
    // What was made with other options is not taken.
    let mut other = with(&["--evidence", "one", "--html", "other.html"]);
    other[7] = "9";
    assert!(place.refused(&other).contains("runs of something else"));
    other[9..11].copy_from_slice(&["--evidence", "c"]);
    let merged = [&other[..], &["--merge", "a", "b"]].concat();
    let refused = place.refused(&merged);
    assert!(
        refused.contains("shard 1/2 is of something else: made by `study sensitivity"),
        "{refused}"
    );
    let json = place.json("one.json");
    // Six stiffnesses and the phases of the ripple, and the two matrices of the design.
    assert_eq!(json["runs"], 8 * (7 + 2));
    let first = &json["figures"][0]["indices"][0];
    assert!(first["input"].as_str().unwrap().starts_with("stiffness."), "{first}");
}

#[test]
fn what_cannot_be_studied_is_refused_with_one_error() {
    let place = workspace();
    let refused = |arguments: &[&str], why: &str| {
        let message = place.refused(arguments);
        assert!(message.contains(why), "{arguments:?}: {message}");
    };
    for grid in ["1.4:2.4:-0.1", "2:1:0.1", "1:2", "1:2:0", "nan", "1:2:5"] {
        refused(&["study", "layout", "--x", grid], "expected VALUE, or LOW:HIGH:STEP");
    }
    // With a name for the page: else the folder for it is made before the grid is looked at.
    let own = ["study", "layout", "--weld", "short.toml", "--html", "page.html"];
    let one = [&own[..], &["--x", "1.7", "--z", "0.5", "--turn", "0"]].concat();
    refused(&one, "leave one placement; expected several");
    let far = [&own[..], &["--x", "5:6:0.5", "--z", "0.5", "--turn", "0"]].concat();
    refused(&far, "none of the 3 placements is reached along the whole seam");
    let many = [&own[..], &["--x", "1:2:0.0001", "--z", "0:1:0.001"]].concat();
    refused(&many, "expected at most 2000000");
    refused(&[&own[..], &["--allow", "torque"]].concat(), "expected FIGURE=VALUE");
    refused(&[&own[..], &["--allow", "torque_share=-1"]].concat(), "expected a number above 0");
    refused(&[&own[..], &["--allow", "torke=1"]].concat(), "there is no such figure");
    refused(&[&own[..], &["--front", "mass"]].concat(), "there is no such figure");
    let limits = ["study", "limits", "--weld", "short.toml", "--requirements", "requirements.toml"];
    let limits = [&limits[..], &["--html", "page.html"]].concat();
    refused(
        &[&limits[..], &["--most-force", "-1"]].concat(),
        "--most-force -1: expected a number above",
    );
    refused(
        &[&limits[..], &["--length", "0.001"]].concat(),
        "--length 0.001: expected a number of metres",
    );
    refused(&[&limits[..], &["--x", "5:6:0.5"]].concat(), "none of the 3 places is reached");
    let sweep = ["study", "sensitivity", "--weld", "short.toml"];
    refused(&[&sweep[..], &["--length", "nan"]].concat(), "expected a number of metres");
    refused(&[&sweep[..], &["--rows", "1"]].concat(), "1 is not in 8..=100000");
    refused(&[&sweep[..], &["--shard", "1/2"]].concat(), "--evidence");
    let shard = ["--shard", "1/2", "--evidence", "e", "--json", "j.json"];
    refused(&[&sweep[..], &shard].concat(), "shard 1/2 has no result yet");
}

#[test]
fn a_reserve_that_no_placement_keeps_is_named_beside_the_deviation() {
    let place = workspace();
    let family = ["--x", "1.5:1.9:0.2", "--z", "0.5", "--turn", "0", "--allow", "torque_share=0.1"];
    let layout = ["study", "layout", "--weld", "short.toml", "--compensator", "none", "-q"];
    let told = place.done(&[&layout[..], &family, &["--html", "page.html"]].concat());
    let told = told.split_whitespace().collect::<Vec<_>>().join(" ");
    let headline = told.split_once(" By full runs").map_or("", |(headline, _)| headline);
    assert_eq!(headline.matches("; not kept: torque, largest share)").count(), 2, "{told}");
}

#[test]
fn a_part_of_two_seams_is_placed_and_confirmed() {
    let place = workspace();
    place.weld("other.toml", "[1.800, -1.000, 0.500]", "[1.800, -0.940, 0.500]");
    let family = ["--x", "1.5:1.9:0.2", "--z", "0.5:0.7:0.1", "--turn", "0"];
    let both = ["study", "layout", "--weld", "short.toml", "--weld", "other.toml", "-q"];
    let out =
        ["--compensator", "none", "--json", "l.json", "--html", "l.html", "--samples", "l.csv"];
    let told = place.done(&[&both[..], &family, &out].concat());
    assert!(told.starts_with("The part is best put at "), "{told}");
    let json = place.json("l.json");
    assert_eq!((&json["placements"], &json["reached"]), (&9.into(), &9.into()));
    let chosen = &json["chosen"];
    assert_eq!(chosen["welds"].as_array().unwrap().len(), 2);
    let lateral =
        |of: &serde_json::Value| of["statics"]["figures"]["lateral_max_m"].as_f64().unwrap();
    assert!(lateral(chosen) <= lateral(&json["filed"]), "{json}");
    let samples = fs::read_to_string(place.path().join("l.csv")).unwrap();
    assert_eq!(samples.lines().count(), 1 + 9);
    let page = fs::read_to_string(place.path().join("l.html")).unwrap();
    // A map for the share and for every figure, and three plots.
    assert_eq!(page.matches("<svg").count(), 11 + 3);
}

#[test]
fn limits_that_nothing_keeps_are_said_to_be_so() {
    let place = workspace();
    place.requirements(|key, _| {
        (key == "lateral_max_m").then(|| "lateral_max_m = 1e-9\n".to_owned())
    });
    let told = place.done(&[
        "study",
        "limits",
        "--weld",
        "short.toml",
        "--requirements",
        "requirements.toml",
        "--what",
        "force",
        "-q",
        "--json",
        "j.json",
        "--html",
        "l.html",
    ]);
    assert!(told.starts_with("No push keeps the requirements."), "{told}");
    assert!(place.json("j.json")["places"][0]["limits"][0]["largest"].is_null());
}
