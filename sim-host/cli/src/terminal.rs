//! What reaches the terminal: text without what a terminal would obey, data as it is, and errors.

use crate::session;
use miette::{IntoDiagnostic, MietteDiagnostic, Report, Result, WrapErr};
use std::io::{ErrorKind, Write, stderr, stdout};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use trueweld_plant::input::{InputError, printable, warnings};

/// True where standard output is for a result alone (`--json -`): text goes to standard error then.
static RESULT_ON_STDOUT: AtomicBool = AtomicBool::new(false);

/// From now on standard output is for a result alone.
pub(crate) fn keep_stdout_for_result() {
    RESULT_ON_STDOUT.store(true, Ordering::Relaxed);
}

/// Prints text for people.
///
/// # Errors
/// Those of [`write_all`].
pub(crate) fn say(text: &str) -> Result<()> {
    let text = printable(text);
    if session::take_text(&text) {
        Ok(())
    } else if RESULT_ON_STDOUT.load(Ordering::Relaxed) {
        write_all(stderr(), text.as_bytes())
    } else {
        write_all(stdout(), text.as_bytes())
    }
}

/// Tells what is wrong on standard error. Where that cannot be written, nobody is there to read it, and
/// the status tells.
pub(crate) fn complain(text: &str) {
    if session::take_text(text) {
        return;
    }
    let _ = write_all(stderr(), text.as_bytes());
}

/// Tells values outside their plausible range on standard error, each once.
pub(crate) fn tell_warnings() {
    if session::is_running() {
        return;
    }
    static TOLD: AtomicUsize = AtomicUsize::new(0);
    let warnings = warnings();
    let told = TOLD.swap(warnings.len(), Ordering::Relaxed);
    for warning in warnings.iter().skip(told) {
        complain(&format!("Warning: {}\n", printable(warning)));
    }
}

/// Writes a result to standard output, byte by byte.
///
/// # Errors
/// Those of [`write_all`].
pub(crate) fn write_result(bytes: &[u8]) -> Result<()> {
    if session::take_text(&String::from_utf8_lossy(bytes)) {
        return Ok(());
    }
    write_all(stdout(), bytes)
}

/// # Errors
/// The operating system's, such as a full disk. A reader that has gone (`| head`) is no error.
fn write_all(mut to: impl Write, bytes: &[u8]) -> Result<()> {
    match to.write_all(bytes).and_then(|()| to.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(error).into_diagnostic().wrap_err("cannot write to standard output")
        }
        _ => Ok(()),
    }
}

/// An error fit for the terminal. Those of input files are so already.
pub(crate) fn shown(error: Report) -> Report {
    match error.downcast::<InputError>() {
        Ok(error) => error.into(),
        Err(error) => {
            let chain: Vec<String> = error.chain().map(|e| printable(&e.to_string())).collect();
            let mut plain = MietteDiagnostic::new(chain.join(": "));
            plain.help = error.help().map(|help| printable(&help.to_string()));
            plain.into()
        }
    }
}
