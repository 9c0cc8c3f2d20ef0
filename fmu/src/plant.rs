//! A cell as a model: robot with its effects, process, instruments and the weld's program, driven
//! by motor torques or, with its controller inside, by a correction.

use crate::groups::{CellParameters, DrivenByCorrection, DrivenByTorque, Seen, Shown};
use crate::model::{Model, Stepped};
use crate::variable::{Causality, VariableGroup, VariableTable};
use std::cell::Cell as Shared;
use std::ops::Range;
use std::rc::Rc;
use trueweld::WeldingCell;
use trueweld::laws::{Entry, Uncompensated};
use trueweld_core::compensation::{Compensator, Observation};
use trueweld_core::state::{StateError, StateResult, StateVisitor, Stateful};
use trueweld_core::{Fault, JOINTS, JointVector, Robot, Twist};
use trueweld_plant::controllers::{ControllerKind, PlantController};
use trueweld_plant::named;
use trueweld_plant::seam::Seam;
use trueweld_plant::simulate::{CellView, ControlSide, OpenCell, Scenario, WeldProgram};

named! {
    /// What drives a cell.
    pub enum CellInput {
        /// Motor torques: the controller is outside.
        Torque = "torque",
        /// A correction of the set-point: the controller is inside, as behind a pose correction
        /// interface.
        Correction = "correction",
    }
}

/// A law that demands what it is told.
struct GivenCorrection(Rc<Shared<Twist<f64>>>);

impl Compensator<f64> for GivenCorrection {
    fn reset(&mut self) {}

    fn demand(&mut self, _: &Robot<f64>, _: &Observation<'_, f64>) -> Result<Twist<f64>, Fault> {
        let demand = self.0.get();
        if demand.is_finite() { Ok(demand) } else { Err(Fault::Compensation) }
    }

    fn visit_state(&mut self, _: &mut dyn StateVisitor) -> StateResult {
        // It is told anew every period.
        Ok(())
    }
}

/// The controller of a cell that has it inside.
struct Inside {
    side: ControlSide<Box<dyn PlantController>, GivenCorrection>,
    demand: Rc<Shared<Twist<f64>>>,
}

/// Places of the variables in the row.
struct CellPlaces {
    parameters: Range<usize>,
    inputs: Range<usize>,
    seen: Range<usize>,
    shown: Range<usize>,
}

/// A simulated cell.
pub(crate) struct CellModel {
    cell: WeldingCell,
    controller: ControllerKind,
    input: CellInput,
    /// Without one: what laws demand comes from outside.
    law: Entry,
    table: VariableTable,
    places: CellPlaces,
    open: Option<OpenCell>,
    inside: Option<Inside>,
}

impl CellModel {
    /// A cell with its weld, at rest with the tool in the material.
    ///
    /// # Errors
    /// A start that cannot be: the arm does not hold it.
    pub(crate) fn new(
        cell: WeldingCell,
        controller: ControllerKind,
        input: CellInput,
    ) -> Result<Self, String> {
        let law = Entry::of::<Uncompensated>();
        let scenario = cell.scenario(WeldProgram::Weld, controller, &law);
        let open = OpenCell::new(&scenario).map_err(|error| error.to_string())?;
        let seed = i32::try_from(cell.seed).map_err(|_| {
            format!("the seed {} does not fit into 31 bits; expected a smaller one", cell.seed)
        })?;
        let mut table = VariableTable::new();
        let parameters = CellParameters { seed: f64::from(seed) };
        let parameters = table.group(&parameters, Causality::Parameter);
        let inputs = match input {
            // One that nobody drives stays where it is for the first period.
            CellInput::Torque => {
                let torque = open.start()[1].into();
                table.group(&DrivenByTorque { torque }, Causality::Input)
            }
            CellInput::Correction => table.group(&DrivenByCorrection::ZERO, Causality::Input),
        };
        let seen = table.group(&Seen::nothing(), Causality::Output);
        let shown = table.group(&Shown::ZERO, Causality::Output);
        let places = CellPlaces { parameters, inputs, seen, shown };
        Ok(Self { cell, controller, input, law, table, places, open: None, inside: None })
    }

