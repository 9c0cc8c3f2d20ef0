//! `trueweld certify`: many welds of uncertain cells, and what they prove of a compensation law.
//!
//! Runs are kept one a line in the evidence folder as they come; the command given again goes on
//! where it was stopped.

mod store;

use crate::inputs::{CellFiles, Inputs, STEP_OF_MANY, passes, read};
use crate::names::{Controller, LawParser};
use crate::results::{Results, check_new_folder, check_outputs, check_targets, write};
use clap::{Args, value_parser};
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::path::{Path, PathBuf};
use std::slice;
use std::sync::{Mutex, PoisonError};
use store::TrialStore;
use trueweld_compensators::Entry;
use trueweld_evaluate::Requirements;
use trueweld_evaluate::certify::{
    Certification, Evidence, FaultTrial, RequiredCorrection, Trial, Verdict, judge, search,
};
use trueweld_output::{CertifiedWeld, CertifyReport, Progress, Report, write_file};
use trueweld_plant::provenance::{FileDigest, Provenance, sha256};
use trueweld_plant::simulate::{Program, RunError, Scenario};

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
    /// Runs of the search for the worst cell, of each weld
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = value_parser!(u32).range(..=10_000))]
    worst: u32,
    /// Welds of one seam in a trial, the law kept; the last one counts
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = passes())]
    passes: u32,
    /// Seed of the draws
    #[arg(long, value_name = "N", default_value_t = 1)]
    draws: u64,
    /// Hybrid force/position controller
    #[arg(long, value_enum, default_value_t = Controller::External)]
    controller: Controller,
    #[command(flatten)]
    cell: CellFiles,
    /// Evidence folder
    #[arg(long, value_name = "FOLDER", default_value = "out/certify")]
    evidence: PathBuf,
    #[command(flatten)]
    results: Results,
}

/// Runs the command. A law that fails, or that so few runs do not show to pass, ends the program
/// with status 1.
pub fn run(arguments: &Arguments) -> Result<()> {
    let (folder, results) = (&arguments.evidence, &arguments.results);
    check_new_folder("--evidence", folder)?;
    check_targets(&results.outputs())?;
    let mut files = Vec::new();
    let requirements: Requirements = read(arguments.requirements.as_deref(), &mut files)?;
    if requirements.limits.is_empty() {
        return Err(miette!(
            "the requirements limit nothing; expected at least one key in [limits]"
        ));
    }
    let [certificate, page] = ["certify.json", "certify.html"].map(|name| folder.join(name));
    // Everything is read and judged usable before the first run.
    let inputs = inputs(arguments)?;
    std::fs::create_dir_all(folder)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot create {}", folder.display()))?;
    let of_weld = |inputs: &Inputs| SECTIONS.map(|s| section_file(folder, s, &inputs.weld_name));
    let evidence: Vec<PathBuf> =
        inputs.iter().flat_map(of_weld).chain([certificate.clone(), page.clone()]).collect();
    let mut outputs: Vec<(&str, &Path)> =
        evidence.iter().map(|path| ("--evidence", path.as_path())).collect();
    outputs.extend(results.outputs());
    check_outputs(&outputs)?;
    let campaigns = inputs
        .iter()
        .map(|inputs| WeldCampaign::open(arguments, &files, inputs))
        .collect::<Result<Vec<_>>>()?;
    let mut provenance = campaigns[0].provenance.clone();
    for campaign in &campaigns[1..] {
        provenance.join(&campaign.provenance);
    }
    let welds = campaigns
        .into_iter()
        .map(|campaign| campaign.run(arguments, &requirements))
        .collect::<Result<Vec<_>>>()?;
    let report = CertifyReport {
        law: arguments.compensator.name().to_owned(),
        controller: arguments.controller.controller().name(),
        passes: arguments.passes as usize,
        seed: arguments.draws,
        asked: [requirements.failure_probability, requirements.confidence],
        welds,
        provenance: &provenance,
    };
    write_file(&certificate, report.json_text())?;
    results.write(&report)?;
    write(&page, &report.page())?;
    if report.verdict() != Verdict::Pass {
        std::process::exit(1);
    }
    Ok(())
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
    inputs: &'a Inputs,
    scenario: Scenario<'a>,
    provenance: Provenance,
    needed: RequiredCorrection,
    kept: EvidenceFiles,
}

/// SHA-256 of everything that runs depend on: options and bytes of files, wherever these lie.
fn key(provenance: &Provenance) -> Result<String> {
    let mut of = provenance.clone();
    of.files.iter_mut().for_each(|file| file.file.clear());
    Ok(sha256(serde_json::to_string(&of).into_diagnostic()?.as_bytes()))
}

/// The sections of a weld's evidence.
const SECTIONS: [&str; 4] = ["nominal", "trials", "worst", "faults"];

