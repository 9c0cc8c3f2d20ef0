//! Sets `TRUEWELD_SOURCES`: the SHA-256 of the sources that the program is built from, which
//! results state and evidence is tied to.
//!
//! It is a digest of contents: it is the same with and without git, wherever the sources lie, and
//! another one after any change. Cargo runs this again only where one of the sources has changed,
//! and the program is built anew then in any case.
//!
//! Left out: the sources of other crates, whose versions `Cargo.lock` pins, the compiler, and a
//! law or an effect of one's own.

mod source_files;

use sha2::{Digest, Sha256};
use source_files::source_files;
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
    let mut lines = String::new();
    for file in source_files(root)? {
        lines += &format!("{}  {file}\n", sha256(&fs::read(root.join(&file))?));
    }
    Ok(sha256(lines.as_bytes()))
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
