//! Errors of Rust as exceptions of Python.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyType;
use trueweld::plant::input::InputError;
use trueweld_cli::SessionError;

/// An exception class of `trueweld._errors`.
fn class<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyType>> {
    Ok(py.import("trueweld._errors")?.getattr(name)?.cast_into::<PyType>()?)
}

/// An exception of a class of `trueweld._errors`; where that cannot be made, why.
fn raised<'py>(
    py: Python<'py>,
    name: &str,
    arguments: impl FnOnce(&Bound<'py, PyType>) -> PyResult<Bound<'py, PyAny>>,
) -> PyErr {
    class(py, name).and_then(|of| arguments(&of)).map_or_else(|error| error, PyErr::from_value)
}

/// What a command of a session cannot do.
pub(crate) fn of_session(py: Python<'_>, error: SessionError) -> PyErr {
    match error {
        SessionError::Arguments(error) => {
            let text = error.render().to_string();
            // Behind it the command line says where its help is.
            let text = text.split("\n\nFor more information").next().unwrap_or_default();
            let text = text.trim().trim_start_matches("error: ").to_owned();
            raised(py, "ArgumentError", |class| class.call1((text,)))
        }
        SessionError::Command(report) => of_report(py, &report),
    }
}

/// An error of the front door: of an input file with its place, where there is one behind it.
pub(crate) fn of_report(py: Python<'_>, report: &miette::Report) -> PyErr {
    let chain = || report.chain();
    if let Some(input) = chain().find_map(|error| error.downcast_ref::<InputError>()) {
        return of_input(py, input);
    }
    let message = chain().map(ToString::to_string).collect::<Vec<_>>().join(": ");
    let help = report.help().map(|help| help.to_string());
    raised(py, "CommandError", |class| class.call1((message, help)))
}

/// An error of an input file, with its place.
fn of_input(py: Python<'_>, error: &InputError) -> PyErr {
    let (file, line, column) = place(error.place());
    raised(py, "InputError", |class| {
        class.call1((error.message(), error.help_text(), file, line, column))
    })
}

/// File, line and column of `file:line:column`, or of the file alone.
fn place(text: &str) -> (&str, Option<usize>, Option<usize>) {
    let mut parts = text.rsplitn(3, ':');
    let (column, line, file) = (parts.next(), parts.next(), parts.next());
    let number = |part: Option<&str>| part.and_then(|part| part.parse().ok());
    match (file, number(line), number(column)) {
        (Some(file), Some(line), Some(column)) => (file, Some(line), Some(column)),
        _ => (text, None, None),
    }
}

/// What a law in Python gave that is no demand.
pub(crate) fn of_law(py: Python<'_>, message: String) -> PyErr {
    raised(py, "LawError", |class| class.call1((message,)))
}

/// A fault of this program, which no input should be able to cause.
pub(crate) fn fault(what: &str) -> PyErr {
    PyRuntimeError::new_err(format!("{what}: this is a fault of trueweld, please report it"))
}
