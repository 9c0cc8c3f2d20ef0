//! The named ports of the plant, where effects enter.
//!
//! An effect is a [`Term`] at one port. The plant asks a port for its terms where its equations
//! need them and knows nothing else of them; an empty port costs a comparison. What leaves the
//! plant at a port is stated at each method.

use nalgebra::Vector3;
use trueweld_core::spatial::rotation_vector;
use trueweld_core::{JOINTS, JointVector, Pose, smooth_sign};

/// Most states that all effects of one cell may keep (a hysteresis keeps one a joint).
pub const INTERNAL_STATES: usize = 6;

/// What joints remember: the states that effects keep, by the order in which they were installed.
pub type Memory = [f64; INTERNAL_STATES];

/// Where a term enters the plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Port {
    /// Torque between motor and link of one joint.
    SpringTorque(usize),
    /// Friction on the motor side of one joint.
    MotorFriction(usize),
    /// Extra torque on the link side of one joint.
    LinkTorque(usize),
    /// Angle between what the encoder of one joint reads and what its gear does.
    JointToLinkAngle(usize),
    /// The frame of one link on its bearing.
    LinkFrame(usize),
    /// The base on its foot.
    BaseFrame,
    /// Force of the process on the tool.
    ProcessForce,
    /// Height of the plate's surface.
    PlateSurface,
    /// What an instrument reads.
    SensorChannel(Channel),
    /// When an instrument reads it.
    TimeBase,
}

/// An instrument whose clock may be late.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// Tracker: TCP pose.
    Tracker,
    /// Force sensor: wrench.
    Wrench,
    /// Motor torque.
    MotorTorque,
    /// Link-side encoders.
    LinkEncoder,
}

/// One joint at one instant.
#[derive(Debug, Clone, Copy)]
pub struct JointState {
    /// Encoder angle θ_E, rad.
    pub encoder: f64,
    /// Encoder rate, rad/s.
    pub encoder_rate: f64,
    /// Link angle θ, rad.
    pub link: f64,
    /// Link rate, rad/s.
    pub link_rate: f64,
    /// Encoder angle of the joint before this one, rad; 0 for A1.
    pub encoder_before: f64,
    /// Rate over which friction turns round, rad/s.
    pub smoothing: f64,
    /// Spring torque τ_s, N·m, which friction may follow; 0 at all ports but motor friction.
    pub spring_torque: f64,
    /// Time from the start, s, with which friction may change; 0 at all ports but motor friction.
    pub time: f64,
    /// The state that the term keeps itself; 0 for one that keeps none.
    pub remembered: f64,
}

impl JointState {
    /// At the zero pose and at rest, with nothing remembered.
    pub(crate) fn at_zero() -> Self {
        Self {
            encoder: 0.0,
            encoder_rate: 0.0,
            link: 0.0,
            link_rate: 0.0,
            encoder_before: 0.0,
            smoothing: 1.0,
            spring_torque: 0.0,
            time: 0.0,
            remembered: 0.0,
        }
    }
}

/// The process at one instant: tool in the weld frame W, origin at the start of the seam on the
/// nominal surface.
#[derive(Debug, Clone, Copy)]
pub struct ProcessPoint {
    /// Time from the start, s.
    pub time: f64,
    /// TCP in W, m.
    pub position: Vector3<f64>,
    /// Velocity of the TCP in W, m/s.
    pub velocity: Vector3<f64>,
    /// Spindle angle, rad, and speed, rad/s.
    pub spindle_angle: f64,
    /// Signed spindle speed, rad/s.
    pub spindle: f64,
    /// Depth force F_d before effects, N, without ripple.
    pub depth_force: f64,
}

/// A value with its slope: what an implicit integrator needs of a stiff term.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ValueDerivative {
    /// The value.
    pub value: f64,
    /// Its derivative by the variable named where it is returned.
    pub slope: f64,
}

impl ValueDerivative {
    /// How far friction has turned round at a rate: tanh(rate/smoothing), between −1 and 1, with
    /// its slope by the rate.
    #[inline]
    pub fn turn(rate: f64, smoothing: f64) -> Self {
        let (value, slope) = smooth_sign(rate, smoothing);
        Self { value, slope }
    }
}

/// What the instruments read in one sample, before noise; a term may change any of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Readings {
    /// Time from the start, s.
    pub time: f64,
    /// Encoder angles, rad.
    pub encoder: [f64; JOINTS],
    /// Link encoder angles, rad.
    pub link_encoder: [f64; JOINTS],
    /// Motor torques as the controller commands them, N·m.
    pub motor_torque: [f64; JOINTS],
    /// Wrench on the tool in T: force, N.
    pub force: Vector3<f64>,
    /// Wrench on the tool in T: moment, N·m.
    pub moment: Vector3<f64>,
    /// Tracker: TCP in B, m, and rotation vector of T in B, rad.
    pub tcp_position: Vector3<f64>,
    /// Rotation vector of T in B, rad.
    pub tcp_rotation: Vector3<f64>,
}

