//! Sets `TRUEWELD_SOURCES`: the SHA-256 of the sources that the program is built from, which
//! results state and evidence is tied to.
//!
//! It is a digest of contents: it is the same with and without git, wherever the sources lie, and
//! another one after any change. Cargo runs this again only where one of the sources has changed,
//! and the program is built anew then in any case.
//!
//! Left out: the sources of other crates, whose versions `Cargo.lock` pins, the compiler, and a
//! law or an effect of one's own.

use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() {
    let folder = env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it");
    let digest = digest(&PathBuf::from(folder).join("../..")).expect("the sources can be read");
    println!("cargo::rustc-env=TRUEWELD_SOURCES={digest}");
}

/// SHA-256 of the lines that `sha256sum` prints of all sources, in the order of their paths from
/// the root.
fn digest(root: &Path) -> io::Result<String> {
    let mut files = ["Cargo.lock", "Cargo.toml"].map(str::to_owned).to_vec();
    let crates = names(&root.join("sim-host"))?.into_iter().map(|name| format!("sim-host/{name}"));
    for folder in crates.chain(["core-nostd", "compensators", "fmu"].map(str::to_owned)) {
        let own = ["Cargo.toml", "build.rs"].map(|name| format!("{folder}/{name}"));
        files.extend(own.into_iter().filter(|file| root.join(file).is_file()));
        let sources = format!("{folder}/src");
        // Where a file is added or removed as well.
        println!("cargo::rerun-if-changed={}", root.join(&sources).display());
        collect(root, &sources, &mut files)?;
    }
    files.sort();
    let mut lines = String::new();
    for file in files {
        let path = root.join(&file);
        println!("cargo::rerun-if-changed={}", path.display());
        lines += &format!("{}  {file}\n", sha256(&fs::read(path)?));
    }
    Ok(sha256(lines.as_bytes()))
}

/// All files in a folder and the folders below.
fn collect(root: &Path, folder: &str, files: &mut Vec<String>) -> io::Result<()> {
    for name in names(&root.join(folder))? {
        let path = format!("{folder}/{name}");
        if root.join(&path).is_dir() {
            collect(root, &path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}

/// What is in a folder, without what editors and the system hide there.
fn names(folder: &Path) -> io::Result<Vec<String>> {
    let all = fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.file_name().to_string_lossy().into_owned()));
    all.filter(|name| !name.as_ref().is_ok_and(|name| name.starts_with('.'))).collect()
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
