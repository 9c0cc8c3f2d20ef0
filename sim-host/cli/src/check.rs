//! `trueweld check`: input files of any kind, and folders of logs and campaigns.

use crate::results::{check_outputs, check_targets, write};
use crate::session::{self, CommandResult};
use crate::terminal::complain;
use clap::Args;
use miette::{IntoDiagnostic, Report, Result, WrapErr, miette};
use std::path::{Path, PathBuf};
use trueweld::is_same_file;
use trueweld_core::JointVector;
use trueweld_evaluate::Requirements;
use trueweld_laboratory::ProtocolFile;
use trueweld_logs::campaign::Campaign;
use trueweld_logs::log::{LOG_FILE, Log};
use trueweld_output::json::{self, CheckResult, CheckedFile};
use trueweld_output::log_notice_in_words;
use trueweld_plant::input::{
    Control, FileKind, InputError, InputFile, ModelFile, Process, RobotFile, Sensors, TomlDocument,
    Weld, folder_of, open_entries, read_text, warnings,
};
use trueweld_plant::integrate::{FastestMode, TooFast};
use trueweld_plant::robot::ElasticRobot;

/// Arguments of `check`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Files to check: robots, processes, welds, gains, sensors, requirements, models, logs, campaigns,
    /// protocols; or
    /// folders of logs and campaigns, whose files are all checked
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Write the verdicts as JSON; `-` writes them to standard output, and the text to standard error
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Runs the command: one line a file, and each error where it stands. In a session, which is handed
/// the verdicts, its status is 1 where a file is not in order.
pub(crate) fn run(arguments: &Arguments) -> Result<u8> {
    let outputs = arguments.json.as_deref().map(|path| ("--json", path));
    check_targets(outputs.as_slice())?;
    let mut paths: Vec<PathBuf> = Vec::new();
    for path in &arguments.files {
        let of_path = if path.is_dir() { files_of(path)? } else { vec![path.clone()] };
        for file in of_path {
            if !paths.iter().any(|known| is_same_file(known, &file)) {
                paths.push(file);
            }
        }
    }
    let checked: Vec<_> = paths.iter().map(|path| (path, check(path))).collect();
    check_outputs(outputs.as_slice())?;
    let mut files = Vec::new();
    for (path, result) in checked {
        let name = path.display().to_string();
        let (kind, error, notices) = match result {
            Ok((kind, notices, doubts)) => {
                match doubts.len() {
                    0 => say!("{name}: {kind}, in order\n"),
                    1 => say!("{name}: {kind}, readable; 1 value is implausible\n"),
                    n => say!("{name}: {kind}, readable; {n} values are implausible\n"),
                }
                for notice in &notices {
                    say!("  note: {notice}\n");
                }
                (Some(kind.schema().to_owned()), None, [notices, doubts].concat())
            }
            Err(error) => {
                let said = error.to_string();
                let open = open_entries(path).unwrap_or_default();
                let elsewhere =
                    paths.iter().find(|other| *other != path && stands_in(&error, other));
                if open.len() > 1 || (elsewhere.is_some() && !open.is_empty()) {
                    let entries: String = open.iter().map(|entry| format!("  {entry}\n")).collect();
                    let (count, help) = (open.len(), open[0].help_text());
                    complain(&format!(
                        "{name}: {count} entries are still to be filled in:\n{entries}  help: {help}\n\n"
                    ));
                } else if let Some(other) = elsewhere {
                    let other = other.display();
                    complain(&format!("{name}: cannot be read before {other} is in order\n\n"));
                } else {
                    complain(&format!("{:?}\n", Report::new(error)));
                }
                (None, Some(said), Vec::new())
            }
        };
        files.push(CheckedFile { file: name, ok: error.is_none(), kind, error, notices });
    }
    let wrong = files.iter().filter(|file| !file.ok).count();
    let verdicts = json::text(CheckResult::SCHEMA, &CheckResult { files });
    if let Some(path) = &arguments.json {
        write(path, &verdicts)?;
    }
    let is_taken = session::take(CommandResult {
        schema: CheckResult::SCHEMA,
        json: verdicts,
        document: None,
        samples: None,
    });
    match wrong {
        0 => Ok(0),
        _ if is_taken => Ok(1),
        1 => Err(miette!("1 file is not in order")),
        n => Err(miette!("{n} files are not in order")),
    }
}

