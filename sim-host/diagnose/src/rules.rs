//! Rules of decision beside the evidence. Their numbers come from the corpus in `tests/`, but for
//! `TOO_FAR` and `COMMAND_HOLD_SHARE`: those were set with recorded campaigns in view, and then held
//! against the corpus.

use std::borrow::Cow;
use std::collections::BTreeMap;
use trueweld_estimate::AUTOCORRELATION_INFLATION;
use trueweld_estimate::fit::{self, BLOCKS, FitProblem, Fitted, Residuals};
use trueweld_estimate::predict::{Compared, ComparedQuantity, Prediction};
use trueweld_estimate::residuals::finding::NOISE_FLOOR_SCORE;

/// Evidence from which on an explanation counts, nats: a hundred to one, which is called decisive
/// (Jeffreys 1961; Kass and Raftery 1995).
pub const DECISIVE: f64 = 4.605;
/// The same as a difference of sums of squares, in what chance makes of a residual.
pub const DECISIVE_FALL: f64 = 2.0 * DECISIVE;
/// Probability from which on something is named: a wrong name costs nine times what "unknown" does.
pub(crate) const NAMED: f64 = 0.9;
/// Probability at most of all explanations together where what they leave says that none is right.
pub(crate) const UNNAMED_PROBABILITY_MAX: f64 = 0.5;
/// Fall of the held-out sum of squares that chance does not reach among some hundred hypotheses.
pub const GAIN: f64 = 30.0;
/// Least share of what is above the floor that an effect must explain.
pub const EXPLAINED_SHARE_MIN: f64 = 0.1;
/// Share of what stood out of the floor that an explanation may leave.
pub const REMAINING_SHARE_MAX: f64 = 0.04;
/// Share of what one effect leaves standing out of the floor that a second one may leave.
pub(crate) const HALVED: f64 = 0.5;
/// Score from which on an explanation leaves too much, whatever it explains.
pub(crate) const TOO_FAR: f64 = 2.0;
/// Score of any channel from which on something is above the floor.
pub(crate) const SURELY_ABOVE: f64 = 1.3;
/// Standard deviations of what was expected of a calibration beyond which it is none.
pub const GROSS_CALIBRATION_DEVIATIONS: f64 = 5.0;
/// Delay of motor torque that is no more than how a controller holds its commands, as a share of
/// the sampling period.
pub const COMMAND_HOLD_SHARE: f64 = 0.25;
/// Least probability of an explanation that is named; with less there are too many others.
pub(crate) const LEAST_LIKELY: f64 = 0.125;
/// Turns of a wave that logs must hold for it to be one.
pub(crate) const WHOLE_TURN: f64 = 1.0;
/// Share of what the best start promises from which on another one is fitted roughly: half of what is
/// asked of those fitted in full, for shapes still move.
pub(crate) const WORTH_STEPS_GAIN: f64 = 0.5 * NEAR_BEST_GAIN;
/// Share of what the best hypothesis gains from which on another one is fitted in full.
pub(crate) const NEAR_BEST_GAIN: f64 = 0.3;
/// Share of what the best fit wins that another one's slopes must promise for it to go on.
pub(crate) const PROMISED_WIN_SHARE: f64 = 0.5;
/// Hypotheses fitted, first alone and then beside the best.
pub(crate) const FITTED_HYPOTHESES: usize = 8;
/// Of these, how many beside the best.
pub(crate) const FITTED_BESIDE: usize = 5;

/// Single effects at most that an explanation of several is looked for from.
pub const STARTING_EFFECTS: usize = 3;

/// Score of residuals: root mean square.
pub fn score(residuals: &Residuals) -> f64 {
    (fit::chi_square(residuals) / fit::count(residuals).max(1) as f64).sqrt()
}

/// Score on blocks in time, each predicted from all the others.
pub fn held_out_score(fitted: &Fitted) -> f64 {
    let squares = fitted.held_out();
    (squares / fit::count(&fitted.residuals).max(1) as f64).sqrt()
}

/// What differences of a fit's sum of squares are to be trusted by: what chance makes of them, where
/// residuals follow each other and are what the fit leaves.
pub(crate) fn variance_inflation(fitted: &Fitted) -> f64 {
    (fit::chi_square(&fitted.residuals) / fit::count(&fitted.residuals).max(1) as f64).max(1.0)
        * AUTOCORRELATION_INFLATION
}

/// Sum of squares and number of the residuals of one channel in one log.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SquareSum {
    /// Sum of squares.
    pub square: f64,
    /// Number.
    pub count: usize,
}

impl SquareSum {
    fn add(&mut self, other: &Self) {
        self.square += other.square;
        self.count += other.count;
    }
}

/// Fall of the sum of squares that values of a calibration must bring to be kept: a hundred to one, the
/// logarithm of how many calibrations there are to choose from, and for each value half of that of how
/// many residuals count as independent ones (Schwarz 1978), twice, as sums of squares are twice a logarithm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CalibrationPrice {
    of_choice: f64,
    of_value: f64,
}

