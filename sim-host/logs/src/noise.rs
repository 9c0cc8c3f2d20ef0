//! How noisy each instrument is: as its maker states it, or read off the recording where nobody does,
//! or where the recording shows white noise that is larger than stated.

use crate::channel::LogChannel;
use crate::floor::{floor, relative_rotation, white};
use crate::log::{Log, LogKind};
pub use crate::log::{NoiseLevel, NoiseLevels};
use trueweld_core::JOINTS;

/// How many times the stated noise white scatter must be for the scatter to be taken for it, and the
/// other way round: it is known to some 10 %, and makers round.
const STATED_NOISE_RATIO_MAX: f64 = 1.5;

/// White scatter of a channel that is not as its log states.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter {
    /// Names of the logs.
    pub logs: Vec<String>,
    /// The channel.
    pub channel: LogChannel,
    /// Deviation that the logs state, in the channel's unit, and that the readings have from row to
    /// row; the root mean square of the columns that are off.
    pub stated: f64,
    /// The same as the recording shows it.
    pub shown: f64,
}

/// The instruments of every log. What a log neither states nor shows is taken from the other logs
/// of the campaign, whose instruments are the same; and where white scatter is larger than stated,
/// that is the noise, in logs that do not show any as well.
pub fn instruments(logs: &[Log]) -> Vec<NoiseLevels> {
    let mut all: Vec<NoiseLevels> = logs.iter().map(of_log).collect();
    larger(logs, &mut all);
    let mut known = all.clone();
    for one in &mut all {
        for (channel, (_, levels)) in one.channels_mut().into_iter().enumerate() {
            for (column, level) in levels.iter_mut().enumerate().filter(|(_, l)| l.is_none()) {
                let of = |known: &mut NoiseLevels| known.channels_mut()[channel].1[column];
                let found = known.iter_mut().filter_map(of).collect();
                *level = median(found, |level: &NoiseLevel| level.deviation);
            }
        }
    }
    all
}

/// Takes white scatter for the noise where it is larger than stated: of the log itself, or of the
/// others that state the same.
fn larger(logs: &[Log], all: &mut [NoiseLevels]) {
    let mut shown: Vec<Option<NoiseLevels>> = logs.iter().map(scatter_of).collect();
    for (k, levels) in all.iter_mut().enumerate() {
        for (channel, (_, levels)) in levels.channels_mut().into_iter().enumerate() {
            for (column, level) in levels.iter_mut().enumerate() {
                let Some(stated) = level.filter(|level| level.stated) else { continue };
                let mut of = |k: usize| {
                    let mut stated_there = logs[k].noise;
                    let there = stated_there.channels_mut()[channel].1[column]?;
                    let shown = shown[k].as_mut()?.channels_mut()[channel].1[column]?;
                    ((there.deviation / stated.deviation - 1.0).abs() < 1e-6).then_some(shown)
                };
                let own = of(k);
                let others = || median((0..logs.len()).filter_map(of).collect(), |l| l.deviation);
                let found = own.or_else(others);
                if let Some(found) =
                    found.filter(|f| f.deviation > STATED_NOISE_RATIO_MAX * stated.deviation)
                {
                    *level = Some(found);
                }
            }
        }
    }
}

/// Channels that scatter by more than their logs state, which is then taken for their noise, or,
/// where `larger` is false, by less.
pub fn scatters(logs: &[Log], larger: bool) -> Vec<Scatter> {
    let mut found: Vec<Scatter> = Vec::new();
    for log in logs {
        let Some(mut shown) = scatter_of(log) else { continue };
        let mut stated = log.noise;
        for ((channel, stated), (_, shown)) in
            stated.channels_mut().into_iter().zip(shown.channels_mut())
        {
            let off = stated.iter().zip(shown.iter()).filter_map(|(stated, shown)| {
                let (stated, shown) = (stated.as_ref()?.deviation, shown.as_ref()?.deviation);
                let off = if larger {
                    shown > STATED_NOISE_RATIO_MAX * stated
                } else {
                    stated > STATED_NOISE_RATIO_MAX * shown
                };
                off.then_some([stated, shown])
            });
            let off: Vec<[f64; 2]> = off.collect();
            if off.is_empty() {
                continue;
            }
            let size = |which: usize| {
                (off.iter().map(|o| o[which].powi(2)).sum::<f64>() / off.len() as f64).sqrt()
            };
            let (stated, shown) = (size(0), size(1));
            let same = |s: &&mut Scatter| s.channel == channel && s.stated == stated;
            match found.iter_mut().find(same) {
                Some(same) => {
                    let before = same.logs.len() as f64;
                    same.shown = (same.shown * before + shown) / (before + 1.0);
                    same.logs.push(log.name.clone());
                }
                None => {
                    found.push(Scatter { logs: vec![log.name.clone()], channel, stated, shown });
                }
            }
        }
    }
    found
}

/// What a log states, and where it does not what its recording shows.
fn of_log(log: &Log) -> NoiseLevels {
    let mut levels = log.noise;
    if log.kind != LogKind::StaticLoad {
        read(log, &mut levels, floor);
    }
    levels
}

/// The white scatter of the columns whose noise a log states; `None` of rows at rest.
fn scatter_of(log: &Log) -> Option<NoiseLevels> {
    if log.kind == LogKind::StaticLoad {
        return None;
    }
    let mut levels = log.noise;
    let unknown = Some(NoiseLevel { deviation: f64::NAN, stated: false });
    for (channel, levels) in levels.channels_mut() {
        // A process, or a brake, shakes the motors themselves; what a free motion commands is smooth.
        let shaken = channel == LogChannel::Encoder && log.kind != LogKind::FreeMotion;
        // What is stated is looked at, and nothing else.
        let looked_at = |level: &Option<NoiseLevel>| level.is_some() && !shaken;
        levels.iter_mut().for_each(|l| *l = if looked_at(l) { None } else { unknown });
    }
    read(log, &mut levels, white);
    for (_, levels) in levels.channels_mut() {
        levels.iter_mut().for_each(|level| *level = level.filter(|l| l.deviation.is_finite()));
    }
    Some(levels)
}

/// Reads the noise that is not known off the recording.
fn read(log: &Log, levels: &mut NoiseLevels, of: fn(&[f64]) -> Option<f64>) {
    let s = &log.samples;
    let read = |level: &mut Option<NoiseLevel>, series: &dyn Fn() -> Option<Vec<f64>>| {
        let shown = || of(&series()?).map(|deviation| NoiseLevel { deviation, stated: false });
        *level = level.or_else(shown);
    };
    let rotation = s.rotation.as_ref().map(|r| relative_rotation(r));
    let vectors = [
        (&mut levels.position, &s.position),
        (&mut levels.rotation, &rotation),
        (&mut levels.force, &s.force),
        (&mut levels.moment, &s.moment),
    ];
    for (levels, series) in vectors {
        for (i, level) in levels.iter_mut().enumerate() {
            read(level, &|| Some(series.as_ref()?.iter().map(|x| x[i]).collect()));
        }
    }
    for i in 0..JOINTS {
        read(&mut levels.encoder[i], &|| Some(s.encoder.iter().map(|q| q[i]).collect()));
        read(&mut levels.link_encoder[i], &|| s.link_encoder[i].clone());
        read(&mut levels.motor_torque[i], &|| s.motor_torque[i].clone());
    }
}

fn median<T: Copy>(mut values: Vec<T>, by: impl Fn(&T) -> f64) -> Option<T> {
    values.sort_by(|a, b| by(a).total_cmp(&by(b)));
    values.get(values.len() / 2).copied()
}
