//! What the arm is along a weld, as far as gains follow from it, and the gains that do: closed
//! forms, before anything is searched.
//!
//! With I the inertia that a drive moves (rotor and links), ω₁ the lowest natural frequency with the
//! motors locked, T the control period, k the stiffness that the tool meets along z (arm and material
//! in series) and m the inertia of the drives along z, m = 1/(nᵀ J I⁻¹ Jᵀ n):
//!
//! ```text
//! position loop    K_p = I w²,  K_d = 2 ζ I w ≤ 0.8 I_m/T,  K_i = K_p w/4
//!                  w = 0.4 ω₁, at most 0.36/T: below the arm's first mode, and slow for the period
//! external         K_if = 3/(t k),  K_if k T ≤ ½ · 2 sin(π/(2(2N+1))),  K_pf = K_if T
//! parallel         K_if = 3/t,  K_df = 0.8 √(k m)
//! superposed       K_if = 3/t,  its position loop at 0.6 w with K_i = K_p w/30
//! ```
//!
//! t: the settling time asked for; a first-order loop is within 5 % after three time constants. N:
//! periods of delay of force sensor, spindle filter and position loop; half of the bound of a
//! delayed integral force loop is kept free.

use super::{AskedResponse, TuneError};
use crate::arm::{ArmAt, PlacedSeam};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use trueweld_compensators::FollowingGains;
use trueweld_core::JointVector;
use trueweld_core::compensation::LoopLimits;
use trueweld_core::control::{ExternalGains, ForceGains, JointGains, SpindleFilter};
use trueweld_core::filter::Filter;
use trueweld_plant::input::{CascadeGains, CompensationLimits, Control, ParallelGains};
use trueweld_plant::simulate::{RunError, Scenario, Seam, Taught, TaughtOffset, start_angles};

/// The arm at so many places from the start of the weld to its end, as the controller believes in
/// it.
///
/// # Errors
/// [`RunError::Reach`].
pub(super) fn arm_along(scenario: &Scenario<'_>, places: usize) -> Result<Vec<ArmAt>, TuneError> {
    let robot = scenario.controller_model;
    let seam = Seam::of(scenario.weld);
    let mut near = start_angles(robot, &seam)?;
    let taught = Taught::at(scenario.cell, robot, &seam, 0.0, &near).offset;
    let taught = TaughtOffset::new(&taught, &seam.axes(0.0), 0.0);
    let last = places.saturating_sub(1).max(1);
    let mut arm = Vec::with_capacity(places);
    for k in 0..places {
        let path = seam.length * k as f64 / last as f64;
        near = robot
            .inverse_near(&seam.nominal(path), &near)
            .map_err(|_| RunError::Reach { path, reason: "no posture welds there" })?;
        let of = PlacedSeam { robot, planned: scenario.planned, weld: scenario.weld, seam: &seam };
        let at = ArmAt::of(&of, path, &near, &taught);
        arm.push(at.ok_or(RunError::Reach { path, reason: "singular posture" })?);
    }
    Ok(arm)
}

/// Damping ratio of the position loops.
const POSITION_LOOP_DAMPING_RATIO: f64 = 0.4;

/// Share of the arm's first natural frequency that a position loop is as fast as.
const OF_MODE: f64 = 0.4;

/// Most that a position loop may turn in a period, rad.
const IN_A_PERIOD: f64 = 0.36;

/// Share of the authority that the weld does not ask for.
const RESERVE: f64 = 0.15;

/// How long slow signals of the force loop are late, s: force sensor with its filter, spindle filter,
/// half a period of hold, and the position loop's 2ζ/w.
pub(super) fn force_delay(scenario: &Scenario<'_>, w: f64) -> f64 {
    let (period, sensor) = (scenario.control.period, &scenario.sensors.force);
    let mut spindle = SpindleFilter::new(period);
    spindle.tune(scenario.planned.spindle);
    let filter = if sensor.filter > 0.0 { (TAU * sensor.filter).recip() } else { 0.0 };
    sensor.delay + filter + spindle.delay() + 0.5 * period + 2.0 * POSITION_LOOP_DAMPING_RATIO / w
}

