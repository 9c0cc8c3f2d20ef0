//! Why a requirement is not met or not shown: what the runs came to, and what their symptoms show
//! of the loop.
//!
//! Nothing is stated that a recording does not show. Where no symptom stands out, the figure stands
//! alone.

use super::{FaultTrial, OF_DRIVES, Symptoms, Trial, within};
use crate::Rate;
use crate::margins::Condition;
use crate::weld::DriveLoad;

/// Share of what is needed below which a correction goes the wrong way; so much may be chance where
/// little is needed.
const WRONG_WAY: f64 = -0.2;

/// Share of what is needed above which a correction gives too much, where only its authority holds
/// it.
const TOO_MUCH: f64 = 1.1;

/// Share of what is needed below which a correction gives too little.
const TOO_LITTLE: f64 = 0.5;

/// Share of the periods at a limit from which on the limit is named.
const HELD: f64 = 0.05;

/// Correlation of an oscillation with itself one period later above which it is no noise.
const REGULAR: f64 = 0.5;

/// Least amplitude of an oscillation that is named, m: noise of a seam sensor comes through with a
/// tenth of it.
const OSCILLATES: f64 = 1e-4;

/// Why a requirement is not met or not shown.
#[derive(Debug, Clone, PartialEq)]
pub enum Reason {
    /// Nothing was run.
    NoRun,
    /// The nominal run, or that of the worst cell found.
    Run(Shortfall),
    /// So few draws do not show it.
    TooFewDraws {
        /// Draws made.
        of: usize,
        /// So many with no more beyond the limit show it; `None` where 100 000 do not.
        enough: Option<usize>,
        /// So many with as large a share of them beyond show it; `None` where 100 000 do not.
        at_this_rate: Option<usize>,
        /// Of all limits together: the one that most miss.
        most: Option<MostMissed>,
    },
    /// A larger share of the draws than allowed is beyond the limit.
    Draws {
        /// Draws made.
        of: usize,
        /// Share allowed.
        allowed: f64,
        /// So many with as large a share of them beyond show that it is not met; `None` where this is
        /// shown, or 100 000 do not show it.
        decided: Option<usize>,
        /// Index of the worst trial.
        index: u64,
        /// The worst trial.
        worst: Shortfall,
        /// Of all limits together: the one that most miss.
        most: Option<MostMissed>,
    },
    /// Rare failures are more probable than allowed, or the error of their probability is too large.
    Rare {
        /// Probability allowed.
        allowed: f64,
        /// The estimate.
        probability: f64,
        /// Whether cells beyond a limit were found at all.
        reached: bool,
    },
    /// A margin is too small.
    Margin {
        /// Where and of what.
        of: Condition,
        /// Where the loop was opened.
        channel: &'static str,
    },
    /// The loop is not stable.
    Unstable {
        /// Where and of what.
        of: Condition,
        /// Only a limit holds it.
        held: bool,
        /// [`Margins::spectral_radius`](crate::margins::Margins::spectral_radius).
        spectral_radius: f64,
    },
    /// Instruments that fail.
    Fault {
        /// The run with the worst fault.
        trial: Box<FaultTrial>,
        /// Time allowed for the recovery, s.
        recovery: f64,
        /// Fault cases beyond the limit.
        beyond: Rate,
    },
}

/// The limit that most draws miss, of those whose weld was made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MostMissed {
    /// Key of its figure.
    pub name: &'static str,
    /// The limit, SI units.
    pub limit: f64,
    /// Draws beyond it.
    pub beyond: usize,
    /// The largest figure among them, SI units.
    pub worst: f64,
}

/// One run beyond a limit.
#[derive(Debug, Clone, PartialEq)]
pub struct Shortfall {
    /// Its figure, SI units.
    pub value: f64,
    /// Why the weld was not made; `None` where it was.
    pub failed: Option<String>,
    /// What stands out in the loop.
    pub symptom: Option<Symptom>,
    /// What stood at a limit.
    pub held: Option<Held>,
}

