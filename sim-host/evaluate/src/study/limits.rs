//! How far a weld can be driven: the largest push, feed and offset of the seam at which its
//! requirements are kept and it is the weld that was asked for, and what limits them.
//!
//! A range is looked at evenly first, then the edge of what is kept is halved until it is known. That
//! more is always worse is not assumed: a range in which requirements are kept again beyond the edge
//! is told.

use super::place::RealArm;
use crate::figure::{Figure, Limit, share_of_limit, within};
use crate::laws::NoFigures;
use crate::weld::{WELD_FIGURES, WeldFigures};
use nalgebra::Vector3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use trueweld_core::Twist;
use trueweld_plant::cell::Cell;
use trueweld_plant::input::Weld;
use trueweld_plant::simulate::{LimitKind, RunError, Scenario, Seam, run_passes};
use trueweld_plant::{named, serialize_as_text};

named! {
    /// What is driven.
    pub enum Driven {
        /// The push, N.
        Force = "force_n",
        /// The speed along the seam, m/s.
        Feed = "feed_m_s",
        /// By how much the seam lies beside where it was taught, along y of W to either side, m.
        Offset = "offset_m",
    }
}

serialize_as_text!(Driven::name);

impl Driven {
    /// How many runs a search takes at most.
    pub fn runs(self) -> usize {
        self.ends([0.0; 2]).len() * (RANGE_SCAN_VALUES + EDGE_HALVINGS)
    }

    /// Where ranges that are searched begin and end: what has two sides is driven to both.
    fn ends(self, [low, high]: [f64; 2]) -> Vec<[f64; 2]> {
        match self {
            Self::Force | Self::Feed => vec![[low, high]],
            Self::Offset => vec![[low, high], [-low, -high]],
        }
    }

    /// What a weld's file states of it.
    pub fn nominal(self, weld: &Weld) -> f64 {
        match self {
            Self::Force => weld.force,
            Self::Feed => weld.feed,
            Self::Offset => 0.0,
        }
    }
}

/// A study of limits.
#[derive(Debug, Clone, Copy)]
pub struct LimitStudy<'a> {
    /// The scenario; its cell is not used.
    pub scenario: Scenario<'a>,
    /// The arm of the real cell.
    pub arm: RealArm<'a>,
    /// The most that figures may be, beside what is asked of every weld ([`AskedWeld`]).
    ///
    /// [`AskedWeld`]: crate::AskedWeld
    pub limits: &'a [Limit],
    /// Welds of the seam, one after another; the last one counts.
    pub passes: usize,
}

/// One run.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "LimitRun", deny_unknown_fields)]
pub struct LimitProbe {
    /// Value of what is driven, SI units.
    pub value: f64,
    /// The figure that takes the largest share of its limit.
    pub figure: Option<Figure>,
    /// That share; `null` where the run came to no end.
    #[schemars(with = "Option<f64>")]
    pub share: f64,
    /// What stood at a limit, the longest first.
    #[serde(rename = "limits")]
    pub held: Vec<LimitKind>,
    /// Why there are no figures.
    pub failed: Option<NoFigures>,
}

impl LimitProbe {
    /// All limits are kept, and it is the weld that was asked for.
    pub fn is_kept(&self) -> bool {
        within(self.share, 1.0)
    }
}

/// How far something can be driven, SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundLimit {
    /// What.
    pub driven: Driven,
    /// What the weld's file states of it.
    pub nominal: f64,
    /// The largest value at which all is kept, below the first at which it is not; `None` where the
    /// least value looked at keeps it not. Of two sides that of the one that bears less, without a
    /// sign.
    pub largest: Option<f64>,
    /// The run just beyond it, which says what limits; `None` where the whole range is kept.
    pub beyond: Option<LimitProbe>,
    /// All is kept again at this value beyond the edge.
    pub kept_again: Option<f64>,
    /// Every run, by its value.
    pub probes: Vec<LimitProbe>,
}

/// Values that a range is looked at first, and how often the edge is halved.
const RANGE_SCAN_VALUES: usize = 9;
const EDGE_HALVINGS: usize = 6;

