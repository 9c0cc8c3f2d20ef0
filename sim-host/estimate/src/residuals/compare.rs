//! How far a model is from measurements: every residual over its noise, by log and channel, and
//! where it is largest.
//!
//! The score √mean((residual/noise)²) is 1.0 where the model is as good as the instruments can
//! tell. Left out: what is missing in the model, which is for a diagnosis to say.

pub use crate::predict::baseline;
pub use crate::residuals::finding::NOISE_FLOOR_SCORE;

use crate::fit::per_log;
use crate::fit::{FitProblem, FitState, PerLogEffect};
use crate::log_faults::{Found, Registered};
use crate::predict::{
    BaselineModel, Compared, ComparedQuantity, Folded, PredictError, Prediction, PreparedLog,
};
use crate::residuals::finding::{Finding, column_label};
use crate::residuals::localize::localize;
use rayon::prelude::*;
use std::path::PathBuf;
use trueweld_logs::log::{Log, LogKind, LogNotice};
use trueweld_logs::noise::{Scatter, instruments, scatters};
use trueweld_plant::effects::Effect;
use trueweld_plant::input::{ModelFile, RobotFile};

/// A model against measurements.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// √mean((residual/noise)²) over all compared samples; 1.0 is the noise floor.
    pub score: f64,
    /// Number of compared samples.
    pub samples: usize,
    /// Every log, in the order given.
    pub logs: Vec<LogComparison>,
    /// Where the residual concentrates, worst first.
    pub worst: Vec<Finding>,
    /// What a person should know although nothing is wrong.
    pub notices: Vec<Notice>,
}

/// What a person should know of a comparison although nothing is wrong.
#[derive(Debug, Clone)]
pub enum Notice {
    /// What was noticed when a log was read.
    Log {
        /// The log's name.
        log: String,
        /// The notice.
        notice: LogNotice,
    },
    /// A tracker that stood elsewhere was registered.
    Registered(Box<Registered>),
    /// The noise is not stated in these logs and was estimated from the recordings.
    NoiseEstimated(Vec<String>),
    /// Readings scatter from row to row by more than the noise that the logs state, which is taken for
    /// their noise.
    NoiseLarger(Scatter),
    /// Readings scatter by less than the noise that the logs state, and so does what is left of them.
    NoiseSmaller(Scatter),
    /// One load of a log at rest makes most of what is left of it.
    SingleLoad {
        /// The log's name.
        log: String,
        /// Row of the samples, from 1.
        row: usize,
        /// Its time, s.
        time: f64,
        /// Share of the log's squared residual.
        share: f64,
    },
    /// A log begins with gears in the midst of their loops.
    GearsAtStart {
        /// The log's name.
        log: String,
        /// The joints of these gears, by name, with their state from -1 to 1.
        gears: Vec<(String, f64)>,
    },
    /// A tracker's clock that is not given is another one under this model.
    ClockSettled {
        /// The log's name.
        log: String,
        /// By how much the tracker is later, s, in the middle of the log.
        late: f64,
    },
    /// An effect of `scope = "log"` was fitted to the logs compared.
    PerLog {
        /// The effect with where it acts: `backlash at A5`.
        name: String,
        /// The effect with its values in each log, by the log's name.
        found: Vec<(String, Effect)>,
    },
    /// Values of an improved model that its logs do not bound: `[posterior]` does not hold them.
    NotBounded(Vec<String>),
    /// Why an improved model was written without `[posterior]`.
    NoPosterior(String),
}

impl Found {
    /// What to tell of trackers that were registered.
    pub fn notices(&self) -> impl Iterator<Item = Notice> {
        self.registered.iter().map(|found| Notice::Registered(Box::new(found.clone())))
    }
}

/// A model against one log.
#[derive(Debug, Clone)]
pub struct LogComparison {
    /// The log's folder.
    pub path: PathBuf,
    /// Its name.
    pub name: String,
    /// What was done.
    pub kind: LogKind,
    /// As [`Comparison::score`], of this log.
    pub score: f64,
    /// Number of compared samples.
    pub samples: usize,
    /// Every channel that is compared.
    pub channels: Vec<ChannelComparison>,
    /// Measured and predicted over time, a column a trace.
    pub traces: Vec<Trace>,
    /// The same of the force's amplitudes at the spindle's orders, of a stretch of the weld around
    /// each instant: a trace for the cosine and one for the sine, labelled `x-order-2-cosine`.
    pub lines: Vec<Trace>,
}

