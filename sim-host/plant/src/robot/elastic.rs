//! The elastic robot (2.1): two inertias a joint, spring and damper between them.
//!
//! ```text
//! M(θ) θ̈ + h(θ, θ̇) + g(θ) = τ_s + τ_cb(θ₂) + J(θ)ᵀ w   (links)
//! I_m θ̈_E = Γ − τ_s − τ_f(θ̇_E)                          (motors, seen from the joint)
//! τ_s = K (θ_E − θ) + D (θ̇_E − θ̇)
//! ```
//!
//! The one description of its physics: whoever drives it (a controller, a recorded log), it is
//! asked here. Rotor gyroscopic effects are left out.

use super::ports::{JointState, JointTerm, Memory, Ports, Term, ValueDerivative};
use crate::effects::{Effect, EffectError};
use crate::input::Process;
use nalgebra::{Matrix6, Vector3};
use trueweld_core::ldlt::Ldlt;
use trueweld_core::{Displacement, Frames, JOINTS, JointVector, Robot, Wrench};

/// What bearings and base give to, beside loads at rest.
#[derive(Debug, Clone, Copy, Default)]
pub struct TiltMotion {
    /// β̇, rad/s.
    pub rate: JointVector<f64>,
    /// β̈, rad/s².
    pub acceleration: JointVector<f64>,
    /// −C R φ̈ of each link's frame and of the foot, rad, in axes of B.
    pub swing: [Vector3<f64>; JOINTS + 1],
}

/// The robot with the terms that effects put at its ports.
#[derive(Debug)]
pub struct ElasticRobot {
    /// Geometry, inertia, elasticity and tool.
    pub model: Robot<f64>,
    /// Terms of effects.
    pub ports: Ports,
}

/// Positions and rates on both sides of the gears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drives {
    /// Link angles θ, rad.
    pub link: JointVector<f64>,
    /// Link rates, rad/s.
    pub link_rate: JointVector<f64>,
    /// Encoder angles θ_E, rad.
    pub motor: JointVector<f64>,
    /// Encoder rates, rad/s.
    pub motor_rate: JointVector<f64>,
}

/// A joint with memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointMemory {
    /// Its joint, from 0.
    pub joint: usize,
    /// Place of its state in a [`Memory`](super::Memory).
    pub slot: usize,
    /// The state after a long way back, and after a long way forth, −1 to 1.
    pub ends: [f64; 2],
}

/// A way after which nothing is remembered of where it began, rad.
const MEMORY_WAY_MAX: f64 = 1e3;

/// Difference of what is remembered that is none.
const MEMORY_DIFFERENCE_MIN: f64 = 1e-9;

/// A joint with what a term there remembers.
#[inline]
fn recalling(at: &JointState, term: &JointTerm, internal: &[f64]) -> JointState {
    JointState { remembered: term.1.map_or(0.0, |slot| internal[slot]), ..*at }
}

impl ElasticRobot {
    /// The robot with its effects. What effects do to the process goes to `process`, where there is
    /// one.
    ///
    /// # Errors
    /// [`EffectError`] where an effect cannot be installed.
    pub fn with_effects(
        model: &Robot<f64>,
        effects: &[Effect],
        mut process: Option<&mut Process>,
    ) -> Result<Self, EffectError> {
        let mut ports = Ports::default();
        let mut parameters = None;
        for effect in effects {
            effect.apply(model, &mut parameters, process.as_deref_mut(), &mut ports)?;
        }
        let Some(parameters) = parameters else {
            return Ok(Self { model: model.clone(), ports });
        };
        // Only effects that change the robot's numbers can make it impossible.
        let changes = effects.iter().rfind(|e| e.is_of_robot_model());
        let blame = changes.map_or("the robot", |e| e.kind.id);
        let model =
            Robot::new(parameters).map_err(|reason| EffectError::Model { id: blame, reason })?;
        Ok(Self { model, ports })
    }

    fn joint_point(&self, drives: &Drives, i: usize) -> JointState {
        JointState {
            encoder: drives.motor[i],
            encoder_rate: drives.motor_rate[i],
            link: drives.link[i],
            link_rate: drives.link_rate[i],
            encoder_before: if i > 0 { drives.motor[i - 1] } else { 0.0 },
            smoothing: self.model.parameters().friction.smoothing,
            spring_torque: 0.0,
            time: 0.0,
            remembered: 0.0,
        }
    }

