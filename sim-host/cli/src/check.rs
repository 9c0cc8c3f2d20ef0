//! `trueweld check`: input files of any kind.

use crate::results::{check_outputs, write};
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
    /// Write the verdicts as JSON; `-` writes them to standard output, and the text to standard error
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Runs the command: one line a file, and each error where it stands.
pub fn run(arguments: &Arguments) -> Result<()> {
    let checked: Vec<_> = arguments.files.iter().map(|path| (path, input::check(path))).collect();
    if let Some(path) = &arguments.json {
        check_outputs(&[("--json", path)])?;
    }
    let mut verdicts = Vec::new();
    let mut wrong = 0;
    for (path, result) in checked {
        let name = path.display().to_string();
        let (key, value) = match result {
            Ok(kind) => {
                say!("{name}: {kind}, in order\n");
                ("kind", kind.schema().to_owned())
            }
            Err(error) => {
                wrong += 1;
                let said = error.to_string();
                eprintln!("{:?}", Report::new(error));
                ("error", said)
            }
        };
        verdicts.push(serde_json::json!({ "file": name, "ok": key == "kind", key: value }));
    }
    if let Some(path) = &arguments.json {
        let document = serde_json::json!({ "schema": "check/1", "files": verdicts });
        write(path, &format!("{document:#}\n"))?;
    }
    match wrong {
        0 => Ok(()),
        1 => Err(miette!("1 file is not in order")),
        n => Err(miette!("{n} files are not in order")),
    }
}
