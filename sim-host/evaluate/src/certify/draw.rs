//! The cells of a certification: the nominal one, and how a drawn one differs from it.

use crate::margins::{Margins, OperatingPoint, sector_margins};
use crate::uncertain::UncertainCell;
use nalgebra::SVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_core::{JointVector, Robot};
use trueweld_plant::cell::Cell;
use trueweld_plant::effects::{Effect, force_crosstalk};
use trueweld_plant::input::{Process, Sensors, Weld};
use trueweld_plant::simulate::{Recording, RunError, Scenario, Seam, run_passes};

/// What every cell of a certification is made from: a robot, and the effects that it has whatever
/// else is drawn.
#[derive(Debug, Clone, Copy)]
pub struct NominalCell<'a> {
    /// The robot as it is believed to be.
    pub robot: &'a Robot<f64>,
    /// Effects of the real cell, of the command line and the model file.
    pub effects: &'a [Effect],
    /// What is not known of it.
    pub uncertain: &'a UncertainCell,
}

impl NominalCell<'_> {
    /// The cell with what was drawn: factors on the robot's stiffness, cross-talk of the force
    /// sensor and drawn effects beside the cell's own, the seam where it really lies. `process` is
    /// taken as it is.
    ///
    /// # Errors
    /// [`RunError::Cell`] where no cell can be built.
    pub fn build(
        &self,
        draw: &SampledCell,
        process: &Process,
        weld: &Weld,
    ) -> Result<Cell, RunError> {
        let factor: JointVector<f64> = SVector::from(draw.stiffness);
        let robot = self.robot.with_stiffness_scaled(&factor).map_err(|_| RunError::Cell)?;
        let crosstalk = force_crosstalk::effect(draw.crosstalk);
        let values = self.uncertain.values(&draw.latents);
        let mut effects = self.uncertain.effects(self.effects, &values, self.robot);
        effects.push(crosstalk);
        let seam = self.uncertain.seam(&values, Seam::real(weld));
        Cell::new(&robot, &effects, process, seam).map_err(|_| RunError::Cell)
    }

    /// Margins of the loop at an operating point with what was drawn of cell, process without its
    /// ripple, and instruments.
    ///
    /// # Errors
    /// [`RunError`].
    pub(crate) fn margins(
        &self,
        scenario: &Scenario<'_>,
        draw: &SampledCell,
        at: &OperatingPoint,
    ) -> Result<Vec<Margins>, RunError> {
        let values = self.uncertain.values(&draw.latents);
        let mut process = draw.process(scenario.planned).even();
        self.uncertain.change_process(&values, scenario.planned, &mut process);
        let cell = self.build(draw, &process, scenario.weld)?;
        let mut sensors = draw.sensors(scenario.sensors, scenario.control.period);
        self.uncertain.change_sensors(&values, &mut sensors);
        sector_margins(&Scenario { cell: &cell, sensors: &sensors, ..*scenario }, at)
    }

    /// Welds with what was drawn of cell, process and instruments; the scenario's own cell is not
    /// used.
    ///
    /// # Errors
    /// [`RunError`].
    pub(crate) fn weld(
        &self,
        scenario: &Scenario<'_>,
        draw: &SampledCell,
        passes: usize,
    ) -> Result<Recording, RunError> {
        let values = self.uncertain.values(&draw.latents);
        let mut process = draw.process(scenario.planned);
        self.uncertain.change_process(&values, scenario.planned, &mut process);
        let cell = self.build(draw, &process, scenario.weld)?;
        let mut sensors = draw.sensors(scenario.sensors, scenario.control.period);
        self.uncertain.change_sensors(&values, &mut sensors);
        let scenario = Scenario { cell: &cell, sensors: &sensors, seed: draw.noise, ..*scenario };
        run_passes(&scenario, passes, |_| {})
    }
}

/// What a cell turned out to be, relative to what it is believed to be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SampledCell {
    /// Factor on every joint's stiffness.
    pub stiffness: [f64; 6],
    /// Factors on depth stiffness and damping, feed drag, lateral damping, lateral stiffness,
    /// lateral ratio.
    pub process: [f64; 5],
    /// Factor on the ripple's amplitude, and what is added to its phases, rad.
    pub ripple: [f64; 2],
    /// What the force sensor shows along x and y of T per axial force.
    pub crosstalk: [f64; 2],
    /// Delay of force sensor and seam sensor, control periods.
    pub delay: f64,
    /// Seed of the instruments' noise.
    pub noise: u64,
    /// Standard normals behind the numbers of `[[uncertain]]`; none in the nominal cell.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub latents: Vec<f64>,
}

impl SampledCell {
    /// The cell of trial `index`.
    pub fn new(uncertain: &UncertainCell, seed: u64, index: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(index);
        let mut within = |half: f64| half * (2.0 * random.random::<f64>() - 1.0);
        let u = &uncertain.short;
        Self {
            stiffness: [0, 1, 2, 3, 4, 5].map(|joint| 1.0 + within(uncertain.stiffness(joint))),
            process: [(); 5].map(|()| 1.0 + within(u.process)),
            ripple: [1.0 + within(u.ripple), within(std::f64::consts::PI)],
            crosstalk: [(); 2].map(|()| within(u.crosstalk)),
            delay: 0.5 * (u.delay[0] + u.delay[1]) + within(0.5 * (u.delay[1] - u.delay[0])),
            noise: random.random(),
            latents: uncertain.draw(seed, index),
        }
    }

    /// The cell as it is believed to be, with instruments without cross-talk and as late as their
    /// file says.
    pub fn nominal(noise: u64) -> Self {
        Self {
            stiffness: [1.0; 6],
            process: [1.0; 5],
            ripple: [1.0, 0.0],
            crosstalk: [0.0; 2],
            delay: 0.0,
            noise,
            latents: Vec::new(),
        }
    }

    /// The process of this cell.
    fn process(&self, nominal: &Process) -> Process {
        let mut process = nominal.clone();
        for (key, factor) in process.kind().drawn {
            process.scale(key, self.process[*factor]);
        }
        for line in &mut process.ripple {
            line.axial *= self.ripple[0];
            line.in_plane *= self.ripple[0];
            line.phase += self.ripple[1];
        }
        process
    }

    /// The instruments of this cell; `period`: of control, s.
    fn sensors(&self, nominal: &Sensors, period: f64) -> Sensors {
        let mut sensors = nominal.clone();
        let delay = self.delay * period;
        sensors.force.delay = sensors.force.delay.max(delay);
        if let Some(seam) = &mut sensors.seam {
            seam.delay = seam.delay.max(delay);
        }
        sensors
    }
}
