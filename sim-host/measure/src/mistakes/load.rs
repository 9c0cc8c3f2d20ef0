//! Mistakes that show in loads: motor torque, the wrench, what hangs on the flange. Also encoders of a
//! cell without a tracker.

use super::pose::column;
use super::rows::{Row, TorqueParts};
use super::{Change, Evidence, Mistake, MistakeKind};
use crate::data::channel::LogChannel;
use crate::data::log::{Log, LogKind, Payload};
use crate::predict::hung;
use crate::register::PosePair;
use nalgebra::{SMatrix, SVector, Vector3};
use trueweld_core::{JOINTS, JointVector, Robot, Wrench};

/// Rows that a relation of two series rests on, at least.
const FEWEST: usize = 12;

/// Correlation from which on measured follows predicted.
const FOLLOWS: f64 = 0.85;

/// Torque or predicted torque below this share of the drive's limit says nothing.
const FAINT: f64 = 0.01;

/// A torque that is so many times too large or too small is not an effect.
const FACTOR: f64 = 8.0;

/// Share of the squares that exchanged or reversed columns may leave.
const LEFT: f64 = 0.1;

/// Share of the error that another sign or unit of a torque or wrench may leave.
const UNDONE: f64 = 0.5;

/// Mass from which on it is no error of the tool's mass but something that hangs there, kg.
const HEAVY: f64 = 30.0;

/// Share of the squares that a mass may leave of all joints, and of all but the one that it is seen
/// best at: what one joint does alone is another thing.
const CARRIED: f64 = 0.15;
const CARRIED_BY_OTHERS: f64 = 0.5;

/// Sums of products of predicted x and measured y.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    count: usize,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Sums {
    fn of(pairs: impl Iterator<Item = (f64, f64)>) -> Self {
        pairs.filter(|(x, y)| x.is_finite() && y.is_finite()).fold(Self::default(), |s, (x, y)| {
            Self { count: s.count + 1, xx: s.xx + x * x, xy: s.xy + x * y, yy: s.yy + y * y }
        })
    }

    /// Measured per predicted.
    fn slope(&self) -> f64 {
        self.xy / self.xx
    }

    fn correlation(&self) -> f64 {
        self.xy / (self.xx * self.yy).sqrt()
    }

    /// Sum of squares that is left of the measured with the predicted taken so many times.
    fn left(&self, factor: f64) -> f64 {
        self.yy - 2.0 * factor * self.xy + factor * factor * self.xx
    }

    /// Root mean square of a sum of squares.
    fn root(&self, sum: f64) -> f64 {
        (sum.max(0.0) / self.count.max(1) as f64).sqrt()
    }

    /// Larger root mean square of both.
    fn size(&self) -> f64 {
        self.root(self.xx.max(self.yy))
    }
}

/// Mistakes in torques, wrenches and payloads of logs whose poses are right.
pub(super) fn find(logs: &[Log], rows: &[Vec<Row>], robot: &Robot<f64>) -> Vec<Mistake> {
    let mut found = torques(logs, rows, robot);
    for (log, rows) in logs.iter().zip(rows) {
        found.extend(match log.kind {
            LogKind::Weld => weld(log, rows),
            LogKind::StaticLoad => standing(log, rows, robot),
            _ => None,
        });
    }
    join(&mut found);
    if found.is_empty() {
        found.extend(payload(logs, rows, robot));
    }
    found
}

/// The same mistake in several logs is one.
fn join(found: &mut Vec<Mistake>) {
    let mut joined: Vec<Mistake> = Vec::new();
    for mistake in found.drain(..) {
        let same = |m: &&mut Mistake| {
            (m.kind, m.channel, &m.columns) == (mistake.kind, mistake.channel, &mistake.columns)
        };
        match joined.iter_mut().find(same) {
            Some(first) => first.logs.extend(mistake.logs),
            None => joined.push(mistake),
        }
    }
    *found = joined;
}

fn names<'a>(logs: impl Iterator<Item = &'a Log>) -> Vec<String> {
    logs.map(|log| log.name.clone()).collect()
}

