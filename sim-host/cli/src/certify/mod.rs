//! `trueweld certify`: many welds of uncertain cells, and what they prove of a compensation law.
//!
//! Runs are kept one a line in the evidence folder as they come; the command given again goes on
//! where it was stopped. A part of them may be made elsewhere ([`shard`]).

pub mod certificate;
pub mod shard;
pub mod store;

use crate::inputs::{CellFiles, Inputs, STEP_OF_MANY, passes, read};
use crate::names::{Controller, LawParser};
use crate::repeat;
use crate::results::{Results, check_new_folder, check_outputs, check_targets, write};
use clap::{Args, value_parser};
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use shard::{Shard, Shards};
use std::path::{Path, PathBuf};
use std::slice;
use std::sync::{Mutex, PoisonError};
use store::{Basis, Repeat, TrialStore};
use trueweld_compensators::Entry;
use trueweld_evaluate::certify::{
    Certification, Evidence, FEWEST_DRAWS, FaultCase, FaultTrial, FaultsRefused,
    RequiredCorrection, SampledCell, Trial, Verdict, WorstCase, accepted_faults, draws, judge,
    rare_failure, search, sensitivities, weak_points,
};
use trueweld_evaluate::{Requirements, UncertainCell};
use trueweld_output::{
    AssumedDraws, CertifiedWeld, CertifyReport, Progress, Report, WeldPlan, write_file,
};
use trueweld_plant::input::FileKind;
use trueweld_plant::provenance::{FileDigest, Provenance, sha256};
use trueweld_plant::simulate::{RunError, Scenario, WeldProgram};

/// Arguments of `certify`.
#[derive(Args)]
pub struct Arguments {
    /// Compensation law, or several with + between them
    #[arg(long, value_name = "LAW", value_parser = LawParser)]
    compensator: Entry,
    /// Requirements (default: those of the lap weld)
    #[arg(long, value_name = "F")]
    requirements: Option<PathBuf>,
    /// Weld file; may be given several times (default: the first published sequence)
    #[arg(long, value_name = "F")]
    weld: Vec<PathBuf>,
    /// Trials of each weld
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = value_parser!(u64).range(..=100_000))]
    trials: u64,
    /// Show that a weld beyond any limit is rarer than P, by subset simulation: begun with the
    /// trials, 100 at least, and with as many runs a level
    #[arg(long, value_name = "P", value_parser = parse_probability)]
    failure_probability: Option<f64>,
    /// Runs of the search for the worst cell, of each weld
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = value_parser!(u32).range(..=10_000))]
    worst: u32,
    /// Welds of one seam in a trial, the law kept; the last one counts
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = passes())]
    passes: u32,
    /// Seed of the draws (default: follows from files and options)
    #[arg(long, value_name = "N")]
    draws: Option<u64>,
    /// Hybrid force/position controller
    #[arg(long, value_enum, default_value_t = Controller::External)]
    controller: Controller,
    #[command(flatten)]
    cell: CellFiles,
    /// Evidence folder
    #[arg(long, value_name = "FOLDER", default_value = "out/certify")]
    evidence: PathBuf,
    /// Make the trials with what the requirements assume of measured numbers as well, to show what the
    /// measurement brought
    #[arg(long, conflicts_with_all = ["shard", "merge"])]
    compare_assumed: bool,
    /// Make part I of N of the runs, in an evidence folder of its own; no certificate yet
    #[arg(long, value_name = "I/N", conflicts_with = "merge")]
    shard: Option<Shard>,
    /// Put shards together that were made with the same options, and do what is left
    #[arg(long, value_name = "FOLDER", num_args = 1..)]
    merge: Vec<PathBuf>,
    /// Make every run that is kept again, not only one in twenty: each must come out as it was kept
    #[arg(long)]
    verify: bool,
    #[command(flatten)]
    results: Results,
}

