//! Campaigns: logs of one cell with the model that they are to be compared with.
//!
//! A campaign is a folder with `campaign.toml`. All its logs are of one robot; whether they fit the
//! model is found out later.

use crate::log::{LOG_FILE, Log, SAMPLES_FILE, name_of, piece_name};
use std::path::{Path, PathBuf};
use trueweld_plant::input::{
    Accuracy, FileKind, InputError, Source, TomlDocument, TomlTable, read_text,
};

/// Name of the file that lists a campaign's logs.
pub const CAMPAIGN_FILE: &str = "campaign.toml";

/// A campaign that was read and checked.
#[derive(Debug, Clone)]
pub struct Campaign {
    /// Name of the folder.
    pub name: String,
    /// The model file; it exists, and is not read here.
    pub model: PathBuf,
    /// The logs, in the order of the file.
    pub logs: Vec<Log>,
}

/// What `campaign.toml` says.
#[derive(Debug, Clone)]
pub struct CampaignList {
    /// Which robot of its type the logs are of; `None` where there is one only.
    pub unit: Option<String>,
    /// The model file.
    pub model: PathBuf,
    /// How exact predictions of its logs need be.
    pub accuracy: Accuracy,
    /// The logs, as it lists them and where they are.
    pub logs: Vec<(String, PathBuf)>,
}

impl Campaign {
    /// Reads the campaign in a folder with all its logs.
    ///
    /// # Errors
    /// The first thing that does not fit, with file, line and column; logs that are not of one
    /// robot.
    pub fn read(folder: impl AsRef<Path>) -> Result<Self, InputError> {
        let folder = folder.as_ref();
        let CampaignList { model, accuracy, logs: folders, .. } = Self::list(folder)?;
        let mut logs = Vec::with_capacity(folders.len());
        for (listed, path) in &folders {
            let pieces = Log::read_pieces(path)?;
            let count = pieces.len();
            for (number, log) in pieces.into_iter().enumerate() {
                let name = piece_name(listed, number, count);
                let mut log = Log { name, accuracy, ..log };
                log.files.push(folder.join(CAMPAIGN_FILE));
                logs.push(log);
            }
        }
        must_fit_together(&logs.iter().collect::<Vec<_>>())?;
        Ok(Self { name: name_of(folder), model, logs })
    }

    /// What the file of a campaign in a folder says. All that it names exists; none is read.
    ///
    /// # Errors
    /// The first thing that does not fit, with file, line and column.
    pub fn list(folder: &Path) -> Result<CampaignList, InputError> {
        let (name, text) = read_text(&folder.join(CAMPAIGN_FILE))?;
        let document = TomlDocument::parse(&text, &name)?;
        let root = document.root_of(FileKind::Campaign.schema())?;
        root.only(&["schema", "unit", "model", "logs", "accuracy"])?;
        let unit = root.optional("unit", TomlTable::name)?;
        let is_word = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
        if unit.as_ref().is_some_and(|unit| !unit.chars().all(is_word)) {
            let expected = "a name of letters, digits, - and _";
            return Err(root.wrong(
                "unit",
                expected,
                "A file is named after it: unit = \"cell-3\".",
            ));
        }
        let model = root.file("model", folder)?;
        let accuracy = Accuracy::read(&root)?;
        let mut folders: Vec<(String, PathBuf)> = Vec::new();
        for entry in root.texts("logs")? {
            let path = folder.join(entry.text);
            if !path.join(LOG_FILE).is_file() {
                let message =
                    format!("{:?} is no log; expected a folder with {LOG_FILE}", entry.text);
                let help =
                    format!("Folders are taken from the campaign's: here {}.", path.display());
                return Err(root.error_at(&entry, message, help));
            }
            if folders.iter().any(|(_, other)| same(other, &path)) {
                let message = format!("{:?} is listed twice; expected each log once", entry.text);
                return Err(root.error_at(
                    &entry,
                    message,
                    "A log that counts twice would weigh twice.",
                ));
            }
            folders.push((entry.text.to_owned(), path));
        }
        Ok(CampaignList { unit, model, accuracy, logs: folders })
    }
}

/// A unit, where campaigns state theirs, and the folders of its campaigns.
pub type UnitFolders = (Option<String>, Vec<PathBuf>);

/// Folders by the unit that their campaigns are of, in the order given; one group without a name where
/// no campaign states a unit, and one group where all are of the same.
///
/// # Errors
/// A `campaign.toml` that cannot be used; a folder of which the unit is not known among campaigns that
/// state theirs.
pub fn by_unit(paths: &[PathBuf]) -> Result<Vec<UnitFolders>, InputError> {
    let mut stated = Vec::with_capacity(paths.len());
    for path in paths {
        let folder = folder_of(path);
        let is_campaign = folder.join(CAMPAIGN_FILE).is_file();
        if !is_campaign && !folder.join(LOG_FILE).is_file() {
            return Err(holds_nothing(path));
        }
        let unit = if is_campaign { Campaign::list(&folder)?.unit } else { None };
        stated.push((unit, is_campaign, folder));
    }
    let mut named: Vec<&String> = stated.iter().filter_map(|(unit, ..)| unit.as_ref()).collect();
    named.dedup();
    if let Some(other) = named.first() {
        // A log beside the campaigns of one unit is of that unit.
        let is_lost = |(unit, is_campaign, _): &&(Option<String>, bool, PathBuf)| {
            unit.is_none() && (*is_campaign || named.len() > 1)
        };
        if let Some((_, is_campaign, folder)) = stated.iter().find(is_lost) {
            let file = if *is_campaign { folder.join(CAMPAIGN_FILE) } else { folder.clone() };
            let message = format!(
                "the unit that it is of is not stated; expected `unit = \"…\"` in its {CAMPAIGN_FILE}, since another campaign is of \
                 the unit {other}"
            );
            let help = "Campaigns of one robot have the same `unit`, or none has one.";
            return Err(Source::new(&file.display().to_string(), "").error_of_file(message, help));
        }
    }
    let mut groups: Vec<UnitFolders> = Vec::new();
    let only = named.first().filter(|_| named.len() == 1).map(|unit| (*unit).clone());
    for ((unit, ..), path) in stated.iter().zip(paths) {
        let unit = unit.clone().or(only.clone());
        match groups.iter_mut().find(|(other, _)| *other == unit) {
            Some((_, folders)) => folders.push(path.clone()),
            None => groups.push((unit, vec![path.clone()])),
        }
    }
    Ok(groups)
}

