//! `trueweld check`: input files of any kind.

use crate::results::{check_outputs, check_targets, write};
use clap::Args;
use miette::{Report, Result, miette};
use std::path::{Path, PathBuf};
use trueweld_evaluate::Requirements;
use trueweld_output::json::{self, CheckResult, CheckedFile};
use trueweld_plant::input::{
    Control, Document, FileKind, InputError, InputFile, ModelFile, Process, RobotFile, Sensors,
    Weld, open_entries, read_text,
};

/// Arguments of `check`.
#[derive(Args)]
pub struct Arguments {
    /// Files to check: robots, processes, welds, gains, sensors, requirements, models
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Write the verdicts as JSON; `-` writes them to standard output, and the text to standard error
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Runs the command: one line a file, and each error where it stands.
pub fn run(arguments: &Arguments) -> Result<()> {
    let outputs = arguments.json.as_deref().map(|path| ("--json", path));
    check_targets(outputs.as_slice())?;
    let checked: Vec<_> = arguments.files.iter().map(|path| (path, check(path))).collect();
    check_outputs(outputs.as_slice())?;
    let mut files = Vec::new();
    for (path, result) in checked {
        let name = path.display().to_string();
        let (kind, error) = match result {
            Ok(kind) => {
                say!("{name}: {kind}, in order\n");
                (Some(kind.schema().to_owned()), None)
            }
            Err(error) => {
                let said = error.to_string();
                let open = open_entries(path).unwrap_or_default();
                if open.len() > 1 {
                    eprintln!("{name}: {} entries are still to be filled in:", open.len());
                    open.iter().for_each(|entry| eprintln!("  {entry}"));
                    eprintln!("  help: {}\n", open[0].help_text());
                } else {
                    eprintln!("{:?}", Report::new(error));
                }
                (None, Some(said))
            }
        };
        files.push(CheckedFile { file: name, ok: error.is_none(), kind, error });
    }
    let wrong = files.iter().filter(|file| !file.ok).count();
    if let Some(path) = &arguments.json {
        write(path, &json::text(&CheckResult::new(files)))?;
    }
    match wrong {
        0 => Ok(()),
        1 => Err(miette!("1 file is not in order")),
        n => Err(miette!("{n} files are not in order")),
    }
}

/// Reads and checks an input file of any kind, and says which kind it is.
///
/// # Errors
/// Everything the reader of its kind refuses; a `schema` that is of no kind, or of one that is not
/// checked on its own.
fn check(path: &Path) -> Result<FileKind, InputError> {
    let (name, text) = read_text(path)?;
    let document = Document::parse(&text, &name)?;
    let kind = document.kind()?;
    match kind {
        FileKind::Robot => RobotFile::parse(&text, &name).map(drop),
        FileKind::Process => Process::parse(&text, &name).map(drop),
        FileKind::Weld => Weld::parse(&text, &name).map(drop),
        FileKind::Control => Control::parse(&text, &name).map(drop),
        FileKind::Sensors => Sensors::parse(&text, &name).map(drop),
        FileKind::Requirements => Requirements::parse(&text, &name).map(drop),
        FileKind::Model => ModelFile::parse(&text, path).map(drop),
        FileKind::Log | FileKind::Campaign => {
            let help = "`trueweld compare FOLDER` reads and checks it with its samples; give it the folder.";
            Err(document.root().wrong(
                "schema",
                "a kind of file that can be checked on its own",
                help,
            ))
        }
    }?;
    Ok(kind)
}
