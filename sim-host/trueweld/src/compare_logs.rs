//! By how much two recordings of one experiment differ, without a model.

use crate::measured::log_digests;
use crate::provenance::of_program;
use miette::{Context, IntoDiagnostic, Result, miette};
use std::path::{Path, PathBuf};
use trueweld_estimate::log_faults::scale_currents;
use trueweld_logs::campaign::{CAMPAIGN_FILE, read_logs};
use trueweld_logs::log::{Log, longest};
use trueweld_logs::pair::{LogPair, compare_logs as compare_pair};
use trueweld_plant::provenance::Provenance;

/// Two logs and by how much they differ.
pub struct ComparedPair {
    /// The logs; SI units, frames as their files have them.
    pub logs: [Log; 2],
    /// By how much the second differs from the first.
    pub pair: LogPair,
    /// What the result is of.
    pub provenance: Provenance,
}

/// Compares two logs of one experiment with each other: is the cell as it was? Each is the folder of a
/// log; of one that gaps cut into pieces, the longest.
///
/// ```no_run
/// use std::path::Path;
///
/// let compared = trueweld::compare_logs(Path::new("march/free"), Path::new("april/free"))?;
/// for channel in &compared.pair.channels {
///     println!("{}: {:.1} times the noise", channel.channel.name(), channel.score().unwrap_or(0.0));
/// }
/// # Ok::<(), miette::Report>(())
/// ```
///
/// # Errors
/// A file that cannot be used, at its place; logs of other robots, of other kinds or of another motion.
pub fn compare_logs(first: &Path, second: &Path) -> Result<ComparedPair> {
    for folder in [first, second] {
        if folder.join(CAMPAIGN_FILE).is_file() {
            return Err(miette!(
                help = "Give the folder of a log in each, such as DAY/free; a campaign is compared with its model.",
                "{}: a campaign; expected a log to compare with the other",
                folder.display()
            ));
        }
    }
    let (_, logs) = read_logs(&[first.to_path_buf(), second.to_path_buf()])?;
    let of = |folder: usize, logs: &[Log]| {
        let path: &PathBuf = &if folder == 0 { &logs[0] } else { &logs[logs.len() - 1] }.path;
        let pieces = logs.iter().filter(|log| log.path == *path).cloned();
        longest(pieces.collect())
    };
    let mut logs = [0, 1].map(|folder| of(folder, &logs));
    scale_currents(&mut logs);
    logs[1].must_be_of(&logs[0].robot, &format!("the log {}", logs[0].path.display()))?;
    let pair = compare_pair(&logs[0], &logs[1])
        .into_diagnostic()
        .wrap_err_with(|| format!("{} and {}", first.display(), second.display()))?;
    let mut provenance = of_program("compare");
    provenance.robot = logs[0].robot.name.clone();
    provenance.files = log_digests("log", &logs)?;
    Ok(ComparedPair { logs, pair, provenance })
}
