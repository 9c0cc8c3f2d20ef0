//! `trueweld new-law`: a crate with a law and an effect of one's own, to begin with.

use crate::folder::make_folder;
use clap::Args;
use miette::{Result, miette};
use std::path::{Path, PathBuf};
use trueweld_compensators::{Entry, library, may_be_name};

/// Arguments of `new-law`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Name of the law: lower-case letters, digits and hyphens
    name: String,
    /// Folder to write (default: the name)
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

/// Folder of this crate, which stands beside the other one on which the written one depends.
const CLI_FOLDER: &str = env!("CARGO_MANIFEST_DIR");

/// What the example calls its law.
const EXAMPLE: &str = "own-law";

/// The example's files, which tests build and run.
const FILES: [(&str, &str); 2] = [
    ("Cargo.toml", include_str!("../../../examples/own-law/Cargo.toml")),
    ("src/main.rs", include_str!("../../../examples/own-law/src/main.rs")),
];

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let name = &arguments.name;
    if !may_be_name(name) {
        return Err(miette!(
            "{name:?} is no name of a law; expected lower-case letters, digits and hyphens, beginning with a letter, such as my-law"
        ));
    }
    if library().iter().map(Entry::name).any(|known| known == name) {
        return Err(miette!("there is a law {name}; expected a name of its own"));
    }
    let folder = arguments.out.as_deref().unwrap_or(Path::new(name));
    make_folder(folder)?;
    make_folder(&folder.join("src"))?;
    for (file, text) in FILES {
        let mut text = text.replace(EXAMPLE, name);
        for dependency in ["cli", "trueweld"] {
            let path = Path::new(CLI_FOLDER).with_file_name(dependency);
            let path = toml::Value::from(path.display().to_string()).to_string();
            text = text.replace(&format!("\"../../sim-host/{dependency}\""), &path);
        }
        trueweld_output::write_file(&folder.join(file), text)?;
    }
    say!(
        "wrote {0}: a law in {0}/src/main.rs, and the program around it\ncargo run --release --manifest-path {0}/Cargo.toml -- compare-laws --laws feed-forward,{name}\n",
        folder.display()
    );
    Ok(())
}
