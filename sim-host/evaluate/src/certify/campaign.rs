//! A certification as a whole: the runs of every weld, kept as they are made, and what they prove.

use super::certified::{AssumedDraws, Certificate, CertifiedWeld, WeldPlan};
use super::draw::{NominalCell, SampledCell};
use super::evidence_error::cannot;
use super::faults::FaultsRefused;
use super::judge::{Evidence, accepted_faults, draws, judge, weak_points};
use super::manifest::{Shards, begin_shard, check_shard_folder, evidence_digest};
use super::rare::{FEWEST_DRAWS, rare_failure};
use super::sections::{
    ASSUMED_SECTION, EVIDENCE_SECTIONS, EvidenceFiles, EvidenceJobs, EvidenceRuns, OnProgress,
    RunMeter, is_trial, section_file,
};
use super::sensitivity::sensitivities;
use super::shard::Shard;
use super::store::{EvidenceBasis, Repeat, TrialStore};
use super::symptoms::RequiredCorrection;
use super::worst::{WorstCase, search};
use super::{Certification, Trial};
use crate::requirements::Requirements;
use crate::uncertain::UncertainCell;
use miette::{IntoDiagnostic, Report};
use std::path::{Path, PathBuf};
use trueweld_core::Robot;
use trueweld_plant::effects::Effect;
use trueweld_plant::input::FileKind;
use trueweld_plant::provenance::{FileDigest, Provenance, sha256};
use trueweld_plant::simulate::{RunError, Scenario};

/// What is to be certified, how it is to be shown, and where its runs are kept.
///
/// The same plan with the same evidence folder goes on where it was stopped; the certificate depends
/// on neither threads nor interruptions.
#[derive(Debug, Clone)]
pub struct CertificationPlan<'a> {
    /// Every weld, each by a name of its own.
    pub welds: Vec<WeldToCertify<'a>>,
    /// Requirements as their file has them, for all welds.
    pub requirements: &'a Requirements,
    /// What is not known of the cell.
    pub uncertain: &'a UncertainCell,
    /// The same without what was measured, where trials of both are to be compared.
    pub assumed: Option<&'a UncertainCell>,
    /// Trials of each weld.
    pub trials: u64,
    /// A weld beyond any limit is to be shown rarer than this, by subset simulation.
    pub failure_probability: Option<f64>,
    /// Runs of the search for the worst cell, of each weld.
    pub worst: usize,
    /// Welds of one seam in a trial, the law kept; the last one counts.
    pub passes: usize,
    /// Seed of the draws, as [`seed_of_inputs`] makes one.
    pub seed: u64,
    /// The folder in which every run is kept.
    pub evidence: &'a Path,
    /// Which of the kept runs are made again.
    pub repeat: Repeat,
    /// Make this part of the runs alone.
    pub shard: Option<Shard>,
    /// Folders of shards whose runs are taken over.
    pub merge: &'a [PathBuf],
}

/// One weld of a certification.
#[derive(Debug, Clone)]
pub struct WeldToCertify<'a> {
    /// The nominal scenario with law, controller, gains and instruments. Its name is that of the
    /// evidence's files; its cell is not used.
    pub scenario: Scenario<'a>,
    /// The robot as it is believed to be.
    pub robot: &'a Robot<f64>,
    /// Effects of the real cell, whatever else is drawn.
    pub effects: &'a [Effect],
    /// Requirements as they are asked of this weld.
    pub requirements: Requirements,
    /// What its runs are of, but for the seed of the draws.
    pub provenance: Provenance,
}

