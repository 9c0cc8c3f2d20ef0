//! A command of the program in process.
//!
//! It runs on a thread of its own, which no other command has used, while the calling one sees to
//! signals and progress. It is stopped by unwinding from where it reports its progress; what it
//! writes is written whole or not at all.

use crate::error;
use crate::law::{LawFailure, PythonLaw};
use crate::table::ResultTable;
use clap::{Arg, ArgAction, Command};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::any::TypeId;
use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};
use trueweld::plant::provenance::FileDigest;
use trueweld_cli::{CommandResult, Outcome, Session, SessionError, commands, run_in};
use trueweld_output::{Document, FORMS};

/// Time between two looks at signals and progress.
const LOOK_PERIOD: Duration = Duration::from_millis(50);

/// Time that a stopped command has to end. After that it ends alone with the runs that it has begun,
/// and its result is dropped.
const STOP_PATIENCE: Duration = Duration::from_secs(1);

/// Memory of the command's stack, bytes: that of a program's main thread.
const STACK_BYTES: usize = 8 << 20;

/// What a command that was stopped unwinds with.
struct Stopped;

/// What the thread of a command shares with the calling one.
#[derive(Default)]
struct Shared {
    is_stopped: AtomicBool,
    /// What is done now and the share of the whole that is done, where it changed.
    progress: Mutex<Option<(String, f64)>>,
}

impl Shared {
    /// Takes progress from the thread that works.
    ///
    /// Unwinds where the command is to stop.
    fn hear(&self, label: &str, share: f64, failure: &LawFailure) {
        if self.is_stopped.load(Ordering::Relaxed) || failure.is_set() {
            resume_unwind(Box::new(Stopped));
        }
        // Whoever looks at it holds it for a moment; the next report comes soon.
        if let Ok(mut progress) = self.progress.try_lock() {
            *progress = Some((label.to_owned(), share));
        }
    }
}

/// How the thread of a command ended.
enum Ended {
    Done(Box<Outcome>),
    Refused(SessionError),
    Stopped,
    Panicked(String),
}

/// Runs a command with these arguments, the name of the program left out.
///
/// `laws`: pairs of a name and a law in Python, which `--compensator` and `--laws` may name.
/// `law_file`: the file that they are in, whose digest the result states. `progress`: is called with
/// what is done now and the share of the whole, ten times a second at most.
#[pyfunction]
#[pyo3(signature = (arguments, laws, law_file, progress))]
pub(crate) fn run_command(
    py: Python<'_>,
    arguments: Vec<OsString>,
    laws: Vec<(String, Py<PyAny>)>,
    law_file: Option<PathBuf>,
    progress: Option<Py<PyAny>>,
) -> PyResult<CommandOutcome> {
    let failure = LawFailure::default();
    let session = session(py, laws, law_file, &failure)?;
    let shared = Arc::new(Shared::default());
    let mut ended = spawn(session, arguments, &shared, &failure)?;
    let ended = watch(py, &mut ended, &shared, progress.as_ref());
    // What a law raised comes before what became of the run.
    if let Some(raised) = failure.take() {
        return Err(raised);
    }
    match ended? {
        Ended::Done(outcome) => CommandOutcome::new(py, *outcome),
        Ended::Refused(refused) => Err(error::of_session(py, refused)),
        Ended::Stopped => Err(error::fault("the command stopped by itself")),
        Ended::Panicked(message) => Err(error::fault(&message)),
    }
}

/// The session of a command with laws in Python.
fn session(
    py: Python<'_>,
    laws: Vec<(String, Py<PyAny>)>,
    law_file: Option<PathBuf>,
    failure: &LawFailure,
) -> PyResult<Session> {
    let law_files = match &law_file {
        Some(path) if !laws.is_empty() => vec![
            FileDigest::of_file("law", path)
                .map_err(|refused| error::of_report(py, &refused.into()))?,
        ],
        _ => Vec::new(),
    };
    let unknown = |(name, _): &(String, _)| {
        format!("the law {name} is written in Python: its source is not in the digest")
    };
    let law_warnings = match law_files.is_empty() {
        true => laws.iter().map(unknown).collect(),
        false => Vec::new(),
    };
    let entry = |(name, law)| PythonLaw::new(py, name, law, failure.clone()).map(PythonLaw::entry);
    let laws = laws.into_iter().map(entry).collect::<PyResult<_>>()?;
    Ok(Session { laws, law_files, law_warnings, listener: None })
}

