//! Friction stir welding: a macroscopic visco-elastic model with ripple locked to the spindle.
//!
//! With p the TCP and s the nominal surface point in W, d = (p − s)·z, d₊ = max(d, 0), e = F_d /
//! reference force:
//!
//! ```text
//! F_d = max(0, k_z d₊ + b_z ḋ·[d > 0])                                 along −z
//! F_f = c_x v_x e                                                       along −x
//! F_l = r F_f sgn(ω) + (c_y v_y + k_y (y − y_m)) e,  ẏ_m = (y − y_m)|v_x|/L   along −y
//! ```
//!
//! each × (1 + Σ aₙ sin(nφ + ψₙ)), φ̇ = ω; axial amplitudes for F_d, in-plane ones for F_f and F_l.
//! No moment at the TCP.

use super::model::{ProcessKind, ProcessModel, ProcessPart, Reaction, ToolInstant};
use crate::input::{InputError, Quantity, Relation, TomlTable, Weld};
use nalgebra::{Matrix3, Vector3};

/// Macroscopic three-axis visco-elastic model of friction stir welding, in the weld frame W
/// (x along the weld, z along the tool into the material).
#[derive(Debug, Clone)]
struct FrictionStir {
    /// Stiffness k_z of the material against depth, N/m.
    depth_stiffness: f64,
    /// Damping b_z along the depth, N·s/m.
    depth_damping: f64,
    /// Drag c_x along the weld at the reference force, N·s/m.
    feed_drag: f64,
    /// Damping c_y across the weld at the reference force, N·s/m.
    lateral_damping: f64,
    /// Stiffness k_y against the plastic channel behind the tool, at the reference force, N/m.
    lateral_stiffness: f64,
    /// Travel L over which the channel follows the tool, m.
    memory_length: f64,
    /// Transversal force per feed force; the sign of the force follows the spindle's.
    lateral_ratio: f64,
    /// Depth force at which drag and lateral terms are stated, N.
    reference_force: f64,
    /// Diameter of the pin, m.
    pin_diameter: f64,
}

pub(super) static FRICTION_STIR: ProcessKind = ProcessKind {
    id: "friction-stir-welding",
    name: "friction stir welding",
    equation: "F_d = k_z d + b_z ḋ, F_f = c_x v_x e, F_l = r F_f sgn(ω) + (c_y v_y + k_y (y − y_m)) e, e = F_d/F_ref",
    about: "A pin under a push of kilonewtons stirs the material; forces in the plane are in proportion to the push. \
            Heat, and what it does to the material, is left out.",
    keys: &[
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
        "ripple.order",
        "ripple.axial",
        "ripple.in_plane",
        "ripple.phase_rad",
    ],
    words: &[],
    quantities: &QUANTITIES_OF_FRICTION_STIR,
    drawn: &[
        ("depth_stiffness_n_m", 0),
        ("depth_damping_ns_m", 0),
        ("feed_drag_ns_m", 1),
        ("lateral_damping_ns_m", 2),
        ("lateral_stiffness_n_m", 3),
        ("lateral_ratio", 4),
    ],
    parts: &[ProcessPart::Drag, ProcessPart::Push],
    read,
};

/// Ranges of its numbers.
#[rustfmt::skip]
static QUANTITIES_OF_FRICTION_STIR: [Quantity; 9] = [
    // Of the macroscopic model as published for aluminium: 5e6 to 90e6.
    Quantity::new("depth_stiffness_n_m", [1e3, 1e11], [4e6, 1e8], "stiffness of the material in depth"),
    Quantity::new("depth_damping_ns_m", [0.0, 1e10], [0.0, 1e7], "damping of the material in depth"),
    Quantity::new("feed_drag_ns_m", [0.0, 1e10], [0.0, 4e6], "drag along the weld"),
    Quantity::new("lateral_damping_ns_m", [0.0, 1e10], [0.0, 4e6], "damping across the weld"),
    Quantity::new("lateral_stiffness_n_m", [0.0, 1e11], [0.0, 5e7], "stiffness across the weld"),
    // A shoulder radius.
    Quantity::new("memory_length_m", [1e-6, 1.0], [1e-3, 0.04], "travel over which the channel follows"),
    Quantity::new("lateral_ratio", [0.0, 100.0], [0.0, 1.0], "transversal force per feed force"),
    Quantity::new("reference_force_n", [1.0, 1e7], [500.0, 5e4], "depth force at which drag is stated"),
    // Pins for plates of 1 to 25 mm.
    Quantity::new("pin_diameter_m", [1e-5, 0.2], [1e-3, 0.02], "diameter of the pin"),
];

