//! The control law as a controller runs it: in `f32`, without std, without an allocator, without
//! panics.
//!
//! That this program links is the proof, for the core and the compensators and all they import:
//!
//! * It has its own panic handler. Were std anywhere in it, there would be two.
//! * It names no global allocator. Were `alloc` anywhere in it, there would be none.
//! * The panic handler calls a function that does not exist. Were there one panic path that the
//!   optimiser cannot rule out – an index that may be out of bounds, a slice of the wrong length –
//!   the linker would ask for it.
//!
//! It prints nothing and ends with 0 where all torques agree with double precision on the host, 1
//! where the robot or the weld is refused, 2 after a fault, 3 where a torque is off, and 4 where the
//! watch beside the law sees in `f32` anything but what it does on the host.
#![no_std]
#![no_main]

#[cfg(target_os = "none")]
mod cortex_m7;
#[cfg(not(target_os = "none"))]
mod host;
mod others;
mod weld;

use core::{hint::black_box, panic::PanicInfo};
use host_tables::{EXPECTED, HEALTH, ROBOT, START};
use trueweld_core::compensation::Observation;
use trueweld_core::control::DriveCommand;
use trueweld_core::monitor::{HealthMonitor, HealthSignals};
use trueweld_core::{Real, Robot};
use weld::{Inputs, Law, PERIOD, Weld};

/// What the build script wrote: the robot file, the start of the weld, and the torques in double
/// precision.
mod host_tables {
    // Some joint angle is a quarter turn.
    #![allow(clippy::approx_constant)]
    use crate::weld::{CYCLES, Joint, Numbers};
    use trueweld_core::monitor::{DriveSignal, HealthSignals, LineSignal};
    include!(concat!(env!("OUT_DIR"), "/host.rs"));
}

unsafe extern "C" {
    /// Defined nowhere: a panic path that is left keeps the program from linking.
    fn a_panic_path_is_left() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: never called, or the program would not exist.
    unsafe { a_panic_path_is_left() }
}

/// How far a torque in `f32` may be off, as a share of the drive's limit. A pose at 2 m is known to
/// some 2e-7 m; through J⁻¹ and K_d over one period that is tens of N·m of drives that give 29
/// kN·m. Measured 6.6e-4.
const BOUND: f64 = 2e-3;

/// What runs every period, and is measured by itself.
#[derive(Debug, Clone, Copy)]
pub enum Work {
    /// Controller and law.
    Law,
    /// The watch beside them.
    Health,
}

/// The whole weld; 0 where its torques are within `bound` of the host's. `measured` is called
/// around everything that runs in a control cycle.
fn run<T: Real + Into<f64>>(bound: f64, mut measured: impl FnMut(Work, &mut dyn FnMut())) -> i32 {
    // Nothing of the robot or its instruments may be known to the optimiser, or it would prove the
    // absence of panics for this weld alone.
    let Some(mut weld) = Weld::<T>::new(black_box(&ROBOT), black_box(&START)) else {
        return 1;
    };
    let Some(mut monitor) = HealthMonitor::new(black_box(PERIOD as f32)) else {
        return 1;
    };
    let mut health = HealthSignals::default();
    for (k, expected) in EXPECTED.iter().enumerate() {
        let Some(inputs) = weld.inputs(k) else {
            return 1;
        };
        let inputs = black_box(inputs);
        let mut command = None;
        let law = &mut || command = Some(cycle(&mut weld.law, black_box(&weld.robot), &inputs));
        measured(Work::Law, law);
        measured(Work::Health, &mut || health = watch(&mut monitor, &inputs));
        let Some(command) = command else { return 1 };
        if command.fault.is_some() {
            return 2;
        }
        for ((torque, expected), joint) in command.torque.iter().zip(expected).zip(&ROBOT.joints) {
            // Also false where the torque is no number.
            let agrees = ((*torque).into() - expected).abs() <= bound * joint.max_torque;
            if !agrees {
                return 3;
            }
        }
        others::link(&weld.robot, &inputs);
        let correction = weld.law.correction();
        if weld.follow(&inputs, &command, correction).is_none() {
            return 1;
        }
    }
    // What the watch is given in double precision differs.
    if size_of::<T>() == size_of::<f32>() && health != HEALTH { 4 } else { 0 }
}

/// The watch over one cycle.
#[inline(never)]
fn watch<T: Real + Into<f64>>(monitor: &mut HealthMonitor, inputs: &Inputs<T>) -> HealthSignals {
    weld::watch(monitor, inputs)
}

/// One control cycle: what a controller calls every period.
#[inline(never)]
fn cycle<T: Real>(law: &mut Law<T>, robot: &Robot<T>, inputs: &Inputs<T>) -> DriveCommand<T> {
    law.cycle(robot, &Observation::of_robot(&inputs.setpoint, &inputs.nominal, &inputs.sensed))
}
