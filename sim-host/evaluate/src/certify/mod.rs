//! Certification of a compensation law: the runs that show what it does, and what they prove.
//!
//! Six kinds of evidence of one weld, each a section with requirements of its own
//! ([`EvidenceKind`]):
//!
//! * nominal: the cell as it is believed to be. A law that is bad there need not be asked further.
//! * draws: seeded Monte Carlo. Every trial draws a cell from the uncertainties of the requirements
//!   and welds it with the law that still believes in the nominal one. A requirement is met where
//!   the probability of a weld beyond its limit is at most what is allowed, with the confidence
//!   asked for, by the exact binomial bound ([`Rate::at_most`](crate::Rate::at_most)).
//! * rare failures, where they are asked for: the probability of a weld beyond any of the limits, by
//!   subset simulation ([`rare_failure`]).
//! * worst case: a search over the whole set that the draws come from, corners included
//!   ([`search`]).
//! * margins: of the loop, linear about the working tool, along the nominal weld and in drawn cells
//!   ([`sector_margins`](crate::margins::sector_margins)).
//! * faults: the nominal cell and drawn ones with one instrument failing for a time
//!   ([`Certification::faults`]).
//!
//! [`CertificationPlan`] is the whole of it: it makes the runs of every weld, keeps them in an evidence
//! folder, takes over those that were made elsewhere ([`Shard`]), and comes to a [`Certificate`].
//!
//! Figures are those of the last pass's steady part. A run that comes to no end, or never reaches
//! its steady part, is beyond every limit. Trial k depends on seed and k alone: not on how many
//! there are, who computes them, or in which order.

mod campaign;
mod certified;
mod difference;
mod draw;
mod evidence_error;
mod fault_figures;
mod faults;
mod judge;
mod manifest;
mod rare;
mod reason;
mod sections;
mod sensitivity;
mod shard;
mod store;
mod subset;
mod symptoms;
pub(crate) mod worst;

pub use campaign::{
    CertificationOutcome, CertificationPlan, CertifyError, OpenCertification, WeldToCertify,
    digest_of_inputs, seed_of_inputs,
};
pub use certified::{AssumedDraws, Certificate, CertifiedWeld, WeldPlan};
pub use difference::must_be_of_same;
pub use draw::{NominalCell, SampledCell};
pub use fault_figures::{FAULT_FIGURES, FaultSizes};
pub use faults::{FaultCase, FaultTrial, FaultsRefused, LimitedFigure};
pub use judge::{
    AcceptedFault, Beyond, DriveUse, Evidence, EvidenceKind, Requirement, Verdict, WeakPoint,
    accepted_faults, drawn_figure, draws, judge, weak_points, worst,
};
pub use manifest::{Shards, begin_shard, check_shard_folder};
pub(crate) use rare::RARE_FIGURE;
pub use rare::{RareFailure, rare_failure};
pub use reason::{Held, MostMissed, Pace, Reason, Shortfall, Symptom};
pub use sensitivity::{Influence, Sensitivity, Trend, sensitivities};
pub use shard::{NoShardName, Shard};
pub use store::{EvidenceBasis, Repeat, TrialStore};
pub use subset::{Level, Subset};
pub use symptoms::{Oscillation, RequiredCorrection, Symptoms};
pub use worst::{WorstCase, search};

pub use crate::figure::within;
use crate::figure::{Figure, FigureOf, Limit, share_of_limit};
use crate::laws::{NoFigures, ReportedFault};
use crate::margins::{MARGIN_FIGURES, Margins, OperatingPoint};
use crate::requirements::Requirements;
use crate::weld::{WELD_FIGURES, WeldFigures};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use trueweld_plant::simulate::{Recording, RunError, Scenario, Seam};

/// Figures by their keys, SI units; all of them numbers.
pub type FigureValues = BTreeMap<String, f64>;

/// Figures of one trial; a reason where there are none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Which.
    pub index: u64,
    /// The cell.
    pub draw: SampledCell,
    /// [`WELD_FIGURES`] of the last pass.
    pub figures: Option<FigureValues>,
    /// How the loop behaved.
    pub symptoms: Option<Symptoms>,
    /// Why there are no figures.
    pub failed: Option<String>,
}

