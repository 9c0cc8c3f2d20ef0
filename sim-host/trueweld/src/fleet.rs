//! Several cells of one type: the model of each improved, and all of them beside each other.

use crate::improve::{ImprovedModel, improve};
use crate::measured::{GivenLogs, HeldOutLogs, MeasuredLogs};
use crate::work::WorkProgress;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::path::{Path, PathBuf};
use std::time::Instant;
use trueweld_diagnose::fleet::{Fleet, ImprovedUnit};
use trueweld_logs::campaign::{by_unit, must_fit_together};
use trueweld_plant::input::ModelFile;

/// A unit of a type, measured.
pub struct MeasuredUnit {
    /// Its name, as its campaigns state it.
    pub name: String,
    /// Its logs, and the model of its type.
    pub measured: MeasuredLogs,
    /// Logs of it that its model is judged by and not fitted to; where there are none, blocks in time of
    /// those that are fitted.
    pub held_out: Option<HeldOutLogs>,
}

/// Reads the campaigns of units of one type, one group of logs a unit. `model`: the model of the type;
/// where none is given, that of the campaigns.
///
/// # Errors
/// Those of [`GivenLogs::read`] and [`GivenLogs::prepare`]; a unit that is not stated; a recording of two
/// units; models that are not of one type.
pub fn read_units(model: Option<&Path>, folders: &[PathBuf]) -> Result<Vec<MeasuredUnit>> {
    let groups = by_unit(folders)?;
    let mut given: Vec<(String, GivenLogs)> = Vec::with_capacity(groups.len());
    for (name, folders) in groups {
        let name = name.unwrap_or_default();
        let logs = GivenLogs::read(model, &folders)?;
        let all = given.iter().map(|(_, of)| of).chain([&logs]).flat_map(|of| &of.logs);
        must_fit_together(&all.collect::<Vec<_>>())?;
        if let Some((_, first)) = given.first() {
            must_be_alike(&first.model, &logs.model)?;
        }
        given.push((name, logs));
    }
    let mut units = Vec::with_capacity(given.len());
    for (name, logs) in given {
        let measured = logs.prepare().wrap_err_with(|| format!("unit {name}"))?;
        units.push(MeasuredUnit { name, measured, held_out: None });
    }
    Ok(units)
}

/// Reads folders of logs or of campaigns that units are judged by and not fitted to, each of the unit that
/// it states.
///
/// # Errors
/// Those of [`HeldOutLogs::read`]; a folder of no unit, or of one that is not among `units`.
pub fn hold_out(units: &mut [MeasuredUnit], folders: &[PathBuf]) -> Result<()> {
    for (name, folders) in by_unit(folders)? {
        let names: Vec<&str> = units.iter().map(|unit| unit.name.as_str()).collect();
        let place = names.iter().position(|unit| Some(*unit) == name.as_deref());
        let Some(place) = place else {
            let stated = name.map_or("no unit".to_owned(), |name| format!("the unit {name}"));
            return Err(miette!(
                help = "The `unit` of its campaign.toml says of which robot a recording is.",
                "--held-out {}: it states {stated}; expected one of those that are improved: {}",
                folders[0].display(),
                names.join(", ")
            ));
        };
        let unit = &mut units[place];
        unit.held_out = Some(HeldOutLogs::read(&folders, &unit.measured)?);
    }
    Ok(())
}

/// Values of units compare only where all are against the same numbers.
fn must_be_alike(first: &ModelFile, other: &ModelFile) -> Result<()> {
    let effects = |model: &ModelFile| -> Vec<_> {
        let all = model.effects.iter();
        all.map(|e| (e.effect.kind.id, e.effect.at, e.effect.values.clone(), e.scope)).collect()
    };
    let differs = match () {
        () if first.robot != other.robot => "robot",
        () if first.process != other.process => "process",
        () if effects(first) != effects(other) => "effects",
        () => return Ok(()),
    };
    Err(miette!(
        help = "What a unit has of its own is told against the model of its type. Give that model to all, in their folders or by \
                --model model.toml.",
        "{}: its {differs} differs from that of {}; expected the same numbers in the models of all units",
        other.path.display(),
        first.path.display()
    ))
}

/// Units of one type, improved.
pub struct ImprovedFleet {
    /// The model of each unit.
    pub units: Vec<ImprovedModel>,
    /// All of them beside each other.
    pub fleet: Fleet,
}

/// Improves the model of each unit, and lays them beside each other. `deadline`: after it no new work is
/// begun; every unit has its share of the time. `progress`: told of the unit under way, by its index.
///
/// # Errors
/// Gross mistakes in the files; a log that a model cannot be driven through.
pub fn improve_fleet(
    units: &mut [MeasuredUnit],
    deadline: Option<Instant>,
    progress: &(dyn Fn(usize, WorkProgress<'_>) + Sync),
) -> Result<ImprovedFleet> {
    let count = units.len();
    let mut improved = Vec::with_capacity(count);
    for (k, MeasuredUnit { name, measured, held_out }) in units.iter_mut().enumerate() {
        let now = Instant::now();
        let share = |end: Instant| now + end.saturating_duration_since(now) / (count - k) as u32;
        let done = improve(measured)
            .held_out(held_out.as_ref())
            .deadline(deadline.map(share))
            .on_progress(&|at| progress(k, at))
            .run();
        improved.push(done.wrap_err_with(|| format!("unit {name}"))?);
    }
    let all: Vec<ImprovedUnit<'_>> = units
        .iter()
        .zip(&improved)
        .map(|(MeasuredUnit { measured, .. }, done)| ImprovedUnit {
            problem: &measured.problem,
            logs: &measured.logs,
            robot: &measured.model.robot,
            improvement: &done.improvement,
            posterior: done.posterior.as_ref().ok(),
        })
        .collect();
    let fleet = Fleet::of(&all).into_diagnostic()?;
    Ok(ImprovedFleet { units: improved, fleet })
}
