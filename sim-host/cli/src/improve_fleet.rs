//! `trueweld improve` of several units of one type.

use crate::measured::{LogArguments, refuse_mistakes, show};
use crate::results::{RecordedResults, check_new_folder, check_outputs};
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;
use trueweld::{ImprovedFleet, WorkProgress, hold_out, improve_fleet, measured_provenance};
use trueweld_output::{ImproveFleetReport, ImproveReport, model_comments};

/// Improves the model of each unit, and writes them into the folder `out`.
pub(crate) fn run(
    measurements: &LogArguments,
    held_out: &[PathBuf],
    out: &Path,
    deadline: Option<Instant>,
    results: &RecordedResults,
) -> Result<()> {
    let mut outputs = results.outputs();
    if let Some((flag, _)) = outputs.iter().find(|(flag, _)| ["--rrd", "--samples"].contains(flag))
    {
        return Err(miette!(
            help = "Leave it out, or improve one unit alone.",
            "{flag}: expected none where campaigns are of several units, whose result is figures and pictures"
        ));
    }
    check_new_folder("--out", out)?;
    let mut units = measurements.read_units()?;
    for unit in &units {
        refuse_mistakes(
            &format!("unit {}", unit.name),
            &unit.measured.found,
            &unit.measured.model,
        )?;
    }
    hold_out(&mut units, held_out)?;
    let judges = || units.iter().filter_map(|unit| Some((unit, unit.held_out.as_ref()?)));
    for (unit, held_out) in judges() {
        let option = format!("--held-out, unit {}", unit.name);
        refuse_mistakes(&option, &held_out.found, &unit.measured.model)?;
    }
    let first = &units[0].measured;
    let mut provenance = measured_provenance("improve", &first.model, &first.logs)?;
    for unit in &units[1..] {
        let of = measured_provenance("improve", &unit.measured.model, &unit.measured.logs)?;
        provenance.files.extend(of.files);
    }
    judges().for_each(|(_, held_out)| provenance.files.extend_from_slice(&held_out.files));
    let file = |name: &str| out.join(format!("{name}.toml"));
    let files: Vec<PathBuf> = units.iter().map(|unit| file(&unit.name)).collect();
    fs::create_dir_all(out)
        .into_diagnostic()
        .wrap_err_with(|| format!("--out {}: cannot make this folder", out.display()))?;
    outputs.extend(files.iter().map(|file| ("--out", file.as_path())));
    check_outputs(&outputs)?;
    let progress = results.files.progress("comparing", 1.0);
    let count = units.len() as f64;
    let told = |unit: usize, now: WorkProgress<'_>| match now {
        WorkProgress::Takes(seconds) => {
            let left = count - unit as f64;
            show(&progress, WorkProgress::Takes(seconds.map(|s| left * s)));
        }
        WorkProgress::At(what, share) => {
            show(&progress, WorkProgress::At(what, (unit as f64 + share) / count));
        }
    };
    let done = improve_fleet(&mut units, deadline, &told);
    progress.finish();
    let ImprovedFleet { units: mut improved, fleet } = done?;
    for ((unit, done), file) in units.iter().zip(&mut improved).zip(&files) {
        let (model, logs) = (&unit.measured.model, &unit.measured.logs);
        let comments = model_comments(&done.improvement, model, logs, &done.origins);
        done.write(file, &comments)?;
    }
    let notices: Vec<_> = improved.iter().map(|done| done.notices()).collect();
    let reports: Vec<(&str, ImproveReport<'_>)> = units
        .iter()
        .zip(&improved)
        .zip(files.iter().zip(&notices))
        .map(|((unit, done), (file, notices))| {
            let report = ImproveReport {
                model: &unit.measured.model,
                out: file,
                improvement: &done.improvement,
                posterior: done.posterior.as_ref().ok(),
                before: &done.before,
                after: &done.after,
                held_out: [&done.held_out[0], &done.held_out[1]],
                reason: done.reason.as_ref(),
                notices,
                provenance: &provenance,
            };
            (unit.name.as_str(), report)
        })
        .collect();
    results.files.write(&ImproveFleetReport {
        units: &reports,
        fleet: &fleet,
        provenance: &provenance,
    })?;
    for file in &files {
        say!("wrote {}\n", file.display());
    }
    Ok(())
}
