//! Poses and loads that tell the stiffness best: D-optimal among those that the arm may stand in.
//!
//! A load moves the tool by Σ J_j τ_j/K_j, so that the logarithm of a stiffness shows as its own part
//! of that. The pose without load is measured too and takes out where links are mounted and the
//! tracker stands: what counts is by how much the loads at one posture differ. Of the candidates those
//! are chosen that make the determinant of the information largest, one after the other, and then
//! exchanged as long as that gains (Fedorov). Left out: what stands in the cell, noise of the wrench.

use crate::safe_space::SafeSpace;
use nalgebra::{Matrix6, Vector3};
use std::f64::consts::PI;
use trueweld_core::{JOINTS, JointVector, Pose, Robot, Wrench};
use trueweld_plant::simulate::postures_at;

/// What the laboratory has.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanOptions {
    /// Loads to choose.
    pub loads: usize,
    /// Heaviest payload, kg.
    pub payload: f64,
    /// Its centre from the flange, in the frame of the last link, m.
    pub centre: Vector3<f64>,
    /// Largest force against a fixture, N.
    pub push: f64,
    /// Where the reflectors sit in T, m.
    pub reflectors: [Vector3<f64>; 3],
    /// Standard deviation of a reflector's coordinate, m.
    pub noise: f64,
}

/// A load at a posture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedLoad {
    /// Encoders, rad.
    pub posture: JointVector<f64>,
    /// How it acts.
    pub load: LoadKind,
}

/// How a load acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LoadKind {
    /// The payload on the flange, in steps up and down.
    Payload,
    /// A force against a fixture, axes of B, N, in steps to and fro.
    Push(Vector3<f64>),
}

/// A plan.
#[derive(Debug, Clone, PartialEq)]
pub struct StiffnessPlan {
    /// The loads, in order.
    pub loads: Vec<PlannedLoad>,
    /// Expected standard deviation of the logarithm of each stiffness.
    pub deviations: [f64; JOINTS],
    /// As many loads in postures picked by hand: the arm before the robot, the tool down.
    pub by_hand: Vec<PlannedLoad>,
    /// What those would leave; infinite where they tell nothing.
    pub by_hand_deviations: [f64; JOINTS],
    /// Candidates looked at.
    pub candidates: usize,
}

/// Shares of a payload and of a push.
pub(crate) const PAYLOAD_SHARES: [f64; 7] = [0.0, 0.25, 0.5, 0.75, 1.0, 0.5, 0.0];
/// See [`PAYLOAD_SHARES`].
pub(crate) const PUSH_SHARES: [f64; 9] = [0.0, 0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0];

/// Postures looked at.
const POSTURES_TRIED: usize = 600;

/// Rounds of exchange at most.
const EXCHANGE_ROUNDS_MAX: usize = 20;

/// Information that stands for none, so that a determinant exists before all six are told: a standard
/// deviation of e².
const PRIOR_INFORMATION: f64 = 0.02;

/// A standard deviation that says nothing.
const UNINFORMED_DEVIATION: f64 = 3.0;

/// Chooses the loads; `None` where the arm may stand nowhere under them.
pub fn plan(robot: &Robot<f64>, options: &PlanOptions) -> Option<StiffnessPlan> {
    let mut space = SafeSpace::new(robot);
    // A wrist that turns on and on need not.
    for range in &mut space.range {
        *range = [range[0].max(-PI), range[1].min(PI)];
    }
    let mut candidates: Vec<(PlannedLoad, Matrix6<f64>)> = Vec::new();
    for posture in space.postures(POSTURES_TRIED) {
        let tcp = robot.forward_kinematics(&posture).position;
        let sideways = Vector3::new(-tcp.y, tcp.x, 0.0).normalize();
        for load in [LoadKind::Payload, LoadKind::Push(sideways * options.push)] {
            let planned = PlannedLoad { posture, load };
            candidates.extend(information(&space, options, &planned).map(|i| (planned, i)));
        }
    }
    if candidates.is_empty() {
        return None;
    }
    let none = Matrix6::<f64>::identity() * PRIOR_INFORMATION;
    let worth =
        |of: &Matrix6<f64>| of.cholesky().map_or(f64::NEG_INFINITY, |c| c.determinant().ln());
    let best = |without: &Matrix6<f64>| {
        (0..candidates.len()).max_by(|a, b| {
            let of = |k: &usize| worth(&(without + candidates[*k].1));
            of(a).total_cmp(&of(b))
        })
    };
    let mut chosen: Vec<usize> = Vec::new();
    let mut sum = none;
    while chosen.len() < options.loads {
        let next = best(&sum)?;
        sum += candidates[next].1;
        chosen.push(next);
    }
    for _ in 0..EXCHANGE_ROUNDS_MAX {
        let mut gained = false;
        for place in 0..chosen.len() {
            let without = sum - candidates[chosen[place]].1;
            let next = best(&without)?;
            let there = without + candidates[next].1;
            if worth(&there) > worth(&sum) + 1e-9 {
                (sum, chosen[place], gained) = (there, next, true);
            }
        }
        if !gained {
            break;
        }
    }
    let mut loads: Vec<PlannedLoad> = chosen.iter().map(|k| candidates[*k].0).collect();
    // The weight is hung once: payloads first.
    loads.sort_by_key(|load| load.load != LoadKind::Payload);
    let by_hand = by_hand(&space, options);
    let told: Matrix6<f64> =
        by_hand.iter().filter_map(|load| information(&space, options, load)).sum();
    Some(StiffnessPlan {
        deviations: deviations(&(sum - none)),
        by_hand_deviations: deviations(&told),
        loads,
        by_hand,
        candidates: candidates.len(),
    })
}

