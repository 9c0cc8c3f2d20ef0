//! What the commands about measurements work on: a model, and logs made ready to be compared with
//! it.

use clap::Args;
use miette::{IntoDiagnostic, Result, miette};
use std::path::PathBuf;
use trueweld_measure::data::campaign::read_logs;
use trueweld_measure::data::log::Log;
use trueweld_measure::predict::Experiment;
use trueweld_measure::residuals::compare::{baseline, experiments};
use trueweld_plant::input::{ModelFile, warnings};
use trueweld_plant::provenance::{EffectRecord, FileDigest, Provenance};

/// A model and logs.
#[derive(Args)]
pub struct Measurements {
    /// Model file (default: the campaign's)
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Folders of logs or of campaigns
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
}

/// Everything read, checked and made ready.
pub struct Measured {
    pub model: ModelFile,
    pub logs: Vec<Log>,
    /// In the order of the logs.
    pub experiments: Vec<Experiment>,
}

impl Measurements {
    pub fn read(&self) -> Result<Measured> {
        // Before the logs, of which there may be gigabytes.
        let given = self.model.as_ref().map(ModelFile::read).transpose()?;
        let (campaign, logs) = read_logs(&self.logs)?;
        let model = match (given, campaign) {
            (Some(model), _) => model,
            (None, Some(path)) => ModelFile::read(path)?,
            (None, None) => {
                return Err(miette!(
                    help = "Give the model that the logs are to be compared with: --model model.toml. Only a campaign names its own, \
                            and several campaigns may name different ones.",
                    "--model is missing; expected a model file"
                ));
            }
        };
        for log in &logs {
            log.must_be_of(&model.robot, &format!("the model {}", model.path.display()))?;
        }
        let experiments = read_experiments(&logs, &model)?;
        Ok(Measured { model, logs, experiments })
    }
}

impl Measured {
    /// What a result of these measurements is of.
    pub fn provenance(&self, command: &str) -> Result<Provenance> {
        let mut files = FileDigest::of_model(&self.model)?;
        files.extend(digests("log", &self.logs)?);
        let effects = self.model.effects.iter();
        Ok(Provenance {
            warnings: warnings(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command: command.to_owned(),
            robot: self.model.robot.name.clone(),
            effects: effects.map(|e| EffectRecord::new(&e.effect, &self.model.robot)).collect(),
            simulation: None,
            files,
        })
    }
}

/// Digests of the files of logs, each file once.
pub fn digests(role: &str, logs: &[Log]) -> Result<Vec<FileDigest>> {
    let mut paths: Vec<&PathBuf> = Vec::new();
    for path in logs.iter().flat_map(|log| &log.files) {
        if !paths.contains(&path) {
            paths.push(path);
        }
    }
    Ok(paths.into_iter().map(|p| FileDigest::of_file(role, p)).collect::<Result<_, _>>()?)
}

/// Logs made ready to be compared with a model.
pub fn read_experiments(logs: &[Log], model: &ModelFile) -> Result<Vec<Experiment>> {
    experiments(logs, &baseline(model)).into_diagnostic()
}