/// Why there is no certificate.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum CertifyError {
    /// A weld that cannot be made.
    #[error("weld {weld}: {error}")]
    Run {
        /// Which, from 0 on.
        weld: usize,
        /// Why not.
        error: RunError,
    },
    /// A weld that never reaches its steady part.
    #[error("weld {weld}: the steady part is not reached")]
    TooShort {
        /// Which, from 0 on.
        weld: usize,
    },
    /// Faults that the weld cannot be judged by.
    #[error("weld {weld}: {error}")]
    Faults {
        /// Which, from 0 on.
        weld: usize,
        /// Why not.
        error: FaultsRefused,
    },
    /// Fewer trials than a simulation of rare failures begins with.
    #[error(
        "--failure-probability: {trials} trials are too few to begin with; expected --trials {FEWEST_DRAWS} or more"
    )]
    #[diagnostic(help(
        "Its first level are the trials, and every later one has as many: some 400 show 1e-4."
    ))]
    TooFewTrials {
        /// How many there are.
        trials: u64,
    },
    /// An evidence folder without a run, where all are to be made again.
    #[error("--verify: {} holds no run; expected an evidence folder", folder.display())]
    NothingKept {
        /// The folder.
        folder: PathBuf,
    },
    /// No run of the cell as it is believed to be.
    #[error("the nominal run is missing")]
    NoNominal,
    /// Runs that cannot be kept, taken over, or put together.
    #[error("{0}")]
    Evidence(Report),
}

impl From<Report> for CertifyError {
    fn from(report: Report) -> Self {
        Self::Evidence(report)
    }
}

/// What [`OpenCertification::run`] comes to.
#[derive(Debug, Clone)]
pub enum CertificationOutcome {
    /// Of the whole.
    Whole(Box<Certificate>),
    /// Of a shard: how many runs it has. No certificate yet.
    Part(usize),
}

/// A certification whose inputs are usable and whose kept runs are read.
pub struct OpenCertification<'a> {
    plan: CertificationPlan<'a>,
    welds: Vec<OpenedWeld>,
    provenance: Provenance,
    /// How many runs are kept.
    kept: usize,
}

/// What is read and computed of a weld before its first run.
struct OpenedWeld {
    needed: RequiredCorrection,
    /// Digest of the inputs.
    key: String,
    sources: String,
    kept: EvidenceFiles,
    /// Trials with what is assumed, where both are compared.
    assumed: Option<TrialStore<Trial>>,
}

