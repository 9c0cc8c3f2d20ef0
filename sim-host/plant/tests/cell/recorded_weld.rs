//! What a controller is given in every period of a whole weld, as the C program of
//! `c-interface/examples/weld.c` reads it: for the comparison of host and target.

use crate::cell::support::{Fixtures, law};
use nalgebra::Matrix3;
use std::ops::ControlFlow;
use trueweld_core::compensation::{Compensator, Observation};
use trueweld_core::{Fault, Robot, Twist};
use trueweld_plant::input::Weld;
use trueweld_plant::simulate::{ControllerKind, WeldProgram, run_with};

/// A law that writes down what it is given.
struct Recorder {
    law: Box<dyn Compensator<f64>>,
    numbers: Vec<f64>,
    periods: usize,
}

impl Compensator<f64> for Recorder {
    fn reset(&mut self) {
        self.law.reset();
    }

    fn demand(
        &mut self,
        robot: &Robot<f64>,
        observation: &Observation<'_, f64>,
    ) -> Result<Twist<f64>, Fault> {
        self.periods += 1;
        let Observation { setpoint, nominal, sensed, path, planned, measurements, .. } =
            observation;
        let to = &mut self.numbers;
        if to.is_empty() {
            to.extend(sensed.encoder.iter().chain(sensed.motor_torque.iter()));
        }
        to.push(1.0);
        let rows = |m: &Matrix3<f64>| <[f64; 9]>::try_from(m.transpose().as_slice()).expect("nine");
        for pose in [&setpoint.pose, nominal] {
            to.extend(rows(&pose.rotation));
            to.extend(pose.position.iter());
        }
        to.extend(rows(&setpoint.b_from_w));
        to.extend([setpoint.force.unwrap_or(0.0), setpoint.spindle_speed]);
        for six in [&sensed.encoder, &sensed.encoder_rate, &sensed.motor_torque] {
            to.extend(six.iter());
        }
        to.extend(sensed.wrench.to_vector().iter());
        to.push(*path);
        to.extend(planned.to_vector().iter());
        to.push(measurements.len() as f64);
        for m in *measurements {
            to.push(m.deviation);
            to.extend(m.along.to_vector().iter());
            to.extend([m.noise, m.age, m.ahead]);
        }
        self.law.demand(robot, observation)
    }
}

/// The whole first weld where RECORD_WELD names a file to write; else ten centimetres of it.
#[test]
fn a_weld_is_recorded_as_a_controller_is_given_it() {
    let file = std::env::var_os("RECORD_WELD");
    let (mut fixtures, law) = (Fixtures::of("vertical"), law("elastostatic"));
    if file.is_none() {
        let Weld { start, end, .. } = fixtures.weld;
        fixtures.weld.end = start + (end - start).normalize() * 0.1;
    }
    let cell = fixtures.cell(&[]);
    let scenario = fixtures.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law);
    let law = scenario.build_law().expect("a law");
    let mut recorder = Recorder { law, numbers: Vec::new(), periods: 0 };
    run_with(&scenario, &mut recorder, |_| ControlFlow::Continue(())).expect("a weld");
    assert!(recorder.numbers.iter().all(|number| number.is_finite()));
    // Of what each period has at least, and of a seam sensor's readings besides.
    let least = 12 + recorder.periods * 69;
    assert!(recorder.numbers.len() > least, "{} of {least}", recorder.numbers.len());
    if let Some(file) = file {
        let bytes: Vec<u8> = recorder.numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        std::fs::write(file, bytes).expect("the file can be written");
    }
}
