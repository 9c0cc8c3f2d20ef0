//! Mistakes that show in loads: motor torque, and with it encoders of a cell without a tracker; the
//! wrench and what hangs on the flange have files of their own.

use super::payload::payload;
use super::pose::{column, coupled, exchanged};
use super::reading::WHOLE_SLOPE_TOLERANCE;
use super::relation::{FACTOR, FOLLOWS, ProductSums, RELATION_ROWS_MIN, regression};
use super::rows::{LogRow, TorqueParts};
use super::wrench::{self, UNDONE_ERROR_SHARE_MAX};
use super::{MisfitEvidence, Mistake, MistakeKind, spindle};
use crate::AUTOCORRELATION_INFLATION;
use crate::predict::BaselineModel;
use nalgebra::SVector;
use trueweld_core::{JOINTS, JointVector, Robot};
use trueweld_logs::HALF_95;
use trueweld_logs::channel::LogChannel;
use trueweld_logs::log::{Coupling, Log};

/// Torque or predicted torque below this share of the drive's limit says nothing.
const TELLING_TORQUE_SHARE_MIN: f64 = 0.01;

/// Share of the squares that exchanged or reversed columns may leave.
const EXCHANGED_MISFIT_MAX: f64 = 0.1;

/// Mistakes in torques, wrenches, spindle and payloads of logs whose poses are right.
pub(super) fn find(logs: &[Log], rows: &[Vec<LogRow>], model: &BaselineModel) -> Vec<Mistake> {
    let mut found = torques(logs, rows, &model.robot);
    let wrenches = wrench::find(logs, rows, model);
    if wrenches.is_empty() {
        // The force across the seam is right.
        found.extend(spindle::find(logs, rows, model));
    }
    found.extend(wrenches);
    if found.is_empty() {
        found.extend(payload(logs, rows, &model.robot));
    }
    found
}

fn names<'a>(logs: impl Iterator<Item = &'a Log>) -> Vec<String> {
    logs.map(|log| log.name.clone()).collect()
}

