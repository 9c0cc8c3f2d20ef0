//! Shards: parts of a certification that are made apart, on one machine or many, and put together.
//!
//! Shard i of n makes of the nominal run, the trials and the faults every n-th, from the i-th on; no
//! run depends on another shard's. A finished shard leaves `shard.json`: which it is, what its
//! runs are of, and the SHA-256 of every file with runs. Shards are merged only where all of them
//! are there, once each, whole, and of what is asked for now. The search for the worst cell needs
//! all trials, and is made by whoever merges, as are the margins. Errors name the options of the
//! command line, under which their reader knows folders and shards.

use super::difference::must_be_of_same;
use super::evidence_error::{cannot, unwritten};
use super::shard::Shard;
use miette::{IntoDiagnostic, Report, Result, miette};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trueweld_plant::input::write_atomically;
use trueweld_plant::provenance::{FileDigest, Provenance};

/// The file of a finished shard.
const SHARD_MANIFEST: &str = "shard.json";

/// Its format.
const SHARD_SCHEMA: &str = "shard/1";

/// What a finished shard says of itself.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ShardManifest {
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
    /// Writes what the shard is, once all of its runs are made. `files`: those that keep the runs;
    /// `trials`: of the whole.
    ///
    /// # Errors
    /// The operating system's, with the file.
    pub fn finish(
        self,
        folder: &Path,
        files: &[PathBuf],
        provenance: Provenance,
        trials: u64,
    ) -> Result<()> {
        let digest = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            Ok((name, evidence_digest(path)?.sha256))
        };
        let files = files.iter().map(digest).collect::<Result<_>>()?;
        let schema = SHARD_SCHEMA.to_owned();
        let manifest = ShardManifest { schema, shard: self, trials, provenance, files };
        let text = serde_json::to_string_pretty(&manifest).into_diagnostic()? + "\n";
        write_atomically(folder.join(SHARD_MANIFEST), text.as_bytes()).map_err(unwritten)
    }
}

/// The digest of a file of the evidence as it is kept, by its name alone.
///
/// # Errors
/// A file that cannot be read.
pub(crate) fn evidence_digest(path: &Path) -> Result<FileDigest> {
    let bytes = std::fs::read(path).map_err(|source| cannot("read", path, source))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Ok(FileDigest::new("evidence", &name, &bytes))
}

/// Checks that an evidence folder is not that of another shard, or of one where the whole is asked
/// for.
///
/// # Errors
/// Another shard; a manifest that cannot be read.
pub fn check_shard_folder(folder: &Path, shard: Option<Shard>) -> Result<()> {
    if !folder.join(SHARD_MANIFEST).exists() {
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
/// A manifest that cannot be removed.
pub fn begin_shard(folder: &Path) -> Result<()> {
    let path = folder.join(SHARD_MANIFEST);
    if path.exists() {
        std::fs::remove_file(&path).map_err(|source| cannot("remove", &path, source))?;
    }
    Ok(())
}

fn read(folder: &Path) -> Result<ShardManifest> {
    let path = folder.join(SHARD_MANIFEST);
    let text = std::fs::read(&path).map_err(|reason| {
        miette!(
            help = "Run the shard with the same command again: it goes on where it was stopped.",
            "--merge {}: no finished shard, shard.json cannot be read: {reason}",
            folder.display()
        )
    })?;
    let path = path.display();
    let manifest: ShardManifest = serde_json::from_slice(&text)
        .map_err(|reason| miette!("{path}: expected what a shard writes of itself: {reason}"))?;
    if manifest.schema != SHARD_SCHEMA {
        let found = manifest.schema;
        return Err(miette!("{path}: of the format {found:?}; expected {SHARD_SCHEMA:?}"));
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
            let manifest = read(folder)?;
            let (at, shard) = (folder.display(), manifest.shard);
            let all = *number.get_or_insert(shard.of);
            if shard.of != all {
                return Err(miette!(
                    "--merge {at}: shard {shard}; expected one of {all}, as the first that was given"
                ));
            }
            if let Err(difference) = must_be_of_same(&manifest.provenance, provenance) {
                return Err(miette!(
                    help = "Shards are put together by the same program with the same options and files.",
                    "--merge {at}: shard {shard} is of something else: {difference}"
                ));
            }
            if manifest.trials != trials {
                let made = manifest.trials;
                return Err(miette!(
                    "--merge {at}: shard {shard} is part of {made} runs; expected {trials}"
                ));
            }
            for (file, digest_then) in manifest.files {
                let now = evidence_digest(&folder.join(&file)).map(|of| of.sha256);
                if now.ok() != Some(digest_then) {
                    return Err(miette!(
                        help = "Run it again in a new folder.",
                        "--merge {at}: shard {shard} is damaged: {file} is not as the shard wrote it"
                    ));
                }
            }
            if let Some(other) = found.insert(shard.number, folder.clone()) {
                return Err(miette!(
                    "--merge {at}: shard {shard} is given twice; the other is {}",
                    other.display()
                ));
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
        let at = self.0[shard].display();
        let shard = Shard { number: shard + 1, of: self.0.len() };
        miette!(
            "--merge {at}: shard {shard} lacks runs of the weld {weld}; expected all of its part"
        )
    }
}