/// Reads logs from folders of logs and folders of campaigns, mixed as one likes; `log.toml` or
/// `campaign.toml` itself stands for its folder. Also gives the model of the campaigns: none where
/// there is no campaign among them, or where they name different ones.
///
/// # Errors
/// Everything that [`Log::read`] and [`Campaign::read`] refuse; a folder that is neither; a log
/// given twice; logs that are not of one robot, or of several units.
pub fn read_logs(paths: &[PathBuf]) -> Result<(Option<PathBuf>, Vec<Log>), InputError> {
    if let [(Some(first), _), (Some(second), folders), ..] = by_unit(paths)?.as_slice() {
        let file = folder_of(&folders[0]).join(CAMPAIGN_FILE);
        let message =
            format!("a campaign of the unit {second}; expected one of {first}, as the first");
        let help = "Give the campaigns of one unit. `trueweld improve` takes several, and says what they share.";
        return Err(Source::new(&file.display().to_string(), "").error_of_file(message, help));
    }
    let mut models: Vec<PathBuf> = Vec::new();
    let mut logs: Vec<Log> = Vec::new();
    for path in paths {
        let folder = folder_of(path);
        let read = if folder.join(CAMPAIGN_FILE).is_file() {
            let campaign = Campaign::read(&folder)?;
            models.push(campaign.model);
            campaign.logs
        } else if folder.join(LOG_FILE).is_file() {
            Log::read_pieces(&folder)?
        } else {
            return Err(holds_nothing(path));
        };
        let before = logs.len();
        for log in read {
            if logs[..before].iter().any(|other| same(&other.path, &log.path)) {
                let message = "this log is given twice; expected each log once";
                let help = "A log that counts twice would weigh twice. Is it part of a campaign that is given too?";
                return Err(
                    Source::new(&log.path.display().to_string(), "").error_of_file(message, help)
                );
            }
            logs.push(log);
        }
    }
    must_fit_together(&logs.iter().collect::<Vec<_>>())?;
    let first = models.pop();
    let model = first.filter(|model| models.iter().all(|other| same(other, model)));
    Ok((model, logs))
}

/// The error of a folder that is neither a log's nor a campaign's.
fn holds_nothing(path: &Path) -> InputError {
    let found = match path.exists() {
        true => format!("holds neither {LOG_FILE} nor {CAMPAIGN_FILE}"),
        false => "does not exist".to_owned(),
    };
    let message = format!("{found}; expected the folder of a log or of a campaign");
    let help = format!("A log is a folder with {LOG_FILE}, a campaign one with {CAMPAIGN_FILE}.");
    Source::new(&path.display().to_string(), "").error_of_file(message, help)
}

fn folder_of(path: &Path) -> PathBuf {
    let named = path.file_name().is_some_and(|name| name == LOG_FILE || name == CAMPAIGN_FILE);
    match path.parent() {
        Some(parent) if named && path.is_file() => {
            if parent.as_os_str().is_empty() {
                PathBuf::from(".")
            } else {
                parent.to_owned()
            }
        }
        _ => path.to_owned(),
    }
}

fn of_one_robot(logs: &[&Log]) -> Result<(), InputError> {
    let Some((first, others)) = logs.split_first() else {
        return Ok(());
    };
    others
        .iter()
        .try_for_each(|log| log.must_be_of(&first.robot, &format!("the log `{}`", first.name)))
}

/// Refuses logs that are not of one robot, and a recording that stands in two of them.
///
/// # Errors
/// The first log that does not fit, with its file.
pub fn must_fit_together(logs: &[&Log]) -> Result<(), InputError> {
    of_one_robot(logs)?;
    recorded_once(logs)
}

/// Refuses a recording that stands in two logs: encoders and an instrument that read the same.
fn recorded_once(logs: &[&Log]) -> Result<(), InputError> {
    /// Rows that do not come out alike by chance.
    const EQUAL_ROWS_MIN: usize = 20;
    let same = |a: &Log, b: &Log| {
        let (a, b) = (&a.samples, &b.samples);
        let instrument = (a.position.is_some() && a.position == b.position)
            || a.motor_torque.iter().zip(&b.motor_torque).any(|(a, b)| a.is_some() && a == b);
        a.len() >= EQUAL_ROWS_MIN && a.encoder == b.encoder && instrument
    };
    for (k, log) in logs.iter().enumerate() {
        if let Some(first) = logs[..k].iter().find(|other| same(other, log)) {
            let message = format!(
                "its rows are those of the log `{}`; expected a recording of its own",
                first.name
            );
            let help = "A recording that counts twice would weigh twice. Was a file copied to the wrong folder?";
            let samples = log.path.join(SAMPLES_FILE);
            let file = if samples.is_file() { samples } else { log.path.join(LOG_FILE) };
            return Err(Source::new(&file.display().to_string(), "").error_of_file(message, help));
        }
    }
    Ok(())
}

/// True where both paths lead to the same place.
fn same(a: &Path, b: &Path) -> bool {
    a == b || matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
