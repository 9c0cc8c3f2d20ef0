//! No text whatever makes a reader panic.

use crate::input::{
    CONTROL, JOGGLE, PROCESS, ROBOT, SENSORS, URDF, VERTICAL, check, parse, rendered,
};
use proptest::prelude::*;
use std::fs;
use trueweld_plant::input::*;

/// Runs every reader on a text; the outcome does not matter, only that there is one, and that it
/// can be shown.
fn read_everything(text: &str) {
    let outcomes = [
        RobotFile::parse(text, "x").map(drop),
        Process::parse(text, "x").map(drop),
        Weld::parse(text, "x").map(drop),
        Control::parse(text, "x").map(drop),
        Sensors::parse(text, "x").map(drop),
        parse(text, "x"),
        import_urdf_text(text, "x").map(drop),
    ];
    for error in outcomes.into_iter().filter_map(Result::err) {
        assert!(!rendered(&error).is_empty());
    }
}

/// A fixture with a few bytes replaced, removed or put in, mostly by what numbers and syntax are
/// made of.
fn mutated() -> impl Strategy<Value = Vec<u8>> {
    let fixtures =
        prop::sample::select(vec![ROBOT, PROCESS, VERTICAL, JOGGLE, CONTROL, SENSORS, URDF]);
    let pieces = [
        "-", "e308", "e-320", "nan", "inf", "\"", "[", "]", "{", "}", "=", "\n", "<", ">", "/",
        "&", "é", ".", "9",
    ];
    let piece = prop_oneof![
        prop::sample::select(pieces.map(|s| s.as_bytes().to_vec()).to_vec()),
        prop::collection::vec(any::<u8>(), 0..4),
    ];
    let edits = prop::collection::vec((any::<prop::sample::Index>(), 0..6usize, piece), 1..5);
    (fixtures, edits).prop_map(|(text, edits)| {
        let mut bytes = text.as_bytes().to_vec();
        for (at, cut, put) in edits {
            let at = at.index(bytes.len() + 1);
            let end = (at + cut).min(bytes.len());
            bytes.splice(at..end, put);
        }
        bytes
    })
}

/// A fixture with one to three of its numbers replaced by extreme ones.
fn extreme() -> impl Strategy<Value = String> {
    let fixtures = prop::sample::select(vec![ROBOT, PROCESS, VERTICAL, CONTROL, SENSORS]);
    let numbers = [
        "0",
        "-0.0",
        "1e12",
        "-1e12",
        "1e-320",
        "1e308",
        "nan",
        "-inf",
        "1e-200",
        "1e-160",
        "0x7fffffffffffffff",
    ];
    let edits = prop::collection::vec(
        (any::<prop::sample::Index>(), prop::sample::select(numbers.to_vec())),
        1..4,
    );
    (fixtures, edits).prop_map(|(text, edits)| {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let values: Vec<usize> = (0..lines.len()).filter(|i| lines[*i].contains('=')).collect();
        for (at, number) in edits {
            let line = &mut lines[values[at.index(values.len())]];
            let start = line.find('=').map_or(0, |i| i + 1);
            let digits = |c: char| c.is_ascii_digit() || c == '-';
            let Some(from) = line[start..].find(digits).map(|i| i + start) else {
                continue;
            };
            let length = line[from..]
                .find(|c: char| !"0123456789.eE-+".contains(c))
                .unwrap_or(line.len() - from);
            line.replace_range(from..from + length, number);
        }
        lines.join("\n")
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_text_makes_a_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        read_everything(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn no_mutated_fixture_makes_a_reader_panic(bytes in mutated()) {
        read_everything(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn no_extreme_value_makes_a_reader_panic(text in extreme()) {
        read_everything(&text);
    }

    #[test]
    fn no_file_makes_check_panic(bytes in mutated()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mutated");
        fs::write(&path, bytes).unwrap();
        let _ = check(&path);
        let _ = import_urdf(&path);
    }
}

/// What opens brackets without end, some in ways that are not TOML.
#[test]
fn brackets_without_end_are_refused() {
    let pieces = [
        "[",
        "{",
        "{a=",
        "[{a=",
        "{[s]\" = ",
        "{[}]=",
        "{\"}\"=",
        "[{]",
        "a.",
        "[[",
        "{a={b=1},c=",
    ];
    for piece in pieces {
        for before in ["x = ", "", "[x]\n", "x = [1, "] {
            let text = format!("{before}{}", piece.repeat(20_000));
            let error = RobotFile::parse(&text, "x").expect_err(piece);
            assert!(rendered(&error).contains("not TOML"), "{piece}: {error:?}");
        }
    }
    // As many brackets as a file may have, one after the other.
    let list = format!("schema = \"robot/1\"\nx = [{}]", "{ a = [1, 2] }, ".repeat(20_000));
    let error = RobotFile::parse(&list, "x").expect_err("no robot");
    assert!(!rendered(&error).contains("not TOML"), "{error:?}");
}
