//! Files that were damaged at random, for readers that must refuse them or make sense of them.
//!
//! [`never_breaks`] gives a reader so many damaged copies of a good file: a few hundred in the
//! ordinary tests, 10⁷ in the long run, which `BOLERO_RANDOM_ITERATIONS` asks for. What fails is
//! shrunk to the fewest edits, and printed with the seed that gives it again.

// Public in one of the crates that take it.
#![allow(unreachable_pub)]

use bolero::produce;
use std::fs;
use std::panic::RefUnwindSafe;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// One change of a file: what is done, where, where else, and how much.
pub type Edit = (u8, u16, u16, u8);

/// Damaged copies that an ordinary test gives a reader.
const SHORT_RUN: usize = 300;

/// No reader may take longer for a file of a few kilobytes.
const LONGEST: Duration = Duration::from_secs(5);

/// What takes so long will not end.
const HANGS: Duration = Duration::from_secs(120);

/// No process may take more memory, bytes.
const MOST_MEMORY: u64 = 1 << 30;

/// Between two looks at the memory; a look costs as much as a small file.
const LOOK_EVERY: u64 = 1024;

/// A damaged file is at most so much longer than the good one, bytes.
const MOST_ADDED: usize = 1 << 16;

/// What files are made of, and what makes readers stumble.
const WORDS: [&[u8]; 62] = [
    b"0",
    b"1",
    b"-1",
    b"9",
    b"-",
    b"+",
    b".",
    b",",
    b";",
    b"\t",
    b" ",
    b"\n",
    b"\r",
    b"\r\n",
    b"\"",
    b"\"\"\"",
    b"'",
    b"#",
    b"=",
    b"[",
    b"]",
    b"[[",
    b"]]",
    b"{",
    b"}",
    b"(",
    b")",
    b"^",
    b"*",
    b"/",
    b"<",
    b">",
    b"/>",
    b"</",
    b"<!--",
    b"<![CDATA[",
    b"&",
    b"&amp;",
    b"-0.0",
    b"1e308",
    b"-1e308",
    b"1e-320",
    b"1e999",
    b"1e12",
    b"1e-12",
    b"nan",
    b"-inf",
    b"null",
    b"true",
    b"4294967296",
    b"9223372036854775807",
    b"18446744073709551616",
    b"0x7fffffffffffffff",
    b"0.1e",
    b"1_0",
    b"..",
    b"\0",
    b"\x7f",
    b"\xff",
    b"\xef\xbb\xbf",
    b"\xc3\xa9",
    b"\xe2\x88\x9e",
];

/// Numbers of eight bytes that binary files stumble over.
const NUMBERS: [u64; 10] = [
    0,
    1,
    0x7f,
    1 << 31,
    1 << 32,
    1 << 40,
    i64::MAX as u64,
    u64::MAX,
    0x7ff8_0000_0000_0000, // NaN
    0x7fef_ffff_ffff_ffff, // the largest double
];

/// The good file with every edit made, one after the other. `words`: more that such a file is made
/// of.
pub fn damaged(good: &[u8], edits: &[Edit], words: &[&str]) -> Vec<u8> {
    let most = good.len() + MOST_ADDED;
    let mut bytes = good.to_vec();
    for edit in edits {
        apply(&mut bytes, *edit, words);
        bytes.truncate(most);
    }
    bytes
}