/// Mistakes in motor torques, or in the encoders of logs without a tracker.
fn torques(logs: &[Log], rows: &[Vec<LogRow>], robot: &Robot<f64>) -> Vec<Mistake> {
    let with: Vec<usize> = (0..logs.len())
        .filter(|k| logs[*k].samples.motor_torque.iter().any(Option::is_some))
        .collect();
    let moved: Vec<&LogRow> = with.iter().flat_map(|k| &rows[*k]).collect();
    if moved.len() < RELATION_ROWS_MIN {
        return Vec::new();
    }
    let in_logs = names(with.iter().map(|k| &logs[*k]));
    let predicted = |change: &dyn Fn(&JointVector<f64>) -> JointVector<f64>| {
        let of = |row: &&LogRow| {
            let [q, v, a] = row.motion().map(change);
            row.motor_torque(robot, [&q, &v, &a]).sum()
        };
        moved.iter().map(of).collect::<Vec<_>>()
    };
    let plain = predicted(&|v| *v);
    let sums = |from: &[JointVector<f64>], i: usize, j: usize| {
        ProductSums::of(from.iter().zip(&moved).map(|(x, row)| (x[i], row.torque[j])))
    };
    let own: Vec<ProductSums> = (0..JOINTS).map(|i| sums(&plain, i, i)).collect();
    // A factor that was found says nothing of the file.
    let open = |i: usize| with.iter().any(|k| logs[*k].origin.currents[i].is_some());
    let loud = |i: usize| {
        !open(i)
            && own[i].count >= RELATION_ROWS_MIN
            && own[i].size() > TELLING_TORQUE_SHARE_MIN * robot.parameters().joints[i].max_torque
    };
    let left = |all: &[JointVector<f64>], i: usize| {
        let of = sums(all, i, i);
        of.left(if open(i) { of.slope() } else { 1.0 })
    };
    let mut found = encoders(logs, &with, &predicted, &left, &own, &in_logs, &Coupling::all(robot));
    if !found.is_empty() {
        return found;
    }
    let torque = LogChannel::MotorTorque;
    let named = |kind, columns: Vec<usize>, before: f64, after: f64, changes| {
        let evidence = MisfitEvidence { before, after, unit: "N·m", channel: torque };
        Mistake::of_columns(kind, torque, columns, &in_logs, evidence, changes)
    };
    let parts: Vec<TorqueParts> =
        moved.iter().map(|row| row.motor_torque(robot, row.motion())).collect();
    for a in 0..JOINTS {
        for b in a + 1..JOINTS {
            let (now, crossed) =
                (own[a].left(1.0) + own[b].left(1.0), [sums(&plain, a, b), sums(&plain, b, a)]);
            let swapped = crossed[0].left(1.0) + crossed[1].left(1.0);
            let like = |i: usize, j: usize| {
                drive_scale(&parts, &moved, i, j).is_some_and(|[s, _]| (0.5..2.0).contains(&s))
            };
            let crosswise = like(a, b) && like(b, a) && !like(a, a) && !like(b, b);
            if loud(a)
                && loud(b)
                && (swapped < EXCHANGED_MISFIT_MAX * now || (crosswise && swapped < now))
            {
                let changes = exchanged(torque, a, b, "Nm");
                let (before, after) = (own[a].root(0.5 * now), own[a].root(0.5 * swapped));
                found.push(named(MistakeKind::Exchanged, vec![a, b], before, after, changes));
            }
        }
    }
    if !found.is_empty() {
        return found;
    }
    // By what it takes to move the joint, which nothing else in a cell does; or all in all.
    let scale = |i: usize| {
        if open(i) {
            return None;
        }
        let follows = loud(i) && own[i].correlation().abs() > FOLLOWS;
        let moving = drive_scale(&parts, &moved, i, i);
        moving.or(follows.then(|| [own[i].slope(), own[i].slope_deviation()]))
    };
    let scales: Vec<Option<[f64; 2]>> = (0..JOINTS).map(scale).collect();
    let joints: Vec<usize> = (0..JOINTS).filter(|i| scales[*i].is_some()).collect();
    let factor = |i: usize| scales[i].map_or(1.0, |[scale, _]| scale);
    let scaled: Vec<usize> = joints
        .iter()
        .copied()
        .filter(|i| factor(*i).abs() < 1.0 / FACTOR || factor(*i).abs() > FACTOR)
        .collect();
    // One factor for all joints is a unit; gears differ.
    let whole = [1e-3, 1e3].into_iter().find(|unit| {
        scaled.len() > 1
            && scaled.len() == joints.len()
            && scaled.iter().all(|i| (factor(*i) / unit).ln().abs() < 0.7)
    });
    let backwards = is_backwards(&parts, &moved);
    for i in joints {
        let slope = factor(i);
        let (before, after) = (own[i].root(own[i].left(1.0)), own[i].root(own[i].left(slope)));
        if scaled.contains(&i) && whole.is_none() {
            // Seen from the joint: as many times as the model needs it to be.
            let deviation = scales[i].map_or(0.0, |[_, deviation]| deviation);
            let fitted = HALF_95 * AUTOCORRELATION_INFLATION.sqrt() * deviation / slope.abs();
            let units = [("kNm", 1e3), ("Nmm", 1e-3)];
            let is_plain = |factor: f64| {
                (factor * slope.abs() - 1.0).abs() < fitted.max(WHOLE_SLOPE_TOLERANCE)
            };
            let unit = units.into_iter().find(|(_, factor)| is_plain(*factor));
            let (kind, change) = match unit {
                Some((unit, _)) => (MistakeKind::Unit, column(torque, i, unit, slope.signum())),
                None => {
                    let change = column(torque, i, "Nm", 1.0 / slope);
                    (MistakeKind::GearSide, super::ColumnChange { fitted, ..change })
                }
            };
            let after = after / slope.abs();
            // Scaled down to nothing it would leave what the model predicts.
            let is_told = slope.abs() < 1.0 || after < own[i].root(own[i].xx);
            if after < UNDONE_ERROR_SHARE_MAX * before && is_told {
                found.push(named(kind, vec![i], before, after, vec![change]));
            }
        } else if slope < 0.0 && !scaled.contains(&i) {
            let change = column(torque, i, "Nm", -1.0);
            let after = own[i].root(own[i].left(-1.0));
            if after < UNDONE_ERROR_SHARE_MAX * before && !backwards {
                found.push(named(MistakeKind::Sign, vec![i], before, after, vec![change]));
            }
        }
    }
    if let Some(whole) = whole {
        let unit = if whole < 1.0 { "kNm" } else { "Nmm" };
        let sum = |of: &dyn Fn(&ProductSums) -> f64| {
            (scaled.iter().map(|i| of(&own[*i]).powi(2)).sum::<f64>() / scaled.len() as f64).sqrt()
        };
        let before = sum(&|s| s.root(s.left(1.0)));
        let after = sum(&|s| s.root(s.left(whole)) / whole);
        if whole > 1.0 && after >= sum(&|s| s.root(s.xx)) {
            return found;
        }
        let changes = (0..JOINTS).map(|i| column(torque, i, unit, 1.0)).collect();
        found.push(named(MistakeKind::Unit, Vec::new(), before, after, changes));
    }
    found
}

