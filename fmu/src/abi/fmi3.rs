//! The functions of FMI 3.0 for co-simulation.
//!
//! # Safety
//! What the standard asks of an importer holds for every function here: an instance is null or one
//! that `fmi3InstantiateCoSimulation` gave and `fmi3FreeInstance` did not take, and no two calls use it
//! at once; a state is null or came from this library; pointers to values are null or have as many as
//! is said.

#![allow(
    non_snake_case,
    clippy::missing_safety_doc,
    clippy::undocumented_unsafe_blocks,
    reason = "names of the standard; the promise of all functions and of their calls is above"
)]
#![allow(missing_docs, reason = "the standard says what its functions do")]

use super::common::{common_functions, variable_functions};
use super::component::{
    self, CallStatus, Logger3, MessageLog, STATUS_ERROR, STATUS_OK, call, call_step, instantiate,
};
use super::fmi2::in_one_line;
use super::pointer::{text, write};
use crate::contents::instantiate as instance_of;
use crate::instance::{Asked, Instance, Numbering};
use std::ffi::{c_char, c_uint, c_void};
use std::path::Path;
use std::ptr;

/// `fmi3Boolean`, a C `bool`, of which an importer might give any byte.
type Flag = u8;

#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: Flag,
    logging: Flag,
    event_mode: Flag,
    _early_return: Flag,
    _intermediate: *const c_uint,
    _intermediates: usize,
    environment: *mut c_void,
    logger: Option<Logger3>,
    _update: *const c_void,
) -> *mut c_void {
    let (token, resources) = unsafe { (text(token), text(resources)) };
    let log = logger.map_or(MessageLog::Nowhere, |logger| MessageLog::Fmi3 { logger, environment });
    instantiate(log, logging != 0, || {
        if event_mode != 0 {
            return Err("this FMU has no event mode".to_owned());
        }
        instance_of(Path::new(&*resources), &token).map_err(|error| in_one_line(&error))
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut c_void,
    _tolerance_defined: Flag,
    _tolerance: f64,
    start: f64,
    _stop_defined: Flag,
    _stop: f64,
) -> CallStatus {
    let enter = |instance: &mut Instance| {
        instance.set_start_time(start)?;
        instance.enter_initialisation()
    };
    unsafe { call(instance, enter) }
}

common_functions! {
    flag: Flag,
    logging: fmi3SetDebugLogging,
    run: fmi3FreeInstance fmi3ExitInitializationMode fmi3Terminate fmi3Reset,
    state: fmi3GetFMUState fmi3SetFMUState fmi3FreeFMUState,
    bytes: fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState,
}

variable_functions! {
    fmi3GetFloat64 fmi3SetFloat64 [length]: f64 = (Numbering::Variables, Asked::Real),
    read: |value| value, write: |value| value,
}

variable_functions! {
    fmi3GetInt32 fmi3SetInt32 [length]: i32 = (Numbering::Variables, Asked::Integer),
    read: |value| value as i32, write: f64::from,
}

variable_functions! {
    fmi3GetBoolean fmi3SetBoolean [length]: Flag = (Numbering::Variables, Asked::Boolean),
    read: |value| value as Flag, write: |value| f64::from(value != 0),
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut c_void,
    time: f64,
    size: f64,
    _keeps_no_state: Flag,
    event_needed: *mut Flag,
    terminates: *mut Flag,
    returned_early: *mut Flag,
    last_time: *mut f64,
) -> CallStatus {
    let step = |instance: &mut Instance| {
        let stepped = instance.step(time, size);
        unsafe {
            write(event_needed, 0);
            write(terminates, 0);
            write(returned_early, 0);
            write(last_time, instance.time());
        }
        stepped
    };
    unsafe { call_step(instance, step) }
}

/// Functions of other interfaces of FMI 3.0, and what the model description says is not provided.
/// By the conventions of C a function may leave its arguments unread.
macro_rules! refused {
    ($($name:ident)*) => {$(
        #[unsafe(no_mangle)]
        pub extern "C" fn $name() -> CallStatus {
            STATUS_ERROR
        }
    )*};
}

refused! {
    fmi3EnterEventMode
    fmi3GetNumberOfVariableDependencies fmi3GetVariableDependencies
    fmi3GetDirectionalDerivative fmi3GetAdjointDerivative
    fmi3EnterConfigurationMode fmi3ExitConfigurationMode
    fmi3GetIntervalDecimal fmi3GetIntervalFraction fmi3GetShiftDecimal fmi3GetShiftFraction
    fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction
    fmi3EvaluateDiscreteStates fmi3UpdateDiscreteStates
    fmi3EnterContinuousTimeMode fmi3CompletedIntegratorStep fmi3SetTime
    fmi3SetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetEventIndicators
    fmi3GetContinuousStates fmi3GetNominalsOfContinuousStates
    fmi3GetNumberOfEventIndicators fmi3GetNumberOfContinuousStates
    fmi3EnterStepMode fmi3GetOutputDerivatives fmi3ActivateModelPartition
}

/// Types that no variable has: in order where none is asked for.
macro_rules! without_variables {
    ($($name:ident)*) => {$(
        #[unsafe(no_mangle)]
        pub extern "C" fn $name(
            _instance: *mut c_void,
            _references: *const c_uint,
            count: usize,
        ) -> CallStatus {
            if count == 0 { STATUS_OK } else { STATUS_ERROR }
        }
    )*};
}

without_variables! {
    fmi3GetFloat32 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetUInt32 fmi3GetInt64
    fmi3GetUInt64 fmi3GetString fmi3GetBinary fmi3GetClock
    fmi3SetFloat32 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16 fmi3SetUInt16 fmi3SetUInt32 fmi3SetInt64
    fmi3SetUInt64 fmi3SetString fmi3SetBinary fmi3SetClock
}

/// Interfaces that the FMU has not got.
macro_rules! not_instantiated {
    ($($name:ident)*) => {$(
        #[unsafe(no_mangle)]
        pub extern "C" fn $name() -> *mut c_void {
            ptr::null_mut()
        }
    )*};
}

not_instantiated! { fmi3InstantiateModelExchange fmi3InstantiateScheduledExecution }
