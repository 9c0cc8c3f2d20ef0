//! Shards: parts of a certification that are made apart, on one machine or many, and put together.
//!
//! Shard i of n makes of the nominal run, the trials and the faults every n-th, from the i-th on; no
//! run depends on another shard's. A finished shard leaves `shard.json`: which it is, what its
//! runs are of, and the SHA-256 of every file with runs. Shards are merged only where all of them
//! are there, once each, whole, and of what is asked for now. The search for the worst cell needs
//! all trials, and is made by whoever merges, as are the margins.

use super::difference::must_be_of_same;
use super::evidence_error::EvidenceError;
use super::shard::Shard;
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
    ) -> Result<(), EvidenceError> {
        let digest = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            Ok((name, evidence_digest(path)?.sha256))
        };
        let files = files.iter().map(digest).collect::<Result<_, EvidenceError>>()?;
        let schema = SHARD_SCHEMA.to_owned();
        let manifest = ShardManifest { schema, shard: self, trials, provenance, files };
        let text = serde_json::to_string_pretty(&manifest)? + "\n";
        write_atomically(folder.join(SHARD_MANIFEST), text.as_bytes()).map_err(EvidenceError::Write)
    }
}

/// The digest of a file of the evidence as it is kept, by its name alone.
///
/// # Errors
/// [`EvidenceError::Read`].
pub(crate) fn evidence_digest(path: &Path) -> Result<FileDigest, EvidenceError> {
    let bytes = std::fs::read(path)
        .map_err(|source| EvidenceError::Read { path: path.to_owned(), source })?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Ok(FileDigest::new("evidence", &name, &bytes))
}

/// Checks that an evidence folder is not that of another shard, or of one where the whole is asked
/// for.
///
/// # Errors
/// [`EvidenceError::OtherShard`]; a manifest that cannot be read.
pub fn check_shard_folder(folder: &Path, shard: Option<Shard>) -> Result<(), EvidenceError> {
    if !folder.join(SHARD_MANIFEST).exists() {
        return Ok(());
    }
    let there = read(folder)?.shard;
    if Some(there) == shard {
        return Ok(());
    }
    Err(EvidenceError::OtherShard { folder: folder.to_owned(), there })
}

/// A shard that is begun is not finished, whatever was there before.
///
/// # Errors
/// [`EvidenceError::Remove`].
pub fn begin_shard(folder: &Path) -> Result<(), EvidenceError> {
    let path = folder.join(SHARD_MANIFEST);
    if path.exists() {
        std::fs::remove_file(&path).map_err(|source| EvidenceError::Remove { path, source })?;
    }
    Ok(())
}

fn read(folder: &Path) -> Result<ShardManifest, EvidenceError> {
    let path = folder.join(SHARD_MANIFEST);
    let text = std::fs::read(&path)
        .map_err(|reason| EvidenceError::NoShard { folder: folder.to_owned(), reason })?;
    let manifest: ShardManifest = serde_json::from_slice(&text)
        .map_err(|reason| EvidenceError::NotOfShard { path: path.clone(), reason })?;
    if manifest.schema != SHARD_SCHEMA {
        let found = manifest.schema;
        return Err(EvidenceError::ShardFormat { path, found, expected: SHARD_SCHEMA });
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
    pub fn read(
        folders: &[PathBuf],
        provenance: &Provenance,
        trials: u64,
    ) -> Result<Self, EvidenceError> {
        let mut found: BTreeMap<usize, PathBuf> = BTreeMap::new();
        let mut number = None;
        for folder in folders {
            let manifest = read(folder)?;
            let (folder, shard) = (folder.clone(), manifest.shard);
            let all = *number.get_or_insert(shard.of);
            if shard.of != all {
                return Err(EvidenceError::ShardOfAnother { folder, shard, all });
            }
            if let Err(difference) = must_be_of_same(&manifest.provenance, provenance) {
                return Err(EvidenceError::ShardOfElse { folder, shard, difference });
            }
            if manifest.trials != trials {
                let (made, asked) = (manifest.trials, trials);
                return Err(EvidenceError::ShardRuns { folder, shard, made, asked });
            }
            for (file, digest_then) in manifest.files {
                let now = evidence_digest(&folder.join(&file)).map(|of| of.sha256);
                if now.ok() != Some(digest_then) {
                    return Err(EvidenceError::ShardDamaged { folder, shard, file });
                }
            }
            if let Some(other) = found.insert(shard.number, folder.clone()) {
                return Err(EvidenceError::ShardTwice { folder, shard, other });
            }
        }
        let all = number.unwrap_or(1);
        let missing: Vec<Shard> = (1..=all)
            .filter(|number| !found.contains_key(number))
            .map(|number| Shard { number, of: all })
            .collect();
        if !missing.is_empty() {
            return Err(EvidenceError::ShardsMissing { all, missing });
        }
        Ok(Self(found.into_values().collect()))
    }

    /// Their folders.
    pub fn folders(&self) -> impl Iterator<Item = &Path> {
        self.0.iter().map(PathBuf::as_path)
    }

    /// What to say of a shard, from 0 on, that lacks a run of its part.
    pub fn lacks(&self, shard: usize, weld: &str) -> EvidenceError {
        EvidenceError::ShardLacks {
            folder: self.0[shard].clone(),
            shard: Shard { number: shard + 1, of: self.0.len() },
            weld: weld.to_owned(),
        }
    }
}