/// Starts the thread of a command.
fn spawn(
    session: Session,
    arguments: Vec<OsString>,
    shared: &Arc<Shared>,
    failure: &LawFailure,
) -> PyResult<Receiver<Ended>> {
    let (sender, receiver) = channel();
    let (heard, failed) = (Arc::clone(shared), failure.clone());
    let listener = move |label: &str, share: f64| heard.hear(label, share, &failed);
    let session = Session { listener: Some(Arc::new(listener)), ..session };
    let words = std::iter::once("trueweld".into()).chain(arguments).collect();
    let run = move || match catch_unwind(AssertUnwindSafe(|| run_in(session, words))) {
        Ok(Ok(outcome)) => Ended::Done(Box::new(outcome)),
        Ok(Err(refused)) => Ended::Refused(refused),
        Err(payload) if payload.is::<Stopped>() => Ended::Stopped,
        Err(payload) => Ended::Panicked(match payload.downcast::<String>() {
            Ok(message) => *message,
            Err(_) => "a command panicked".to_owned(),
        }),
    };
    let work = move || {
        // The thread is known to the interpreter throughout, and does not hold it: a law in Python
        // would otherwise make it known anew in every control period.
        let ended = Python::attach(|py| py.detach(run));
        // Nobody waits any more for a command that was given up.
        let _ = sender.send(ended);
    };
    thread::Builder::new().stack_size(STACK_BYTES).spawn(work)?;
    Ok(receiver)
}

/// Waits for a command, and sees to signals and progress meanwhile.
fn watch(
    py: Python<'_>,
    ended: &mut Receiver<Ended>,
    shared: &Shared,
    progress: Option<&Py<PyAny>>,
) -> PyResult<Ended> {
    loop {
        match wait(py, ended) {
            Ok(ended) => return Ok(ended),
            Err(RecvTimeoutError::Disconnected) => return Err(error::fault("a thread was lost")),
            Err(RecvTimeoutError::Timeout) => {}
        }
        let told = shared.progress.lock().unwrap_or_else(PoisonError::into_inner).take();
        let shown = match (progress, told) {
            (Some(progress), Some(told)) => progress.call1(py, told).map(drop),
            _ => Ok(()),
        };
        if let Err(stop) = shown.and_then(|()| py.check_signals()) {
            shared.is_stopped.store(true, Ordering::Relaxed);
            wait_for_end(py, ended);
            return Err(stop);
        }
    }
}

/// Waits for a moment, without the interpreter.
fn wait(py: Python<'_>, ended: &mut Receiver<Ended>) -> Result<Ended, RecvTimeoutError> {
    py.detach(move || ended.recv_timeout(LOOK_PERIOD))
}

/// Gives a stopped command time to end; a second signal cuts it short.
fn wait_for_end(py: Python<'_>, ended: &mut Receiver<Ended>) {
    let since = Instant::now();
    while since.elapsed() < STOP_PATIENCE
        && matches!(wait(py, ended), Err(RecvTimeoutError::Timeout))
        && py.check_signals().is_ok()
    {}
}

/// What a command leaves behind.
#[pyclass(frozen, module = "trueweld._core")]
pub(crate) struct CommandOutcome {
    /// 0, or 1 where what was asked for is not reached.
    #[pyo3(get)]
    status: u8,
    /// What the program prints.
    #[pyo3(get)]
    text: String,
    /// Values outside their plausible range, and what else a reader should know of the inputs.
    #[pyo3(get)]
    warnings: Vec<String>,
    /// The results.
    #[pyo3(get)]
    results: Vec<Py<FoundResult>>,
}

impl CommandOutcome {
    fn new(py: Python<'_>, outcome: Outcome) -> PyResult<Self> {
        let Outcome { status, text, warnings, results } = outcome;
        let results = results.into_iter().map(|result| FoundResult::new(py, result));
        Ok(Self { status, text, warnings, results: results.collect::<PyResult<_>>()? })
    }
}

