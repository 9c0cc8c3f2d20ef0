//! The welding cell of the fixtures, for tests that span the plant.

// Public in one of the crates that take it.
#![allow(unreachable_pub)]

use super::fixture;
use nalgebra::Vector3;
use trueweld_compensators::{Entry, find};
use trueweld_core::{Pose, Robot};
use trueweld_plant::cell::Cell;
use trueweld_plant::effects::Effect;
use trueweld_plant::input::{Control, InputFile, Process, RobotFile, Sensors, Weld};
use trueweld_plant::integrate::Integrator;
use trueweld_plant::robot::{ElasticRobot, Port, Ports, Term};
use trueweld_plant::simulate::{ControllerKind, Recording, Scenario, Seam, WeldProgram, run};

/// The fixtures of one weld.
#[derive(Debug)]
pub struct Fixtures {
    /// Name of the weld file.
    pub name: &'static str,
    /// The KR 500 MT.
    pub robot: RobotFile,
    /// The process.
    pub process: Process,
    /// The weld.
    pub weld: Weld,
    /// Tuned gains.
    pub control: Control,
    /// Instruments.
    pub sensors: Sensors,
}

impl Fixtures {
    /// `name`: `vertical` or `inclined`.
    ///
    /// # Panics
    /// Where a fixture cannot be read.
    pub fn of(name: &'static str) -> Self {
        let weld =
            Weld::read(fixture(&format!("welds/{name}.toml"))).expect("the weld is in order");
        Self {
            name,
            robot: RobotFile::read(fixture("robots/kr500-mt.toml")).expect("the robot is in order"),
            process: Process::read(fixture("processes/lap-weld-2024-t3.toml"))
                .expect("the process is in order"),
            weld,
            control: Control::read(fixture("control/kr500-mt.toml"))
                .expect("the gains are in order"),
            sensors: Sensors::read(fixture("sensors/kr500-mt.toml"))
                .expect("the sensors are in order"),
        }
    }

    /// The cell with effects given as on the command line.
    ///
    /// # Panics
    /// Where an effect is not understood.
    pub fn cell(&self, effects: &[&str]) -> Cell {
        let effects: Vec<_> = effects
            .iter()
            .map(|e| Effect::parse(e, &self.robot).expect("an effect of the library"))
            .collect();
        Cell::new(&self.robot.robot, &effects, &self.process, Seam::real(&self.weld))
            .expect("room for them")
    }

    /// A run of a cell with the default integrator at 1 ms, the controller knowing the robot as
    /// `controller_model`.
    ///
    /// # Panics
    /// Where the run fails.
    pub fn run(
        &self,
        cell: &Cell,
        program: WeldProgram,
        controller: ControllerKind,
        law: &Entry,
        controller_model: &Robot<f64>,
    ) -> Recording {
        run(&Scenario { controller_model, ..self.scenario(cell, program, controller, law) }, |_| {})
            .expect("the run ends")
    }

    /// What such a run is made of, the controller knowing the robot exactly.
    pub fn scenario<'a>(
        &'a self,
        cell: &'a Cell,
        program: WeldProgram,
        controller: ControllerKind,
        law: &'a Entry,
    ) -> Scenario<'a> {
        Scenario {
            name: self.name,
            cell,
            controller_model: &self.robot.robot,
            planned: &self.process,
            weld: &self.weld,
            program,
            control: &self.control,
            sensors: &self.sensors,
            controller,
            law,
            integrator: Integrator::LinearlyImplicit,
            plant_step: 1e-3,
            seed: self.sensors.seed,
            fault: None,
        }
    }
}

/// The law of a name.
///
/// # Panics
/// Where there is none.
pub fn law(name: &str) -> Entry {
    find(name).expect("a law of the table")
}

/// The KR 500 MT in free space (the plate out of reach), with one term at a port if given.
///
/// # Panics
/// Where the fixtures cannot be read.
pub fn free_cell(model: &Robot<f64>, term: Option<(Port, Box<dyn Term>)>) -> Cell {
    let mut ports = Ports::default();
    if let Some((port, term)) = term {
        ports.install(port, term).expect("room for one");
    }
    let mut b_from_w = Pose::identity();
    b_from_w.position = Vector3::new(0.0, 0.0, 100.0);
    let process = Fixtures::of("vertical").process;
    Cell { robot: ElasticRobot { model: model.clone(), ports }, process, seam: b_from_w.into() }
}