/// A model against one channel of a log, or against one column of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelComparison {
    /// Its name: `tcp_position`, `tcp_rotation`, `motor_torque`, `link_encoder`, `force` or
    /// `moment`; of a column, with its number from 0: `motor_torque[2]`.
    pub name: String,
    /// What people call a column: x, y, z or the joint's name; empty for a whole channel.
    pub label: String,
    /// Unit of the figures.
    pub unit: &'static str,
    /// Root mean square of measured less predicted, in the unit.
    pub rmse: f64,
    /// Largest magnitude of measured less predicted, in the unit.
    pub max: f64,
    /// Root mean square of the deviation that measured and propagated noise leave in the
    /// difference, in the unit.
    pub noise: f64,
    /// Root mean square of what predictions may be off by, in the unit; 0 where they are to be as
    /// exact as the noise.
    pub accuracy: f64,
    /// True where the logs state all of the instruments' noise; false where some was read off the
    /// recordings.
    pub stated: bool,
    /// As [`Comparison::score`], of this channel.
    pub score: f64,
    /// Number of compared samples.
    pub samples: usize,
    /// The columns of a channel; a column has none.
    pub columns: Vec<ChannelComparison>,
}

/// Measured and predicted values of one column over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// The channel's name.
    pub channel: &'static str,
    /// The column's number, from 0.
    pub column: u8,
    /// x, y, z or the joint's name.
    pub label: String,
    /// Unit of the values.
    pub unit: &'static str,
    /// Time from the log's first row, s.
    pub time: Vec<f64>,
    /// Measured; of `tcp_rotation` the rotation from the predicted to the measured tool.
    pub measured: Vec<f64>,
    /// Predicted; 0 of `tcp_rotation`.
    pub predicted: Vec<f64>,
    /// Standard deviation of the noise in their difference.
    pub deviation: Vec<f64>,
}

/// Makes logs ready to be compared with a model, each with its instruments' noise.
///
/// # Errors
/// [`PredictError`] of the first log that cannot be.
pub fn experiments(logs: &[Log], model: &BaselineModel) -> Result<Vec<PreparedLog>, PredictError> {
    let instruments = instruments(logs);
    (0..logs.len())
        .into_par_iter()
        .map(|k| PreparedLog::new(&logs[k], &instruments[k], model))
        .collect()
}

/// The same, of logs of which some may have nothing to compare, as a short piece of a log that was
/// cut: those are taken out of `logs`, and the notices of the first that stays say so. Notices of a
/// weld say where its forces are left out.
///
/// # Errors
/// As [`experiments`]; [`PredictError::Nothing`] only where no log can be compared.
pub fn of_comparable(
    logs: &mut Vec<Log>,
    model: &BaselineModel,
) -> Result<Vec<PreparedLog>, PredictError> {
    let instruments = instruments(logs);
    let mut made: Vec<Result<PreparedLog, PredictError>> = (0..logs.len())
        .into_par_iter()
        .map(|k| PreparedLog::new(&logs[k], &instruments[k], model))
        .collect();
    if made.iter().any(Result::is_ok) {
        let (mut kept, mut left_out) = (Vec::new(), Vec::new());
        let mut stay = Vec::with_capacity(made.len());
        for (log, made) in logs.drain(..).zip(made) {
            match made {
                Err(PredictError::Nothing { log: name, what }) => {
                    left_out.push((log, LogNotice::LeftOut { log: name, what }));
                }
                made => {
                    kept.push(log);
                    stay.push(made);
                }
            }
        }
        for (log, notice) in left_out {
            // What was given stays part of the result.
            kept[0].files.extend(log.files);
            kept[0].notices.extend(log.notices);
            kept[0].notices.push(notice);
        }
        *logs = kept;
        made = stay;
    }
    for (log, made) in logs.iter_mut().zip(&made) {
        if let Ok(PreparedLog { folded: Some(Folded { order, frequency }), period, .. }) = made {
            let (order, frequency, period) = (*order, *frequency, *period);
            log.notices.push(LogNotice::Folded { order, frequency, period });
        }
    }
    made.into_iter().collect()
}

/// Compares a model with the logs that a problem was made of. What every log has of its own
/// (`scope = "log"`) is fitted to each, and the notices say so. `done` is called with the
/// number of every log that is done, from several threads.
///
/// # Errors
/// [`PredictError`] of the first log that the model cannot be driven through.
pub fn compare(
    model: &ModelFile,
    logs: &[Log],
    problem: &FitProblem,
    done: &(impl Fn(usize) + Sync),
) -> Result<Comparison, PredictError> {
    let point = match problem.per_log.as_slice() {
        [] => FitState::empty(logs.len()),
        own => per_log::fitted(problem, own, Vec::new())?.0,
    };
    let predict = |k: usize| {
        let prediction = problem.logs[k].predict(&problem.model, &point.effects(problem, k), None);
        done(k);
        prediction
    };
    let predictions =
        (0..logs.len()).into_par_iter().map(predict).collect::<Result<Vec<_>, _>>()?;
    let mut comparison = of_predictions(logs, &problem.logs, &predictions);
    comparison.notices.extend(of_each_log(&model.robot, logs, &problem.per_log, &point));
    Ok(comparison)
}