/// One result in all its forms.
#[pyclass(frozen, module = "trueweld._core")]
pub(crate) struct FoundResult {
    /// Name and version of the file for programs.
    #[pyo3(get)]
    schema: &'static str,
    /// The text of that file, as the program writes it.
    #[pyo3(get)]
    json: String,
    document: Option<Document>,
    /// Every sample; `None` where the result has none.
    #[pyo3(get)]
    samples: Option<Py<ResultTable>>,
}

#[pymethods]
impl FoundResult {
    /// The finding in a sentence or two; `None` where the result is text alone.
    #[getter]
    fn headline(&self) -> Option<&str> {
        self.document.as_ref().map(Document::headline)
    }

    /// The page; `None` where the result is text alone.
    fn page(&self, py: Python<'_>) -> Option<String> {
        let document = self.document.as_ref()?;
        Some(py.detach(|| (FORMS[0].write)(document)))
    }
}

impl FoundResult {
    fn new(py: Python<'_>, result: CommandResult) -> PyResult<Py<Self>> {
        let CommandResult { schema, json, document, samples } = result;
        let samples =
            samples.map(|samples| Py::new(py, ResultTable::new(py, samples)?)).transpose()?;
        Py::new(py, Self { schema, json, document, samples })
    }
}

/// Every command with its arguments, as the command line has them: what the facade is made of.
#[pyfunction]
pub(crate) fn describe_commands(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let mut program = commands();
    program.build();
    let mut found = Vec::new();
    describe(py, &program, &[], &mut found)?;
    Ok(found)
}

/// What a value of an argument is in Python.
fn kind_of(argument: &Arg) -> &'static str {
    let kind = argument.get_value_parser().type_id();
    let is = |kinds: &[TypeId]| kinds.iter().any(|of| kind == *of);
    if is(&[TypeId::of::<PathBuf>()]) {
        "path"
    } else if is(&[TypeId::of::<f64>()]) {
        "float"
    } else if is(&[TypeId::of::<u64>(), TypeId::of::<u32>(), TypeId::of::<usize>()]) {
        "int"
    } else {
        "str"
    }
}

fn describe<'py>(
    py: Python<'py>,
    command: &Command,
    names: &[&str],
    found: &mut Vec<Bound<'py, PyDict>>,
) -> PyResult<()> {
    let inner: Vec<&Command> =
        command.get_subcommands().filter(|inner| inner.get_name() != "help").collect();
    for inner in &inner {
        describe(py, inner, &[names, &[inner.get_name()]].concat(), found)?;
    }
    if !inner.is_empty() || names.is_empty() {
        return Ok(());
    }
    let arguments =
        command.get_arguments().filter(|of| !["help", "version"].contains(&of.get_id().as_str()));
    let arguments = arguments.map(|of| {
        let argument = PyDict::new(py);
        let defaults =
            of.get_default_values().iter().map(|value| value.to_string_lossy().into_owned());
        let help = of.get_long_help().or(of.get_help()).map(ToString::to_string);
        argument.set_item("name", of.get_id().as_str())?;
        argument.set_item("flag", of.get_long())?;
        argument.set_item("help", help)?;
        argument.set_item("is_switch", matches!(of.get_action(), ArgAction::SetTrue))?;
        argument.set_item(
            "is_repeated",
            matches!(of.get_action(), ArgAction::Append)
                || of.get_num_args().is_some_and(|n| n.max_values() > 1),
        )?;
        argument.set_item("delimiter", of.get_value_delimiter())?;
        argument.set_item("is_required", of.is_required_set())?;
        argument.set_item("type", kind_of(of))?;
        argument.set_item(
            "value_name",
            of.get_value_names().and_then(|names| names.first()).map(ToString::to_string),
        )?;
        argument.set_item("defaults", defaults.collect::<Vec<_>>())?;
        Ok(argument)
    });
    let description = PyDict::new(py);
    description.set_item("names", names)?;
    let about = command.get_long_about().or(command.get_about()).map(ToString::to_string);
    description.set_item("about", about)?;
    description.set_item("arguments", arguments.collect::<PyResult<Vec<_>>>()?)?;
    found.push(description);
    Ok(())
}