impl CalibrationPrice {
    /// By a fit with all of so many calibrations to choose from.
    pub(crate) fn new(fitted: &Fitted, choices: usize) -> Self {
        let inflation = variance_inflation(fitted);
        let independent = fit::count(&fitted.residuals) as f64 / AUTOCORRELATION_INFLATION;
        Self {
            of_choice: inflation * (DECISIVE_FALL + 2.0 * (choices.max(1) as f64).ln()),
            of_value: inflation * independent.max(1.0).ln(),
        }
    }

    /// Of so many values of one calibration.
    pub(crate) fn of(self, values: usize) -> f64 {
        self.of_choice + values as f64 * self.of_value
    }
}

/// Sums of squares by log and whatever else `key` tells values apart by.
fn sums<'r, K: Ord>(
    problem: &FitProblem,
    residuals: impl Iterator<Item = Cow<'r, [f64]>>,
    key: impl Fn(usize, &Compared) -> K,
) -> BTreeMap<K, SquareSum> {
    let mut sums: BTreeMap<K, SquareSum> = BTreeMap::new();
    for (log, (experiment, residual)) in problem.logs.iter().zip(residuals).enumerate() {
        for (c, r) in experiment.compared.iter().zip(residual.iter()) {
            let part = sums.entry(key(log, c)).or_default();
            part.add(&SquareSum { square: r * r, count: 1 });
        }
    }
    sums
}

/// What each value of a log counts for as evidence: of n values that are off alike by a share ρ of
/// their variance, each counts for 1/(1 + (n − 1) ρ) (Kish's design effect). What is off by less than
/// anybody asks about is off alike within a block of time.
pub fn evidence_weights(compared: &[Compared]) -> Vec<f64> {
    let mut columns: BTreeMap<(ComparedQuantity, u8), (f64, f64, f64)> = BTreeMap::new();
    for c in compared {
        let column = columns.entry((c.quantity, c.component)).or_default();
        let allowed = (c.accuracy / c.deviation).powi(2);
        *column = (column.0 + 1.0, column.1 + c.alike, column.2 + allowed);
    }
    let weight = |c: &Compared| {
        let (count, alike, allowed) = columns[&(c.quantity, c.component)];
        let of_block = (count / BLOCKS as f64).max(1.0);
        (1.0 + ((count - 1.0) * alike + (of_block - 1.0) * allowed) / count).recip()
    };
    compared.iter().map(weight).collect()
}

/// Sums of squares by log and channel.
pub fn parts(
    problem: &FitProblem,
    residuals: &Residuals,
) -> BTreeMap<(usize, &'static str), SquareSum> {
    let as_weighed = residuals.iter().map(|at| Cow::from(&at.residual));
    sums(problem, as_weighed, |log, c| (log, c.quantity.channel()))
}

/// Sums of squares by log and column in the noise that is under the model; the spindle's orders apart from
/// what is slow.
fn columns(
    problem: &FitProblem,
    residuals: &Residuals,
) -> BTreeMap<(usize, &'static str, u8, bool), SquareSum> {
    let in_own_noise = residuals.iter().map(Prediction::in_own_noise);
    sums(problem, in_own_noise, |log, c| {
        (
            log,
            c.quantity.channel(),
            c.component,
            matches!(c.quantity, ComparedQuantity::Ripple { .. }),
        )
    })
}

/// Fall of the sum of squares from one model to another that is no evidence: links that are put where
/// they were seen are put there noise and all, and a clock that is moved was not expected there.
pub(crate) fn prior_penalty(before: &Residuals, after: &Residuals) -> f64 {
    let not_evidence = |at: &Residuals| at.iter().map(|p| p.not_evidence).sum::<f64>();
    not_evidence(after) - not_evidence(before)
}

/// Sum of squares that noise may make, as far as it is known.
pub(crate) fn noise_chi_square(problem: &FitProblem) -> f64 {
    let all = problem.logs.iter().flat_map(|e| &e.compared);
    all.map(|c| if c.stated { 1.0 } else { NOISE_FLOOR_SCORE.powi(2) }).sum()
}

/// Sum of squares in the noise that is under the model.
pub(crate) fn chi_square_in_own_noise(residuals: &Residuals) -> f64 {
    let squares = |at: &Prediction| at.in_own_noise().iter().map(|r| r * r).sum::<f64>();
    residuals.iter().map(squares).sum()
}

/// The same above the floor.
pub(crate) fn excess_chi_square(problem: &FitProblem, residuals: &Residuals) -> f64 {
    (chi_square_in_own_noise(residuals) - noise_chi_square(problem)).max(0.0)
}

/// True where no column of any log stands out of the floor.
pub(crate) fn within_noise(problem: &FitProblem, residuals: &Residuals) -> bool {
    noise_excess(problem, residuals) == 0.0
}

/// Sum of squares of the columns that stand out of the floor, above it.
pub(crate) fn noise_excess(problem: &FitProblem, residuals: &Residuals) -> f64 {
    let above = |p: &SquareSum| {
        let count = p.count as f64;
        (p.square - count * (SURELY_ABOVE.powi(2) + 6.0 * (2.0 / count).sqrt())).max(0.0)
    };
    columns(problem, residuals).values().map(above).sum()
}