impl Trial {
    /// A figure by its key; infinite where the run came to no end, or to no number.
    pub fn figure(&self, key: &str) -> f64 {
        figure_of(self.figures.as_ref(), key)
    }
}

/// The figure with a key, of whichever kind of run.
pub fn figure(key: &str) -> Option<&'static Figure> {
    let weld = WELD_FIGURES.iter().map(|of| &of.figure);
    let margins = MARGIN_FIGURES.iter().map(|of| &of.figure);
    let faults = FAULT_FIGURES.iter().map(|of| &of.figure);
    let rare = std::iter::once(&RARE_FIGURE);
    weld.chain(margins).chain(faults).chain(rare).find(|figure| figure.key == key)
}

/// A figure that is limited, as a search and a simulation of rare failures look at it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Criterion {
    key: &'static str,
    limit: f64,
    /// Where its share of the limit counts from.
    from: f64,
}

/// Figures of drives, whose shares count from the nominal cell's: the most of what a drive gives is
/// for the arm's weight and the push, in any cell, and would hide how close other figures come.
const OF_DRIVES: [&str; 2] = ["torque_share_max", "speed_share_max"];

impl Criterion {
    fn new(limit: &Limit, nominal: &Trial) -> Self {
        let (key, limit) = (limit.figure.key, limit.value);
        let there = nominal.figure(key);
        let counts = OF_DRIVES.contains(&key) && there < limit;
        Self { key, limit, from: if counts { there } else { 0.0 } }
    }

    fn share(&self, trial: &Trial) -> f64 {
        share_of_limit(trial.figure(self.key), self.from, self.limit)
    }
}

/// The criterion of which a trial takes the largest share, with that share, beyond 1 where the weld
/// has failed. Of equals the first; `None` of none.
fn largest_share<'c>(all: &'c [Criterion], trial: &Trial) -> Option<(&'c Criterion, f64)> {
    let shares = all.iter().map(|criterion| (criterion, criterion.share(trial)));
    shares.reduce(|most, one| if one.1 > most.1 { one } else { most })
}

/// A figure of a run; infinite where it came to no end, or to no number.
fn figure_of(figures: Option<&FigureValues>, key: &str) -> f64 {
    figures.and_then(|figures| figures.get(key)).copied().unwrap_or(f64::INFINITY)
}

/// Figures by their keys; what is no number is left out.
pub(crate) fn values<'a, S: 'static>(
    table: impl Iterator<Item = &'a FigureOf<S>>,
    of: &S,
) -> FigureValues {
    let all = table.map(|figure| (figure.figure.key.to_owned(), (figure.value)(of)));
    all.filter(|(_, value)| value.is_finite()).collect()
}

/// A run that is worth a picture.
#[derive(Debug, Clone)]
pub struct ShownRun {
    /// Which.
    pub kind: ShownKind,
    /// What was recorded of its last pass.
    pub recording: Recording,
}

/// Which run is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShownKind {
    /// The cell as it is believed to be.
    Nominal,
    /// The worst draw in a figure, by its key.
    Draw(u64, &'static str),
    /// The worst cell that the search found.
    Search(u64),
}

/// Most draws that are shown.
const SHOWN_DRAWS: usize = 3;

/// What is to be certified.
#[derive(Debug, Clone, Copy)]
pub struct Certification<'a> {
    /// The nominal scenario: law, weld, gains, instruments. Its cell is not used.
    pub scenario: Scenario<'a>,
    /// What every cell of the certification is made from.
    pub cell: NominalCell<'a>,
    /// Requirements and uncertainties.
    pub requirements: &'a Requirements,
    /// What the nominal cell needs of a correction, to tell a law that goes the wrong way.
    pub needed: &'a RequiredCorrection,
    /// Welds of one seam in a trial, the law kept; the last one counts.
    pub passes: usize,
    /// Of the draws.
    pub seed: u64,
}