/// Standard deviations at which a scale stands out.
pub(super) const CLEAR: f64 = 8.0;

/// Joints at which a motion read backwards is seen.
const BACKWARDS: usize = 2;

/// True for a motion read backwards: it turns friction round, and not what inertia needs.
fn is_backwards(parts: &[TorqueParts], rows: &[&LogRow]) -> bool {
    let turned = |both: &[(f64, f64); 2]| {
        let [friction, inertia] = both.map(|(scale, weight)| scale * weight.sqrt());
        friction < -CLEAR && inertia > CLEAR
    };
    let joints = (0..JOINTS).filter_map(|i| drive_scales(parts, rows, i, i));
    joints.filter(turned).count() >= BACKWARDS
}

/// A log whose rows stand in the wrong order.
pub(super) fn read_backwards<'l>(
    logs: &'l [Log],
    rows: &[Vec<LogRow>],
    robot: &Robot<f64>,
) -> Option<&'l Log> {
    let moves = |(log, rows): (&'l Log, &Vec<LogRow>)| {
        let rows: Vec<&LogRow> = rows.iter().collect();
        let parts: Vec<TorqueParts> =
            rows.iter().map(|row| row.motor_torque(robot, row.motion())).collect();
        is_backwards(&parts, &rows).then_some(log)
    };
    logs.iter().zip(rows).find_map(moves)
}

/// What is measured at joint `j` per what friction and inertia of joint `i` need, each with the
/// reciprocal of its variance.
fn drive_scales(
    parts: &[TorqueParts],
    rows: &[&LogRow],
    i: usize,
    j: usize,
) -> Option<[(f64, f64); 2]> {
    let regressors = |(part, row): (&TorqueParts, &&LogRow)| {
        (SVector::from([1.0, part.held[i], part.friction[i], part.inertia[i]]), row.torque[j])
    };
    let (found, covariance) = regression(parts.iter().zip(rows).map(regressors))?;
    Some([2, 3].map(|k| (found[k], 1.0 / covariance[(k, k)].max(1e-30))))
}

/// What is measured at joint `j` per what moves joint `i`, where that stands out, and its deviation.
fn drive_scale(parts: &[TorqueParts], rows: &[&LogRow], i: usize, j: usize) -> Option<[f64; 2]> {
    let both = drive_scales(parts, rows, i, j)?;
    let weight = both[0].1 + both[1].1;
    let scale = (both[0].0 * both[0].1 + both[1].0 * both[1].1) / weight;
    let deviation = 1.0 / weight.sqrt();
    (scale.abs() > CLEAR * deviation).then_some([scale, deviation])
}