impl LimitStudy<'_> {
    /// The edge of what keeps the limits, between two values.
    pub fn find(&self, driven: Driven, range: [f64; 2], progress: impl Fn() + Sync) -> FoundLimit {
        let sides = driven.ends(range).into_iter().map(|ends| self.edge(driven, ends, &progress));
        let mut sides: Vec<FoundLimit> = sides.collect();
        // Nothing that is kept is less than any.
        let reached = |side: &FoundLimit| side.largest.unwrap_or(-1.0);
        sides.sort_by(|a, b| reached(a).total_cmp(&reached(b)));
        let mut found = sides.swap_remove(0);
        found.probes.extend(sides.into_iter().flat_map(|side| side.probes));
        found.probes.sort_by(|a, b| a.value.total_cmp(&b.value));
        // Both sides begin at the same value.
        found.probes.dedup();
        found
    }

    fn edge(
        &self,
        driven: Driven,
        [low, high]: [f64; 2],
        progress: &(impl Fn() + Sync),
    ) -> FoundLimit {
        let value = |k: usize| low + (high - low) * k as f64 / (RANGE_SCAN_VALUES - 1) as f64;
        let values: Vec<f64> = (0..RANGE_SCAN_VALUES).map(value).collect();
        let mut probes: Vec<LimitProbe> = values
            .par_iter()
            .map(|value| {
                let probe = self.probe(driven, *value);
                progress();
                probe
            })
            .collect();
        let first = probes.iter().position(|probe| !probe.is_kept());
        let kept_again = first
            .and_then(|first| probes[first..].iter().find(|probe| probe.is_kept()))
            .map(|probe| probe.value);
        let (largest, beyond) = match first {
            None => (Some(high.abs()), None),
            Some(0) => (None, Some(probes[0].clone())),
            Some(first) => {
                let (mut kept, mut beyond) = (probes[first - 1].value, probes[first].clone());
                for _ in 0..EDGE_HALVINGS {
                    let probe = self.probe(driven, 0.5 * (kept + beyond.value));
                    progress();
                    probes.push(probe.clone());
                    if probe.is_kept() { kept = probe.value } else { beyond = probe }
                }
                (Some(kept.abs()), Some(beyond))
            }
        };
        let nominal = driven.nominal(self.scenario.weld);
        FoundLimit { driven, nominal, largest, beyond, kept_again, probes }
    }

    /// One run at a value of what is driven.
    pub fn probe(&self, driven: Driven, value: f64) -> LimitProbe {
        match self.run(driven, value) {
            Ok(figures) => {
                let stated = self.limits.iter().map(|limit| {
                    let of = WELD_FIGURES.iter().find(|of| of.figure.key == limit.figure.key);
                    let value = of.map_or(f64::NAN, |of| (of.value)(&figures));
                    (*limit.figure, share_of_limit(value, 0.0, limit.value))
                });
                let asked = figures.judged.iter().map(|judged| (judged.figure, judged.share()));
                let worst = stated.chain(asked).reduce(|a, b| if b.1 > a.1 { b } else { a });
                let (figure, share) = worst.unzip();
                let share = share.unwrap_or(0.0);
                let held = figures.limits.iter().map(|span| span.kind).collect();
                LimitProbe { value, figure, share, held, failed: None }
            }
            Err(error) => {
                let held = match &error {
                    NoFigures::Run(RunError::RanAway { limits, .. }) => {
                        limits.iter().map(|span| span.kind).collect()
                    }
                    _ => Vec::new(),
                };
                LimitProbe { value, figure: None, share: f64::INFINITY, held, failed: Some(error) }
            }
        }
    }

    fn run(&self, driven: Driven, value: f64) -> Result<WeldFigures, NoFigures> {
        let mut weld = self.scenario.weld.clone();
        let mut offset = 0.0;
        match driven {
            Driven::Force => weld.force = value,
            Driven::Feed => {
                let share = value / weld.feed;
                weld.feeds.iter_mut().for_each(|(_, feed)| *feed *= share);
                weld.feed = value;
            }
            Driven::Offset => offset = value,
        }
        let beside = Twist { angular: Vector3::zeros(), linear: Vector3::y() * offset };
        let real = Seam::real(&weld).displaced(&beside);
        let cell = Cell::new(self.arm.robot, self.arm.effects, self.scenario.planned, real);
        let cell = cell.map_err(|_| RunError::Cell)?;
        let scenario = Scenario { cell: &cell, weld: &weld, ..self.scenario };
        let recording = run_passes(&scenario, self.passes, |_| {})?;
        WeldFigures::of(&recording).ok_or(NoFigures::NotSteady)
    }
}
