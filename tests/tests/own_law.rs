//! Programs with a law and an effect of their own: the example, and what `trueweld new-law` writes.

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use trueweld_laboratory::{Protocol, Recipe};
use trueweld_plant::input::ModelFile;
use trueweld_tests::{LABORATORY, fixture};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
const EXAMPLE: &str = env!("CARGO_BIN_EXE_trueweld-own-law");

/// A folder with the first 220 mm of the first published weld.
fn workspace() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let text = fs::read_to_string(fixture("welds/vertical.toml")).expect("a weld");
    let end = |line: &str| match line.starts_with("end_m") {
        true => "end_m = [1.700, -0.780, 0.500]\n".to_owned(),
        false => format!("{line}\n"),
    };
    let text: String = text.lines().map(end).collect();
    fs::write(folder.path().join("short.toml"), text).expect("a weld file");
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(EXAMPLE).args(arguments).current_dir(folder).output().expect("it runs")
}

/// Standard output and the JSON of a command that succeeds.
fn done(folder: &Path, arguments: &[&str], json: &str) -> (String, Value) {
    let output = run(folder, arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(folder.join(json)).expect("JSON");
    let json = serde_json::from_str(&text).expect("JSON");
    (String::from_utf8(output.stdout).expect("text"), json)
}

#[test]
fn a_law_of_ones_own_is_compared_beside_the_others() {
    let place = workspace();
    let laws = "own-law,feed-forward,own-law+elastostatic";
    let arguments = ["compare-laws", "-q", "--weld", "short.toml", "--laws", laws];
    let (text, json) =
        done(place.path(), &[&arguments[..], &["--json", "laws.json"]].concat(), "laws.json");
    assert!(text.contains("own-law"), "{text}");
    let names: Vec<_> = json["laws"].as_array().expect("laws").iter().map(|l| &l["name"]).collect();
    assert_eq!(names, laws.split(',').collect::<Vec<_>>());
    // A stiffness believed 20 % too high: feed-forward is off, the seam sensor is not.
    let exact = |law: usize| {
        let noise = &json["sweeps"].as_array().expect("sweeps")[1];
        let point = &noise["results"][law]["points"][2];
        point["lateral_rms_m"].as_f64().unwrap_or_else(|| panic!("{point}"))
    };
    assert!(exact(0) < 0.3 * exact(1), "{} m, feed-forward {} m", exact(0), exact(1));
}

#[test]
fn a_law_of_ones_own_is_certified_with_its_gains() {
    let place = workspace();
    let requirements = r#"
        schema = "requirements/1"
        failure_probability = 0.5
        confidence = 0.75
        [limits]
        lateral_rms_m = 3.0e-4
        [margins]
        places = 3
        gain_margin = 2.0
        modulus_margin = 0.5
        [uncertainty]
        stiffness = 0.1
        process = 0.1
        ripple = 0.5
        crosstalk = 0.01
        delay_periods = [1.0, 2.0]
    "#;
    fs::write(place.path().join("requirements.toml"), requirements).expect("requirements");
    // Feed-forward under the law is to follow slowly enough for drives that friction holds.
    let control = fs::read_to_string(fixture("control/kr500-mt.toml")).expect("gains");
    let control = control.replace("following_rad_s = 6.0", "following_rad_s = 2.0");
    let with = |gains: &str| {
        let text = format!("{control}\n[law.own-law]\n{gains}\n");
        fs::write(place.path().join("control.toml"), text).expect("a control file");
    };
    let arguments = [
        "certify",
        "-q",
        "--compensator",
        "own-law",
        "--weld",
        "short.toml",
        "--requirements",
        "requirements.toml",
        "--control",
        "control.toml",
        "--trials",
        "2",
        "--worst",
        "0",
        "--evidence",
        "evidence",
    ];
    with("rate_rad_s = 1.0");
    let (_, json) = done(place.path(), &arguments, "evidence/certify.json");
    assert_eq!((&json["law"], &json["verdict"]), (&"own-law".into(), &"pass".into()), "{json}");
    with("rate_rads = 1.0");
    let error = String::from_utf8(run(place.path(), &arguments).stderr).expect("text");
    assert!(error.contains("Did you mean `rate_rad_s`?"), "{error}");
    with("rate_rad_s = 0.0");
    let error = String::from_utf8(run(place.path(), &arguments).stderr).expect("text");
    assert!(error.contains("`rate_rad_s`") && error.contains("a number above 0"), "{error}");
}

#[test]
fn an_effect_of_ones_own_is_found_in_logs() {
    // The logs come from an expression in a model file, and not from the example's Rust.
    let model = ModelFile::read(fixture("models/cable-drag.toml")).expect("a model");
    let hidden = model.cell_effects().into_iter().find(|e| e.kind.id == "cable-drag");
    let recipe = Recipe { protocol: Protocol::short(), ..Recipe::plain(3) }
        .with_effect(hidden.expect("the file defines it"));
    let place = workspace();
    LABORATORY.write(&recipe, &place.path().join("campaign")).expect("a campaign");
    let given = fs::read_to_string(place.path().join("campaign/model.toml")).expect("a model");
    assert!(!given.contains("cable-drag"), "{given}");
    let arguments = ["diagnose", "-q", "campaign", "--json", "diagnosis.json"];
    let (text, json) = done(place.path(), &arguments, "diagnosis.json");
    assert_eq!(json["verdict"], "effect-found", "{text}");
    let found = &json["candidates"][0]["effects"];
    assert_eq!(
        (&found[0]["effect"], &found[0]["at"]),
        (&"cable-drag".into(), &"A1".into()),
        "{text}"
    );
    assert!(text.contains("A cable drags on A1"), "{text}");
}

/// A command of cargo on a crate that `new-law` wrote, with the versions of the workspace's lock file.
fn cargo(command: &[&str], folder: &Path) -> Output {
    fs::copy(format!("{ROOT}/Cargo.lock"), folder.join("Cargo.lock")).expect("a lock file");
    let manifest = folder.join("Cargo.toml");
    let output = Command::new(env!("CARGO"))
        .args(command)
        .args(["--quiet", "--offline", "--manifest-path"])
        .arg(manifest)
        .env("CARGO_TARGET_DIR", Path::new(env!("CARGO_TARGET_TMPDIR")).join("new-law"))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

#[test]
fn new_law_writes_the_example_under_another_name() {
    let place = workspace();
    let output = run(place.path(), &["new-law", "my-law"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let written = place.path().join("my-law");
    let example = Path::new(ROOT).join("examples/own-law/src/main.rs");
    let [source, example] = [written.join("src/main.rs"), example]
        .map(|file| fs::read_to_string(file).expect("a source file"));
    assert!(source.contains("\"my-law\""), "{source}");
    assert_eq!(source, example.replace("own-law", "my-law"));
    // Crates of this platform alone: others' are not there where they were never asked for.
    let tree = cargo(&["tree", "--prefix=none"], &written).stdout;
    let tree = String::from_utf8(tree).expect("text");
    for name in ["trueweld-my-law ", "trueweld ", "trueweld-cli "] {
        assert!(tree.lines().any(|line| line.starts_with(name)), "{name}is no crate of it: {tree}");
    }
    for (name, expected) in [
        ("my-law", "cannot make the folder"),
        ("Mine!", "is no name of a law"),
        ("own-law", "there is a law"),
    ] {
        let output = run(place.path(), &["new-law", name]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && error.contains(expected), "{name}: {error}");
    }
}

#[test]
#[ignore = "release checklist: builds all crates once more"]
fn new_law_writes_a_crate_that_builds() {
    let place = workspace();
    run(place.path(), &["new-law", "my-law"]);
    cargo(&["build"], &place.path().join("my-law"));
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("new-law/debug/trueweld-my-law");
    let help = Command::new(program).args(["weld", "--help"]).output().expect("it runs").stdout;
    let help = String::from_utf8(help).expect("text");
    assert!(help.contains("my-law") && !help.contains("own-law"), "{help}");
}
