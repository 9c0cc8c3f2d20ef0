//! Files that go in and out: nothing is overwritten, nothing hangs, nothing is lost without a word.
#![cfg(unix)]

use crate::support::{Workspace, fixture, one_line};
use serde_json::Value;
use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime};

/// A weld of one run, as short as the steady part allows.
const WELD: [&str; 6] = ["weld", "--quiet", "--compensator", "none", "--weld", "short.toml"];

#[test]
fn no_output_overwrites_an_input_or_another_output() {
    let place = Workspace::new();
    let campaign = place.path().join("campaign");
    fs::create_dir_all(campaign.join("static")).unwrap();
    let copy = |name: &str| {
        let from = fixture(&format!("campaigns/backlash/{name}"));
        fs::write(campaign.join(name), fs::read(from).unwrap()).unwrap();
    };
    for name in
        ["model.toml", "robot.toml", "process.toml", "static/log.toml", "static/samples.csv"]
    {
        copy(name);
    }
    let list = "schema = \"campaign/1\"\nmodel = \"model.toml\"\nlogs = [\"static\"]\n";
    fs::write(campaign.join("campaign.toml"), list).unwrap();
    fs::copy(fixture("robots/arm6.urdf"), place.path().join("arm6.urdf")).unwrap();
    symlink("short.toml", place.path().join("link.toml")).unwrap();
    fs::create_dir(place.path().join("sub")).unwrap();

    fs::create_dir(campaign.join("again")).unwrap();
    for name in ["log.toml", "samples.csv"] {
        let text = fs::read_to_string(campaign.join("static").join(name)).unwrap();
        let shorter: Vec<&str> = text.lines().collect();
        let rows = shorter.len() - usize::from(name == "samples.csv");
        fs::write(campaign.join("again").join(name), shorter[..rows].join("\n")).unwrap();
    }
    fs::write(place.path().join("sub/cell.h"), "/* mine */\n").unwrap();

    let input = "it is an input of this command";
    let coupon = fixture("requirements/coupon.toml");
    let cases: &[(&[&str], &str)] = &[
        (&["weld", "--weld", "short.toml", "--json", "short.toml"], input),
        (&["weld", "--weld", "short.toml", "--json", "sub/../short.toml"], input),
        (&["weld", "--weld", "link.toml", "--html", "short.toml"], input),
        (&["step", "--weld", "short.toml", "--html", "link.toml"], input),
        (&["compare-laws", "--weld", "short.toml", "--json", "short.toml"], input),
        (
            &[
                "certify",
                "--compensator",
                "none",
                "--weld",
                "short.toml",
                "--requirements",
                &coupon,
                "--evidence",
                "sub",
                "--json",
                "short.toml",
            ],
            input,
        ),
        (
            &[
                "certify",
                "--compensator",
                "none",
                "--weld",
                "short.toml",
                "--requirements",
                &coupon,
                "--evidence",
                "sub",
                "--json",
                "sub/trials-short.jsonl",
            ],
            "--json: cannot write sub/trials-short.jsonl: --evidence goes there too",
        ),
        (&["check", "short.toml", "--json", "short.toml"], input),
        (&["import-urdf", "arm6.urdf", "--out", "./arm6.urdf"], input),
        (&["compare", "campaign", "--json", "campaign/campaign.toml"], input),
        (&["compare", "campaign", "--json", "campaign/static/samples.csv"], input),
        (
            &["compare", "campaign/static", "campaign/again", "--json", "campaign/again/log.toml"],
            input,
        ),
        (
            &["export-core", "--compensator", "none", "--weld", "short.toml", "--out", "sub"],
            "--out: cannot write sub/cell.h: there is a file that trueweld did not write",
        ),
        (&["diagnose", "campaign", "--html", "campaign/static/log.toml"], input),
        (&["improve", "campaign", "--out", "campaign/campaign.toml"], input),
        (&["improve", "campaign", "--out", "campaign/robot.toml"], input),
        (
            &["weld", "--weld", "short.toml", "--json", "new", "--html", "sub/../new"],
            "--html: cannot write sub/../new: --json goes there too",
        ),
        (
            &["weld", "--weld", "short.toml", "--json", "-", "--html", "-"],
            "--html: cannot write -: --json goes there too",
        ),
        (&["improve", "campaign", "--out", "-"], "--out: cannot write -"),
        (
            &["improve", "campaign", "--out", "short.toml"],
            "--out: cannot write short.toml: there is a file that trueweld did not write",
        ),
        (
            &["tune", "--out", "campaign/robot.toml"],
            "--out: cannot write campaign/robot.toml: there is a file that trueweld did not write",
        ),
    ];
    let bytes = |name: &str| place.bytes(name);
    let before =
        ["short.toml", "arm6.urdf", "campaign/campaign.toml", "campaign/robot.toml"].map(bytes);
    for (arguments, expected) in cases {
        let message = place.refused(arguments);
        assert!(message.contains(expected), "{arguments:?}: {message}");
    }
    let after =
        ["short.toml", "arm6.urdf", "campaign/campaign.toml", "campaign/robot.toml"].map(bytes);
    assert_eq!(before, after);
    // Any number of results may go to a device.
    place.done(&["check", "short.toml", "--json", "/dev/null"]);
}

