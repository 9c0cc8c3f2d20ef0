//! What experiments would show of a cell, before any is made.

use crate::fixture::read_input;
use crate::measured::MeasuredLogs;
use miette::{IntoDiagnostic, Result};
use trueweld_diagnose::{Detectability, detectability};
use trueweld_laboratory::ProtocolFile;
use trueweld_logs::log::Log;
use trueweld_plant::input::{Control, Sensors};

/// Experiments as a cell without any missing effect would give them, and what they would show.
pub struct PlannedExperiments {
    /// The logs, in the protocol's order.
    pub logs: Vec<Log>,
    /// What they would show.
    pub detectability: Detectability,
}

/// Says what the experiments of a protocol would show of each effect: they are simulated with the
/// noise of its instruments, as its model states the cell, without its `[[effect]]` tables. `done`:
/// called with what is done now, and the share of the whole.
///
/// ```no_run
/// use trueweld::{laboratory::ProtocolFile, plan};
///
/// let planned = plan(ProtocolFile::read("laboratory-day.toml")?, &|_, _| ())?;
/// println!("{} effects would be seen", planned.detectability.shown.len());
/// # Ok::<(), miette::Report>(())
/// ```
///
/// # Errors
/// Experiments that the cell cannot make; the operating system's, of a temporary folder.
pub fn plan(mut protocol: ProtocolFile, done: &dyn Fn(&str, f64)) -> Result<PlannedExperiments> {
    protocol.effects.clear();
    let (control, sensors) = control_and_sensors(&protocol)?;
    let folder = tempfile::tempdir().into_diagnostic()?;
    let count = protocol.logs.len() as f64;
    let recorded = |logs: usize| done("simulating", 0.4 * logs as f64 / count);
    protocol.record(&control, &sensors, folder.path(), &recorded).into_diagnostic()?;
    done("screening every effect", 0.4);
    let measured = MeasuredLogs::read(folder.path())?;
    measured.must_be_usable()?;
    let MeasuredLogs { logs, problem, .. } = measured;
    let detectability = detectability(&problem, &logs).into_diagnostic()?;
    Ok(PlannedExperiments { logs, detectability })
}

/// Gains and sensors of the controllers that weld in a protocol: its own, or else the embedded ones.
///
/// # Errors
/// None of files that are part of the program.
pub fn control_and_sensors(protocol: &ProtocolFile) -> Result<(Control, Sensors)> {
    let control = match protocol.control.clone() {
        Some(control) => control,
        None => read_input::<Control>(None, &mut Vec::new())?,
    };
    let sensors = match protocol.sensors.clone() {
        Some(sensors) => sensors,
        None => read_input::<Sensors>(None, &mut Vec::new())?,
    };
    Ok((control, sensors))
}