impl Readings {
    /// What ideal instruments would read of the robot, without force and motor torque.
    pub fn of(
        time: f64,
        motor: &JointVector<f64>,
        link: &JointVector<f64>,
        tcp: &Pose<f64>,
    ) -> Self {
        Self {
            time,
            encoder: (*motor).into(),
            link_encoder: (*link).into(),
            motor_torque: [0.0; JOINTS],
            force: Vector3::zeros(),
            moment: Vector3::zeros(),
            tcp_position: tcp.position,
            tcp_rotation: rotation_vector(&tcp.rotation),
        }
    }
}

/// What an effect does at its port. Every method has the neutral answer as its default; a term
/// overrides those of the port it is installed at and no others.
pub trait Term: std::fmt::Debug + Send + Sync {
    /// Spring torque: added to the twist δ = θ_E − θ, rad (gear error, coupling between axes).
    fn torsion(&self, _at: &JointState) -> f64 {
        0.0
    }

    /// Spring torque: the part of the twist that loads the spring, rad (backlash).
    fn engaged(&self, twist: f64) -> f64 {
        twist
    }

    /// Spring torque: half of the range of twists over which nothing loads the spring, rad
    /// (backlash).
    fn play(&self) -> f64 {
        0.0
    }

    /// Spring torque: factor on K at an engaged twist.
    fn stiffness(&self, _engaged: f64) -> f64 {
        1.0
    }

    /// Spring torque: factor on D.
    fn damping(&self) -> f64 {
        1.0
    }

    /// Spring torque: extra torque on the link, N·m, and less on the motor.
    fn spring_torque(&self, _at: &JointState) -> f64 {
        0.0
    }

    /// Spring torque, motor friction, link torque: rate of the term's own state; `None` for a term
    /// that keeps none.
    fn internal_rate(&self, _at: &JointState) -> Option<f64> {
        None
    }

    /// The same ports: the term's own state after the joint has gone an even way to `way`, however
    /// slowly: the rates are the way's lengths, rad, and `remembered` the state at its start.
    fn remembered_after(&self, way: &JointState) -> f64 {
        way.remembered
    }

    /// Motor friction: extra torque against the motor, N·m, with its slope by θ̇_E, N·m·s/rad.
    fn friction(&self, _at: &JointState) -> ValueDerivative {
        ValueDerivative::default()
    }

    /// Link torque: extra torque on the link, N·m; `counterbalance` is τ_cb on this link, zero but
    /// for A2.
    fn link_torque(&self, _at: &JointState, _counterbalance: f64) -> f64 {
        0.0
    }

    /// Joint-to-link angle: real angle of the drive less what the encoder reads, rad.
    fn link_angle(&self) -> f64 {
        0.0
    }

    /// Link or base frame: tilt, rad, for the moment the frame carries, N·m, both in axes of that
    /// frame; `axis` is the joint's (zero for the base).
    fn tilt(&self, _moment: &Vector3<f64>, _axis: &Vector3<f64>) -> Vector3<f64> {
        Vector3::zeros()
    }

    /// Base frame: how far the whole arm has moved, in B, m, at a time from the start, s.
    fn shift(&self, _time: f64) -> Vector3<f64> {
        Vector3::zeros()
    }

    /// Process force: factor on the drag F_f along the seam; the transversal force follows F_f.
    fn drag(&self, _at: &ProcessPoint) -> f64 {
        1.0
    }

    /// Process force: exponent of that factor in the speed along the seam, ∂ ln(factor)/∂ ln|v_x|,
    /// which an implicit integrator needs where the drag is steep.
    fn drag_exponent(&self, _at: &ProcessPoint) -> f64 {
        0.0
    }

    /// Process force: added to F_l, along −y of W, N, before ripple.
    fn lateral_force(&self, _at: &ProcessPoint) -> f64 {
        0.0
    }

    /// Process force: F in axes of W after this term, from the force before it, N.
    fn process_force(&self, _at: &ProcessPoint, force: Vector3<f64>) -> Vector3<f64> {
        force
    }

    /// Plate surface: its height towards the tool (against z of W), m.
    fn surface(&self, _at: &ProcessPoint) -> f64 {
        0.0
    }

    /// Plate surface: how far it gives way for the depth force, m/N.
    fn surface_compliance(&self) -> f64 {
        0.0
    }

    /// Sensor channel: changes what the instruments read.
    fn sense(&self, _readings: &mut Readings) {}

