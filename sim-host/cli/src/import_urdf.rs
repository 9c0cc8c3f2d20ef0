//! `trueweld import-urdf`: a robot file from a URDF.

use crate::results::{check_outputs, check_targets, write};
use crate::terminal::write_result;
use clap::Args;
use miette::Result;
use std::path::PathBuf;
use trueweld_plant::input;

/// Arguments of `import-urdf`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// URDF of a serial arm with six revolute joints
    #[arg(value_name = "URDF")]
    urdf: PathBuf,
    /// Robot file to write (default: standard output)
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let outputs = arguments.out.as_deref().map(|path| ("--out", path));
    check_targets(outputs.as_slice())?;
    let text = input::import_urdf(&arguments.urdf)?;
    let Some(path) = &arguments.out else {
        return write_result(text.as_bytes());
    };
    check_outputs(outputs.as_slice())?;
    write(path, &text)?;
    for note in text.lines().filter_map(|line| line.strip_prefix("# Note: ")) {
        say!("{note}\n");
    }
    let left = input::open_entries(path)?.len();
    if left > 0 {
        say!(
            "{left} values are marked {:?}: a URDF does not hold them. Fill them in, then: trueweld check {}\n",
            input::FILL_IN,
            path.display()
        );
    }
    Ok(())
}