    /// Spring torque τ_s of every joint, N·m: on the link, and its reaction on the motor.
    #[inline]
    pub fn spring_torque(&self, drives: &Drives, internal: &[f64]) -> JointVector<f64> {
        let torsion = drives.motor - drives.link + self.ports.link_angle;
        let rate = drives.motor_rate - drives.link_rate;
        let mut torque = self.model.stiffness().component_mul(&torsion)
            + self.model.damping().component_mul(&rate);
        for i in 0..JOINTS {
            if !self.spring_is_plain(i) {
                torque[i] = self.joint_spring_torque(drives, i, internal);
            }
        }
        torque
    }

    /// Half of the play in a joint's gear, rad: within it the spring carries nothing.
    pub fn play(&self, i: usize) -> f64 {
        self.ports.spring[i].iter().map(|(t, _)| t.play()).sum()
    }

    /// True where no effect changes the spring of a joint.
    #[inline]
    pub(crate) fn spring_is_plain(&self, i: usize) -> bool {
        self.ports.spring[i].is_empty()
    }

    /// Spring torque of one joint, N·m, with its effects.
    pub(crate) fn joint_spring_torque(&self, drives: &Drives, i: usize, internal: &[f64]) -> f64 {
        let spring = &self.ports.spring[i];
        let at = self.joint_point(drives, i);
        let mut torsion = drives.motor[i] - drives.link[i] + self.ports.link_angle[i];
        torsion += spring.iter().map(|(t, _)| t.torsion(&at)).sum::<f64>();
        let engaged = spring.iter().fold(torsion, |torsion, (t, _)| t.engaged(torsion));
        let stiffness =
            spring.iter().fold(self.model.stiffness()[i], |k, (t, _)| k * t.stiffness(engaged));
        let damping = spring.iter().fold(self.model.damping()[i], |d, (t, _)| d * t.damping());
        let extra: f64 =
            spring.iter().map(|term| term.0.spring_torque(&recalling(&at, term, internal))).sum();
        stiffness * engaged + damping * (drives.motor_rate[i] - drives.link_rate[i]) + extra
    }

    /// What one joint remembers after an even way to `to`, whose rates are the way's lengths, rad,
    /// however slowly: from `before` into `after`.
    pub(crate) fn remembered(&self, to: &Drives, i: usize, before: &Memory, after: &mut Memory) {
        for term in self.ports.of_joint(i) {
            if let (term, Some(slot)) = (&term.0, term.1) {
                let way = JointState { remembered: before[slot], ..self.joint_point(to, i) };
                after[slot] = term.remembered_after(&way);
            }
        }
    }

    /// The joints that remember, each with what it remembers after a long way back and a long way
    /// forth; those left out that no way makes forget.
    pub fn memories(&self) -> Vec<JointMemory> {
        let still = JointVector::zeros();
        let drives = Drives { link: still, link_rate: still, motor: still, motor_rate: still };
        let joints = 0..JOINTS;
        joints.flat_map(|i| self.joint_memories(i, &self.joint_point(&drives, i))).collect()
    }

    fn joint_memories(&self, joint: usize, at: &JointState) -> Vec<JointMemory> {
        let ports = &self.ports;
        let held = ports.spring[joint].iter().map(|term| (term, false));
        let moved = ports.friction[joint].iter().chain(&ports.link_torque[joint]);
        let all = held.chain(moved.map(|term| (term, true)));
        let memory = |(term, of_link): (&JointTerm, bool)| {
            let (slot, ends) = (term.1?, memory_ends(term.0.as_ref(), at, of_link)?);
            Some(JointMemory { joint, slot, ends })
        };
        all.filter_map(memory).collect()
    }

