//! What gears remember when a log begins.
//!
//! A gear with friction under load carries a state that no instrument reads. It starts at nothing
//! where a log begins at rest and without a load; one that was cut out of a motion, or begins under
//! load, starts anywhere in its loop, and the tool is off by T z/K until the gear has turned round.
//! The state is taken for what fits the log's poses best, beside what is known of it beforehand. A
//! prediction beside another one keeps the motion with the states found there: how far the best
//! ones move is taken from their slopes. What was taken from the poses is no evidence for the model:
//! it is judged over all states that are expected (Laplace's approximation; Kass and Raftery 1995).

use super::{LinkMotion, PredictError, PreparedLog};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;
use trueweld_plant::robot::{ElasticRobot, INTERNAL_STATES, JointMemory, Memory};

/// What is expected of a state beforehand: a deviation, as a share of half of the loop.
const EXPECTED: f64 = 0.5;

/// Step over which slopes are taken, as a share of half of the loop.
const STATE_STEP: f64 = 0.25;

/// Times that the state is fitted anew at most, for the loop is not straight, and the change that
/// needs no further round, as a share of half of the loop.
const STATE_FIT_ROUNDS: usize = 3;
const STATE_SETTLED_SHARE: f64 = 0.01;

/// Deviations, and share of half of the loop, from which on a state is told.
const STATE_TOLD_DEVIATIONS: f64 = 4.0;
const STATE_TOLD_SHARE: f64 = 0.1;

/// What a gear remembers when a log begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartState {
    /// The gear's joint, from 0.
    pub joint: usize,
    /// From -1 after a long way back to 1 after a long way forth.
    pub state: f64,
}

/// The states of gears that fit a log's poses best.
#[derive(Debug)]
pub struct StartFit {
    gears: Vec<JointMemory>,
    /// From -1 to 1.
    states: DVector<f64>,
    /// Deviations of the states.
    deviations: DVector<f64>,
    /// Residuals of the poses with these states.
    poses: DVector<f64>,
    /// Slopes of the residuals of poses, and of what motors read, by the states.
    slopes: DMatrix<f64>,
    /// By how much the best states fall with each residual of a pose.
    gain: DMatrix<f64>,
    /// Twice the logarithm of how many times narrower the states are known than they were expected.
    learnt: f64,
}

impl StartFit {
    /// The memory with states for these gears.
    fn memory(gears: &[JointMemory], states: &DVector<f64>) -> Memory {
        let mut memory: Memory = [0.0; INTERNAL_STATES];
        for (gear, state) in gears.iter().zip(states.iter()) {
            memory[gear.slot] = state.abs() * gear.ends[usize::from(*state > 0.0)];
        }
        memory
    }

    /// Residuals with these states, of a model not far from the one that they were found under, as
    /// they are with the best states there, beyond the loop as well: of two changes that undo each
    /// other the slopes must do so too.
    pub(super) fn settle(&self, residual: &mut [f64]) {
        let off = DVector::from_column_slice(&residual[..self.poses.len()]) - &self.poses;
        let by = &self.slopes * (&self.gain * -off);
        residual.iter_mut().zip(by.iter()).for_each(|(r, by)| *r += by);
    }

    /// What it takes from the evidence for a model that its gears begin where the poses have them, as a
    /// sum of squares.
    pub(super) fn not_evidence(&self) -> f64 {
        self.states.norm_squared() * EXPECTED.powi(-2) + self.learnt
    }

    /// The states that stand out: what is not nothing.
    pub fn significant_states(&self) -> Vec<StartState> {
        let of = |(gear, (state, deviation)): (&JointMemory, (&f64, &f64))| {
            let is_significant =
                state.abs() > (STATE_TOLD_DEVIATIONS * deviation).max(STATE_TOLD_SHARE);
            is_significant.then_some(StartState { joint: gear.joint, state: *state })
        };
        let states = self.states.iter().zip(self.deviations.iter());
        self.gears.iter().zip(states).filter_map(of).collect()
    }
}

