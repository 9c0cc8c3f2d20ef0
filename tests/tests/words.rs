//! Rooms that measure and judge return data: their words are made in the output crate.
//!
//! Errors of input files are sentences where they arise, with the place that they show.

use std::fs;
use std::path::{Path, PathBuf};

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()) {
        if entry.is_dir() {
            files(&entry, found);
        } else {
            found.push(entry);
        }
    }
}

/// The texts with a blank in them that code makes strings of: `format!("…")`, `"…".to_owned()`.
fn sentences(code: &str) -> Vec<String> {
    let code = code.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let code = lines.collect::<Vec<_>>().join("\n");
    let literal =
        |text: &str| text.trim_start().strip_prefix('"')?.split('"').next().map(str::to_owned);
    let formatted =
        code.match_indices("format!(").filter_map(|(at, m)| literal(&code[at + m.len()..]));
    let owned = code
        .match_indices("\".to_owned()")
        .filter_map(|(at, _)| code[..at].rfind('"').map(|start| code[start + 1..at].to_owned()));
    formatted.chain(owned).filter(|text| text.contains(' ')).collect()
}

#[test]
fn no_sentence_is_made_where_numbers_are() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../sim-host");
    let mut all = Vec::new();
    files(&root.join("measure/src"), &mut all);
    files(&root.join("evaluate/src"), &mut all);
    let of_input = |file: &Path| {
        [
            "measure/src/data/log",
            "measure/src/data/campaign.rs",
            "evaluate/src/uncertain",
            "evaluate/src/requirements.rs",
        ]
        .iter()
        .any(|input| file.starts_with(root.join(input)))
    };
    let made: Vec<_> = all
        .iter()
        .filter(|file| !of_input(file))
        .map(|file| (file, sentences(&fs::read_to_string(file).expect("a source file"))))
        .filter(|(_, sentences)| !sentences.is_empty())
        .collect();
    assert!(made.is_empty(), "words below the output: {made:#?}");
}

#[test]
fn a_sentence_is_found() {
    let code =
        "fn f() -> String {\n    format!(\n        \"{n} of {m}\")\n}\n// format!(\"a b\")\n";
    assert_eq!(sentences(code), ["{n} of {m}"]);
    assert_eq!(sentences("let a = \"no word\".to_owned();"), ["no word"]);
    assert!(sentences("let a = format!(\"{a}-{b}\"); f(\"a b\");").is_empty());
}
