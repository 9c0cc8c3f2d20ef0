//! A weld simulated: with one law or several, side by side.

use crate::cell::{PLANT_STEP, WeldingCell};
use miette::{Result, miette};
use std::sync::atomic::{AtomicU64, Ordering};
use trueweld_compensators::{Entry, Uncompensated};
use trueweld_evaluate::WeldFigures;
use trueweld_plant::provenance::Provenance;
use trueweld_plant::simulate::{
    ControllerKind, Recording, RunError, Scenario, WeldProgram, run_passes,
};

/// Simulates the weld of a cell under control; without a law where none is given.
///
/// The plant is the elastic robot (2.1) with the cell's effects, under the external hybrid
/// controller (2.4)–(2.5) where no other is chosen.
///
/// ```no_run
/// let cell = trueweld::CellFiles::new().read()?;
/// let law = trueweld::law("elastostatic")?;
/// let welds = trueweld::simulate(&cell).law(law).run()?;
/// let lateral = welds.runs[0].figures.lateral.max_abs;
/// println!("{:.2} mm beside the seam", 1e3 * lateral);
/// # Ok::<(), miette::Report>(())
/// ```
pub fn simulate(cell: &WeldingCell) -> SimulateOptions<'_> {
    SimulateOptions {
        cell,
        controller: ControllerKind::EXTERNAL,
        laws: Vec::new(),
        passes: 1,
        plant_step: PLANT_STEP,
        progress: &|_| {},
    }
}

/// How a weld is simulated.
#[must_use]
#[derive(Clone)]
pub struct SimulateOptions<'a> {
    cell: &'a WeldingCell,
    controller: ControllerKind,
    laws: Vec<Entry>,
    passes: usize,
    plant_step: f64,
    progress: &'a (dyn Fn(f64) + Sync),
}

/// Finished welds of one seam.
#[derive(Debug, Clone)]
pub struct SimulatedWelds {
    /// One a law, in their order.
    pub runs: Vec<SimulatedWeld>,
    /// What they are of.
    pub provenance: Provenance,
}

/// One finished weld.
#[derive(Debug, Clone)]
pub struct SimulatedWeld {
    /// What the run left behind: a row a control period, SI units, weld frame W.
    pub recording: Recording,
    /// What it amounts to, over its steady part.
    pub figures: WeldFigures,
}

impl<'a> SimulateOptions<'a> {
    /// Adds a law, which has a run of its own.
    pub fn law(mut self, law: Entry) -> Self {
        self.laws.push(law);
        self
    }

    /// With this hybrid controller.
    pub fn controller(self, controller: ControllerKind) -> Self {
        Self { controller, ..self }
    }

    /// So many welds of the seam one after another, the law kept; the last one counts.
    pub fn passes(self, passes: usize) -> Self {
        Self { passes, ..self }
    }

    /// With plant steps of this length at most, s.
    pub fn plant_step(self, plant_step: f64) -> Self {
        Self { plant_step, ..self }
    }

    /// Tells the simulated time of the run that is furthest, s, over all its passes: every run tells
    /// it, from its own thread.
    pub fn on_progress(self, progress: &'a (dyn Fn(f64) + Sync)) -> Self {
        Self { progress, ..self }
    }

    /// What the welds are of.
    pub fn provenance(&self) -> Provenance {
        let Self { cell, controller, passes, plant_step, .. } = self;
        let simulation = cell.simulation(&[*controller], &self.laws(), *passes, *plant_step);
        cell.provenance("weld", simulation)
    }

    /// The laws that are run.
    fn laws(&self) -> Vec<Entry> {
        match self.laws.as_slice() {
            [] => vec![Entry::of::<Uncompensated>()],
            laws => laws.to_vec(),
        }
    }

    /// One run a law: of several each on its own thread, and the same bytes come out whatever their
    /// number; a single one on the thread of the caller.
    ///
    /// # Errors
    /// A law that needs a sensor that the cell has not; a run that does not come to its end; a weld
    /// too short to reach its steady part.
    pub fn run(&self) -> Result<SimulatedWelds> {
        let Self { cell, controller, .. } = self;
        let laws = self.laws();
        let furthest = AtomicU64::new(0);
        let joined: Vec<_> = match &laws[..] {
            [law] => vec![Ok(self.run_law(law, &furthest))],
            laws => std::thread::scope(|scope| {
                let furthest = &furthest;
                let run = |law| scope.spawn(move || self.run_law(law, furthest));
                let threads: Vec<_> = laws.iter().map(run).collect();
                threads.into_iter().map(|thread| thread.join()).collect()
            }),
        };
        let finished = |joined: std::thread::Result<Result<Recording, RunError>>| {
            let recording = joined
                .map_err(|_| miette!("a simulation thread stopped"))?
                .map_err(|error| cell.failed(*controller, &error))?;
            Ok(recording)
        };
        let recordings = joined.into_iter().map(finished).collect::<Result<Vec<_>>>()?;
        let run = |recording| {
            let figures = WeldFigures::of(&recording).ok_or_else(|| cell.too_short())?;
            Ok(SimulatedWeld { recording, figures })
        };
        let runs = recordings.into_iter().map(run).collect::<Result<_>>()?;
        Ok(SimulatedWelds { runs, provenance: self.provenance() })
    }

    /// `furthest`: bits of the time of the run that is furthest, which of times from 0 on are in the
    /// order of the times.
    fn run_law(&self, law: &Entry, furthest: &AtomicU64) -> Result<Recording, RunError> {
        let scenario = Scenario {
            plant_step: self.plant_step,
            ..self.cell.scenario(WeldProgram::Weld, self.controller, law)
        };
        run_passes(&scenario, self.passes, |time| {
            let time = time.to_bits();
            let before = furthest.fetch_max(time, Ordering::Relaxed);
            (self.progress)(f64::from_bits(before.max(time)));
        })
    }
}
