//! No process: a cell in which the arm is measured and nothing is done.
//!
//! It is in no table, since no file can ask for it.

use super::model::{Process, ProcessKind, ProcessModel, Reaction, ToolInstant};
use crate::input::{InputError, TomlTable, Weld};
use nalgebra::{Matrix3, Vector3};

/// No force whatever the tool does.
#[derive(Debug)]
struct NoProcess;

impl Process {
    /// What a cell has in which nothing is done: no force whatever the tool does.
    pub fn none() -> Self {
        Self { spindle: 0.0, ripple: Vec::new(), model: Box::new(NoProcess) }
    }
}

static NO_PROCESS: ProcessKind = ProcessKind {
    id: "none",
    name: "no process",
    equation: "F = 0",
    about: "The tool meets nothing.",
    keys: &[],
    words: &[],
    quantities: &[],
    drawn: &[],
    parts: &[],
    read: no_file,
};

fn no_file(_: &TomlTable<'_>) -> Result<Box<dyn ProcessModel>, InputError> {
    Ok(Box::new(NoProcess))
}

impl ProcessModel for NoProcess {
    fn kind(&self) -> &'static ProcessKind {
        &NO_PROCESS
    }

    fn boxed(&self) -> Box<dyn ProcessModel> {
        Box::new(Self)
    }

    fn number(&mut self, _key: &str) -> Option<&mut f64> {
        None
    }

    fn reaction(&self, at: ToolInstant<'_>) -> Reaction {
        Reaction {
            force: Vector3::zeros(),
            stiffness: Matrix3::zeros(),
            damping: Matrix3::zeros(),
            trail_rate: 0.0,
            channel_rate: (at.point.position.y - at.channel) * at.point.velocity.x.abs(),
        }
    }

    fn tool_diameter(&self) -> f64 {
        0.0
    }

    fn lateral_tolerance(&self) -> f64 {
        0.0
    }

    fn planned_drag(&self, _spindle: f64, _push: f64, _feed: f64) -> [f64; 2] {
        [0.0; 2]
    }

    fn reference_force(&self) -> f64 {
        1.0
    }

    fn check(&self, _spindle: f64, _place: &dyn Fn(&str) -> String) {}

    fn check_weld(&self, _spindle: f64, _weld: &Weld, _place: &dyn Fn(&str) -> String) {}
}
