//! Shards: parts of a certification that are made apart, on one machine or many, and put together.
//!
//! Shard i of n makes of the nominal run, the trials and the faults every n-th, from the i-th on; no
//! run depends on another shard's. A finished shard leaves `shard.json`: which it is, what its
//! runs are of, and the SHA-256 of every file with runs. Shards are merged only where all of them
//! are there, once each, whole, and of what is asked for now. The search for the worst cell needs
//! all trials, and is made by whoever merges, as are the margins.

use miette::{IntoDiagnostic, Report, Result, WrapErr, miette};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::{Display, Formatter};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use trueweld_output::write_file;
use trueweld_plant::provenance::{FileDigest, Provenance};

/// The file of a finished shard.
const MANIFEST: &str = "shard.json";

/// Its format.
const SCHEMA: &str = "shard/1";

/// One part of so many: number from 1 on, and how many there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shard {
    number: usize,
    of: usize,
}

impl Display for Shard {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| {
            Some(Self { number: number.parse().ok()?, of: of.parse().ok()? })
        });
        numbers
            .filter(|shard| {
                (1..=MOST).contains(&shard.of) && (1..=shard.of).contains(&shard.number)
            })
            .ok_or_else(|| format!("expected I/N with I from 1 to N and N up to {MOST}, as 2/8"))
    }
}

/// Most shards: as many as there may be trials.
const MOST: usize = 100_000;

/// What a finished shard says of itself.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    schema: String,
    shard: Shard,
    /// Trials of the whole certification.
    trials: u64,
    /// What the runs are of.
    provenance: Provenance,
    /// SHA-256 of every file with runs, by its name.
    files: BTreeMap<String, String>,
}

impl Shard {
    /// What this shard makes of the whole.
    pub fn part<J>(self, jobs: Vec<J>) -> Vec<J> {
        jobs.into_iter().skip(self.number - 1).step_by(self.of).collect()
    }

    /// Writes what the shard is, once all of its runs are made.
    ///
    /// # Errors
    /// The operating system's.
    pub fn finish(
        self,
        folder: &Path,
        files: &[PathBuf],
        provenance: Provenance,
        trials: u64,
    ) -> Result<()> {
        let digest = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            Ok((name, digest(path)?.sha256))
        };
        let files = files.iter().map(digest).collect::<Result<_>>()?;
        let manifest =
            Manifest { schema: SCHEMA.to_owned(), shard: self, trials, provenance, files };
        let text = serde_json::to_string_pretty(&manifest).into_diagnostic()?;
        Ok(write_file(&folder.join(MANIFEST), text + "\n")?)
    }
}

/// The digest of a file of the evidence as it is kept, by its name alone.
pub fn digest(path: &Path) -> Result<FileDigest> {
    let bytes = std::fs::read(path)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot read {}", path.display()))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Ok(FileDigest::new("evidence", &name, &bytes))
}

/// Checks that an evidence folder is not that of another shard, or of one where the whole is asked
/// for.
///
/// # Errors
/// The shard that is there.
pub fn check_folder(folder: &Path, shard: Option<Shard>) -> Result<()> {
    if !folder.join(MANIFEST).exists() {
        return Ok(());
    }
    let there = read(folder)?.shard;
    if Some(there) == shard {
        return Ok(());
    }
    Err(miette!(
        "--evidence {} holds shard {there}; expected a folder of its own",
        folder.display()
    ))
}

/// A shard that is begun is not finished, whatever was there before.
///
/// # Errors
/// The operating system's.
pub fn begin(folder: &Path) -> Result<()> {
    let path = folder.join(MANIFEST);
    if path.exists() {
        std::fs::remove_file(&path)
            .into_diagnostic()
            .wrap_err_with(|| format!("cannot remove {}", path.display()))?;
    }
    Ok(())
}

fn read(folder: &Path) -> Result<Manifest> {
    let path = folder.join(MANIFEST);
    let text = std::fs::read(&path).map_err(|error| {
        miette!(
            help = "Run the shard with the same command again: it goes on where it was stopped.",
            "--merge {}: no finished shard, {MANIFEST} cannot be read: {error}",
            folder.display()
        )
    })?;
    let manifest: Manifest = serde_json::from_slice(&text).map_err(|error| {
        miette!("{}: expected what a shard writes of itself: {error}", path.display())
    })?;
    if manifest.schema != SCHEMA {
        let (path, schema) = (path.display(), &manifest.schema);
        return Err(miette!("{path}: of the format {schema:?}; expected {SCHEMA:?}"));
    }
    Ok(manifest)
}

