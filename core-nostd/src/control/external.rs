//! Scheme 3, (2.4)–(2.5): an outer force loop corrects the depth of the set-point of an inner
//! position loop.
//!
//! (2.4) ΔX_f = (I−S)[K_pf Δf + K_if∫Δf − K_df Ẋ], in metres along z; (2.5) Γ = K_p J⁻¹(ΔX +
//! ΔX_f) + K_d d/dt(…) + K_i∫(…). The loop's gain is the force that a depth makes, 1/k_eq =
//! 1/k_material + nᵀ J K⁻¹ Jᵀ n with n along z: the arm in series with the material. The arm is the softer one,
//! and along one weld it changes by a factor of nearly two; K_pf and K_if are therefore scaled by
//! (k_eq where they were tuned)/(k_eq here), within a factor of two either way. K_df is not: what
//! it feeds back is motion.
//!
//! No static force error for any K_if > 0. A sensor that fails moves the tool no further than the
//! correction's limits. This is the structure a pose correction interface allows. Reconstructed
//! (see the [module](super) text).

use super::position_loop::PositionLoop;
use super::{
    DriveCommand, HybridController, JointGains, Limited, SensorReadings, Setpoint, SpindleFilter,
    sensed_push,
};
use crate::error::Fault;
use crate::filter::Filter;
use crate::kinematics::Frames;
use crate::pid::{Pid, PidGains};
use crate::robot::Robot;
use crate::scalar::{JointVector, Real, held, lit};
use crate::state::{StateResult, StateVisitor, Stateful};
use nalgebra::Vector3;

/// How far the gains may be scaled either way: a model that asks for more is not believed.
const WIDEST_SCALE: f64 = 2.0;

/// Gains and limits of the outer force loop (2.4).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExternalGains<T: Real> {
    /// K_pf, m/N.
    pub kp: T,
    /// K_if, m/(N·s).
    pub ki: T,
    /// K_df on the encoder velocity along z, s.
    pub kd: T,
    /// What the material's stiffness against depth is believed to be, N/m.
    pub material_stiffness: T,
    /// Stiffness that the tool met along z where K_pf and K_if were tuned, arm and material in
    /// series, N/m.
    pub tuned_stiffness: T,
    /// Largest depth correction, m.
    pub max_correction: T,
    /// Largest rate of the depth correction, m/s.
    pub max_rate: T,
}

/// External hybrid controller (2.4)–(2.5).
#[derive(Debug, Clone, Copy)]
pub struct External<T: Real> {
    position: PositionLoop<T>,
    gains: ExternalGains<T>,
    force: Pid<T>,
    spindle: SpindleFilter<T>,
    correction: T,
}

impl<T: Real> External<T> {
    /// Controller at rest. `period`: s between calls of [`cycle`](HybridController::cycle).
    pub fn new(joint: JointGains<T>, force: ExternalGains<T>, period: T) -> Self {
        Self {
            position: PositionLoop::new(joint, period),
            gains: force,
            force: Pid::new(PidGains { kp: force.kp, ki: force.ki, kd: T::zero() }),
            spindle: SpindleFilter::new(period),
            correction: T::zero(),
        }
    }

    /// The force error that would have been met where the gains were tuned: Δf · tuned stiffness /
    /// stiffness here.
    fn as_tuned(
        &self,
        robot: &Robot<T>,
        frames: &Frames<T>,
        depth_axis: &Vector3<T>,
        error: T,
    ) -> T {
        let material = self.gains.material_stiffness.recip();
        let scale =
            self.gains.tuned_stiffness * (material + robot.compliance_along(frames, depth_axis));
        let widest = lit::<T>(WIDEST_SCALE);
        // A scale of NaN becomes the smallest as well.
        let scale = if scale > widest.recip() { scale.min(widest) } else { widest.recip() };
        error * scale
    }
}

impl<T: Real> HybridController<T> for External<T> {
    fn start(&mut self, robot: &Robot<T>, encoder: &JointVector<T>, torque: &JointVector<T>) {
        self.position.start(robot, encoder, torque);
        self.force.preload(T::zero());
        self.spindle.reset();
        self.correction = T::zero();
    }

    fn cycle(
        &mut self,
        robot: &Robot<T>,
        setpoint: &Setpoint<T>,
        sensed: &SensorReadings<T>,
    ) -> DriveCommand<T> {
        let view = match self.position.view(robot, setpoint, sensed) {
            Ok(view) => view,
            Err(fault) => return self.position.safe(robot, sensed, fault),
        };
        let z = setpoint.depth_axis();
        let tcp = &view.frames.tcp;
        let (mut force_error, mut fault, mut limited) = (T::zero(), None, false);
        if let Some(desired) = setpoint.force {
            let error = sensed_push(tcp, &z, &sensed.wrench).map(|push| desired - push);
            if let Some(error) = error.filter(|e| e.is_finite()) {
                self.spindle.tune(setpoint.spindle_speed);
                force_error = self.spindle.update(error);
                let velocity = view.frames.twist(&sensed.encoder_rate).linear.dot(&z);
                let (wanted, at_limit) = self.force.update(
                    self.as_tuned(robot, &view.frames, &z, force_error),
                    -self.gains.kd * velocity,
                    self.gains.max_correction,
                    self.position.period,
                );
                let step = self.gains.max_rate * self.position.period;
                let next = held(wanted, self.correction, step);
                limited = at_limit || next != wanted;
                self.correction = next;
            } else {
                // Blind: the correction stays where it is, and depth stays under position control.
                fault = Some(Fault::Force);
            }
        } else {
            self.spindle.reset();
        }
        let mut error = tcp.error_to(&setpoint.pose);
        error.linear += z * self.correction;
        match self.position.torque(robot, &view, &sensed.encoder, &error, &JointVector::zeros()) {
            Err(fault) => self.position.safe(robot, sensed, fault),
            Ok((torque, held)) => DriveCommand {
                torque,
                fault,
                force_error,
                depth_correction: self.correction,
                push: T::zero(),
                limited: Limited { torque: held, force_loop: limited, compensation: false },
            },
        }
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.position.visit_state(visitor)?;
        self.force.visit_state(visitor)?;
        self.spindle.visit_state(visitor)?;
        visitor.scalar(&mut self.correction)
    }
}
