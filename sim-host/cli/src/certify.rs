//! `trueweld certify`: many welds of uncertain cells, and what they prove of a compensation law.
//!
//! Trials are kept one a line in the evidence folder as they come; the command given again goes on where it was stopped.

use crate::inputs::{CellFiles, Inputs, embedded};
use crate::names::{Compensator, Controller};
use crate::results::may_be_written;
use clap::Args;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use trueweld_evaluate::certify::{Certification, Trial, judge};
use trueweld_output::{Certified, CertifiedWeld, Input, Progress, write_file};
use trueweld_plant::input::Requirements;
use trueweld_plant::simulate::{BuildLaw, Program};

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
    if let Some(path) = &arguments.json {
        may_be_written(path)?;
    }
    let requirements = embedded!(Requirements, arguments.requirements.as_deref(), "requirements/lap-weld.toml");
    if requirements.limits.iter().all(Option::is_none) {
        return Err(miette!("the requirements limit nothing; expected at least one key in [limits]"));
    }
    let folder = &arguments.evidence;
    std::fs::create_dir_all(folder)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot create {}", folder.display()))?;
    let files: Vec<Option<&Path>> = match arguments.weld.as_slice() {
        [] => vec![None],
        files => files.iter().map(|f| Some(f.as_path())).collect(),
    };
    let mut inputs_said = vec![said("requirements", &requirements)];
    let mut welds = Vec::new();
    for file in files {
        let inputs = arguments.cell.read(file)?;
        let parts = [
            said(&format!("weld {}", inputs.weld_name), &inputs.weld),
            said("robot", inputs.robot.robot.parameters()),
            said("process", &inputs.planned),
            said("control", &inputs.control),
            said("sensors", &inputs.sensors),
            said("belief", inputs.belief.parameters()),
        ];
        for part in &parts {
            if !inputs_said.contains(part) {
                inputs_said.push(part.clone());
            }
        }
        let law = arguments.compensator.law();
        let key = said(
            "trials",
            &(&parts, &requirements, law.name(), arguments.passes, arguments.draws, env!("CARGO_PKG_VERSION")),
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
    write_file(&folder.join("certify.json"), &text)?;
    write_file(&folder.join("certify.html"), certified.html())?;
    if let Some(path) = &arguments.json {
        write_file(path, &text)?;
    }
    say!("{}wrote {}\n", certified.text(), folder.join("certify.html").display());
    if !certified.passes() {
        std::process::exit(1);
    }
    Ok(())
}

/// All trials of one weld: those that are there, and the missing ones.
fn weld(arguments: &Arguments, requirements: &Requirements, inputs: &Inputs, key: &str) -> Result<CertifiedWeld> {
    let scenario = inputs.scenario(Program::Weld, arguments.controller.controller(), arguments.compensator.law());
    let robot = &inputs.robot.robot;
    let passes = arguments.passes.max(1);
    let certification = Certification { scenario, robot, requirements, passes, seed: arguments.draws };
    let path = arguments.evidence.join(format!("trials-{}.jsonl", inputs.weld_name));
    let mut trials = kept(&path, key)?;
    trials.retain(|t| t.index < arguments.trials);
    let missing: Vec<u64> = (0..arguments.trials).filter(|k| !trials.iter().any(|t| t.index == *k)).collect();
    let nominal = certification.nominal();
    if let Some(why) = nominal.failed.as_ref().filter(|_| trials.is_empty()) {
        return Err(miette!("{}: the nominal cell cannot be welded: {why}", inputs.weld_file));
    }
    let progress =
        if arguments.quiet { Progress::silent() } else { Progress::new(&inputs.weld_name, missing.len() as f64) };
    let file = Mutex::new((record(&path, key)?, 0_usize));
    let more: Vec<Result<Trial>> = missing
        .par_iter()
        .map(|index| {
            let trial = certification.trial(*index);
            let line = serde_json::to_string(&trial).into_diagnostic()? + "\n";
            let mut file = file.lock().map_err(|_| miette!("a thread stopped"))?;
            let written = file.0.write_all(line.as_bytes()).and_then(|()| file.0.flush());
            written.into_diagnostic().wrap_err_with(|| format!("cannot write {}", path.display()))?;
            file.1 += 1;
            progress.advance_to(file.1 as f64);
            Ok(trial)
        })
        .collect();
    progress.finish();
    trials.extend(more.into_iter().collect::<Result<Vec<_>>>()?);
    trials.sort_by_key(|t| t.index);
    // In their order, whoever was first.
    let lines: Vec<String> = trials.iter().map(serde_json::to_string).collect::<Result<_, _>>().into_diagnostic()?;
    write_file(&path, format!("{}\n{}\n", header(key), lines.join("\n")))?;
    let judged = judge(requirements, &trials);
    Ok(CertifiedWeld { name: inputs.weld_name.clone(), nominal, trials, requirements: judged })
}

fn header(key: &str) -> String {
    serde_json::json!({ "schema": "trials/1", "inputs": key }).to_string()
}

/// Trials of an interrupted certification of the same. A last line that was cut off is done again.
fn kept(path: &Path, key: &str) -> Result<Vec<Trial>> {
    let Ok(text) = std::fs::read_to_string(path) else { return Ok(Vec::new()) };
    let mut lines = text.lines();
    if lines.next().is_some_and(|first| first != header(key)) {
        return Err(miette!(
            help = "Give another --evidence folder, or remove this one.",
            "{} holds trials of another certification; expected none, or some of the same inputs",
            path.display()
        ));
    }
    Ok(lines.filter_map(|line| serde_json::from_str(line).ok()).collect())
}

/// The file that trials are added to, ending with a whole line.
fn record(path: &Path, key: &str) -> Result<File> {
    let fail = || format!("cannot write {}", path.display());
    let whole = std::fs::read_to_string(path).ok().filter(|text| !text.is_empty());
    let mut file = OpenOptions::new().create(true).append(true).open(path).into_diagnostic().wrap_err_with(fail)?;
    let start = match whole {
        None => header(key) + "\n",
        Some(text) if !text.ends_with('\n') => "\n".to_owned(),
        Some(_) => String::new(),
    };
    file.write_all(start.as_bytes()).into_diagnostic().wrap_err_with(fail)?;
    Ok(file)
}

/// The digest of a value as it was read.
fn said(what: &str, value: &impl std::fmt::Debug) -> Input {
    let digest = Sha256::digest(format!("{value:?}"));
    Input { what: what.to_owned(), sha256: digest.iter().map(|b| format!("{b:02x}")).collect() }
}
