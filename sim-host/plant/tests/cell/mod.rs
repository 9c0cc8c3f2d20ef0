//! What takes a whole cell: effects, ports, the motion of the arm.

mod constants;
mod effects;
mod fast;
mod health;
mod milling;
#[expect(dead_code, reason = "shared with tests that need more of it")]
#[path = "../../../../core-nostd/tests/algebra/support.rs"]
mod numbers;
mod plant;
mod ports;
mod recorded_weld;
mod seams;
mod state;
mod support;
mod tilt;

use std::path::PathBuf;
use std::sync::LazyLock;
use trueweld_core::Robot;

/// Path of a file below `fixtures/`.
fn fixture(relative: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(relative)
}

/// The KR 500 MT with its end effector.
static KR500: LazyLock<Robot<f64>> =
    LazyLock::new(|| support::Fixtures::of("vertical").robot.robot);
