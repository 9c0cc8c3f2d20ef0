//! Certifications made in parts on several machines.

use crate::support::Workspace;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Few runs of a short weld whose faults have room.
const CERTIFY: [&str; 9] = [
    "certify",
    "--compensator",
    "seam-tracking",
    "--weld",
    "short.toml",
    "--requirements",
    "requirements.toml",
    "--trials",
    "7",
];

const WORST: [&str; 3] = ["--worst", "2", "-q"];

fn workspace() -> Workspace {
    let place = Workspace::new();
    place.requirements(|key, line| {
        (key == "places" && line.contains("11")).then(|| "places = 2\n".to_owned())
    });
    place
}

fn arguments<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&CERTIFY[..], &WORST, more].concat()
}

/// Panics unless certificate, page and every file with runs are those of the serial run.
fn assert_same_evidence(place: &Workspace, told: &str) {
    let sections =
        ["nominal", "trials", "worst", "faults"].map(|name| format!("{name}-short.jsonl"));
    for file in sections.iter().map(String::as_str).chain(["certify.json", "certify.html"]) {
        assert!(place.path().join("merged").join(file).exists(), "{file}: {told}");
        let [a, b] = ["serial", "merged"].map(|folder| place.bytes(&format!("{folder}/{file}")));
        assert!(a == b, "{file}");
    }
}

/// Copies a shard.
fn copied(place: &Workspace, from: &str, to: &str) -> PathBuf {
    let folder = place.path().join(to);
    fs::create_dir(&folder).unwrap();
    for entry in fs::read_dir(place.path().join(from)).unwrap().map(Result::unwrap) {
        fs::copy(entry.path(), folder.join(entry.file_name())).unwrap();
    }
    folder
}

fn replace(path: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "{from} in {text}");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
}

#[test]
fn merged_shards_are_the_serial_run_and_what_is_no_whole_is_refused() {
    let place = workspace();
    let serial = place.run(&arguments(&["--evidence", "serial"]));
    for shard in ["1/3", "2/3", "3/3"] {
        let folder = shard.replace('/', "-");
        place.done(&arguments(&["--shard", shard, "--evidence", &folder]));
        assert!(!place.path().join(folder).join("certify.json").exists());
    }
    let merge = |folders: &[&'static str], evidence: &'static str| {
        let of = [&["--merge"], folders, &["--evidence", evidence]].concat();
        arguments(&of)
    };
    // In any order, and again.
    for _ in 0..2 {
        let merged = place.run(&merge(&["3-3", "1-3", "2-3"], "merged"));
        let told = String::from_utf8_lossy(&merged.stderr);
        assert_eq!(merged.status, serial.status, "{told}");
        assert_same_evidence(&place, &told);
    }

    let refused = |folders: &[&'static str], expected: &[&str]| {
        let message = place.refused(&merge(folders, "no"));
        for words in expected {
            assert!(message.contains(words), "{words} in: {message}");
        }
    };
    refused(&["1-3", "3-3"], &["1 of 3 shards not given: 2/3"]);
    refused(&["1-3", "2-3", "2-3", "3-3"], &["--merge 2-3: shard 2/3 is given twice"]);

    let damaged = copied(&place, "2-3", "damaged").join("trials-short.jsonl");
    replace(&damaged, "\"index\":1", "\"index\":2");
    refused(&["1-3", "damaged", "3-3"], &["shard 2/3 is damaged: trials-short.jsonl"]);
    // Cut at the end of a line the file is whole in itself.
    let lost = copied(&place, "2-3", "lost").join("trials-short.jsonl");
    let text = fs::read_to_string(&lost).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    fs::write(&lost, lines[..lines.len() - 1].join("\n") + "\n").unwrap();
    refused(&["1-3", "lost", "3-3"], &["shard 2/3 is damaged: trials-short.jsonl"]);
    // A shard that says that it is whole, and is not.
    let manifest = lost.with_file_name("shard.json");
    fs::remove_file(&manifest).unwrap();
    refused(&["1-3", "lost", "3-3"], &["--merge lost: no finished shard"]);

    let version = copied(&place, "2-3", "version").join("shard.json");
    replace(
        &version,
        &format!("\"version\": {:?}", env!("CARGO_PKG_VERSION")),
        "\"version\": \"9.9\"",
    );
    refused(&["1-3", "version", "3-3"], &["shard 2/3", "made by version 9.9 of the program"]);
    let sources = copied(&place, "2-3", "sources").join("shard.json");
    let of = &place.json("2-3/shard.json")["provenance"];
    let built = of["sources"].as_str().unwrap();
    replace(&sources, built, "abc");
    let both = format!("made by a build of the sources abc, and this is one of {built}");
    refused(&["1-3", "sources", "3-3"], &["shard 2/3", &both]);
    let seed = copied(&place, "2-3", "seed").join("shard.json");
    let drawn = &of["simulation"]["draws_seed"];
    replace(&seed, &format!("\"draws_seed\": {drawn}"), "\"draws_seed\": 2");
    refused(&["1-3", "seed", "3-3"], &["shard 2/3", &format!("draws_seed was 2, and is {drawn}")]);
    let digest = copied(&place, "2-3", "digest").join("shard.json");
    let text = fs::read_to_string(&digest).unwrap();
    let (before, weld) = text.split_once("\"short.toml\"").unwrap();
    let weld = weld.replacen("\"sha256\": \"", "\"sha256\": \"0", 1);
    fs::write(&digest, format!("{before}\"short.toml\"{weld}")).unwrap();
    refused(&["1-3", "digest", "3-3"], &["shard 2/3", "its weld file was short.toml"]);
    let more = [&CERTIFY[..8], &["8"], &WORST].concat();
    let more = [&more[..], &["--merge", "1-3", "2-3", "3-3", "--evidence", "no"]].concat();
    assert!(place.refused(&more).contains("shard 1/3 is part of 7 runs; expected 8"));

    // A folder of a shard is not one of another shard, nor of the whole.
    let message = place.refused(&arguments(&["--shard", "3/3", "--evidence", "1-3"]));
    assert!(message.contains("--evidence 1-3 holds shard 1/3"), "{message}");
    let message = place.refused(&arguments(&["--evidence", "1-3"]));
    assert!(message.contains("--evidence 1-3 holds shard 1/3"), "{message}");
    let message = place.refused(&arguments(&["--shard", "4/3", "--evidence", "no"]));
    assert!(message.contains("I from 1 to N"), "{message}");
    let json = ["--shard", "1/3", "--evidence", "no", "--json", "x.json"];
    assert!(place.refused(&arguments(&json)).contains("has no result yet"));
}

#[test]
fn the_dask_driver_gives_the_serial_certificate() {
    let asked = Command::new("python3").args(["-c", "import dask.distributed"]).output();
    if !asked.is_ok_and(|output| output.status.success()) {
        println!("skipped: Dask is not installed");
        return;
    }
    let place = workspace();
    let serial = place.run(&arguments(&["--evidence", "serial"]));
    let driver = format!("{}/../../examples/scale/certify_dask.py", env!("CARGO_MANIFEST_DIR"));
    let output = Command::new("python3")
        .args([&driver, "--shards", "3", "--workers", "2", "--folder", "shards"])
        .args(["--program", env!("CARGO_BIN_EXE_trueweld"), "--"])
        .args(&arguments(&["--evidence", "merged"])[1..])
        .current_dir(place.path())
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status, serial.status, "{told}");
    assert_same_evidence(&place, &told);
}