impl Certification<'_> {
    /// Runs one trial of the Monte Carlo.
    pub fn trial(&self, index: u64) -> Trial {
        self.weld(index, SampledCell::new(self.cell.uncertain, self.seed, index))
    }

    /// Runs the cell as it is believed to be.
    pub fn nominal(&self) -> Trial {
        self.weld(0, SampledCell::nominal(self.scenario.seed))
    }

    /// Margins of the loop along the weld in the nominal cell with its effects, without the ripple
    /// of its process, and in drawn cells, one a place of the steady part; none where none are
    /// asked for.
    ///
    /// # Errors
    /// [`RunError`] where the seam cannot be followed.
    pub fn margins(&self) -> Result<Vec<Margins>, RunError> {
        let Some(asked) = &self.requirements.margins else {
            return Ok(Vec::new());
        };
        let weld = self.scenario.weld;
        let nominal = SampledCell::nominal(0);
        let drawn = (0..asked.draws).map(|k| {
            let draw = SampledCell::new(self.cell.uncertain, self.seed, k as u64);
            let share = (k as f64 + 0.5) / asked.draws as f64;
            (OperatingPoint::steady(weld, Seam::of(weld).length * share), draw, Some(k as u64))
        });
        let along = OperatingPoint::along(weld, asked.places).into_iter();
        let all: Vec<_> = along.map(|at| (at, nominal.clone(), None)).chain(drawn).collect();
        let each: Result<Vec<_>, RunError> = all
            .par_iter()
            .map(|(at, cell, draw)| {
                let mut margins = self.cell.margins(&self.scenario, cell, at)?;
                margins.iter_mut().for_each(|margins| margins.of.draw = *draw);
                Ok(margins)
            })
            .collect();
        Ok(each?.concat())
    }

    /// Runs a cell of one's own choice.
    pub fn weld(&self, index: u64, draw: SampledCell) -> Trial {
        let recording = self.cell.weld(&self.scenario, &draw, self.passes);
        let (figures, symptoms, failed) = match &recording {
            Ok(recording) => match (ReportedFault::of(recording), WeldFigures::of(recording)) {
                (Some(fault), _) => (None, Some(self.symptoms(recording)), Some(fault.to_string())),
                (None, Some(figures)) => {
                    (Some(values(self.asked(), &figures)), Some(self.symptoms(recording)), None)
                }
                (None, None) => (None, None, Some(NoFigures::NotSteady.to_string())),
            },
            Err(error) => (None, None, Some(error.to_string())),
        };
        Trial { index, draw, figures, symptoms, failed }
    }

    /// Runs worth a picture, made once more: the nominal one, the worst draws in the figures that
    /// come closest to their limits or farthest beyond, and the worst cell of the search.
    pub fn shown(&self, evidence: &Evidence, judged: &[Requirement]) -> Vec<ShownRun> {
        let trials = &evidence.trials;
        let of_draws = judged.iter().filter(|r| r.case == EvidenceKind::Draws && !r.is_joint());
        let mut worst: Vec<(f64, &'static str, &Trial)> = of_draws
            .filter_map(|r| {
                let of = |trial: &Trial| trial.figure(r.name);
                let trial = worst(trials, |t| of(t))?;
                Some((share_of_limit(of(trial), 0.0, r.limit), r.name, trial))
            })
            .collect();
        worst.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut shown = vec![(ShownKind::Nominal, &evidence.nominal.draw)];
        for (_, name, trial) in worst {
            let is = |(_, draw): &(ShownKind, &SampledCell)| **draw == trial.draw;
            if shown.len() <= SHOWN_DRAWS && !shown.iter().any(is) {
                shown.push((ShownKind::Draw(trial.index, name), &trial.draw));
            }
        }
        if let Some(found) = &evidence.worst.worst
            && !trials.contains(found)
        {
            shown.push((ShownKind::Search(found.index), &found.draw));
        }
        let runs = shown.into_par_iter().filter_map(|(kind, draw)| {
            let recording = self.cell.weld(&self.scenario, draw, self.passes).ok()?;
            Some(ShownRun { kind, recording })
        });
        runs.collect()
    }

    /// Figures that are kept of a weld: all of the steady part, and those of other phases that are
    /// limited.
    fn asked(&self) -> impl Iterator<Item = &'static FigureOf<WeldFigures>> {
        let limits = || self.requirements.limits.iter().chain(&self.requirements.worst_case);
        WELD_FIGURES.iter().filter(move |of| {
            of.figure.phase().is_empty() || limits().any(|limit| limit.figure.key == of.figure.key)
        })
    }

    fn symptoms(&self, recording: &Recording) -> Symptoms {
        let spindle = self.scenario.planned.spindle.abs();
        Symptoms::of(recording, self.needed, &self.scenario.control.compensation, spindle)
    }
}
