//! Recorded loads at rest, on which tests build residuals of their own.

use std::sync::LazyLock;
use trueweld_estimate::fit::FitProblem;
use trueweld_estimate::residuals::compare::{baseline, experiments};
use trueweld_logs::campaign::Campaign;
use trueweld_logs::log::Log;
use trueweld_plant::input::ModelFile;

/// The problem of one log of them, for what is compared in it.
pub(crate) static STATIC_LOADS: LazyLock<FitProblem> = LazyLock::new(|| {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/campaigns/backlash");
    let campaign = Campaign::read(folder).unwrap();
    let file = ModelFile::read(&campaign.model).unwrap();
    let loads = campaign.logs.into_iter().filter(|log| log.name == "static");
    let ready = experiments(&loads.collect::<Vec<Log>>(), &baseline(&file)).unwrap();
    FitProblem::new(&file, ready)
});
