//! A model with what was missing in it, refitted, and with what the logs leave open of its numbers.

use crate::measured::{ComparedLogs, HeldOutLogs, MeasuredLogs};
use crate::work::{MeasuredWork, WorkProgress};
use miette::{IntoDiagnostic, Result};
use std::path::Path;
use trueweld_diagnose::improve::{self, EffectOrigin, Improvement, model_file};
use trueweld_diagnose::posterior::{not_bounded, posterior};
use trueweld_diagnose::{ExplanationReason, reason_of_best};
use trueweld_estimate::residuals::compare::{LogComparison, Notice};
use trueweld_plant::input::{Comments, ModelFile, Posterior, RobotFile};

/// Predictions of all logs that an improvement asks for: at least, where nothing is missing, and at
/// most, where two effects are.
const IMPROVEMENT_PREDICTIONS: [f64; 2] = [400.0, 1600.0];

/// Adds what is missing to a model, step by step, each judged where nothing was fitted, and refits
/// it.
///
/// ```no_run
/// # use trueweld::plant::input::Comments;
/// let mut measured = trueweld::MeasuredLogs::read("my-campaign")?;
/// let mut improved = trueweld::improve(&mut measured).run()?;
/// improved.write("improved.toml".as_ref(), &Comments::default())?;
/// # Ok::<(), miette::Report>(())
/// ```
pub fn improve(measured: &mut MeasuredLogs) -> ImproveOptions<'_> {
    MeasuredWork::new(measured, ImproveTask { held_out: None })
}

/// How a model is improved.
pub type ImproveOptions<'a> = MeasuredWork<'a, ImproveTask<'a>>;

/// An improvement of the model of measured logs.
pub struct ImproveTask<'a> {
    held_out: Option<&'a HeldOutLogs>,
}

/// What an improvement comes to.
pub struct ImprovedModel {
    /// What was done, step by step.
    pub improvement: Improvement,
    /// The model with what was found, without a posterior.
    pub file: ModelFile,
    /// Where each of its effects comes from.
    pub origins: Vec<EffectOrigin>,
    /// What the logs leave open of its numbers; why there is none.
    pub posterior: Result<Posterior, String>,
    /// The logs fitted, under the model as it was given.
    pub before: Vec<LogComparison>,
    /// The logs fitted, under the improved model.
    pub after: Vec<LogComparison>,
    /// The logs held out, under the model as it was given and under the improved one; none where
    /// blocks in time of the logs fitted were held out.
    pub held_out: [Vec<LogComparison>; 2],
    /// Why what was found first is believed.
    pub reason: Option<ExplanationReason>,
    notices: Vec<Notice>,
    robot: RobotFile,
}

impl<'a> MeasuredWork<'a, ImproveTask<'a>> {
    /// Every step is judged by these logs, in place of blocks in time of those that are fitted.
    pub fn held_out(mut self, held_out: Option<&'a HeldOutLogs>) -> Self {
        self.task.held_out = held_out;
        self
    }

    /// Improves the model.
    ///
    /// # Errors
    /// Gross mistakes in the files; a log that a model cannot be driven through.
    pub fn run(mut self) -> Result<ImprovedModel> {
        let ImproveTask { held_out } = self.task;
        self.measured.must_be_usable()?;
        held_out.map_or(Ok(()), HeldOutLogs::must_be_usable)?;
        let progress = self.begin(IMPROVEMENT_PREDICTIONS);
        let measured = &*self.measured;
        let MeasuredLogs { model, logs, problem, .. } = measured;
        let stage = |what: &str, share: f64| progress(WorkProgress::At(what, share));
        let judged = held_out.map(|of| &of.held_out);
        let done = improve::improve(problem, logs, judged, &stage).into_diagnostic()?;
        let improvement = &done.improvement;
        let (file, origins) = model_file(improvement, model, problem);
        let posterior = if improvement.is_worse_elsewhere() {
            Err("the values that it would hold predict worse where nothing was fitted".to_owned())
        } else {
            posterior(problem, logs, &done, &model.robot).map_err(|error| error.to_string())
        };
        let fits = &done.diagnosis;
        let at = done.fitted.as_ref().map_or(&fits.before, |fitted| &fitted.residuals);
        let ComparedLogs { before, after, mut notices } = measured.compared(fits, at);
        let elsewhere = |step| match held_out {
            Some(of) => of.held_out.compare(&of.logs, step).into_diagnostic(),
            None => Ok((Vec::new(), Vec::new())),
        };
        let (given, _) = elsewhere(improvement.first())?;
        let (improved, own) = elsewhere(improvement.last())?;
        notices.extend(own);
        let reason = reason_of_best(problem, logs, &improvement.diagnosis, fits);
        Ok(ImprovedModel {
            file,
            origins,
            posterior,
            before,
            after,
            held_out: [given, improved],
            reason,
            notices,
            robot: model.robot.clone(),
            improvement: done.improvement,
        })
    }
}

