//! Where results go.

use clap::Args;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::path::{Path, PathBuf};
use trueweld_output::write_file;

/// Result files.
#[derive(Args, Default)]
pub struct Results {
    /// Write the figures as JSON
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
    /// Refuses before the work what could not be written after it.
    pub fn check(&self) -> Result<()> {
        if cfg!(not(feature = "rerun")) && self.rrd.is_some() {
            return Err(miette!(
                "--rrd: this build has no Rerun; build it with the feature `rerun`"
            ));
        }
        for path in [&self.json, &self.html, &self.rrd].into_iter().flatten() {
            may_be_written(path)?;
        }
        Ok(())
    }

    /// Writes the JSON and the page that were asked for.
    pub fn write(
        &self,
        json: impl FnOnce() -> serde_json::Value,
        html: impl FnOnce() -> String,
    ) -> Result<()> {
        if let Some(path) = &self.json {
            let text = serde_json::to_string_pretty(&json())
                .into_diagnostic()
                .wrap_err("figures as JSON")?;
            write_file(path, text + "\n")?;
            say!("wrote {}\n", path.display());
        }
        if let Some(path) = &self.html {
            write_file(path, html())?;
            say!("wrote {}\n", path.display());
        }
        Ok(())
    }
}

/// The folder that the program and its guide write into: made where it is not there. A folder of
/// another name may be a slip.
const OUT: &str = "out";

/// Refuses what could not be written: a file in no folder, or a folder.
pub fn may_be_written(path: &Path) -> Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if folder == Path::new(OUT) {
        std::fs::create_dir_all(folder)
            .into_diagnostic()
            .wrap_err("cannot create the folder out")?;
    }
    if !folder.is_dir() {
        return Err(miette!(
            "cannot write {}: expected a folder {}, and there is none",
            path.display(),
            folder.display()
        ));
    }
    if path.is_dir() {
        return Err(miette!(
            "cannot write {}: expected the name of a file, and it is a folder",
            path.display()
        ));
    }
    Ok(())
}
