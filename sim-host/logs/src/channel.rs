//! The channels of a log: one entry each says which columns it has, what they may hold, what the
//! noise is called, and which kinds of logs need it or are compared by it.

use super::kind::LogKind;

/// A channel of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogChannel {
    /// Time, s.
    Time,
    /// Encoder angles on the joint side, rad.
    Encoder,
    /// Second encoders on the link side, rad.
    LinkEncoder,
    /// Motor torques seen from the joint, N·m.
    MotorTorque,
    /// Force on the tool, in T, N.
    Force,
    /// Moment on the tool, at the tool centre point, in T, N·m.
    Moment,
    /// Tracker: tool centre point in B, m.
    Position,
    /// Tracker: rotation vector of T in B, rad.
    Rotation,
    /// Spindle speed, rad/s.
    Spindle,
    /// Mass on the flange, kg, and its centre, m.
    Payload,
}

/// What is known of a channel.
#[derive(Debug)]
pub struct ChannelEntry {
    /// Which.
    pub id: LogChannel,
    /// Name in results.
    pub name: &'static str,
    /// Unit; of a payload that of its mass.
    pub unit: &'static str,
    /// What measures it, as messages name it.
    pub instrument: &'static str,
    /// Columns of `samples.csv`.
    pub columns: &'static [&'static str],
    /// True where a log has all of its columns or none.
    pub together: bool,
    /// Key of its noise in `log.toml`; empty where it has none.
    pub noise: &'static str,
    /// Largest noise that an instrument of a cell may have, in the unit.
    pub most_noise: f64,
    /// Largest magnitude that a cell can have, in the unit, and what a larger one is probably in.
    pub most: (f64, &'static str),
    /// Kinds of logs that cannot be read without it.
    pub needed: &'static [LogKind],
    /// Kinds of logs in which the model predicts it.
    pub predicted: &'static [LogKind],
}

impl ChannelEntry {
    const fn new(
        id: LogChannel,
        name: &'static str,
        unit: &'static str,
        columns: &'static [&'static str],
    ) -> Self {
        Self {
            id,
            name,
            unit,
            instrument: name,
            columns,
            together: false,
            noise: "",
            most_noise: 0.0,
            most: (1e6, "another unit"),
            needed: &[],
            predicted: &[],
        }
    }
}

use LogKind::{FreeMotion, StaticLoad, Weld};

