//! Noise of a log's instruments.

use super::columns::LogHeader;
use crate::channel::{COUNT, LOG_CHANNELS, LogChannel};
use nalgebra::Matrix3;
use trueweld_core::spatial::skew;
use trueweld_core::{JOINTS, Pose};
use trueweld_plant::input::{Bounds, InputError, TomlTable};

/// One column's noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseLevel {
    /// Standard deviation, in the column's unit.
    pub deviation: f64,
    /// True where the log states it, false where it was read off the recordings.
    pub stated: bool,
}

/// Noise of every instrument in one log; `None` for a column of which nothing tells.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NoiseLevels {
    /// Tracker: TCP position, m.
    pub position: [Option<NoiseLevel>; 3],
    /// Tracker: rotation vector, rad.
    pub rotation: [Option<NoiseLevel>; 3],
    /// Encoders, rad.
    pub encoder: [Option<NoiseLevel>; JOINTS],
    /// Second encoders on the link side, rad.
    pub link_encoder: [Option<NoiseLevel>; JOINTS],
    /// Motor torque, N·m.
    pub motor_torque: [Option<NoiseLevel>; JOINTS],
    /// Force, N.
    pub force: [Option<NoiseLevel>; 3],
    /// Moment, N·m.
    pub moment: [Option<NoiseLevel>; 3],
}

impl NoiseLevels {
    /// What `log.toml` states.
    pub(super) fn read(table: &TomlTable<'_>, header: &LogHeader) -> Result<Self, InputError> {
        let keys: Vec<&str> =
            LOG_CHANNELS.iter().map(|c| c.noise).filter(|k| !k.is_empty()).collect();
        table.only(&keys)?;
        Ok(Self {
            position: stated(table, header, LogChannel::Position)?,
            rotation: stated(table, header, LogChannel::Rotation)?,
            encoder: stated(table, header, LogChannel::Encoder)?,
            force: stated(table, header, LogChannel::Force)?,
            moment: stated(table, header, LogChannel::Moment)?,
            motor_torque: stated(table, header, LogChannel::MotorTorque)?,
            link_encoder: stated(table, header, LogChannel::LinkEncoder)?,
        })
    }

    /// The columns of each channel.
    pub(crate) fn channels_mut(&mut self) -> [(LogChannel, &mut [Option<NoiseLevel>]); 7] {
        [
            (LogChannel::Position, &mut self.position),
            (LogChannel::Rotation, &mut self.rotation),
            (LogChannel::Encoder, &mut self.encoder),
            (LogChannel::LinkEncoder, &mut self.link_encoder),
            (LogChannel::MotorTorque, &mut self.motor_torque),
            (LogChannel::Force, &mut self.force),
            (LogChannel::Moment, &mut self.moment),
        ]
    }

    /// Of the columns of a channel; none of one that has no noise.
    pub(crate) fn of(&self, channel: LogChannel) -> Vec<Option<NoiseLevel>> {
        let mut all = *self;
        let found = all.channels_mut().into_iter().find(|(of, _)| *of == channel);
        found.map_or(Vec::new(), |(_, levels)| levels.to_vec())
    }

    /// True where the noise of a channel, by its name, is stated.
    pub fn states(&self, channel: &str) -> bool {
        let mut all = *self;
        let is_stated = |level: &Option<NoiseLevel>| level.is_some_and(|level| level.stated);
        all.channels_mut()
            .into_iter()
            .any(|(of, levels)| of.name() == channel && levels.iter().any(is_stated))
    }

    /// What becomes of it where a wrench is taken to the tool centre point, in T, from a sensor that
    /// sits so there. A column that rests on one whose noise is not stated has none stated.
    pub(super) fn at_tool(mut self, sensor: &Pose<f64>) -> Self {
        let lever = skew(&sensor.position) * sensor.rotation;
        let (force, moment) = (self.force, self.moment);
        let row = |m: &Matrix3<f64>, r: usize, of: &[Option<NoiseLevel>; 3]| {
            [0, 1, 2].map(|c| (m[(r, c)], of[c]))
        };
        let sum = |terms: &[(f64, Option<NoiseLevel>)]| {
            let used = terms.iter().filter(|(by, _)| by.abs() > f64::EPSILON);
            let variance: Option<f64> =
                used.map(|(by, l)| Some((by * (*l)?.deviation).powi(2))).sum();
            variance.map(|v| NoiseLevel { deviation: v.sqrt(), stated: true })
        };
        self.force = [0, 1, 2].map(|r| sum(&row(&sensor.rotation, r, &force)));
        self.moment = [0, 1, 2]
            .map(|r| sum(&[row(&sensor.rotation, r, &moment), row(&lever, r, &force)].concat()));
        self
    }

    /// What becomes of it where a column's variance is changed by a factor.
    pub(super) fn propagated(mut self, gain: &[f64; COUNT]) -> Self {
        for (channel, levels) in self.channels_mut() {
            for (level, gain) in levels.iter_mut().zip(&gain[channel.columns()]) {
                level.iter_mut().for_each(|level| level.deviation *= gain.sqrt());
            }
        }
        self
    }
}

/// One standard deviation for all columns, or one a column that the log has.
fn stated<const N: usize>(
    table: &TomlTable<'_>,
    header: &LogHeader,
    channel: LogChannel,
) -> Result<[Option<NoiseLevel>; N], InputError> {
    let there: [bool; N] = header.which(channel);
    let (key, most) = (channel.entry().noise, channel.entry().most_noise);
    // A larger one is in another unit; a smaller one is a slip: squares of residuals over it
    // overflow.
    let bounds = Bounds::Between(most / 1e9, most);
    let level = |deviation: f64| Some(NoiseLevel { deviation, stated: true });
    if !table.has(key) {
        return Ok([None; N]);
    }
    if !table.is_list(key) {
        return Ok([level(table.number(key, bounds)?); N]);
    }
    let list = table.list(key, N, bounds)?;
    if let Ok(all) = <[f64; N]>::try_from(list.as_slice()) {
        return Ok(all.map(level));
    }
    let columns = there.iter().filter(|there| **there).count();
    if list.is_empty() || list.len() != columns {
        let or = if (1..N).contains(&columns) {
            format!(", or {columns}, as many as this log has")
        } else {
            String::new()
        };
        let expected = format!("one number, or a list of {N}, one a column{or}");
        return Err(table.wrong(key, &expected, "Leave the key out where the noise is not known."));
    }
    let mut list = list.into_iter();
    Ok(there.map(|there| if there { list.next().and_then(level) } else { None }))
}