fn apply(bytes: &mut Vec<u8>, (what, at, to, amount): Edit, words: &[&str]) {
    let place = |share: u16, length: usize| usize::from(share) * length / 65_536;
    let (at, other) = (place(at, bytes.len() + 1), place(to, bytes.len() + 1));
    let piece = at..(at + usize::from(amount)).min(bytes.len());
    let word = match words.get(usize::from(to) % (WORDS.len() + words.len())) {
        Some(word) => word.as_bytes(),
        None => WORDS[usize::from(to) % WORDS.len()],
    };
    match what % 14 {
        0 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte = amount),
        1 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << (amount % 8)),
        2 => drop(bytes.splice(at..at, word.iter().copied())),
        3 => drop(bytes.splice(at..(at + word.len()).min(bytes.len()), word.iter().copied())),
        4 => drop(bytes.drain(at..(at + usize::from(amount % 32)).min(bytes.len()))),
        5 => drop(bytes.drain(piece)),
        6 => bytes.truncate(at),
        7 => {
            let number = NUMBERS[usize::from(amount) % NUMBERS.len()].to_le_bytes();
            bytes.iter_mut().skip(at).zip(number).for_each(|(byte, new)| *byte = new);
        }
        8 => {
            let piece = bytes[piece].to_vec();
            drop(bytes.splice(other..other, piece));
        }
        9 => {
            // Nested, or longer than anybody writes; rarely very long, which takes its time.
            let piece = bytes[at..(at + usize::from(amount % 8) + 1).min(bytes.len())].to_vec();
            let most = if amount >= 252 { MOST_ADDED } else { 512 };
            let times = place(to, most) / piece.len().max(1);
            drop(bytes.splice(at..at, piece.repeat(times)));
        }
        10 => drop(bytes.drain(line(bytes, at))),
        11 => {
            let line = bytes[line(bytes, at)].to_vec();
            let there = self::line(bytes, other).start;
            drop(bytes.splice(there..there, line));
        }
        // A number becomes another.
        _ => {
            let digit = |byte: &u8| byte.is_ascii_digit();
            let Some(start) = bytes[at..].iter().position(digit).map(|i| at + i) else { return };
            let part = |byte: &u8| byte.is_ascii_alphanumeric() || b".+-".contains(byte);
            let length = bytes[start..].iter().take_while(|byte| part(byte)).count();
            drop(bytes.splice(start..start + length, word.iter().copied()));
        }
    }
}

/// The line that a byte stands on, with its ending.
fn line(bytes: &[u8], at: usize) -> std::ops::Range<usize> {
    let start = bytes[..at].iter().rposition(|byte| *byte == b'\n').map_or(0, |i| i + 1);
    let end = bytes[at..].iter().position(|byte| *byte == b'\n');
    start..end.map_or(bytes.len(), |i| at + i + 1)
}

/// Most memory that this process took so far, bytes, where the system tells.
fn peak() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kilobytes| kilobytes << 10)
}

/// How long this thread has been at work, where the system tells.
fn working_time() -> Option<Duration> {
    let state = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    state.split_whitespace().next()?.parse().ok().map(Duration::from_nanos)
}

/// Ends the process where an input is worked on without end: no assertion would see that.
struct Watch(Arc<Mutex<(Instant, Vec<Edit>)>>);

impl Watch {
    fn new(name: &str) -> Self {
        let current = Arc::new(Mutex::new((Instant::now(), Vec::new())));
        let (seen, name) = (Arc::downgrade(&current), name.to_owned());
        std::thread::spawn(move || {
            while let Some(current) = seen.upgrade() {
                std::thread::sleep(Duration::from_secs(1));
                let current = current.lock().unwrap_or_else(PoisonError::into_inner);
                if current.0.elapsed() > HANGS {
                    eprintln!("{name} hangs: {:?}", current.1);
                    std::process::abort();
                }
            }
        });
        Self(current)
    }

    fn begins(&self, edits: &[Edit]) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = (Instant::now(), edits.to_vec());
    }
}

/// Gives `read` damaged copies of a good file. None may make it panic, hang, or take a gigabyte.
///
/// # Panics
/// Where one does.
pub fn never_breaks(name: &str, good: &[u8], words: &[&str], read: impl Fn(&[u8]) + RefUnwindSafe) {
    let (begun, count, watch) = (Instant::now(), AtomicU64::new(0), Watch::new(name));
    let edits = produce::<Vec<Edit>>().with().len(1_usize..8);
    bolero::check!(name = name).with_iterations(SHORT_RUN).with_generator(edits).for_each(
        |edits| {
            let bytes = damaged(good, edits, words);
            watch.begins(edits);
            let start = Instant::now();
            read(&bytes);
            // A machine may be busy with something else: the work for it is counted once more.
            if start.elapsed() > LONGEST {
                let worked = working_time();
                read(&bytes);
                let took = match (worked, working_time()) {
                    (Some(before), Some(after)) => after - before,
                    _ => start.elapsed(),
                };
                assert!(took < LONGEST, "{name}: {took:?}");
            }
            if count.fetch_add(1, Ordering::Relaxed) % LOOK_EVERY == 0 {
                let peak = peak().unwrap_or(0);
                assert!(peak < MOST_MEMORY, "{name}: {peak} bytes");
            }
        },
    );
    println!(
        "{name}: {} inputs in {:.0?}, at most {} MB",
        count.into_inner(),
        begun.elapsed(),
        peak().unwrap_or(0) >> 20
    );
}
