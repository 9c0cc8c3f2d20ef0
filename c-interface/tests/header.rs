//! The committed header is what cbindgen makes of the source.

use std::path::Path;

/// Renewed with UPDATE=1 in the environment.
#[test]
fn the_header_is_of_this_source() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config =
        cbindgen::Config::from_file(folder.join("cbindgen.toml")).expect("a configuration");
    let bindings = cbindgen::Builder::new().with_crate(folder).with_config(config).generate();
    let mut made = Vec::new();
    bindings.expect("the source has an interface").write(&mut made);
    let path = folder.join("include/trueweld.h");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &made).expect("the folder is there");
    }
    let committed = std::fs::read(&path).expect("the header is there");
    assert!(committed == made, "include/trueweld.h is not of this source: run with UPDATE=1");
}
