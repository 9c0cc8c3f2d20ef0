//! Peripheral milling: the mechanistic force model of a helical end mill.
//!
//! At the immersion angle φ of an edge, measured from the normal of the cut surface in the spindle's
//! sense, an element dz of the edge cuts a chip of thickness h and is loaded by
//!
//! ```text
//! h = f_x sin φ + f_n cos φ,   f = v 2π/(N|ω|)        travel from tooth to tooth
//! dF_t = (K_tc h + K_te) dz,  dF_r = (K_rc h + K_re) dz,  dF_a = (K_ac h + K_ae) dz
//! dF_x = −dF_t cos φ − dF_r sin φ,  dF_n = dF_t sin φ − dF_r cos φ,  dF_z = dF_a
//! ```
//!
//! where φ lies between entry and exit: 0 to acos(1 − a_e/R) in up-milling, acos(a_e/R − 1) to π in
//! down-milling, 0 to π in a slot; n is −sgn(ω) y of W. Along the edge φ falls by 2 tan β/D a metre;
//! the integral over the axial depth is exact. Y. Altintas, Manufacturing Automation, 2nd ed.,
//! Cambridge 2012, chapter 2; over a turn the mean is that of the book, for a slot of depth a
//!
//! ```text
//! F_x = −N a c K_rc/4 − N a K_re/π,   F_n = N a c K_tc/4 + N a K_te/π
//! ```
//!
//! The axial depth is that of the file and how deep the tool stands besides; the radial one grows as
//! the tool comes closer to the material. K_ac > 0 pulls the tool out of its holder, into the plate.
//!
//! A tooth cuts what the one before left (regeneration): f = p(t) − p(t − T), T = 2π/(N|ω|). The delay
//! is taken as a lag of first order, T ẋ_m = x − x_m and T ẏ_m = y − y_m, f = p − p_m: exact for what is
//! slow against the teeth, where f = v T, and without the teeth's own vibration in the chip.
//!
//! Left out: chatter at and above the teeth's frequency, which that lag does not hold; run-out, which
//! a ripple of order 1 stands for; the moment at the TCP.

use super::model::{ProcessKind, ProcessModel, Reaction, ToolInstant};
use crate::input::{InputError, Quantity, Relation, TomlTable, Weld};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{PI, TAU};

/// Feed per tooth at which a force is one to speak of, m.
const USUAL_CHIP: f64 = 1e-4;

/// On which side of the tool the material lies.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Cut {
    /// Chips begin thin.
    Up,
    /// Chips end thin.
    Down,
    /// On both.
    Slot,
}

#[derive(Debug, Clone)]
struct PeripheralMilling {
    cut: Cut,
    /// Number N of teeth.
    teeth: f64,
    /// Diameter D, m.
    diameter: f64,
    /// Helix angle β, rad.
    helix: f64,
    /// Axial depth of cut of a tool on its nominal pose, m.
    axial_depth: f64,
    /// Radial depth of cut a_e, likewise, m.
    radial_depth: f64,
    /// K_tc, K_rc, K_ac, N/m².
    cutting: [f64; 3],
    /// K_te, K_re, K_ae, N/m.
    edge: [f64; 3],
    /// Feed per tooth below which the edge finds less than its whole length to rub on, m: a tool
    /// that stands has cut itself free.
    least_chip: f64,
    /// How far off the cut surface may be, m.
    tolerance: f64,
    /// True for the mean over a turn.
    even: bool,
}

