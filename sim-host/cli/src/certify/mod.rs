//! `trueweld certify`: many welds of uncertain cells, and what they prove of a compensation law.
//!
//! Runs are kept one a line in the evidence folder as they come; the command given again goes on
//! where it was stopped.

mod kept;

use crate::inputs::{CellFiles, Inputs, STEP_OF_MANY, embedded};
use crate::names::{Compensator, Controller};
use crate::results::{check_outputs, write};
use clap::Args;
use kept::TrialStore;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use trueweld_evaluate::certify::{
    Certification, Evidence, FaultTrial, RequiredCorrection, Trial, judge, search,
};
use trueweld_output::{Certified, CertifiedWeld, Input, Progress, html, write_file};
use trueweld_plant::input::Requirements;
use trueweld_plant::simulate::{BuildLaw, Program, RunError, Scenario, Seam};

/// Arguments of `certify`.
#[derive(Args)]
pub struct Arguments {
    /// Compensation law
    #[arg(long, value_enum)]
    compensator: Compensator,
    /// Requirements (default: those of the lap weld)
    #[arg(long, value_name = "F")]
    requirements: Option<PathBuf>,
    /// Weld file; may be given several times (default: the first published sequence)
    #[arg(long, value_name = "F")]
    weld: Vec<PathBuf>,
    /// Trials of each weld
    #[arg(long, value_name = "N", default_value_t = 100)]
    trials: u64,
    /// Runs of the search for the worst cell, of each weld
    #[arg(long, value_name = "N", default_value_t = 60)]
    worst: usize,
    /// Welds of one seam in a trial, the law kept; the last one counts
    #[arg(long, value_name = "N", default_value_t = 1)]
    passes: usize,
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

/// Runs the command. A law that fails ends the program with status 1.
pub fn run(arguments: &Arguments) -> Result<()> {
    let requirements =
        embedded!(Requirements, arguments.requirements.as_deref(), "requirements/lap-weld.toml");
    if requirements.limits.iter().all(Option::is_none) {
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
    let files: Vec<Option<&Path>> = match arguments.weld.as_slice() {
        [] => vec![None],
        files => files.iter().map(|f| Some(f.as_path())).collect(),
    };
    let mut inputs_said = vec![digest("requirements", &requirements)];
    let mut welds = Vec::new();
    for file in files {
        let inputs = arguments.cell.read(file)?;
        check_outputs(&outputs)?;
        let parts = [
            digest(&format!("weld {}", inputs.weld_name), &inputs.weld),
            digest("robot", inputs.robot.robot.parameters()),
            digest("process", &inputs.planned),
            digest("control", &inputs.control),
            digest("sensors", &inputs.sensors),
            digest("belief", inputs.controller_model.parameters()),
        ];
        for part in &parts {
            if !inputs_said.contains(part) {
                inputs_said.push(part.clone());
            }
        }
        let law = arguments.compensator.law();
        let key = digest(
            "trials",
            &(
                &parts,
                &requirements,
                law.name(),
                arguments.passes,
                arguments.draws,
                env!("CARGO_PKG_VERSION"),
            ),
        );
        welds.push(weld(arguments, &requirements, &inputs, &key.sha256)?);
    }
    let certified = Certified {
        law: arguments.compensator.law().name(),
        controller: arguments.controller.controller().name(),
        passes: arguments.passes,
        seed: arguments.draws,
        asked: [requirements.failure_probability, requirements.confidence],
        welds,
        inputs: inputs_said,
        version: env!("CARGO_PKG_VERSION"),
    };
    let text = serde_json::to_string_pretty(&certified.json()).into_diagnostic()? + "\n";
    say!("{}", certified.text());
    write_file(&certificate, &text)?;
    write(&page, &html::certify_page(&certified))?;
    if let Some(path) = &arguments.json {
        write(path, &text)?;
    }
    if !certified.passes() {
        std::process::exit(1);
    }
    Ok(())
}

/// Every run of one weld: those that are there, and the missing ones.
fn weld(
    arguments: &Arguments,
    requirements: &Requirements,
    inputs: &Inputs,
    key: &str,
) -> Result<CertifiedWeld> {
    let scenario = Scenario {
        plant_step: STEP_OF_MANY,
        ..inputs.scenario(
            Program::Weld,
            arguments.controller.controller(),
            arguments.compensator.law(),
        )
    };
    let robot = &inputs.robot.robot;
    let failed = |error: RunError| inputs.failed(scenario.controller, &error);
    scenario
        .law
        .build(scenario.control, scenario.sensors, Seam::of(scenario.weld).length)
        .map_err(failed)?;
    let needed = RequiredCorrection::of(&scenario, robot).map_err(failed)?.ok_or_else(|| {
        miette!(
            help =
                "Expected a seam long enough for the feed to rise and settle: a few centimetres.",
            "{}: the weld is too short to reach its steady part",
            inputs.weld_file
        )
    })?;
    let passes = arguments.passes.max(1);
    let certification = Certification {
        scenario,
        robot,
        requirements,
        needed: &needed,
        passes,
        seed: arguments.draws,
    };
    let cases = certification.faults().map_err(|error| {
        miette!(
            help = "Expected a longer seam, or shorter duration_s and recovery_s in [faults].",
            "{}: {error}",
            inputs.weld_file
        )
    })?;
    let file =
        |section: &str| arguments.evidence.join(format!("{section}-{}.jsonl", inputs.weld_name));
    let mut nominal = TrialStore::<Trial>::open(file("nominal"), key)?;
    let mut trials = TrialStore::<Trial>::open(file("trials"), key)?;
    let mut worst = TrialStore::<Trial>::open(file("worst"), key)?;
    let mut faults = TrialStore::<FaultTrial>::open(file("faults"), key)?;
    let there = nominal.count() + trials.count() + worst.count() + faults.count();
    let all = 1 + arguments.trials as usize + arguments.worst + cases.len();
    let meter = Meter::new(arguments.quiet, all.saturating_sub(there));

    let nominals = nominal.complete(
        &[()],
        |(), _| true,
        |()| meter.count("nominal", certification.nominal()),
    )?;
    let struck = faults.complete(
        &cases,
        |case, run| run.fault == case.to_string(),
        |case| meter.count("faults", certification.run_fault(case)),
    )?;
    let indices: Vec<u64> = (0..arguments.trials).collect();
    let drawn = trials.complete(
        &indices,
        |index, run| run.index == *index,
        |index| meter.count("draws", certification.trial(*index)),
    )?;
    let found = search(requirements, arguments.draws, &drawn, arguments.worst, |batch| {
        let is = |(index, draw): &(u64, _), run: &Trial| run.index == *index && run.draw == *draw;
        worst.complete(batch, is, |(index, draw)| {
            meter.count("worst case", certification.weld(*index, *draw))
        })
    })?;
    meter.finish();
    nominal.close()?;
    trials.close()?;
    worst.close()?;
    faults.close()?;
    let nominal =
        nominals.into_iter().next().ok_or_else(|| miette!("the nominal run is missing"))?;
    let margins = certification.margins().map_err(failed)?;
    let evidence = Evidence { nominal, trials: drawn, worst: found, margins, faults: struck };
    let requirements = judge(requirements, &evidence);
    Ok(CertifiedWeld { name: inputs.weld_name.clone(), evidence, requirements })
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

/// The digest of a value as it was read.
fn digest(what: &str, value: &impl std::fmt::Debug) -> Input {
    let digest = Sha256::digest(format!("{value:?}"));
    Input { what: what.to_owned(), sha256: digest.iter().map(|b| format!("{b:02x}")).collect() }
}