    fn scenario(&self) -> Scenario<'_> {
        self.cell.scenario(WeldProgram::Weld, self.controller, &self.law)
    }

    /// Torques that drives give which are asked for these, N·m, and which of them are held: bit 0
    /// is A1.
    fn within_limits(&self, asked: &JointVector<f64>) -> (JointVector<f64>, u8) {
        let joints = &self.cell.robot.robot.parameters().joints;
        let most = |joint: usize| joints[joint].max_torque;
        let held = (0..JOINTS).filter(|joint| asked[*joint].abs() > most(*joint));
        let held = held.fold(0, |bits, joint| bits | 1 << joint);
        (asked.map_with_location(|joint, _, torque| torque.clamp(-most(joint), most(joint))), held)
    }

    /// The torque of this period, N·m, and the drives that are held at their limit.
    fn torque(&mut self, values: &[f64]) -> Result<(JointVector<f64>, u8), String> {
        let given = &values[self.places.inputs.clone()];
        let Some(Inside { side, demand }) = &mut self.inside else {
            let torque = JointVector::from(DrivenByTorque::load(given).torque);
            if !torque.iter().all(|torque| torque.is_finite()) {
                return Err("a motor torque is NaN or infinite".to_owned());
            }
            return Ok(self.within_limits(&torque));
        };
        let correction = DrivenByCorrection::load(given).demand();
        if !correction.is_finite() {
            return Err("the correction is NaN or infinite".to_owned());
        }
        demand.set(correction);
        let seen = Seen::load(&values[self.places.seen.clone()]);
        let (reference, sensed) = (seen.reference(), seen.sensed());
        let model = &self.cell.controller_model;
        let controlled = side.cycle(model, &reference, &sensed, &seen.measurements()?);
        Ok(self.within_limits(&controlled.command.torque))
    }

    /// Reads instruments and truth into the row.
    fn show(&mut self, held: u8, values: &mut [f64]) -> Result<(), String> {
        let scenario = self.cell.scenario(WeldProgram::Weld, self.controller, &self.law);
        let open = self.open.as_mut().ok_or("the cell was not initialised")?;
        let view = open.observe(&scenario);
        Seen::of(&view, &open.start())?.store(&mut values[self.places.seen.clone()]);
        shown(open, &view, held).store(&mut values[self.places.shown.clone()]);
        Ok(())
    }
}

/// What a cell shows beyond its instruments.
fn shown(open: &OpenCell, view: &CellView, held: u8) -> Shown {
    let motion = open.motion();
    let (drives, at) = (motion.state.drives(), &motion.at);
    let (tcp, deviation) = (&at.frames.tcp, &view.readings.deviation_w);
    Shown {
        link: drives.link.into(),
        link_rate: drives.link_rate.into(),
        motor: drives.motor.into(),
        motor_rate: drives.motor_rate.into(),
        tool_rotation: tcp.rotation.transpose().into(),
        tool_position: tcp.position.into(),
        deviation_rotation: deviation.angular.into(),
        deviation_translation: deviation.linear.into(),
        process_force: at.reaction.force.into(),
        spindle_angle: motion.state.spindle_angle(),
        applied_torque: (*open.torque()).into(),
        torque_held: f64::from(held),
        phase: f64::from(view.target.phase as u8),
        done: f64::from(open.is_done()),
    }
}

impl Model for CellModel {
    fn table(&self) -> &VariableTable {
        &self.table
    }

    fn period(&self) -> f64 {
        self.cell.control.period
    }

    fn duration(&self) -> f64 {
        WeldProgram::Weld.duration(&self.cell.weld, &Seam::of(&self.cell.weld))
    }

    fn initialise(&mut self, values: &mut [f64]) -> Result<(), String> {
        let CellParameters { seed } = CellParameters::load(&values[self.places.parameters.clone()]);
        if seed < 0.0 {
            return Err(format!("the seed is {seed}; expected 0 or more"));
        }
        self.cell.seed = seed as u64;
        let scenario = self.scenario();
        let open = OpenCell::new(&scenario).map_err(|error| error.to_string())?;
        let inside = if self.input == CellInput::Correction {
            let hybrid = scenario.build_controller().map_err(|error| error.to_string())?;
            let demand = Rc::new(Shared::new(Twist::zero()));
            let law = GivenCorrection(Rc::clone(&demand));
            let mut side = ControlSide::new(&scenario, hybrid, law);
            let [encoder, torque] = open.start();
            side.start(scenario.controller_model, &encoder, &torque);
            Some(Inside { side, demand })
        } else {
            None
        };
        (self.open, self.inside) = (Some(open), inside);
        self.show(0, values)
    }

    fn step(&mut self, values: &mut [f64]) -> Result<Stepped, String> {
        let (torque, held) = self.torque(values)?;
        let scenario = self.cell.scenario(WeldProgram::Weld, self.controller, &self.law);
        let open = self.open.as_mut().ok_or("the cell was not initialised")?;
        open.command(&torque);
        open.advance(&scenario).map_err(|error| error.to_string())?;
        self.show(held, values)?;
        Ok(match held {
            0 => Stepped::Well,
            _ => Stepped::Warned("a drive was asked for more than its largest torque".to_owned()),
        })
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.open.as_mut().ok_or(StateError::Length)?.visit_state(visitor)?;
        self.inside.as_mut().map_or(Ok(()), |inside| inside.side.visit_state(visitor))
    }

    fn restored(&mut self) {
        let scenario = self.cell.scenario(WeldProgram::Weld, self.controller, &self.law);
        if let Some(open) = &mut self.open {
            open.evaluate(&scenario);
        }
    }
}