/// Standard deviations of the logarithms; infinite where nothing is told.
fn deviations(information: &Matrix6<f64>) -> [f64; JOINTS] {
    let weak = information + Matrix6::<f64>::identity() * 1e-6;
    let covariance = weak.try_inverse().unwrap_or_else(Matrix6::zeros);
    std::array::from_fn(|j| {
        let deviation = covariance[(j, j)].abs().sqrt();
        if deviation < UNINFORMED_DEVIATION { deviation } else { f64::INFINITY }
    })
}

/// The wrench of the whole load at the TCP, axes of B.
fn wrench(robot: &Robot<f64>, options: &PlanOptions, load: &PlannedLoad) -> Wrench<f64> {
    match load.load {
        LoadKind::Push(force) => Wrench { moment: Vector3::zeros(), force },
        LoadKind::Payload => {
            let frames = robot.frames(&load.posture);
            let parameters = robot.parameters();
            let lever = options.centre - parameters.tool.tcp_from_flange;
            let force = parameters.gravity * options.payload;
            Wrench { moment: (frames.rotation[JOINTS - 1] * lever).cross(&force), force }
        }
    }
}

/// What a load tells of the logarithms; `None` where the arm may not bear it.
fn information(
    space: &SafeSpace<'_>,
    options: &PlanOptions,
    load: &PlannedLoad,
) -> Option<Matrix6<f64>> {
    let robot = space.robot;
    let frames = robot.frames(&load.posture);
    let whole = wrench(robot, options, load);
    let shares: &[f64] =
        if load.load == LoadKind::Payload { &PAYLOAD_SHARES } else { &PUSH_SHARES };
    let to_tool = frames.tcp.rotation.transpose();
    let bears = |share: f64| {
        let part = Wrench { moment: whole.moment * share, force: whole.force * share };
        space.bears(&load.posture, &part.rotated(&to_tool))
    };
    if !shares.iter().all(|share| bears(*share)) {
        return None;
    }
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    let swing: f64 = shares.iter().map(|share| (share - mean).powi(2)).sum();
    let twist = frames.joint_torque(&whole).component_div(robot.stiffness());
    let jacobian = frames.jacobian().0;
    let mut information = Matrix6::zeros();
    for reflector in &options.reflectors {
        let at = frames.tcp.rotation * reflector;
        for axis in 0..3 {
            let moves = JointVector::from_fn(|j, _| {
                let angular = jacobian.fixed_view::<3, 1>(0, j).into_owned();
                (jacobian[(3 + axis, j)] + angular.cross(&at)[axis]) * twist[j]
            });
            information += moves * moves.transpose();
        }
    }
    Some(information * swing / options.noise.powi(2))
}

/// As many loads in postures picked by hand: the arm before the robot at several distances, the tool
/// down; the last one pushed sideways.
fn by_hand(space: &SafeSpace<'_>, options: &PlanOptions) -> Vec<PlannedLoad> {
    let robot = space.robot;
    let down = nalgebra::Matrix3::new(1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0);
    let reach = SafeSpace::reach(robot);
    let posture = |share: f64| {
        let pose = Pose { position: Vector3::new(share * reach, 0.0, 0.2 * reach), rotation: down };
        let all = postures_at(robot, &pose).ok()?;
        all.into_iter().find(|q| space.bears(q, &Wrench::zero()))
    };
    let found: Vec<JointVector<f64>> =
        [0.45, 0.5, 0.55, 0.6, 0.65].into_iter().filter_map(posture).collect();
    if found.is_empty() {
        return Vec::new();
    }
    (0..options.loads)
        .map(|k| PlannedLoad {
            posture: found[k % found.len()],
            load: if k + 1 == options.loads {
                LoadKind::Push(Vector3::y() * options.push)
            } else {
                LoadKind::Payload
            },
        })
        .collect()
}

/// The protocol that records a plan. `robot`: path of the robot file, as the protocol is to name it.
pub fn protocol_text(plan: &StiffnessPlan, options: &PlanOptions, robot: &str) -> String {
    let list = |values: &mut dyn Iterator<Item = f64>| {
        let all: Vec<String> = values.map(|v| format!("{:?}", (v * 1e6).round() / 1e6)).collect();
        format!("[{}]", all.join(", "))
    };
    let mut text = format!(
        "# Loads that tell the stiffness best, by `trueweld identify stiffness --plan`. Check the way from posture to\n\
         # posture before you drive it: what stands in the cell is not known here.\n\
         schema = \"protocol/1\"\nrobot = {robot:?}\n\n[reflectors]\n"
    );
    for (k, at) in options.reflectors.iter().enumerate() {
        text += &format!("reflector{}_m = {}\n", k + 1, list(&mut at.iter().copied()));
    }
    text += &format!("\n[noise]\ntcp_position_m = {:?}\n", options.noise);
    text += "\n[[log]]\nname = \"loads\"\nkind = \"static-load\"\n";
    for planned in &plan.loads {
        let degrees = list(&mut planned.posture.iter().map(|q| q.to_degrees()));
        text += &format!("\n[[log.load]]\nposture_deg = {degrees}\n");
        text += &match planned.load {
            LoadKind::Payload => format!(
                "payload_kg = {:?}\ncentre_m = {}\nshares = {:?}\n",
                options.payload,
                list(&mut options.centre.iter().copied()),
                PAYLOAD_SHARES
            ),
            LoadKind::Push(force) => format!(
                "force_base_n = {}\nshares = {:?}\n",
                list(&mut force.iter().copied()),
                PUSH_SHARES
            ),
        };
    }
    text
}