fn parse_probability(text: &str) -> Result<f64, String> {
    let probability: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    if (1e-9..0.5).contains(&probability) {
        Ok(probability)
    } else {
        Err("expected a probability from 1e-9 to below 0.5".to_owned())
    }
}

/// Runs the command. A law that fails, or that so few runs do not show to pass, ends the program
/// with status 1.
pub fn run(arguments: &Arguments) -> Result<()> {
    let (folder, results) = (&arguments.evidence, &arguments.results);
    check_new_folder("--evidence", folder)?;
    if let (Some(shard), Some((flag, _))) = (arguments.shard, results.outputs().first()) {
        return Err(miette!(
            "{flag}: shard {shard} has no result yet; expected this option with --merge"
        ));
    }
    check_targets(&results.outputs())?;
    let fewest = FEWEST_DRAWS as u64;
    if arguments.failure_probability.is_some() && arguments.trials < fewest {
        return Err(miette!(
            help = "Its first level are the trials, and every later one has as many: some 400 show 1e-4.",
            "--failure-probability: {} trials are too few to begin with; expected --trials {fewest} or more",
            arguments.trials
        ));
    }
    let mut files = Vec::new();
    let requirements: Requirements = read(arguments.requirements.as_deref(), &mut files)?;
    // Everything is read and judged usable before the first run.
    let inputs = inputs(arguments)?;
    let Inputs { robot, planned, sensors, .. } = &inputs[0];
    let assumed = requirements.uncertain_cell(robot, planned, sensors).map_err(|error| {
        miette!(help = "Numbers in [[uncertain]] are of the cell that is certified.", "{error}")
    })?;
    let measured = inputs[0].measured(&assumed)?;
    if arguments.compare_assumed && measured.is_none() {
        return Err(miette!(
            help = "`improve` writes what it measured into the model file, as [posterior].",
            "--compare-assumed: nothing of this cell is measured; expected --model with a posterior"
        ));
    }
    let uncertain = measured.as_ref().unwrap_or(&assumed);
    let seed = seed_of_inputs(&provenance(arguments, &inputs[0], &files))?;
    let asked = Asked {
        requirements: &requirements,
        uncertain,
        assumed: arguments.compare_assumed.then_some(&assumed),
        seed: arguments.draws.unwrap_or(seed),
    };
    let mut campaigns = inputs
        .iter()
        .map(|inputs| WeldSetup::new(arguments, asked, &files, inputs).and_then(WeldCampaign::open))
        .collect::<Result<Vec<_>>>()?;
    let mut provenance = campaigns[0].setup.provenance.clone();
    for campaign in &campaigns[1..] {
        provenance.join(&campaign.setup.provenance);
    }
    shard::check_folder(folder, arguments.shard)?;
    if !arguments.merge.is_empty() {
        let shards = Shards::read(&arguments.merge, &provenance, arguments.trials)?;
        campaigns.iter_mut().try_for_each(|campaign| campaign.take(&shards))?;
    }
    let kept: usize = campaigns.iter().map(|campaign| campaign.kept.kept()).sum();
    if arguments.verify && kept == 0 {
        let folder = folder.display();
        return Err(miette!("--verify: {folder} holds no run; expected an evidence folder"));
    }
    std::fs::create_dir_all(folder)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot create {}", folder.display()))?;
    let [certificate, page] = ["certify.json", "certify.html"].map(|name| folder.join(name));
    let sections: Vec<PathBuf> = inputs
        .iter()
        .flat_map(|inputs| SECTIONS.map(|s| section_file(folder, s, &inputs.weld_name)))
        .collect();
    let compared = inputs.iter().filter(|_| arguments.compare_assumed);
    let compared: Vec<PathBuf> =
        compared.map(|inputs| section_file(folder, ASSUMED, &inputs.weld_name)).collect();
    let mut outputs: Vec<(&str, &Path)> = sections
        .iter()
        .chain(&compared)
        .chain([&certificate, &page])
        .map(|path| ("--evidence", path.as_path()))
        .collect();
    outputs.extend(results.outputs());
    check_outputs(&outputs)?;
    if let Some(shard) = arguments.shard {
        shard::begin(folder)?;
        let made = campaigns
            .into_iter()
            .map(|campaign| campaign.run_shard(shard))
            .sum::<Result<usize>>()?;
        shard.finish(folder, &written(&sections), provenance, arguments.trials)?;
        say!("shard {shard}: {made} runs in {}\n", folder.display());
        return Ok(());
    }
    let welds = campaigns.into_iter().map(WeldCampaign::run).collect::<Result<Vec<_>>>()?;
    let (welds, repeated): (Vec<_>, Vec<usize>) = welds.into_iter().unzip();
    let report = CertifyReport {
        law: arguments.compensator.name().to_owned(),
        controller: arguments.controller.controller().name(),
        passes: arguments.passes as usize,
        seed: asked.seed,
        seed_given: asked.seed != seed,
        asked: [requirements.failure_probability, requirements.confidence],
        welds,
        uncertain,
        robot_grade: inputs[0].robot_grade()?,
        repeat: repeat::command_line("certify", &ONLY_HERE),
        kept: written(&sections).iter().map(|file| shard::digest(file)).collect::<Result<_>>()?,
        provenance: &provenance,
    };
    write_file(&certificate, report.json_text())?;
    results.write(&report)?;
    write(&page, &report.page())?;
    if kept > 0 {
        let repeated: usize = repeated.iter().sum();
        say!("{repeated} of {kept} kept runs were made again, and came out as they were kept\n");
    }
    if report.verdict() != Verdict::Pass {
        std::process::exit(1);
    }
    Ok(())
}

