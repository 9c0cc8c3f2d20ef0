//! An effect of one's own, from outside the library: a cable package that pulls back on A1.
//!
//!     cargo run --release -p trueweld-plant --example own_effect
//!
//! The term states what the cable does; the kind says where, with which parameters, and how to
//! build the term. What is built so stands beside the library's effects in every cell and in every
//! fit. The same effect as an expression, with no Rust at all, is
//! `fixtures/models/cable-drag.toml`.

use std::error::Error;
use std::path::Path;
use trueweld_compensators::{Elastostatic, Law};
use trueweld_plant::cell::Cell;
use trueweld_plant::effects::curve::{Curve, CurveAxis, ShownQuantity};
use trueweld_plant::effects::{Action, Effect, EffectKind, Location, LocationKind, Parameter};
use trueweld_plant::input::{Control, InputFile, Process, RobotFile, Sensors, Weld};
use trueweld_plant::integrate::Integrator;
use trueweld_plant::robot::{JointState, Port, Term};
use trueweld_plant::simulate::{Controller, Program, Recording, Scenario, Seam, run};

/// Torque on the link: −(c tanh(θ̇/smoothing) + s θ).
#[derive(Debug)]
struct CableDrag {
    friction: f64,
    stiffness: f64,
}

impl Term for CableDrag {
    fn link_torque(&self, at: &JointState, _counterbalance: f64) -> f64 {
        -(self.friction * (at.link_rate / at.smoothing).tanh() + self.stiffness * at.link)
    }
}

static CABLE_DRAG: EffectKind = EffectKind {
    id: "cable-drag",
    place: LocationKind::Joint,
    equation: "torque on the link −(c tanh(θ̇/smoothing) + s θ)",
    shows: "the tool is drawn back towards the middle of the joint, by more the further it turns",
    experiment: "the joint turned to and fro over its range, tracker",
    parameters: &[
        Parameter::size("friction_nm", "N·m", "friction c of the cable", 20.0, [0.0, 500.0]),
        Parameter::size(
            "stiffness_nm_rad",
            "N·m/rad",
            "stiffness s of the cable",
            500.0,
            [0.0, 2e4],
        ),
    ],
    sentence: "a cable drags on {joint}, with a friction of {0} and a stiffness of {1}",
    curve: Curve::Quantity(
        &[ShownQuantity::port("link-torque", "more torque on the link of {joint}")],
        &[CurveAxis::Angle, CurveAxis::Rate],
    ),
    action: Action::Term {
        port: Port::LinkTorque,
        build: |values, _joint| Box::new(CableDrag { friction: values[0], stiffness: values[1] }),
    },
    ..EffectKind::DEFAULT
};

fn main() -> Result<(), Box<dyn Error>> {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let robot = RobotFile::read(fixtures.join("robots/kr500-mt.toml"))?;
    let process = Process::read(fixtures.join("processes/lap-weld-2024-t3.toml"))?;
    let weld = Weld::read(fixtures.join("welds/vertical.toml"))?;
    let control = Control::read(fixtures.join("control/kr500-mt.toml"))?;
    let sensors = Sensors::read(fixtures.join("sensors/kr500-mt.toml"))?;

    let simulate = |effects: &[Effect]| -> Result<Recording, Box<dyn Error>> {
        let cell = Cell::new(&robot.robot, effects, &process, Seam::of(&weld).b_from_w)?;
        let scenario = Scenario {
            name: "vertical",
            cell: &cell,
            controller_model: &robot.robot,
            planned: &process,
            weld: &weld,
            program: Program::Weld,
            control: &control,
            sensors: &sensors,
            controller: Controller::External,
            law: &Elastostatic::<f64>::entry(),
            integrator: Integrator::LinearlyImplicit,
            plant_step: 1e-3,
            seed: sensors.seed,
            fault: None,
        };
        Ok(run(&scenario, |_| {})?)
    };
    let without = simulate(&[])?;
    let with = simulate(&[Effect {
        kind: &CABLE_DRAG,
        at: Location::Joint(0),
        values: vec![150.0, 4000.0],
    }])?;

    println!("     path   lateral deviation, mm");
    println!("        m    without   with cable   difference");
    let seam = Seam::of(&weld);
    let mut next = 0.0;
    for (a, b) in without.rows.iter().zip(&with.rows) {
        let path = (a.nominal.position - seam.nominal(0.0).position).norm();
        if path >= next {
            let (a, b) = (1e3 * a.deviation_w.linear.y, 1e3 * b.deviation_w.linear.y);
            println!("{path:>9.2} {a:>10.3} {b:>12.3} {:>12.3}", b - a);
            next += 0.25;
        }
    }
    Ok(())
}