/// Shards that make a whole, in their order.
pub struct Shards(Vec<PathBuf>);

impl Shards {
    /// Reads shards and checks that they make the whole that `provenance` and the number of trials
    /// ask for.
    ///
    /// # Errors
    /// The shard that is missing, given twice, damaged, or of something else, with its folder.
    pub fn read(folders: &[PathBuf], provenance: &Provenance, trials: u64) -> Result<Self> {
        let mut found: BTreeMap<usize, PathBuf> = BTreeMap::new();
        let mut number = None;
        for folder in folders {
            let Manifest { shard, trials: made, provenance: of, files, .. } = read(folder)?;
            let at = format!("--merge {}: shard {shard}", folder.display());
            let all = *number.get_or_insert(shard.of);
            if shard.of != all {
                return Err(miette!("{at}; expected one of {all}, as the first that was given"));
            }
            if let Some(difference) = difference(&of, provenance) {
                return Err(miette!(
                    help = "Shards are put together by the same program with the same options and files.",
                    "{at} is of something else: {difference}"
                ));
            }
            if made != trials {
                return Err(miette!("{at} is part of {made} runs; expected {trials}"));
            }
            for (name, digest_then) in &files {
                let now = digest(&folder.join(name)).map(|of| of.sha256);
                if now.ok().as_ref() != Some(digest_then) {
                    return Err(miette!(
                        help = "Run it again in a new folder.",
                        "{at} is damaged: {name} is not as the shard wrote it"
                    ));
                }
            }
            if let Some(other) = found.insert(shard.number, folder.clone()) {
                return Err(miette!("{at} is given twice; the other is {}", other.display()));
            }
        }
        let all = number.unwrap_or(1);
        let missing: Vec<String> = (1..=all)
            .filter(|number| !found.contains_key(number))
            .map(|number| Shard { number, of: all }.to_string())
            .collect();
        if !missing.is_empty() {
            return Err(miette!(
                help = "Run it with --shard, and merge again.",
                "--merge: {} of {all} shards not given: {}",
                missing.len(),
                missing.join(", ")
            ));
        }
        Ok(Self(found.into_values().collect()))
    }

    /// Their folders.
    pub fn folders(&self) -> impl Iterator<Item = &Path> {
        self.0.iter().map(PathBuf::as_path)
    }

    /// What to say of a shard, from 0 on, that lacks a run of its part.
    pub fn lacks(&self, shard: usize, weld: &str) -> Report {
        let (folder, of) = (self.0[shard].display(), self.0.len());
        miette!(
            "--merge {folder}: shard {}/{of} lacks runs of the weld {weld}; expected all of its part",
            shard + 1
        )
    }
}

/// What two certifications differ in, if anything; where files lie does not count.
pub fn difference(of: &Provenance, asked: &Provenance) -> Option<String> {
    if of.version != asked.version {
        let (made, this) = (&of.version, &asked.version);
        return Some(format!("made by version {made} of the program, and this is {this}"));
    }
    if of.sources != asked.sources {
        let (made, this) = (&of.sources, &asked.sources);
        return Some(format!("made by a build of the sources {made}, and this is one of {this}"));
    }
    if of.command != asked.command {
        return Some(format!("made by `{}`, and this is `{}`", of.command, asked.command));
    }
    let count = of.files.len().max(asked.files.len());
    for (a, b) in (0..count).map(|i| (of.files.get(i), asked.files.get(i))) {
        match (a, b) {
            (Some(a), Some(b)) if (&a.role, &a.sha256) == (&b.role, &b.sha256) => {}
            (Some(a), _) => return Some(format!("its {} file was {}", a.role, a.file)),
            (None, Some(b)) => return Some(format!("it had no {} file", b.role)),
            (None, None) => {}
        }
    }
    let value = |provenance: &Provenance| {
        let plain = Provenance { files: Vec::new(), warnings: Vec::new(), ..provenance.clone() };
        serde_json::to_value(plain).unwrap_or_default()
    };
    let (of, asked) = (value(of), value(asked));
    let [simulation, now] = [&of, &asked].map(|all| all["simulation"].as_object());
    let option = simulation.into_iter().flatten().find_map(|(name, then)| {
        let now = now?.get(name).unwrap_or(&serde_json::Value::Null);
        (then != now).then(|| format!("{name} was {then}, and is {now}"))
    });
    option.or_else(|| (of != asked).then(|| "robot or effects differ".to_owned()))
}
