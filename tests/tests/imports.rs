//! Inside a crate files do not import each other in a circle.
//!
//! A file is a module. It imports another where its code names a path that ends there: through
//! `crate::`, `super::` or a child module. A re-export (`pub use`) is no import; a path that goes
//! through one ends at the file that it leads to. Unit tests at the end of a file do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Path of a module from the crate's root.
type Module = Vec<String>;

/// What one file names: paths from the crate's root.
#[derive(Default)]
struct Source {
    imports: Vec<Module>,
    /// Name as seen from outside, and the path it leads to; `*` for a glob.
    exports: Vec<(String, Module)>,
}

/// Reads the paths of a `use` tree or an expression that begins at `text`, each with the name it
/// is bound to, and appends them to `found` behind `prefix`.
fn read_tree<'t>(
    mut text: &'t str,
    prefix: &[String],
    found: &mut Vec<(String, Module)>,
) -> &'t str {
    let mut path = prefix.to_vec();
    loop {
        text = text.trim_start();
        if let Some(mut rest) = text.strip_prefix('{') {
            loop {
                rest = read_tree(rest, &path, found).trim_start();
                match rest.strip_prefix(',') {
                    Some(next) => rest = next,
                    None => return rest.strip_prefix('}').unwrap_or(rest),
                }
            }
        }
        let length = text.find(|c: char| !c.is_alphanumeric() && c != '_' && c != '*');
        let (word, rest) = text.split_at(length.unwrap_or(text.len()));
        if word.is_empty() {
            // Generic arguments: the path ends before them.
            found.push((path.last().cloned().unwrap_or_default(), path));
            return rest;
        }
        match word {
            "super" => drop(path.pop()),
            "self" => {}
            _ => path.push(word.to_owned()),
        }
        match rest.strip_prefix("::") {
            Some(next) => text = next,
            None => {
                let renamed = rest.trim_start().strip_prefix("as ").unwrap_or(word);
                let name = renamed.split([',', ';', '}', ' ', '\n']).next().unwrap_or(word);
                found.push((name.to_owned(), path));
                return &rest[rest.find([',', '}', ';']).unwrap_or(rest.len())..];
            }
        }
    }
}

fn read_source(file: &Path, module: &Module, children: &BTreeSet<Module>) -> Source {
    let text = fs::read_to_string(file).expect("a source file");
    let text = text.split("#[cfg(test)]").next().unwrap_or_default();
    let code = text.lines().filter(|l| !l.trim_start().starts_with("//"));
    let text = code.collect::<Vec<_>>().join("\n");
    let mut source = Source::default();
    for (at, _) in text.match_indices("use ") {
        let rest = &text[at + 4..];
        let line = text[..at].rsplit('\n').next().unwrap_or_default().trim();
        let first = rest.split([':', ';', ' ']).next().unwrap_or_default();
        let child = [module.as_slice(), &[first.to_owned()]].concat();
        if children.contains(&child) || (line.starts_with("pub") && first == "self") {
            let mut found = Vec::new();
            read_tree(rest, module, &mut found);
            match line {
                "" => source.imports.extend(found.into_iter().map(|(_, path)| path)),
                _ => source.exports.append(&mut found),
            }
        }
    }
    for (start, base) in [("crate::", &[][..]), ("super::", module)] {
        for (at, _) in text.match_indices(start) {
            let before = &text[..at];
            if before.ends_with("::") || before.ends_with(|c: char| c.is_alphanumeric() || c == '_')
            {
                continue;
            }
            let rest = &text[at + if base.is_empty() { start.len() } else { 0 }..];
            let mut found = Vec::new();
            read_tree(rest, base, &mut found);
            let line = before.rsplit('\n').next().unwrap_or_default().trim();
            if line.starts_with("pub") && line.ends_with("use") {
                source.exports.append(&mut found);
            } else {
                source.imports.extend(found.into_iter().map(|(_, path)| path));
            }
        }
    }
    source
}

