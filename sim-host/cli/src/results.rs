//! Where results go.

use crate::terminal;
use clap::Args;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::path::{Path, PathBuf};
use trueweld_output::{Recorded, Report, write_file};
use trueweld_plant::input::{files_read, folder_of, remove_stale};

/// Result files.
#[derive(Args, Default)]
pub struct Results {
    /// Write the figures as JSON; `-` writes them to standard output, and the text to standard error
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write one self-contained HTML page
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Write a Rerun recording (open with: rerun FILE)
    #[arg(long, value_name = "FILE")]
    pub rrd: Option<PathBuf>,
    /// No progress bar
    #[arg(long, short)]
    pub quiet: bool,
}

impl Results {
    /// Refuses what could not be written, and what would overwrite an input: to be asked once the
    /// inputs are read, before the work.
    ///
    /// # Errors
    /// Those of [`check_outputs`].
    pub fn check(&self) -> Result<()> {
        check_outputs(&self.outputs())
    }

    /// The files asked for, and the flags that ask for them.
    pub fn outputs(&self) -> Vec<(&'static str, &Path)> {
        let files = [("--json", &self.json), ("--html", &self.html), ("--rrd", &self.rrd)];
        files.into_iter().filter_map(|(flag, path)| Some((flag, path.as_deref()?))).collect()
    }

    /// Shows a result, and writes the files that were asked for.
    pub fn write(&self, report: &(impl Report + Recorded)) -> Result<()> {
        self.write_unrecorded(report)?;
        #[cfg(feature = "rerun")]
        if let Some(path) = &self.rrd {
            report.record(path)?;
            say!("wrote {}\n", path.display());
        }
        Ok(())
    }

    /// The same of a result that has no recording.
    pub fn write_unrecorded(&self, report: &impl Report) -> Result<()> {
        say!("{}", report.text());
        if let Some(path) = &self.json {
            write(path, &report.json_text())?;
        }
        if let Some(path) = &self.html {
            write(path, &report.page())?;
        }
        Ok(())
    }
}

/// The path that stands for standard output.
const STDOUT: &str = "-";

/// Writes a result and says so; to standard output where the path is `-`.
///
/// # Errors
/// The operating system's.
pub fn write(path: &Path, text: &str) -> Result<()> {
    if path == Path::new(STDOUT) {
        return terminal::write_result(text.as_bytes());
    }
    write_file(path, text)?;
    say!("wrote {}\n", path.display());
    Ok(())
}

/// The folder that the program and its guide write into: made where it is not there. A folder of
/// another name may be a slip.
const OUT: &str = "out";

/// Checks the outputs of a command, each with the flag that asks for it, before its work: every
/// file that was read until now is an input, those that other files name included. Also tells the
/// warnings about the inputs, makes the folder `out`, removes what a killed run left in the
/// folders, and keeps standard output for the output that is `-`.
///
/// # Errors
/// A path in no folder, a folder, an output that is an input, or two outputs in one file.
pub fn check_outputs(outputs: &[(&str, &Path)]) -> Result<()> {
    terminal::tell_warnings();
    let inputs = files_read();
    let mut targets: Vec<(&str, PathBuf)> = Vec::new();
    for (flag, path) in outputs {
        let refuse = |why: &str| Err(miette!("{flag}: cannot write {}: {why}", path.display()));
        if *flag == "--rrd" && cfg!(not(feature = "rerun")) {
            return Err(miette!(
                "--rrd: this build has no Rerun; build it with the feature `rerun`"
            ));
        }
        let folder = folder_of(path);
        if folder == Path::new(OUT) {
            std::fs::create_dir_all(folder)
                .into_diagnostic()
                .wrap_err("cannot create the folder out")?;
        }
        let target = if *path == Path::new(STDOUT) {
            if !matches!(*flag, "--json" | "--html") {
                return refuse("only text goes to standard output; expected the name of a file");
            }
            terminal::keep_stdout_for_result();
            path.to_path_buf()
        } else if !folder.is_dir() {
            let folder = folder.display();
            return refuse(&format!("expected a folder {folder}, and there is none"));
        } else if path.is_dir() {
            return refuse("expected the name of a file, and it is a folder");
        } else if path.exists() && !path.is_file() {
            // Any number of results may go to a device.
            continue;
        } else {
            remove_stale(folder);
            let folder = folder.canonicalize().into_diagnostic()?;
            path.canonicalize().unwrap_or(folder.join(path.file_name().unwrap_or_default()))
        };
        if inputs.contains(&target) {
            return refuse("it is an input of this command; expected another file");
        }
        if let Some((other, _)) = targets.iter().find(|(_, other)| *other == target) {
            return refuse(&format!("{other} goes there too; expected another file"));
        }
        targets.push((flag, target));
    }
    Ok(())
}
