//! What numbers of a weld and its process are together: one table of plausible relations.
//!
//! A spindle at 600 rad/s turns, a pin of 50 mm is made, and 4 kN·s/m of drag is somewhere: a
//! number by itself does not tell that it is in another unit or off by a factor of ten. Beside the
//! numbers that it belongs to, it does. A relation outside its range is a warning, as a quantity
//! outside its plausible range is.

use super::quantity::{short, warn};
use super::{Process, Weld};

/// A relation of several numbers.
#[derive(Debug)]
pub struct Relation {
    /// The key at which a warning stands.
    pub key: &'static str,
    /// The others that it is made from.
    pub with: &'static [&'static str],
    /// What it is.
    pub meaning: &'static str,
    /// Its unit; empty of a share.
    pub unit: &'static str,
    /// Least and largest value that is taken without a warning. Zero stands for something that is
    /// not there.
    pub plausible: [f64; 2],
    /// Its value.
    pub of: RelationOf,
}

/// What a relation is made from.
#[derive(Debug, Clone, Copy)]
pub enum RelationOf {
    /// Numbers of a process file.
    Process(fn(&Process) -> f64),
    /// Numbers of a weld file and of the process file.
    Weld(fn(&Weld, &Process) -> f64),
}

use RelationOf::{Process as OfProcess, Weld as OfWeld};

const fn row(
    key: &'static str,
    with: &'static [&'static str],
    unit: &'static str,
    plausible: [f64; 2],
    meaning: &'static str,
    of: RelationOf,
) -> Relation {
    Relation { key, with, meaning, unit, plausible, of }
}

/// Every relation. Grades: of tool and feed from the practice of friction stir welding; of the
/// macroscopic model a factor of seven about the published lap weld, whose numbers for other welds
/// are scaled from it.
#[rustfmt::skip]
pub static RELATIONS: &[Relation] = &[
    // 2 kN on a pin of 5 mm for soft sheet, 18 kN for a lap weld in 2024.
    row("pin_diameter_m", &["reference_force_n"], "N/mm²", [60.0, 3000.0],
        "push over the square of the pin's diameter",
        OfProcess(|p| p.reference_force / p.pin_diameter.powi(2) * 1e-6)),
    // 4 mm at 1400 rpm: 0.3 m/s.
    row("spindle_rad_s", &["pin_diameter_m"], "m/s", [0.03, 1.2],
        "speed of the pin's surface",
        OfProcess(|p| 0.5 * p.spindle.abs() * p.pin_diameter)),
    // 22 s/m: at 10 mm/s 22 % of the push.
    row("feed_drag_ns_m", &["reference_force_n"], "s/m", [3.0, 150.0],
        "drag along the weld per feed and push",
        OfProcess(|p| p.feed_drag / p.reference_force)),
    row("lateral_damping_ns_m", &["reference_force_n"], "s/m", [3.0, 150.0],
        "drag across the weld per speed and push",
        OfProcess(|p| p.lateral_damping / p.reference_force)),
    row("lateral_stiffness_n_m", &["reference_force_n"], "1/m", [40.0, 2000.0],
        "stiffness across the weld per push",
        OfProcess(|p| p.lateral_stiffness / p.reference_force)),
    row("depth_damping_ns_m", &["depth_stiffness_n_m"], "s", [0.006, 0.3],
        "time in which the material gives way in depth",
        OfProcess(|p| p.depth_damping / p.depth_stiffness)),
    // A shoulder has two to four times the pin's diameter.
    row("memory_length_m", &["pin_diameter_m"], "", [0.25, 8.0],
        "travel over which the channel follows, in diameters of the pin",
        OfProcess(|p| p.memory_length / p.pin_diameter)),
    row("force_n", &["reference_force_n"], "", [0.2, 5.0],
        "push over the one at which the process is stated",
        OfWeld(|w, p| w.force / p.reference_force)),
    // From hot to cold welds.
    row("feed_m_s", &["spindle_rad_s"], "mm", [0.05, 3.0],
        "feed per turn of the spindle",
        OfWeld(|w, p| w.feed * std::f64::consts::TAU / p.spindle.abs() * 1e3)),
    // Measured in friction stir welds: 5 to 60 %.
    row("feed_m_s", &["feed_drag_ns_m", "reference_force_n"], "", [0.03, 1.0],
        "drag along the weld over the push",
        OfWeld(|w, p| w.feed * p.feed_drag / p.reference_force)),
    row("initial_depth_m", &["depth_stiffness_n_m", "force_n"], "", [0.0, 3.0],
        "push at the start, under position control, over the push of the weld",
        OfWeld(|w, p| w.initial_depth * p.depth_stiffness / w.force)),
];

/// Warns of implausible relations of a process. `place`: where a key stands.
pub(super) fn check_process(process: &Process, place: impl Fn(&str) -> String) {
    for relation in RELATIONS {
        if let OfProcess(of) = relation.of {
            relation.check(of(process), &place);
        }
    }
}

/// Warns of implausible relations of a weld and the process that it is planned with. `place`: where
/// a key of the weld file stands.
pub fn check_weld(weld: &Weld, process: &Process, place: impl Fn(&str) -> String) {
    for relation in RELATIONS {
        if let OfWeld(of) = relation.of {
            relation.check(of(weld, process), &place);
        }
    }
}

impl Relation {
    fn check(&self, value: f64, place: &impl Fn(&str) -> String) {
        let [low, high] = self.plausible;
        let is_there = value != 0.0 && value.is_finite();
        if !is_there || (low..=high).contains(&value) {
            return;
        }
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let with = self.with.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(" and ");
        warn(format!(
            "{}: `{}` does not fit {with}: {} is {}{unit}; plausible are {} to {}{unit}",
            place(self.key),
            self.key,
            self.meaning,
            rounded(value),
            short(low),
            short(high),
        ));
    }
}

/// Three digits: more are none of a relation's.
fn rounded(x: f64) -> String {
    short(format!("{x:.2e}").parse().unwrap_or(x))
}