/// Torques that the model predicts with encoders read in some way.
type PredictedTorques<'a> =
    dyn Fn(&dyn Fn(&JointVector<f64>) -> JointVector<f64>) -> Vec<JointVector<f64>> + 'a;

/// Squares of a joint's recorded torques that predicted ones leave.
type SquaresLeft<'a> = dyn Fn(&[JointVector<f64>], usize) -> f64 + 'a;

/// Encoders that count the other way, from the horizontal, or stand in each other's place, where no
/// tracker says so: all torques then follow better.
fn encoders(
    logs: &[Log],
    with: &[usize],
    predicted: &PredictedTorques<'_>,
    left: &SquaresLeft<'_>,
    own: &[ProductSums],
    in_logs: &[String],
    couplings: &[Coupling],
) -> Vec<Mistake> {
    if with.iter().any(|k| logs[*k].samples.position.is_some()) {
        return Vec::new();
    }
    // Every joint by its own size, so that the wrist counts as much as the base.
    let share = |all: &[JointVector<f64>]| {
        let each = (0..JOINTS).filter(|i| own[*i].count > 0);
        each.map(|i| (left(all, i) / own[i].yy.max(1e-9)).min(4.0)).sum::<f64>()
    };
    let before = share(&predicted(&|v| *v));
    let (encoder, channel) = (LogChannel::Encoder, LogChannel::MotorTorque);
    let mut best: Option<Mistake> = None;
    // Before and after are shares of the squares, not torques.
    let mut take = |kind, columns: Vec<usize>, after: f64, changes| {
        let least = best.as_ref().map_or(f64::INFINITY, |best| best.evidence.after);
        if after < 0.5 * before && after < 0.8 * least {
            let evidence = MisfitEvidence { before, after, unit: "1", channel };
            best = Some(Mistake::of_columns(kind, encoder, columns, in_logs, evidence, changes));
        }
    };
    let degrees = std::f64::consts::PI / 180.0;
    let changes = (0..JOINTS).map(|i| column(encoder, i, "deg", 1.0)).collect();
    // Angles that one joint alone has too large are not in degrees.
    let turned = |i: &usize| {
        let rows = with.iter().flat_map(|k| &logs[*k].samples.encoder);
        rows.map(|q| q[*i].abs()).fold(0.0, f64::max) > std::f64::consts::TAU
    };
    let after = match (0..JOINTS).filter(turned).count() {
        0 | 1 => f64::INFINITY,
        _ => share(&predicted(&|v| *v * degrees)),
    };
    // Angles that are nearly scaled away must tell more than none.
    let none = share(&predicted(&|_| JointVector::zeros()));
    let after = if after < none { after } else { f64::INFINITY };
    take(MistakeKind::Unit, Vec::new(), after, changes);
    for i in 0..JOINTS {
        let after = share(&predicted(&|v| {
            let mut v = *v;
            v[i] = -v[i];
            v
        }));
        let changes = vec![column(encoder, i, "rad", -1.0)];
        take(MistakeKind::Sign, vec![i], after, changes);
        for j in i + 1..JOINTS {
            let after = share(&predicted(&|v| {
                let mut v = *v;
                v.swap_rows(i, j);
                v
            }));
            let changes = exchanged(encoder, i, j, "rad");
            take(MistakeKind::Exchanged, vec![i, j], after, changes);
        }
    }
    for coupling in couplings {
        let after = share(&predicted(&|v| coupling.of(v)));
        let columns = vec![coupling.joint, coupling.other];
        take(MistakeKind::Coupling, columns, after, vec![coupled(*coupling)]);
    }
    best.into_iter().collect()
}