/// Options that do not change what is certified: where runs are made and kept, and what is written.
const ONLY_HERE: [&str; 8] =
    ["evidence", "shard", "merge", "verify", "json", "html", "samples", "quiet"];

/// The sections that there are: not every certification has all of them.
fn written(sections: &[PathBuf]) -> Vec<PathBuf> {
    sections.iter().filter(|file| file.exists()).cloned().collect()
}

/// The cell with each of the welds. Evidence is named after the weld: two of one name would share it.
fn inputs(arguments: &Arguments) -> Result<Vec<Inputs>> {
    let files: Vec<Option<&Path>> = match arguments.weld.as_slice() {
        [] => vec![None],
        files => files.iter().map(|f| Some(f.as_path())).collect(),
    };
    let inputs =
        files.into_iter().map(|f| arguments.cell.read(f)).collect::<Result<Vec<Inputs>>>()?;
    for (k, one) in inputs.iter().enumerate() {
        if let Some(other) = inputs[..k].iter().find(|other| other.weld_name == one.weld_name) {
            return Err(miette!(
                help = "Evidence and results are named after the weld file: give one of them another name.",
                "--weld {} and --weld {}: two welds of the name {}; expected each weld once, by a name of its own",
                other.weld_file,
                one.weld_file,
                one.weld_name
            ));
        }
    }
    Ok(inputs)
}

/// One weld that is to be certified.
struct WeldCampaign<'a> {
    setup: WeldSetup<'a>,
    kept: EvidenceFiles,
}

/// What is asked of every weld, and what is not known of the cell.
#[derive(Clone, Copy)]
struct Asked<'a> {
    requirements: &'a Requirements,
    uncertain: &'a UncertainCell,
    /// The same without what was measured, where both are to be compared.
    assumed: Option<&'a UncertainCell>,
    /// Of the draws.
    seed: u64,
}

/// What the runs of a weld are made from.
struct WeldSetup<'a> {
    arguments: &'a Arguments,
    asked: Asked<'a>,
    /// As they are asked of this weld.
    requirements: Requirements,
    inputs: &'a Inputs,
    scenario: Scenario<'a>,
    provenance: Provenance,
    /// Digest of the inputs.
    key: String,
    needed: RequiredCorrection,
}

