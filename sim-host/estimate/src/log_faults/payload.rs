//! A payload that nobody wrote down.

use super::relation::RELATION_ROWS_MIN;
use super::rows::LogRow;
use super::{MisfitEvidence, Mistake, MistakeKind, Remedy};
use crate::predict::with_payload;
use nalgebra::{SMatrix, SVector, Vector3};
use trueweld_core::{JOINTS, JointVector, Robot};
use trueweld_logs::channel::LogChannel;
use trueweld_logs::log::{Log, LogKind, Payload};

/// Mass from which on it is no error of the tool's mass but something that hangs there, kg.
const HEAVY: f64 = 30.0;

/// Share of the squares that a mass may leave of all joints, and of all but the one that it is seen
/// best at: what one joint does alone is another thing.
const PAYLOAD_MISFIT_MAX: f64 = 0.04;
const CARRIED_BY_OTHERS: f64 = 0.5;

/// A mass that nobody wrote down.
pub(super) fn payload(logs: &[Log], rows: &[Vec<LogRow>], robot: &Robot<f64>) -> Option<Mistake> {
    let centre = robot.parameters().tool.com_from_flange;
    let tracked = logs.iter().zip(rows).filter(|(log, _)| {
        log.kind == LogKind::StaticLoad
            && log.samples.payload.as_ref().is_none_or(|p| p.iter().all(|p| p.mass == 0.0))
    });
    // At rest: how far rows of one posture lie apart.
    let mut at_rest = Vec::new();
    let mut names = Vec::new();
    for (log, rows) in tracked {
        names.push(log.name.clone());
        let sagged = rows.iter().filter_map(|row| {
            let seen = row.pose_pair(robot, &row.encoder)?;
            let weight = row.weight(robot, &row.encoder, HEAVY, &centre);
            let hung = LogRow { wrench: row.wrench + weight, ..row.clone() };
            let hung = hung.pose_pair(robot, &row.encoder)?;
            let per_kg = (hung.nominal.position - seen.nominal.position) / HEAVY;
            Some((row.encoder, per_kg, seen.position - seen.nominal.position))
        });
        let sagged: Vec<_> = sagged.collect();
        for posture in sagged.chunk_by(|a, b| (a.0 - b.0).amax() < 5e-3) {
            let n = posture.len() as f64;
            let first = posture.iter().map(|p| p.2).sum::<Vector3<f64>>() / n;
            // Each row's mass, less the posture's mean.
            for (_, per_kg, left) in posture {
                let left = left - first;
                let mass = per_kg.dot(&left) / per_kg.norm_squared();
                at_rest.push((mass, left.norm_squared(), (left - per_kg * mass).norm_squared()));
            }
        }
    }
    let carried = carried(logs, rows, robot).filter(|(mass, _)| !is_denied(rows, robot, *mass));
    let (mass, evidence, change) = if let Some((mass, evidence)) = carried {
        names = logs.iter().map(|log| log.name.clone()).collect();
        (mass, evidence, Remedy::ToolMass(robot.parameters().tool.mass + mass))
    } else {
        let sum = |of: &dyn Fn(&(f64, f64, f64)) -> f64| at_rest.iter().map(of).sum::<f64>();
        let (all, left) = (sum(&|p| p.1), sum(&|p| p.2));
        let range = |sign: f64| at_rest.iter().map(|p| sign * p.0).fold(0.0, f64::max);
        let mass = range(1.0) + range(-1.0);
        let root = |sum: f64| (sum / at_rest.len().max(1) as f64).sqrt();
        if at_rest.len() < RELATION_ROWS_MIN / 2 || mass < HEAVY || left > 0.3 * all {
            return None;
        }
        let channel = LogChannel::Position;
        let evidence = MisfitEvidence { before: root(all), after: root(left), unit: "m", channel };
        (mass, evidence, Remedy::PayloadColumns(mass))
    };
    (mass > HEAVY).then_some(Mistake {
        kind: MistakeKind::Payload,
        channel: LogChannel::Payload,
        columns: Vec::new(),
        logs: names,
        evidence,
        change,
        lines: Vec::new(),
    })
}

