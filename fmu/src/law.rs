//! A law as a model: the controller of a cell with the law on top, as `trueweld weld` runs it.

use crate::groups::{Commanded, Seen};
use crate::model::{Model, Stepped};
use crate::variable::{Causality, PhysicalQuantity, ValueKind, VariableGroup, VariableTable};
use std::ops::Range;
use trueweld::WeldingCell;
use trueweld::laws::{Entry, OwnedLaw};
use trueweld_core::state::{StateError, StateResult, StateVisitor, Stateful};
use trueweld_plant::controllers::{ControllerKind, PlantController};
use trueweld_plant::simulate::{ControlSide, LimitKind, Scenario, WeldProgram};

/// Before the names of gains, so that none is that of another variable.
const GAIN_PREFIX: &str = "gain_";

/// A gain that is a parameter.
#[derive(Debug, Clone)]
struct GainParameter {
    key: String,
    is_list: bool,
    places: Range<usize>,
}

/// A controller with its law.
pub(crate) struct LawModel {
    cell: WeldingCell,
    controller: ControllerKind,
    law: Entry,
    table: VariableTable,
    gains: Vec<GainParameter>,
    inputs: Range<usize>,
    outputs: Range<usize>,
    side: Option<ControlSide<Box<dyn PlantController>, OwnedLaw>>,
    started: bool,
}

impl LawModel {
    /// The law of a cell. The gains are those of its control file, or the law's own.
    pub(crate) fn new(cell: WeldingCell, controller: ControllerKind, law: Entry) -> Self {
        let mut table = VariableTable::new();
        let mut gains = Vec::new();
        for (key, value) in law.gains(&cell.control.laws) {
            // Gains that are no numbers stay as they are.
            let Some((is_list, start)) = numbers(&value) else { continue };
            let kind = ValueKind::Real(PhysicalQuantity::of_key(&key));
            let dimensions: &[usize] = if is_list { &[start.len()] } else { &[] };
            let first = table.start.len();
            table.add(
                format!("{GAIN_PREFIX}{key}"),
                format!("Gain {key} of the law {}", law.name()),
                (kind, Causality::Parameter),
                dimensions,
                &start,
            );
            gains.push(GainParameter { key, is_list, places: first..table.start.len() });
        }
        let inputs = table.group(&Seen::nothing(), Causality::Input);
        let outputs = table.group(&Commanded::ZERO, Causality::Output);
        Self { cell, controller, law, table, gains, inputs, outputs, side: None, started: false }
    }

    fn scenario(&self) -> Scenario<'_> {
        self.cell.scenario(WeldProgram::Weld, self.controller, &self.law)
    }
}

/// A gain's numbers, and whether it is a list of them; `None` where it is none of numbers.
fn numbers(value: &toml::Value) -> Option<(bool, Vec<f64>)> {
    let number = |value: &toml::Value| {
        value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
    };
    match value.as_array() {
        Some(list) => Some((true, list.iter().map(number).collect::<Option<_>>()?)),
        None => Some((false, vec![number(value)?])),
    }
}

impl Model for LawModel {
    fn table(&self) -> &VariableTable {
        &self.table
    }

    fn period(&self) -> f64 {
        self.cell.control.period
    }

    fn duration(&self) -> f64 {
        let seam = trueweld_plant::seam::Seam::of(&self.cell.weld);
        WeldProgram::Weld.duration(&self.cell.weld, &seam)
    }

    fn initialise(&mut self, values: &mut [f64]) -> Result<(), String> {
        let mut own = self.law.gains(&self.cell.control.laws);
        for GainParameter { key, is_list, places } in &self.gains {
            let numbers = &values[places.clone()];
            let value = if *is_list { numbers.to_vec().into() } else { numbers[0].into() };
            own.insert(key.clone(), value);
        }
        self.cell.control.laws.insert(self.law.name().to_owned(), own);
        let scenario = self.scenario();
        let law = scenario.build_law().map_err(|error| error.to_string())?;
        let hybrid = scenario.build_controller().map_err(|error| error.to_string())?;
        let side = ControlSide::new(&scenario, hybrid, OwnedLaw(law));
        (self.side, self.started) = (Some(side), false);
        Commanded::ZERO.store(&mut values[self.outputs.clone()]);
        Ok(())
    }

    fn step(&mut self, values: &mut [f64]) -> Result<Stepped, String> {
        let seen = Seen::load(&values[self.inputs.clone()]);
        let measurements = seen.measurements()?;
        let side = self.side.as_mut().ok_or("the law was not initialised")?;
        let model = &self.cell.controller_model;
        if !self.started {
            let [encoder, torque] = seen.start();
            if !encoder.iter().chain(&torque).all(|number| number.is_finite()) {
                return Err("a weld cannot start from encoders or torques that are NaN".to_owned());
            }
            side.start(model, &encoder, &torque);
            self.started = true;
        }
        let reference = seen.reference();
        let controlled = side.cycle(model, &reference, &seen.sensed(), &measurements);
        Commanded::of(&controlled, &reference).store(&mut values[self.outputs.clone()]);
        Ok(match controlled.command.fault {
            None => Stepped::Well,
            Some(fault) => {
                Stepped::Warned(format!("{}; the torque is a safe one", LimitKind::Fault(fault)))
            }
        })
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.flag(&mut self.started)?;
        self.side.as_mut().ok_or(StateError::Length)?.visit_state(visitor)
    }

    fn restored(&mut self) {}
}
