//! Mistakes in wrenches: the side that is stated, and the unit.

use super::pose::column;
use super::relation::{FACTOR, FEWEST, FOLLOWS, Sums};
use super::rows::Row;
use super::{Change, Evidence, Mistake, MistakeKind};
use crate::data::channel::LogChannel;
use crate::data::log::Log;
use crate::register::PosePair;
use nalgebra::Vector3;
use trueweld_core::{Robot, Wrench};

/// Share of the error that another sign or unit of a torque or wrench may leave.
pub(super) const UNDONE: f64 = 0.5;

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
pub(super) fn weld(log: &Log, rows: &[Row]) -> Option<Mistake> {
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
pub(super) fn standing(log: &Log, rows: &[Row], robot: &Robot<f64>) -> Option<Mistake> {
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