fn read(root: &TomlTable<'_>) -> Result<Box<dyn ProcessModel>, InputError> {
    let number = |key: &str| root.quantity_in(&QUANTITIES_OF_FRICTION_STIR, key);
    Ok(Box::new(FrictionStir {
        depth_stiffness: number("depth_stiffness_n_m")?,
        depth_damping: number("depth_damping_ns_m")?,
        feed_drag: number("feed_drag_ns_m")?,
        lateral_damping: number("lateral_damping_ns_m")?,
        lateral_stiffness: number("lateral_stiffness_n_m")?,
        memory_length: number("memory_length_m")?,
        lateral_ratio: number("lateral_ratio")?,
        reference_force: number("reference_force_n")?,
        pin_diameter: number("pin_diameter_m")?,
    }))
}

/// The value of a relation of the process, at a spindle's speed.
type OfFrictionStir = fn(&FrictionStir, f64) -> f64;

/// Relations of the process. Grades: of the tool from the practice of friction stir welding; of the
/// macroscopic model a factor of seven about the published lap weld, from which the numbers of
/// others are scaled.
#[rustfmt::skip]
static PROCESS_RELATIONS: [Relation<OfFrictionStir>; 7] = [
    // 2 kN on a pin of 5 mm for soft sheet, 18 kN for a lap weld in 2024.
    Relation::new("pin_diameter_m", &["reference_force_n"], [60.0, 3000.0], "N/mm²",
        "push over the square of the pin's diameter",
        |p, _| p.reference_force / p.pin_diameter.powi(2) * 1e-6),
    // 4 mm at 1400 rpm: 0.3 m/s.
    Relation::new("spindle_rad_s", &["pin_diameter_m"], [0.03, 1.2], "m/s",
        "speed of the pin's surface",
        |p, spindle| 0.5 * spindle.abs() * p.pin_diameter),
    // 22 s/m: at 10 mm/s 22 % of the push.
    Relation::new("feed_drag_ns_m", &["reference_force_n"], [3.0, 150.0], "s/m",
        "drag along the weld per feed and push",
        |p, _| p.feed_drag / p.reference_force),
    Relation::new("lateral_damping_ns_m", &["reference_force_n"], [3.0, 150.0], "s/m",
        "drag across the weld per speed and push",
        |p, _| p.lateral_damping / p.reference_force),
    Relation::new("lateral_stiffness_n_m", &["reference_force_n"], [40.0, 2000.0], "1/m",
        "stiffness across the weld per push",
        |p, _| p.lateral_stiffness / p.reference_force),
    Relation::new("depth_damping_ns_m", &["depth_stiffness_n_m"], [0.006, 0.3], "s",
        "time in which the material gives way in depth",
        |p, _| p.depth_damping / p.depth_stiffness),
    // A shoulder has two to four times the pin's diameter.
    Relation::new("memory_length_m", &["pin_diameter_m"], [0.25, 8.0], "",
        "travel over which the channel follows, in diameters of the pin",
        |p, _| p.memory_length / p.pin_diameter),
];

/// The value of a relation of a weld and its process, at a spindle's speed.
type OfWeld = fn(&Weld, &FrictionStir, f64) -> f64;

/// Relations of a weld and the process that it is planned with, graded as those of a process.
#[rustfmt::skip]
static WELD_RELATIONS: [Relation<OfWeld>; 4] = [
    Relation::new("force_n", &["reference_force_n"], [0.2, 5.0], "",
        "push over the one at which the process is stated",
        |w, p, _| w.force / p.reference_force),
    // From hot to cold welds.
    Relation::new("feed_m_s", &["spindle_rad_s"], [0.05, 3.0], "mm",
        "feed per turn of the spindle",
        |w, _, spindle| w.feed * std::f64::consts::TAU / spindle.abs() * 1e3),
    // Measured in friction stir welds: 5 to 60 %.
    Relation::new("feed_m_s", &["feed_drag_ns_m", "reference_force_n"], [0.03, 1.0], "",
        "drag along the weld over the push",
        |w, p, _| w.feed * p.feed_drag / p.reference_force),
    Relation::new("initial_depth_m", &["depth_stiffness_n_m", "force_n"], [0.0, 3.0], "",
        "push at the start, under position control, over the push of the weld",
        |w, p, _| w.initial_depth * p.depth_stiffness / w.force),
];