/// True where an error stands in a file.
fn stands_in(error: &InputError, file: &Path) -> bool {
    let place = error.place();
    let mut parts = place.rsplitn(3, ':');
    let named = parts.nth(2).unwrap_or(place);
    is_same_file(Path::new(named), file)
}

/// What is in a folder, by its name.
fn listed(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot read {}", folder.display()))?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    Ok(paths)
}

/// Every TOML file of a folder and of the folders in it: a campaign's own, then its logs', wherever
/// they are.
fn files_of(folder: &Path) -> Result<Vec<PathBuf>> {
    let is_toml = |path: &PathBuf| path.is_file() && path.extension().is_some_and(|e| e == "toml");
    let inside = listed(folder)?;
    let mut files: Vec<PathBuf> = inside.iter().filter(|path| is_toml(path)).cloned().collect();
    let mut logs: Vec<PathBuf> =
        inside.into_iter().filter(|path| path.join(LOG_FILE).is_file()).collect();
    // A campaign that does not list its logs is told of where it is checked itself.
    if let Ok(list) = Campaign::list(folder) {
        logs.extend(list.logs.into_iter().map(|(_, path)| path));
    }
    for log in logs {
        files.extend(listed(&log)?.into_iter().filter(is_toml));
    }
    // What a campaign's truth was is no input.
    files.retain(|path| path.file_name().is_none_or(|name| name != "truth.toml"));
    if files.is_empty() {
        return Err(miette!(
            "{}: there is no TOML file here; expected the folder of a log or of a campaign",
            folder.display()
        ));
    }
    Ok(files)
}

/// The mode of a robot that is too fast for its motion to be computed, at some posture between its
/// limits.
fn too_fast(file: &RobotFile) -> Option<TooFast> {
    const POSTURES: usize = 8;
    let robot = ElasticRobot::with_effects(&file.robot, &[], None).ok()?;
    let joints = &file.parameters.joints;
    let posture = |share: f64| {
        JointVector::from_fn(|i, _| {
            let [low, high] = joints[i].limits;
            low + (high - low) * share
        })
    };
    let modes = (0..=POSTURES).map(|k| posture(k as f64 / POSTURES as f64));
    let mut modes = modes.filter_map(|link| FastestMode::of(&robot, &link));
    modes.find_map(|mode| mode.followed().err())
}

/// Checks that what a model says was measured was measured of it.
fn check_model(model: &ModelFile, document: &TomlDocument<'_>) -> Result<(), InputError> {
    if model.is_sealed()? {
        return Ok(());
    }
    let help = "Effects, robot, process or this table were changed since. Run `improve` again for the model as it is, or \
                take the table out.";
    let posterior = document.root().table("posterior")?;
    Err(posterior.wrong("sha256", "the digest of this model, as `improve` wrote it", help))
}

/// Reads and checks an input file of any kind, and says which kind it is, of a log what a reader
/// should know, and what is implausible.
///
/// # Errors
/// Everything the reader of its kind refuses; a `schema` that is of no kind.
fn check(path: &Path) -> Result<(FileKind, Vec<String>, Vec<String>), InputError> {
    let (name, text) = read_text(path)?;
    let document = TomlDocument::parse(&text, &name)?;
    let kind = document.kind()?;
    let mut notices = Vec::new();
    match kind {
        FileKind::Robot => {
            let robot = RobotFile::parse(&text, &name)?;
            let told = |mode: TooFast| mode.told(&robot.joint_names[mode.0.joint]);
            notices.extend(too_fast(&robot).map(told));
            Ok(())
        }
        FileKind::Process => Process::parse(&text, &name).map(drop),
        FileKind::Weld => Weld::parse(&text, &name).map(drop),
        FileKind::Control => Control::parse(&text, &name).map(drop),
        FileKind::Sensors => Sensors::parse(&text, &name).map(drop),
        FileKind::Requirements => Requirements::parse(&text, &name).map(drop),
        FileKind::Model => check_model(&ModelFile::parse(&text, path)?, &document),
        FileKind::Log => {
            let log = Log::read(folder_of(path))?;
            notices.extend(log.notices.iter().map(log_notice_in_words));
            Ok(())
        }
        FileKind::Campaign => Campaign::list(folder_of(path)).map(drop),
        FileKind::Protocol => ProtocolFile::parse(&text, path).map(drop),
    }?;
    // Of this file alone: others may have been read with it, or before.
    let of_file = format!("{name}:");
    let doubts = warnings().into_iter().filter(|warning| warning.starts_with(&of_file)).collect();
    Ok((kind, notices, doubts))
}
