//! Start and end of the program on a Linux host: libc's, and nothing else of an operating system.

use core::panic::PanicInfo;

// SAFETY: names libc for the linker, because its start-up code calls `main`; declares nothing.
#[link(name = "c")]
unsafe extern "C" {}

/// Called by libc's start-up code; the result is the exit code.
// SAFETY: no other `main` is in the program.
#[unsafe(no_mangle)]
extern "C" fn main() -> i32 {
    crate::run()
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