/// What the runs of a weld are of, but for the seed of the draws. `files`: read for all welds.
fn provenance(arguments: &Arguments, inputs: &Inputs, files: &[FileDigest]) -> Provenance {
    let (controller, law) = (arguments.controller.controller(), &arguments.compensator);
    let passes = arguments.passes as usize;
    let mut simulation =
        inputs.simulation(&[controller], slice::from_ref(law), passes, STEP_OF_MANY);
    simulation.cores = inputs.cores(controller, law);
    let mut provenance = inputs.provenance("certify", simulation);
    provenance.files.extend_from_slice(files);
    provenance
}

/// SHA-256 of every input that runs depend on: options and bytes of files, wherever these lie.
pub fn digest_of_inputs(provenance: &Provenance) -> Result<String> {
    let mut of = provenance.clone();
    of.files.iter_mut().for_each(|file| file.file.clear());
    // Warnings follow from the files, and name their paths; of the program the sources count.
    of.warnings.clear();
    of.version.clear();
    of.sources.clear();
    Ok(sha256(serde_json::to_string(&of).into_diagnostic()?.as_bytes()))
}

/// The seed of the draws that follows from the inputs. Welds are left out: all meet the same cells,
/// whichever are certified together. So are trials and runs of search: there may be more later.
fn seed_of_inputs(provenance: &Provenance) -> Result<u64> {
    let mut of = provenance.clone();
    of.files.retain(|file| file.role != FileKind::Weld.name());
    if let Some(simulation) = &mut of.simulation {
        simulation.welds.clear();
        simulation.cores.clear();
    }
    // Short enough to be typed after --draws.
    u64::from_str_radix(&digest_of_inputs(&of)?[..8], 16).into_diagnostic()
}

/// The sections of a weld's evidence.
const SECTIONS: [&str; 5] = ["nominal", "trials", "rare", "worst", "faults"];

/// The section of trials with what is assumed of measured numbers.
const ASSUMED: &str = "assumed";

/// The file of a section of a weld.
fn section_file(folder: &Path, section: &str, weld: &str) -> PathBuf {
    folder.join(format!("{section}-{weld}.jsonl"))
}

/// The runs that are kept of a weld.
struct EvidenceFiles {
    nominal: TrialStore<Trial>,
    trials: TrialStore<Trial>,
    rare: TrialStore<Trial>,
    worst: TrialStore<Trial>,
    faults: TrialStore<FaultTrial>,
}

impl EvidenceFiles {
    fn open(folder: &Path, weld: &str, basis: Basis<'_>, repeat: Repeat) -> Result<Self> {
        let [nominal, trials, rare, worst, faults] =
            SECTIONS.map(|s| section_file(folder, s, weld));
        Ok(Self {
            nominal: TrialStore::open(nominal, basis, repeat)?,
            trials: TrialStore::open(trials, basis, repeat)?,
            rare: TrialStore::open(rare, basis, repeat)?,
            worst: TrialStore::open(worst, basis, repeat)?,
            faults: TrialStore::open(faults, basis, repeat)?,
        })
    }

    /// How many runs are kept.
    fn kept(&self) -> usize {
        let welds = self.nominal.kept() + self.trials.kept() + self.rare.kept();
        welds + self.worst.kept() + self.faults.kept()
    }

    /// How many kept runs were made again so far, and came out as they were kept.
    fn repeated(&self) -> usize {
        let welds = self.nominal.repeated() + self.trials.repeated() + self.rare.repeated();
        welds + self.worst.repeated() + self.faults.repeated()
    }

    /// How many welds without a fault need not be made again.
    fn welds(&self) -> usize {
        self.nominal.count() + self.trials.count() + self.rare.count() + self.worst.count()
    }

    /// `rare`: whether rare failures were asked for.
    fn close(self, rare: bool) -> Result<()> {
        self.nominal.close()?;
        self.trials.close()?;
        if rare {
            self.rare.close()?;
        }
        self.worst.close()?;
        self.faults.close()
    }
}