impl<'a> CertificationPlan<'a> {
    /// Finds out whether every weld can be made, and reads what is kept. Makes the evidence folder;
    /// nothing else is written yet.
    ///
    /// # Errors
    /// A weld that cannot be made or judged; evidence of something else, or that was changed; a
    /// shard that does not fit.
    pub fn open(self) -> Result<OpenCertification<'a>, CertifyError> {
        if self.failure_probability.is_some() && self.trials < FEWEST_DRAWS as u64 {
            return Err(CertifyError::TooFewTrials { trials: self.trials });
        }
        let mut provenance: Option<Provenance> = None;
        let mut welds = Vec::new();
        for number in 0..self.welds.len() {
            let of = self.provenance(number);
            welds.push(self.open_weld(number, &of)?);
            match &mut provenance {
                None => provenance = Some(of),
                Some(all) => all.join(&of),
            }
        }
        let provenance = provenance.unwrap_or_default();
        check_shard_folder(self.evidence, self.shard)?;
        if !self.merge.is_empty() {
            let shards = Shards::read(self.merge, &provenance, self.trials)?;
            for (number, weld) in welds.iter_mut().enumerate() {
                self.merge_weld(number, weld, &shards)?;
            }
        }
        let kept = welds.iter().map(|weld| weld.kept.kept()).sum();
        if self.repeat == Repeat::All && kept == 0 {
            return Err(CertifyError::NothingKept { folder: self.evidence.to_owned() });
        }
        std::fs::create_dir_all(self.evidence)
            .map_err(|source| cannot("create", self.evidence, source))?;
        Ok(OpenCertification { plan: self, welds, provenance, kept })
    }

    /// What the runs of a weld are of.
    fn provenance(&self, weld: usize) -> Provenance {
        let mut provenance = self.welds[weld].provenance.clone();
        if let Some(simulation) = &mut provenance.simulation {
            simulation.draws_seed = Some(self.seed);
        }
        provenance
    }

    /// Finds out whether the law can be built and the weld be made, and reads what is kept of it.
    fn open_weld(
        &self,
        number: usize,
        provenance: &Provenance,
    ) -> Result<OpenedWeld, CertifyError> {
        let failed = |error| CertifyError::Run { weld: number, error };
        let WeldToCertify { scenario, .. } = &self.welds[number];
        let key = digest_of_inputs(provenance)?;
        scenario.build_law().map_err(failed)?;
        let cell = self.cell(number, self.uncertain);
        let drawn = SampledCell::new(self.uncertain, self.seed, 0);
        cell.build(&drawn, scenario.planned, scenario.weld).map_err(failed)?;
        let needed = RequiredCorrection::of(scenario, &cell)
            .map_err(failed)?
            .ok_or(CertifyError::TooShort { weld: number })?;
        self.jobs(number, &needed)?;
        let sources = provenance.sources.clone();
        let basis = EvidenceBasis { inputs: &key, sources: &sources };
        let kept = EvidenceFiles::open(self.evidence, scenario.name, basis, self.repeat)?;
        let path = section_file(self.evidence, ASSUMED_SECTION, scenario.name);
        let assumed = self.assumed.map(|_| TrialStore::open(path, basis, self.repeat));
        Ok(OpenedWeld { needed, assumed: assumed.transpose()?, kept, key, sources })
    }

    /// Takes over the runs of shards.
    fn merge_weld(
        &self,
        number: usize,
        weld: &mut OpenedWeld,
        shards: &Shards,
    ) -> Result<(), CertifyError> {
        let jobs = self.jobs(number, &weld.needed)?;
        let name = self.welds[number].scenario.name;
        let (key, sources) = (weld.key.clone(), weld.sources.clone());
        let basis = EvidenceBasis { inputs: &key, sources: &sources };
        let open = |folder: &Path| EvidenceFiles::open(folder, name, basis, self.repeat);
        Ok(weld.kept.merge(&jobs, shards, name, open)?)
    }

    /// What the cells of a weld are made from.
    fn cell<'c>(&'c self, weld: usize, uncertain: &'c UncertainCell) -> NominalCell<'c> {
        let WeldToCertify { robot, effects, .. } = &self.welds[weld];
        NominalCell { robot, effects, uncertain }
    }

    fn certification<'c>(
        &'c self,
        weld: usize,
        needed: &'c RequiredCorrection,
    ) -> Certification<'c> {
        Certification {
            scenario: self.welds[weld].scenario,
            cell: self.cell(weld, self.uncertain),
            requirements: &self.welds[weld].requirements,
            needed,
            passes: self.passes,
            seed: self.seed,
        }
    }

    /// The runs of a weld that depend on no other; the search for the worst cell needs all of them.
    fn jobs(&self, weld: usize, needed: &RequiredCorrection) -> Result<EvidenceJobs, CertifyError> {
        let faults = self.certification(weld, needed).faults();
        let faults = faults.map_err(|error| CertifyError::Faults { weld, error })?;
        Ok(EvidenceJobs { nominal: vec![()], faults, trials: (0..self.trials).collect() })
    }

    /// The files with the runs of a weld; not every certification has all of them.
    fn section_files(&self) -> Vec<PathBuf> {
        let names = self.welds.iter().map(|weld| weld.scenario.name);
        let files =
            names.flat_map(|name| EVIDENCE_SECTIONS.map(|s| section_file(self.evidence, s, name)));
        files.collect()
    }

    /// How many runs are made of a weld beside its jobs, at most: of the search, of rare failures,
    /// and of the cell as it is assumed.
    fn more_runs(&self, weld: &OpenedWeld) -> usize {
        // Of every level but the first nine tenths are new; the next one's cells are a tenth as rare.
        let levels = self.failure_probability.map_or(0.0, |p| (-p.log10()).ceil());
        let rare = (0.9 * levels * self.trials as f64) as usize;
        let assumed = weld.assumed.as_ref().map_or(0, |store| {
            (self.trials as usize).max(weld.kept.trials.kept()).saturating_sub(store.count())
        });
        self.worst + rare + assumed
    }
}

impl OpenCertification<'_> {
    /// The files with runs that it writes, or would where there are such runs.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files = self.plan.section_files();
        let compared = self.plan.welds.iter().filter(|_| self.plan.assumed.is_some());
        let name = |weld: &WeldToCertify<'_>| {
            section_file(self.plan.evidence, ASSUMED_SECTION, weld.scenario.name)
        };
        files.extend(compared.map(name));
        files
    }

    /// Makes the runs that are missing and judges all of them. `progress` is told what is made now
    /// and the share of the missing runs that is made, from any thread.
    ///
    /// # Errors
    /// A loop without margins; evidence that cannot be written; a kept run that comes out otherwise.
    pub fn run(
        self,
        progress: &(dyn Fn(&str, f64) + Sync),
    ) -> Result<CertificationOutcome, CertifyError> {
        let Self { plan, welds, provenance, kept } = self;
        match plan.shard {
            Some(shard) => {
                run_part(&plan, shard, welds, provenance, progress).map(CertificationOutcome::Part)
            }
            None => {
                let certificate = run_whole(&plan, welds, provenance, kept, progress)?;
                Ok(CertificationOutcome::Whole(Box::new(certificate)))
            }
        }
    }
}