/// Mistakes in motor torques, or in the encoders of logs without a tracker.
fn torques(logs: &[Log], rows: &[Vec<Row>], robot: &Robot<f64>) -> Vec<Mistake> {
    let with: Vec<usize> = (0..logs.len())
        .filter(|k| logs[*k].samples.motor_torque.iter().any(Option::is_some))
        .collect();
    let moved: Vec<&Row> = with.iter().flat_map(|k| &rows[*k]).collect();
    if moved.len() < FEWEST {
        return Vec::new();
    }
    let in_logs = names(with.iter().map(|k| &logs[*k]));
    let predicted = |change: &dyn Fn(&JointVector<f64>) -> JointVector<f64>| {
        let of = |row: &&Row| {
            let [q, v, a] = row.motion().map(change);
            row.motor_torque(robot, [&q, &v, &a]).sum()
        };
        moved.iter().map(of).collect::<Vec<_>>()
    };
    let plain = predicted(&|v| *v);
    let sums = |from: &[JointVector<f64>], i: usize, j: usize| {
        Sums::of(from.iter().zip(&moved).map(|(x, row)| (x[i], row.torque[j])))
    };
    let own: Vec<Sums> = (0..JOINTS).map(|i| sums(&plain, i, i)).collect();
    let loud = |i: usize| {
        own[i].count >= FEWEST && own[i].size() > FAINT * robot.parameters().joints[i].max_torque
    };
    let named = |kind, channel, columns: Vec<usize>, before: f64, after: f64, changes| Mistake {
        kind,
        channel,
        columns,
        logs: in_logs.clone(),
        evidence: Evidence { before, after, unit: "N·m", channel: LogChannel::MotorTorque },
        change: Change::Columns(changes),
        lines: Vec::new(),
    };
    let mut found = encoders(logs, &with, &predicted, &sums, &own, &named);
    if !found.is_empty() {
        return found;
    }
    let torque = LogChannel::MotorTorque;
    let parts: Vec<TorqueParts> =
        moved.iter().map(|row| row.motor_torque(robot, row.motion())).collect();
    for a in 0..JOINTS {
        for b in a + 1..JOINTS {
            let (now, crossed) =
                (own[a].left(1.0) + own[b].left(1.0), [sums(&plain, a, b), sums(&plain, b, a)]);
            let swapped = crossed[0].left(1.0) + crossed[1].left(1.0);
            let like = |i: usize, j: usize| {
                drive_scale(&parts, &moved, i, j).is_some_and(|s| (0.5..2.0).contains(&s))
            };
            let crosswise = like(a, b) && like(b, a) && !like(a, a) && !like(b, b);
            if loud(a) && loud(b) && (swapped < LEFT * now || (crosswise && swapped < now)) {
                let mut changes = vec![column(torque, a, "Nm", 1.0), column(torque, b, "Nm", 1.0)];
                let (first, second) = changes.split_at_mut(1);
                std::mem::swap(&mut first[0].channel, &mut second[0].channel);
                let (before, after) = (own[a].root(0.5 * now), own[a].root(0.5 * swapped));
                let kind = MistakeKind::Exchanged;
                found.push(named(kind, torque, vec![a, b], before, after, changes));
            }
        }
    }
    if !found.is_empty() {
        return found;
    }
    // By what it takes to move the joint, which nothing else in a cell does; or all in all.
    let scale = |i: usize| {
        let follows = loud(i) && own[i].correlation().abs() > FOLLOWS;
        let moving = drive_scale(&parts, &moved, i, i);
        moving.or(follows.then(|| own[i].slope()))
    };
    let scales: Vec<Option<f64>> = (0..JOINTS).map(scale).collect();
    let joints: Vec<usize> = (0..JOINTS).filter(|i| scales[*i].is_some()).collect();
    let factor = |i: usize| scales[i].unwrap_or(1.0);
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
            let change = column(torque, i, "Nm", 1.0 / slope);
            let after = after / slope.abs();
            if after < UNDONE * before {
                let kind = MistakeKind::GearSide;
                found.push(named(kind, torque, vec![i], before, after, vec![change]));
            }
        } else if slope < 0.0 && !scaled.contains(&i) {
            let change = column(torque, i, "Nm", -1.0);
            let after = own[i].root(own[i].left(-1.0));
            if after < UNDONE * before && !backwards {
                found.push(named(MistakeKind::Sign, torque, vec![i], before, after, vec![change]));
            }
        }
    }
    if let Some(whole) = whole {
        let unit = if whole < 1.0 { "kNm" } else { "Nmm" };
        let sum = |of: &dyn Fn(&Sums) -> f64| {
            (scaled.iter().map(|i| of(&own[*i]).powi(2)).sum::<f64>() / scaled.len() as f64).sqrt()
        };
        let before = sum(&|s| s.root(s.left(1.0)));
        let after = sum(&|s| s.root(s.left(whole)) / whole);
        let changes = (0..JOINTS).map(|i| column(torque, i, unit, 1.0)).collect();
        found.push(named(MistakeKind::Unit, torque, Vec::new(), before, after, changes));
    }
    found
}

