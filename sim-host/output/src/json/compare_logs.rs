//! By how much two logs of one experiment differ.

use super::{finite, result};
use crate::CompareLogsReport;
use crate::text::compare_logs::column_name;
use trueweld_core::spatial::rotation_vector;
use trueweld_logs::clock::FittedClock;
use trueweld_logs::pair::{
    ChannelDifference, ColumnDifference, DifferenceVariable, FollowedDifference, TrackerMove,
};
use trueweld_plant::provenance::Provenance;

result! {
    /// By how much two logs of one experiment differ: the second less the first.
    CompareLogsResult<'a> of (report: &CompareLogsReport<'a>) with {
        let (pair, logs) = (report.pair, report.logs);
    } {
        /// What the result is of.
        provenance: &'a Provenance = report.provenance,
        /// Folders of the first and the second log.
        logs: [String; 2] = [&logs[0], &logs[1]].map(|log| log.path.display().to_string()),
        /// What was done.
        kind: String = logs[0].kind.name().to_owned(),
        /// Rows that are compared.
        rows: usize = pair.rows,
        /// Rows of each log that the other does not have.
        unmatched: [usize; 2] = pair.unmatched,
        /// The second log's clock against the first's; null of loads at rest.
        clock: Option<PairClock> = pair.clock.as_ref().map(PairClock::of),
        /// How the second tracker stands in the first's frame, which is taken out; null without one.
        tracker: Option<MovedTracker> = pair.tracker.as_ref().map(MovedTracker::of),
        /// Every channel that both logs have.
        channels: Vec<DifferentChannel> =
            pair.channels.iter().map(|channel| DifferentChannel::of(channel, report)).collect(),
    }
}

result! {
    /// A clock against another: time = offset + (1 + drift) · the other's.
    PairClock of (clock: &FittedClock) {
        /// Offset, s.
        offset_s: f64 = clock.map.offset,
        /// What it gains, s per s.
        drift: f64 = clock.map.drift,
        /// Standard deviations of offset, s, and drift.
        deviation: [f64; 2] = clock.deviation,
        /// Root mean square of what is left between the tool's paths by the encoders, m.
        left_m: f64 = clock.left,
    }
}

result! {
    /// A tracker that stands elsewhere than before.
    MovedTracker of (moved: &TrackerMove) {
        /// Shift at the base's origin, m.
        position_m: [f64; 3] = moved.motion.position.into(),
        /// Rotation vector, rad.
        rotation_rad: [f64; 3] = rotation_vector(&moved.motion.rotation).into(),
        /// False where the points tell no turn: a shift alone.
        turned: bool = moved.turned,
    }
}

result! {
    /// By how much logs differ in a channel.
    DifferentChannel of (channel: &ChannelDifference, report: &CompareLogsReport<'_>) {
        /// Its name.
        name: String = channel.channel.name().to_owned(),
        /// Unit of the figures.
        unit: String = channel.channel.unit().to_owned(),
        /// Root mean square of the difference.
        rms: f64 = channel.rms(),
        /// What noise alone makes of it; null where it is not known.
        noise: Option<f64> = channel.noise(),
        /// How many times the noise it is; null where that is not known.
        score: Option<f64> = channel.score(),
        /// Each column.
        columns: Vec<DifferentColumn> =
            channel.columns.iter().map(|c| DifferentColumn::of(channel, c, report)).collect(),
    }
}

result! {
    /// By how much logs differ in a column.
    DifferentColumn of (
        channel: &ChannelDifference,
        column: &ColumnDifference,
        report: &CompareLogsReport<'_>,
    ) {
        /// Axis or joint.
        name: String = column_name(channel, column, &report.logs[0].robot),
        /// Values that were compared.
        samples: usize = column.count,
        /// Root mean square of the difference.
        rms: f64 = column.rms,
        /// Its largest magnitude.
        largest: f64 = column.largest.0,
        /// When that was, in the first log, s.
        largest_at_s: f64 = column.largest.1,
        /// Its mean.
        mean: f64 = column.mean[0],
        /// Half the 95 % interval of the mean, from ten stretches of the log; null of a single row.
        mean_interval: Option<f64> = finite(column.mean[1]),
        /// What noise alone makes of the difference; null where it is not known.
        noise: Option<f64> = column.noise,
        /// What explains most of it beside its mean; null where nothing does.
        follows: Option<FollowedVariable> =
            column.follows.as_ref().map(|followed| FollowedVariable::of(followed, report)),
    }
}

result! {
    /// What a difference follows.
    FollowedVariable of (followed: &FollowedDifference, report: &CompareLogsReport<'_>) {
        /// `time`, `value` (the column's own, the mean of both logs), `direction` of a joint's motion, or
        /// `payload`.
        variable: String = match followed.of {
            DifferenceVariable::Time => "time",
            DifferenceVariable::Value => "value",
            DifferenceVariable::Direction(_) => "direction",
            DifferenceVariable::Payload => "payload",
        }.to_owned(),
        /// The joint, of a direction.
        joint: Option<String> = match followed.of {
            DifferenceVariable::Direction(joint) => {
                Some(report.logs[0].robot.joint_names[joint].clone())
            }
            _ => None,
        },
        /// Share of the squared difference that it explains.
        share: f64 = followed.share,
        /// Change of the difference from begin to end of the log, for a value of 1, from standing to
        /// moving, or from no payload to the largest; in the channel's unit.
        size: f64 = followed.size,
    }
}