/// The file of a section of a weld.
fn section_file(folder: &Path, section: &str, weld: &str) -> PathBuf {
    folder.join(format!("{section}-{weld}.jsonl"))
}

/// The runs that are kept of a weld.
struct EvidenceFiles {
    nominal: TrialStore<Trial>,
    trials: TrialStore<Trial>,
    worst: TrialStore<Trial>,
    faults: TrialStore<FaultTrial>,
}

impl EvidenceFiles {
    fn open(folder: &Path, weld: &str, key: &str) -> Result<Self> {
        let [nominal, trials, worst, faults] = SECTIONS.map(|s| section_file(folder, s, weld));
        Ok(Self {
            nominal: TrialStore::open(nominal, key)?,
            trials: TrialStore::open(trials, key)?,
            worst: TrialStore::open(worst, key)?,
            faults: TrialStore::open(faults, key)?,
        })
    }

    /// How many welds without a fault need not be made again.
    fn welds(&self) -> usize {
        self.nominal.count() + self.trials.count() + self.worst.count()
    }

    fn close(self) -> Result<()> {
        self.nominal.close()?;
        self.trials.close()?;
        self.worst.close()?;
        self.faults.close()
    }
}

impl<'a> WeldCampaign<'a> {
    /// Reads what is kept, and finds out whether the law can be built and the weld be made.
    /// `files`: read for all welds.
    fn open(arguments: &'a Arguments, files: &[FileDigest], inputs: &'a Inputs) -> Result<Self> {
        let (controller, law) = (arguments.controller.controller(), &arguments.compensator);
        let passes = arguments.passes as usize;
        let mut simulation =
            inputs.simulation(&[controller], slice::from_ref(law), passes, STEP_OF_MANY);
        simulation.draws_seed = Some(arguments.draws);
        let mut provenance = inputs.provenance("certify", simulation);
        provenance.files.extend_from_slice(files);
        let kept = EvidenceFiles::open(&arguments.evidence, &inputs.weld_name, &key(&provenance)?)?;
        let scenario = Scenario {
            plant_step: STEP_OF_MANY,
            ..inputs.scenario(Program::Weld, controller, law)
        };
        let failed = |error: RunError| inputs.failed(controller, &error);
        scenario.build_law().map_err(failed)?;
        let needed = RequiredCorrection::of(&scenario, &inputs.nominal())
            .map_err(failed)?
            .ok_or_else(|| inputs.too_short())?;
        Ok(Self { inputs, scenario, provenance, needed, kept })
    }

    /// Every run: those that are kept, and the missing ones.
    fn run(self, arguments: &Arguments, requirements: &Requirements) -> Result<CertifiedWeld> {
        let Self { inputs, scenario, needed, mut kept, .. } = self;
        let certification = Certification {
            scenario,
            cell: inputs.nominal(),
            requirements,
            needed: &needed,
            passes: arguments.passes as usize,
            seed: arguments.draws,
        };
        let cases = certification.faults().map_err(|error| {
            miette!(
                help = "Expected a longer seam, or shorter duration_s and recovery_s in [faults].",
                "{}: {error}",
                inputs.weld_file
            )
        })?;
        let budget = arguments.worst as usize;
        let welds = 1 + arguments.trials as usize + budget;
        let faults: f64 = cases.iter().map(|case| certification.cost(case)).sum();
        let of_kept = faults / cases.len().max(1) as f64 * kept.faults.count() as f64;
        let missing = welds.saturating_sub(kept.welds()) as f64 + faults - of_kept;
        let meter = Meter::new(&arguments.results, missing);

        let nominals = kept.nominal.complete(
            &[()],
            |(), _| true,
            |()| meter.count("nominal", 1.0, certification.nominal()),
        )?;
        let faults = kept.faults.complete(
            &cases,
            |case, run| run.fault == case.to_string(),
            |case| meter.count("faults", certification.cost(case), certification.run_fault(case)),
        )?;
        let indices: Vec<u64> = (0..arguments.trials).collect();
        let trials = kept.trials.complete(
            &indices,
            |index, run| run.index == *index,
            |index| meter.count("draws", 1.0, certification.trial(*index)),
        )?;
        let worst = search(requirements, arguments.draws, &trials, budget, |batch| {
            let is =
                |(index, draw): &(u64, _), run: &Trial| run.index == *index && run.draw == *draw;
            kept.worst.complete(batch, is, |(index, draw)| {
                meter.count("worst case", 1.0, certification.weld(*index, *draw))
            })
        })?;
        meter.finish();
        kept.close()?;
        let nominal =
            nominals.into_iter().next().ok_or_else(|| miette!("the nominal run is missing"))?;
        let margins =
            certification.margins().map_err(|error| inputs.failed(scenario.controller, &error))?;
        let evidence = Evidence { nominal, trials, worst, margins, faults };
        let requirements = judge(requirements, &evidence);
        Ok(CertifiedWeld { name: inputs.weld_name.clone(), evidence, requirements })
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
