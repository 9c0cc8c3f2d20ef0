//! `--log`: what both commands of RSI leave of a weld besides its result.

use crate::results::check_empty_folder;
use clap::Args;
use miette::{IntoDiagnostic, Result, WrapErr};
use std::io;
use std::path::{Path, PathBuf};
use trueweld::WeldingCell;
use trueweld_laboratory::WeldLog;
use trueweld_plant::input::{Process, RobotFile, Weld};

/// Where a log goes.
#[derive(Args)]
pub(crate) struct LogFolder {
    /// Write a log of the weld into a new folder, with the files that it was made with: for `compare`,
    /// `diagnose` and `improve`
    #[arg(long = "log", value_name = "FOLDER")]
    folder: Option<PathBuf>,
}

impl LogFolder {
    /// Checks the folder, if there is to be one: before anything is welded.
    pub(crate) fn check(&self) -> Result<()> {
        self.folder.as_deref().map_or(Ok(()), |folder| check_empty_folder("--log", folder))
    }

    /// Writes a log, if one is asked for, and says so.
    pub(crate) fn write(
        &self,
        inputs: &WeldingCell,
        log: impl FnOnce(WeldLog<'_>, &Path) -> io::Result<()>,
    ) -> Result<()> {
        let Some(folder) = &self.folder else { return Ok(()) };
        let robot = inputs.text::<RobotFile>()?;
        let process = inputs.text::<Process>()?;
        let weld = inputs.text::<Weld>()?;
        log(WeldLog { robot: &robot, process: &process, weld: &weld }, folder)
            .into_diagnostic()
            .wrap_err_with(|| format!("--log {}", folder.display()))?;
        say!("wrote {}\n", folder.display());
        Ok(())
    }
}
