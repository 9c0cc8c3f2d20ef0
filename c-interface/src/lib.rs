//! The core and the compensation laws for controllers that are programmed in C.
//!
//! A static library without std, allocation, global state or panic, and its header
//! `include/trueweld.h`. All state lies in memory that the caller provides: robot model, controller
//! and law, built once from a constant [`Configuration`] and called every control period. Every
//! function checks what it is given and answers with a [`Status`].
//!
//! * [`types`]: the structs of the boundary, in `float` and in `double`;
//! * [`memory`]: the caller's memory, the one place that believes a pointer;
//! * [`operation`]: what is done with the law that lies there, whichever it is.
//!
//! Left out: combinations of two laws, and what serves analysis on the host.
#![no_std]

mod memory;
mod operation;
mod types;

pub use trueweld_compensators::{
    CONFIGURATION_VERSION, Configuration, ControlNumbers, GainNumbers, JointNumbers, LawNumbers,
    LimitNumbers, Name, RobotNumbers,
};
pub use types::{
    INTERFACE_VERSION, Inputs, MEASUREMENTS, MEMORY_ALIGNMENT, MEMORY_BYTES_F32, MEMORY_BYTES_F64,
    Measurement, Outputs, Pose, Status,
};

use core::ffi::{CStr, c_char, c_void};

#[cfg(feature = "archive")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        /// Defined nowhere: a panic path that is left keeps a program from linking.
        fn trueweld_a_panic_path_is_left() -> !;
    }
    // SAFETY: never called, or the program would not have been linked.
    unsafe { trueweld_a_panic_path_is_left() }
}

/// The version of this interface: what `version` of the structs must be.
#[unsafe(no_mangle)]
pub extern "C" fn trueweld_interface_version() -> u32 {
    INTERFACE_VERSION
}

/// What a status means, in a line of English.
#[unsafe(no_mangle)]
pub extern "C" fn trueweld_status_text(status: i32) -> *const c_char {
    let text: &'static CStr = types::text_of(status);
    text.as_ptr()
}

/// SHA-256 of the configuration that a core was built from, to compare with a certificate's: 32
/// bytes to `digest`.
///
/// # Safety
/// `memory` is null or was given to an `initialise`; `digest` is null or has 32 bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueweld_digest(memory: *const c_void, digest: *mut u8) -> Status {
    // SAFETY: the caller's promise is that of `digest`.
    unsafe { memory::digest(memory, digest) }.into()
}

/// Bytes of memory that the law of a configuration needs in `float`, to `bytes`; never more than
/// TRUEWELD_MEMORY_BYTES_F32.
///
/// # Safety
/// The pointers are null or point to what their types say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueweld_f32_bytes(
    configuration: *const Configuration,
    bytes: *mut usize,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe { operation::bytes::<f32>(configuration, bytes) }.into()
}

/// Builds robot model, controller and law in the caller's memory, in `float`, and checks the whole
/// configuration. The configuration is not needed afterwards.
///
/// # Safety
/// `memory` is null or has `bytes` bytes that nobody else uses; `configuration` is null or points
/// to one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueweld_f32_initialise(
    memory: *mut c_void,
    bytes: usize,
    configuration: *const Configuration,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe { operation::initialise::<f32>(memory, bytes, configuration) }.into()
}

/// Starts a weld from rest: the drives hold `torque`, N·m, at `encoder` angles, rad; 6 numbers
/// each.
///
/// # Safety
/// `memory` is null or was given to `trueweld_f32_initialise`; the others are null or have 6
/// numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueweld_f32_start(
    memory: *mut c_void,
    encoder: *const f32,
    torque: *const f32,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe { operation::start::<f32>(memory, encoder, torque) }.into()
}

/// One control period. With a status of 0 or above `outputs` holds a torque that is safe to apply;
/// below 0 the call was wrong, and `outputs` is as it was.
///
/// # Safety
/// `memory` is null or was given to `trueweld_f32_initialise` and is not used by another call at the
/// same time; the others are null or point to what their types say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueweld_f32_cycle(
    memory: *mut c_void,
    inputs: *const Inputs<f32>,
    outputs: *mut Outputs<f32>,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe { operation::cycle::<f32>(memory, inputs, outputs) }.into()
}

/// Joint angles at which the unloaded model's tool is at a pose, on the branch nearest to `near`, to
/// `angles`, rad; 6 numbers each.
///
/// # Safety
/// As of `trueweld_f32_start`; `pose` is null or points to one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueweld_f32_inverse(
    memory: *const c_void,
    pose: *const Pose<f32>,
    near: *const f32,
    angles: *mut f32,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe { operation::inverse::<f32>(memory, pose, near, angles) }.into()
}

/// The pose that the encoders show while the real tool is at `nominal` under gravity alone, to
/// `pose`: the set-point of a weld that is not taught by hand. `near`: 6 joint angles near it, rad.
///
/// # Safety
/// As of `trueweld_f32_start`; the poses are null or point to one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueweld_f32_taught(
    memory: *const c_void,
    nominal: *const Pose<f32>,
    near: *const f32,
    pose: *mut Pose<f32>,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe { operation::taught::<f32>(memory, nominal, near, pose) }.into()
}

/// As `trueweld_f32_bytes`, in `double`.
///
/// # Safety
/// The pointers are null or point to what their types say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueweld_f64_bytes(
    configuration: *const Configuration,
    bytes: *mut usize,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe { operation::bytes::<f64>(configuration, bytes) }.into()
}

/// As `trueweld_f32_initialise`, in `double`.
///
/// # Safety
/// As there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueweld_f64_initialise(
    memory: *mut c_void,
    bytes: usize,
    configuration: *const Configuration,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe { operation::initialise::<f64>(memory, bytes, configuration) }.into()
}

/// As `trueweld_f32_start`, in `double`.
///
/// # Safety
/// As there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueweld_f64_start(
    memory: *mut c_void,
    encoder: *const f64,
    torque: *const f64,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe { operation::start::<f64>(memory, encoder, torque) }.into()
}

/// As `trueweld_f32_cycle`, in `double`.
///
/// # Safety
/// As there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueweld_f64_cycle(
    memory: *mut c_void,
    inputs: *const Inputs<f64>,
    outputs: *mut Outputs<f64>,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe { operation::cycle::<f64>(memory, inputs, outputs) }.into()
}

/// As `trueweld_f32_inverse`, in `double`.
///
/// # Safety
/// As there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueweld_f64_inverse(
    memory: *const c_void,
    pose: *const Pose<f64>,
    near: *const f64,
    angles: *mut f64,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe { operation::inverse::<f64>(memory, pose, near, angles) }.into()
}

/// As `trueweld_f32_taught`, in `double`.
///
/// # Safety
/// As there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trueweld_f64_taught(
    memory: *const c_void,
    nominal: *const Pose<f64>,
    near: *const f64,
    pose: *mut Pose<f64>,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe { operation::taught::<f64>(memory, nominal, near, pose) }.into()
}
