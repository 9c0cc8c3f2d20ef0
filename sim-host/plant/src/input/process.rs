//! The welding process: `process/1`.

use super::relation::Relation;
use super::{FileKind, InputError, InputFile, TomlTable};

/// Macroscopic three-axis visco-elastic model of friction stir welding, in the weld frame W
/// (x along the weld, z along the tool into the material).
#[derive(Debug, Clone, PartialEq)]
pub struct Process {
    /// Stiffness k_z of the material against depth, N/m.
    pub depth_stiffness: f64,
    /// Damping b_z along the depth, N·s/m.
    pub depth_damping: f64,
    /// Drag c_x along the weld at the reference force, N·s/m.
    pub feed_drag: f64,
    /// Damping c_y across the weld at the reference force, N·s/m.
    pub lateral_damping: f64,
    /// Stiffness k_y against the plastic channel behind the tool, at the reference force, N/m.
    pub lateral_stiffness: f64,
    /// Travel L over which the channel follows the tool, m.
    pub memory_length: f64,
    /// Transversal force per feed force; the sign of the force follows the spindle's.
    pub lateral_ratio: f64,
    /// Depth force at which drag and lateral terms are stated, N.
    pub reference_force: f64,
    /// Spindle speed, rad/s, positive about the tool's z axis.
    pub spindle: f64,
    /// Diameter of the pin, m.
    pub pin_diameter: f64,
    /// Ripple locked to the spindle angle φ: each force is multiplied by 1 + Σ
    /// amplitude·sin(order·φ + phase).
    pub ripple: Vec<Ripple>,
}

/// One order of the ripple.
#[derive(Debug, Clone, PartialEq)]
pub struct Ripple {
    /// Periods per spindle turn.
    pub order: f64,
    /// Relative amplitude of the depth force.
    pub axial: f64,
    /// Relative amplitude of the forces in the plane of the plate.
    pub in_plane: f64,
    /// Phase at spindle angle 0, rad.
    pub phase: f64,
}

/// The value of a relation of a process.
type OfProcess = fn(&Process) -> f64;

/// Relations of a process. Grades: of the tool from the practice of friction stir welding; of the
/// macroscopic model a factor of seven about the published lap weld, from which the numbers of
/// others are scaled.
pub static PROCESS_RELATIONS: [Relation<OfProcess>; 7] = [
    // 2 kN on a pin of 5 mm for soft sheet, 18 kN for a lap weld in 2024.
    Relation {
        key: "pin_diameter_m",
        with: &["reference_force_n"],
        unit: "N/mm²",
        plausible: [60.0, 3000.0],
        meaning: "push over the square of the pin's diameter",
        of: |p| p.reference_force / p.pin_diameter.powi(2) * 1e-6,
    },
    // 4 mm at 1400 rpm: 0.3 m/s.
    Relation {
        key: "spindle_rad_s",
        with: &["pin_diameter_m"],
        unit: "m/s",
        plausible: [0.03, 1.2],
        meaning: "speed of the pin's surface",
        of: |p| 0.5 * p.spindle.abs() * p.pin_diameter,
    },
    // 22 s/m: at 10 mm/s 22 % of the push.
    Relation {
        key: "feed_drag_ns_m",
        with: &["reference_force_n"],
        unit: "s/m",
        plausible: [3.0, 150.0],
        meaning: "drag along the weld per feed and push",
        of: |p| p.feed_drag / p.reference_force,
    },
    Relation {
        key: "lateral_damping_ns_m",
        with: &["reference_force_n"],
        unit: "s/m",
        plausible: [3.0, 150.0],
        meaning: "drag across the weld per speed and push",
        of: |p| p.lateral_damping / p.reference_force,
    },
    Relation {
        key: "lateral_stiffness_n_m",
        with: &["reference_force_n"],
        unit: "1/m",
        plausible: [40.0, 2000.0],
        meaning: "stiffness across the weld per push",
        of: |p| p.lateral_stiffness / p.reference_force,
    },
    Relation {
        key: "depth_damping_ns_m",
        with: &["depth_stiffness_n_m"],
        unit: "s",
        plausible: [0.006, 0.3],
        meaning: "time in which the material gives way in depth",
        of: |p| p.depth_damping / p.depth_stiffness,
    },
    // A shoulder has two to four times the pin's diameter.
    Relation {
        key: "memory_length_m",
        with: &["pin_diameter_m"],
        unit: "",
        plausible: [0.25, 8.0],
        meaning: "travel over which the channel follows, in diameters of the pin",
        of: |p| p.memory_length / p.pin_diameter,
    },
];