/// What stands out in a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Symptom {
    /// The correction goes the wrong way: share given of what is needed.
    WrongWay(f64),
    /// The correction oscillates.
    Oscillates {
        /// Amplitude, m.
        amplitude: f64,
        /// Frequency, Hz.
        frequency: f64,
        /// It grows along the weld.
        grows: bool,
    },
    /// Share given of what is needed, more than all.
    TooMuch(f64),
    /// Share given of what is needed.
    TooLittle(f64),
    /// Most of the lateral deviation left is of one kind.
    Remains {
        /// How fast it changes.
        pace: Pace,
        /// RMS of that part, m.
        part: f64,
        /// RMS of the whole, m.
        whole: f64,
    },
}

/// How fast a deviation changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// Over seconds.
    Slow,
    /// Within seconds, more slowly than the spindle turns.
    Middle,
    /// Within a turn of the spindle.
    Ripple,
}

/// What stood at a limit: share of the periods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Held {
    /// A drive (0 = A1), at its torque.
    Torque(usize, f64),
    /// A drive, at its speed.
    Speed(usize, f64),
    /// The correction, at its authority.
    Authority(f64),
    /// The correction, at a limit of its size or its rate.
    Compensation(f64),
    /// What the force loop adds.
    ForceLoop(f64),
    /// The controller, at fault.
    Fault(f64),
}

impl Held {
    /// A drive or the authority, whichever stood at its limit for longer: a law that swings between
    /// the ends of its authority drives motors to theirs. Of what is asked of the drives themselves a
    /// drive is told however short it was.
    fn of(name: &str, s: &Symptoms) -> Option<Self> {
        let of_drives = OF_DRIVES.contains(&name);
        let least = if of_drives { f64::MIN_POSITIVE } else { HELD.max(s.at_authority) };
        let drives = s.drives.iter().enumerate().flat_map(|(joint, drive)| {
            let DriveLoad { at_torque_limit, at_speed_limit, .. } = *drive;
            [Self::Torque(joint, at_torque_limit), Self::Speed(joint, at_speed_limit)]
        });
        let longest = drives.reduce(|a, b| if b.share() > a.share() { b } else { a });
        let others = [
            Self::Authority(s.at_authority),
            Self::Compensation(s.compensation),
            Self::ForceLoop(s.force_loop),
            Self::Fault(s.fault),
        ];
        let drive = longest.filter(|held| held.share() >= least);
        drive.or(others.into_iter().find(|held| held.share() >= HELD))
    }

    fn share(self) -> f64 {
        match self {
            Self::Torque(_, share)
            | Self::Speed(_, share)
            | Self::Authority(share)
            | Self::Compensation(share)
            | Self::ForceLoop(share)
            | Self::Fault(share) => share,
        }
    }
}

