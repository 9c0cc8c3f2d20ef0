//! A recorded weld that is made again, and a recorded run of a core, from the command line.

use crate::support::{Workspace, fixture, one_line};
use std::fs;

/// The log of a weld with the header of its samples changed, beside the files that it names.
fn log(place: &Workspace, header: impl Fn(&str) -> String) {
    let from = fixture("campaigns/nothing-missing");
    fs::create_dir_all(place.path().join("log")).unwrap();
    for file in ["robot.toml", "process.toml"] {
        fs::copy(format!("{from}/{file}"), place.path().join(file)).unwrap();
    }
    for file in ["log.toml", "weld.toml"] {
        fs::copy(format!("{from}/weld-1/{file}"), place.path().join("log").join(file)).unwrap();
    }
    let rows = fs::read_to_string(format!("{from}/weld-1/samples.csv")).unwrap();
    let (first, rows) = rows.split_once('\n').unwrap();
    let text = format!("{}\n{rows}", header(first));
    fs::write(place.path().join("log/samples.csv"), text).unwrap();
    let path = place.path().join("log/log.toml");
    let noise = fs::read_to_string(&path).unwrap();
    // The noise of columns that are not there may not be stated.
    let kept =
        noise.lines().filter(|line| !line.starts_with("force_n") && !line.starts_with("moment_nm"));
    fs::write(path, kept.collect::<Vec<_>>().join("\n")).unwrap();
}

#[test]
fn a_log_that_cannot_be_welded_again_is_refused_in_a_sentence() {
    let place = Workspace::new();
    let campaign = fixture("campaigns/nothing-missing");
    let cases = [
        (
            format!("{campaign}/free"),
            "a log of the kind \"free-motion\"; expected one of the kind \"weld\"",
        ),
        (format!("{campaign}/static"), "a log of the kind \"static-load\""),
        (campaign, "expected one of the kind \"weld\""),
        ("short.toml".to_owned(), "expected the folder of a log"),
    ];
    for (folder, expected) in cases {
        let told = one_line(&place.refused(&["weld", "--from", &folder]));
        assert!(told.contains(expected), "{folder}: {told}");
    }
    log(&place, |header| header.replace("fx_n", "a").replace("fy_n", "b").replace("fz_n", "c"));
    let told = one_line(&place.refused(&["weld", "--from", "log"]));
    assert!(told.contains("the log has no force columns (fx_n, fy_n, fz_n)"), "{told}");
}

#[test]
fn options_that_mean_nothing_together_are_refused() {
    let place = Workspace::new();
    for with in ["--weld", "--robot", "--process"] {
        let told = place.refused(&["weld", "--from", "log", with, "short.toml"]);
        assert!(told.contains("cannot be used with"), "{with}: {told}");
    }
    for alone in ["--recorded-law", "--recorded-control"] {
        let told = place.refused(&["weld", alone, "none"]);
        assert!(told.contains("--from"), "{alone}: {told}");
    }
    let told = place.refused(&["weld", "--compensator", "none,nothing"]);
    assert!(told.contains("'nothing'"), "{told}");
    let two = ["weld", "--compensator", "none,observer", "--certificate", "certify.json"];
    let told = one_line(&place.refused(&two));
    assert!(told.contains("--compensator names 2 laws; expected one"), "{told}");
}

#[test]
fn a_recorded_weld_is_made_again_beside_its_record() {
    let place = Workspace::new();
    let log = fixture("campaigns/nothing-missing/weld-1");
    let again = ["weld", "-q", "--from", &log, "--compensator", "none,elastostatic"];
    let told = one_line(&place.done(&[&again[..], &["--json", "weld.json"]].concat()));
    for said in
        ["The recorded weld left the seam by up to", "Not taken from it", "recorded replayed"]
    {
        assert!(told.contains(said), "{said}: {told}");
    }
    let weld = place.json("weld.json");
    let number = |pointer: &str| weld.pointer(pointer).and_then(|v| v.as_f64()).unwrap();
    let bent = number("/from_log/check/recorded/bent_m/rms");
    // The plant that made this log is another program's, with the effects of the model: none.
    assert!(number("/from_log/check/lateral_apart_m/rms") < 0.1 * bent, "{}", weld["from_log"]);
    assert_eq!(weld["from_log"]["disturbance"][2]["taken"], false);
    assert_eq!(weld["runs"].as_array().unwrap().len(), 2);
}

#[test]
fn a_run_of_a_core_is_compared_from_its_files() {
    let place = Workspace::new();
    let export = |law: &str, out: &str| {
        let log = format!("{out}-log");
        let files = ["--out", out, "--log", &log, "--weld", "short.toml"];
        place.done(&[&["export-core", "--compensator", law][..], &files].concat());
    };
    export("elastostatic", "core");
    let told = place.done(&["replay", "core", "core-log", "--json", "replay.json"]);
    assert!(told.contains("Equal to the last bit"), "{told}");
    crate::support::assert_valid(&place.bytes("replay.json"));
    // Outputs of another period.
    let outputs = place.path().join("core-log/outputs.bin");
    let mut bytes = fs::read(&outputs).unwrap();
    bytes[300 * 104 + 8 + 8 + 3] ^= 1;
    fs::write(&outputs, &bytes).unwrap();
    let output = place.run(&["replay", "core/cell.h", "core-log"]);
    assert_eq!(output.status.code(), Some(1));
    let told = one_line(&String::from_utf8(output.stdout).unwrap());
    assert!(
        told.contains("The first difference is in period 300") && told.contains("torque of A2"),
        "{told}"
    );
    fs::write(&outputs, &bytes[..bytes.len() - 8]).unwrap();
    let told = one_line(&place.refused(&["replay", "core", "core-log"]));
    assert!(told.contains("outputs.bin: it ends within period"), "{told}");
    let header = place.path().join("core/cell.h");
    let text = fs::read_to_string(&header).unwrap();
    fs::write(&header, text.replacen("/* mass */ 558.0", "/* mass */ 559.0", 1)).unwrap();
    let told = one_line(&place.refused(&["replay", "core", "core-log"]));
    assert!(told.contains("its numbers are not those of its digest"), "{told}");
}
