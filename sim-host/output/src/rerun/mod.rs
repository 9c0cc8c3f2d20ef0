//! Recordings for the Rerun viewer: the arm, its path and every signal of finished welds, with the layout to see them in.
//!
//! Deviations of millimetres on an arm of three metres are drawn enlarged by one factor, the arm's with the path's:
//! joint angles about the angles that would hold the nominal pose, the path about the seam. With a factor of 1 the
//! picture is to scale. Signals are never enlarged.

mod layout;
mod scene;
mod signals;
mod writer;

use crate::{OutputError, WeldRun, file};
use std::io::BufWriter;
use std::path::Path;
use writer::{RecordError, Writer};

/// Name under which the viewer files recordings and keeps their layout.
const APPLICATION: &str = "trueweld";

/// A run and how it appears in the recording.
struct Shown<'a> {
    run: WeldRun<'a>,
    /// Root of its entities.
    root: String,
    /// Its name for people.
    name: String,
    color: crate::color::Rgb,
    /// Distance gone along the seam, m, one value a row.
    travelled: Vec<f64>,
}

/// Writes welds of one seam into a recording at `path`, each under its own root, with the layout to compare them.
///
/// `exaggeration` enlarges what is drawn in space, not the signals. Timelines: `time`, and `path_um`, the position on the
/// seam in micrometres, for rows in which the tool moves. The same runs give the same bytes.
///
/// # Errors
/// [`OutputError`] with the path; no file is left behind.
pub fn weld_recording(path: &Path, runs: &[WeldRun], exaggeration: f64) -> Result<(), OutputError> {
    let shown = shown(runs);
    file::replace(path, |file| {
        let mut file = BufWriter::new(file);
        write(&mut file, &shown, exaggeration).map_err(|error| match error {
            RecordError::File(source) => file::failed(path, source),
            RecordError::Library(reason) => OutputError::Record { path: path.to_owned(), reason },
        })
    })
}

fn write(file: &mut impl std::io::Write, shown: &[Shown], exaggeration: f64) -> Result<(), RecordError> {
    let weld = shown.first().map_or("empty", |s| s.run.recording.weld.as_str());
    let mut writer = Writer::new(&mut *file, weld)?;
    layout::send(&mut writer, shown, exaggeration)?;
    scene::cell(&mut writer, shown, exaggeration)?;
    for run in shown {
        scene::arm(&mut writer, run, exaggeration)?;
        signals::all(&mut writer, run)?;
    }
    writer.finish()?;
    file.flush().map_err(RecordError::File)
}

fn shown<'a>(runs: &[WeldRun<'a>]) -> Vec<Shown<'a>> {
    let names = crate::figures::run_names(runs);
    let roots = names.iter().map(|name| match name.as_str() {
        "no compensation" => "none".to_owned(),
        name => {
            let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
            name.chars().map(plain).collect::<String>().replace("__", "_")
        }
    });
    runs.iter()
        .zip(&names)
        .zip(roots)
        .enumerate()
        .map(|(k, ((run, name), root))| Shown {
            run: *run,
            root,
            name: name.clone(),
            color: crate::color::run(k),
            travelled: crate::path::travelled(&run.recording.rows),
        })
        .collect()
}

#[cfg(test)]
mod tests;
