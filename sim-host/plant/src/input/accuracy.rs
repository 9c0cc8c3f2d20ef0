//! `[accuracy]` of a campaign or a model: how exact predictions need be.
//!
//! ```toml
//! [accuracy]
//! tcp_position_m = 1e-4        # a tenth of a millimetre
//! tcp_rotation_rad = 5e-4
//! link_encoder_rad = 5e-5
//! motor_torque_nm = 20.0
//! force_n = 50.0
//! moment_nm = 5.0
//! ```
//!
//! What is off by less is no error that anybody asks about. A key that is left out asks for all that
//! the noise of the instruments lets be seen.

use super::table::TomlTable;
use super::{Bounds, InputError};

/// How exact predictions need be: one standard deviation of each channel, in its SI unit.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Accuracy {
    /// Tool centre point, a coordinate, m.
    pub tcp_position: Option<f64>,
    /// Rotation of the tool about an axis, rad.
    pub tcp_rotation: Option<f64>,
    /// Link angle of a joint, rad.
    pub link_encoder: Option<f64>,
    /// Motor torque of a joint, seen from the joint, N·m.
    pub motor_torque: Option<f64>,
    /// Force on the tool along an axis, N.
    pub force: Option<f64>,
    /// Moment on the tool about an axis, N·m.
    pub moment: Option<f64>,
}

/// A key, the largest value that is no slip of the unit, and the field.
type Row = (&'static str, f64, fn(&mut Accuracy) -> &mut Option<f64>);

const ROWS: [Row; 6] = [
    ("tcp_position_m", 0.1, |of| &mut of.tcp_position),
    ("tcp_rotation_rad", 0.1, |of| &mut of.tcp_rotation),
    ("link_encoder_rad", 0.1, |of| &mut of.link_encoder),
    ("motor_torque_nm", 1e5, |of| &mut of.motor_torque),
    ("force_n", 1e5, |of| &mut of.force),
    ("moment_nm", 1e4, |of| &mut of.moment),
];

impl Accuracy {
    /// Reads `[accuracy]` of a file's root; nothing where the file has none.
    ///
    /// # Errors
    /// The first thing that does not fit, with its place.
    pub fn read(root: &TomlTable<'_>) -> Result<Self, InputError> {
        let mut all = Self::default();
        if !root.has("accuracy") {
            return Ok(all);
        }
        let table = root.table("accuracy")?;
        table.only(&ROWS.map(|(key, ..)| key))?;
        for (key, most, field) in ROWS.into_iter().filter(|(key, ..)| table.has(key)) {
            *field(&mut all) = Some(table.number(key, Bounds::Between(most / 1e9, most))?);
        }
        Ok(all)
    }

    /// This, and where it says nothing the other.
    #[must_use]
    pub fn or(mut self, mut other: Self) -> Self {
        for (.., field) in ROWS {
            let of = field(&mut self);
            *of = of.or(*field(&mut other));
        }
        self
    }

    /// What it says, by the keys of a file.
    pub fn entries(mut self) -> impl Iterator<Item = (&'static str, f64)> {
        ROWS.into_iter().filter_map(move |(key, _, field)| Some((key, (*field(&mut self))?)))
    }
}
