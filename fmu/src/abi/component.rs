//! An instance with the importer's log, as its pointer leads to it.

use crate::instance::{Asked, Instance, Numbering};
use crate::model::Stepped;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Status of a call, the same numbers in both versions of FMI.
pub(super) type CallStatus = c_int;

pub(super) const STATUS_OK: CallStatus = 0;
pub(super) const STATUS_WARNING: CallStatus = 1;
pub(super) const STATUS_DISCARD: CallStatus = 2;
pub(super) const STATUS_ERROR: CallStatus = 3;

/// `void logger(environment, instanceName, status, category, message, ...)` of FMI 2.0.
pub(super) type Logger2 =
    unsafe extern "C" fn(*mut c_void, *const c_char, CallStatus, *const c_char, *const c_char, ...);

/// `void logMessage(environment, status, category, message)` of FMI 3.0.
pub(super) type Logger3 =
    unsafe extern "C" fn(*mut c_void, CallStatus, *const c_char, *const c_char);

/// Where messages go.
pub(super) enum MessageLog {
    Nowhere,
    Fmi2 { logger: Logger2, environment: *mut c_void, name: CString },
    Fmi3 { logger: Logger3, environment: *mut c_void },
}

impl MessageLog {
    /// Tells the importer. Only called while a call of the importer's is under way.
    pub(super) fn tell(&self, status: CallStatus, text: &str) {
        let category: &CStr =
            if status == STATUS_WARNING { c"logStatusWarning" } else { c"logStatusError" };
        let message = |text: &str| CString::new(text.replace('\0', " ")).unwrap_or_default();
        match self {
            Self::Nowhere => {}
            Self::Fmi2 { logger, environment, name } => {
                // A format of C: what looks like one of its fields is none.
                let text = message(&text.replace('%', "%%"));
                // SAFETY: the importer gave logger and environment for this; the texts end with 0.
                unsafe {
                    logger(*environment, name.as_ptr(), status, category.as_ptr(), text.as_ptr());
                }
            }
            Self::Fmi3 { logger, environment } => {
                let text = message(text);
                // SAFETY: as above.
                unsafe { logger(*environment, status, category.as_ptr(), text.as_ptr()) };
            }
        }
    }
}

/// What the importer's pointer to an instance leads to.
pub(super) struct Component {
    instance: Instance,
    log: MessageLog,
    /// Whether warnings are told.
    pub verbose: bool,
    /// The last warning: one that stands for many steps is told once.
    warned: String,
}

/// What `make` makes of an instance, as a pointer for the importer; null where it cannot be made.
pub(super) fn instantiate(
    log: MessageLog,
    verbose: bool,
    make: impl FnOnce() -> Result<Instance, String>,
) -> *mut c_void {
    let made = catch_unwind(AssertUnwindSafe(make));
    match made.unwrap_or_else(|_| Err("a panic: please report it".to_owned())) {
        Ok(instance) => {
            let component = Component { instance, log, verbose, warned: String::new() };
            Box::into_raw(Box::new(component)).cast()
        }
        Err(text) => {
            log.tell(STATUS_ERROR, &text);
            std::ptr::null_mut()
        }
    }
}

/// Frees an instance.
///
/// # Safety
/// `component` is null or came from [`instantiate`], and is not used afterwards.
pub(super) unsafe fn free(component: *mut c_void) {
    if !component.is_null() {
        // SAFETY: made by `Box::into_raw` of this type, and the importer's last use of it.
        drop(unsafe { Box::from_raw(component.cast::<Component>()) });
    }
}

/// The component of a pointer.
///
/// # Safety
/// `component` is null or came from [`instantiate`], was not freed, and no other call uses it.
unsafe fn component<'a>(component: *mut c_void) -> Option<&'a mut Component> {
    // SAFETY: null or a `Component` of this call alone, by the caller's promise.
    unsafe { component.cast::<Component>().as_mut() }
}

/// Does something with an instance.
///
/// # Safety
/// `pointer` is null or came from [`instantiate`], was not freed, and no other call uses it.
pub(super) unsafe fn call_step(
    pointer: *mut c_void,
    what: impl FnOnce(&mut Instance) -> Result<Stepped, String>,
) -> CallStatus {
    // SAFETY: the caller's promise.
    let Some(component) = (unsafe { component(pointer) }) else {
        return STATUS_ERROR;
    };
    let instance = &mut component.instance;
    match catch_unwind(AssertUnwindSafe(|| what(instance))) {
        Ok(Ok(Stepped::Idle)) => STATUS_OK,
        Ok(Ok(Stepped::Well)) => {
            component.warned.clear();
            STATUS_OK
        }
        Ok(Ok(Stepped::Warned(text))) => {
            if component.verbose && component.warned != text {
                component.log.tell(STATUS_WARNING, &text);
            }
            component.warned = text;
            STATUS_WARNING
        }
        Ok(Err(text)) => {
            component.log.tell(STATUS_ERROR, &text);
            STATUS_ERROR
        }
        Err(_) => {
            component.instance.fail();
            component
                .log
                .tell(STATUS_ERROR, "a panic: please report it; the instance takes no more steps");
            STATUS_ERROR
        }
    }
}

