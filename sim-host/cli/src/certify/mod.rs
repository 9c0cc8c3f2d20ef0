//! `trueweld certify`: many welds of uncertain cells, and what they prove of a compensation law.
//!
//! Runs are kept one a line in the evidence folder as they come; the command given again goes on
//! where it was stopped. A part of them may be made elsewhere ([`Shard`]).

pub(crate) mod certificate;

use crate::inputs::{CellArguments, passes};
use crate::names::{ControllerParser, LawParser};
use crate::repeat;
use crate::results::{Results, check_new_folder, check_outputs, check_targets, write};
use clap::{Args, value_parser};
use miette::{Result, miette};
use std::path::{Path, PathBuf};
use trueweld::{
    CertificationOutcome, Repeat, RequirementsFile, Shard, Verdict, WeldingCell, certify,
};
use trueweld_compensators::Entry;
use trueweld_output::{CertifyReport, Report, write_file};
use trueweld_plant::controllers::ControllerKind;

/// Arguments of `certify`.
#[derive(Args)]
pub(crate) struct Arguments {
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
    #[arg(long, value_parser = ControllerParser, default_value = ControllerKind::default().name())]
    controller: ControllerKind,
    #[command(flatten)]
    cell: CellArguments,
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

/// Runs the command. Its status is 1 where the law fails, or so few runs do not show it to pass.
pub(crate) fn run(arguments: &Arguments) -> Result<u8> {
    let (folder, results) = (&arguments.evidence, &arguments.results);
    check_new_folder("--evidence", folder)?;
    if let (Some(shard), Some((flag, _))) = (arguments.shard, results.outputs().first()) {
        return Err(miette!(
            "{flag}: shard {shard} has no result yet; expected this option with --merge"
        ));
    }
    check_targets(&results.outputs())?;
    let requirements = RequirementsFile::read(arguments.requirements.as_deref())?;
    // Everything is read and judged usable before the first run.
    let cells = cells(arguments)?;
    let prepared = certify(&cells, arguments.compensator.clone())
        .controller(arguments.controller)
        .requirements(requirements)
        .trials(arguments.trials)
        .failure_probability(arguments.failure_probability)
        .worst(arguments.worst as usize)
        .passes(arguments.passes as usize)
        .draws(arguments.draws)
        .evidence(folder)
        .compare_assumed(arguments.compare_assumed)
        .shard(arguments.shard)
        .merge(&arguments.merge)
        .repeat(if arguments.verify { Repeat::All } else { Repeat::Sample })
        .prepare()?;
    let certification = prepared.open()?;
    let [file, page] = ["certify.json", "certify.html"].map(|name| folder.join(name));
    let runs = certification.files();
    let outputs = runs.iter().chain([&file, &page]).map(|path| ("--evidence", path.as_path()));
    let outputs: Vec<_> = outputs.chain(results.outputs()).collect();
    check_outputs(&outputs)?;
    let progress = results.progress("certifying", 1.0);
    let done = certification.run(&|stage, share| progress.stage(stage, share))?;
    progress.finish();
    let certificate = match (done, arguments.shard) {
        (CertificationOutcome::Part(made), Some(shard)) => {
            say!("shard {shard}: {made} runs in {}\n", folder.display());
            return Ok(0);
        }
        (CertificationOutcome::Whole(certificate), _) => *certificate,
        (CertificationOutcome::Part(_), None) => return Ok(0),
    };
    let report = CertifyReport {
        seed_given: certificate.seed != prepared.natural_seed(),
        certificate,
        robot_grade: cells[0].robot_grade()?,
        repeat: repeat::command_line("certify", &ONLY_HERE),
    };
    write_file(&file, report.json_text())?;
    results.write(&report)?;
    write(&page, &report.page())?;
    let (kept, repeated) = (report.certificate.kept, report.certificate.repeated);
    if kept > 0 {
        say!("{repeated} of {kept} kept runs were made again, and came out as they were kept\n");
    }
    Ok(if report.certificate.verdict() == Verdict::Pass { 0 } else { 1 })
}

/// Options that do not change what is certified: where runs are made and kept, and what is written.
const ONLY_HERE: [&str; 8] =
    ["evidence", "shard", "merge", "verify", "json", "html", "samples", "quiet"];

/// The cell with each of the welds.
fn cells(arguments: &Arguments) -> Result<Vec<WeldingCell>> {
    let files: Vec<Option<&Path>> = match arguments.weld.as_slice() {
        [] => vec![None],
        files => files.iter().map(|f| Some(f.as_path())).collect(),
    };
    files.into_iter().map(|f| arguments.cell.read(f)).collect()
}