    /// What terms at the springs that remember add to the stiffness of each joint for motions far
    /// smaller than their loops, N·m/rad: in the middle of its loop, on the way forth.
    pub fn remembered_stiffness(&self) -> JointVector<f64> {
        /// A rate that takes every loop round slowly enough for its memory to follow, rad/s.
        const LOOP_SLOPE_RATE: f64 = 1e-6;
        let still = JointVector::zeros();
        let drives = Drives { link: still, link_rate: still, motor: still, motor_rate: still };
        JointVector::from_fn(|i, _| {
            let forth =
                JointState { encoder_rate: LOOP_SLOPE_RATE, ..self.joint_point(&drives, i) };
            let of = |term: &dyn Term| {
                let torque = |remembered| term.spring_torque(&JointState { remembered, ..forth });
                (torque(1.0) - torque(0.0)) * term.internal_rate(&forth).unwrap_or(0.0)
                    / LOOP_SLOPE_RATE
            };
            let remembering = self.ports.spring[i].iter().filter(|(_, slot)| slot.is_some());
            remembering.map(|(term, _)| of(term.as_ref())).sum()
        })
    }

    /// Rates of the states that terms keep.
    pub fn internal_rates(&self, drives: &Drives, internal: &[f64], rates: &mut [f64]) {
        if self.ports.memories() == 0 {
            return;
        }
        for i in 0..JOINTS {
            for term in self.ports.of_joint(i) {
                if let Some(slot) = term.1 {
                    let at = recalling(&self.joint_point(drives, i), term, internal);
                    rates[slot] = term.0.internal_rate(&at).unwrap_or(0.0);
                }
            }
        }
    }

    /// Motor friction τ_f of one joint whose spring carries τ_s = `spring`, N·m, at `time` from the
    /// start, s, with its slope by θ̇_E.
    #[inline]
    pub fn friction(
        &self,
        drives: &Drives,
        i: usize,
        spring: f64,
        internal: &[f64],
        time: f64,
    ) -> ValueDerivative {
        let (value, slope) = self.model.parameters().friction.torque(i, drives.motor_rate[i]);
        let mut torque = ValueDerivative { value, slope };
        if !self.ports.friction[i].is_empty() {
            let at = JointState { spring_torque: spring, time, ..self.joint_point(drives, i) };
            for term in &self.ports.friction[i] {
                let more = term.0.friction(&recalling(&at, term, internal));
                torque.value += more.value;
                torque.slope += more.slope;
            }
        }
        torque
    }

    /// Torque on the links that is neither spring nor load: the counterbalance and the link ports,
    /// N·m.
    #[inline]
    pub fn link_torque(&self, drives: &Drives, internal: &[f64]) -> JointVector<f64> {
        let mut torque = JointVector::zeros();
        let counterbalance = self.model.counterbalance_torque(drives.link[1]);
        torque[1] = counterbalance;
        for i in 0..JOINTS {
            if !self.ports.link_torque[i].is_empty() {
                let at = self.joint_point(drives, i);
                let balance = if i == 1 { counterbalance } else { 0.0 };
                torque[i] += self.ports.link_torque[i]
                    .iter()
                    .map(|term| term.0.link_torque(&recalling(&at, term, internal), balance))
                    .sum::<f64>();
            }
        }
        torque
    }

    /// Frames of the real arm at `time`, s. `wrench` on the tool at the TCP in axes of B loads
    /// bearings and base, where these give.
    #[inline]
    pub fn frames(&self, link: &JointVector<f64>, wrench: &Wrench<f64>, time: f64) -> Frames<f64> {
        self.frames_in_motion(link, &TiltMotion::default(), wrench, time)
    }

    /// The same of an arm in motion.
    #[inline]
    pub fn frames_in_motion(
        &self,
        link: &JointVector<f64>,
        motion: &TiltMotion,
        wrench: &Wrench<f64>,
        time: f64,
    ) -> Frames<f64> {
        let rigid = self.model.frames(link);
        if !self.ports.frames_give() {
            return rigid;
        }
        self.displaced_frames(link, motion, &rigid, wrench, time)
    }

