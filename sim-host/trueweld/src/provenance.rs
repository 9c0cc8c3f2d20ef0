//! What a result is of, as far as the program itself is.

use trueweld_plant::input::warnings;
use trueweld_plant::provenance::Provenance;

/// SHA-256 of the sources that the program is built from, as the build script states it.
pub const SOURCES: &str = env!("TRUEWELD_SOURCES");

/// Version of the program, with the digest of its sources.
pub const VERSION: &str =
    concat!(env!("CARGO_PKG_VERSION"), " (sources ", env!("TRUEWELD_SOURCES"), ")");

/// What a result of this program is of, without what was read: version, sources, command, and the
/// warnings about input files so far.
pub fn of_program(command: &str) -> Provenance {
    Provenance {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        sources: SOURCES.to_owned(),
        command: command.to_owned(),
        warnings: warnings(),
        ..Provenance::default()
    }
}