/// The same of what is no step.
///
/// # Safety
/// As of [`call_step`].
pub(super) unsafe fn call(
    pointer: *mut c_void,
    what: impl FnOnce(&mut Instance) -> Result<(), String>,
) -> CallStatus {
    // SAFETY: the caller's promise.
    unsafe { call_step(pointer, |instance| what(instance).map(|()| Stepped::Idle)) }
}

/// Sets whether warnings are told.
///
/// # Safety
/// As of [`call_step`].
pub(super) unsafe fn set_verbose(pointer: *mut c_void, verbose: bool) -> CallStatus {
    // SAFETY: the caller's promise.
    match unsafe { component(pointer) } {
        Some(component) => {
            component.verbose = verbose;
            STATUS_OK
        }
        None => STATUS_ERROR,
    }
}

/// Reads variables into room for as many values.
///
/// # Safety
/// As of [`call_step`]; `references` and `values` are null or have as many as their counts say.
pub(super) unsafe fn get<V>(
    pointer: *mut c_void,
    (references, count): (*const u32, usize),
    (values, room): (*mut V, Option<usize>),
    of: (Numbering, Asked),
    convert: impl Fn(f64) -> V,
) -> CallStatus {
    let read = |instance: &mut Instance| {
        // SAFETY: the caller's promise.
        let references = unsafe { super::pointer::values(references, count) }?;
        let count = instance.count(references, of)?;
        if let Some(room) = room.filter(|room| *room != count) {
            return Err(format!("there is room for {room} values; expected {count}"));
        }
        // SAFETY: FMI 2.0 has one value a reference, FMI 3.0 states the room, which was checked.
        let mut places = unsafe { super::pointer::room(values, count) }?.iter_mut();
        instance.get(references, of, |value| {
            if let Some(place) = places.next() {
                *place = convert(value);
            }
        })
    };
    // SAFETY: the caller's promise.
    unsafe { call(pointer, read) }
}

/// Sets variables.
///
/// # Safety
/// As of [`get`].
pub(super) unsafe fn set<V: Copy>(
    pointer: *mut c_void,
    (references, count): (*const u32, usize),
    (values, given): (*const V, usize),
    of: (Numbering, Asked),
    convert: impl Fn(V) -> f64,
) -> CallStatus {
    let write = |instance: &mut Instance| {
        // SAFETY: the caller's promise.
        let (references, values) = unsafe {
            (super::pointer::values(references, count)?, super::pointer::values(values, given)?)
        };
        let numbers: Vec<f64> = values.iter().map(|value| convert(*value)).collect();
        instance.set(references, of, &numbers)
    };
    // SAFETY: the caller's promise.
    unsafe { call(pointer, write) }
}

/// A state in memory: the bytes of a serialised one.
type SavedState = Vec<u8>;

