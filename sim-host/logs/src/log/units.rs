//! The units that instruments record in, and what one of each is in the unit that is used here: one
//! table.

use std::f64::consts::{PI, TAU};

/// What a number measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// Time, s.
    Time,
    /// Angle, rad.
    Angle,
    /// Angular speed, rad/s.
    AngularSpeed,
    /// Length, m.
    Length,
    /// Force, N.
    Force,
    /// Torque or moment, N·m.
    Torque,
    /// Mass, kg.
    Mass,
    /// A number without a unit.
    Number,
}

impl Dimension {
    /// The unit in which values of this dimension are held, by its name in `log.toml`.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Time => "s",
            Self::Angle => "rad",
            Self::AngularSpeed => "rad/s",
            Self::Length => "m",
            Self::Force => "N",
            Self::Torque => "Nm",
            Self::Mass => "kg",
            Self::Number => "1",
        }
    }
}

/// A unit.
#[derive(Debug, PartialEq)]
pub struct Unit {
    /// Its name in `log.toml`.
    pub name: &'static str,
    /// What it measures; `None` for a unit that takes a factor to become one (amperes).
    pub dimension: Option<Dimension>,
    /// What one of it is in the unit that is held.
    pub factor: f64,
    /// The factor as messages write it.
    pub written: &'static str,
    /// Other spellings, without blanks, dots and brackets, in small letters.
    others: &'static [&'static str],
}

const fn unit(
    name: &'static str,
    dimension: Dimension,
    factor: f64,
    written: &'static str,
    others: &'static [&'static str],
) -> Unit {
    Unit { name, dimension: Some(dimension), factor, written, others }
}

/// A reading that only a factor turns into a torque or a force.
const fn raw(name: &'static str, others: &'static [&'static str]) -> Unit {
    Unit { name, dimension: None, factor: 1.0, written: "its factor", others }
}

use Dimension::{Angle, AngularSpeed, Force, Length, Mass, Number, Time, Torque};

/// Every unit.
#[rustfmt::skip]
pub static UNITS: &[Unit] = &[
    unit("s", Time, 1.0, "1", &["sec", "second", "seconds"]),
    unit("ms", Time, 1e-3, "0.001", &["msec", "millisecond", "milliseconds"]),
    unit("us", Time, 1e-6, "1e-6", &["µs", "μs", "microseconds"]),
    unit("ns", Time, 1e-9, "1e-9", &["nanoseconds"]),
    unit("min", Time, 60.0, "60", &["minutes"]),
    unit("h", Time, 3600.0, "3600", &["hours"]),
    unit("rad", Angle, 1.0, "1", &["radian", "radians"]),
    unit("mrad", Angle, 1e-3, "0.001", &["milliradian"]),
    unit("urad", Angle, 1e-6, "1e-6", &["µrad", "μrad"]),
    unit("deg", Angle, PI / 180.0, "π/180", &["degree", "degrees", "°", "grad"]),
    unit("arcsec", Angle, PI / 648_000.0, "π/648000", &["\"", "arcseconds"]),
    unit("turn", Angle, TAU, "2π", &["rev", "turns"]),
    unit("rad/s", AngularSpeed, 1.0, "1", &["radps", "rad_s", "1/s"]),
    unit("deg/s", AngularSpeed, PI / 180.0, "π/180", &["°/s", "degps", "deg_s"]),
    unit("rpm", AngularSpeed, TAU / 60.0, "2π/60", &["1/min", "u/min", "r/min", "1_min", "min-1"]),
    unit("Hz", AngularSpeed, TAU, "2π", &["rev/s", "turn/s"]),
    unit("m", Length, 1.0, "1", &["metre", "meter", "meters"]),
    unit("km", Length, 1e3, "1000", &[]),
    unit("cm", Length, 1e-2, "0.01", &[]),
    unit("mm", Length, 1e-3, "0.001", &["millimetre", "millimeter", "millimeters"]),
    unit("um", Length, 1e-6, "1e-6", &["µm", "μm", "micron", "microns"]),
    unit("in", Length, 0.0254, "0.0254", &["inch"]),
    unit("N", Force, 1.0, "1", &["newton", "newtons"]),
    unit("kN", Force, 1e3, "1000", &[]),
    unit("daN", Force, 10.0, "10", &[]),
    unit("lbf", Force, 4.448_221_615, "4.448", &[]),
    unit("Nm", Torque, 1.0, "1", &["newtonmeter", "n*m", "n-m"]),
    unit("kNm", Torque, 1e3, "1000", &[]),
    unit("Nmm", Torque, 1e-3, "0.001", &[]),
    unit("kg", Mass, 1.0, "1", &[]),
    unit("g", Mass, 1e-3, "0.001", &["gram", "grams"]),
    unit("t", Mass, 1e3, "1000", &["tonne", "tonnes"]),
    unit("lb", Mass, 0.453_592_37, "0.4536", &["lbs"]),
    unit("1", Number, 1.0, "1", &["-"]),
    raw("A", &["ampere", "amperes", "amps"]),
    raw("%", &["percent", "prozent"]),
    raw("V", &["volt", "volts"]),
    raw("count", &["counts", "tick", "ticks", "inc", "digit", "digits", "lsb"]),
];

/// The unit of a spelling: blanks, dots and brackets do not count, and capitals only where they
/// tell two units apart.
pub fn unit_named(text: &str) -> Option<&'static Unit> {
    let bare: String = text.chars().filter(|c| !" ·.[]()^⋅".contains(*c)).collect();
    let small = bare.to_lowercase();
    let exact = UNITS.iter().find(|u| u.name == bare);
    exact.or_else(|| {
        UNITS.iter().find(|u| u.name.to_lowercase() == small || u.others.contains(&small.as_str()))
    })
}

/// Names of the units that a dimension may be given in, as messages list them.
pub(super) fn names_of(dimension: Dimension) -> String {
    let raw = matches!(dimension, Torque | Force | Angle);
    let fits = |u: &&Unit| u.dimension == Some(dimension) || (raw && u.dimension.is_none());
    UNITS.iter().filter(fits).map(|u| format!("\"{}\"", u.name)).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_vendors_are_known_and_no_spelling_is_of_two_units() {
        for (text, name) in [
            ("N·m", "Nm"),
            ("[Nm]", "Nm"),
            ("°", "deg"),
            ("DEG", "deg"),
            ("kN", "kN"),
            ("1/min", "rpm"),
            ("µm", "um"),
            ("°/s", "deg/s"),
        ] {
            assert_eq!(unit_named(text).map(|u| u.name), Some(name), "{text}");
        }
        assert!(unit_named("parsec").is_none());
        for (i, a) in UNITS.iter().enumerate() {
            for b in &UNITS[i + 1..] {
                assert_ne!(a.name.to_lowercase(), b.name.to_lowercase());
                assert!(a.others.iter().all(|o| *o != b.name && !b.others.contains(o)), "{a:?}");
            }
        }
    }
}
