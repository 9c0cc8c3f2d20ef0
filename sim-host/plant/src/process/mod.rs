//! The processes that a tool may do to the material: one file each, and the table of them.
//!
//! A process is a [`ProcessModel`]: the force on a tool that stands at a point of the weld frame W and
//! moves. Its file holds all that is known of it: equations with their source, numbers with units and
//! ranges, what effects may act on, and what is said of it. To add one, write its file, and its line
//! in the table below. Left out: moments at the TCP, of which no process here has any.

mod friction_stir;
mod milling;
mod model;
mod none;

pub use model::{
    Process, ProcessKind, ProcessMisfit, ProcessModel, ProcessPart, Reaction, Ripple, ToolInstant,
};

use crate::input::{
    FileKind, InputError, InputFile, Quantity, TomlTable, Weld, did_you_mean, quantity,
};
use crate::robot::{Ports, ProcessPoint};
use nalgebra::Vector3;

/// The processes: one line each. A file that does not state its kind is of the first.
static PROCESSES: &[&ProcessKind] = &[&friction_stir::FRICTION_STIR, &milling::PERIPHERAL_MILLING];

/// Every process that there is.
pub fn processes() -> &'static [&'static ProcessKind] {
    PROCESSES
}

/// Every key of a number that some process states, each once.
pub fn process_keys() -> Vec<&'static str> {
    let mut keys: Vec<&'static str> = Vec::new();
    for key in PROCESSES.iter().flat_map(|kind| kind.keys) {
        if !keys.contains(key) {
            keys.push(key);
        }
    }
    keys
}

/// The range of a number of a process by its key.
pub fn process_quantity(key: &str) -> Option<&'static Quantity> {
    PROCESSES.iter().find_map(|kind| kind.quantity(key)).or_else(|| quantity(key))
}

/// Force on a tool that presses with `push`, N, moves along the seam at `feed`, m/s, and stands on
/// the line: what a weld is planned with. Mean over a turn of the spindle, in axes of W, N.
pub fn planned(process: &Process, push: f64, feed: f64) -> Vector3<f64> {
    let position = Vector3::z() * process.depth_under(push);
    let even = process.even();
    reaction(&even, &Ports::default(), 0.0, &position, &(Vector3::x() * feed), 0.0, 0.0).force
}

/// Force of the process on the tool. `position` and `velocity` of the TCP in W (origin at the start
/// of the seam, on the nominal surface); `channel` y_m, m; `spindle_angle` φ, rad.
#[inline]
pub fn reaction(
    process: &Process,
    ports: &Ports,
    time: f64,
    position: &Vector3<f64>,
    velocity: &Vector3<f64>,
    channel: f64,
    spindle_angle: f64,
) -> Reaction {
    reaction_with_trail(process, ports, time, (position, velocity), (channel, None), spindle_angle)
}

/// The same, of a tool whose path position a while before, m, may be known beside the channel.
#[inline]
pub(crate) fn reaction_with_trail(
    process: &Process,
    ports: &Ports,
    time: f64,
    (position, velocity): (&Vector3<f64>, &Vector3<f64>),
    (channel, trail): (f64, Option<f64>),
    spindle_angle: f64,
) -> Reaction {
    let point = ProcessPoint {
        time,
        position: *position,
        velocity: *velocity,
        spindle_angle,
        spindle: process.spindle,
        depth_force: 0.0,
    };
    process.model.reaction(ToolInstant { ports, ripple: &process.ripple, point, channel, trail })
}

/// Warns of implausible relations of a weld and the process that it is planned with. `place`: where
/// a key of the weld file stands.
pub fn check_weld(weld: &Weld, process: &Process, place: impl Fn(&str) -> String) {
    process.model.check_weld(process.spindle, weld, &place);
}

impl InputFile for Process {
    const KIND: FileKind = FileKind::Process;

    fn from_root(root: &TomlTable<'_>) -> Result<Self, InputError> {
        let kind = kind_of(root)?;
        let numbers = kind.keys.iter().copied().filter(|key| !key.starts_with("ripple."));
        let keys = ["schema", "kind"].into_iter().chain(numbers);
        let keys: Vec<&str> = keys.chain(kind.words.iter().copied()).chain(["ripple"]).collect();
        root.only(&keys)?;
        let process = Self {
            model: (kind.read)(root)?,
            spindle: root.quantity_in(kind.quantities, "spindle_rad_s")?,
            // A process without ripple has no [[ripple]] table: that is how TOML writes an empty
            // list of tables.
            ripple: root.each_table("ripple", ripple)?,
        };
        process.model.check(process.spindle, &|key| root.place_of(key));
        Ok(process)
    }
}

fn kind_of(root: &TomlTable<'_>) -> Result<&'static ProcessKind, InputError> {
    if !root.has("kind") {
        return Ok(PROCESSES[0]);
    }
    let read = root.text("kind")?.text;
    PROCESSES.iter().find(|kind| kind.id == read).copied().ok_or_else(|| {
        let known: Vec<&str> = PROCESSES.iter().map(|kind| kind.id).collect();
        let guess = did_you_mean(read, known.iter().copied());
        let help = "A file without `kind` is of the first.";
        root.wrong("kind", &format!("one of {}{guess}", known.join(", ")), help)
    })
}

fn ripple(table: &TomlTable<'_>) -> Result<Ripple, InputError> {
    table.only(&["order", "axial", "in_plane", "phase_rad"])?;
    Ok(Ripple {
        order: table.quantity("order")?,
        axial: table.quantity("axial")?,
        in_plane: table.quantity("in_plane")?,
        phase: table.quantity("phase_rad")?,
    })
}
