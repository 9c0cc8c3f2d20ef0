//! `trueweld certify`: many welds of uncertain cells, and what they prove of a compensation law.
//!
//! Runs are kept one a line in the evidence folder as they come; the command given again goes on
//! where it was stopped.

mod store;

use crate::inputs::{CellFiles, Inputs, STEP_OF_MANY, passes, read};
use crate::names::{Controller, LawParser};
use crate::results::{check_outputs, write};
use clap::{Args, value_parser};
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::path::{Path, PathBuf};
use std::slice;
use std::sync::atomic::{AtomicUsize, Ordering};
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
    /// Write the result as JSON to this file as well
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// No progress bar
    #[arg(long, short)]
    quiet: bool,
}

/// Runs the command. A law that fails, or that so few runs do not show to pass, ends the program
/// with status 1.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut files = Vec::new();
    let requirements: Requirements = read(arguments.requirements.as_deref(), &mut files)?;
    if requirements.limits.is_empty() {
        return Err(miette!(
            "the requirements limit nothing; expected at least one key in [limits]"
        ));
    }
    let folder = &arguments.evidence;
    std::fs::create_dir_all(folder)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot create {}", folder.display()))?;
    let [certificate, page] = ["certify.json", "certify.html"].map(|name| folder.join(name));
    let mut outputs = vec![("--evidence", certificate.as_path()), ("--evidence", page.as_path())];
    outputs.extend(arguments.json.as_deref().map(|path| ("--json", path)));
    // Everything is read and judged usable before the first run.
    let inputs = inputs(arguments)?;
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
    let text = report.json_text();
    say!("{}", report.text());
    write_file(&certificate, &text)?;
    write(&page, &report.page())?;
    if let Some(path) = &arguments.json {
        write(path, &text)?;
    }
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

/// The runs that are kept of a weld.
struct EvidenceFiles {
    nominal: TrialStore<Trial>,
    trials: TrialStore<Trial>,
    worst: TrialStore<Trial>,
    faults: TrialStore<FaultTrial>,
}

impl EvidenceFiles {
    fn open(folder: &Path, weld: &str, key: &str) -> Result<Self> {
        let file = |section: &str| folder.join(format!("{section}-{weld}.jsonl"));
        Ok(Self {
            nominal: TrialStore::open(file("nominal"), key)?,
            trials: TrialStore::open(file("trials"), key)?,
            worst: TrialStore::open(file("worst"), key)?,
            faults: TrialStore::open(file("faults"), key)?,
        })
    }

    /// How many runs need not be made again.
    fn count(&self) -> usize {
        self.nominal.count() + self.trials.count() + self.worst.count() + self.faults.count()
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
        let all = 1 + arguments.trials as usize + budget + cases.len();
        let meter = Meter::new(arguments.quiet, all.saturating_sub(kept.count()));

        let nominals = kept.nominal.complete(
            &[()],
            |(), _| true,
            |()| meter.count("nominal", certification.nominal()),
        )?;
        let faults = kept.faults.complete(
            &cases,
            |case, run| run.fault == case.to_string(),
            |case| meter.count("faults", certification.run_fault(case)),
        )?;
        let indices: Vec<u64> = (0..arguments.trials).collect();
        let trials = kept.trials.complete(
            &indices,
            |index, run| run.index == *index,
            |index| meter.count("draws", certification.trial(*index)),
        )?;
        let worst = search(requirements, arguments.draws, &trials, budget, |batch| {
            let is =
                |(index, draw): &(u64, _), run: &Trial| run.index == *index && run.draw == *draw;
            kept.worst.complete(batch, is, |(index, draw)| {
                meter.count("worst case", certification.weld(*index, *draw))
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

/// How many of the missing runs of a weld are made.
struct Meter {
    progress: Progress,
    made: AtomicUsize,
    of: usize,
}

impl Meter {
    fn new(quiet: bool, of: usize) -> Self {
        let progress =
            if quiet { Progress::silent() } else { Progress::new("certifying", of as f64) };
        Self { progress, made: AtomicUsize::new(0), of }
    }

    /// Counts a run that was just made.
    fn count<R>(&self, section: &str, run: R) -> R {
        let made = self.made.fetch_add(1, Ordering::Relaxed) + 1;
        self.progress.stage(section, made as f64 / self.of.max(1) as f64);
        run
    }

    fn finish(self) {
        self.progress.finish();
    }
}
