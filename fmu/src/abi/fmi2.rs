//! The functions of FMI 2.0 for co-simulation.
//!
//! # Safety
//! What the standard asks of an importer holds for every function here: a component is null or one
//! that `fmi2Instantiate` gave and `fmi2FreeInstance` did not take, and no two calls use it at once; a
//! state is null or came from this library; pointers to values are null or have as many as is said.

#![allow(
    non_snake_case,
    clippy::missing_safety_doc,
    clippy::undocumented_unsafe_blocks,
    reason = "names of the standard; the promise of all functions and of their calls is above"
)]
#![allow(missing_docs, reason = "the standard says what its functions do")]

use super::common::{common_functions, variable_functions};
use super::component::{
    self, CallStatus, Logger2, MessageLog, STATUS_DISCARD, STATUS_ERROR, STATUS_OK, call,
    call_step, instantiate,
};
use super::pointer::{folder_of, text, write};
use crate::contents::instantiate as instance_of;
use crate::instance::{Asked, Instance, Numbering};
use std::ffi::{CString, c_char, c_int, c_uint, c_void};

/// `fmi2CoSimulation` of `fmi2Type`.
const CO_SIMULATION: c_int = 1;

/// `fmi2CallbackFunctions`. Memory is that of this library, and steps end before they return.
#[repr(C)]
pub struct Fmi2Callbacks {
    logger: Option<Logger2>,
    allocate: *const c_void,
    free: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    kind: c_int,
    guid: *const c_char,
    resources: *const c_char,
    callbacks: *const Fmi2Callbacks,
    _visible: c_int,
    logging: c_int,
) -> *mut c_void {
    let (name, guid, resources) = unsafe { (text(name), text(guid), text(resources)) };
    let log = match unsafe { callbacks.as_ref() } {
        Some(Fmi2Callbacks { logger: Some(logger), environment, .. }) => MessageLog::Fmi2 {
            logger: *logger,
            environment: *environment,
            name: CString::new(name.as_bytes()).unwrap_or_default(),
        },
        _ => MessageLog::Nowhere,
    };
    instantiate(log, logging != 0, || {
        if kind != CO_SIMULATION {
            return Err("this FMU is for co-simulation alone".to_owned());
        }
        instance_of(&folder_of(&resources)?, &guid).map_err(|error| in_one_line(&error))
    })
}

/// An error with its causes.
pub(super) fn in_one_line(error: &miette::Report) -> String {
    error.chain().map(ToString::to_string).collect::<Vec<_>>().join(": ")
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: *mut c_void,
    _tolerance_defined: c_int,
    _tolerance: f64,
    start: f64,
    _stop_defined: c_int,
    _stop: f64,
) -> CallStatus {
    unsafe { call(c, |instance| instance.set_start_time(start)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: *mut c_void) -> CallStatus {
    unsafe { call(c, Instance::enter_initialisation) }
}

common_functions! {
    flag: c_int,
    logging: fmi2SetDebugLogging,
    run: fmi2FreeInstance fmi2ExitInitializationMode fmi2Terminate fmi2Reset,
    state: fmi2GetFMUstate fmi2SetFMUstate fmi2FreeFMUstate,
    bytes: fmi2SerializedFMUstateSize fmi2SerializeFMUstate fmi2DeSerializeFMUstate,
}

variable_functions! {
    fmi2GetReal fmi2SetReal []: f64 = (Numbering::Scalars, Asked::Real),
    read: |value| value, write: |value| value,
}

variable_functions! {
    fmi2GetInteger fmi2SetInteger []: c_int = (Numbering::Scalars, Asked::Integer),
    read: |value| value as c_int, write: f64::from,
}

variable_functions! {
    fmi2GetBoolean fmi2SetBoolean []: c_int = (Numbering::Scalars, Asked::Boolean),
    read: |value| value as c_int, write: |value| f64::from(value != 0),
}

/// No model has texts.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetString(
    _c: *mut c_void,
    _references: *const c_uint,
    count: usize,
    _values: *mut *const c_char,
) -> CallStatus {
    if count == 0 { STATUS_OK } else { STATUS_ERROR }
}

/// No model has texts.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2SetString(
    _c: *mut c_void,
    _references: *const c_uint,
    count: usize,
    _values: *const *const c_char,
) -> CallStatus {
    if count == 0 { STATUS_OK } else { STATUS_ERROR }
}

/// Said not to be provided.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetDirectionalDerivative(
    _c: *mut c_void,
    _unknown: *const c_uint,
    _unknowns: usize,
    _known: *const c_uint,
    _knowns: usize,
    _known_change: *const f64,
    _unknown_change: *mut f64,
) -> CallStatus {
    STATUS_ERROR
}

/// Inputs are held over a step: derivatives of order 0 alone.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2SetRealInputDerivatives(
    _c: *mut c_void,
    _references: *const c_uint,
    count: usize,
    _orders: *const c_int,
    _values: *const f64,
) -> CallStatus {
    if count == 0 { STATUS_OK } else { STATUS_ERROR }
}

/// Likewise of outputs.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetRealOutputDerivatives(
    _c: *mut c_void,
    _references: *const c_uint,
    count: usize,
    _orders: *const c_int,
    _values: *mut f64,
) -> CallStatus {
    if count == 0 { STATUS_OK } else { STATUS_ERROR }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    c: *mut c_void,
    time: f64,
    size: f64,
    _keeps_no_state: c_int,
) -> CallStatus {
    unsafe { call_step(c, |instance| instance.step(time, size)) }
}

/// Steps end before they return: there is none to cancel.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2CancelStep(_c: *mut c_void) -> CallStatus {
    STATUS_ERROR
}

/// Asked while a step is under way, which it never is.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetStatus(_c: *mut c_void, _kind: c_int, _value: *mut c_int) -> CallStatus {
    STATUS_DISCARD
}

/// The end of the last step that succeeded, s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(
    c: *mut c_void,
    kind: c_int,
    value: *mut f64,
) -> CallStatus {
    /// `fmi2LastSuccessfulTime` of `fmi2StatusKind`.
    const LAST_SUCCESSFUL_TIME: c_int = 2;
    if kind != LAST_SUCCESSFUL_TIME {
        return STATUS_DISCARD;
    }
    let read = |instance: &mut Instance| {
        unsafe { write(value, instance.time()) };
        Ok(())
    };
    unsafe { call(c, read) }
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetIntegerStatus(
    _c: *mut c_void,
    _kind: c_int,
    _value: *mut c_int,
) -> CallStatus {
    STATUS_DISCARD
}

/// Whether the FMU asks to end the run, which it does not.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    _c: *mut c_void,
    kind: c_int,
    value: *mut c_int,
) -> CallStatus {
    /// `fmi2Terminated` of `fmi2StatusKind`.
    const TERMINATED: c_int = 3;
    if kind != TERMINATED {
        return STATUS_DISCARD;
    }
    unsafe { write(value, 0) };
    STATUS_OK
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetStringStatus(
    _c: *mut c_void,
    _kind: c_int,
    _value: *mut *const c_char,
) -> CallStatus {
    STATUS_DISCARD
}