/// True where the arm at rest stands as it does without a mass at the tool, kg.
fn is_denied(rows: &[Vec<LogRow>], robot: &Robot<f64>, mass: f64) -> bool {
    let centre = robot.parameters().tool.com_from_flange;
    let (mut without, mut with) = (0.0, 0.0);
    for row in rows.iter().flatten().filter(|row| row.at_rest) {
        let weight = row.weight(robot, &row.encoder, mass, &centre);
        let hung = LogRow { wrench: row.wrench + weight, ..row.clone() };
        let seen = [row, &hung].map(|row| row.pose_pair(robot, &row.encoder));
        if let [Some(seen), Some(hung)] = seen {
            without += (seen.position - seen.nominal.position).norm_squared();
            with += (hung.position - hung.nominal.position).norm_squared();
        }
    }
    with > 2.0 * without
}

/// A mass, kg, that the motors carry besides, wherever its centre is.
fn carried(
    logs: &[Log],
    rows: &[Vec<LogRow>],
    robot: &Robot<f64>,
) -> Option<(f64, MisfitEvidence)> {
    /// How far the centre is moved for the torque of a first moment, m.
    const ARM: f64 = 0.1;
    let tool = &robot.parameters().tool;
    let with = |by: Vector3<f64>| {
        with_payload(robot, &Payload { mass: HEAVY, centre: tool.com_from_flange + by })
    };
    let heavier = with(Vector3::zeros()).ok()?;
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let moved = axes.map(|axis| with(axis * ARM));
    let mut normal = [SMatrix::<f64, 4, 4>::zeros(); JOINTS];
    let mut right = [SVector::<f64, 4>::zeros(); JOINTS];
    let (mut squares, mut count) = (JointVector::zeros(), 0usize);
    let in_motion = logs.iter().zip(rows);
    let in_motion =
        in_motion.filter(|(log, _)| log.samples.motor_torque.iter().any(Option::is_some));
    for row in in_motion.flat_map(|(_, rows)| rows) {
        let needed = |robot: &Robot<f64>| row.motor_torque(robot, row.motion()).sum();
        let (plain, heavier) = (needed(robot), needed(&heavier));
        let moved = moved.each_ref().map(|m| m.as_ref().map_or(heavier, needed));
        for i in (0..JOINTS).filter(|i| row.torque[*i].is_finite()) {
            let moment = |k: usize| (moved[k][i] - heavier[i]) / (HEAVY * ARM);
            let x =
                SVector::from([(heavier[i] - plain[i]) / HEAVY, moment(0), moment(1), moment(2)]);
            let y = row.torque[i] - plain[i];
            normal[i] += x * x.transpose();
            right[i] += x * y;
            squares[i] += y * y;
            count += 1;
        }
    }
    let mut all = normal.iter().sum::<SMatrix<f64, 4, 4>>();
    let least = 1e-9 * all.trace();
    (0..4).for_each(|k| all[(k, k)] += least);
    let found = all.cholesky()?.solve(&right.iter().sum());
    let of_joint =
        |i: usize, y: f64| y - 2.0 * found.dot(&right[i]) + found.dot(&(normal[i] * found));
    let left_of = JointVector::from_fn(|i, _| of_joint(i, squares[i]).max(0.0));
    let alone = (squares - left_of).imax();
    let others = [squares, left_of].map(|s| s.sum() - s[alone]);
    let (squares, left) = (squares.sum(), left_of.sum());
    let is_found = count >= RELATION_ROWS_MIN
        && found[0] > HEAVY
        && left < PAYLOAD_MISFIT_MAX * squares
        && others[1] < CARRIED_BY_OTHERS * others[0];
    let root = |sum: f64| (sum / count.max(1) as f64).sqrt();
    let channel = LogChannel::MotorTorque;
    let evidence =
        MisfitEvidence { before: root(squares), after: root(left), unit: "N·m", channel };
    is_found.then_some((found[0], evidence))
}
