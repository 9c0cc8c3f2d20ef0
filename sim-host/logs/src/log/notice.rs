//! What a reader should know of a log although nothing is wrong with it.

use crate::channel::LogChannel;
use crate::kind::LogKind;
use nalgebra::Vector3;

/// A factor of a motor torque, where no file states it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundFactor {
    /// The column.
    pub column: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Torque of one unit, N·m.
    pub factor: f64,
    /// 95 % half-width by what the model's masses and friction need, N·m; `None` where the model
    /// states the factor.
    pub interval: Option<f64>,
}

/// What was noticed when a log was read.
#[derive(Debug, Clone, PartialEq)]
pub enum LogNotice {
    /// Columns with these headers are not known and left out.
    UnknownColumns(Vec<String>),
    /// These columns belong to static-load logs only and are left out.
    StaticLoadColumns {
        /// Their names.
        columns: Vec<&'static str>,
        /// Kind of this log.
        kind: LogKind,
    },
    /// These columns have no value in any row and are read as absent.
    EmptyColumns(Vec<&'static str>),
    /// Of a weld's force these columns alone were measured.
    ForceInPart(Vec<&'static str>),
    /// A clock was fitted to the motion that both instruments saw.
    ClockFitted {
        /// Its name.
        clock: String,
        /// Offset, s.
        offset: f64,
        /// Drift, s/s.
        drift: f64,
        /// What is left between the two motions, m, where it is strangely much.
        left: Option<f64>,
    },
    /// Reflectors were placed in the tool frame as the encoders' motion tells: number from 1, and
    /// place in T, m.
    ReflectorsPlaced(Vec<(usize, Vector3<f64>)>),
    /// An instrument is read less often than rows are written, and holds its reading until the next.
    Held {
        /// Its columns.
        columns: Vec<&'static str>,
        /// Rows that a reading stands for, on average.
        every: f64,
    },
    /// Motor torques in a unit whose factor is not stated, read with a factor that was found.
    FactorsFound(Vec<FoundFactor>),
    /// A motor torque in a unit whose factor is not stated, and does not show: left out.
    FactorUnknown {
        /// The column.
        column: &'static str,
        /// Its unit.
        unit: &'static str,
    },
    /// A motor torque in a unit whose factor is not stated, of a joint whose torque another log has in
    /// another such unit: a model has one factor, so it is left out.
    FactorOfAnotherUnit {
        /// The column.
        column: &'static str,
        /// Its unit.
        unit: &'static str,
        /// The other log's.
        other: &'static str,
    },
    /// Rows were thinned to a longer period; nothing faster is compared, and the noise is that of
    /// the thinned rows.
    Thinned {
        /// Number of rows before.
        rows: usize,
        /// Period before, s.
        from: f64,
        /// Period after, s.
        to: f64,
    },
    /// Rows whose times are uneven were brought to an even grid of this period, s.
    Resampled(f64),
    /// So many rows at rest lack an encoder and are left out.
    RowsLeftOut(usize),
    /// So many rows hold the time and the values of the row before, and are left out.
    RowsRepeated(usize),
    /// So many rows came after the one that they precede by their time, and changed places with it.
    RowsSwapped(usize),
    /// Rows that came in bursts, so many at a time, whose times are spread evenly.
    Bursts {
        /// Rows in a burst.
        rows: usize,
    },
    /// A number that stands for a value that was not measured, and is read as missing.
    Sentinel {
        /// The column.
        column: &'static str,
        /// The number, as it is written.
        value: f64,
        /// Number of rows.
        rows: usize,
    },
    /// So many rows without encoders are interpolated.
    RowsInterpolated(usize),
    /// Stretches without encoders cut the log or its ends.
    Cut {
        /// What is missing: the column's name, or none for the encoders.
        column: Option<&'static str>,
        /// The first of the stretches: begin and end, s from the log's first row.
        gaps: Vec<[f64; 2]>,
        /// Number of pieces left.
        pieces: usize,
    },
    /// Instruments that read nothing for a while, in which nothing of them is compared.
    Dropout {
        /// Their columns.
        columns: Vec<&'static str>,
        /// The first of the stretches: begin and end, s from the log's first row.
        stretches: Vec<[f64; 2]>,
    },
    /// A column that reads the limit of its instrument now and then, where nothing of it is compared.
    Clipped {
        /// The column.
        column: &'static str,
        /// The limit, in the unit.
        limit: f64,
        /// Unit.
        unit: &'static str,
        /// Number of rows at the limit.
        rows: usize,
    },
    /// Single readings that stand out of their neighbours on both sides.
    Outliers {
        /// Their columns.
        columns: Vec<&'static str>,
        /// Number of rows.
        rows: usize,
        /// By how much the worst stands out, in the unit.
        largest: f64,
        /// Unit.
        unit: &'static str,
        /// True where they are not compared; false where there are too many of them.
        left_out: bool,
    },
    /// Loads at rest that the other loads contradict in this channel: not compared.
    OutlyingLoads {
        /// The channel.
        channel: LogChannel,
        /// Rows of the samples, from 1.
        rows: Vec<usize>,
        /// By how much the worst is off the median of its posture, or of the log, in the channel's unit.
        largest: f64,
    },
    /// Forces of a weld that are not compared: rows are so far apart that a line of the spindle shows as a
    /// slow force.
    Folded {
        /// Order of the ripple.
        order: f64,
        /// What the rows show it at, Hz.
        frequency: f64,
        /// Period of the rows, s.
        period: f64,
    },
    /// Another log of the same campaign has nothing to compare.
    LeftOut {
        /// Its name.
        log: String,
        /// What is missing.
        what: &'static str,
    },
}
