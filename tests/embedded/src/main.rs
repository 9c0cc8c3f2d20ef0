//! The control law as a controller runs it: in `f32`, without std, without an allocator, without panics.
//!
//! That this program links is the proof, for the core and the compensators and all they import:
//!
//! * It has its own panic handler. Were std anywhere in it, there would be two.
//! * It names no global allocator. Were `alloc` anywhere in it, there would be none.
//! * The panic handler calls a function that does not exist. Were there one panic path that the optimiser cannot rule out
//!   – an index that may be out of bounds, a slice of the wrong length – the linker would ask for it.
//!
//! It prints nothing and ends with 0 where all torques agree with double precision on the host, 1 where the robot or the
//! weld is refused, 2 after a fault, and 3 where a torque is off.
#![no_std]
#![no_main]

mod host;
mod weld;

use core::hint::black_box;
use weld::{CYCLES, Numbers, Weld};

include!(concat!(env!("OUT_DIR"), "/host.rs"));

/// How far a torque in `f32` may be off, as a share of the drive's limit. A pose at 2 m is known to some 2e-7 m; through
/// J⁻¹ and K_d over one period that is up to a hundred N·m of drives that give 29 kN·m.
const BOUND: f64 = 5e-3;

/// The whole weld; 0 where it agrees with the host.
fn run() -> i32 {
    // Nothing of the robot or its instruments may be known to the optimiser, or it would prove the absence of panics for
    // this weld alone.
    let Some(mut weld) = Weld::<f32>::new(black_box(&ROBOT), black_box(&START)) else { return 1 };
    for (k, expected) in EXPECTED.iter().enumerate() {
        let Some(inputs) = weld.inputs(k) else { return 1 };
        let inputs = black_box(inputs);
        let command = weld.law.cycle(black_box(&weld.robot), &inputs.setpoint, &inputs.nominal, &inputs.sensed);
        if command.fault.is_some() {
            return 2;
        }
        for ((torque, expected), joint) in command.torque.iter().zip(expected).zip(&ROBOT.joints) {
            // Written so that a torque that is no number is off.
            if !((f64::from(*torque) - expected).abs() <= BOUND * joint.max_torque) {
                return 3;
            }
        }
        if weld.follow(&inputs, &command).is_none() {
            return 1;
        }
    }
    0
}
