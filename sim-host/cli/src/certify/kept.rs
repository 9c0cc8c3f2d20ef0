//! Runs that are kept as they come, one a line, so that an interrupted certification goes on where
//! it was stopped.

use miette::{IntoDiagnostic, Result, WrapErr, miette};
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use trueweld_output::write_file;

/// The runs of one section of one weld, and their file.
pub struct TrialStore<R> {
    path: PathBuf,
    header: String,
    file: Mutex<File>,
    /// Of an interrupted certification of the same.
    before: Vec<R>,
    /// Those asked for, in their order.
    done: Vec<R>,
}

impl<R: Serialize + DeserializeOwned + Clone + Send> TrialStore<R> {
    /// Opens the file of a section. `key`: digest of everything that the runs depend on.
    pub fn open(path: PathBuf, key: &str) -> Result<Self> {
        let header = serde_json::json!({ "schema": "trials/1", "inputs": key }).to_string();
        let before = before(&path, &header)?;
        let file = Mutex::new(appended(&path, &header)?);
        Ok(Self { path, header, file, before, done: Vec::new() })
    }

    /// How many runs are there already.
    pub fn count(&self) -> usize {
        self.before.len()
    }

    /// The runs of these jobs in their order: those that are there, and the missing ones on all
    /// cores. `is`: whether a run is of a job; `run` makes one.
    pub fn complete<J: Sync>(
        &mut self,
        jobs: &[J],
        is: impl Fn(&J, &R) -> bool,
        run: impl Fn(&J) -> R + Sync,
    ) -> Result<Vec<R>> {
        let there: Vec<Option<R>> =
            jobs.iter().map(|j| self.before.iter().find(|r| is(j, r)).cloned()).collect();
        let (file, path) = (&self.file, &self.path);
        let runs = jobs.par_iter().zip(there).map(|(job, there)| {
            if let Some(run) = there {
                return Ok(run);
            }
            let run = run(job);
            let line = serde_json::to_string(&run).into_diagnostic()? + "\n";
            let mut file = file.lock().map_err(|_| miette!("a thread stopped"))?;
            let written = file.write_all(line.as_bytes()).and_then(|()| file.flush());
            written
                .into_diagnostic()
                .wrap_err_with(|| format!("cannot write {}", path.display()))?;
            Ok(run)
        });
        let runs: Vec<Result<R>> = runs.collect();
        let runs = runs.into_iter().collect::<Result<Vec<R>>>()?;
        self.done.extend_from_slice(&runs);
        Ok(runs)
    }

    /// Writes the runs in the order in which they were asked for, whoever was first.
    pub fn close(self) -> Result<()> {
        let lines = self
            .done
            .iter()
            .map(serde_json::to_string)
            .collect::<Result<Vec<_>, _>>()
            .into_diagnostic()?;
        let lines: String = lines.iter().flat_map(|line| [line, "\n"]).collect();
        write_file(&self.path, format!("{}\n{lines}", self.header))?;
        Ok(())
    }
}

/// Runs of an interrupted certification of the same. A last line that was cut off is done again.
fn before<R: DeserializeOwned>(path: &Path, header: &str) -> Result<Vec<R>> {
    let Ok(text) = std::fs::read_to_string(path) else {
        return Ok(Vec::new());
    };
    let mut lines = text.lines();
    if lines.next().is_some_and(|first| first != header) {
        return Err(miette!(
            help = "Give another --evidence folder, or remove this one.",
            "{} holds runs of another certification; expected none, or some of the same inputs",
            path.display()
        ));
    }
    Ok(lines.filter_map(|line| serde_json::from_str(line).ok()).collect())
}

/// The file that runs are added to, ending with a whole line.
fn appended(path: &Path, header: &str) -> Result<File> {
    let fail = || format!("cannot write {}", path.display());
    let whole = std::fs::read_to_string(path).ok().filter(|text| !text.is_empty());
    let mut file = OpenOptions::new()
        .create(true)
        .append(true)
        .open(path)
        .into_diagnostic()
        .wrap_err_with(fail)?;
    let start = match whole {
        None => format!("{header}\n"),
        Some(text) if !text.ends_with('\n') => "\n".to_owned(),
        Some(_) => String::new(),
    };
    file.write_all(start.as_bytes()).into_diagnostic().wrap_err_with(fail)?;
    Ok(file)
}