/// Standard deviations at which a scale stands out.
const CLEAR: f64 = 8.0;

/// Joints at which a motion read backwards is seen.
const BACKWARDS: usize = 2;

/// True for a motion read backwards: it turns friction round, and not what inertia needs.
fn is_backwards(parts: &[TorqueParts], rows: &[&Row]) -> bool {
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
    rows: &[Vec<Row>],
    robot: &Robot<f64>,
) -> Option<&'l Log> {
    let moves = |(log, rows): (&'l Log, &Vec<Row>)| {
        let rows: Vec<&Row> = rows.iter().collect();
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
    rows: &[&Row],
    i: usize,
    j: usize,
) -> Option<[(f64, f64); 2]> {
    let mut normal = SMatrix::<f64, 4, 4>::zeros();
    let mut right = SVector::<f64, 4>::zeros();
    let (mut squares, mut count) = (0.0, 0usize);
    for (part, row) in parts.iter().zip(rows) {
        let y = row.torque[j];
        if y.is_finite() {
            let x = SVector::from([1.0, part.held[i], part.friction[i], part.inertia[i]]);
            normal += x * x.transpose();
            right += x * y;
            squares += y * y;
            count += 1;
        }
    }
    let least = 1e-9 * normal.trace();
    (0..4).for_each(|k| normal[(k, k)] += least);
    let inverse = normal.try_inverse()?;
    let found = inverse * right;
    let variance =
        (squares - found.dot(&right)).max(0.0) / count.checked_sub(FEWEST)?.max(1) as f64;
    Some([2, 3].map(|k| (found[k], 1.0 / (variance * inverse[(k, k)]).max(1e-30))))
}

/// What is measured at joint `j` per what moves joint `i`, where that stands out.
fn drive_scale(parts: &[TorqueParts], rows: &[&Row], i: usize, j: usize) -> Option<f64> {
    let both = drive_scales(parts, rows, i, j)?;
    let weight = both[0].1 + both[1].1;
    let scale = (both[0].0 * both[0].1 + both[1].0 * both[1].1) / weight;
    (scale.abs() > CLEAR / weight.sqrt()).then_some(scale)
}

/// Torques that the model predicts with encoders read in some way.
type Predicted<'a> =
    dyn Fn(&dyn Fn(&JointVector<f64>) -> JointVector<f64>) -> Vec<JointVector<f64>> + 'a;

/// Products of predicted and recorded torques, of a predicted and of a recorded joint.
type Products<'a> = dyn Fn(&[JointVector<f64>], usize, usize) -> Sums + 'a;

