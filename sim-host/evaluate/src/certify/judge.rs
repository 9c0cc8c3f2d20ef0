//! Requirements, judged: what the runs came to, against what was asked for, with the reason where
//! it fell short.

use super::faults;
use super::reason::{self, Reason, Shortfall};
use super::{
    FAULT_FIGURES, FaultTrial, MostMissed, RARE_FIGURE, RareFailure, Trial, WorstCase, within,
};
use crate::Rate;
use crate::figure::{Limit, share_of_limit};
use crate::margins::{Condition, MARGIN_FIGURES, Margins};
use crate::requirements::{Faults, Requirements};
use crate::weld::DriveLoad;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_core::JOINTS;
use trueweld_plant::{named, serialize_as_text};

named! {
    /// Which runs a requirement is judged by.
    pub enum EvidenceKind {
        /// The cell as it is believed to be.
        Nominal = "nominal",
        /// Cells drawn from the uncertainties.
        Draws = "draws",
        /// Cells that are followed from the worst draws to where a weld fails.
        Rare = "rare",
        /// The worst cell that was found within the uncertainties.
        WorstCase = "worst-case",
        /// Margins of the loop along the weld.
        Margins = "margins",
        /// Instruments that fail.
        Faults = "faults",
    }
}

serialize_as_text!(EvidenceKind::name, Verdict::name);

named! {
    /// What the runs say of a requirement, the better first.
    #[derive(PartialOrd, Ord, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Verdict {
        /// It is met, with the confidence asked for.
        Pass = "pass",
        /// Neither that it is met nor that it is not: there are too few runs.
        NotShown = "not-shown",
        /// It is not met, with the confidence asked for.
        Fail = "fail",
    }
}

impl Verdict {
    /// Of several requirements together: the worst. Nothing is shown where nothing is required.
    pub fn of<'a>(requirements: impl IntoIterator<Item = &'a Requirement>) -> Self {
        requirements.into_iter().map(|r| r.verdict).max().unwrap_or(Self::NotShown)
    }

    /// Of a probability between two bounds, each of the confidence asked for, against what is
    /// allowed.
    fn of_probability(at_most: f64, at_least: f64, allowed: f64) -> Self {
        // Bounds are exact to their last digits.
        if within(at_most, allowed) {
            Self::Pass
        } else if at_least > allowed {
            Self::Fail
        } else {
            Self::NotShown
        }
    }

    /// Of a figure against its limit; `None` where no run gave one.
    fn of_figure(within: Option<bool>) -> Self {
        match within {
            Some(true) => Self::Pass,
            Some(false) => Self::Fail,
            None => Self::NotShown,
        }
    }
}

/// Everything that was run of one weld.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// The cell as it is believed to be.
    pub nominal: Trial,
    /// The Monte Carlo, in its order.
    pub trials: Vec<Trial>,
    /// The probability of rare failures; `None` where it was not asked for.
    pub rare: Option<RareFailure>,
    /// What the search for the worst cell found.
    pub worst: WorstCase,
    /// Margins along the weld; empty where none were asked for.
    pub margins: Vec<Margins>,
    /// The fault cases; empty where none were asked for.
    pub faults: Vec<FaultTrial>,
}

/// How many of the draws were beyond a limit, and what that shows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Beyond {
    /// Draws beyond the limit.
    #[schemars(with = "Option<usize>")]
    pub beyond: usize,
    // With the confidence asked for.
    /// Largest probability of a weld beyond the limit that the draws leave open.
    #[schemars(with = "Option<f64>")]
    pub failure_probability: f64,
}

/// One requirement, judged.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Requirement {
    /// Which runs it is judged by: `nominal`, `draws`, `rare`, `worst-case`, `margins` or `faults`.
    pub case: EvidenceKind,
    // One of [`WELD_FIGURES`](crate::WELD_FIGURES), [`MARGIN_FIGURES`] or [`FAULT_FIGURES`].
    /// Key of the figure.
    pub name: &'static str,
    /// The most that is allowed, of margins the least, in the unit of the key.
    pub limit: f64,
    /// What was reached; of draws what all but the allowed share stay within.
    #[schemars(with = "Option<f64>")]
    pub achieved: f64,
    // Of draws that asked for; of runs that come out the same every time, 1.
    /// Confidence with which it is shown.
    pub confidence: f64,
    /// Of draws, and of rare failures.
    #[serde(flatten)]
    pub draws: Option<Beyond>,
    /// `pass`, `not-shown` or `fail`.
    pub verdict: Verdict,
    /// Why it is not met or not shown; `None` where it is met.
    #[serde(skip)]
    pub reason: Option<Reason>,
}

impl Requirement {
    /// True where it is on all limits together.
    pub fn is_joint(&self) -> bool {
        self.name == RARE_FIGURE.key
    }
}

