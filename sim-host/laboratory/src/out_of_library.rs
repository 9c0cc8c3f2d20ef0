//! Effects that a real cell may have and the library does not have: a diagnosis must call them
//! unknown.
//!
//! Each is a term at a port of the plant, or acts on a moving arm only. At size 1 each shows well above the noise.

use crate::random::OUT_OF_LIBRARY_STREAM;
use nalgebra::Vector3;
use std::f64::consts::TAU;
use trueweld_core::JOINTS;
use trueweld_plant::cell::Cell;
use trueweld_plant::named;
use trueweld_plant::random::Random;
use trueweld_plant::robot::{
    Channel, JointState, Port, ProcessPoint, Readings, Term, TooManyStates, ValueDerivative,
};

named! {
    /// Kinds of effects outside the library.
    pub enum OutOfLibraryKind {
        /// A bearing that drags on the link's side of the gear.
        LinkFriction = "link-friction",
        /// A heavy thing hung softly on the tool: a second mode.
        Appendage = "appendage",
        /// A gear that rubs more on one side of its turn.
        UnevenFriction = "uneven-friction",
        /// A force sensor whose axial channel reads too much of a large force.
        ForceCurve = "force-curve",
        /// A cable package that draws a joint back to its middle.
        CablePull = "cable-pull",
        /// A gear that damps fast twisting more than slow.
        CubicDamping = "cubic-damping",
        /// A gear softer on one side of its turn.
        UnevenStiffness = "uneven-stiffness",
        /// A gear whose lubricant warms up.
        FadingFriction = "fading-friction",
        /// A machine nearby that shakes the tool.
        Shaker = "shaker",
    }
}

impl OutOfLibraryKind {
    /// Its equation.
    pub fn equation(self) -> &'static str {
        match self {
            Self::LinkFriction => "link side gains −v θ̇",
            Self::Appendage => {
                "m ü = −k (u − p) − c (u̇ − ṗ) and its reaction on the TCP p, in motion; its weight is balanced"
            }
            Self::UnevenFriction => "τ_f gains a sin(7 θ_E) tanh(θ̇_E/smoothing)",
            Self::ForceCurve => "measured F_z gains g F_z |F_z|",
            Self::CablePull => "link side gains −k θ",
            Self::CubicDamping => "τ_s gains c δ̇³",
            Self::UnevenStiffness => "τ_s gains a K sin(3 θ_E) δ",
            Self::FadingFriction => "τ_f gains f exp(−t/T) tanh(θ̇_E/smoothing)",
            Self::Shaker => "force F sin(2π f t) along y of B on the tool, while the machine runs",
        }
    }
}

/// An effect outside the library.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutOfLibrary {
    /// What it is.
    pub kind: OutOfLibraryKind,
    /// The joint it is at, 0 = A1; effects of the cell or the tool ignore it.
    pub joint: usize,
    /// Factor on its usual size.
    pub size: f64,
}

/// A mass hung on the tool by spring and damper.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Appendage {
    /// Mass, kg.
    pub mass: f64,
    /// Stiffness, N/m.
    pub stiffness: f64,
    /// Damping, N·s/m.
    pub damping: f64,
}

impl OutOfLibrary {
    /// The effect at a random joint that can have it. `size` is a factor on the usual size.
    pub fn draw(kind: OutOfLibraryKind, size: f64, seed: u64) -> Self {
        let mut random = Random::new(seed, OUT_OF_LIBRARY_STREAM);
        let joint = match kind {
            // Only motor torque shows them, and its noise is the same at the weak joints.
            OutOfLibraryKind::UnevenFriction | OutOfLibraryKind::FadingFriction => {
                random.whole(0, 2)
            }
            // Where it is not like gravity.
            OutOfLibraryKind::CablePull => [0, 3][random.whole(0, 1)],
            // The tool centre lies on A6.
            OutOfLibraryKind::UnevenStiffness | OutOfLibraryKind::CubicDamping => {
                random.whole(0, 4)
            }
            _ => random.whole(0, JOINTS - 1),
        };
        Self { kind, joint, size }
    }

