//! Commands inside another program.

use crate::support::{Workspace, fixture};
use std::ffi::OsString;
use std::sync::Arc;
use std::thread;
use trueweld_cli::{Outcome, Session, SessionError, run_in};

/// Runs a command on a thread that has run no other one.
fn run(session: Session, arguments: &[&str]) -> Result<Outcome, String> {
    let words = std::iter::once("trueweld").chain(arguments.iter().copied());
    let words: Vec<OsString> = words.map(Into::into).collect();
    let told = |error| match error {
        SessionError::Arguments(error) => error.to_string(),
        SessionError::Command(report) => report.to_string(),
    };
    thread::spawn(move || run_in(session, words).map_err(told)).join().expect("no panic")
}

#[test]
fn a_session_is_handed_the_bytes_that_the_program_writes() {
    let place = Workspace::new();
    let [model, log] =
        ["model.toml", "static"].map(|of| fixture(&format!("campaigns/backlash/{of}")));
    let compare = ["compare", "--model", &model, &log];
    let files = ["--json", "c.json", "--html", "c.html", "-q"];
    let printed = place.done(&[&compare[..], &files].concat());
    let outcome = run(Session::default(), &compare).expect("a comparison");
    let [result] = &outcome.results[..] else { panic!("one result") };
    assert_eq!(result.json.as_bytes(), place.bytes("c.json"));
    let page = result.document.as_ref().map(|of| (trueweld_output::FORMS[0].write)(of));
    assert_eq!(page.unwrap_or_default().as_bytes(), place.bytes("c.html"));
    assert!(printed.starts_with(&outcome.text), "{printed}");
    assert!(result.samples.as_ref().is_some_and(|table| table.columns.len() == 12));
}

#[test]
fn what_a_command_cannot_do_is_an_error_and_ends_nothing() {
    let refused = |arguments: &[&str]| run(Session::default(), arguments).err().unwrap_or_default();
    assert!(refused(&["weld", "--passes", "0"]).contains("--passes"));
    assert!(refused(&["weld", "--weld", "gone.toml"]).contains("gone.toml"));
}

#[test]
fn a_listener_may_stop_a_command_by_unwinding() {
    let place = Workspace::new();
    let weld = place.path().join("short.toml").display().to_string();
    let stop = |_: &str, share: f64| {
        if share > 0.1 {
            std::panic::resume_unwind(Box::new("stopped"));
        }
    };
    let session = Session { listener: Some(Arc::new(stop)), ..Session::default() };
    let refused = run(session, &["weld", "--weld", &weld]).err();
    assert!(refused.is_some_and(|why| why.contains("stopped")));
}
