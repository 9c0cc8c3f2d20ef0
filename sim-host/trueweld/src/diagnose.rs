//! Which physical effect is missing in a model.

use crate::measured::{ComparedLogs, MeasuredLogs};
use crate::work::{MeasuredWork, WorkProgress};
use miette::{IntoDiagnostic, Result};
use trueweld_diagnose::discover::{Discovery, discover, settling_experiment};
use trueweld_diagnose::{Diagnosis, Explanation, explain};
use trueweld_estimate::residuals::compare::{LogComparison, Notice};

/// Predictions of all logs that a diagnosis asks for: at least, where nothing is missing, and at
/// most, where two effects are.
const DIAGNOSIS_PREDICTIONS: [f64; 2] = [350.0, 1200.0];

/// Finds out which effect is missing in a model: of the library's, or a law outside it. It says so
/// where the logs do not explain.
///
/// ```no_run
/// let mut measured = trueweld::MeasuredLogs::read("my-campaign")?;
/// let told = trueweld::diagnose(&mut measured).run()?;
/// println!("{}: {} explanations", told.diagnosis.verdict.name(), told.diagnosis.candidates.len());
/// # Ok::<(), miette::Report>(())
/// ```
pub fn diagnose(measured: &mut MeasuredLogs) -> DiagnoseOptions<'_> {
    MeasuredWork::new(measured, DiagnoseTask)
}

/// How a diagnosis is made.
pub type DiagnoseOptions<'a> = MeasuredWork<'a, DiagnoseTask>;

/// A diagnosis of measured logs.
pub struct DiagnoseTask;

/// What a diagnosis comes to.
pub struct CellDiagnosis {
    /// The verdict, with every explanation and its evidence.
    pub diagnosis: Diagnosis,
    /// What is told of it: why, and the experiment to make next.
    pub explanation: Explanation,
    /// Laws outside the library that were found.
    pub discovered: Vec<Discovery>,
    /// The logs under the model as it was given.
    pub before: Vec<LogComparison>,
    /// The logs under the model with the best explanation.
    pub after: Vec<LogComparison>,
    /// What a person should know besides.
    pub notices: Vec<Notice>,
}

impl MeasuredWork<'_, DiagnoseTask> {
    /// Makes the diagnosis.
    ///
    /// # Errors
    /// Gross mistakes in the files; a log that the model cannot be driven through.
    pub fn run(mut self) -> Result<CellDiagnosis> {
        self.measured.must_be_usable()?;
        let progress = self.begin(DIAGNOSIS_PREDICTIONS);
        let measured = &*self.measured;
        let MeasuredLogs { logs, problem, .. } = measured;
        let stage = |from: f64, part: f64| {
            move |what: &str, share: f64| progress(WorkProgress::At(what, from + part * share))
        };
        let diagnosed =
            trueweld_diagnose::diagnose(problem, logs, &stage(0.0, 0.7)).into_diagnostic()?;
        let (diagnosed, discovered) = discover(problem, logs, diagnosed, &stage(0.7, 0.15));
        let mut explanation = explain(problem, logs, &diagnosed, &stage(0.85, 0.15));
        if let Some(discovery) = discovered.first() {
            // The other one would explain apart what explains a part within the library.
            explanation.next_experiment = settling_experiment(problem, logs, discovery);
        }
        let ComparedLogs { before, after, notices } =
            measured.compared(&diagnosed.fits, &diagnosed.fits.improved.residuals);
        let diagnosis = diagnosed.diagnosis;
        Ok(CellDiagnosis { diagnosis, explanation, discovered, before, after, notices })
    }
}