impl ProcessModel for FrictionStir {
    fn kind(&self) -> &'static ProcessKind {
        &FRICTION_STIR
    }

    fn boxed(&self) -> Box<dyn ProcessModel> {
        Box::new(self.clone())
    }

    fn number(&mut self, key: &str) -> Option<&mut f64> {
        Some(match key {
            "depth_stiffness_n_m" => &mut self.depth_stiffness,
            "depth_damping_ns_m" => &mut self.depth_damping,
            "feed_drag_ns_m" => &mut self.feed_drag,
            "lateral_damping_ns_m" => &mut self.lateral_damping,
            "lateral_stiffness_n_m" => &mut self.lateral_stiffness,
            "memory_length_m" => &mut self.memory_length,
            "lateral_ratio" => &mut self.lateral_ratio,
            "reference_force_n" => &mut self.reference_force,
            "pin_diameter_m" => &mut self.pin_diameter,
            _ => return None,
        })
    }

    #[inline]
    fn reaction(&self, tool: ToolInstant<'_>) -> Reaction {
        let ToolInstant { ports, mut point, channel, .. } = tool;
        let (position, velocity) = (point.position, point.velocity);
        let channel_rate = (position.y - channel) * velocity.x.abs() / self.memory_length;
        let surface: f64 = ports.surface.iter().map(|t| t.surface(&point)).sum();
        let depth = position.z + surface;
        // A surface that gives way by F_d/k: F_d = k_z (d − F_d/k) + b_z ḋ, solved for F_d.
        let give: f64 = ports.surface.iter().map(|t| t.surface_compliance()).sum();
        let share = 1.0 / (1.0 + self.depth_stiffness * give);
        let push = share * (self.depth_stiffness * depth + self.depth_damping * velocity.z);
        // A depth that is not a number makes a force that is not, and the run ends; it must not
        // pass for no contact.
        let depth_force = if depth <= 0.0 || push < 0.0 { 0.0 } else { push };
        if depth_force == 0.0 {
            return Reaction {
                force: Vector3::zeros(),
                stiffness: Matrix3::zeros(),
                damping: Matrix3::zeros(),
                channel_rate,
                trail_rate: 0.0,
            };
        }
        point.depth_force = depth_force;
        let [axial, in_plane] = tool.ripple_factors();
        let e = depth_force / self.reference_force;
        let (mut drag, mut exponent) = (self.feed_drag, 1.0);
        for term in &ports.process {
            drag *= term.drag(&point);
            exponent += term.drag_exponent(&point);
        }
        let feed = drag * velocity.x * e;
        let turn = self.lateral_ratio * point.spindle.signum();
        let across =
            self.lateral_damping * velocity.y + self.lateral_stiffness * (position.y - channel);
        let lateral = turn * feed
            + across * e
            + ports.process.iter().map(|t| t.lateral_force(&point)).sum::<f64>();
        let mut force = -Vector3::new(feed * in_plane, lateral * in_plane, depth_force * axial);
        for term in &ports.process {
            force = term.process_force(&point, force);
        }

        // Drag and lateral force scale with e, so depth enters all three rows; feed enters the
        // lateral one through r.
        let per_force = 1.0 / self.reference_force;
        let by_depth = Vector3::new(
            drag * velocity.x * per_force * in_plane,
            (turn * drag * velocity.x + across) * per_force * in_plane,
            axial,
        );
        let mut stiffness = Matrix3::zeros();
        stiffness.set_column(2, &(by_depth * self.depth_stiffness * share));
        stiffness[(1, 1)] = self.lateral_stiffness * e * in_plane;
        let mut damping = Matrix3::zeros();
        damping.set_column(2, &(by_depth * self.depth_damping * share));
        damping[(0, 0)] = exponent * drag * e * in_plane;
        damping[(1, 0)] = turn * exponent * drag * e * in_plane;
        damping[(1, 1)] = self.lateral_damping * e * in_plane;
        Reaction { force, stiffness, damping, channel_rate, trail_rate: 0.0 }
    }

    fn tool_diameter(&self) -> f64 {
        self.pin_diameter
    }

    /// Half the pin: farther off, the joint line of a butt weld is missed.
    fn lateral_tolerance(&self) -> f64 {
        0.5 * self.pin_diameter
    }

    fn tolerance_name(&self) -> &'static str {
        "half the pin"
    }

    fn depth_stiffness(&self) -> f64 {
        self.depth_stiffness
    }

    fn plane_follows_push(&self) -> bool {
        true
    }

    fn planned_drag(&self, _spindle: f64, push: f64, feed: f64) -> [f64; 2] {
        let drag = self.feed_drag * feed * push / self.reference_force;
        [drag, self.lateral_ratio * drag]
    }

    fn reference_force(&self) -> f64 {
        self.reference_force
    }

    fn memory_length(&self) -> f64 {
        self.memory_length
    }

    fn channel_stiffness(&self, push: f64) -> f64 {
        self.lateral_stiffness * (push / self.reference_force)
    }

    fn check(&self, spindle: f64, place: &dyn Fn(&str) -> String) {
        for relation in &PROCESS_RELATIONS {
            relation.check((relation.of)(self, spindle), place);
        }
    }

    fn check_weld(&self, spindle: f64, weld: &Weld, place: &dyn Fn(&str) -> String) {
        for relation in &WELD_RELATIONS {
            relation.check((relation.of)(weld, self, spindle), place);
        }
    }
}