pub(super) static PERIPHERAL_MILLING: ProcessKind = ProcessKind {
    id: "peripheral-milling",
    name: "peripheral milling",
    equation: "dF = (K_c h + K_e) dz, h = (v_x sin φ + v_n cos φ) 2π/(N|ω|), tangential, radial and axial",
    about: "The teeth of a helical end mill cut chips from an edge or a slot, with forces in the plane and no push to be held. \
            What the tooth before left is taken as a lag, and chatter near the teeth's frequency is left out.",
    keys: &[
        "cutter_diameter_m",
        "helix_rad",
        "axial_depth_m",
        "radial_depth_m",
        "tangential_cutting_n_m2",
        "radial_cutting_n_m2",
        "axial_cutting_n_m2",
        "tangential_edge_n_m",
        "radial_edge_n_m",
        "axial_edge_n_m",
        "least_chip_m",
        "tolerance_m",
        "spindle_rad_s",
        "ripple.order",
        "ripple.axial",
        "ripple.in_plane",
        "ripple.phase_rad",
    ],
    words: &["cut", "teeth"],
    quantities: &QUANTITIES_OF_MILLING,
    drawn: &[
        ("tangential_cutting_n_m2", 0),
        ("radial_cutting_n_m2", 1),
        ("tangential_edge_n_m", 2),
        ("radial_edge_n_m", 3),
        ("axial_cutting_n_m2", 4),
        ("axial_edge_n_m", 4),
    ],
    parts: &[],
    read,
};

/// Ranges of its numbers: end mills from 1 to 100 mm in light metals, steel and titanium.
#[rustfmt::skip]
static QUANTITIES_OF_MILLING: [Quantity; 13] = [
    Quantity::new("cutter_diameter_m", [1e-4, 0.5], [1e-3, 0.1], "diameter of the end mill"),
    Quantity::new("helix_rad", [1e-3, 1.4], [0.1, 1.0], "helix angle of its edges"),
    Quantity::new("axial_depth_m", [1e-6, 0.2], [1e-4, 0.05], "axial depth of cut"),
    Quantity::new("radial_depth_m", [1e-6, 0.5], [1e-4, 0.1], "radial depth of cut"),
    // Aluminium 0.2 to 1.3 GPa, steel and titanium 1.5 to 3.
    Quantity::new("tangential_cutting_n_m2", [1e6, 1e11], [1e8, 6e9], "tangential force per chip area"),
    Quantity::new("radial_cutting_n_m2", [0.0, 1e11], [1e7, 3e9], "radial force per chip area"),
    Quantity::new("axial_cutting_n_m2", [-1e11, 1e11], [0.0, 3e9], "axial force per chip area"),
    Quantity::new("tangential_edge_n_m", [0.0, 1e7], [1e3, 3e5], "tangential force per length of edge"),
    Quantity::new("radial_edge_n_m", [0.0, 1e7], [1e3, 3e5], "radial force per length of edge"),
    Quantity::new("axial_edge_n_m", [-1e7, 1e7], [0.0, 1e5], "axial force per length of edge"),
    // A third of the radius of an edge, which has 5 to 60 µm.
    Quantity::new("least_chip_m", [1e-9, 1e-3], [1e-6, 3e-5], "feed per tooth below which an edge rubs less"),
    Quantity::new("tolerance_m", [1e-6, 0.02], [1e-5, 2e-3], "how far off the cut surface may be"),
    // Up to 30 000 turns a minute.
    Quantity::new("spindle_rad_s", [-6300.0, 6300.0], [10.0, 3200.0], "speed of the spindle"),
];

fn read(root: &TomlTable<'_>) -> Result<Box<dyn ProcessModel>, InputError> {
    let number = |key: &str| root.quantity_in(&QUANTITIES_OF_MILLING, key);
    let cut = match root.text("cut")?.text {
        "up" => Cut::Up,
        "down" => Cut::Down,
        "slot" => Cut::Slot,
        _ => {
            let help = "Up: chips begin thin; down: chips end thin; slot: material on both sides.";
            return Err(root.wrong("cut", "\"up\", \"down\" or \"slot\"", help));
        }
    };
    let teeth = root.integer("teeth")?;
    if !(1..=40).contains(&teeth) {
        return Err(root.wrong("teeth", "from 1 to 40 teeth", "Count the edges of the tool."));
    }
    if number("spindle_rad_s")? == 0.0 {
        let help = "A tool that does not turn does not cut.";
        return Err(root.wrong("spindle_rad_s", "a spindle that turns", help));
    }
    let (diameter, radial_depth) = (number("cutter_diameter_m")?, number("radial_depth_m")?);
    let fits = if cut == Cut::Slot { radial_depth == diameter } else { radial_depth < diameter };
    if !fits {
        let expected = match cut {
            Cut::Slot => "the diameter of the tool, which is how wide it cuts a slot",
            Cut::Up | Cut::Down => "less than the diameter of the tool",
        };
        let help = "A tool in its whole width cuts a slot: cut = \"slot\".";
        return Err(root.wrong("radial_depth_m", expected, help));
    }
    Ok(Box::new(PeripheralMilling {
        cut,
        teeth: teeth as f64,
        diameter,
        helix: number("helix_rad")?,
        axial_depth: number("axial_depth_m")?,
        radial_depth,
        cutting: [
            number("tangential_cutting_n_m2")?,
            number("radial_cutting_n_m2")?,
            number("axial_cutting_n_m2")?,
        ],
        edge: [
            number("tangential_edge_n_m")?,
            number("radial_edge_n_m")?,
            number("axial_edge_n_m")?,
        ],
        least_chip: number("least_chip_m")?,
        tolerance: number("tolerance_m")?,
        even: false,
    }))
}

