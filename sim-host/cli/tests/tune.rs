//! Gains for a robot, from the command line.

use crate::support::{Workspace, assert_valid, fixture};
use std::fs;

/// Margins that the gains to begin with keep or not, at both ends of the short weld.
fn workspace(gain_margin: &str) -> Workspace {
    let place = Workspace::new();
    let text = fs::read_to_string(fixture("requirements/lap-weld.toml")).unwrap();
    let (before, rest) = text.split_once("[margins]").unwrap();
    let (_, after) = rest.split_once("[faults]").unwrap();
    let margins = format!("[margins]\nplaces = 2\ngain_margin = {gain_margin}\n");
    let text = format!("{before}{margins}\n[faults]{after}");
    fs::write(place.path().join("requirements.toml"), text).unwrap();
    place
}

#[test]
fn gains_that_the_runs_do_not_confirm_are_said_to_be_so_and_end_with_status_1() {
    let place = workspace("1.01");
    let control = fixture("control/kr500-mt.toml");
    let arguments = |out: &'static str| {
        let asked = ["tune", "--weld", "short.toml", "--requirements", "requirements.toml", "-q"];
        let begin = ["--control", &control, "--height", "11000", "--overshoot", "0.3"];
        let all = [&asked[..], &begin, &["--out", out]].concat();
        all.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let run = |out: &'static str, more: &[&str]| {
        let all = arguments(out);
        let all: Vec<&str> = all.iter().map(String::as_str).chain(more.iter().copied()).collect();
        place.run(&all)
    };
    // What the gains to begin with reach is asked for: the force loop stays as it is.
    let output = run("kept.toml", &["--settle", "0.9", "--json", "kept.json"]);
    let told = String::from_utf8(output.stdout).unwrap();
    let text = fs::read_to_string(place.path().join("kept.toml")).unwrap();
    let gains = |text: &str, key: &str| {
        let line = text.lines().rev().find(|line| line.starts_with(key)).unwrap().to_owned();
        line.split_once(" = ").unwrap().1.split(" #").next().unwrap().trim().parse::<f64>().unwrap()
    };
    let start = fs::read_to_string(&control).unwrap();
    for key in ["force_ki_m_ns", "tuned_stiffness_n_m"] {
        assert_eq!(gains(&text, key), gains(&start, key), "{key}");
    }
    let json = place.json("kept.json");
    assert_valid(&place.bytes("kept.json"));
    let confirmed = json["confirmed"].as_bool().unwrap();
    assert_eq!(output.status.code(), Some(i32::from(!confirmed)), "{told}");
    assert_eq!(text.contains("NOT CONFIRMED"), !confirmed, "{text}");
    assert_eq!(told.contains("NOT CONFIRMED"), !confirmed, "{told}");
    let controllers = json["controllers"].as_array().unwrap();
    let confirmed = |name| controllers.iter().any(|c| c["name"] == name && c["confirmed"] == true);
    // Superposed control comes to rest a little later than asked for.
    assert!(confirmed("parallel") && confirmed("external"), "{told}");
    assert!(place.done(&["check", "kept.toml"]).contains("in order"));

    // No controller answers within two periods.
    let output = run("fast.toml", &["--settle", "0.024", "--json", "fast.json"]);
    let told = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("NOT CONFIRMED") && told.contains("(asked 24 ms)"), "{told}");
    let text = fs::read_to_string(place.path().join("fast.toml")).unwrap();
    assert!(text.contains("# NOT CONFIRMED. "), "{text}");
    let json = place.json("fast.json");
    assert_eq!(json["confirmed"], false);
    assert!(json["limits"][0].as_str().unwrap().contains("step within 5 %"), "{json}");
    // It is a control file all the same, and names what it is of.
    assert!(place.done(&["check", "fast.toml"]).contains("in order"));
    assert!(text.contains("robot: embedded robots/kr500-mt.toml, sha256 "), "{text}");
}

#[test]
fn what_cannot_be_asked_of_a_step_is_refused() {
    let place = workspace("2.0");
    for (flag, value) in [("--settle", "0"), ("--overshoot", "2"), ("--height", "0")] {
        let message = place.refused(&["tune", flag, value, "--out", "control.toml"]);
        assert!(
            message.contains(&format!("{flag} {value}: expected a number above 0")),
            "{message}"
        );
    }
    fs::write(place.path().join("none.toml"), {
        let text = fs::read_to_string(place.path().join("requirements.toml")).unwrap();
        let (before, rest) = text.split_once("[margins]").unwrap();
        format!("{before}[faults]{}", rest.split_once("[faults]").unwrap().1)
    })
    .unwrap();
    let message = place.refused(&["tune", "--requirements", "none.toml", "--out", "control.toml"]);
    assert!(message.contains("the requirements ask for no margins"), "{message}");
}
