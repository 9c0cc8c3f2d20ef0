//! What gears remember when a log begins.
//!
//! A gear with friction under load carries a state that no instrument reads. It starts at nothing
//! where a log begins at rest and without a load; one that was cut out of a motion, or begins under
//! load, starts anywhere in its loop, and the tool is off by T z/K until the gear has turned round.
//! The state is taken for what fits the log's poses best, beside what is known of it beforehand.

use super::{Experiment, Motion, PredictError};
use nalgebra::{DMatrix, DVector};
use trueweld_plant::robot::{ElasticRobot, GearMemory, INTERNAL_STATES, Memory};

/// What is expected of a state beforehand: a deviation, as a share of half of the loop.
const EXPECTED: f64 = 0.5;

/// Step over which slopes are taken, as a share of half of the loop.
const STEP: f64 = 0.25;

/// Times that the state is fitted anew: the loop is not straight.
const ROUNDS: usize = 3;

/// Deviations, and share of half of the loop, from which on a state is told.
const TOLD: f64 = 4.0;
const TOLD_SHARE: f64 = 0.1;

/// What a gear remembers when a log begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartState {
    /// The gear's joint, from 0.
    pub joint: usize,
    /// From -1 after a long way back to 1 after a long way forth.
    pub state: f64,
}

/// The motion of links whose gears remember what fits best, where `plain` is the one of gears that
/// remember nothing.
pub(super) fn at_the_start(
    experiment: &Experiment,
    robot: &mut ElasticRobot,
    plain: Motion,
) -> Result<Motion, PredictError> {
    let gears = robot.memories();
    if gears.is_empty() || experiment.poses == 0 {
        return Ok(plain);
    }
    let residual = |robot: &ElasticRobot, motion: &Motion| {
        let mut left = Vec::with_capacity(experiment.poses);
        experiment.pose_residual(robot, Some(motion), &mut left);
        DVector::from_vec(left)
    };
    let memory = |states: &DVector<f64>| {
        let mut memory: Memory = [0.0; INTERNAL_STATES];
        for (gear, state) in gears.iter().zip(states.iter()) {
            memory[gear.slot] = within(gear, *state);
        }
        memory
    };
    let follow = |robot: &mut ElasticRobot, states: &DVector<f64>, before: &Motion| {
        let followed = experiment.follow(robot, &memory(states), Some(before))?;
        Ok::<Motion, PredictError>(followed.unwrap_or_else(|| before.clone()))
    };
    let mut motion = plain;
    let mut states = DVector::zeros(gears.len());
    let mut told = states.clone();
    for _ in 0..ROUNDS {
        let left = residual(robot, &motion);
        let mut slopes = DMatrix::zeros(left.len(), gears.len());
        for k in 0..gears.len() {
            // Away from the end of the loop.
            let step = if states[k] > 0.0 { -STEP } else { STEP };
            let mut there = states.clone();
            there[k] += step;
            let moved = follow(robot, &there, &motion)?;
            slopes.set_column(k, &((residual(robot, &moved) - &left) / step));
        }
        let known = EXPECTED.powi(-2);
        let normal = slopes.tr_mul(&slopes) + DMatrix::identity(gears.len(), gears.len()) * known;
        let Some(factor) = normal.cholesky() else { return Ok(motion) };
        let by = factor.solve(&(slopes.tr_mul(&left) + &states * known));
        states = (&states - by).map(|state| state.clamp(-1.0, 1.0));
        told = factor.inverse().diagonal().map(|v| TOLD * v.sqrt());
        motion = follow(robot, &states, &motion)?;
    }
    motion.placed = true;
    let of = |(gear, (state, told)): (&GearMemory, (&f64, &f64))| {
        let stands_out = state.abs() > told.max(TOLD_SHARE);
        stands_out.then_some(StartState { joint: gear.joint, state: *state })
    };
    motion.start = gears.iter().zip(states.iter().zip(told.iter())).filter_map(of).collect();
    Ok(motion)
}

/// A gear's own state, of one from -1 to 1.
fn within(gear: &GearMemory, state: f64) -> f64 {
    state.abs() * gear.ends[usize::from(state > 0.0)]
}
