//! Stiffness, damping or process of a cell from its logs, with intervals.

use crate::measured::GivenLogs;
use trueweld_estimate::identify::{Identification, IdentificationTarget, IdentifyError};

/// Identifies numbers of a cell from logs, without a prior: joint stiffness, damping, or the welding
/// process. `done` is told what is being done, and the share done of it.
///
/// ```no_run
/// use trueweld::{GivenLogs, IdentificationTarget, identify};
///
/// let given = GivenLogs::read(None, &["my-campaign".into()])?;
/// let found = identify(IdentificationTarget::Stiffness, given, &|_, _| {})?;
/// for number in &found.numbers {
///     println!("{} {}: {:.3e}", number.name, number.at, number.value);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`IdentifyError`].
pub fn identify(
    target: IdentificationTarget,
    given: GivenLogs,
    done: &dyn Fn(&'static str, f64),
) -> Result<Identification, IdentifyError> {
    trueweld_estimate::identify::identify(target, &given.model, given.logs, done)
}