/// The value of a relation of the process, at a spindle's speed.
type OfMilling = fn(&PeripheralMilling, f64) -> f64;

#[rustfmt::skip]
static MILLING_RELATIONS: [Relation<OfMilling>; 3] = [
    Relation::new("spindle_rad_s", &["cutter_diameter_m"], [0.3, 60.0], "m/s",
        "cutting speed",
        |p, spindle| 0.5 * spindle.abs() * p.diameter),
    // Of the published tables for aluminium 0.15 to 0.6.
    Relation::new("radial_cutting_n_m2", &["tangential_cutting_n_m2"], [0.05, 1.5], "",
        "radial over tangential force",
        |p, _| p.cutting[1] / p.cutting[0]),
    Relation::new("axial_depth_m", &["cutter_diameter_m"], [0.01, 5.0], "",
        "axial depth of cut in diameters of the tool",
        |p, _| p.axial_depth / p.diameter),
];

/// Integrals over the edges in the cut, m: of sin², sin cos, cos², sin, cos and 1 of φ.
#[derive(Debug, Clone, Copy)]
struct Engaged([f64; 6]);

impl Engaged {
    fn none() -> Self {
        Self([0.0; 6])
    }

    /// Adds the integrals from one angle to another, at so much edge per radian, m.
    fn add(&mut self, from: f64, to: f64, edge: f64) {
        let primitive = |a: f64| {
            let (sine, cosine) = a.sin_cos();
            let double = 0.5 * sine * cosine;
            [0.5 * a - double, 0.5 * sine * sine, 0.5 * a + double, -cosine, sine, a]
        };
        let (low, high) = (primitive(from), primitive(to));
        for (sum, (low, high)) in self.0.iter_mut().zip(low.iter().zip(high)) {
            *sum += (high - low) * edge;
        }
    }

    /// What one more radian at an angle adds, at so much edge per radian, m.
    fn at(angle: f64, edge: f64) -> Self {
        let (s, c) = angle.sin_cos();
        Self([s * s, s * c, c * c, s, c, 1.0].map(|v| v * edge))
    }
}

impl PeripheralMilling {
    /// Entry and exit angle of a tool `closer` m to the material than on its line.
    fn immersion(&self, closer: f64) -> [f64; 2] {
        let radius = 0.5 * self.diameter;
        let share = ((self.radial_depth + closer) / radius).clamp(0.0, 2.0);
        match self.cut {
            Cut::Up => [0.0, (1.0 - share).acos()],
            Cut::Down => [(share - 1.0).acos(), PI],
            Cut::Slot => [0.0, PI],
        }
    }

    /// The edges in the cut, as a mean over a turn.
    fn mean(&self, depth: f64, [entry, exit]: [f64; 2]) -> Engaged {
        let mut engaged = Engaged::none();
        engaged.add(entry, exit, self.teeth * depth / TAU);
        engaged
    }

