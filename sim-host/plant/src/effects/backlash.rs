//! `backlash`: play in a gear.
//!
//! The elastic part of τ_s acts on dz(δ): δ − b above b, δ + b below −b, 0 between. The damper keeps acting inside the gap.

use super::{Kind, Parameter, Place};
use crate::robot::{Port, Term};

pub(super) static KIND: Kind = Kind {
    id: "backlash",
    place: Place::Joint,
    equation: "elastic part of τ_s = K dz(δ), dz(δ) = δ − b above b, δ + b below −b, 0 between; δ = θ_E − θ",
    shows: "the tool jumps where the joint's torque changes sign; no offset elsewhere but ± b",
    parameters: &[Parameter {
        name: "half_gap_rad",
        unit: "rad",
        meaning: "half of the play, b",
        low: 0.0,
        high: 1e-3,
    }],
    port: Port::SpringTorque,
    build: |values| Box::new(Backlash { half_gap: values[0] }),
};

#[derive(Debug)]
struct Backlash {
    half_gap: f64,
}

impl Term for Backlash {
    fn engaged(&self, twist: f64) -> f64 {
        // Soft threshold: zero within the gap, and continuous at its ends.
        twist.signum() * (twist.abs() - self.half_gap).max(0.0)
    }
}