#[test]
fn json_goes_to_standard_output_alone() {
    let place = Workspace::new();
    let out = place.done(&["check", "short.toml", "--json", "-"]);
    assert_eq!(serde_json::from_str::<Value>(&out).unwrap()["schema"], "check/1");
    let output = place.run(&[&WELD[..], &["--json", "-"]].concat());
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(value["schema"], "weld-result/1");
    assert!(String::from_utf8(output.stderr).unwrap().contains("lateral"), "the text goes there");
}

#[test]
fn a_full_disk_is_an_error_and_a_reader_that_has_gone_is_none() {
    let place = Workspace::new();
    let run = |to: Stdio| {
        Command::new(env!("CARGO_BIN_EXE_trueweld"))
            .args(["import-urdf", &fixture("robots/arm6.urdf")])
            .current_dir(place.path())
            .stdout(to)
            .output()
            .unwrap()
    };
    let full = run(File::options().write(true).open("/dev/full").unwrap().into());
    assert!(!full.status.success());
    let message = String::from_utf8(full.stderr).unwrap();
    assert!(message.contains("cannot write to standard output"), "{message}");
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    assert!(run(writer.into()).status.success());
}

#[test]
fn pipes_devices_and_huge_files_are_refused_at_once() {
    let place = Workspace::new();
    let fifo = place.path().join("fifo");
    assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    let huge = File::create(place.path().join("huge.toml")).unwrap();
    huge.set_len(1 << 40).unwrap();
    let cases = [
        ("fifo", "it is a pipe or a device"),
        ("/dev/zero", "it is a pipe or a device"),
        (".", "it is a folder"),
        ("huge.toml", "it has 1099511627776 bytes, and at most 16777216 are read"),
    ];
    for (file, expected) in cases {
        let all = [&["check", file][..], &["import-urdf", file], &["weld", "--weld", file]];
        // `check` takes folders.
        for arguments in all.iter().skip(usize::from(file == ".")) {
            let output = place.run(arguments);
            let message = one_line(&String::from_utf8(output.stderr).unwrap());
            assert!(!output.status.success() && message.contains(expected), "{message}");
        }
    }
}

#[test]
fn nothing_that_a_terminal_obeys_reaches_it() {
    let place = Workspace::new();
    let name = "a\u{1b}[31m\u{202e}.toml";
    let reaches = |arguments: &[&str]| {
        let output = place.run(arguments);
        let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        assert!(!text.contains(['\u{1b}', '\u{202e}', '\u{7}']), "{text:?}");
        assert!(text.contains("a␛[31m�.toml"), "{text}");
    };
    reaches(&["check", name]);
    reaches(&["weld", "--weld", "short.toml", "--json", &format!("gone/{name}")]);
    fs::write(place.path().join(name), "schema = 1 # \u{202e}\u{7f}\n").unwrap();
    reaches(&["check", name]);
    fs::copy(place.path().join("short.toml"), place.path().join(name)).unwrap();
    reaches(&["check", name]);
}

#[test]
fn an_error_in_a_long_line_shows_what_stands_around_it() {
    let place = Workspace::new();
    let long = "x".repeat(65_534) + " = [1 2]";
    fs::write(place.path().join("long.toml"), &long).unwrap();
    let urdf = fs::read_to_string(fixture("robots/arm6.urdf")).unwrap().replace('\n', " ");
    let urdf = urdf.replace(
        "</robot>",
        &("<!-- ".to_owned() + &"y".repeat(1_200_000) + " --><link name=\"a\"></robot>"),
    );
    fs::write(place.path().join("long.urdf"), urdf).unwrap();
    for (arguments, column) in
        [(["check", "long.toml"], ":1:65539"), (["import-urdf", "long.urdf"], ":1:12")]
    {
        let output = place.run(&arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(!message.contains("panicked") && message.len() < 4000, "{}", message.len());
        assert!(message.contains(column), "{message}");
    }
}

#[test]
fn what_a_killed_run_left_is_removed_by_the_next() {
    let place = Workspace::new();
    let [old, new, other] = [".trueweld-abc123.tmp", ".trueweld-def456.tmp", ".other.tmp"]
        .map(|n| place.path().join(n));
    for file in [&old, &new, &other] {
        fs::write(file, "half").unwrap();
    }
    let yesterday = SystemTime::now() - Duration::from_secs(86_400);
    for file in [&old, &other] {
        File::options().write(true).open(file).unwrap().set_modified(yesterday).unwrap();
    }
    place.done(&["check", "short.toml", "--json", "check.json"]);
    assert!(!old.exists() && new.exists() && other.exists());
}
