//! The smallest firmware with one law: from the constants that `trueweld export-core` writes to the
//! function that is called every control period. Its size is what core and law take in flash.
#![no_std]
#![no_main]

use core::{hint::black_box, panic::PanicInfo};
use cortex_m_rt::entry;
use nalgebra::Vector3;
use trueweld_compensators::{Elastostatic, RunningCore};
use trueweld_core::compensation::Observation;
use trueweld_core::control::{SensorReadings, Setpoint};
use trueweld_core::{JointVector, Pose, Wrench};

/// What `export-core --compensator elastostatic` writes.
mod cell {
    // The running core tells its digest by itself.
    #![allow(dead_code)]
    include!("../../../c-interface/examples/cell.rs");
}

/// Robot model, controller and law in single precision.
type Core = RunningCore<f32, Elastostatic<f32>>;

unsafe extern "C" {
    /// Defined nowhere: a panic path that is left keeps the program from linking.
    fn a_panic_path_is_left() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: never called, or the program would not exist.
    unsafe { a_panic_path_is_left() }
}

#[entry]
fn main() -> ! {
    let configuration = black_box(&cell::CONFIGURATION);
    if let Ok(mut core) = Core::new::<Elastostatic<f32>>(configuration) {
        let sensed = instruments();
        core.start(&sensed.encoder, &sensed.motor_torque);
        loop {
            black_box(period(&mut core));
        }
    }
    loop {}
}

/// What a control task calls every period: motor torques, N·m.
#[inline(never)]
fn period(core: &mut Core) -> JointVector<f32> {
    let (nominal, setpoint, sensed) = (program(), taught(), instruments());
    core.cycle(&Observation::of_robot(&setpoint, &nominal, &sensed)).torque
}

/// Where the tool is to be: your program's.
fn program() -> Pose<f32> {
    black_box(Pose::identity())
}

/// The set-point as taught: your program's.
fn taught() -> Setpoint<f32> {
    let pose = black_box(Pose::identity());
    black_box(Setpoint { pose, b_from_w: pose.rotation, force: Some(18e3), spindle_speed: -62.8 })
}

/// Encoders, drives and force sensor: your part's.
fn instruments() -> SensorReadings<f32> {
    let six = black_box(JointVector::zeros());
    let wrench = Wrench { moment: Vector3::zeros(), force: Vector3::z() };
    black_box(SensorReadings { encoder: six, encoder_rate: six, motor_torque: six, wrench })
}
