//! `joint-friction`: more friction on the motor side than the model has.
//!
//! τ_f gains c tanh(θ̇_E / smoothing) + v θ̇_E, with the robot's own smoothing rate.

use super::{Kind, Parameter, Place};
use crate::robot::{JointPoint, Port, Sloped, Term};

pub(super) static KIND: Kind = Kind {
    id: "joint-friction",
    place: Place::Joint,
    equation: "τ_f gains c tanh(θ̇_E/smoothing) + v θ̇_E",
    shows: "motor torque off by a level that changes sign with the joint's rate, and by a share of the rate; the encoder \
            follows, so the tool stays",
    parameters: &[
        Parameter { name: "coulomb_nm", unit: "N·m", meaning: "Coulomb level c", low: -500.0, high: 2000.0 },
        Parameter {
            name: "viscous_nms_rad",
            unit: "N·m·s/rad",
            meaning: "viscous coefficient v",
            low: -1000.0,
            high: 5000.0,
        },
    ],
    port: Port::MotorFriction,
    build: |values| Box::new(JointFriction { coulomb: values[0], viscous: values[1] }),
};

#[derive(Debug)]
struct JointFriction {
    coulomb: f64,
    viscous: f64,
}

impl Term for JointFriction {
    fn friction(&self, at: &JointPoint) -> Sloped {
        let turn = (at.encoder_rate / at.smoothing).tanh();
        Sloped {
            value: self.coulomb * turn + self.viscous * at.encoder_rate,
            slope: self.coulomb / at.smoothing * (1.0 - turn * turn) + self.viscous,
        }
    }
}