/// The figure of a drawn cell that a requirement is on, one of those that were `judged`.
pub fn drawn_figure(judged: &[Requirement], of: &Requirement, trial: &Trial) -> f64 {
    if !of.is_joint() {
        return trial.figure(of.name);
    }
    let each = judged.iter().filter(|r| r.case == EvidenceKind::Draws && !r.is_joint());
    share_of_limits(each.map(|r| (r.name, r.limit)), trial)
}

/// The largest share of any limit; 0 where there is none.
fn share_of_limits(limits: impl Iterator<Item = (&'static str, f64)>, trial: &Trial) -> f64 {
    limits.map(|(key, limit)| share_of_limit(trial.figure(key), 0.0, limit)).fold(0.0, f64::max)
}

/// Judges everything that was run of a weld, section by section. Nothing passes without runs enough
/// to show it, and nothing fails that more runs may show yet.
pub fn judge(requirements: &Requirements, evidence: &Evidence) -> Vec<Requirement> {
    let mut judged = nominal(requirements, &evidence.nominal);
    judged.extend(draws(requirements, &evidence.trials));
    judged.extend(evidence.rare.as_ref().map(|found| rare(requirements.confidence, found)));
    judged.extend(worst_case(requirements, evidence));
    judged.extend(margins(requirements, &evidence.margins));
    judged.extend(fault_cases(requirements, &evidence.faults));
    judged
}

/// The one with the greatest figure; the first of equal ones.
pub fn worst<T>(all: impl IntoIterator<Item = T>, figure: impl Fn(&T) -> f64) -> Option<T> {
    all.into_iter().reduce(|a, b| if figure(&b) > figure(&a) { b } else { a })
}

/// A requirement on the worst figure of runs that come out the same every time; `None` where there
/// was no run.
fn certain(
    case: EvidenceKind,
    name: &'static str,
    limit: f64,
    worst: Option<f64>,
    why: impl FnOnce() -> Reason,
) -> Requirement {
    let verdict = Verdict::of_figure(worst.map(|figure| within(figure, limit)));
    Requirement {
        case,
        name,
        limit,
        achieved: worst.unwrap_or(f64::INFINITY),
        confidence: 1.0,
        draws: None,
        verdict,
        reason: (verdict != Verdict::Pass).then(why),
    }
}

fn nominal(requirements: &Requirements, trial: &Trial) -> Vec<Requirement> {
    let judged = requirements.limits.iter().map(|Limit { figure, value }| {
        let (name, limit) = (figure.key, *value);
        certain(EvidenceKind::Nominal, name, limit, Some(trial.figure(name)), || {
            Reason::Run(Shortfall::of(name, trial))
        })
    });
    judged.collect()
}

/// Judges drawn cells alone: each limit by itself, and where there are several all of them together.
/// A weld that misses one limit has failed, whichever it is.
pub fn draws(requirements: &Requirements, trials: &[Trial]) -> Vec<Requirement> {
    let limits = || requirements.limits.iter().map(|limit| (limit.figure.key, limit.value));
    let alone = limits().map(|(name, limit)| {
        of_draws(requirements, trials, (name, limit), |trial| trial.figure(name), None)
    });
    let joint = (requirements.limits.len() > 1).then(|| {
        let (asked, most) = ((RARE_FIGURE.key, 1.0), MostMissed::of(limits(), trials));
        of_draws(requirements, trials, asked, |trial| share_of_limits(limits(), trial), most)
    });
    alone.chain(joint).collect()
}

fn of_draws(
    requirements: &Requirements,
    trials: &[Trial],
    (name, limit): (&'static str, f64),
    figure: impl Fn(&Trial) -> f64,
    most: Option<MostMissed>,
) -> Requirement {
    let (allowed, confidence) = (requirements.failure_probability, requirements.confidence);
    let beyond = Rate::of(trials, |t| !within(figure(t), limit));
    let mut sorted: Vec<f64> = trials.iter().map(&figure).collect();
    sorted.sort_by(f64::total_cmp);
    let within = ((1.0 - allowed) * sorted.len() as f64).ceil() as usize;
    let achieved = sorted.get(within.saturating_sub(1)).copied().unwrap_or(f64::INFINITY);
    let bound = beyond.at_most(confidence);
    let at_least = beyond.at_least(confidence);
    let verdict = Verdict::of_probability(bound, at_least, allowed);
    let why = || {
        // Of drives the one that is at a limit for longest: a torque that is cut off is the same in all.
        let largest = sorted.last().copied();
        let as_bad = trials.iter().filter(|t| Some(figure(t)) == largest);
        let worst = worst(as_bad, |t| t.figure("at_limit_s")).map(|trial| (trial, figure(trial)));
        reason::draws(name, beyond, allowed, confidence, worst, most)
    };
    Requirement {
        case: EvidenceKind::Draws,
        name,
        limit,
        achieved,
        confidence,
        draws: Some(Beyond { beyond: beyond.hits, failure_probability: bound }),
        verdict,
        reason: (verdict != Verdict::Pass).then(why),
    }
}

fn rare(confidence: f64, found: &RareFailure) -> Requirement {
    let bound = found.subset.at_most(confidence);
    let at_least = found.subset.at_least(confidence);
    let verdict = Verdict::of_probability(bound, at_least, found.allowed);
    let last = found.subset.levels.last();
    let beyond = last.map_or(0, |level| (level.share * level.cells as f64).round() as usize);
    Requirement {
        case: EvidenceKind::Rare,
        name: RARE_FIGURE.key,
        limit: 1.0,
        achieved: found.subset.quantile(found.allowed),
        confidence,
        draws: Some(Beyond {
            beyond: if found.subset.reached { beyond } else { 0 },
            failure_probability: bound,
        }),
        verdict,
        reason: (verdict != Verdict::Pass).then_some(Reason::Rare {
            allowed: found.allowed,
            probability: found.subset.probability,
            reached: found.subset.reached,
        }),
    }
}

/// Every run counts; that nothing is worse only a search can say.
fn worst_case(requirements: &Requirements, evidence: &Evidence) -> Vec<Requirement> {
    let searched = !evidence.worst.runs.is_empty();
    let judged = requirements.worst_case.iter().map(|Limit { figure, value }| {
        let (name, limit) = (figure.key, *value);
        let known = std::iter::once(&evidence.nominal).chain(&evidence.trials);
        let worst = worst(known.chain(&evidence.worst.runs), |t| t.figure(name));
        let figure = worst.map(|trial| trial.figure(name));
        let judged = certain(EvidenceKind::WorstCase, name, limit, figure, || {
            worst.map_or(Reason::NoRun, |trial| Reason::Run(Shortfall::of(name, trial)))
        });
        match judged.verdict {
            Verdict::Pass if !searched => {
                Requirement { verdict: Verdict::NotShown, reason: Some(Reason::NoRun), ..judged }
            }
            _ => judged,
        }
    });
    judged.collect()
}

fn margins(requirements: &Requirements, map: &[Margins]) -> Vec<Requirement> {
    let Some(asked) = &requirements.margins else {
        return Vec::new();
    };
    asked.at_least.iter().map(|limit| margin(map, limit)).collect()
}

/// The least of a margin over all conditions, with its value and where the loop was opened.
fn least<'a>(map: &'a [Margins], name: &str) -> Option<(&'a Margins, f64, &'static str)> {
    let of = MARGIN_FIGURES.iter().find(|of| of.figure.key == name)?;
    let each = map.iter().map(|margins| {
        let (value, channel) = (of.value)(margins);
        (margins, value, channel)
    });
    worst(each, |(_, value, _)| -value)
}

/// A margin against its limit: the least of all conditions.
fn margin(map: &[Margins], limit: &Limit) -> Requirement {
    let (name, limit) = (limit.figure.key, limit.value);
    let least = least(map, name);
    let achieved = least.map_or(0.0, |(_, value, _)| value);
    let verdict = Verdict::of_figure(least.map(|_| achieved >= limit));
    let why = || match least {
        None => Reason::NoRun,
        Some((Margins { of, held_at_a_limit, spectral_radius, channels: None, .. }, ..)) => {
            Reason::Unstable { of: *of, held: *held_at_a_limit, spectral_radius: *spectral_radius }
        }
        Some((margins, _, channel)) => Reason::Margin { of: margins.of, channel },
    };
    Requirement {
        case: EvidenceKind::Margins,
        name,
        limit,
        achieved,
        confidence: 1.0,
        draws: None,
        verdict,
        reason: (verdict != Verdict::Pass).then(why),
    }
}

/// What margins are customarily asked to be: Åström and Murray, Feedback Systems, 2nd edition,
/// section 10.3 (gain 2 to 5, phase 30° to 60°, stability margin 0.5 to 0.8).
const CUSTOMARY: [(&str, f64); 6] = [
    ("gain_margin", 2.0),
    ("phase_margin_rad", std::f64::consts::FRAC_PI_6),
    ("modulus_margin", 0.5),
    ("drive_gain_margin", 2.0),
    ("drive_phase_margin_rad", std::f64::consts::FRAC_PI_6),
    ("drive_modulus_margin", 0.5),
];

/// A margin that no requirement limits and that is smaller than is customary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeakPoint {
    /// Key of the margin.
    pub name: &'static str,
    /// The least along the weld, SI units.
    pub least: f64,
    /// The least that is customary, SI units.
    pub customary: f64,
    /// The condition that has it.
    pub of: Condition,
    /// Where the loop was opened.
    pub channel: &'static str,
}

