//! Turns the robot file into constants, and runs the weld in double precision for the program to be
//! judged by.

#[path = "src/weld.rs"]
mod weld;

use std::{env, fs, path::PathBuf};
use toml::{Table, Value};
use trueweld_core::compensation::Observation;
use trueweld_core::monitor::HealthMonitor;
use weld::{CYCLES, Joint, Numbers, PERIOD, Weld, nominal, watch};

const ROBOT: &str = "../../fixtures/robots/kr500-mt.toml";

fn main() {
    println!("cargo::rerun-if-changed={ROBOT}");
    println!("cargo::rerun-if-changed=src/weld.rs");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    if env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none") {
        // Where the linker script of the start-up code looks for it.
        fs::copy("memory.x", out.join("memory.x")).expect("the build directory can be written");
        println!("cargo::rerun-if-changed=memory.x");
        println!("cargo::rustc-link-search={}", out.display());
    }
    let text = fs::read_to_string(ROBOT).expect("the robot file is there");
    let numbers = numbers(&text.parse().expect("the robot file is TOML"));
    let robot = numbers.robot::<f64>().expect("the robot file is a robot");
    let all = robot.inverse_all(&nominal(0)).expect("the weld is within reach");
    let start = all
        .iter()
        .map(|(_, q)| *q)
        .find(|q| robot.beyond_limits(q).is_none())
        .expect("a branch within limits");
    let start: [f64; 6] = start.into();
    let mut weld = Weld::<f64>::new(&numbers, &start).expect("the weld is within reach");
    let expected: Vec<[f64; 6]> = (0..CYCLES)
        .map(|k| {
            let inputs = weld.inputs(k).expect("the weld is within reach");
            let command = weld.law.cycle(
                &weld.robot,
                &Observation::of_robot(&inputs.setpoint, &inputs.nominal, &inputs.sensed),
            );
            assert_eq!(command.fault, None, "cycle {k}");
            weld.follow(&inputs, &command, weld.law.correction())
                .expect("the corrected weld is within reach");
            command.torque.into()
        })
        .collect();
    // In single precision: what the watch sees is to be the same to the last bit.
    let mut weld = Weld::<f32>::new(&numbers, &start).expect("the weld is within reach");
    let mut monitor = HealthMonitor::new(PERIOD as f32).expect("a period");
    let health = (0..CYCLES)
        .map(|k| {
            let inputs = weld.inputs(k).expect("the weld is within reach");
            let observation =
                Observation::of_robot(&inputs.setpoint, &inputs.nominal, &inputs.sensed);
            let command = weld.law.cycle(&weld.robot, &observation);
            weld.follow(&inputs, &command, weld.law.correction())
                .expect("the corrected weld is within reach");
            watch(&mut monitor, &inputs)
        })
        .last()
        .expect("a weld has cycles");
    // How Debug writes structs and arrays of numbers is how Rust reads them.
    let source = format!(
        "/// The robot file.\npub static ROBOT: Numbers = {numbers:?};\n\
         /// Joint angles at the start of the weld, rad.\npub static START: [f64; 6] = {start:?};\n\
         /// Torques of every cycle in double precision, N·m.\n\
         pub static EXPECTED: [[f64; 6]; CYCLES] = {expected:?};\n\
         /// What the watch sees in the last cycle, in single precision.\n\
         pub static HEALTH: HealthSignals = {health:?};\n"
    );
    fs::write(out.join("host.rs"), source).expect("the build directory can be written");
}

fn numbers(file: &Table) -> Numbers {
    let (tool, friction) = (&file["tool"], &file["friction"]);
    let joint = |i: usize| {
        let j = &file["joint"][i];
        Joint {
            origin: list(&j["origin_m"]),
            axis: list(&j["axis"]),
            limits: list(&j["limits_deg"]).map(f64::to_radians),
            max_rate: number(&j["max_speed_deg_s"]).to_radians(),
            max_torque: number(&j["max_torque_nm"]),
            stiffness: number(&j["stiffness_nm_rad"]),
            damping: number(&j["damping_nms_rad"]),
            rotor_inertia: number(&j["rotor_inertia_kg_m2"]),
            mass: number(&j["mass_kg"]),
            center_of_mass: list(&j["com_m"]),
            inertia: inertia(j),
        }
    };
    Numbers {
        gravity: list(&file["gravity_m_s2"]),
        joints: std::array::from_fn(joint),
        viscous: list(&friction["viscous_nms_rad"]),
        coulomb: list(&friction["coulomb_nm"]),
        smoothing: number(&friction["smoothing_rad_s"]),
        counterbalance: list(&file["counterbalance"]["cos_nm"]),
        flange_offset: list(&tool["flange_offset_m"]),
        tool_mass: number(&tool["mass_kg"]),
        com_from_flange: list(&tool["com_from_flange_m"]),
        tool_inertia: inertia(tool),
        tcp_from_flange: list(&tool["tcp_from_flange_m"]),
        z_axis: list(&tool["z_axis"]),
        y_axis: list(&tool["y_axis"]),
    }
}

fn number(v: &Value) -> f64 {
    v.as_float().or(v.as_integer().map(|i| i as f64)).expect("a number")
}

fn list<const N: usize>(v: &Value) -> [f64; N] {
    let all = v.as_array().expect("a list");
    assert_eq!(all.len(), N);
    std::array::from_fn(|i| number(&all[i]))
}

fn inertia(body: &Value) -> [f64; 6] {
    ["xx", "yy", "zz", "xy", "xz", "yz"].map(|key| number(&body["inertia_kg_m2"][key]))
}
