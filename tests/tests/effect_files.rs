//! An effect is one file and one line: no other source knows its identifier.

use std::fs;
use std::path::{Path, PathBuf};
use trueweld_plant::effects::library;

/// Every source file of the project outside tests, benches and examples.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let (path, name) = (entry.path(), entry.file_name().into_string().unwrap());
        if path.is_dir() {
            if !["tests", "benches", "examples", "target"].contains(&name.as_str()) {
                sources(&path, found);
            }
        } else if name.ends_with(".rs") {
            found.push(path);
        }
    }
}

/// The part of a source that is compiled into the product, without comments.
fn product(text: &str) -> String {
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// True for a module that its parent declares for tests only.
fn for_tests_only(path: &Path, all: &[(PathBuf, String)]) -> bool {
    let name = path.file_stem().unwrap().to_string_lossy();
    let declared = format!("#[cfg(test)]\nmod {name};");
    all.iter().any(|(other, text)| other.parent() == path.parent() && text.contains(&declared))
}

#[test]
fn no_source_but_its_own_knows_an_effect() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut paths = Vec::new();
    for folder in ["core-nostd/src", "compensators/src", "sim-host"] {
        sources(&root.join(folder), &mut paths);
    }
    let all: Vec<(PathBuf, String)> =
        paths.into_iter().map(|path| (path.clone(), fs::read_to_string(path).unwrap())).collect();
    assert!(all.len() > 100, "found {} sources only", all.len());
    for kind in library() {
        let literal = format!("\"{}\"", kind.id);
        let knows = all
            .iter()
            .filter(|(path, text)| product(text).contains(&literal) && !for_tests_only(path, &all));
        let names: Vec<String> = knows
            .map(|(path, _)| path.file_name().unwrap().to_string_lossy().into_owned())
            .collect();
        assert_eq!(names, [format!("{}.rs", kind.id.replace('-', "_"))], "{}", kind.id);
    }
}
