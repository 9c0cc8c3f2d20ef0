//! What two results differ in that should be of the same.

use serde_json::Value;
use trueweld_plant::provenance::Provenance;

/// The first thing in which two results differ; where files lie does not count.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProvenanceDifference {
    /// The version of the program.
    #[error("made by version {made} of the program, and this is {this}")]
    Version {
        /// The one.
        made: String,
        /// The other.
        this: String,
    },
    /// The sources of the program.
    #[error("made by a build of the sources {made}, and this is one of {this}")]
    Sources {
        /// Digest of the one.
        made: String,
        /// Digest of the other.
        this: String,
    },
    /// The command.
    #[error("made by `{made}`, and this is `{this}`")]
    Command {
        /// The one.
        made: String,
        /// The other.
        this: String,
    },
    /// A file's bytes, or a file that only the one read.
    #[error("its {role} file was {file}")]
    File {
        /// What it was read as.
        role: String,
        /// Its path.
        file: String,
    },
    /// A file that only the other read.
    #[error("it had no {role} file")]
    NoFile {
        /// What it was read as.
        role: String,
    },
    /// An option of the simulation.
    #[error("{name} was {made}, and is {this}")]
    Option {
        /// Its name.
        name: String,
        /// The one.
        made: Value,
        /// The other.
        this: Value,
    },
    /// Robot or effects.
    #[error("robot or effects differ")]
    Cell,
}

impl ProvenanceDifference {
    /// What a result that was made (`of`) differs in from the one that is asked for; `None` where
    /// both are of the same.
    pub fn between(of: &Provenance, asked: &Provenance) -> Option<Self> {
        let differ =
            |made: &String, this: &String| (made != this).then(|| (made.clone(), this.clone()));
        if let Some((made, this)) = differ(&of.version, &asked.version) {
            return Some(Self::Version { made, this });
        }
        if let Some((made, this)) = differ(&of.sources, &asked.sources) {
            return Some(Self::Sources { made, this });
        }
        if let Some((made, this)) = differ(&of.command, &asked.command) {
            return Some(Self::Command { made, this });
        }
        Self::of_files(of, asked).or_else(|| Self::of_cells(of, asked))
    }

    fn of_files(of: &Provenance, asked: &Provenance) -> Option<Self> {
        let count = of.files.len().max(asked.files.len());
        (0..count).find_map(|i| match (of.files.get(i), asked.files.get(i)) {
            (Some(a), Some(b)) if (&a.role, &a.sha256) == (&b.role, &b.sha256) => None,
            (Some(a), _) => Some(Self::File { role: a.role.clone(), file: a.file.clone() }),
            (None, Some(b)) => Some(Self::NoFile { role: b.role.clone() }),
            (None, None) => None,
        })
    }

    /// Options, robot and effects.
    fn of_cells(of: &Provenance, asked: &Provenance) -> Option<Self> {
        let value = |provenance: &Provenance| {
            let plain =
                Provenance { files: Vec::new(), warnings: Vec::new(), ..provenance.clone() };
            serde_json::to_value(plain).unwrap_or_default()
        };
        let (of, asked) = (value(of), value(asked));
        let [simulation, now] = [&of, &asked].map(|all| all["simulation"].as_object());
        let option = simulation.into_iter().flatten().find_map(|(name, then)| {
            let now = now?.get(name).unwrap_or(&Value::Null);
            let differ =
                || Self::Option { name: name.clone(), made: then.clone(), this: now.clone() };
            (then != now).then(differ)
        });
        option.or_else(|| (of != asked).then_some(Self::Cell))
    }
}