/// The file in which a path ends.
fn resolve(path: &[String], sources: &BTreeMap<Module, Source>) -> Module {
    let mut length = path.len();
    while length > 0 && !sources.contains_key(&path[..length]) {
        length -= 1;
    }
    let (module, rest) = path.split_at(length);
    let Some(name) = rest.first() else { return module.to_vec() };
    let exports = &sources[module].exports;
    let led = exports.iter().find(|(n, p)| n == name && p != path);
    led.map_or(module.to_vec(), |(_, to)| resolve(&[to, &rest[1..]].concat(), sources))
}

fn files(folder: &Path, module: &Module, found: &mut BTreeMap<Module, PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()) {
        let stem = entry.file_stem().and_then(|s| s.to_str()).expect("a name").to_owned();
        let inner = [module.as_slice(), std::slice::from_ref(&stem)].concat();
        if entry.is_dir() {
            files(&entry, &inner, found);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            let root = ["lib", "main", "mod"].contains(&stem.as_str());
            found.insert(if root { module.clone() } else { inner }, entry);
        }
    }
}

/// A circle of imports below `source`, as the files it goes through.
fn circle(source: &Path) -> Option<Vec<String>> {
    let mut paths = BTreeMap::new();
    files(source, &Vec::new(), &mut paths);
    let modules: BTreeSet<Module> = paths.keys().cloned().collect();
    let sources: BTreeMap<Module, Source> =
        paths.iter().map(|(m, file)| (m.clone(), read_source(file, m, &modules))).collect();
    let imports = |module: &Module| -> BTreeSet<Module> {
        let to = sources[module].imports.iter().map(|path| resolve(path, &sources));
        to.filter(|to| to != module).collect()
    };
    // Files that import nothing of what is left fall away; what remains is in a circle or behind
    // one.
    let mut left: BTreeMap<&Module, BTreeSet<Module>> =
        modules.iter().map(|m| (m, imports(m))).collect();
    loop {
        let free: Vec<&Module> = left
            .iter()
            .filter(|(_, to)| !to.iter().any(|t| left.contains_key(t)))
            .map(|(m, _)| *m)
            .collect();
        if free.is_empty() {
            break;
        }
        left.retain(|m, _| !free.contains(m));
    }
    let mut at = *left.keys().next()?;
    let mut way: Vec<&Module> = Vec::new();
    while !way.contains(&at) {
        way.push(at);
        let next = left[at].iter().find_map(|to| left.get_key_value(to))?;
        at = next.0;
    }
    let begin = way.iter().position(|m| *m == at)?;
    Some(way[begin..].iter().map(|m| format!("crate::{}", m.join("::"))).collect())
}

#[test]
fn files_of_a_crate_do_not_import_each_other_in_a_circle() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let crates = [
        "core-nostd",
        "compensators",
        "sim-host/plant",
        "sim-host/laboratory",
        "sim-host/logs",
        "sim-host/estimate",
        "sim-host/diagnose",
        "sim-host/evaluate",
        "sim-host/trueweld",
        "sim-host/output",
        "sim-host/cli",
        "fmu",
        "python",
        "tests",
    ];
    let circles: Vec<_> = crates
        .iter()
        .filter_map(|name| Some((name, circle(&root.join(name).join("src"))?)))
        .collect();
    assert!(circles.is_empty(), "imports in a circle: {circles:#?}");
}

#[test]
fn a_circle_is_found() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).expect("a file");
    };
    write("lib.rs", "mod a;\nmod b;\npub use a::A;\n");
    write("a.rs", "use crate::b::B;\npub struct A(B);\n");
    write("b.rs", "pub struct B;\n");
    assert_eq!(circle(folder.path()), None);
    // Through the re-export.
    write("b.rs", "pub struct B;\nfn f(_: crate::A) {}\n");
    assert_eq!(circle(folder.path()).map(|c| c.len()), Some(2));
}
