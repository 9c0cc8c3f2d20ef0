//! Which files the program is built from, for the build scripts that digest and pack them.

use std::path::Path;
use std::{fs, io};

/// Paths from the root of the repository, in their order. Cargo runs the script again where one of
/// them changes, and where one is added or removed.
pub(crate) fn source_files(root: &Path) -> io::Result<Vec<String>> {
    let mut files = ["Cargo.lock", "Cargo.toml"].map(str::to_owned).to_vec();
    let crates = names(&root.join("sim-host"))?.into_iter().map(|name| format!("sim-host/{name}"));
    for folder in crates.chain(["core-nostd", "compensators", "fmu"].map(str::to_owned)) {
        let own = ["Cargo.toml", "build.rs", "source_files.rs"];
        let own = own.map(|name| format!("{folder}/{name}"));
        files.extend(own.into_iter().filter(|file| root.join(file).is_file()));
        collect(root, &format!("{folder}/src"), &mut files)?;
    }
    files.sort();
    for file in &files {
        println!("cargo::rerun-if-changed={}", root.join(file).display());
    }
    Ok(files)
}

/// All files in a folder and the folders below.
pub(crate) fn collect(root: &Path, folder: &str, files: &mut Vec<String>) -> io::Result<()> {
    println!("cargo::rerun-if-changed={}", root.join(folder).display());
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