    /// Time base: how late a channel is, s.
    fn delay(&self, _channel: Channel) -> f64 {
        0.0
    }
}

/// True for a term that keeps a state of its own.
pub(crate) fn remembers(term: &dyn Term) -> bool {
    term.internal_rate(&JointState::at_zero()).is_some()
}

/// A term of a joint, with the slot of its own state if it keeps one.
pub(crate) type JointTerm = (Box<dyn Term>, Option<usize>);

/// The terms of one cell, by port.
#[derive(Debug, Default)]
pub struct Ports {
    /// Spring torque of each joint.
    pub spring: [Vec<JointTerm>; JOINTS],
    /// Motor friction of each joint.
    pub friction: [Vec<JointTerm>; JOINTS],
    /// Link torque of each joint.
    pub link_torque: [Vec<JointTerm>; JOINTS],
    /// Joint-to-link angle of each joint: the sum of its terms, rad.
    pub link_angle: JointVector<f64>,
    /// Link frames.
    pub link_frame: [Vec<Box<dyn Term>>; JOINTS],
    /// Base frame.
    pub base_frame: Vec<Box<dyn Term>>,
    /// Process force.
    pub process: Vec<Box<dyn Term>>,
    /// Plate surface.
    pub surface: Vec<Box<dyn Term>>,
    /// Sensor channels, each with the instrument whose readings it changes.
    pub sensor: Vec<(Channel, Box<dyn Term>)>,
    /// Time base.
    pub time: Vec<Box<dyn Term>>,
    internal_states: usize,
}

/// More effects with a state of their own than the plant has room for ([`INTERNAL_STATES`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("more than {INTERNAL_STATES} effects with an internal state in one cell")]
pub struct TooManyStates;

impl Ports {
    /// Puts a term at a port, after those already there.
    ///
    /// # Errors
    /// [`TooManyStates`].
    ///
    /// # Panics
    /// Where a port names a joint above 5.
    pub fn install(&mut self, port: Port, term: Box<dyn Term>) -> Result<(), TooManyStates> {
        match port {
            Port::SpringTorque(i) => {
                let term = self.with_slot(term)?;
                self.spring[i].push(term);
            }
            Port::MotorFriction(i) => {
                let term = self.with_slot(term)?;
                self.friction[i].push(term);
            }
            Port::LinkTorque(i) => {
                let term = self.with_slot(term)?;
                self.link_torque[i].push(term);
            }
            Port::JointToLinkAngle(i) => self.link_angle[i] += term.link_angle(),
            Port::LinkFrame(i) => self.link_frame[i].push(term),
            Port::BaseFrame => self.base_frame.push(term),
            Port::ProcessForce => self.process.push(term),
            Port::PlateSurface => self.surface.push(term),
            Port::SensorChannel(channel) => self.sensor.push((channel, term)),
            Port::TimeBase => self.time.push(term),
        }
        Ok(())
    }

    /// A term with the next slot, if it keeps a state.
    fn with_slot(&mut self, term: Box<dyn Term>) -> Result<JointTerm, TooManyStates> {
        let keeps = remembers(term.as_ref());
        let slot = keeps.then_some(self.internal_states);
        if slot == Some(INTERNAL_STATES) {
            return Err(TooManyStates);
        }
        self.internal_states += usize::from(keeps);
        Ok((term, slot))
    }

    /// All terms of one joint that may keep a state, in the order of their ports.
    pub fn of_joint(&self, i: usize) -> impl Iterator<Item = &JointTerm> {
        self.spring[i].iter().chain(&self.friction[i]).chain(&self.link_torque[i])
    }

    /// Number of effects that keep a state of their own.
    pub fn memories(&self) -> usize {
        self.internal_states
    }

    /// Lateness of a channel, s: the sum over the time base's terms.
    pub fn delay(&self, channel: Channel) -> f64 {
        self.time.iter().map(|t| t.delay(channel)).sum()
    }

    /// True where a term changes what an instrument reads.
    pub fn senses(&self, instrument: Channel) -> bool {
        self.sensor.iter().any(|(channel, _)| *channel == instrument)
    }

    /// What all instruments read of `readings`, the truth.
    pub fn sense(&self, readings: &mut Readings) {
        self.sensor.iter().for_each(|(_, term)| term.sense(readings));
    }

    /// What one instrument reads of it; the others stay.
    pub fn sense_by(&self, instrument: Channel, readings: &mut Readings) {
        let own = self.sensor.iter().filter(|(channel, _)| *channel == instrument);
        own.for_each(|(_, term)| term.sense(readings));
    }

    /// True where the frames of links or base give way to their loads.
    pub fn frames_give(&self) -> bool {
        !self.base_frame.is_empty() || self.link_frame.iter().any(|p| !p.is_empty())
    }
}
