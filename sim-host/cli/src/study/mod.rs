//! `trueweld study`: where to put a part, how far its weld can be driven, what its figures follow from,
//! and what the published study shows.

mod grid;
mod layout;
mod limits;
mod paper;
mod sensitivity;
mod sweep;

use clap::Subcommand;
use miette::Result;

/// Studies of a cell.
#[derive(Subcommand)]
pub(crate) enum Study {
    /// Find where a part is best put, and the arm's posture there
    ///
    /// Every placement of a family by statics and kinematics, the best one searched between them and
    /// confirmed by full runs. The page goes to out/study-layout.html where --html does not say
    /// otherwise.
    Layout(layout::Arguments),
    /// Find the largest push, feed and offset of the seam that keep requirements, and what limits them
    ///
    /// The page goes to out/study-limits.html where --html does not say otherwise.
    Limits(limits::Arguments),
    /// Show which of the uncertain numbers of a cell a weld's figures follow from
    ///
    /// Derivatives about the middle of what the requirements call uncertain, and Sobol indices with
    /// intervals over all of it. The page goes to out/study-sensitivity.html where --html does not
    /// say otherwise.
    Sensitivity(sensitivity::Arguments),
    /// Show the figures of the published study beside ours, on one page
    ///
    /// The page goes to out/study-paper.html where --html does not say otherwise.
    Paper(paper::Arguments),
}

/// Runs a study.
pub(crate) fn run(study: &Study) -> Result<()> {
    match study {
        Study::Layout(arguments) => layout::run(arguments),
        Study::Limits(arguments) => limits::run(arguments),
        Study::Sensitivity(arguments) => sensitivity::run(arguments),
        Study::Paper(arguments) => paper::run(arguments),
    }
}