/// The motion of links whose gears remember what fits best; `None` where none remembers. `near`: the
/// motion under a model not far from this one. Its states are kept where `held`, else they are where
/// the search begins.
pub(super) fn at_the_start(
    experiment: &PreparedLog,
    robot: &mut ElasticRobot,
    near: Option<&LinkMotion>,
    held: bool,
) -> Result<Option<LinkMotion>, PredictError> {
    let gears = robot.memories();
    if gears.is_empty() || experiment.poses == 0 || !experiment.starts_anywhere {
        return Ok(None);
    }
    let slots = |gears: &[JointMemory]| gears.iter().map(|g| g.slot).collect::<Vec<_>>();
    let known =
        near.and_then(|n| n.start.as_ref()).filter(|fit| slots(&fit.gears) == slots(&gears));
    let mut states = known.map_or_else(|| DVector::zeros(gears.len()), |fit| fit.states.clone());
    let swing = near.and_then(|near| near.swing.as_ref());
    let memory = |states: &DVector<f64>| StartFit::memory(&gears, states);
    let Some(mut motion) = experiment.follow(robot, &memory(&states), swing, None)? else {
        return Ok(None);
    };
    if let Some(fit) = known.filter(|_| held) {
        motion.start = Some(fit.clone());
        return Ok(Some(motion));
    }
    let residual = |robot: &ElasticRobot, motion: &LinkMotion| {
        DVector::from_vec(experiment.residual(robot, Some(motion), None, [None; 2]))
    };
    let follow = |robot: &mut ElasticRobot, states: &DVector<f64>, before: &LinkMotion| {
        let followed =
            experiment.follow(robot, &memory(states), before.swing.as_ref(), Some(before))?;
        Ok::<LinkMotion, PredictError>(followed.unwrap_or_else(|| before.clone()))
    };
    let mut left = residual(robot, &motion);
    let mut slopes = DMatrix::zeros(left.len(), gears.len());
    let mut solved = None;
    for _ in 0..STATE_FIT_ROUNDS {
        for k in 0..gears.len() {
            // Away from the end of the loop.
            let step = if states[k] > 0.0 { -STATE_STEP } else { STATE_STEP };
            let mut there = states.clone();
            there[k] += step;
            let moved = follow(robot, &there, &motion)?;
            slopes.set_column(k, &((residual(robot, &moved) - &left) / step));
        }
        let of_poses = slopes.rows(0, experiment.poses);
        let known = EXPECTED.powi(-2);
        let normal =
            of_poses.tr_mul(&of_poses) + DMatrix::<f64>::identity(gears.len(), gears.len()) * known;
        let Some(factor) = normal.cholesky() else { break };
        let poses = left.rows(0, experiment.poses);
        let by = factor.solve(&(of_poses.tr_mul(&poses) + &states * known));
        let next = (&states - by).map(|state| state.clamp(-1.0, 1.0));
        let deviations = factor.inverse().diagonal().map(f64::sqrt);
        let learnt = (factor.determinant() / known.powi(gears.len() as i32)).ln();
        solved = Some((factor.solve(&of_poses.transpose()), deviations, learnt));
        if (&next - &states).amax() < STATE_SETTLED_SHARE {
            break;
        }
        states = next;
        motion = follow(robot, &states, &motion)?;
        left = residual(robot, &motion);
    }
    if let Some((mut gain, deviations, learnt)) = solved {
        // A state at an end of its loop stays there.
        for k in (0..gears.len()).filter(|k| states[*k].abs() == 1.0) {
            gain.row_mut(k).fill(0.0);
        }
        let poses = left.rows(0, experiment.poses).into_owned();
        let fit = StartFit { gears, states, deviations, poses, slopes, gain, learnt };
        motion.start = Some(Arc::new(fit));
    }
    Ok(Some(motion))
}