/// The sections that there are.
fn written(sections: &[PathBuf]) -> Vec<PathBuf> {
    sections.iter().filter(|file| file.exists()).cloned().collect()
}

/// Makes the runs of a shard: how many there are.
fn run_part(
    plan: &CertificationPlan<'_>,
    shard: Shard,
    welds: Vec<OpenedWeld>,
    provenance: Provenance,
    progress: &OnProgress<'_>,
) -> Result<usize, CertifyError> {
    begin_shard(plan.evidence)?;
    let mut parts = Vec::new();
    let mut missing = 0.0;
    for (number, weld) in welds.iter().enumerate() {
        let jobs = plan.jobs(number, &weld.needed)?.part(shard);
        missing += weld.kept.missing(&jobs, 0, &plan.certification(number, &weld.needed));
        parts.push(jobs);
    }
    let meter = RunMeter::new(progress, missing);
    let mut runs = 0;
    for (number, (weld, jobs)) in welds.into_iter().zip(parts).enumerate() {
        let OpenedWeld { needed, mut kept, .. } = weld;
        runs += kept.complete(&jobs, &plan.certification(number, &needed), &meter)?.count();
        kept.close(false)?;
    }
    let sections = written(&plan.section_files());
    shard.finish(plan.evidence, &sections, provenance, plan.trials)?;
    Ok(runs)
}

/// Makes every run and judges it.
fn run_whole(
    plan: &CertificationPlan<'_>,
    welds: Vec<OpenedWeld>,
    provenance: Provenance,
    kept: usize,
    progress: &OnProgress<'_>,
) -> Result<Certificate, CertifyError> {
    let mut missing = 0.0;
    for (number, weld) in welds.iter().enumerate() {
        let jobs = plan.jobs(number, &weld.needed)?;
        let certification = plan.certification(number, &weld.needed);
        missing += weld.kept.missing(&jobs, plan.more_runs(weld), &certification);
    }
    let meter = RunMeter::new(progress, missing);
    let mut certified = Vec::new();
    let mut repeated = 0;
    for (number, weld) in welds.into_iter().enumerate() {
        let (weld, again) = run_weld(plan, number, weld, &meter)?;
        certified.push(weld);
        repeated += again;
    }
    let scenario = plan.welds.first().map(|weld| weld.scenario);
    let files = written(&plan.section_files());
    Ok(Certificate {
        law: scenario.map_or(String::new(), |scenario| scenario.law.name().to_owned()),
        controller: scenario.map_or("", |scenario| scenario.controller.name()),
        passes: plan.passes,
        seed: plan.seed,
        asked: [plan.requirements.failure_probability, plan.requirements.confidence],
        welds: certified,
        uncertain: plan.uncertain.clone(),
        files: files.iter().map(|file| evidence_digest(file)).collect::<Result<_, _>>()?,
        kept,
        repeated,
        provenance,
    })
}

