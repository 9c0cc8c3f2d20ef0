//! Why runs cannot be kept, taken over, or put together. The texts name the options of the command
//! line, under which their reader knows folders and shards.

use super::shard::Shard;
use miette::Report;
use std::io;
use std::path::PathBuf;

/// Runs that cannot be kept in an evidence folder, or that are not what is asked for.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum EvidenceError {
    /// A file that cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// Which.
        path: PathBuf,
        /// The operating system's reason.
        source: io::Error,
    },
    /// A file that no run can be added to.
    #[error("cannot write {}", path.display())]
    Append {
        /// Which.
        path: PathBuf,
        /// The operating system's reason.
        source: io::Error,
    },
    /// A file that cannot be written as a whole; it is as it was.
    #[error("{0}")]
    #[diagnostic(help("the folder must exist and be writable"))]
    Write(io::Error),
    /// A file that cannot be removed.
    #[error("cannot remove {}", path.display())]
    Remove {
        /// Which.
        path: PathBuf,
        /// The operating system's reason.
        source: io::Error,
    },
    /// A folder that cannot be made.
    #[error("cannot create {}", path.display())]
    Create {
        /// Which.
        path: PathBuf,
        /// The operating system's reason.
        source: io::Error,
    },
    /// A run that has no text.
    #[error(transparent)]
    Text(#[from] serde_json::Error),
    /// A thread that came to no end.
    #[error("a thread stopped")]
    Thread,
    /// A kept run that comes out otherwise.
    #[error(
        "{}: a kept run comes out otherwise when it is run again: kept …{kept}…, now …{again}…",
        path.display()
    )]
    #[diagnostic(help(
        "Another version of a law of one's own made these runs, or another compiler, or they were changed: give another --evidence folder."
    ))]
    Differs {
        /// The file that keeps it.
        path: PathBuf,
        /// What it has about the first difference.
        kept: String,
        /// What came out there.
        again: String,
    },
    /// Runs that another build of the program made.
    #[error(
        "{} holds runs of another build, of the sources {made}; this program is built from {this}",
        path.display()
    )]
    #[diagnostic(help(
        "Build the program from those sources again, or give another --evidence folder."
    ))]
    OtherBuild {
        /// The file that keeps them.
        path: PathBuf,
        /// Digest of the sources that made them.
        made: String,
        /// Digest of the sources now.
        this: String,
    },
    /// Runs of other files or options.
    #[error(
        "{} holds runs of something else; expected none, or some of the same files and options",
        path.display()
    )]
    #[diagnostic(help("Give another --evidence folder, or remove this one."))]
    OtherInputs {
        /// The file that keeps them.
        path: PathBuf,
    },
    /// A line that was changed, moved, or follows one that was taken out.
    #[error(
        "{}, line {line}: not as it was written; expected a run and the digest of it and the lines before",
        path.display()
    )]
    #[diagnostic(help(
        "Keep the lines before it, or give another --evidence folder: what is missing is run again."
    ))]
    ChangedLine {
        /// The file.
        path: PathBuf,
        /// Which line, from 1 on.
        line: usize,
    },
    /// A folder of another shard, or of a shard where the whole is asked for.
    #[error("--evidence {} holds shard {there}; expected a folder of its own", folder.display())]
    OtherShard {
        /// The folder.
        folder: PathBuf,
        /// The shard that is there.
        there: Shard,
    },
    /// A folder without a finished shard.
    #[error("--merge {}: no finished shard, shard.json cannot be read: {reason}", folder.display())]
    #[diagnostic(help(
        "Run the shard with the same command again: it goes on where it was stopped."
    ))]
    NoShard {
        /// The folder.
        folder: PathBuf,
        /// The operating system's reason.
        reason: io::Error,
    },
    /// A file that no shard wrote.
    #[error("{}: expected what a shard writes of itself: {reason}", path.display())]
    NotOfShard {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: serde_json::Error,
    },
    /// A shard in another format.
    #[error("{}: of the format {found:?}; expected {expected:?}", path.display())]
    ShardFormat {
        /// Its file.
        path: PathBuf,
        /// Its format.
        found: String,
        /// The one that is read.
        expected: &'static str,
    },
    /// A shard of another number of shards than the first that was given.
    #[error(
        "--merge {}: shard {shard}; expected one of {all}, as the first that was given",
        folder.display()
    )]
    ShardOfAnother {
        /// Its folder.
        folder: PathBuf,
        /// Which.
        shard: Shard,
        /// How many shards the first is one of.
        all: usize,
    },
    /// A shard whose runs are of something else.
    #[error("--merge {}: shard {shard} is of something else: {difference}", folder.display())]
    #[diagnostic(help(
        "Shards are put together by the same program with the same options and files."
    ))]
    ShardOfElse {
        /// Its folder.
        folder: PathBuf,
        /// Which.
        shard: Shard,
        /// What it differs in.
        difference: Report,
    },
    /// A shard of another number of runs.
    #[error(
        "--merge {}: shard {shard} is part of {made} runs; expected {asked}",
        folder.display()
    )]
    ShardRuns {
        /// Its folder.
        folder: PathBuf,
        /// Which.
        shard: Shard,
        /// Runs of the whole that it is part of.
        made: u64,
        /// Runs that are asked for.
        asked: u64,
    },
    /// A shard with a file that was changed.
    #[error(
        "--merge {}: shard {shard} is damaged: {file} is not as the shard wrote it",
        folder.display()
    )]
    #[diagnostic(help("Run it again in a new folder."))]
    ShardDamaged {
        /// Its folder.
        folder: PathBuf,
        /// Which.
        shard: Shard,
        /// The file's name.
        file: String,
    },
    /// A shard that is given twice.
    #[error(
        "--merge {}: shard {shard} is given twice; the other is {}",
        folder.display(),
        other.display()
    )]
    ShardTwice {
        /// The second folder.
        folder: PathBuf,
        /// Which.
        shard: Shard,
        /// The first folder.
        other: PathBuf,
    },
    /// Shards without which there is no whole.
    #[error("--merge: {} of {all} shards not given: {}", missing.len(), listed(missing))]
    #[diagnostic(help("Run it with --shard, and merge again."))]
    ShardsMissing {
        /// How many there are.
        all: usize,
        /// Those that are missing.
        missing: Vec<Shard>,
    },
    /// A shard without a run of its part.
    #[error(
        "--merge {}: shard {shard} lacks runs of the weld {weld}; expected all of its part",
        folder.display()
    )]
    ShardLacks {
        /// Its folder.
        folder: PathBuf,
        /// Which.
        shard: Shard,
        /// Name of the weld.
        weld: String,
    },
}

fn listed(shards: &[Shard]) -> String {
    shards.iter().map(Shard::to_string).collect::<Vec<_>>().join(", ")
}