impl<'a> WeldSetup<'a> {
    /// Finds out whether the law can be built and the weld be made. `files`: read for all welds.
    fn new(
        arguments: &'a Arguments,
        asked: Asked<'a>,
        files: &[FileDigest],
        inputs: &'a Inputs,
    ) -> Result<Self> {
        let (controller, law) = (arguments.controller.controller(), &arguments.compensator);
        let requirements = inputs.asked(asked.requirements, files)?;
        let mut provenance = provenance(arguments, inputs, files);
        if let Some(simulation) = &mut provenance.simulation {
            simulation.draws_seed = Some(asked.seed);
        }
        let key = digest_of_inputs(&provenance)?;
        let scenario = Scenario {
            plant_step: STEP_OF_MANY,
            ..inputs.scenario(WeldProgram::Weld, controller, law)
        };
        let failed = |error: RunError| inputs.failed(controller, &error);
        scenario.build_law().map_err(failed)?;
        let cell = inputs.nominal(asked.uncertain);
        let drawn = SampledCell::new(asked.uncertain, asked.seed, 0);
        cell.build(&drawn, &inputs.planned, &inputs.weld).map_err(failed)?;
        let needed = RequiredCorrection::of(&scenario, &cell)
            .map_err(failed)?
            .ok_or_else(|| inputs.too_short())?;
        Ok(Self { arguments, asked, requirements, inputs, scenario, provenance, key, needed })
    }

    fn certification(&self) -> Certification<'_> {
        Certification {
            scenario: self.scenario,
            cell: self.inputs.nominal(self.asked.uncertain),
            requirements: &self.requirements,
            needed: &self.needed,
            passes: self.arguments.passes as usize,
            seed: self.asked.seed,
        }
    }

    /// The same of a cell of which only this is assumed, and its trials.
    fn assumed<'c>(
        &'c self,
        uncertain: &'c UncertainCell,
    ) -> Result<(Certification<'c>, TrialStore<Trial>)> {
        let path = section_file(&self.arguments.evidence, ASSUMED, &self.inputs.weld_name);
        let cell = self.inputs.nominal(uncertain);
        let certification = Certification { cell, ..self.certification() };
        Ok((certification, TrialStore::open(path, self.basis(), self.repeat())?))
    }

    /// What kept runs must be of.
    fn basis(&self) -> Basis<'_> {
        Basis { inputs: &self.key, sources: &self.provenance.sources }
    }

    /// Which of them are made again.
    fn repeat(&self) -> Repeat {
        if self.arguments.verify { Repeat::All } else { Repeat::Sample }
    }

    /// The runs that a folder keeps of this weld.
    fn kept(&self, folder: &Path) -> Result<EvidenceFiles> {
        EvidenceFiles::open(folder, &self.inputs.weld_name, self.basis(), self.repeat())
    }

    /// The runs that depend on no other; the search for the worst cell needs all of them.
    fn jobs(&self) -> Result<Jobs> {
        let faults = self.certification().faults().map_err(|error| match error {
            FaultsRefused::TooShort { .. } => miette!(
                help = "Expected a longer seam, or shorter duration_s and recovery_s in [faults].",
                "{}: {error}",
                self.inputs.weld_file
            ),
            FaultsRefused::NoLimit { .. } => {
                let is_it = |file: &&FileDigest| file.role == FileKind::Requirements.name();
                let file = self.provenance.files.iter().find(is_it);
                let file = file.map_or("the requirements", |file| file.file.as_str());
                miette!("{file}: {error}")
            }
        })?;
        Ok(Jobs { nominal: vec![()], faults, trials: (0..self.arguments.trials).collect() })
    }

    /// A bar of these jobs and so many runs beside them, without those that are kept.
    fn meter(&self, jobs: &Jobs, more: usize, kept: &EvidenceFiles) -> Meter {
        let certification = self.certification();
        let trials = jobs.trials.len().max(kept.trials.kept());
        let welds = jobs.nominal.len() + trials + more;
        let faults: f64 = jobs.faults.iter().map(|case| certification.cost(case)).sum();
        let of_kept = faults / jobs.faults.len().max(1) as f64 * kept.faults.count() as f64;
        let missing = welds.saturating_sub(kept.welds()) as f64 + faults - of_kept;
        Meter::new(&self.arguments.results, missing)
    }
}

