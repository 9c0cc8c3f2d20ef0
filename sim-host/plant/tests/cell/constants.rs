//! The constants of a controller: of the embedded cell they are those that the C interface is tested
//! with, and a core runs from them as the simulation does.

use crate::cell::support::{Fixtures, law};
use nalgebra::Vector3;
use trueweld_compensators::{Elastostatic, RunningCore};
use trueweld_core::compensation::{Compensated, Observation};
use trueweld_core::control::{SensorReadings, Setpoint};
use trueweld_core::{JointVector, Wrench};
use trueweld_plant::simulate::{ControllerKind, Scenario, Seam, WeldProgram, start_angles};

/// Calls `with` with the scenario of the embedded files.
fn scenario(name: &str, with: impl FnOnce(&Scenario<'_>)) {
    let (fixtures, law) = (Fixtures::of("vertical"), law(name));
    let cell = fixtures.cell(&[]);
    with(&fixtures.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law));
}

#[test]
fn every_law_of_the_table_has_constants_with_a_digest_of_its_own() {
    let mut digests = std::collections::BTreeSet::new();
    for law in trueweld_compensators::library() {
        scenario(law.name(), |scenario| {
            let constants = scenario.constants().expect("a law of the table");
            assert!(digests.insert(constants.configuration.digest()), "{}", law.name());
            assert!(constants.bytes[0] <= 32768 && constants.bytes[1] <= 65536, "{}", law.name());
        });
    }
}

#[test]
fn any_number_that_changes_changes_the_digest() {
    scenario("adaptive", |scenario| {
        let configuration = scenario.constants().expect("constants").configuration;
        let digest = configuration.digest();
        let mut others = [configuration; 8];
        others[0].robot.joints[5].inertia[5] += 1e-9;
        others[1].robot.table[23][1] = 1.0;
        others[2].robot.tool_y_axis[2] = 1e-12;
        others[3].control.tuned_stiffness += 1.0;
        others[4].control.orientation.rate *= 1.0 + 1e-15;
        others[5].law.following_size += 1e-9;
        others[6].law.gains[3].values[0] += 1e-12;
        others[7].control.force_sensor_force += 1.0;
        for (k, other) in others.iter().enumerate() {
            assert_ne!(other.digest(), digest, "{k}");
        }
    });
}

#[test]
fn a_combination_of_laws_is_refused() {
    scenario("elastostatic+feed-forward", |scenario| {
        let refused = scenario.constants().expect_err("a combination").to_string();
        assert!(refused.contains("elastostatic+feed-forward"), "{refused}");
    });
}

#[test]
fn a_core_built_from_the_constants_commands_what_the_simulation_does() {
    scenario("elastostatic", |scenario| {
        let configuration = scenario.constants().expect("constants").configuration;
        let mut core =
            RunningCore::<f64, Elastostatic<f64>>::new::<Elastostatic<f64>>(&configuration)
                .expect("it was built before");
        let seam = Seam::of(scenario.weld);
        let angles = start_angles(scenario.controller_model, &seam).expect("within reach");
        let torque = JointVector::repeat(1e3);
        let mut hybrid = scenario.build_controller().unwrap();
        let mut law = scenario.build_law().expect("a law");
        let limits = &scenario.control.compensation;
        let mut simulated = Compensated::new(
            &mut *hybrid,
            &mut *law,
            limits.lateral,
            limits.orientation,
            scenario.control.period,
        )
        .with_force_sensor_limits(scenario.sensors.force.limits);
        simulated.start(scenario.controller_model, &angles, &torque);
        core.start(&angles, &torque);
        for k in 0..50 {
            let nominal = seam.nominal(1e-4 * f64::from(k));
            let setpoint = Setpoint {
                pose: nominal,
                b_from_w: seam.b_from_w.rotation,
                force: Some(18e3),
                spindle_speed: scenario.planned.spindle,
            };
            let push = -18e3 + 50.0 * f64::from(k % 5);
            let wrench = Wrench { moment: Vector3::zeros(), force: Vector3::new(0.0, -4e3, push) };
            let robot = scenario.controller_model;
            let frames = robot.frames(&angles);
            let load = wrench.rotated(&frames.tcp.rotation);
            let sensed = SensorReadings {
                encoder: angles,
                encoder_rate: JointVector::zeros(),
                motor_torque: robot.spring_torque_at_rest(&frames, &angles, &load),
                wrench,
            };
            let observation = Observation::of_robot(&setpoint, &nominal, &sensed);
            let expected = simulated.cycle(scenario.controller_model, &observation);
            assert_eq!(expected.fault, None, "period {k}");
            // The same arithmetic, to the last bit.
            assert_eq!(core.cycle(&observation), expected, "period {k}");
            assert_eq!(core.correction(), simulated.correction(), "period {k}");
        }
    });
}

/// Renewed with UPDATE=1 in the environment.
#[test]
fn the_c_interface_is_tested_with_the_constants_of_the_embedded_cell() {
    scenario("elastostatic", |scenario| {
        let constants = scenario.constants().expect("constants");
        let heading = "The embedded cell with the elastostatic law, written by\n\
                       sim-host/plant/tests/cell/constants.rs as trueweld export-core writes it.";
        for (file, text) in [
            ("cell.h", constants.configuration.c_header(heading, constants.bytes)),
            ("cell.rs", constants.configuration.rust_source(heading)),
        ] {
            let path = format!("{}/../../c-interface/examples/{file}", env!("CARGO_MANIFEST_DIR"));
            if std::env::var_os("UPDATE").is_some() {
                std::fs::write(&path, &text).expect("the folder is there");
            }
            let committed = std::fs::read_to_string(&path).expect("the file is there");
            assert!(committed == text, "{file} is not what is written now: run with UPDATE=1");
        }
    });
}