/// Takes the state; one that the pointer leads to already is replaced.
///
/// # Safety
/// As of [`call_step`]; `to` is null or leads to null or to a state of this function.
pub(super) unsafe fn get_state(pointer: *mut c_void, to: *mut *mut c_void) -> CallStatus {
    let save = |instance: &mut Instance| {
        // SAFETY: null or a pointer by the caller's promise.
        let to = unsafe { to.as_mut() }.ok_or("the pointer to a state is null")?;
        let state = instance.state()?;
        // SAFETY: null or a state by the caller's promise.
        match unsafe { to.cast::<SavedState>().as_mut() } {
            Some(before) => *before = state,
            None => *to = Box::into_raw(Box::new(state)).cast(),
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { call(pointer, save) }
}

/// Goes on from a state.
///
/// # Safety
/// As of [`call_step`]; `state` is null or came from [`get_state`] or [`deserialise`].
pub(super) unsafe fn set_state(pointer: *mut c_void, state: *mut c_void) -> CallStatus {
    let restore = |instance: &mut Instance| {
        // SAFETY: the caller's promise.
        instance.restore(unsafe { bytes(state) }?)
    };
    // SAFETY: the caller's promise.
    unsafe { call(pointer, restore) }
}

/// The bytes of a state.
///
/// # Safety
/// `state` is null or a state that is not freed while the bytes live.
unsafe fn bytes<'a>(state: *mut c_void) -> Result<&'a SavedState, String> {
    // SAFETY: the caller's promise.
    let state = unsafe { state.cast::<SavedState>().as_ref() };
    state.ok_or_else(|| "the state is null".to_owned())
}

/// Frees a state and forgets it.
///
/// # Safety
/// As of [`get_state`].
pub(super) unsafe fn free_state(state: *mut *mut c_void) -> CallStatus {
    // SAFETY: null or a pointer by the caller's promise.
    if let Some(state) = unsafe { state.as_mut() }
        && !state.is_null()
    {
        // SAFETY: made by `Box::into_raw` of this type.
        drop(unsafe { Box::from_raw(state.cast::<SavedState>()) });
        *state = std::ptr::null_mut();
    }
    STATUS_OK
}

/// Bytes of a serialised state.
///
/// # Safety
/// As of [`set_state`]; `size` is null or has room.
pub(super) unsafe fn state_size(
    pointer: *mut c_void,
    state: *mut c_void,
    size: *mut usize,
) -> CallStatus {
    // SAFETY: the caller's promise.
    unsafe {
        call(pointer, |_| {
            let length = bytes(state)?.len();
            super::pointer::write(size, length);
            Ok(())
        })
    }
}

/// Writes a state as bytes.
///
/// # Safety
/// As of [`set_state`]; `to` is null or has room for `size` bytes.
pub(super) unsafe fn serialise(
    pointer: *mut c_void,
    state: *mut c_void,
    (to, size): (*mut u8, usize),
) -> CallStatus {
    let write = |_: &mut Instance| {
        // SAFETY: the caller's promise.
        let (state, to) = unsafe { (bytes(state)?, super::pointer::room(to, size)?) };
        let place = to.get_mut(..state.len()).ok_or_else(|| {
            format!("there is room for {size} bytes; the state has {}", state.len())
        })?;
        place.copy_from_slice(state);
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { call(pointer, write) }
}

/// Makes a state of bytes. Whether they are one of this FMU is known here already.
///
/// # Safety
/// As of [`get_state`]; `from` is null or has `size` bytes.
pub(super) unsafe fn deserialise(
    pointer: *mut c_void,
    (from, size): (*const u8, usize),
    to: *mut *mut c_void,
) -> CallStatus {
    let read = |instance: &mut Instance| {
        // SAFETY: the caller's promise.
        let (given, to) = unsafe { (super::pointer::values(from, size)?, to.as_mut()) };
        let to = to.ok_or("the pointer to a state is null")?;
        instance.check_state(given)?;
        *to = Box::into_raw(Box::new(SavedState::from(given))).cast();
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { call(pointer, read) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Model;
    use crate::variable::VariableTable;
    use trueweld_core::state::{StateResult, StateVisitor};

    /// A model that panics in its second step.
    struct Panics(VariableTable, u8);

    impl Model for Panics {
        fn table(&self) -> &VariableTable {
            &self.0
        }

        fn period(&self) -> f64 {
            1.0
        }

        fn duration(&self) -> f64 {
            1.0
        }

        fn initialise(&mut self, _: &mut [f64]) -> Result<(), String> {
            Ok(())
        }

        fn step(&mut self, _: &mut [f64]) -> Result<Stepped, String> {
            assert_eq!(self.1, 0);
            self.1 += 1;
            Ok(Stepped::Warned("once".to_owned()))
        }

        fn visit_state(&mut self, _: &mut dyn StateVisitor) -> StateResult {
            Ok(())
        }

        fn restored(&mut self) {}
    }

    /// Counts what it is told, in the integer that its environment is.
    unsafe extern "C" fn count(
        environment: *mut c_void,
        _: CallStatus,
        _: *const c_char,
        _: *const c_char,
    ) {
        // SAFETY: the test's own.
        unsafe { *environment.cast::<u32>() += 1 };
    }

    #[test]
    fn a_panic_is_an_error_and_the_end_of_steps() {
        let mut told = 0_u32;
        let log = MessageLog::Fmi3 { logger: count, environment: (&raw mut told).cast() };
        let model = Box::new(Panics(VariableTable::new(), 0));
        let pointer = instantiate(log, true, || Ok(Instance::new(model, [0; 32])));
        let step = |time: f64| {
            // SAFETY: an instance that lives.
            unsafe { call_step(pointer, |instance| instance.step(time, 1.0)) }
        };
        // SAFETY: likewise, freed once.
        unsafe {
            assert_eq!(call(pointer, Instance::enter_initialisation), STATUS_OK);
            assert_eq!(call(pointer, Instance::exit_initialisation), STATUS_OK);
            assert_eq!(step(0.0), STATUS_WARNING);
            assert_eq!(step(1.0), STATUS_ERROR);
            assert_eq!(step(1.0), STATUS_ERROR);
            free(pointer);
        }
        assert_eq!(told, 3);
        let none = instantiate(MessageLog::Nowhere, true, || panic!("on purpose"));
        assert!(none.is_null());
    }
}