/// Every run of a weld: those that are kept, and the missing ones; how many kept ones were made
/// again.
fn run_weld(
    plan: &CertificationPlan<'_>,
    number: usize,
    weld: OpenedWeld,
    meter: &RunMeter<'_>,
) -> Result<(CertifiedWeld, usize), CertifyError> {
    let OpenedWeld { needed, mut kept, assumed, .. } = weld;
    let WeldToCertify { scenario, requirements, .. } = &plan.welds[number];
    let CertificationPlan { uncertain, seed, .. } = *plan;
    let certification = plan.certification(number, &needed);
    let jobs = plan.jobs(number, &needed)?;
    // First: where they cannot be determined, no run is made for nothing.
    meter.tell("margins");
    let margins =
        certification.margins().map_err(|error| CertifyError::Run { weld: number, error })?;
    let EvidenceRuns { nominal, faults, mut trials } =
        kept.complete(&jobs, &certification, meter)?;
    let nominal = nominal.into_iter().next().ok_or(CertifyError::NoNominal)?;
    let trial = |index: &u64| meter.count("draws", 1.0, certification.trial(*index));
    trials.extend(kept.trials.others(|trial| trial.index, is_trial, trial)?);
    trials.sort_by_key(|trial| trial.index);
    trials.dedup_by_key(|trial| trial.index);
    let is = |(index, draw): &(u64, _), run: &Trial| run.index == *index && run.draw == *draw;
    let rare = plan.failure_probability.map(|allowed| {
        rare_failure(requirements, &nominal, uncertain, seed, &trials, allowed, |batch| {
            kept.rare.complete(batch, is, |(index, draw)| {
                meter.count("rare failures", 1.0, certification.weld(*index, draw.clone()))
            })
        })
    });
    let rare = rare.transpose()?;
    let searching = |(index, draw): &(u64, SampledCell)| {
        meter.count("worst case", 1.0, certification.weld(*index, draw.clone()))
    };
    let mut searched =
        search(requirements, uncertain, seed, &nominal, &trials, plan.worst, |batch| {
            kept.worst.complete(batch, is, searching)
        })?;
    let job = |run: &Trial| (run.index, run.draw.clone());
    searched.extend(kept.worst.others(job, is, searching)?);
    let assumed = match plan.assumed.zip(assumed) {
        Some((uncertain, mut store)) => {
            let cell = plan.cell(number, uncertain);
            let certification = Certification { cell, ..certification };
            let indices: Vec<u64> = trials.iter().map(|trial| trial.index).collect();
            let trials = store.complete(&indices, is_trial, |index| {
                meter.count("assumed", 1.0, certification.trial(*index))
            })?;
            store.close()?;
            Some(AssumedDraws { requirements: draws(requirements, &trials), trials })
        }
        None => None,
    };
    let repeated = kept.repeated();
    kept.close(plan.failure_probability.is_some())?;
    let worst = WorstCase::among(requirements, &nominal, &trials, searched);
    let evidence = Evidence { nominal, trials, rare, worst, margins, faults };
    let held = plan.requirements.held(requirements);
    let accepted_faults = accepted_faults(requirements, &evidence.faults);
    let requirements = judge(requirements, &evidence);
    let weld = CertifiedWeld {
        name: scenario.name.to_owned(),
        held,
        planned: WeldPlan::of(scenario.weld, scenario.planned),
        sensitivities: sensitivities(uncertain, &requirements, &evidence),
        weak_points: weak_points(&requirements, &evidence.margins),
        shown: certification.shown(&evidence, &requirements),
        evidence,
        requirements,
        accepted_faults,
        assumed,
    };
    Ok((weld, repeated))
}

/// SHA-256 of every input that runs depend on: options and bytes of files, wherever these lie.
///
/// # Errors
/// Inputs that have no text.
pub fn digest_of_inputs(provenance: &Provenance) -> miette::Result<String> {
    let mut of = provenance.clone();
    of.files.iter_mut().for_each(|file: &mut FileDigest| file.file.clear());
    // Warnings follow from the files, and name their paths; of the program the sources count.
    of.warnings.clear();
    of.version.clear();
    of.sources.clear();
    Ok(sha256(serde_json::to_string(&of).into_diagnostic()?.as_bytes()))
}

/// The seed of the draws that follows from the inputs. Welds are left out: all meet the same cells,
/// whichever are certified together. So are trials and runs of search: there may be more later.
///
/// # Errors
/// Those of [`digest_of_inputs`].
pub fn seed_of_inputs(provenance: &Provenance) -> miette::Result<u64> {
    let mut of = provenance.clone();
    of.files.retain(|file| file.role != FileKind::Weld.name());
    if let Some(simulation) = &mut of.simulation {
        simulation.welds.clear();
        simulation.cores.clear();
    }
    // Short enough to be typed after --draws.
    let digits = digest_of_inputs(&of)?;
    Ok(digits.bytes().take(8).fold(0, |seed, digit| {
        16 * seed + u64::from((digit as char).to_digit(16).unwrap_or_default())
    }))
}