/// A number of the process by its key: one place, or one for every order of the ripple.
type ProcessNumber = (&'static str, fn(&mut Process) -> Vec<&mut f64>);

impl Process {
    /// Every number that a file states, by its key; those of the ripple as `ripple.axial`.
    pub const NUMBERS: [ProcessNumber; 14] = [
        ("depth_stiffness_n_m", |p| vec![&mut p.depth_stiffness]),
        ("depth_damping_ns_m", |p| vec![&mut p.depth_damping]),
        ("feed_drag_ns_m", |p| vec![&mut p.feed_drag]),
        ("lateral_damping_ns_m", |p| vec![&mut p.lateral_damping]),
        ("lateral_stiffness_n_m", |p| vec![&mut p.lateral_stiffness]),
        ("memory_length_m", |p| vec![&mut p.memory_length]),
        ("lateral_ratio", |p| vec![&mut p.lateral_ratio]),
        ("reference_force_n", |p| vec![&mut p.reference_force]),
        ("spindle_rad_s", |p| vec![&mut p.spindle]),
        ("pin_diameter_m", |p| vec![&mut p.pin_diameter]),
        ("ripple.order", |p| p.ripple.iter_mut().map(|line| &mut line.order).collect()),
        ("ripple.axial", |p| p.ripple.iter_mut().map(|line| &mut line.axial).collect()),
        ("ripple.in_plane", |p| p.ripple.iter_mut().map(|line| &mut line.in_plane).collect()),
        ("ripple.phase_rad", |p| p.ripple.iter_mut().map(|line| &mut line.phase).collect()),
    ];
}

impl InputFile for Process {
    const KIND: FileKind = FileKind::Process;

    fn from_root(root: &TomlTable<'_>) -> Result<Self, InputError> {
        root.only(&[
            "schema",
            "depth_stiffness_n_m",
            "depth_damping_ns_m",
            "feed_drag_ns_m",
            "lateral_damping_ns_m",
            "lateral_stiffness_n_m",
            "memory_length_m",
            "lateral_ratio",
            "reference_force_n",
            "spindle_rad_s",
            "pin_diameter_m",
            "ripple",
        ])?;
        let process = Self {
            depth_stiffness: root.quantity("depth_stiffness_n_m")?,
            depth_damping: root.quantity("depth_damping_ns_m")?,
            feed_drag: root.quantity("feed_drag_ns_m")?,
            lateral_damping: root.quantity("lateral_damping_ns_m")?,
            lateral_stiffness: root.quantity("lateral_stiffness_n_m")?,
            memory_length: root.quantity("memory_length_m")?,
            lateral_ratio: root.quantity("lateral_ratio")?,
            reference_force: root.quantity("reference_force_n")?,
            spindle: root.quantity("spindle_rad_s")?,
            pin_diameter: root.quantity("pin_diameter_m")?,
            // A process without ripple has no [[ripple]] table: that is how TOML writes an empty
            // list of tables.
            ripple: if root.has("ripple") {
                root.tables("ripple")?.iter().map(ripple).collect::<Result<_, _>>()?
            } else {
                Vec::new()
            },
        };
        for relation in &PROCESS_RELATIONS {
            relation.check((relation.of)(&process), &|key| root.place_of(key));
        }
        Ok(process)
    }
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