impl ImprovedModel {
    /// Writes the model with its posterior; without it, and says why in [`ImprovedModel::posterior`],
    /// where there is none or the file with it could not be read back. `comments`: what is said in the
    /// file of its values.
    ///
    /// # Errors
    /// The operating system's; a model that its own file does not hold.
    pub fn write(&mut self, out: &Path, comments: &Comments) -> Result<()> {
        let posterior = write_model(&self.file, self.posterior.clone(), out, comments)?;
        self.posterior = posterior;
        Ok(())
    }

    /// What a person should know besides.
    pub fn notices(&self) -> Vec<Notice> {
        let mut notices = self.notices.clone();
        match &self.posterior {
            Ok(posterior) => {
                let names = not_bounded(posterior, &self.improvement, &self.robot);
                notices.extend((!names.is_empty()).then_some(Notice::NotBounded(names)));
            }
            Err(why) => notices.push(Notice::NoPosterior(why.clone())),
        }
        notices
    }
}

/// Writes an improved model with its posterior, and gives that; without it, and gives why, where
/// there is none or the file with it could not be read back.
fn write_model(
    file: &ModelFile,
    posterior: Result<Posterior, String>,
    out: &Path,
    comments: &Comments,
) -> Result<Result<Posterior, String>> {
    let written = posterior.and_then(|posterior| {
        let whole = file.clone().with_posterior(posterior.clone());
        let written = whole.and_then(|file| file.write(out, comments));
        written.map(|()| posterior).map_err(|error| error.message().to_owned())
    });
    if written.is_err() {
        file.write(out, comments)?;
    }
    Ok(written)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trueweld_plant::effects::EffectKind;
    use trueweld_plant::input::MeasuredNumber;

    fn posterior(variance: f64) -> Posterior {
        let kind = EffectKind::of("counterbalance-loss").unwrap();
        Posterior {
            numbers: vec![MeasuredNumber {
                kind,
                at: kind.places()[0],
                occurrence: 0,
                parameter: 0,
                value: 0.1,
                between_logs: 0.0,
            }],
            covariance: vec![variance],
            logs: vec!["a log".to_owned()],
            campaign: "00".to_owned(),
            score: 1.0,
            at_bound: Vec::new(),
            undetermined: Vec::new(),
            not_measured: Vec::new(),
            seal: String::new(),
        }
    }

    #[test]
    fn a_posterior_that_cannot_be_read_back_costs_the_posterior_and_not_the_model() {
        let given = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/models/cable-drag.toml");
        let model = ModelFile::read(given).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("improved.toml");
        let written = |posterior| write_model(&model, posterior, &out, &Comments::default());
        let read = || ModelFile::read(&out).unwrap();
        assert!(written(Ok(posterior(1e-6))).unwrap().is_ok());
        assert!(read().posterior.is_some());
        for none in [Ok(posterior(f64::NAN)), Ok(posterior(-1e-6)), Err("no time".to_owned())] {
            let why = written(none.clone()).unwrap().unwrap_err();
            assert!(why.contains(none.map_or("no time", |_| "covariance")), "{why}");
            assert!(read().posterior.is_none());
            assert_eq!(read().effects.len(), model.effects.len());
        }
        // Where the model itself cannot be written there is none.
        let out = folder.path().join("none/improved.toml");
        assert!(write_model(&model, Ok(posterior(1e-6)), &out, &Comments::default()).is_err());
    }
}