    /// The edges in the cut with the tip of one of them at an angle.
    fn turned(&self, depth: f64, [entry, exit]: [f64; 2], angle: f64) -> Engaged {
        let mut engaged = Engaged::none();
        let fall = 2.0 * self.helix.tan() / self.diameter;
        for tooth in 0..self.teeth as usize {
            let tip = (angle + TAU * tooth as f64 / self.teeth).rem_euclid(TAU);
            let top = tip - fall * depth;
            let mut turn = 0.0;
            while exit - turn > top {
                let (from, to) = ((entry - turn).max(top), (exit - turn).min(tip));
                if from < to {
                    engaged.add(from, to, 1.0 / fall);
                }
                turn += TAU;
            }
        }
        engaged
    }

    /// The mean force at a feed per tooth, m, of a tool on its nominal pose.
    fn planned_force(&self, chip: f64) -> Vector3<f64> {
        let mean = self.mean(self.axial_depth, self.immersion(0.0));
        self.force(mean, [chip, 0.0], (chip / self.least_chip).clamp(0.0, 1.0))
    }

    /// Force along x, along the normal and along z: `chip` is the travel per tooth along x and along
    /// the normal, m; `rubs` the share of the edge forces.
    fn force(
        &self,
        Engaged([ss, sc, cc, s, c, all]): Engaged,
        chip: [f64; 2],
        rubs: f64,
    ) -> Vector3<f64> {
        let ([kt, kr, ka], [et, er, ea]) = (self.cutting, self.edge.map(|k| k * rubs));
        let by_sine = chip[0] * ss + chip[1] * sc;
        let by_cosine = chip[0] * sc + chip[1] * cc;
        Vector3::new(
            -(kt * by_cosine + et * c) - (kr * by_sine + er * s),
            (kt * by_sine + et * s) - (kr * by_cosine + er * c),
            ka * (chip[0] * s + chip[1] * c) + ea * all,
        )
    }
}