/// Runs that depend on no other run, in their order.
struct Jobs {
    nominal: Vec<()>,
    faults: Vec<FaultCase>,
    trials: Vec<u64>,
}

fn is_nominal((): &(), _: &Trial) -> bool {
    true
}

fn is_fault(case: &FaultCase, run: &FaultTrial) -> bool {
    run.is_of(case)
}

fn is_trial(index: &u64, run: &Trial) -> bool {
    run.index == *index
}

/// What the jobs came to.
struct Done {
    nominal: Vec<Trial>,
    faults: Vec<FaultTrial>,
    trials: Vec<Trial>,
}

impl EvidenceFiles {
    /// The runs of these jobs: those that are kept, and the missing ones.
    fn complete(
        &mut self,
        jobs: &Jobs,
        certification: &Certification<'_>,
        meter: &Meter,
    ) -> Result<Done> {
        let nominal = self.nominal.complete(&jobs.nominal, is_nominal, |()| {
            meter.count("nominal", 1.0, certification.nominal())
        })?;
        let faults = self.faults.complete(&jobs.faults, is_fault, |case| {
            meter.count("faults", certification.cost(case), certification.run_fault(case))
        })?;
        let trials = self.trials.complete(&jobs.trials, is_trial, |index| {
            meter.count("draws", 1.0, certification.trial(*index))
        })?;
        Ok(Done { nominal, faults, trials })
    }
}

impl<'a> WeldCampaign<'a> {
    /// Reads what is kept of a weld, whose runs can all be made.
    fn open(setup: WeldSetup<'a>) -> Result<Self> {
        setup.jobs()?;
        let kept = setup.kept(&setup.arguments.evidence)?;
        Ok(Self { setup, kept })
    }

    /// Takes over the runs of shards.
    fn take(&mut self, shards: &Shards) -> Result<()> {
        let Self { setup, kept } = self;
        let jobs = setup.jobs()?;
        let weld = &setup.inputs.weld_name;
        let (mut nominal, mut faults, mut trials) = (Vec::new(), Vec::new(), Vec::new());
        for folder in shards.folders() {
            let files = setup.kept(folder)?;
            nominal.push(files.nominal);
            faults.push(files.faults);
            trials.push(files.trials);
        }
        let lacks = |shard: usize| shards.lacks(shard, weld);
        kept.nominal.merge(&jobs.nominal, &nominal, is_nominal).map_err(lacks)?;
        kept.faults.merge(&jobs.faults, &faults, is_fault).map_err(lacks)?;
        kept.trials.merge(&jobs.trials, &trials, is_trial).map_err(lacks)
    }

    /// The runs of one shard; how many there are.
    fn run_shard(self, shard: Shard) -> Result<usize> {
        let Self { setup, mut kept } = self;
        let Jobs { nominal, faults, trials } = setup.jobs()?;
        let jobs = Jobs {
            nominal: shard.part(nominal),
            faults: shard.part(faults),
            trials: shard.part(trials),
        };
        let meter = setup.meter(&jobs, 0, &kept);
        let done = kept.complete(&jobs, &setup.certification(), &meter)?;
        meter.finish();
        kept.close(false)?;
        Ok(done.nominal.len() + done.faults.len() + done.trials.len())
    }