    /// Bearings and base tilt under the moments that the rigid arm passes them, gravity
    /// included. The tilts are of the order of 0.1 mrad, so that their own effect on the moments is
    /// left out.
    fn displaced_frames(
        &self,
        link: &JointVector<f64>,
        motion: &TiltMotion,
        rigid: &Frames<f64>,
        wrench: &Wrench<f64>,
        time: f64,
    ) -> Frames<f64> {
        let loads = self.model.joint_loads(rigid, &motion.rate, &motion.acceleration, wrench);
        let mut by = Displacement::none();
        // What a frame carries is the reaction to what it passes on: the loads act outward, the
        // tilt follows them inward.
        for (i, load) in loads.iter().enumerate() {
            let moment = -rigid.rotation[i].tr_mul(&load.moment);
            let axis = self.model.parameters().joints[i].axis;
            by.tilt[i] = self.ports.link_frame[i].iter().map(|t| t.tilt(&moment, &axis)).sum();
            by.tilt[i] += rigid.rotation[i].tr_mul(&motion.swing[i]);
        }
        let foot = -(loads[0].moment + rigid.origin[0].cross(&loads[0].force));
        let tilt: Vector3<f64> =
            self.ports.base_frame.iter().map(|t| t.tilt(&foot, &Vector3::zeros())).sum();
        let tilt = tilt + motion.swing[JOINTS];
        by.base.rotation = trueweld_core::spatial::rotation_from_vector(&tilt);
        by.base.position = self.ports.base_frame.iter().map(|t| t.shift(time)).sum();
        self.model.frames_displaced(link, &by)
    }

    /// Link accelerations θ̈, rad/s², with the inertia matrix and its factors. `None` where the state
    /// is not finite.
    #[inline]
    pub fn link_acceleration(
        &self,
        frames: &Frames<f64>,
        (drives, internal): (&Drives, &[f64]),
        spring: &JointVector<f64>,
        wrench: &Wrench<f64>,
    ) -> Option<(JointVector<f64>, Matrix6<f64>, Ldlt<f64>)> {
        let (inertia, bias) = self.model.equation_of_motion(frames, &drives.link_rate, wrench);
        let torque = spring + self.link_torque(drives, internal) - bias;
        let factor = Ldlt::new(inertia)?;
        Some((factor.solve(&torque), inertia, factor))
    }

    /// Link accelerations within a step from a state where they were θ̈₀ and M had these factors:
    ///
    /// θ̈ = θ̈₀ + M₀⁻¹ (τ − M θ̈₀ − h − g + Jᵀ w).
    ///
    /// Inverse dynamics costs less than M and its factors. Left out is the change of M times that of
    /// θ̈, both over the step.
    #[inline]
    pub fn link_acceleration_near(
        &self,
        frames: &Frames<f64>,
        (drives, internal): (&Drives, &[f64]),
        spring: &JointVector<f64>,
        wrench: &Wrench<f64>,
        (acceleration, factor): (&JointVector<f64>, &Ldlt<f64>),
    ) -> JointVector<f64> {
        let asked = self.model.rnea(frames, &drives.link_rate, acceleration, wrench);
        acceleration + factor.solve(&(spring + self.link_torque(drives, internal) - asked))
    }

    /// Energy of links, rotors, gravity, counterbalance and springs of the baseline, J. Without
    /// process and effects it changes only by what the motors give and what dampers and friction
    /// take.
    pub fn energy(&self, drives: &Drives) -> f64 {
        let frames = self.model.frames(&drives.link);
        let torsion = drives.motor - drives.link;
        let rotors =
            self.model.rotor_inertia().dot(&drives.motor_rate.component_mul(&drives.motor_rate));
        let springs = self.model.stiffness().dot(&torsion.component_mul(&torsion));
        let counterbalance = self.model.parameters().counterbalance.work(drives.link[1]);
        self.model.kinetic_energy(&frames, &drives.link_rate) + self.model.potential_energy(&frames)
            - counterbalance
            + 0.5 * (rotors + springs)
    }
}

/// What a term remembers after a long way back and forth; `None` where it does not come to the same
/// from every start. A spring's twist goes the way of the encoder with the link held, a link's that of
/// itself.
fn memory_ends(term: &dyn Term, at: &JointState, of_link: bool) -> Option<[f64; 2]> {
    let end = |way: f64| {
        let link_rate = if of_link { way } else { 0.0 };
        let [low, high] = [-1.0, 1.0].map(|remembered| {
            term.remembered_after(&JointState { encoder_rate: way, link_rate, remembered, ..*at })
        });
        (high - low < MEMORY_DIFFERENCE_MIN).then_some(high)
    };
    let (back, forth) = (end(-MEMORY_WAY_MAX)?, end(MEMORY_WAY_MAX)?);
    (back < forth).then_some([back, forth])
}
