//! A command inside another program: what it would print, show and write is handed over instead.
//!
//! A session belongs to the thread that runs the command. Commands ask for it where they would reach
//! the terminal; without one they do.

use std::cell::RefCell;
use std::ffi::OsString;
use trueweld_compensators::{Entry, find_among};
use trueweld_output::{CollectedSamples, Document, Progress, ProgressListener, Report};
use trueweld_plant::input::{warn, warnings};
use trueweld_plant::provenance::FileDigest;

/// What a command is run with beside its arguments.
#[derive(Default)]
pub struct Session {
    /// Laws that this command alone knows, before those of the library.
    pub laws: Vec<Entry>,
    /// The files that these laws were read from: they enter the digest of a result.
    pub law_files: Vec<FileDigest>,
    /// What a reader of the result should know of these laws.
    pub law_warnings: Vec<String>,
    /// Is told how far the work is, from whatever thread works. It may end the work by unwinding.
    pub listener: Option<ProgressListener>,
}

/// What a command leaves behind.
#[derive(Default)]
pub struct Outcome {
    /// The status with which the program would end: 0, or 1 where what was asked for is not reached.
    pub status: u8,
    /// What the program would have printed.
    pub text: String,
    /// Values outside their plausible range, as they were read.
    pub warnings: Vec<String>,
    /// The results, in the order in which they were found.
    pub results: Vec<CommandResult>,
}

/// One result in all its forms.
pub struct CommandResult {
    /// Name and version of the file for programs.
    pub schema: &'static str,
    /// The text of that file.
    pub json: String,
    /// What people read; `None` where that is text alone.
    pub document: Option<Document>,
    /// Every sample; `None` where the result has none.
    pub samples: Option<CollectedSamples>,
}

/// A session and what its command has left so far.
struct Running {
    session: Session,
    outcome: Outcome,
}

thread_local! {
    static RUNNING: RefCell<Option<Running>> = const { RefCell::new(None) };
    /// The arguments of the command, where they are not those of this process.
    static ARGUMENTS: RefCell<Option<Vec<OsString>>> = const { RefCell::new(None) };
}

/// Runs `work` in a session, on this thread.
pub(crate) fn run<E>(session: Session, work: impl FnOnce() -> Result<u8, E>) -> Result<Outcome, E> {
    session.law_warnings.iter().cloned().for_each(warn);
    RUNNING.set(Some(Running { session, outcome: Outcome::default() }));
    let status = work();
    let running = RUNNING.take();
    let outcome = running.map(|running| running.outcome).unwrap_or_default();
    Ok(Outcome { status: status?, warnings: warnings(), ..outcome })
}

/// True inside a session.
pub(crate) fn is_running() -> bool {
    RUNNING.with_borrow(Option::is_some)
}

/// Takes text that would be printed; false where there is no session.
pub(crate) fn take_text(text: &str) -> bool {
    let take = |running: &mut Running| running.outcome.text += text;
    RUNNING.with_borrow_mut(|running| running.as_mut().map(take)).is_some()
}

/// Takes a result in all its forms, where there is a session.
pub(crate) fn take_result<R: Report>(report: &R) {
    if !is_running() {
        return;
    }
    take(CommandResult {
        schema: R::SCHEMA,
        json: report.json_text(),
        document: Some(report.document()),
        samples: report.samples().map(|samples| samples.collect()),
    });
}

/// Takes a result; false where there is no session.
pub(crate) fn take(result: CommandResult) -> bool {
    let take = |running: &mut Running| running.outcome.results.push(result);
    RUNNING.with_borrow_mut(|running| running.as_mut().map(take)).is_some()
}

/// The progress that a session listens to; `None` where nobody does.
pub(crate) fn progress(label: &str, total: f64) -> Option<Progress> {
    let of = |running: &Running| running.session.listener.clone();
    let listener = RUNNING.with_borrow(|running| running.as_ref().and_then(of))?;
    Some(Progress::heard(label, total, listener))
}

/// The law of a name, those of the session first.
///
/// # Errors
/// The name, or the part of it, that no law has.
pub(crate) fn find_law(name: &str) -> Result<Entry, &str> {
    RUNNING.with_borrow(|running| {
        let own = running.as_ref().map_or(&[][..], |running| &running.session.laws);
        find_among(name, own)
    })
}

/// The files of the session's laws.
pub(crate) fn law_files() -> Vec<FileDigest> {
    let files = |running: &Running| running.session.law_files.clone();
    RUNNING.with_borrow(|running| running.as_ref().map_or(Vec::new(), files))
}

/// From now on the command of this thread is that of these arguments.
pub(crate) fn set_arguments(arguments: &[OsString]) {
    ARGUMENTS.set(Some(arguments.to_vec()));
}

/// The arguments of this thread's command; those of this process where it has none of its own.
pub(crate) fn arguments() -> Vec<OsString> {
    ARGUMENTS.with_borrow(Clone::clone).unwrap_or_else(|| std::env::args_os().collect())
}