/// Tells of every effect that each log has of its own, with its values in each log at a fit's point.
/// `logs`: those of the fit, in its order; `per_log`: the effects.
pub fn of_each_log(
    robot: &RobotFile,
    logs: &[Log],
    per_log: &[PerLogEffect],
    point: &FitState,
) -> Vec<Notice> {
    let mut notices = Vec::new();
    for own in per_log {
        let of_log = |(log, each): (&Log, &Vec<Effect>)| {
            Some((log.name.clone(), own.whole(each.iter().find(|e| own.is(e))?)))
        };
        let found: Vec<_> = logs.iter().zip(&point.per_log).filter_map(of_log).collect();
        if !found.is_empty() {
            notices.push(Notice::PerLog { name: own.stated.name(robot), found });
        }
    }
    notices
}

/// The comparison that predictions of all logs make.
pub(crate) fn of_predictions(
    logs: &[Log],
    experiments: &[PreparedLog],
    predictions: &[Prediction],
) -> Comparison {
    let compared = of_logs(logs, experiments, predictions);
    let all: Vec<f64> = predictions.iter().flat_map(|p| p.residual.iter().copied()).collect();
    Comparison {
        score: root_mean_square(&all),
        samples: all.len(),
        worst: localize(experiments, predictions, logs),
        notices: notices(logs, &compared, predictions),
        logs: compared,
    }
}

/// The part of a comparison that is of single logs: their channels and traces, without where the
/// residual concentrates.
pub fn of_logs(
    logs: &[Log],
    experiments: &[PreparedLog],
    predictions: &[Prediction],
) -> Vec<LogComparison> {
    (0..logs.len()).map(|k| of_log(&logs[k], &experiments[k], &predictions[k])).collect()
}

/// What was noticed when logs were read.
pub fn of_reading(logs: &[Log]) -> impl Iterator<Item = Notice> {
    logs.iter().flat_map(|log| {
        let of = |notice: &LogNotice| Notice::Log { log: log.name.clone(), notice: notice.clone() };
        log.notices.iter().map(of)
    })
}

/// What a person should know of logs and of their predictions.
pub fn notices(
    logs: &[Log],
    compared: &[LogComparison],
    predictions: &[Prediction],
) -> Vec<Notice> {
    let read = of_reading(logs);
    let larger = scatters(logs, true);
    // What is not stated at all; where more is shown than stated, its own notice tells.
    let told = |log: &LogComparison, channel: &ChannelComparison| {
        let is_told = |s: &Scatter| s.channel.name() == channel.name;
        larger.iter().any(is_told) && states(logs, log, &channel.name)
    };
    let estimated: Vec<String> = compared
        .iter()
        .filter(|log| log.channels.iter().any(|channel| !channel.stated && !told(log, channel)))
        .map(|log| log.name.clone())
        .collect();
    let noise = (!estimated.is_empty()).then_some(Notice::NoiseEstimated(estimated));
    let at_start = logs.iter().zip(predictions).filter_map(|(log, prediction)| {
        let start = prediction.motion.as_ref()?.start.as_ref()?.significant_states();
        let gears = start.iter().map(|g| (log.robot.joint_names[g.joint].clone(), g.state));
        let gears: Vec<(String, f64)> = gears.collect();
        (!gears.is_empty()).then(|| Notice::GearsAtStart { log: log.name.clone(), gears })
    });
    /// Less says nothing, s.
    const CLOCK_SHIFT_MIN: f64 = 2e-5;
    let clocks = logs.iter().zip(predictions).filter_map(|(log, prediction)| {
        let [late, _] = prediction.late?;
        let log = log.name.clone();
        (late.abs() > CLOCK_SHIFT_MIN).then_some(Notice::ClockSettled { log, late })
    });
    // A filter makes readings scatter less as well; then what is left of them is as stated.
    let quiet = |log: &Log| compared.iter().any(|c| c.name == log.name && c.score < QUIET);
    let quiet: Vec<Log> = logs.iter().filter(|log| quiet(log)).cloned().collect();
    let smaller = scatters(&quiet, false).into_iter().map(Notice::NoiseSmaller);
    let larger = larger.into_iter().map(Notice::NoiseLarger);
    read.chain(noise).chain(larger).chain(smaller).chain(at_start).chain(clocks).collect()
}

/// Score of a log below which its noise is smaller than stated: a right model has 1.
const QUIET: f64 = 0.7;

/// True where a log states the noise of a channel.
fn states(logs: &[Log], compared: &LogComparison, channel: &str) -> bool {
    let log = logs.iter().find(|log| log.name == compared.name);
    log.is_some_and(|log| log.noise.states(channel))
}