    /// Every run: those that are kept, and the missing ones; how many kept ones were made again.
    fn run(self) -> Result<(CertifiedWeld, usize)> {
        let Self { setup, mut kept } = self;
        let WeldSetup { arguments, asked, inputs, ref requirements, .. } = setup;
        let Asked { uncertain, assumed, .. } = asked;
        let certification = setup.certification();
        let budget = arguments.worst as usize;
        let jobs = setup.jobs()?;
        // Of every level but the first nine tenths are new; the next one's cells are a tenth as rare.
        let levels = arguments.failure_probability.map_or(0.0, |p| (-p.log10()).ceil());
        let rare = (0.9 * levels * arguments.trials as f64) as usize;
        let compared = assumed.map(|cell| setup.assumed(cell)).transpose()?;
        let more = compared.as_ref().map_or(0, |(_, store)| {
            jobs.trials.len().max(kept.trials.kept()).saturating_sub(store.count())
        });
        let meter = setup.meter(&jobs, budget + rare + more, &kept);
        // First: where they cannot be determined, no run is made for nothing.
        meter.progress.stage("margins", 0.0);
        let controller = setup.scenario.controller;
        let margins = certification.margins().map_err(|error| inputs.failed(controller, &error))?;
        let Done { nominal, faults, mut trials } = kept.complete(&jobs, &certification, &meter)?;
        let nominal =
            nominal.into_iter().next().ok_or_else(|| miette!("the nominal run is missing"))?;
        let trial = |index: &u64| meter.count("draws", 1.0, certification.trial(*index));
        trials.extend(kept.trials.others(|trial| trial.index, is_trial, trial)?);
        trials.sort_by_key(|trial| trial.index);
        trials.dedup_by_key(|trial| trial.index);
        let is = |(index, draw): &(u64, _), run: &Trial| run.index == *index && run.draw == *draw;
        let seed = asked.seed;
        let rare = arguments.failure_probability.map(|allowed| {
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
            search(requirements, uncertain, seed, &nominal, &trials, budget, |batch| {
                kept.worst.complete(batch, is, searching)
            })?;
        let job = |run: &Trial| (run.index, run.draw.clone());
        searched.extend(kept.worst.others(job, is, searching)?);
        let compared = match compared {
            Some((certification, mut store)) => {
                let indices: Vec<u64> = trials.iter().map(|trial| trial.index).collect();
                let trials = store.complete(&indices, is_trial, |index| {
                    meter.count("assumed", 1.0, certification.trial(*index))
                })?;
                store.close()?;
                Some(AssumedDraws { requirements: draws(requirements, &trials), trials })
            }
            None => None,
        };
        meter.finish();
        let repeated = kept.repeated();
        kept.close(arguments.failure_probability.is_some())?;
        let worst = WorstCase::among(requirements, &nominal, &trials, searched);
        let evidence = Evidence { nominal, trials, rare, worst, margins, faults };
        let held = asked.requirements.held(requirements);
        let accepted_faults = accepted_faults(requirements, &evidence.faults);
        let requirements = judge(requirements, &evidence);
        let weld = CertifiedWeld {
            name: inputs.weld_name.clone(),
            held,
            planned: WeldPlan::of(&inputs.weld, &inputs.planned),
            sensitivities: sensitivities(uncertain, &requirements, &evidence),
            weak_points: weak_points(&requirements, &evidence.margins),
            shown: certification.shown(&evidence, &requirements),
            evidence,
            requirements,
            accepted_faults,
            assumed: compared,
        };
        Ok((weld, repeated))
    }
}

/// How much of the missing runs of a weld is made, in welds without a fault.
struct Meter {
    progress: Progress,
    made: Mutex<f64>,
    of: f64,
}

impl Meter {
    fn new(results: &Results, of: f64) -> Self {
        Self { progress: results.progress("certifying", of), made: Mutex::new(0.0), of }
    }

    /// Counts a run that was just made.
    fn count<R>(&self, section: &str, cost: f64, run: R) -> R {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        *made += cost;
        self.progress.stage(section, *made / self.of.max(1.0));
        run
    }

    fn finish(self) {
        self.progress.finish();
    }
}
