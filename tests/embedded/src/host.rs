//! Start and end of the program on a Linux host: libc's, and nothing else of an operating system.

// SAFETY: names libc for the linker, because its start-up code calls `main`; declares nothing.
#[link(name = "c")]
unsafe extern "C" {}

/// Called by libc's start-up code; the result is the exit code.
// SAFETY: no other `main` is in the program.
#[unsafe(no_mangle)]
extern "C" fn main() -> i32 {
    crate::run::<f32>(crate::BOUND, |_, cycle| cycle())
}