/// Gains from the arm at the start of the weld, where the step of force is made.
pub(super) fn closed_form(
    scenario: &Scenario<'_>,
    asked: &AskedResponse,
    arm: &[ArmAt],
) -> Control {
    let (period, weld) = (scenario.control.period, scenario.weld);
    let start = &arm[0];
    let slowest = arm.iter().map(|at| at.mode_rad_s).fold(f64::INFINITY, f64::min);
    let w = (OF_MODE * slowest).min(IN_A_PERIOD / period);
    let most_damping = scenario.controller_model.rotor_inertia() * (0.8 / period);
    let position =
        |w: f64, integral: f64| position_gains(&start.inertia, w, integral, &most_damping);
    let rise = 3.0 / asked.settle;
    let delay = (force_delay(scenario, w) / period).ceil();
    let bound = 2.0 * (PI / (2.0 * (2.0 * delay + 1.0))).sin();
    let ki = rise.min(0.5 * bound / period) / start.stiffness_n_m;
    let most = weld.force.max(asked.height);
    let depth = 4.0 * most / start.stiffness_n_m;
    // The height of the step in half a turn of the arm's first mode.
    let rate = asked.height * slowest / PI;
    let force = |kd: f64, max_rate: f64| ForceGains {
        kp: 0.0,
        ki: rise,
        kd,
        max_correction: 1.1 * most,
        max_rate,
    };
    let needed = |of: fn(&ArmAt) -> f64| (1.0 + RESERVE) * arm.iter().map(of).fold(0.0, f64::max);
    let [translation, rotation] = [needed(|at| at.correction_m), needed(|at| at.correction_rad)];
    let bandwidth = 0.83 * w;
    Control {
        period,
        parallel: ParallelGains {
            joint: position(w, w / 4.0),
            force: force(
                2.0 * POSITION_LOOP_DAMPING_RATIO * (start.stiffness_n_m * start.mass).sqrt(),
                rate,
            ),
        },
        superposed: ParallelGains {
            joint: position(0.6 * w, 0.6 * w / 30.0),
            force: force(0.0, 0.3 * rate),
        },
        external: CascadeGains {
            joint: position(w, w / 4.0),
            force: ExternalGains {
                kp: ki * period,
                ki,
                kd: 0.0,
                material_stiffness: scenario.planned.model.depth_stiffness(),
                tuned_stiffness: start.stiffness_n_m,
                max_correction: depth,
                max_rate: depth,
            },
        },
        compensation: CompensationLimits {
            lateral: LoopLimits { bandwidth, size: translation, rate: translation },
            orientation: LoopLimits { bandwidth, size: rotation, rate: rotation },
            following: FollowingGains {
                rate: 0.24 * bandwidth,
                along: 0.07 * bandwidth,
                size: 0.2 * translation,
            },
        },
        others: scenario.control.others.clone(),
        laws: BTreeMap::new(),
    }
}

/// Gains of a position loop of joints with these inertias, kg·m², at `w`, rad/s. `integral`: of kp,
/// 1/s; `most_damping`: that the sampled loop bears, N·m·s/rad.
fn position_gains(
    inertia: &JointVector<f64>,
    w: f64,
    integral: f64,
    most_damping: &JointVector<f64>,
) -> JointGains<f64> {
    let kp = inertia * (w * w);
    let kd = inertia * (2.0 * POSITION_LOOP_DAMPING_RATIO * w);
    JointGains { kp, ki: kp * integral, kd: kd.zip_map(most_damping, f64::min) }
}

/// The pace w of a position loop, rad/s: the least of its joints.
pub(super) fn pace(joint: &JointGains<f64>, at: &ArmAt) -> f64 {
    joint.kp.component_div(&at.inertia).min().sqrt()
}