/// The weak points of a loop that no requirement forbids, where its margins were determined. A loop
/// that is not stable has no margin at all.
pub fn weak_points(judged: &[Requirement], map: &[Margins]) -> Vec<WeakPoint> {
    let limited = |name| judged.iter().any(|r| r.case == EvidenceKind::Margins && r.name == name);
    let free = CUSTOMARY.iter().filter(|(name, _)| !limited(*name));
    free.filter_map(|&(name, customary)| {
        let (at, least, channel) = least(map, name)?;
        let weak = at.channels.is_some() && least < customary;
        weak.then_some(WeakPoint { name, least, customary, of: at.of, channel })
    })
    .collect()
}

/// What one drive gave in the steady part.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "DriveEvidence", deny_unknown_fields)]
pub struct DriveUse {
    /// Which, as in `A1`.
    pub drive: String,
    /// In the cell as it is believed to be.
    pub nominal: DriveLoad,
    /// The most in any drawn cell, number by number.
    pub drawn: DriveLoad,
    /// Drawn cells in which it stood at a limit of torque or speed.
    pub cells_at_limit: usize,
}

impl DriveUse {
    /// Of the drives A1 to A6, over the welds that were made.
    pub fn all(evidence: &Evidence) -> [Self; JOINTS] {
        let loads = |trial: &Trial| trial.symptoms.map_or(Default::default(), |s| s.drives);
        let nominal: [DriveLoad; JOINTS] = loads(&evidence.nominal);
        std::array::from_fn(|joint| {
            let drawn = || evidence.trials.iter().map(|trial| loads(trial)[joint]);
            let at_limit = |one: &DriveLoad| one.at_torque_limit > 0.0 || one.at_speed_limit > 0.0;
            Self {
                drive: format!("A{}", joint + 1),
                nominal: nominal[joint],
                drawn: drawn().fold(DriveLoad::default(), |most, one| most.most(&one)),
                cells_at_limit: drawn().filter(at_limit).count(),
            }
        })
    }
}

