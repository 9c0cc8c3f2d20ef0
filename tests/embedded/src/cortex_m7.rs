//! Start and end of the program on a bare Cortex-M7, and what a control cycle costs there:
//! instructions by SysTick in an emulator that counts them, stack by painting it beforehand.

use crate::host_tables::{ROBOT, START};
use crate::weld::{CYCLES, Weld, controller};
use crate::{Work, others};
use core::arch::asm;
use core::ffi::CStr;
use core::hint::black_box;
use core::ptr::{addr_of, read_volatile, write_volatile};
use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, syscall1};
use trueweld_core::Real;
use trueweld_core::compensation::Compensator;

/// What f64 may be off, as a share of the drive's limit: the rounding of two different compilers.
const BOUND_F64: f64 = 1e-9;

/// The law whose full control cycle is measured as well, with two readings a period: the longest that
/// a seam sensor makes.
const FULL_CYCLE: &str = "seam-tracking";

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
    let (mut law, mut health) = (Cost::default(), Cost::default());
    let code = crate::run::<T>(bound, |work, cycle| {
        let cost = match work {
            Work::Law => &mut law,
            Work::Health => &mut health,
        };
        cost.of(thousand, cycle);
    });
    print(name);
    print_number(c"  exit code", code.unsigned_abs());
    law.print(CYCLES);
    if size_of::<T>() == size_of::<f32>() {
        print(c"health\n");
        health.print(CYCLES);
    }
    code == 0
}

/// What something costs in the cycles of the weld.
#[derive(Default)]
struct Cost {
    most: u32,
    sum: u32,
    stack: u32,
}

impl Cost {
    /// Instructions of one more cycle. `thousand`: ticks of so many.
    fn of(&mut self, thousand: u32, cycle: &mut dyn FnMut()) -> u32 {
        paint();
        let spent = ticks(cycle) * 100 / (thousand / 10).max(1);
        self.most = self.most.max(spent);
        self.sum += spent;
        self.stack = self.stack.max(unpainted());
        spent
    }

    fn print(&self, cycles: usize) {
        print_number(c"  instructions a cycle, mean", self.sum / cycles as u32);
        print_number(c"  instructions a cycle, most", self.most);
        print_number(c"  stack of a cycle, bytes", self.stack);
    }
}

/// What a period of every law costs by itself, over so many periods that whatever it keeps is full;
/// and of one with its controller.
fn laws<T: Real>() {
    const PERIODS: usize = 2 * CYCLES;
    let Some(weld) = Weld::<T>::new(&ROBOT, &START) else {
        return;
    };
    let thousand = thousand();
    others::laws(&mut |name, law| {
        law.reset();
        let (mut least, mut cost) = (u32::MAX, Cost::default());
        for k in 0..PERIODS {
            let Some(inputs) = weld.inputs(k % CYCLES) else {
                return;
            };
            let spent = cost.of(thousand, &mut || others::ask(law, &weld.robot, &inputs, k));
            least = least.min(spent);
        }
        print_name(name, c"\n");
        print_number(c"  instructions a period, least", least);
        cost.print(PERIODS);
        if name == FULL_CYCLE {
            law.reset();
            full_cycle(name, law, weld.clone());
        }
    });
}

/// What periods of external control with a law cost over the weld.
fn full_cycle<T: Real>(name: &str, law: &mut dyn Compensator<T>, mut weld: Weld<T>) {
    let thousand = thousand();
    let mut cycle = controller(law);
    let mut cost = Cost::default();
    for k in 0..CYCLES {
        let Some(inputs) = weld.inputs(k) else { return };
        if k == 0 {
            cycle.start(&weld.robot, &inputs.sensed.encoder, &inputs.sensed.motor_torque);
        }
        let mut command = None;
        cost.of(thousand, &mut || {
            others::observed(&inputs, k, |observation| {
                command = Some(black_box(black_box(&mut cycle).cycle(&weld.robot, observation)));
            });
        });
        let correction = cycle.correction();
        if command.and_then(|command| weld.follow(&inputs, &command, correction)).is_none() {
            return;
        }
    }
    print_name(name, c"-in-external\n");
    cost.print(CYCLES);
}

/// Ticks of a thousand instructions.
fn thousand() -> u32 {
    ticks(&mut nops)
}

/// A thousand instructions, in a frame of their own: a constant that the code around them loads would
/// be too far away.
#[inline(never)]
fn nops() {
    // SAFETY: touches nothing but the program counter.
    unsafe { asm!(".rept 1000", "nop", ".endr", options(nomem, nostack)) };
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

fn print_name(name: &str, of: &CStr) {
    for byte in name.bytes() {
        // SAFETY: the debugger reads the one byte.
        unsafe { syscall1!(WRITEC, &raw const byte) };
    }
    print(of);
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
