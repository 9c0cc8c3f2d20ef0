//! How fast links move on their springs, and the steps that an explicit integration of them needs.
//!
//! With the motors held, links swing and creep by M θ̈ + D θ̇ + K θ = 0. Let ω² be the largest
//! eigenvalue of M⁻¹K and δ that of M⁻¹D. No mode grows, however it is damped, where √(ω² + δ²) h is
//! below the limit of Runge–Kutta's fourth order on the negative real axis. A mode that is faster
//! than what drives it is hardly excited: the step only has to keep it from growing. Left out:
//! springs that effects make stiffer over a few microradians, such as a gear's hysteresis; their
//! torque has a bound, and so has what they do.

use crate::robot::{Drives, ElasticRobot, INTERNAL_STATES};
use nalgebra::Matrix6;
use std::f64::consts::TAU;
use trueweld_core::{JOINTS, JointVector};

/// Limit of |λ| h, Runge–Kutta of fourth order.
const STABLE: f64 = 2.785;

/// |λ| h where the step is made smaller for a mode's sake.
const MODE_STEP_MAX: f64 = 1.5;

/// Fastest mode that is followed, rad/s: beyond it, a second of motion takes some hundred thousand
/// steps, and no drive train swings there.
const FOLLOWED_RATE_MAX: f64 = TAU * 10e3;

/// The fastest motion of links on their springs and dampers, motors held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FastestMode {
    /// The joint that moves most in it, from 0.
    pub joint: usize,
    /// Size that its eigenvalue has at most, rad/s.
    pub rate: f64,
    /// True where the damper makes it as fast, not the spring.
    pub damped: bool,
}

/// A mode that is too fast to be followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TooFast(pub FastestMode);

impl std::error::Error for TooFast {}

impl std::fmt::Display for TooFast {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.told(&format!("joint {}", self.0.joint + 1)))
    }
}

impl TooFast {
    /// What is too fast, and what to do; `joint`: what its joint is called.
    pub fn told(&self, joint: &str) -> String {
        let FastestMode { rate, damped, .. } = self.0;
        let (is, key) = if damped {
            let settles = format!(
                "settles within {:.2} µs by its damper; {:.0} µs is the least",
                1e6 / rate,
                1e6 / FOLLOWED_RATE_MAX
            );
            (settles, "damping_nms_rad")
        } else {
            let (own, most) = (1e-3 * rate / TAU, 1e-3 * FOLLOWED_RATE_MAX / TAU);
            (
                format!("swings at {own:.1} kHz on its spring; {most:.0} kHz is the most"),
                "stiffness_nm_rad",
            )
        };
        format!(
            "{joint} {is} that a motion can be computed for: state the inertia of the tool and of the links behind \
             that joint, or check its {key}, or state `stiffness_nm_rad = \"rigid\"`"
        )
    }
}

impl FastestMode {
    /// Of a robot with its effects, links at `link`, rad; `None` where M is not positive definite.
    pub fn of(robot: &ElasticRobot, link: &JointVector<f64>) -> Option<Self> {
        let scaled = Scaled::new(robot, link)?;
        let [spring, damper] = [scaled.springs, scaled.dampers].map(Matrix6::symmetric_eigen);
        let [omega, delta] = [spring.eigenvalues.max().max(0.0).sqrt(), damper.eigenvalues.max()];
        let damped = delta > omega;
        let (modes, held) =
            if damped { (damper, scaled.held[1]) } else { (spring, scaled.held[0]) };
        let mode = modes.eigenvectors.column(modes.eigenvalues.imax());
        let moves = scaled.half.tr_mul(&mode);
        let energy = held.component_mul(&moves.component_mul(&moves));
        Some(Self { joint: energy.imax(), rate: omega.hypot(delta), damped })
    }

    /// The mode, where it can be followed.
    ///
    /// # Errors
    /// A mode that is too fast.
    pub fn followed(self) -> Result<Self, TooFast> {
        if self.rate > FOLLOWED_RATE_MAX { Err(TooFast(self)) } else { Ok(self) }
    }
}

