//! No bytes whatever make a reader of settings panic, hang or take a gigabyte. Files of samples are
//! in `sim-host/logs/tests/formats.rs`.
//!
//! A short run is part of the ordinary tests. The long one, 10⁷ a reader, in memory (an effect of
//! one's own stays until the program ends, so `models` is run in ten parts):
//!
//! ```text
//! BOLERO_RANDOM_ITERATIONS=10000000 TMPDIR=/dev/shm cargo test --profile bench -p trueweld-tests --test all fuzz::
//! ```

use std::fs;
use std::path::Path;
use trueweld_evaluate::Requirements;
use trueweld_logs::campaign::{CAMPAIGN_FILE, Campaign};
use trueweld_logs::log::{LOG_FILE, Log};
use trueweld_plant::input::{
    Control, InputError, InputFile, ModelFile, Process, RobotFile, Sensors, TomlDocument, Weld,
    import_urdf_text,
};
use trueweld_tests::fixture;
use trueweld_tests::mutation::never_breaks;

/// A fixture without its comments: what is damaged in them hurts no reader.
fn settings(path: &str) -> String {
    let text = fs::read_to_string(fixture(path)).expect("a fixture");
    let kept = text.lines().map(|line| line.split(" #").next().unwrap_or(line).trim_end());
    let kept: Vec<&str> = kept.filter(|line| !line.starts_with('#')).collect();
    kept.join("\n")
}

/// What a refusal must be fit for: to be shown.
fn shown<T>(outcome: Result<T, InputError>) -> Option<T> {
    let refused = |error: InputError| {
        assert!(!error.place().is_empty() && !error.message().is_empty(), "{error:?}");
        assert!(!error.help_text().is_empty() && !format!("{error}").contains('\0'), "{error:?}");
    };
    outcome.map_err(refused).ok()
}

/// What is read as text reads bytes that are not, too.
fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn a_reader_of_settings<T: InputFile>(path: &str, words: &[&str]) {
    let good = settings(path);
    T::parse(&good, path).map(drop).expect("what is damaged is good");
    never_breaks(path, good.as_bytes(), words, |bytes| {
        let text = text(bytes);
        drop(shown(T::parse(&text, path)));
    });
}

#[test]
fn robots() {
    a_reader_of_settings::<RobotFile>("robots/kr500-mt.toml", &["[[joint]]", "FILL IN", "A7"]);
}

#[test]
fn processes() {
    a_reader_of_settings::<Process>("processes/lap-weld-2024-t3.toml", &["FILL IN"]);
}

#[test]
fn welds() {
    a_reader_of_settings::<Weld>("welds/inclined.toml", &["FILL IN"]);
}

#[test]
fn control() {
    a_reader_of_settings::<Control>("control/kr500-mt.toml", &["FILL IN", "[law.x]"]);
}

#[test]
fn sensors() {
    a_reader_of_settings::<Sensors>("sensors/kr500-mt.toml", &["FILL IN"]);
}

#[test]
fn requirements() {
    a_reader_of_settings::<Requirements>("requirements/lap-weld.toml", &["FILL IN"]);
}

#[test]
fn models() {
    let path = fixture("models/cable-drag.toml");
    let words = ["(", "tanh(", "atan2(", "link_rate", "e9", "1/0", "A6", "scope = \"log\"\n"];
    let good = settings("models/cable-drag.toml");
    never_breaks("models/cable-drag.toml", good.as_bytes(), &words, |bytes| {
        drop(shown(ModelFile::parse(&text(bytes), &path)));
    });
}

#[test]
fn entries_to_be_filled_in() {
    let good = settings("robots/kr500-mt.toml").replace("0.0", "\"FILL IN: m\"");
    never_breaks("entries", good.as_bytes(), &["FILL IN", "schema"], |bytes| {
        if let Some(document) = shown(TomlDocument::parse(&text(bytes), "x")) {
            let _ = (shown(document.kind().map(drop)), document.open_entries());
        }
    });
}

#[test]
fn urdfs() {
    let good = fs::read(fixture("robots/arm6.urdf")).expect("a fixture");
    let words = ["<link name=\"x\"/>", "type=\"fixed\"", "<mimic joint=\"a1\"/>", "xmlns=\"\""];
    never_breaks("arm6.urdf", &good, &words, |bytes| {
        drop(shown(import_urdf_text(&text(bytes), "arm6.urdf")));
    });
}

/// A folder that is gone when the test ends.
fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

fn write(folder: &Path, name: &str, bytes: &[u8]) {
    fs::create_dir_all(folder).expect("a folder");
    fs::write(folder.join(name), bytes).expect("a file");
}

/// The first lines of a file.
fn head(path: &str, lines: usize) -> String {
    let text = fs::read_to_string(fixture(path)).expect("a fixture");
    text.split_inclusive('\n').take(lines).collect()
}

#[test]
fn logs() {
    let folder = folder();
    write(folder.path(), "krc.csv", head("raw/krc.csv", 12).as_bytes());
    write(folder.path(), "tracker.txt", head("raw/tracker.txt", 12).as_bytes());
    let robot = settings("campaigns/backlash/robot.toml");
    write(folder.path(), "robot.toml", robot.as_bytes());
    let good = settings("raw/log.toml").replace("../campaigns/backlash/", "");
    let good =
        good + "\n[reflectors]\nreflector1_m = [0.1, 0.0, 0.2]\n[tracker]\nbase_m = [0, 1, 2]\n";
    let words = ["reflector1_x", "static-load", "ring-down", "rw", "qx", "r11", "payload", "in"];
    write(folder.path(), LOG_FILE, good.as_bytes());
    Log::read(folder.path()).expect("what is damaged is good");
    never_breaks("raw/log.toml", good.as_bytes(), &words, |bytes| {
        write(folder.path(), LOG_FILE, bytes);
        drop(shown(Log::read(folder.path())));
    });
}

#[test]
fn campaigns() {
    let folder = folder();
    write(folder.path(), "model.toml", b"");
    for log in ["static", "free"] {
        write(&folder.path().join(log), LOG_FILE, b"");
    }
    let good = b"schema = \"campaign/1\"\nmodel = \"model.toml\"\nlogs = [\"static\", \"free\"]\n";
    write(folder.path(), CAMPAIGN_FILE, good);
    Campaign::list(folder.path()).expect("what is damaged is good");
    never_breaks("campaign.toml", good, &["../", "/", "static", "./free"], |bytes| {
        write(folder.path(), CAMPAIGN_FILE, bytes);
        drop(shown(Campaign::list(folder.path())));
    });
}