impl MostMissed {
    /// Of figures by their keys, with their limits; `None` where no weld that was made is beyond one.
    /// Of equals the one that is missed farthest.
    pub(super) fn of(
        limits: impl Iterator<Item = (&'static str, f64)>,
        trials: &[Trial],
    ) -> Option<Self> {
        let each = limits.filter_map(|(name, limit)| {
            let figures = trials.iter().map(|trial| trial.figure(name));
            let beyond = figures.filter(|figure| figure.is_finite() && !within(*figure, limit));
            let beyond: Vec<f64> = beyond.collect();
            let worst = beyond.iter().copied().reduce(f64::max)?;
            Some(Self { name, limit, beyond: beyond.len(), worst })
        });
        let order = |one: &Self| (one.beyond, one.worst / one.limit);
        each.reduce(|most, one| if order(&one) > order(&most) { one } else { most })
    }
}

impl Shortfall {
    pub(super) fn of(name: &str, trial: &Trial) -> Self {
        // Symptoms are of the steady part.
        let symptoms = trial.symptoms.as_ref().filter(|_| !name.contains('.'));
        let (symptom, held) =
            symptoms.map_or((None, None), |s| (symptom(name, s), Held::of(name, s)));
        Self { value: trial.figure(name), failed: trial.failed.clone(), symptom, held }
    }
}

/// Of draws: too many beyond the limit, or too few to show that there are few enough.
pub(super) fn draws(
    name: &str,
    beyond: Rate,
    allowed: f64,
    confidence: f64,
    worst: Option<(&Trial, f64)>,
    most: Option<MostMissed>,
) -> Reason {
    let Some((trial, value)) = worst else { return Reason::NoRun };
    let of = beyond.of;
    // So many times as many trials, as large a share of them beyond.
    let times = |shows: &dyn Fn(Rate) -> bool| {
        let rate = |k: usize| Rate { hits: k * beyond.hits, of: k * of };
        Some(of * least([1, MOST_TRIALS / of], |k| shows(rate(k)))?)
    };
    if beyond.hits as f64 / of as f64 <= allowed {
        let shown = |rate: Rate| within(rate.at_most(confidence), allowed);
        let enough = least([of.max(beyond.hits + 1), MOST_TRIALS], |n| {
            shown(Rate { hits: beyond.hits, of: n })
        });
        return Reason::TooFewDraws { of, enough, at_this_rate: times(&shown), most };
    }
    let decided = times(&|rate| rate.at_least(confidence) > allowed).filter(|n| *n > of);
    let worst = Shortfall { value, ..Shortfall::of(name, trial) };
    Reason::Draws { of, allowed, decided, index: trial.index, worst, most }
}

/// The least number of a range from which on something is so; `None` where it is not at its end.
fn least([mut low, mut high]: [usize; 2], is: impl Fn(usize) -> bool) -> Option<usize> {
    if low > high || !is(high) {
        return None;
    }
    while low < high {
        let middle = low + (high - low) / 2;
        if is(middle) { high = middle } else { low = middle + 1 }
    }
    Some(low)
}

/// Most trials that a certification may make.
const MOST_TRIALS: usize = 100_000;

fn symptom(name: &str, s: &Symptoms) -> Option<Symptom> {
    let given = match name {
        "side_tilt_rms_rad" => s.given[1],
        "travel_angle_rms_rad" => s.given[2],
        _ => s.given[0],
    };
    // A wrong sign comes first: what follows from it may oscillate as well.
    if let Some(given) = given.filter(|given| *given < WRONG_WAY) {
        return Some(Symptom::WrongWay(given));
    }
    let swing = s.swing;
    if swing.amplitude >= OSCILLATES && swing.regularity >= REGULAR {
        let (amplitude, frequency, grows) = (swing.amplitude, swing.frequency, swing.growth > 1.5);
        return Some(Symptom::Oscillates { amplitude, frequency, grows });
    }
    if let Some(given) = given.filter(|given| *given > TOO_MUCH && s.at_authority >= HELD) {
        return Some(Symptom::TooMuch(given));
    }
    let pushed = ["depth_rms_m", "push_reading_error_n"].contains(&name)
        || name.ends_with("push_error_rms_n");
    if Held::of(name, s).is_some_and(|held| held.share() >= HELD)
        || pushed
        || name.starts_with("correction")
    {
        return None;
    }
    if let Some(given) = given.filter(|given| *given < TOO_LITTLE) {
        return Some(Symptom::TooLittle(given));
    }
    if !name.starts_with("lateral") || name == "lateral_before_m" {
        return None;
    }
    let [slow, middle, ripple] = s.lateral;
    let (whole, part) = (slow.hypot(middle).hypot(ripple), slow.max(middle).max(ripple));
    let pace = match part {
        part if part == slow => Pace::Slow,
        part if part == ripple => Pace::Ripple,
        _ => Pace::Middle,
    };
    Some(Symptom::Remains { pace, part, whole })
}
