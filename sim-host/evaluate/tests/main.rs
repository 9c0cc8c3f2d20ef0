//! Figures, uncertain cells and studies.

#[expect(dead_code, reason = "shared with tests that need more of it")]
#[path = "../../plant/tests/cell/support.rs"]
mod cell;
mod joint_share;
mod study;
mod uncertain;

use std::path::PathBuf;

/// Path of a file below `fixtures/`.
fn fixture(relative: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(relative)
}
