//! Start and end of the program on a bare Cortex-M7, and what a control cycle costs there:
//! instructions by SysTick in an emulator that counts them, stack by painting it beforehand.

use crate::host_tables::{ROBOT, START};
use crate::others;
use crate::weld::Weld;
use core::arch::asm;
use core::ffi::CStr;
use core::ptr::{addr_of, read_volatile, write_volatile};
use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, syscall1};
use trueweld_core::Real;

/// What f64 may be off, as a share of the drive's limit: the rounding of two different compilers.
const BOUND_F64: f64 = 1e-9;

/// SysTick counts down from here, in 24 bits.
const RELOAD: u32 = 0x00ff_ffff;

/// What unused stack holds.
const PAINT: u32 = 0xa5a5_5a5a;

unsafe extern "C" {
    /// End of the static variables: the stack grows down towards it.
    static __sheap: u32;
}

#[entry]
fn main() -> ! {
    if let Some(mut peripherals) = cortex_m::Peripherals::take() {
        peripherals.SYST.set_clock_source(SystClkSource::Core);
        peripherals.SYST.set_reload(RELOAD);
        peripherals.SYST.clear_current();
        peripherals.SYST.enable_counter();
        let agrees = judge::<f32>(c"f32\n", crate::BOUND) & judge::<f64>(c"f64\n", BOUND_F64);
        print(c"laws alone, f32\n");
        laws::<f32>();
        print(c"laws alone, f64\n");
        laws::<f64>();
        if agrees {
            debug::exit(debug::EXIT_SUCCESS);
        }
    }
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}

/// Runs the weld and reports what its control cycles cost; false where it does not agree with the
/// host.
fn judge<T: Real + Into<f64>>(name: &CStr, bound: f64) -> bool {
    let thousand = thousand();
    let (mut most, mut sum, mut stack) = (0, 0, 0);
    let code = crate::run::<T>(bound, |cycle| {
        paint();
        let spent = ticks(cycle) * 100 / (thousand / 10).max(1);
        most = most.max(spent);
        sum += spent;
        stack = stack.max(unpainted());
    });
    print(name);
    print_number(c"  exit code", code.unsigned_abs());
    print_number(c"  instructions a cycle, mean", sum / crate::weld::CYCLES as u32);
    print_number(c"  instructions a cycle, most", most);
    print_number(c"  stack of a cycle, bytes", stack);
    code == 0
}

/// What a period of every law costs by itself, over so many periods that whatever it keeps is full.
fn laws<T: Real>() {
    const PERIODS: usize = 2 * crate::weld::CYCLES;
    let Some(weld) = Weld::<T>::new(&ROBOT, &START) else {
        return;
    };
    let thousand = thousand();
    others::laws(&mut |name, law| {
        law.reset();
        let (mut least, mut most, mut stack) = (u32::MAX, 0, 0);
        for k in 0..PERIODS {
            let Some(inputs) = weld.inputs(k % crate::weld::CYCLES) else {
                return;
            };
            paint();
            let spent = ticks(&mut || others::ask(law, &weld.robot, &inputs, k)) * 100
                / (thousand / 10).max(1);
            (least, most) = (least.min(spent), most.max(spent));
            stack = stack.max(unpainted());
        }
        for byte in name.bytes() {
            // SAFETY: the debugger reads the one byte.
            unsafe { syscall1!(WRITEC, &raw const byte) };
        }
        print_number(c"\n  instructions a period, least", least);
        print_number(c"  instructions a period, most", most);
        print_number(c"  stack of a period, bytes", stack);
    });
}

/// Ticks of a thousand instructions.
fn thousand() -> u32 {
    // SAFETY: touches nothing but the program counter.
    ticks(&mut || unsafe { asm!(".rept 1000", "nop", ".endr", options(nomem, nostack)) })
}

/// SysTick's ticks while `work` runs.
fn ticks(work: &mut dyn FnMut()) -> u32 {
    let start = SYST::get_current();
    work();
    start.wrapping_sub(SYST::get_current()) & RELOAD
}

#[inline(always)]
fn stack_pointer() -> usize {
    let sp: usize;
    // SAFETY: reads a register.
    unsafe { asm!("mov {}, sp", out(reg) sp, options(nomem, nostack)) };
    sp
}

/// Fills the stack below the caller's frame.
#[inline(never)]
fn paint() {
    let mut at = addr_of!(__sheap).addr();
    while at < stack_pointer() - 64 {
        // SAFETY: between the statics and this frame's lower end nothing lives; no interrupt is
        // enabled.
        unsafe { write_volatile(at as *mut u32, PAINT) };
        at += 4;
    }
}

/// Bytes from the deepest overwritten word up to the caller's frame.
#[inline(never)]
fn unpainted() -> u32 {
    let mut at = addr_of!(__sheap).addr();
    // SAFETY: reads RAM below this frame.
    while at < stack_pointer() && unsafe { read_volatile(at as *const u32) } == PAINT {
        at += 4;
    }
    (stack_pointer() - at) as u32
}

fn print(text: &CStr) {
    // SAFETY: the debugger reads up to the terminating zero.
    unsafe { syscall1!(WRITE0, text.as_ptr()) };
}

/// Decimal digits by hand: core's formatting has panic paths.
fn print_number(label: &CStr, mut number: u32) {
    let mut digits = *b"            \n\0";
    for digit in digits.iter_mut().rev().skip(2) {
        *digit = b'0' + (number % 10) as u8;
        number /= 10;
        if number == 0 {
            break;
        }
    }
    print(label);
    // SAFETY: the last byte is zero.
    unsafe { syscall1!(WRITE0, digits.as_ptr()) };
}
