//! The weld to make: `weld/1`.

use super::{FileKind, InputError, InputFile, Table};
use nalgebra::Vector3;

/// How far a stated unit vector's length may be from 1.
const UNIT: f64 = 1e-6;

/// Below this sine between tool axis and path there is no direction across the weld to speak of.
const LEAST_SINE: f64 = 1e-3;

/// A straight weld.
#[derive(Debug, Clone, PartialEq)]
pub struct Weld {
    /// Start on the plate's surface, in B, m.
    pub start: Vector3<f64>,
    /// End on the plate's surface, in B, m.
    pub end: Vector3<f64>,
    /// Tool axis in B, of length 1, into the material: z of the weld frame W.
    pub tool_axis: Vector3<f64>,
    /// Speed along the weld, m/s.
    pub feed: f64,
    /// Time in which the feed rises from 0, s.
    pub feed_ramp: f64,
    /// Depth force to hold, N.
    pub force: f64,
    /// Time in which the force rises to it, s.
    pub force_ramp: f64,
    /// Depth of the tool in the material at the start, m.
    pub initial_depth: f64,
    /// Time of pure position control before the force loop closes, s.
    pub settle: f64,
}

impl InputFile for Weld {
    const KIND: FileKind = FileKind::Weld;

    fn from_root(root: &Table<'_>) -> Result<Self, InputError> {
        root.only(&[
            "schema",
            "start_m",
            "end_m",
            "tool_axis",
            "feed_m_s",
            "feed_ramp_s",
            "force_n",
            "force_ramp_s",
            "initial_depth_m",
            "settle_s",
        ])?;
        let start = root.vector("start_m")?;
        let end = root.vector("end_m")?;
        let axis = root.vector("tool_axis")?;
        let path = end - start;
        if path.norm() < 1e-6 {
            let help = "A weld needs a length: move `end_m` away from `start_m`.";
            return Err(root.wrong("end_m", "a point other than `start_m`", help));
        }
        if (axis.norm() - 1.0).abs() > UNIT {
            let expected = format!("a vector of length 1, not {}", axis.norm());
            let help = match axis.try_normalize(1e-12) {
                Some(unit) => {
                    format!("In the same direction: [{}, {}, {}].", unit.x, unit.y, unit.z)
                }
                None => "It points along the tool, into the material.".to_owned(),
            };
            return Err(root.wrong("tool_axis", &expected, help));
        }
        let tool_axis = axis.normalize();
        if tool_axis.cross(&path.normalize()).norm() < LEAST_SINE {
            let expected = "a direction that is not parallel to the path from `start_m` to `end_m`";
            return Err(root.wrong(
                "tool_axis",
                expected,
                "It points along the tool, into the material.",
            ));
        }
        Ok(Self {
            start,
            end,
            tool_axis,
            feed: root.quantity("feed_m_s")?,
            feed_ramp: root.quantity("feed_ramp_s")?,
            force: root.quantity("force_n")?,
            force_ramp: root.quantity("force_ramp_s")?,
            initial_depth: root.quantity("initial_depth_m")?,
            settle: root.quantity("settle_s")?,
        })
    }
}