fn fault_cases(requirements: &Requirements, trials: &[FaultTrial]) -> Vec<Requirement> {
    let Some(asked) = &requirements.faults else {
        return Vec::new();
    };
    let judged = FAULT_FIGURES.iter().filter_map(|figure| {
        let name = figure.figure.key;
        let is_required = |trial: &&FaultTrial| asked.not_required(&trial.name, name).is_none();
        let required: Vec<&FaultTrial> = trials.iter().filter(is_required).collect();
        // What is required of no fault is no requirement; where none was tried, it is not shown.
        let is_asked = trials.is_empty() || !required.is_empty();
        is_asked.then(|| of_faults(requirements, asked, &required, name)).flatten()
    });
    judged.collect()
}

/// A figure of faults against its limit; `None` where nothing limits it.
fn of_faults(
    requirements: &Requirements,
    asked: &Faults,
    trials: &[&FaultTrial],
    name: &'static str,
) -> Option<Requirement> {
    let limit = faults::limit(name, requirements, asked)?;
    let worst = worst(trials.iter().copied(), |trial| trial.figure(name));
    let why = || {
        worst.map_or(Reason::NoRun, |trial| Reason::Fault {
            trial: Box::new(trial.clone()),
            recovery: asked.recovery,
            beyond: Rate::of(trials, |trial| !within(trial.figure(name), limit)),
        })
    };
    let figure = worst.map(|trial| trial.figure(name));
    Some(certain(EvidenceKind::Faults, name, limit, figure, why))
}

/// A figure of a fault that is not required, as it would be judged if it were.
#[derive(Debug, Clone, PartialEq)]
pub struct AcceptedFault {
    /// Name of the fault.
    pub fault: String,
    /// The figure.
    pub judged: Requirement,
    /// Why it is not required.
    pub reason: String,
}

/// What is not required of the faults that were tried.
pub fn accepted_faults(requirements: &Requirements, trials: &[FaultTrial]) -> Vec<AcceptedFault> {
    let Some(asked) = &requirements.faults else {
        return Vec::new();
    };
    let accepted = asked.not_required.iter().flat_map(|of| {
        let of_it: Vec<&FaultTrial> = trials.iter().filter(|t| t.name == of.fault).collect();
        let judged = of.figures.iter().filter(|_| !of_it.is_empty()).filter_map(|name| {
            let judged = of_faults(requirements, asked, &of_it, name)?;
            Some(AcceptedFault { fault: of.fault.clone(), judged, reason: of.reason.clone() })
        });
        judged.collect::<Vec<_>>()
    });
    accepted.collect()
}
