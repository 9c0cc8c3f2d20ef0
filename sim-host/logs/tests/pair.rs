//! Two logs of one experiment beside each other.

use nalgebra::Vector3;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_logs::channel::LogChannel;
use trueweld_logs::log::Log;
use trueweld_logs::pair::{
    ChannelDifference, ColumnDifference, DifferenceVariable, PairError, compare_logs,
};

fn log(name: &str) -> Log {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/campaigns/backlash");
    Log::read(format!("{folder}/{name}")).unwrap()
}

fn columns(channels: &[ChannelDifference]) -> Vec<(LogChannel, &ColumnDifference)> {
    let of = |c: &'_ ChannelDifference| c.channel;
    channels.iter().flat_map(|c| c.columns.iter().map(move |column| (of(c), column))).collect()
}

#[test]
fn a_log_is_the_same_as_itself() {
    for name in ["static", "free", "ring-25", "weld-1"] {
        let first = log(name);
        let pair = compare_logs(&first, &first).unwrap();
        assert_eq!((pair.rows, pair.unmatched), (first.samples.len(), [0, 0]), "{name}");
        for (channel, column) in columns(&pair.channels) {
            assert!(column.rms < 1e-8, "{name}, {}: {}", channel.name(), column.rms);
        }
    }
}

/// The log on another day: another clock, begun later, the tracker elsewhere, more friction in A2.
#[test]
fn what_changed_is_told_apart_from_clocks_and_frames() {
    let first = log("free");
    let mut second = first.clone();
    let late = 120;
    let samples = &mut second.samples;
    let directions: Vec<f64> = (0..samples.len()).map(|k| direction(&first, k)).collect();
    let turn = rotation_from_vector(&Vector3::new(0.02, -0.01, 0.4));
    let away = Vector3::new(0.3, -0.2, 0.05);
    samples.time.iter_mut().for_each(|t| *t = 1000.0 + 1.00003 * *t);
    for position in samples.position.as_mut().unwrap() {
        *position = turn * *position + away;
    }
    for rotation in samples.rotation.as_mut().unwrap() {
        *rotation = rotation_vector(&(turn * rotation_from_vector(rotation)));
    }
    let torque = samples.motor_torque[1].as_mut().unwrap();
    torque.iter_mut().zip(&directions).for_each(|(torque, way)| *torque += 40.0 * way);
    samples.time.drain(..late);
    samples.encoder.drain(..late);
    samples.position.as_mut().unwrap().drain(..late);
    samples.rotation.as_mut().unwrap().drain(..late);
    samples.motor_torque.iter_mut().flatten().for_each(|torque| drop(torque.drain(..late)));

    let pair = compare_logs(&first, &second).unwrap();
    let clock = pair.clock.unwrap().map;
    let begin = first.samples.time[0];
    let read = clock.offset + (1.0 + clock.drift) * begin;
    assert!((read - (1000.0 + 1.00003 * begin)).abs() < 1e-5, "{read}");
    assert!((clock.drift - 3e-5).abs() < 2e-6, "{}", clock.drift);
    let moved = pair.tracker.unwrap();
    assert!(moved.turned);
    assert!((moved.motion.rotation - turn.transpose()).amax() < 1e-5, "{moved:?}");
    assert_eq!(pair.rows, first.samples.len() - late);
    for (channel, column) in columns(&pair.channels) {
        let ratio = column.rms / column.noise.unwrap();
        if (channel, column.component) == (LogChannel::MotorTorque, 1) {
            let follows = column.follows.unwrap();
            assert_eq!(follows.of, DifferenceVariable::Direction(1));
            assert!((follows.size - 40.0).abs() < 1.0 && follows.share > 0.9, "{follows:?}");
        } else {
            assert!(ratio < 0.1, "{} {}: {ratio}", channel.name(), column.component);
        }
    }
}

fn direction(log: &Log, row: usize) -> f64 {
    let q = &log.samples.encoder;
    let (a, b) = (row.saturating_sub(1), (row + 1).min(q.len() - 1));
    let step = q[b][1] - q[a][1];
    if step.abs() > 1e-4 { step.signum() } else { 0.0 }
}

#[test]
fn loads_are_matched_by_posture_and_payload() {
    let first = log("static");
    let mut second = first.clone();
    let n = second.samples.len();
    let samples = &mut second.samples;
    samples.encoder.reverse();
    samples.position.as_mut().unwrap().reverse();
    samples.rotation.as_mut().unwrap().reverse();
    samples.payload.as_mut().unwrap().reverse();
    samples.payload.as_mut().unwrap()[3].mass += 80.0;
    let pair = compare_logs(&first, &second).unwrap();
    assert!(pair.clock.is_none());
    assert_eq!((pair.rows, pair.unmatched), (n - 1, [1, 1]));
}

#[test]
fn what_is_no_second_recording_is_refused() {
    let [rest, free, ring] = ["static", "free", "ring-25"].map(log);
    assert!(matches!(compare_logs(&rest, &free), Err(PairError::Kinds(..))));
    assert!(matches!(
        compare_logs(&ring, &log("ring-14")),
        Err(PairError::OtherMotion { .. } | PairError::Rests)
    ));
    let mut other = free.clone();
    other.samples.encoder.reverse();
    assert!(matches!(compare_logs(&free, &other), Err(PairError::OtherMotion { .. })));
    let mut other = rest.clone();
    other.samples.encoder.iter_mut().for_each(|q| q[0] += 0.5);
    assert_eq!(compare_logs(&rest, &other).unwrap_err(), PairError::NoCommonRow);
}
