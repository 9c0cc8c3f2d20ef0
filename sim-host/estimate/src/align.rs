//! Clocks of instruments that were not given, fitted to what a model predicts: an arm bends, and
//! where the encoders alone put the tool is some millimetres off.

use crate::predict::{BaselineModel, PredictError, PreparedLog};
use rayon::prelude::*;
use trueweld_core::Pose;
use trueweld_logs::log::Log;
use trueweld_logs::noise::instruments;

/// Fits anew and resamples: from the first fit the second is near enough to be the last.
const CLOCK_PASSES: usize = 2;

/// Fits the clocks that logs leave open to the motion that a model predicts, and reads their
/// instruments anew. Logs whose clocks are given stay as they are.
///
/// # Errors
/// [`PredictError`] of the first log that the model cannot be driven through.
pub fn align_clocks(logs: &mut [Log], model: &BaselineModel) -> Result<(), PredictError> {
    let open = |log: &Log| log.origin.clocks.iter().any(|clock| clock.fitted.is_some());
    if !logs.iter().any(open) {
        return Ok(());
    }
    for _ in 0..CLOCK_PASSES {
        let levels = instruments(logs);
        logs.par_iter_mut().zip(&levels).filter(|(log, _)| open(log)).try_for_each(
            |(log, levels)| -> Result<(), PredictError> {
                let experiment = match PreparedLog::new(log, levels, model) {
                    // A short piece of a log that was cut: it has no say.
                    Err(PredictError::Nothing { .. }) => return Ok(()),
                    made => made?,
                };
                let prediction = experiment.predict(model, &[], None)?;
                let Some(motion) = prediction.motion else { return Ok(()) };
                let poses: Vec<Pose<f64>> = if motion.tool.is_empty() {
                    motion.link.iter().map(|q| model.robot.forward_kinematics(q)).collect()
                } else {
                    motion.tool.clone()
                };
                log.refit_clocks(&poses);
                Ok(())
            },
        )?;
    }
    Ok(())
}