impl ProcessModel for PeripheralMilling {
    fn kind(&self) -> &'static ProcessKind {
        &PERIPHERAL_MILLING
    }

    fn boxed(&self) -> Box<dyn ProcessModel> {
        Box::new(self.clone())
    }

    fn number(&mut self, key: &str) -> Option<&mut f64> {
        let ([kt, kr, ka], [et, er, ea]) = (&mut self.cutting, &mut self.edge);
        Some(match key {
            "cutter_diameter_m" => &mut self.diameter,
            "helix_rad" => &mut self.helix,
            "axial_depth_m" => &mut self.axial_depth,
            "radial_depth_m" => &mut self.radial_depth,
            "tangential_cutting_n_m2" => kt,
            "radial_cutting_n_m2" => kr,
            "axial_cutting_n_m2" => ka,
            "tangential_edge_n_m" => et,
            "radial_edge_n_m" => er,
            "axial_edge_n_m" => ea,
            "least_chip_m" => &mut self.least_chip,
            "tolerance_m" => &mut self.tolerance,
            _ => return None,
        })
    }

    fn reaction(&self, tool: ToolInstant<'_>) -> Reaction {
        let ToolInstant { ports, mut point, channel, trail, .. } = tool;
        let nothing = Reaction {
            force: Vector3::zeros(),
            stiffness: Matrix3::zeros(),
            damping: Matrix3::zeros(),
            channel_rate: 0.0,
            trail_rate: 0.0,
        };
        // From the normal's axis to W and back.
        let sense = point.spindle.signum();
        let normal = -sense;
        let between = self.trail_time(point.spindle);
        let way = match trail {
            Some(trail) => [point.position.x - trail, point.position.y - channel],
            None => [point.velocity.x * between, point.velocity.y * between],
        };
        let lag = |way: f64| if trail.is_some() { way / between } else { 0.0 };
        let nothing = Reaction { channel_rate: lag(way[1]), trail_rate: lag(way[0]), ..nothing };
        let chip = [way[0], normal * way[1]];
        let rubs = (chip[0] / self.least_chip).clamp(0.0, 1.0);
        // In up-milling the material lies along the normal, in down-milling against it.
        let side = match self.cut {
            Cut::Up => 1.0,
            Cut::Down => -1.0,
            Cut::Slot => 0.0,
        };
        let immersion = self.immersion(side * normal * point.position.y);
        let surface: f64 = ports.surface.iter().map(|t| t.surface(&point)).sum();
        let open = self.axial_depth + point.position.z + surface;
        // The forces are in proportion to the depth, which grows where a pull lifts the surface.
        let per_depth = self.force(self.mean(1.0, immersion), chip, rubs);
        let give: f64 = ports.surface.iter().map(|t| t.surface_compliance()).sum();
        let depth = open / (1.0 - give * per_depth.z);
        // A depth that is not a number makes a force that is not, and the run ends.
        if depth <= 0.0 {
            return nothing;
        }
        point.depth_force = -per_depth.z * depth;
        let mean = self.mean(depth, immersion);
        let engaged = if self.even {
            mean
        } else {
            self.turned(depth, immersion, sense * point.spindle_angle)
        };
        let mut force = self.force(engaged, chip, rubs);
        force.y *= normal;
        force.x *= ports.process.iter().map(|t| t.drag(&point)).product::<f64>();
        force.y -= ports.process.iter().map(|t| t.lateral_force(&point)).sum::<f64>();
        let [axial, in_plane] = tool.ripple_factors();
        force.component_mul_assign(&Vector3::new(in_plane, in_plane, axial));
        for term in &ports.process {
            force = term.process_force(&point, force);
        }

        let in_w = |force: Vector3<f64>| Vector3::new(force.x, normal * force.y, force.z);
        let mut stiffness = Matrix3::zeros();
        stiffness.set_column(2, &-in_w(per_depth));
        // The radial depth moves the exit angle in up-milling, the entry angle in down-milling.
        let edge = self.teeth * depth / TAU;
        let [entry, exit] = immersion;
        let bound = if self.cut == Cut::Up { exit } else { entry };
        let sine = bound.sin();
        if self.cut != Cut::Slot && sine > 0.0 {
            let per_metre = 2.0 / (self.diameter * sine) * side * normal;
            let gained = self.force(Engaged::at(bound, edge), chip, rubs) * per_metre;
            stiffness.set_column(1, &-in_w(gained));
        }
        // A chip is as long as the tool has gone from the place before, or as it goes in that time.
        let mut damping = Matrix3::zeros();
        for (axis, chip) in [[1.0, 0.0], [0.0, normal]].into_iter().enumerate() {
            let slope = -in_w(self.force(mean, chip, 0.0));
            match trail {
                Some(_) => stiffness.set_column(axis, &(stiffness.column(axis) + slope)),
                None => damping.set_column(axis, &(slope * between)),
            }
        }
        Reaction { force, stiffness, damping, ..nothing }
    }

    fn even(&self) -> Box<dyn ProcessModel> {
        Box::new(Self { even: true, ..self.clone() })
    }

    fn tool_diameter(&self) -> f64 {
        self.diameter
    }

    fn lateral_tolerance(&self) -> f64 {
        self.tolerance
    }

    fn planned_drag(&self, spindle: f64, _push: f64, feed: f64) -> [f64; 2] {
        let force = self.planned_force(feed * self.trail_time(spindle));
        [force.x.abs(), force.y.abs()]
    }

    /// Of the whole cut at a usual feed per tooth.
    fn reference_force(&self) -> f64 {
        self.planned_force(USUAL_CHIP).norm()
    }

    fn trail_time(&self, spindle: f64) -> f64 {
        TAU / (self.teeth * spindle.abs())
    }

    fn own_orders(&self) -> Vec<f64> {
        [1.0, 2.0, 3.0].map(|n| n * self.teeth).to_vec()
    }

    fn check(&self, spindle: f64, place: &dyn Fn(&str) -> String) {
        for relation in &MILLING_RELATIONS {
            relation.check((relation.of)(self, spindle), place);
        }
    }

    fn check_weld(&self, spindle: f64, weld: &Weld, place: &dyn Fn(&str) -> String) {
        // A chip of a few micrometres rubs, one of a millimetre breaks the tooth.
        let with = &["spindle_rad_s", "teeth"];
        let feed_per_tooth =
            Relation::new("feed_m_s", with, [0.01, 1.0], "mm", "feed per tooth", ());
        feed_per_tooth.check(weld.feed * TAU / (self.teeth * spindle.abs()) * 1e3, place);
    }
}
