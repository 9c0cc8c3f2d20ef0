//! Rooms that measure and judge return data: their words are made in the output crate. Errors of
//! input files are sentences where they arise, with the place that they show.
//!
//! One name means one thing: every type and every constant of the workspace is declared once.
//! Associated items (`Law::NAME`) have the name of their trait or type before them and do not
//! count; nor do unit tests.

use std::collections::BTreeMap;
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
    for name in ["logs", "estimate", "diagnose"] {
        files(&root.join(name).join("src"), &mut all);
    }
    files(&root.join("evaluate/src"), &mut all);
    let of_input = |file: &Path| {
        [
            "logs/src/log",
            // Robot, process and protocol files with what was found.
            "estimate/src/identify",
            "logs/src/campaign.rs",
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

/// Names that commands still share, each private to its file.
const STILL_TWICE: [&str; 6] = ["Arguments", "HOLD", "LENGTH", "MOST", "PAGE", "What"];

/// Keyword and name of the item that a line of code begins.
fn item(line: &str) -> Option<(&str, &str)> {
    let mut rest = line;
    if let Some(public) = rest.strip_prefix("pub") {
        let scope = public.strip_prefix('(').and_then(|scope| scope.split_once(')'));
        rest = scope.map_or(public, |(_, rest)| rest).trim_start();
    }
    rest = rest.strip_prefix("unsafe ").unwrap_or(rest);
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let (keyword, rest) = rest.split_at(rest.find(|c| !is_word(c))?);
    let rest = rest.trim_start();
    let rest = rest.strip_prefix("mut ").unwrap_or(rest);
    Some((keyword, &rest[..rest.find(|c| !is_word(c)).unwrap_or(rest.len())]))
}

/// The types and constants that code declares, but for associated ones and those of macros.
fn declared(code: &str) -> Vec<String> {
    let code = code.split("#[cfg(test)]").next().unwrap_or_default();
    let mut names = Vec::new();
    // Indentation of what a line stands in, where that is a macro, an `impl` or a `trait`, and from
    // which indentation on items are no part of it.
    let mut outer: Option<(usize, usize)> = None;
    let mut is_alternative = false;
    for line in code.lines() {
        let text = line.trim_start();
        let indent = line.len() - text.len();
        if outer.is_some_and(|(begin, _)| begin == indent) && text.starts_with('}') {
            outer = None;
        }
        let (keyword, name) = item(text).unwrap_or_default();
        let is_apart = outer.is_none_or(|(_, inner)| indent >= inner);
        let is_item = ["struct", "enum", "union", "trait", "type", "const", "static"]
            .contains(&keyword)
            && !["", "_", "const", "fn"].contains(&name);
        if is_item && is_apart && !is_alternative {
            names.push(name.to_owned());
        }
        if outer.is_none() && !text.ends_with('}') {
            outer = match keyword {
                "impl" | "trait" => Some((indent, indent + 8)),
                "macro_rules" => Some((indent, usize::MAX)),
                _ => None,
            };
        }
        // The other one of a pair of which a build has one.
        is_alternative =
            text.starts_with("#[cfg(not(") || (is_alternative && text.starts_with('#'));
    }
    names
}

#[test]
fn a_type_or_a_constant_is_declared_once() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut all = Vec::new();
    for name in ["core-nostd", "compensators", "sim-host", "fmu", "python/src"] {
        files(&root.join(name), &mut all);
    }
    let is_source = |file: &&PathBuf| {
        let mut parts = file.components().map(|part| part.as_os_str());
        parts.any(|part| part == "src") && file.extension().is_some_and(|e| e == "rs")
    };
    let mut places: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for file in all.iter().filter(is_source) {
        let place = file.strip_prefix(&root).expect("a file of the workspace");
        for name in declared(&fs::read_to_string(file).expect("a source file")) {
            places.entry(name).or_default().push(place.to_owned());
        }
    }
    places.retain(|name, places| places.len() > 1 && name != "_");
    let shared: Vec<_> = STILL_TWICE.iter().filter(|name| !places.contains_key(**name)).collect();
    assert!(shared.is_empty(), "declared once by now: {shared:?}");
    let is_shared = |name: &str, places: &[PathBuf]| {
        STILL_TWICE.contains(&name) && places.iter().all(|place| place.starts_with("sim-host/cli"))
    };
    places.retain(|name, places| !is_shared(name, places));
    assert!(places.is_empty(), "declared more than once: {places:#?}");
}

#[test]
fn a_declaration_is_found() {
    let code = "pub struct A<T> {\n    at: u8,\n}\n\nimpl<T> A<T> {\n    const B: u8 = 1;\n\n    \
                fn f() {\n        const C: u8 = 2;\n    }\n}\n\npub(crate) static D: u8 = 3;\n\
                const fn f() {}\n#[cfg(not(test))]\nconst E: u8 = 4;\n// const F: u8 = 5;\n\
                pub trait G {\n    type H;\n}\ntype I = u8;\n";
    assert_eq!(declared(code), ["A", "C", "D", "G", "I"]);
}
