//! Mistakes in second encoders: each follows the encoder of its joint to what a gear gives.

use super::pose::{column, exchanged};
use super::reading::plain_angle;
use super::refine::quantile;
use super::{ColumnChange, MisfitEvidence, Mistake, MistakeKind};
use std::f64::consts::PI;
use trueweld_core::JOINTS;
use trueweld_logs::channel::LogChannel;
use trueweld_logs::log::Log;

/// What a second encoder and its encoder may be apart, rad: gears give some milliradians, and a zero
/// is taught to a degree or two. With a mistake undone, no more than a gear gives is left.
const ENCODER_DIFFERENCE_MAX: f64 = 0.05;
const ENCODER_REMAINDER_MAX: f64 = 0.02;

/// A joint's second encoder and the encoder of another joint, or its own, in one log.
fn pairs(log: &Log, second: usize, encoder: usize) -> impl Iterator<Item = (f64, f64)> + '_ {
    let read = log.samples.link_encoder[second].iter().flatten();
    let rows = read.zip(&log.samples.encoder).map(move |(link, q)| (*link, q[encoder]));
    rows.filter(|(link, _)| link.is_finite())
}

/// Median of how far they are apart with the second encoder read on a line.
fn median_difference(
    logs: &[&Log],
    [second, encoder]: [usize; 2],
    [slope, offset]: [f64; 2],
) -> Option<f64> {
    let rows = logs.iter().flat_map(|log| pairs(log, second, encoder));
    quantile(rows.map(|(link, q)| (slope * link + offset - q).abs()), 5)
}

/// Mistakes in the second encoders of logs whose encoders are right.
pub(super) fn find(logs: &[Log]) -> Vec<Mistake> {
    const PLAIN_READING: [f64; 2] = [1.0, 0.0];
    let wrong = |i: usize| -> Vec<&Log> {
        let off = |log: &&Log| {
            median_difference(&[*log], [i, i], PLAIN_READING)
                .is_some_and(|by| by > ENCODER_DIFFERENCE_MAX)
        };
        logs.iter().filter(off).collect()
    };
    let wrong: [Vec<&Log>; JOINTS] = std::array::from_fn(wrong);
    let before = |i: usize| median_difference(&wrong[i], [i, i], PLAIN_READING).unwrap_or(0.0);
    let channel = LogChannel::LinkEncoder;
    let named = |kind, columns: Vec<usize>, after: f64, changes| {
        let first = columns[0];
        let logs: Vec<String> = wrong[first].iter().map(|log| log.name.clone()).collect();
        let evidence = MisfitEvidence { before: before(first), after, unit: "rad", channel };
        Mistake::of_columns(kind, channel, columns, &logs, evidence, changes)
    };
    let mut found = Vec::new();
    let mut explained = [false; JOINTS];
    for a in 0..JOINTS {
        for b in a + 1..JOINTS {
            let crossed =
                [[a, b], [b, a]].map(|of| median_difference(&wrong[of[0]], of, PLAIN_READING));
            if let [Some(first), Some(second)] = crossed
                && first.max(second) < ENCODER_REMAINDER_MAX
                && !explained[a]
                && !explained[b]
            {
                [explained[a], explained[b]] = [true, true];
                let changes = exchanged(channel, a, b, "rad");
                found.push(named(MistakeKind::Exchanged, vec![a, b], first, changes));
            }
        }
    }
    for i in (0..JOINTS).filter(|i| !explained[*i] && !wrong[*i].is_empty()) {
        if let Some((kind, after, change)) = on_a_line(&wrong[i], i) {
            found.push(named(kind, vec![i], after, vec![change]));
        }
    }
    found
}

/// The line on which a second encoder follows its encoder, the simplest first.
fn on_a_line(logs: &[&Log], i: usize) -> Option<(MistakeKind, f64, ColumnChange)> {
    let line = |unit, factor| column(LogChannel::LinkEncoder, i, unit, factor);
    let degree = PI / 180.0;
    let zero = |slope: f64| {
        let rows = logs.iter().flat_map(|log| pairs(log, i, i));
        plain_angle(quantile(rows.map(|(link, q)| q - slope * link), 5).unwrap_or(0.0))
    };
    let (plus, minus) = (zero(1.0), zero(-1.0));
    let lines = [
        (MistakeKind::Sign, [-1.0, 0.0], line("rad", -1.0)),
        (MistakeKind::Unit, [degree, 0.0], line("deg", 1.0)),
        (MistakeKind::Unit, [-degree, 0.0], line("deg", -1.0)),
        (MistakeKind::Zero, [1.0, plus], ColumnChange { offset: plus, ..line("rad", 1.0) }),
        (MistakeKind::Sign, [-1.0, minus], ColumnChange { offset: minus, ..line("rad", -1.0) }),
    ];
    lines.into_iter().find_map(|(kind, reading, change)| {
        let left = median_difference(logs, [i, i], reading)
            .filter(|left| *left < ENCODER_REMAINDER_MAX)?;
        Some((kind, left, change))
    })
}
