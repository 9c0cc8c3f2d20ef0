//! The true cell of a campaign: the model with every effect of the recipe in it.

use crate::error::CampaignError;
use crate::laboratory::Laboratory;
use crate::recipe::Recipe;
use trueweld_core::Pose;
use trueweld_plant::cell::Cell;
use trueweld_plant::input::Process;

/// The true cell of one campaign.
#[derive(Debug)]
pub(crate) struct Truth<'a> {
    pub laboratory: &'a Laboratory,
    pub recipe: &'a Recipe,
}

impl Truth<'_> {
    /// The cell of one log, welding in the frame `b_from_w` with the spindle at `spindle`, rad/s.
    /// `log` is the log's number: each log has its own registration of the tracker.
    pub fn cell(&self, log: u64, b_from_w: Pose<f64>, spindle: f64) -> Result<Cell, CampaignError> {
        let recipe = self.recipe;
        let mut effects = recipe.effects.clone();
        effects.extend(recipe.miscalibrations(log));
        let process = Process { spindle, ..self.laboratory.process.clone() };
        let mut cell = Cell::new(&self.laboratory.robot.robot, &effects, &process, b_from_w)?;
        if let Some(foreign) = &recipe.out_of_library {
            foreign.install(&mut cell)?;
        }
        Ok(cell)
    }
}