/// Every channel, in the order in which columns are numbered.
pub(crate) static LOG_CHANNELS: [ChannelEntry; 10] = [
    ChannelEntry {
        most: (1e10, "milliseconds or less"),
        needed: &LogKind::ALL,
        ..ChannelEntry::new(LogChannel::Time, "time", "s", &["t_s"])
    },
    ChannelEntry {
        instrument: "the encoders",
        noise: "encoder_rad",
        most_noise: 0.1,
        most: (7.0, "degrees"),
        needed: &LogKind::ALL,
        ..ChannelEntry::new(
            LogChannel::Encoder,
            "encoder",
            "rad",
            &["qe1_rad", "qe2_rad", "qe3_rad", "qe4_rad", "qe5_rad", "qe6_rad"],
        )
    },
    ChannelEntry {
        instrument: "the second encoders",
        noise: "link_encoder_rad",
        most_noise: 0.1,
        most: (7.0, "degrees"),
        predicted: &[FreeMotion],
        ..ChannelEntry::new(
            LogChannel::LinkEncoder,
            "link_encoder",
            "rad",
            &["ql1_rad", "ql2_rad", "ql3_rad", "ql4_rad", "ql5_rad", "ql6_rad"],
        )
    },
    ChannelEntry {
        instrument: "motor torque",
        noise: "motor_torque_nm",
        most_noise: 1e5,
        predicted: &[FreeMotion],
        ..ChannelEntry::new(
            LogChannel::MotorTorque,
            "motor_torque",
            "N·m",
            &["tm1_nm", "tm2_nm", "tm3_nm", "tm4_nm", "tm5_nm", "tm6_nm"],
        )
    },
    ChannelEntry {
        instrument: "the force sensor",
        together: true,
        noise: "force_n",
        most_noise: 1e5,
        predicted: &[Weld],
        ..ChannelEntry::new(LogChannel::Force, "force", "N", &["fx_n", "fy_n", "fz_n"])
    },
    ChannelEntry {
        instrument: "the moment sensor",
        together: true,
        noise: "moment_nm",
        most_noise: 1e5,
        predicted: &[Weld],
        ..ChannelEntry::new(LogChannel::Moment, "moment", "N·m", &["mx_nm", "my_nm", "mz_nm"])
    },
    ChannelEntry {
        instrument: "the tracker's position",
        together: true,
        noise: "tcp_position_m",
        most_noise: 0.1,
        most: (20.0, "millimetres"),
        predicted: &LogKind::ALL,
        ..ChannelEntry::new(LogChannel::Position, "tcp_position", "m", &["px_m", "py_m", "pz_m"])
    },
    ChannelEntry {
        instrument: "the tracker's rotation",
        together: true,
        noise: "tcp_rotation_rad",
        most_noise: 0.5,
        most: (7.0, "degrees"),
        predicted: &[StaticLoad, FreeMotion, Weld],
        ..ChannelEntry::new(
            LogChannel::Rotation,
            "tcp_rotation",
            "rad",
            &["rx_rad", "ry_rad", "rz_rad"],
        )
    },
    ChannelEntry {
        most: (1e4, "another unit"),
        needed: &[Weld],
        ..ChannelEntry::new(LogChannel::Spindle, "spindle", "rad/s", &["spindle_rad_s"])
    },
    ChannelEntry {
        together: true,
        most: (1e4, "grams"),
        ..ChannelEntry::new(
            LogChannel::Payload,
            "payload",
            "kg",
            &["payload_kg", "cx_m", "cy_m", "cz_m"],
        )
    },
];

/// Number of columns that are known.
pub(super) const COUNT: usize = first(LOG_CHANNELS.len());

/// Number of all columns before the channel of this index.
const fn first(index: usize) -> usize {
    let (mut sum, mut i) = (0, 0);
    while i < index {
        sum += LOG_CHANNELS[i].columns.len();
        i += 1;
    }
    sum
}

impl LogChannel {
    /// Its name in results.
    pub fn name(self) -> &'static str {
        self.entry().name
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        self.entry().unit
    }

    /// Key of its noise in `log.toml`; empty where it has none.
    pub fn noise_key(self) -> &'static str {
        self.entry().noise
    }

    /// What is known of it.
    pub fn entry(self) -> &'static ChannelEntry {
        &LOG_CHANNELS[self as usize]
    }

    /// Numbers of its columns.
    pub(super) const fn columns(self) -> std::ops::Range<usize> {
        first(self as usize)..first(self as usize + 1)
    }

    /// The channel that a column belongs to, and its place there.
    pub(super) fn of(column: usize) -> (&'static ChannelEntry, usize) {
        let has = |entry: &&ChannelEntry| entry.id.columns().contains(&column);
        let entry = LOG_CHANNELS.iter().find(has).unwrap_or(&LOG_CHANNELS[0]);
        (entry, column - entry.id.columns().start)
    }
}

/// Name of a column.
pub(super) fn column_name(column: usize) -> &'static str {
    let (entry, place) = LogChannel::of(column);
    entry.columns[place]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_stand_in_the_order_of_their_channels_and_columns_are_numbered_through() {
        assert!(LOG_CHANNELS.iter().all(|entry| std::ptr::eq(entry.id.entry(), entry)));
        let names: Vec<&str> = LOG_CHANNELS.iter().flat_map(|c| c.columns).copied().collect();
        assert_eq!(names, (0..COUNT).map(column_name).collect::<Vec<_>>());
    }
}
