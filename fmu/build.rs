//! Packs the sources that an FMU carries, so that its library can be built for another platform.
//!
//! They are those that the digest of the program is of, so that what is built of them takes the same
//! FMUs, and what else Cargo asks for: the manifests of the other members of the workspace, and the
//! files that the program embeds.

#[path = "../sim-host/trueweld/source_files.rs"]
mod source_files;

use source_files::{collect, source_files};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::{env, error};
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipWriter};

/// Members of the workspace whose code is not needed.
const OTHER_MEMBERS: [&str; 5] = [
    "python/Cargo.toml",
    "python/build.rs",
    "python/src/lib.rs",
    "tests/Cargo.toml",
    "tests/src/lib.rs",
];

/// Files that the program embeds.
const EMBEDDED: [&str; 6] = ["control", "processes", "requirements", "robots", "sensors", "welds"];

const LICENSES: [&str; 2] = ["LICENSE-APACHE", "LICENSE-MIT"];

fn main() -> Result<(), Box<dyn error::Error>> {
    let folder = env::var_os("CARGO_MANIFEST_DIR").ok_or("cargo sets it")?;
    let out = env::var_os("OUT_DIR").ok_or("cargo sets it")?;
    let root = PathBuf::from(folder).join("..");
    let archive = File::create(PathBuf::from(out).join("sources.zip"))?;
    Ok(pack(&root, &files(&root)?, archive)?)
}

fn files(root: &Path) -> io::Result<Vec<String>> {
    let mut files = source_files(root)?;
    files.extend(OTHER_MEMBERS.into_iter().chain(LICENSES).map(str::to_owned));
    // Cargo builds nothing of a workspace in which a benchmark is missing that a manifest names.
    let manifests = files.clone().into_iter();
    for folder in manifests.filter_map(|file| Some(file.strip_suffix("/Cargo.toml")?.to_owned())) {
        let benches = format!("{folder}/benches");
        if root.join(&benches).is_dir() {
            collect(root, &benches, &mut files)?;
        }
    }
    for folder in EMBEDDED {
        collect(root, &format!("fixtures/{folder}"), &mut files)?;
    }
    files.sort();
    Ok(files)
}

/// The same files give the same bytes.
fn pack(root: &Path, files: &[String], archive: File) -> io::Result<()> {
    let options = SimpleFileOptions::default().last_modified_time(DateTime::default());
    let mut zip = ZipWriter::new(archive);
    for file in files {
        zip.start_file(file.as_str(), options.unix_permissions(0o644))?;
        zip.write_all(&fs::read(root.join(file))?)?;
    }
    zip.finish()?;
    Ok(())
}
