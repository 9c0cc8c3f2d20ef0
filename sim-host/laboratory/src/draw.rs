//! A random place and random values for an effect of the library, of a size that a laboratory would
//! want to know of.

use crate::laboratory::Laboratory;
use crate::protocol::Protocol;
use crate::random::{DRAW, Random};
use std::f64::consts::PI;
use trueweld_plant::effects::{Effect, EffectKind, Location, library};
use trueweld_plant::robot::Channel;

/// An effect of the library at a place.
///
/// # Panics
/// Where the library has no such effect, or it has another number of parameters.
pub fn effect(id: &str, at: Location, values: &[f64]) -> Effect {
    let kind = EffectKind::of(id).expect("an effect of the library");
    assert_eq!(kind.parameters.len(), values.len(), "{id} has other parameters");
    Effect { kind, at, values: values.to_vec() }
}

impl Laboratory {
    /// A random place and random values for the effect `id`. `size` is a factor on what is usual: 1
    /// shows well above the noise in logs of the usual kinds, 0.3 hardly. `protocol` states the
    /// seams' length, on which some effects depend.
    ///
    /// # Panics
    /// Where the library has no such effect, or no size of it is known here.
    pub fn draw(&self, id: &str, size: f64, protocol: &Protocol, seed: u64) -> Effect {
        // Each effect has a stream of its own, so that one seed does not put all of them at the same
        // joint.
        let index = library().position(|k| k.id == id).expect("an effect of the library");
        let mut random = Random::new(seed, DRAW + index as u64);
        let r = &mut random;
        let joint = r.whole(0, 5);
        let proximal = r.whole(0, 2);
        let heavy = joint < 3;
        let parameters = &self.robot.parameters;
        // What a torque of the proximal joints means at this one.
        let scale = parameters.joints[joint].max_torque / parameters.joints[1].max_torque;
        let coulomb = parameters.friction.coulomb[joint];
        let viscous = parameters.friction.viscous[joint];
        let here = Location::Joint(joint);
        let (at, values) = match id {
            "stiffness-error" => (here, vec![size * r.either(0.12, 0.25)]),
            "damping-error" => (here, vec![size * r.either(0.3, 0.6)]),
            "nonlinear-stiffness" => {
                let twist = if heavy { r.between(2e-4, 6e-4) } else { r.between(5e-4, 1.2e-3) };
                (here, vec![size * r.between(0.3, 0.6), twist])
            }
            "backlash" => (here, vec![size * r.between(1e-4, 3e-4)]),
            "hysteresis" => {
                let twist = if heavy { r.between(7e-5, 1.5e-4) } else { r.between(1e-4, 3e-4) };
                (here, vec![size * scale * r.between(1000.0, 2500.0), twist])
            }
            "joint-friction" => (
                here,
                vec![size * coulomb * r.between(0.3, 0.6), size * viscous * r.between(0.3, 0.6)],
            ),
            "stribeck" => {
                (here, vec![size * coulomb * r.between(0.4, 0.8), r.between(0.015, 0.05)])
            }
            "asymmetric-friction" => (here, vec![size * coulomb * r.between(0.25, 0.5)]),
            "transmission-error" => (
                here,
                vec![size * r.between(5e-5, 2e-4), r.whole(10, 80) as f64, r.between(-PI, PI)],
            ),
            "wrist-coupling" => (Location::Joint(r.whole(4, 5)), vec![size * r.either(5e-4, 2e-3)]),
            "bearing-tilt" => (here, vec![size * r.between(5e-9, 2e-8)]),
            "base-compliance" => (Location::Cell, vec![size * r.between(1e-9, 4e-9)]),
            "counterbalance-loss" => (Location::Cell, vec![size * r.between(0.1, 0.3)]),
            "payload-error" => {
                let center = [(); 3].map(|()| r.between(-0.02, 0.02));
                (
                    Location::Cell,
                    vec![
                        size * r.between(5.0, 15.0),
                        size * center[0],
                        size * center[1],
                        size * center[2],
                    ],
                )
            }
            "encoder-offset" => (here, vec![size * r.either(1e-4, 3e-4)]),
            "link-encoder-offset" => (Location::Joint(proximal), vec![size * r.either(5e-5, 2e-4)]),
            "link-encoder-ripple" => (
                Location::Joint(proximal),
                vec![size * r.between(3e-5, 1.5e-4), r.whole(10, 80) as f64, r.between(-PI, PI)],
            ),
            "tracker-registration" => {
                let (shift, turn) =
                    (r.direction() * r.between(2e-4, 6e-4), r.direction() * r.between(1e-4, 2e-4));
                (Location::Cell, shift.iter().chain(turn.iter()).map(|v| size * v).collect())
            }
            "thermal-drift" => {
                let drift = r.direction() * (size * r.between(1.5e-4, 4e-4));
                (Location::Cell, vec![drift.x, drift.y, drift.z, r.between(10.0, 200.0)])
            }
            "force-crosstalk" => {
                (Location::Cell, vec![size * r.either(0.005, 0.015), size * r.either(0.005, 0.015)])
            }
            "force-offset" => {
                (Location::Cell, [(); 3].map(|()| size * r.either(60.0, 200.0)).to_vec())
            }
            "channel-delay" => {
                let channels =
                    [Channel::Tracker, Channel::Wrench, Channel::MotorTorque, Channel::LinkEncoder];
                (Location::Channel(channels[r.whole(0, 3)]), vec![size * r.between(2e-3, 6e-3)])
            }
            "process-stiffness-error" => (Location::Cell, vec![size * r.either(0.15, 0.4)]),
            "drag-error" => (Location::Cell, vec![size * r.either(0.1, 0.25)]),
            "thermal-softening" => {
                (Location::Cell, vec![size * r.between(0.05, 0.15), r.between(10.0, 40.0)])
            }
            "feed-power-law" => (Location::Cell, vec![1.0 - size * r.between(0.2, 0.5)]),
            "advancing-side" => (Location::Cell, vec![size * r.either(0.02, 0.05)]),
            "spindle-harmonic" => {
                let order = r.whole(3, 6) as f64;
                (
                    Location::Cell,
                    vec![
                        order,
                        size * r.between(0.01, 0.03),
                        size * r.between(0.03, 0.08),
                        r.between(-PI, PI),
                    ],
                )
            }
            "plate-waviness" => {
                let length = protocol.seam * r.between(0.2, 0.6);
                (Location::Cell, vec![size * r.between(1e-4, 3e-4), length, r.between(-PI, PI)])
            }
            "fixture-compliance" => (Location::Cell, vec![r.between(3e7, 1e8) / size]),
            "material-step" => (
                Location::Cell,
                vec![size * r.either(0.1, 0.25), protocol.seam * r.between(0.3, 0.7)],
            ),
            _ => panic!("no usual size of the effect `{id}` is known"),
        };
        effect(id, at, &values)
    }
}