/// Springs and dampers by the links' inertia: L⁻¹ K L⁻ᵀ and L⁻¹ D L⁻ᵀ with M = L Lᵀ.
struct Scaled {
    /// L⁻¹.
    half: Matrix6<f64>,
    /// Stiffness, N·m/rad, and damping, N·m·s/rad, of each joint.
    held: [JointVector<f64>; 2],
    springs: Matrix6<f64>,
    dampers: Matrix6<f64>,
}

impl Scaled {
    fn new(robot: &ElasticRobot, link: &JointVector<f64>) -> Option<Self> {
        let inertia = robot.model.crba(&robot.model.frames(link));
        let half = inertia.cholesky()?.l().try_inverse()?;
        let held = stiffest(robot);
        let [springs, dampers] =
            held.map(|held| half * Matrix6::from_diagonal(&held) * half.transpose());
        springs.sum().is_finite().then_some(Self { half, held, springs, dampers })
    }

    /// Size that no eigenvalue exceeds, rad/s: of all modes together.
    fn bound(&self) -> f64 {
        self.springs.trace().sqrt().hypot(self.dampers.trace())
    }
}

/// Largest slope of each joint's spring torque by its twist, N·m/rad, over the twists that its motor
/// can bring about, and that by the twist's rate, N·m·s/rad.
fn stiffest(robot: &ElasticRobot) -> [JointVector<f64>; 2] {
    /// Shares of the largest torque.
    const LOADS: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];
    /// Differences for the slopes, rad and rad/s.
    const MODE_SLOPE_DIFFERENCE: f64 = 1e-7;
    let mut held = [*robot.model.stiffness(), *robot.model.damping()];
    for i in (0..JOINTS).filter(|i| !robot.spring_is_plain(*i)) {
        let torque = |twist: f64, rate: f64| {
            let (mut link, mut link_rate) = (JointVector::zeros(), JointVector::zeros());
            (link[i], link_rate[i]) = (-twist, -rate);
            let (motor, motor_rate) = (JointVector::zeros(), JointVector::zeros());
            let drives = Drives { link, link_rate, motor, motor_rate };
            robot.joint_spring_torque(&drives, i, &[0.0; INTERNAL_STATES])
        };
        let most = robot.model.parameters().joints[i].max_torque / robot.model.stiffness()[i];
        let slopes = LOADS.map(|load| {
            let (twist, by) = (load * most, MODE_SLOPE_DIFFERENCE);
            let rise = torque(twist + by, 0.0) - torque(twist - by, 0.0);
            [rise, torque(twist, by) - torque(twist, -by)].map(|rise| 0.5 * rise / by)
        });
        for (k, held) in held.iter_mut().enumerate() {
            held[i] = slopes.iter().map(|slope| slope[k]).fold(0.0, f64::max);
        }
    }
    held
}

/// Steps of Runge–Kutta's fourth order in which `whole`, s, is to be taken, each no longer than
/// `longest`, s: so many more as the fastest mode needs that links have at `postures`, rad.
///
/// # Errors
/// A mode that is too fast to be followed.
pub fn substeps(
    robot: &ElasticRobot,
    postures: impl IntoIterator<Item = JointVector<f64>>,
    whole: f64,
    longest: f64,
) -> Result<usize, TooFast> {
    let fewest = (whole / longest - 1e-9).ceil().max(1.0) as usize;
    let mut needed = fewest;
    for link in postures {
        let is_stable = |rate: f64| rate * whole <= STABLE * fewest as f64;
        // The bound is had without a mode's shape.
        if Scaled::new(robot, &link).is_none_or(|scaled| is_stable(scaled.bound())) {
            continue;
        }
        let Some(mode) = FastestMode::of(robot, &link) else { continue };
        let rate = mode.followed()?.rate;
        if !is_stable(rate) {
            needed = needed.max((whole * rate / MODE_STEP_MAX).ceil() as usize);
        }
    }
    Ok(needed)
}