fn of_log(log: &Log, experiment: &PreparedLog, prediction: &Prediction) -> LogComparison {
    let pairs: Vec<(&Compared, f64)> =
        experiment.compared.iter().zip(prediction.residual.iter().copied()).collect();
    let mut names: Vec<&'static str> = Vec::new();
    for (compared, _) in &pairs {
        let name = compared.quantity.channel();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let channels = names.iter().map(|name| channel(log, name, &pairs)).collect();
    let [traces, lines] = traces(log, &pairs);
    LogComparison {
        path: log.path.clone(),
        name: log.name.clone(),
        kind: log.kind,
        score: root_mean_square(&prediction.residual),
        samples: pairs.len(),
        channels,
        traces,
        lines,
    }
}

fn channel(log: &Log, name: &'static str, pairs: &[(&Compared, f64)]) -> ChannelComparison {
    let of_channel: Vec<(&Compared, f64)> =
        pairs.iter().copied().filter(|(compared, _)| compared.quantity.channel() == name).collect();
    let mut columns: Vec<u8> = of_channel.iter().map(|(compared, _)| compared.component).collect();
    columns.sort_unstable();
    columns.dedup();
    let columns = columns
        .into_iter()
        .map(|column| {
            let own: Vec<_> = of_channel
                .iter()
                .copied()
                .filter(|(compared, _)| compared.component == column)
                .collect();
            let label = column_label(log, own[0].0.quantity, column);
            ChannelComparison { label, ..figures(format!("{name}[{column}]"), &own) }
        })
        .collect();
    ChannelComparison { columns, ..figures(name.to_owned(), &of_channel) }
}

fn figures(name: String, pairs: &[(&Compared, f64)]) -> ChannelComparison {
    let difference = |(compared, residual): &(&Compared, f64)| residual * compared.deviation;
    let differences: Vec<f64> = pairs.iter().map(difference).collect();
    let noise = |(c, _): &(&Compared, f64)| (c.deviation.powi(2) - c.accuracy.powi(2)).sqrt();
    let noise: Vec<f64> = pairs.iter().map(noise).collect();
    let accuracy: Vec<f64> = pairs.iter().map(|(compared, _)| compared.accuracy).collect();
    let residuals: Vec<f64> = pairs.iter().map(|(_, residual)| *residual).collect();
    ChannelComparison {
        name,
        label: String::new(),
        unit: pairs[0].0.quantity.unit(),
        rmse: root_mean_square(&differences),
        max: differences.iter().fold(0.0, |most, d| most.max(d.abs())),
        noise: root_mean_square(&noise),
        accuracy: root_mean_square(&accuracy),
        stated: pairs.iter().all(|(compared, _)| compared.stated),
        score: root_mean_square(&residuals),
        samples: pairs.len(),
        columns: Vec::new(),
    }
}

/// What was compared over time, and the amplitudes at the spindle's orders.
fn traces(log: &Log, pairs: &[(&Compared, f64)]) -> [Vec<Trace>; 2] {
    let mut traces: Vec<(ComparedQuantity, Trace)> = Vec::new();
    let start = log.samples.time.first().copied().unwrap_or(0.0);
    for (compared, residual) in pairs {
        let (quantity, column) = (compared.quantity, compared.component);
        let found = traces.iter().rposition(|(of, t)| *of == quantity && t.column == column);
        let place = found.unwrap_or_else(|| {
            let mut label = column_label(log, quantity, column);
            if let ComparedQuantity::Ripple { order, sine } = quantity {
                label += &format!("-order-{order}-{}", if sine { "sine" } else { "cosine" });
            }
            let trace = Trace {
                channel: quantity.channel(),
                column,
                label,
                unit: quantity.unit(),
                time: Vec::new(),
                measured: Vec::new(),
                predicted: Vec::new(),
                deviation: Vec::new(),
            };
            traces.push((quantity, trace));
            traces.len() - 1
        });
        let difference = residual * compared.deviation;
        let (_, trace) = &mut traces[place];
        trace.time.push(log.samples.time[compared.row] - start);
        // A rotation has no measured value that could be drawn over a predicted one: its difference
        // is drawn over nothing.
        let measured = if compared.quantity == ComparedQuantity::Rotation {
            difference
        } else {
            compared.measured
        };
        trace.measured.push(measured);
        trace.predicted.push(measured - difference);
        trace.deviation.push(compared.deviation);
    }
    let (lines, traces): (Vec<_>, Vec<_>) =
        traces.into_iter().partition(|(of, _)| matches!(of, ComparedQuantity::Ripple { .. }));
    [traces, lines].map(|of| of.into_iter().map(|(_, trace)| trace).collect())
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
