//! `trueweld study`: where a weld's figures come from, and how far they can be driven.

mod paper;
mod sensitivity;
mod sweep;

use clap::Subcommand;
use miette::Result;

/// Studies of a cell.
#[derive(Subcommand)]
pub enum Study {
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
pub fn run(study: &Study) -> Result<()> {
    match study {
        Study::Sensitivity(arguments) => sensitivity::run(arguments),
        Study::Paper(arguments) => paper::run(arguments),
    }
}
