//! The runs of one weld as an evidence folder keeps them: a file a section.

use super::faults::{FaultCase, FaultTrial};
use super::manifest::Shards;
use super::shard::Shard;
use super::store::{EvidenceBasis, Repeat, TrialStore};
use super::{Certification, Trial};
use miette::Result;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The sections of a weld's evidence.
pub(super) const EVIDENCE_SECTIONS: [&str; 5] = ["nominal", "trials", "rare", "worst", "faults"];

/// The section of trials with what is assumed of measured numbers.
pub(super) const ASSUMED_SECTION: &str = "assumed";

/// The file of a section of a weld.
pub(super) fn section_file(folder: &Path, section: &str, weld: &str) -> PathBuf {
    folder.join(format!("{section}-{weld}.jsonl"))
}

/// The runs that are kept of a weld.
pub(super) struct EvidenceFiles {
    nominal: TrialStore<Trial>,
    pub(super) trials: TrialStore<Trial>,
    pub(super) rare: TrialStore<Trial>,
    pub(super) worst: TrialStore<Trial>,
    faults: TrialStore<FaultTrial>,
}

impl EvidenceFiles {
    pub(super) fn open(
        folder: &Path,
        weld: &str,
        basis: EvidenceBasis<'_>,
        repeat: Repeat,
    ) -> Result<Self> {
        let [nominal, trials, rare, worst, faults] =
            EVIDENCE_SECTIONS.map(|s| section_file(folder, s, weld));
        Ok(Self {
            nominal: TrialStore::open(nominal, basis, repeat)?,
            trials: TrialStore::open(trials, basis, repeat)?,
            rare: TrialStore::open(rare, basis, repeat)?,
            worst: TrialStore::open(worst, basis, repeat)?,
            faults: TrialStore::open(faults, basis, repeat)?,
        })
    }

    /// How many runs are kept.
    pub(super) fn kept(&self) -> usize {
        let welds = self.nominal.kept() + self.trials.kept() + self.rare.kept();
        welds + self.worst.kept() + self.faults.kept()
    }

    /// How many kept runs were made again so far, and came out as they were kept.
    pub(super) fn repeated(&self) -> usize {
        let welds = self.nominal.repeated() + self.trials.repeated() + self.rare.repeated();
        welds + self.worst.repeated() + self.faults.repeated()
    }

    /// How many welds without a fault need not be made again.
    fn welds(&self) -> usize {
        self.nominal.count() + self.trials.count() + self.rare.count() + self.worst.count()
    }

    /// What it takes, in welds without a fault, to make these jobs and so many runs beside them,
    /// without those that are kept.
    pub(super) fn missing(
        &self,
        jobs: &EvidenceJobs,
        more: usize,
        certification: &Certification<'_>,
    ) -> f64 {
        let trials = jobs.trials.len().max(self.trials.kept());
        let welds = jobs.nominal.len() + trials + more;
        let faults: f64 = jobs.faults.iter().map(|case| certification.cost(case)).sum();
        let of_kept = faults / jobs.faults.len().max(1) as f64 * self.faults.count() as f64;
        welds.saturating_sub(self.welds()) as f64 + faults - of_kept
    }

    /// Takes over the runs of these jobs from shards. `open`: the same of a shard's folder.
    pub(super) fn merge(
        &mut self,
        jobs: &EvidenceJobs,
        shards: &Shards,
        weld: &str,
        open: impl Fn(&Path) -> Result<Self>,
    ) -> Result<()> {
        let (mut nominal, mut faults, mut trials) = (Vec::new(), Vec::new(), Vec::new());
        for folder in shards.folders() {
            let files = open(folder)?;
            nominal.push(files.nominal);
            faults.push(files.faults);
            trials.push(files.trials);
        }
        let lacks = |shard: usize| shards.lacks(shard, weld);
        self.nominal.merge(&jobs.nominal, &nominal, is_nominal).map_err(lacks)?;
        self.faults.merge(&jobs.faults, &faults, is_fault).map_err(lacks)?;
        self.trials.merge(&jobs.trials, &trials, is_trial).map_err(lacks)
    }

    /// The runs of these jobs: those that are kept, and the missing ones.
    pub(super) fn complete(
        &mut self,
        jobs: &EvidenceJobs,
        certification: &Certification<'_>,
        meter: &RunMeter<'_>,
    ) -> Result<EvidenceRuns> {
        let nominal = self.nominal.complete(&jobs.nominal, is_nominal, |()| {
            meter.count("nominal", 1.0, certification.nominal())
        })?;
        let faults = self.faults.complete(&jobs.faults, is_fault, |case| {
            meter.count("faults", certification.cost(case), certification.run_fault(case))
        })?;
        let trials = self.trials.complete(&jobs.trials, is_trial, |index| {
            meter.count("draws", 1.0, certification.trial(*index))
        })?;
        Ok(EvidenceRuns { nominal, faults, trials })
    }

    /// `rare`: whether rare failures were asked for.
    pub(super) fn close(self, rare: bool) -> Result<()> {
        self.nominal.close()?;
        self.trials.close()?;
        if rare {
            self.rare.close()?;
        }
        self.worst.close()?;
        self.faults.close()
    }
}

/// Runs that depend on no other run, in their order.
pub(super) struct EvidenceJobs {
    pub(super) nominal: Vec<()>,
    pub(super) faults: Vec<FaultCase>,
    pub(super) trials: Vec<u64>,
}

impl EvidenceJobs {
    /// What a shard makes of them.
    pub(super) fn part(self, shard: Shard) -> Self {
        let Self { nominal, faults, trials } = self;
        Self {
            nominal: shard.part(nominal),
            faults: shard.part(faults),
            trials: shard.part(trials),
        }
    }
}

/// What the jobs came to.
pub(super) struct EvidenceRuns {
    pub(super) nominal: Vec<Trial>,
    pub(super) faults: Vec<FaultTrial>,
    pub(super) trials: Vec<Trial>,
}

impl EvidenceRuns {
    pub(super) fn count(&self) -> usize {
        self.nominal.len() + self.faults.len() + self.trials.len()
    }
}

fn is_nominal((): &(), _: &Trial) -> bool {
    true
}

fn is_fault(case: &FaultCase, run: &FaultTrial) -> bool {
    run.is_of(case)
}

/// Whether a run is the trial of this number.
pub(super) fn is_trial(index: &u64, run: &Trial) -> bool {
    run.index == *index
}

/// Told of what is made now, and of the share of the missing runs that is made; from any thread.
pub(super) type OnProgress<'a> = dyn Fn(&str, f64) + Sync + 'a;

/// How much of the missing runs is made, in welds without a fault.
pub(super) struct RunMeter<'a> {
    told: &'a OnProgress<'a>,
    made: Mutex<f64>,
    of: f64,
}

impl<'a> RunMeter<'a> {
    pub(super) fn new(told: &'a OnProgress<'a>, of: f64) -> Self {
        Self { told, made: Mutex::new(0.0), of }
    }

    /// Tells what is made now.
    pub(super) fn tell(&self, section: &str) {
        self.count(section, 0.0, ());
    }

    /// Counts a run that was just made.
    pub(super) fn count<R>(&self, section: &str, cost: f64, run: R) -> R {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        *made += cost;
        (self.told)(section, *made / self.of.max(1.0));
        run
    }
}
