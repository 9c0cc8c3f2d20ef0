//! What numbers of files are together: a plausible range of a relation.
//!
//! A spindle at 600 rad/s turns, a pin of 50 mm is made, and 4 kN·s/m of drag is somewhere: a
//! number by itself does not tell that it is in another unit or off by a factor of ten. Beside the
//! numbers that it belongs to, it does. A relation outside its range is a warning, as a quantity
//! outside its plausible range is. The relations stand with the files that they are of.

use super::quantity::{short, warn};

/// A relation of several numbers. `F` makes its value of what the files hold.
#[derive(Debug)]
pub struct Relation<F: 'static> {
    /// The key at which a warning stands.
    key: &'static str,
    /// The others that it is made from.
    with: &'static [&'static str],
    /// Least and largest value that is taken without a warning. Zero stands for something that is
    /// not there.
    plausible: [f64; 2],
    /// Its unit; empty of a share.
    unit: &'static str,
    /// What it is.
    meaning: &'static str,
    /// Its value.
    pub of: F,
}

impl<F> Relation<F> {
    /// A relation: the key at which a warning stands, the other keys, the plausible range with its unit,
    /// what the relation is and how its value follows.
    pub const fn new(
        key: &'static str,
        with: &'static [&'static str],
        plausible: [f64; 2],
        unit: &'static str,
        meaning: &'static str,
        of: F,
    ) -> Self {
        Self { key, with, plausible, unit, meaning, of }
    }

    /// Warns of a value outside the plausible range. `place`: where a key stands.
    pub(crate) fn check(&self, value: f64, place: &dyn Fn(&str) -> String) {
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
