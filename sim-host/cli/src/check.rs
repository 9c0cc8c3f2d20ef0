//! `trueweld check`: input files of any kind.

use clap::Args;
use miette::{Report, Result, miette};
use std::path::PathBuf;
use trueweld_plant::input;

/// Arguments of `check`.
#[derive(Args)]
pub struct Arguments {
    /// Files to check: robots, processes, welds, gains, sensors, models
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Write the verdicts as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Runs the command: one line a file, and each error where it stands.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut verdicts = Vec::new();
    let mut wrong = 0;
    for path in &arguments.files {
        let name = path.display().to_string();
        match input::check(path) {
            Ok(kind) => {
                say!("{name}: {kind}, in order\n");
                verdicts
                    .push(serde_json::json!({ "file": name, "ok": true, "kind": kind.schema() }));
            }
            Err(error) => {
                wrong += 1;
                verdicts.push(
                    serde_json::json!({ "file": name, "ok": false, "error": error.to_string() }),
                );
                eprintln!("{:?}", Report::new(error));
            }
        }
    }
    if let Some(path) = &arguments.json {
        let document = serde_json::json!({ "schema": "check/1", "files": verdicts });
        trueweld_output::write_file(path, format!("{document:#}\n"))?;
    }
    match wrong {
        0 => Ok(()),
        1 => Err(miette!("1 file is not in order")),
        n => Err(miette!("{n} files are not in order")),
    }
}
