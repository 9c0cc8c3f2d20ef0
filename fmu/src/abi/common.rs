//! What both versions of FMI have, under names and with types of their own.
//!
//! # Safety
//! Of each function as its file says of all.

/// Functions that differ in their names and in the type of flags alone.
macro_rules! common_functions {
    (
        flag: $flag:ty,
        logging: $set_debug_logging:ident,
        run: $free_instance:ident $exit_initialisation:ident $terminate:ident $reset:ident,
        state: $get_state:ident $set_state:ident $free_state:ident,
        bytes: $state_size:ident $serialise:ident $deserialise:ident,
    ) => {
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set_debug_logging(
            instance: *mut c_void,
            on: $flag,
            _categories: usize,
            _names: *const *const c_char,
        ) -> CallStatus {
            unsafe { component::set_verbose(instance, on != 0) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $free_instance(instance: *mut c_void) {
            unsafe { component::free(instance) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $exit_initialisation(instance: *mut c_void) -> CallStatus {
            unsafe { component::call(instance, Instance::exit_initialisation) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $terminate(instance: *mut c_void) -> CallStatus {
            unsafe { component::call(instance, Instance::terminate) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $reset(instance: *mut c_void) -> CallStatus {
            let reset = |instance: &mut Instance| {
                instance.reset();
                Ok(())
            };
            unsafe { component::call(instance, reset) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get_state(
            instance: *mut c_void,
            state: *mut *mut c_void,
        ) -> CallStatus {
            unsafe { component::get_state(instance, state) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set_state(
            instance: *mut c_void,
            state: *mut c_void,
        ) -> CallStatus {
            unsafe { component::set_state(instance, state) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $free_state(
            _instance: *mut c_void,
            state: *mut *mut c_void,
        ) -> CallStatus {
            unsafe { component::free_state(state) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $state_size(
            instance: *mut c_void,
            state: *mut c_void,
            size: *mut usize,
        ) -> CallStatus {
            unsafe { component::state_size(instance, state, size) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $serialise(
            instance: *mut c_void,
            state: *mut c_void,
            bytes: *mut u8,
            size: usize,
        ) -> CallStatus {
            unsafe { component::serialise(instance, state, (bytes, size)) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $deserialise(
            instance: *mut c_void,
            bytes: *const u8,
            size: usize,
            state: *mut *mut c_void,
        ) -> CallStatus {
            unsafe { component::deserialise(instance, (bytes, size), state) }
        }
    };
}

/// Reading and setting variables of a type. `read` and `write` convert a number to it and from it.
/// In brackets the argument that states how many values there are, which FMI 2.0 has not: one a
/// reference there.
macro_rules! variable_functions {
    (
        $get:ident $set:ident [$($length:ident)?]: $type:ty = $of:expr,
        read: $read:expr, write: $write:expr,
    ) => {
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            instance: *mut c_void,
            references: *const c_uint,
            count: usize,
            values: *mut $type,
            $($length: usize,)?
        ) -> CallStatus {
            let room: &[usize] = &[$($length)?];
            let values = (values, room.first().copied());
            unsafe { component::get(instance, (references, count), values, $of, $read) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            instance: *mut c_void,
            references: *const c_uint,
            count: usize,
            values: *const $type,
            $($length: usize,)?
        ) -> CallStatus {
            let given: &[usize] = &[$($length)?];
            let values = (values, given.first().copied().unwrap_or(count));
            unsafe { component::set(instance, (references, count), values, $of, $write) }
        }
    };
}

pub(super) use {common_functions, variable_functions};
