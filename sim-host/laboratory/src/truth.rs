//! The true cell of a campaign: the model with every effect of the recipe in it.

use crate::error::CampaignError;
use crate::laboratory::Laboratory;
use crate::recipe::Recipe;
use trueweld_plant::cell::Cell;
use trueweld_plant::input::Process;
use trueweld_plant::seam::Seam;

/// The true cell of one campaign.
#[derive(Debug)]
pub(crate) struct Truth<'a> {
    pub laboratory: &'a Laboratory,
    pub recipe: &'a Recipe,
}

impl Truth<'_> {
    /// The cell of one log, welding a seam with the spindle at `spindle`, rad/s.
    /// `log` is the log's number: each log has its own registration of the tracker.
    pub(crate) fn cell(
        &self,
        log: u64,
        seam: impl Into<Seam>,
        spindle: f64,
    ) -> Result<Cell, CampaignError> {
        let recipe = self.recipe;
        let mut effects = recipe.effects.clone();
        effects.extend(recipe.miscalibrations(log));
        let planned = self.laboratory.process.clone();
        let process = Process { spindle, ..planned.unwrap_or_else(Process::none) };
        let mut cell = Cell::new(&self.laboratory.robot.robot, &effects, &process, seam)?;
        if let Some(foreign) = &recipe.out_of_library {
            foreign.install(&mut cell)?;
        }
        Ok(cell)
    }
}