/// Encoders that count the other way or stand in each other's place, where no tracker says so: all
/// torques then follow better.
fn encoders(
    logs: &[Log],
    with: &[usize],
    predicted: &Predicted<'_>,
    sums: &Products<'_>,
    own: &[Sums],
    named: &dyn Fn(
        MistakeKind,
        LogChannel,
        Vec<usize>,
        f64,
        f64,
        Vec<super::ColumnChange>,
    ) -> Mistake,
) -> Vec<Mistake> {
    if with.iter().any(|k| logs[*k].samples.position.is_some()) {
        return Vec::new();
    }
    // Every joint by its own size, so that the wrist counts as much as the base.
    let share = |all: &[JointVector<f64>]| {
        let each = (0..JOINTS).filter(|i| own[*i].count > 0);
        each.map(|i| (sums(all, i, i).left(1.0) / own[i].yy.max(1e-9)).min(4.0)).sum::<f64>()
    };
    let before = share(&predicted(&|v| *v));
    let encoder = LogChannel::Encoder;
    let mut best: Option<(f64, Mistake)> = None;
    let mut take = |after: f64, mistake: Mistake| {
        if after < 0.5 * before && best.as_ref().is_none_or(|(least, _)| after < 0.8 * least) {
            best = Some((after, mistake));
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
    take(after, named(MistakeKind::Unit, encoder, Vec::new(), before, after, changes));
    for i in 0..JOINTS {
        let after = share(&predicted(&|v| {
            let mut v = *v;
            v[i] = -v[i];
            v
        }));
        let changes = vec![column(encoder, i, "rad", -1.0)];
        take(after, named(MistakeKind::Sign, encoder, vec![i], before, after, changes));
        for j in i + 1..JOINTS {
            let after = share(&predicted(&|v| {
                let mut v = *v;
                v.swap_rows(i, j);
                v
            }));
            let mut changes = vec![column(encoder, i, "rad", 1.0), column(encoder, j, "rad", 1.0)];
            let (first, second) = changes.split_at_mut(1);
            std::mem::swap(&mut first[0].channel, &mut second[0].channel);
            take(after, named(MistakeKind::Exchanged, encoder, vec![i, j], before, after, changes));
        }
    }
    best.into_iter()
        .map(|(_, mistake)| {
            // Shares of the squares, not torques.
            let evidence = Evidence { unit: "1", ..mistake.evidence };
            Mistake { evidence, ..mistake }
        })
        .collect()
}

/// Six lines for the wrench.
fn wrench_lines(units: [&'static str; 2], factor: f64) -> Change {
    let lines = [(LogChannel::Force, units[0]), (LogChannel::Moment, units[1])];
    let lines =
        lines.into_iter().flat_map(|(c, unit)| (0..3).map(move |k| column(c, k, unit, factor)));
    Change::Columns(lines.collect())
}

/// What a factor between measured and expected wrench says: its side, or its unit.
fn of_wrench(
    log: &Log,
    factor: f64,
    before: f64,
    after: f64,
    unit: &'static str,
) -> Option<Mistake> {
    if after > UNDONE * before {
        return None;
    }
    let (kind, change) = if factor < 0.0 && factor.abs() > 1.0 / FACTOR && factor.abs() < FACTOR {
        (MistakeKind::WrenchSide, wrench_lines(["N", "Nm"], -1.0))
    } else if factor.abs() < 1.0 / FACTOR {
        (MistakeKind::Unit, wrench_lines(["kN", "kNm"], factor.signum()))
    } else if factor.abs() > FACTOR {
        (MistakeKind::Unit, wrench_lines(["N", "Nm"], factor.signum() * 1e-3))
    } else {
        return None;
    };
    Some(Mistake {
        kind,
        channel: LogChannel::Force,
        columns: Vec::new(),
        logs: vec![log.name.clone()],
        evidence: Evidence { before, after, unit, channel: LogChannel::Force },
        change,
        lines: Vec::new(),
    })
}

/// A weld pushes the tool out of the plate: along −z of T.
fn weld(log: &Log, rows: &[Row]) -> Option<Mistake> {
    log.samples.force.as_ref()?;
    let push = log.weld.as_ref()?.force;
    let mut along: Vec<f64> = rows.iter().map(|row| -row.wrench.force.z).collect();
    along.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
    along.truncate(rows.len().div_ceil(2));
    along.sort_by(f64::total_cmp);
    let read = *along.get(along.len() / 2)?;
    if read == 0.0 {
        return None;
    }
    let factor = read / push;
    // In the unit and with the sign that it would have.
    let unit = match factor.abs() {
        small if small < 1.0 / FACTOR => 1e3,
        large if large > FACTOR => 1e-3,
        _ => 1.0,
    };
    let right = read.abs() * unit;
    if (right - push).abs() > UNDONE * push {
        return None;
    }
    of_wrench(log, factor, (read - push).abs(), (right - push).abs(), "N")
}

/// What a load on a standing arm does to the tool: it gives way along it.
fn standing(log: &Log, rows: &[Row], robot: &Robot<f64>) -> Option<Mistake> {
    /// A row, as it was seen, and where it would be without its load.
    type Loaded<'a> = (&'a Row, PosePair, PosePair);
    log.samples.force.as_ref()?;
    let loaded = rows.iter().filter_map(|row| {
        let seen = row.pose_pair(robot, &row.encoder)?;
        let free = Row { wrench: Wrench::zero(), ..row.clone() };
        let unloaded = free.pose_pair(robot, &row.encoder)?;
        Some((row, seen, unloaded))
    });
    let loaded: Vec<Loaded<'_>> = loaded.collect();
    // Rows of one posture differ by their load alone.
    let mut pairs: Vec<(f64, f64)> = Vec::new();
    for posture in loaded.chunk_by(|a, b| (a.0.encoder - b.0.encoder).amax() < 5e-3) {
        let mean = |of: &dyn Fn(&Loaded<'_>) -> Vector3<f64>| {
            posture.iter().map(of).sum::<Vector3<f64>>() / posture.len() as f64
        };
        let given = |p: &Loaded<'_>| p.1.nominal.position - p.2.nominal.position;
        let moved = |p: &Loaded<'_>| p.2.position - p.2.nominal.position;
        let (given_mean, moved_mean) = (mean(&given), mean(&moved));
        for row in posture {
            let (x, y) = (given(row) - given_mean, moved(row) - moved_mean);
            pairs.extend(x.iter().copied().zip(y.iter().copied()));
        }
    }
    let sums = Sums::of(pairs.into_iter());
    // Less than a tenth of a millimetre tells nothing.
    if sums.count < FEWEST || sums.root(sums.yy) < 1e-4 || sums.correlation().abs() < FOLLOWS {
        return None;
    }
    let slope = sums.slope();
    let right = if slope < 0.0 && slope.abs() < FACTOR { -1.0 } else { slope };
    of_wrench(log, 1.0 / slope, sums.root(sums.left(1.0)), sums.root(sums.left(right)), "m")
}

/// A mass that nobody wrote down.
fn payload(logs: &[Log], rows: &[Vec<Row>], robot: &Robot<f64>) -> Option<Mistake> {
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
            let hung = Row { wrench: row.wrench + weight, ..row.clone() };
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
        (mass, evidence, Change::ToolMass(robot.parameters().tool.mass + mass))
    } else {
        let sum = |of: &dyn Fn(&(f64, f64, f64)) -> f64| at_rest.iter().map(of).sum::<f64>();
        let (all, left) = (sum(&|p| p.1), sum(&|p| p.2));
        let range = |sign: f64| at_rest.iter().map(|p| sign * p.0).fold(0.0, f64::max);
        let mass = range(1.0) + range(-1.0);
        let root = |sum: f64| (sum / at_rest.len().max(1) as f64).sqrt();
        if at_rest.len() < FEWEST / 2 || mass < HEAVY || left > 0.3 * all {
            return None;
        }
        let channel = LogChannel::Position;
        let evidence = Evidence { before: root(all), after: root(left), unit: "m", channel };
        (mass, evidence, Change::PayloadColumns(mass))
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
fn is_denied(rows: &[Vec<Row>], robot: &Robot<f64>, mass: f64) -> bool {
    let centre = robot.parameters().tool.com_from_flange;
    let (mut without, mut with) = (0.0, 0.0);
    for row in rows.iter().flatten().filter(|row| row.at_rest) {
        let weight = row.weight(robot, &row.encoder, mass, &centre);
        let hung = Row { wrench: row.wrench + weight, ..row.clone() };
        let seen = [row, &hung].map(|row| row.pose_pair(robot, &row.encoder));
        if let [Some(seen), Some(hung)] = seen {
            without += (seen.position - seen.nominal.position).norm_squared();
            with += (hung.position - hung.nominal.position).norm_squared();
        }
    }
    with > 2.0 * without
}

/// A mass, kg, that the motors carry besides, wherever its centre is.
fn carried(logs: &[Log], rows: &[Vec<Row>], robot: &Robot<f64>) -> Option<(f64, Evidence)> {
    /// How far the centre is moved for the torque of a first moment, m.
    const ARM: f64 = 0.1;
    let tool = &robot.parameters().tool;
    let with =
        |by: Vector3<f64>| hung(robot, &Payload { mass: HEAVY, centre: tool.com_from_flange + by });
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
    let stands_out = count >= FEWEST
        && found[0] > HEAVY
        && left < CARRIED * squares
        && others[1] < CARRIED_BY_OTHERS * others[0];
    let root = |sum: f64| (sum / count.max(1) as f64).sqrt();
    let channel = LogChannel::MotorTorque;
    let evidence = Evidence { before: root(squares), after: root(left), unit: "N·m", channel };
    stands_out.then_some((found[0], evidence))
}