    /// Puts its term, if it is one, at its port.
    pub(crate) fn install(&self, cell: &mut Cell) -> Result<(), TooManyStates> {
        let joint = self.joint;
        let model = &cell.robot.model;
        let friction = &model.parameters().friction;
        let (stiffness, damping) = (model.stiffness()[joint], model.damping()[joint]);
        let (port, term): (Port, Box<dyn Term>) = match self.kind {
            OutOfLibraryKind::LinkFriction => {
                let viscous = self.size * friction.viscous[joint];
                (Port::LinkTorque(joint), Box::new(LinkFriction { viscous }))
            }
            OutOfLibraryKind::UnevenFriction => (
                Port::MotorFriction(joint),
                Box::new(UnevenFriction { amplitude: self.size * 0.8 * friction.coulomb[joint] }),
            ),
            OutOfLibraryKind::FadingFriction => (
                Port::MotorFriction(joint),
                Box::new(FadingFriction { amplitude: self.size * 0.8 * friction.coulomb[joint] }),
            ),
            OutOfLibraryKind::ForceCurve => (
                Port::SensorChannel(Channel::Wrench),
                Box::new(ForceCurve { gain: 5e-6 * self.size }),
            ),
            OutOfLibraryKind::CablePull => (
                Port::LinkTorque(joint),
                Box::new(CablePull {
                    stiffness: self.size * 0.1 * model.parameters().joints[joint].max_torque,
                }),
            ),
            OutOfLibraryKind::CubicDamping => {
                // Twice as much again as D, at the rate at which a ring-down begins.
                let rate: f64 = if joint < 3 { 0.05 } else { 0.15 };
                let coefficient = 2.0 * self.size * damping / (rate * rate);
                (Port::SpringTorque(joint), Box::new(CubicDamping { coefficient }))
            }
            OutOfLibraryKind::UnevenStiffness => (
                Port::SpringTorque(joint),
                Box::new(UnevenStiffness { stiffness: 0.25 * self.size * stiffness }),
            ),
            OutOfLibraryKind::Shaker => {
                let amplitude = cell.seam.b_from_w.rotation.transpose() * self.shaking();
                (Port::ProcessForce, Box::new(Shaker { amplitude }))
            }
            OutOfLibraryKind::Appendage => return Ok(()),
        };
        cell.robot.ports.install(port, term)
    }

    /// Amplitude of the shaker, in B, N.
    fn shaking(&self) -> Vector3<f64> {
        Vector3::y() * (250.0 * self.size)
    }

    /// Force on the tool of an arm that moves freely, in B, N.
    pub(crate) fn force(&self, time: f64) -> Vector3<f64> {
        if self.kind == OutOfLibraryKind::Shaker {
            self.shaking() * shake(time)
        } else {
            Vector3::zeros()
        }
    }

    /// The mass hung on the tool, where it is one. A weld's feed does not stir it.
    pub(crate) fn appendage(&self) -> Option<Appendage> {
        const APPENDAGE_RATE: f64 = 9.0 * TAU;
        let mass = 12.0 * self.size;
        let hung = Appendage {
            mass,
            stiffness: mass * APPENDAGE_RATE * APPENDAGE_RATE,
            damping: 2.0 * 0.02 * mass * APPENDAGE_RATE,
        };
        (self.kind == OutOfLibraryKind::Appendage).then_some(hung)
    }
}

/// The shaker's wave, 6.3 Hz.
fn shake(time: f64) -> f64 {
    (6.3 * TAU * time).sin()
}

#[derive(Debug)]
struct LinkFriction {
    viscous: f64,
}

impl Term for LinkFriction {
    fn link_torque(&self, at: &JointState, _: f64) -> f64 {
        -self.viscous * at.link_rate
    }
}

#[derive(Debug)]
struct UnevenFriction {
    amplitude: f64,
}

impl Term for UnevenFriction {
    fn friction(&self, at: &JointState) -> ValueDerivative {
        let turn = ValueDerivative::turn(at.encoder_rate, at.smoothing);
        let level = self.amplitude * (7.0 * at.encoder).sin();
        ValueDerivative { value: level * turn.value, slope: level * turn.slope }
    }
}

#[derive(Debug)]
struct FadingFriction {
    amplitude: f64,
}

impl Term for FadingFriction {
    fn friction(&self, at: &JointState) -> ValueDerivative {
        const DECAY_TIME: f64 = 4.0;
        let turn = ValueDerivative::turn(at.encoder_rate, at.smoothing);
        let level = self.amplitude * (-at.time / DECAY_TIME).exp();
        ValueDerivative { value: level * turn.value, slope: level * turn.slope }
    }
}

#[derive(Debug)]
struct ForceCurve {
    gain: f64,
}

impl Term for ForceCurve {
    fn sense(&self, readings: &mut Readings) {
        readings.force.z *= 1.0 + self.gain * readings.force.z.abs();
    }
}

#[derive(Debug)]
struct CablePull {
    stiffness: f64,
}

impl Term for CablePull {
    fn link_torque(&self, at: &JointState, _: f64) -> f64 {
        -self.stiffness * at.link
    }
}

#[derive(Debug)]
struct CubicDamping {
    coefficient: f64,
}

impl Term for CubicDamping {
    fn spring_torque(&self, at: &JointState) -> f64 {
        self.coefficient * (at.encoder_rate - at.link_rate).powi(3)
    }
}

#[derive(Debug)]
struct UnevenStiffness {
    stiffness: f64,
}

impl Term for UnevenStiffness {
    fn spring_torque(&self, at: &JointState) -> f64 {
        self.stiffness * (3.0 * at.encoder).sin() * (at.encoder - at.link)
    }
}

#[derive(Debug)]
struct Shaker {
    amplitude: Vector3<f64>,
}

impl Term for Shaker {
    fn process_force(&self, at: &ProcessPoint, force: Vector3<f64>) -> Vector3<f64> {
        force + self.amplitude * shake(at.time)
    }
}
