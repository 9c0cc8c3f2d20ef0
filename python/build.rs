//! Sets `TRUEWELD_FMU_LIBRARY`: where Cargo puts the shared library of `trueweld-fmu`, which is built
//! before this crate, as every crate that it depends on, and beside the others.

use std::env;
use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let variable = |name: &str| env::var(name).expect("cargo sets it");
    // target/PROFILE/build/NAME/out
    let out = PathBuf::from(variable("OUT_DIR"));
    let profile = out.ancestors().nth(3).expect("cargo's folders");
    let name = match variable("CARGO_CFG_TARGET_OS").as_str() {
        "windows" => "trueweld_fmu.dll",
        "macos" => "libtrueweld_fmu.dylib",
        _ => "libtrueweld_fmu.so",
    };
    let library = profile.join("deps").join(name);
    println!("cargo::rustc-env=TRUEWELD_FMU_LIBRARY={}", library.display());
}
