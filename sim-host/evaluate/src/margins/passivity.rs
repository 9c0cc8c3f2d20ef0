//! Whether the position-controlled robot is passive at its tool, whatever it touches: the sampled
//! wall.
//!
//! A stiffness K and a damping B given by a controller of period T are passive only on a mechanism
//! whose own damping b is b > K T/2 + B (Colgate and Schenkel 1997). Along the tool axis n, with
//! the joint gains in series through the arm: 1/K = Σ (Jᵀn)ᵢ²/K_p,ᵢ, and likewise B from K_d and b
//! from the viscous friction of the drives. A robot that is not passive is stable only with what it
//! was made stable with: that is what the margins are for.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Serialize;
use trueweld_core::control::JointGains;
use trueweld_core::{Frames, JointVector, Wrench};

/// Damping that the position loop needs at the tool and that is there, N·s/m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "LoopPassivity", deny_unknown_fields)]
pub struct Passivity {
    /// That the mechanism must have to be passive with this controller, K T/2 + B.
    #[schemars(with = "Option<f64>")]
    pub needed_ns_m: f64,
    /// That the friction of the drives gives.
    #[schemars(with = "Option<f64>")]
    pub there_ns_m: f64,
}

impl Passivity {
    /// Of a joint position loop. `axis`: unit vector in B; `viscous`: friction of the drives,
    /// N·m·s/rad; `period`: s.
    pub fn of(
        frames: &Frames<f64>,
        axis: &Vector3<f64>,
        gains: &JointGains<f64>,
        viscous: &JointVector<f64>,
        period: f64,
    ) -> Self {
        let lever = frames.joint_torque(&Wrench { moment: Vector3::zeros(), force: *axis });
        let along =
            |each: &JointVector<f64>| lever.component_mul(&lever).component_div(each).sum().recip();
        Self {
            needed_ns_m: 0.5 * along(&gains.kp) * period + along(&gains.kd),
            there_ns_m: along(viscous),
        }
    }
}
