//! Where results go.

use crate::init::is_template;
use crate::{session, terminal};
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, value_parser};
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::path::{Path, PathBuf};
use trueweld_output::{FORMS, Form, Progress, Recorded, Report, is_parquet, write_file};
use trueweld_plant::input::{files_read, folder_of, may_write_into, remove_stale};

/// Result files of any command.
#[derive(Args, Clone, Default)]
pub(crate) struct Results {
    /// Write the figures as JSON; `-` writes them to standard output, and the text to standard error
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    #[command(flatten)]
    pub forms: FormFiles,
    /// Write every sample as a table: Parquet where FILE ends in .parquet, CSV where in .csv
    #[arg(long, value_name = "FILE")]
    pub samples: Option<PathBuf>,
    /// No progress bar
    #[arg(long, short)]
    pub quiet: bool,
}

impl Results {
    /// The files asked for, and the flags that ask for them.
    pub(crate) fn outputs(&self) -> Vec<(&'static str, &Path)> {
        let json = self.json.iter().map(|path| ("--json", path));
        let forms = self.forms.0.iter().map(|(form, path)| (form.flag, path));
        let samples = self.samples.iter().map(|path| ("--samples", path));
        json.chain(forms).chain(samples).map(|(flag, path)| (flag, path.as_path())).collect()
    }

    /// The bar of some work.
    pub(crate) fn progress(&self, label: &str, total: f64) -> Progress {
        session::progress(label, total).unwrap_or_else(|| match self.quiet {
            true => Progress::silent(),
            false => Progress::new(label, total),
        })
    }

    /// Shows a result, and writes the files that were asked for.
    pub(crate) fn write(&self, report: &impl Report) -> Result<()> {
        session::take_result(report);
        say!("{}", report.text());
        if let Some(path) = &self.json {
            write(path, &report.json_text())?;
        }
        for (form, path) in &self.forms.0 {
            write(path, &(form.write)(&report.document()))?;
        }
        match (&self.samples, report.samples()) {
            (None, _) => {}
            (Some(path), Some(samples)) => {
                samples.write(path)?;
                say!("wrote {}\n", path.display());
            }
            (Some(path), None) => say!("nothing was compared: no {} is written\n", path.display()),
        }
        Ok(())
    }
}

/// Files of the forms that a document can be written in, where they are asked for.
#[derive(Clone, Default)]
pub(crate) struct FormFiles(Vec<(&'static Form, PathBuf)>);

impl FormFiles {
    /// The same with a page, where none is asked for and nobody takes the result over.
    pub(crate) fn or_page(mut self, path: &str) -> Self {
        let page = &FORMS[0];
        if !session::is_running() && self.0.iter().all(|(form, _)| form.flag != page.flag) {
            self.0.push((page, path.into()));
        }
        self
    }
}

fn option(form: &Form) -> &'static str {
    form.flag.trim_start_matches('-')
}

impl FromArgMatches for FormFiles {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let asked =
            |form: &'static Form| Some((form, matches.get_one::<PathBuf>(option(form)).cloned()?));
        Ok(Self(FORMS.iter().filter_map(asked).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for FormFiles {
    fn augment_args(command: Command) -> Command {
        FORMS.iter().fold(command, |command, form| {
            let name = option(form);
            let file = Arg::new(name).long(name).value_name("FILE").help(form.help);
            command.arg(file.value_parser(value_parser!(PathBuf)))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// Result files of a command whose result can be recorded.
#[derive(Args, Default)]
pub(crate) struct RecordedResults {
    #[command(flatten)]
    pub files: Results,
    /// Write a Rerun recording (open with: rerun FILE)
    #[arg(long, value_name = "FILE")]
    pub rrd: Option<PathBuf>,
}

impl RecordedResults {
    /// As [`Results::outputs`].
    pub(crate) fn outputs(&self) -> Vec<(&'static str, &Path)> {
        let mut outputs = self.files.outputs();
        outputs.extend(self.rrd.as_deref().map(|path| ("--rrd", path)));
        outputs
    }

    /// As [`Results::write`].
    pub(crate) fn write(&self, report: &(impl Report + Recorded)) -> Result<()> {
        self.files.write(report)?;
        #[cfg(feature = "rerun")]
        if let Some(path) = &self.rrd {
            report.record(path)?;
            say!("wrote {}\n", path.display());
        }
        Ok(())
    }
}

/// The path that stands for standard output.
const STDOUT: &str = "-";

/// Writes a result and says so; to standard output where the path is `-`.
///
/// # Errors
/// The operating system's.
pub(crate) fn write(path: &Path, text: &str) -> Result<()> {
    if path == Path::new(STDOUT) {
        return terminal::write_result(text.as_bytes());
    }
    write_file(path, text)?;
    say!("wrote {}\n", path.display());
    Ok(())
}

/// The folder that the program and its guide write into: made where it is not there. A folder of
/// another name may be a slip.
const OUT: &str = "out";

/// Checks whether the outputs of a command can be written, each with the flag that asks for it:
/// before anything is read.
///
/// # Errors
/// A path in no folder or in one that cannot be written into, a folder, a form that this build does
/// not have.
pub(crate) fn check_targets(outputs: &[(&str, &Path)]) -> Result<()> {
    for (flag, path) in outputs {
        let refuse = |why: &str| refused(flag, path, why);
        if *flag == "--rrd" && cfg!(not(feature = "rerun")) {
            return Err(miette!(
                "--rrd: this build has no Rerun; build it with the feature `rerun`"
            ));
        }
        if *flag == "--samples" && is_parquet(path) && cfg!(not(feature = "parquet")) {
            return refuse("this build has no Parquet; build it with the feature `parquet`");
        }
        if *flag == "--samples" && !is_parquet(path) && path.extension() != Some("csv".as_ref()) {
            return refuse("expected a name that ends in .csv or .parquet");
        }
        if *path == Path::new(STDOUT) {
            if *flag != "--json" && FORMS.iter().all(|form| form.flag != *flag) {
                return refuse("only text goes to standard output; expected the name of a file");
            }
            terminal::keep_stdout_for_result();
        } else if path.is_dir() {
            return refuse("expected the name of a file, and it is a folder");
        } else if !path.exists() || path.is_file() {
            let folder = folder_of(path);
            let made = folder == Path::new(OUT) && !folder.exists();
            check_folder(flag, path, if made { Path::new(".") } else { folder })?;
        }
    }
    Ok(())
}

/// Checks a folder that is to be made where it is not there, with those above it.
///
/// # Errors
/// A file of that name; a folder in which it cannot be made.
pub(crate) fn check_new_folder(flag: &str, path: &Path) -> Result<()> {
    let there = path.ancestors().find(|folder| folder.exists()).unwrap_or(Path::new("."));
    check_folder(flag, path, there)
}

/// The same of one that nothing may be in yet, because recordings are never written over.
///
/// # Errors
/// Those of [`check_new_folder`]; something in it.
pub(crate) fn check_empty_folder(flag: &str, path: &Path) -> Result<()> {
    check_new_folder(flag, path)?;
    if path.exists() && std::fs::read_dir(path).into_diagnostic()?.next().is_some() {
        return Err(miette!(
            help = "Recordings are never written over: give another folder, or remove this one.",
            "{flag} {}: there is something in this folder; expected a new or an empty one",
            path.display()
        ));
    }
    Ok(())
}

fn check_folder(flag: &str, path: &Path, folder: &Path) -> Result<()> {
    if !folder.is_dir() {
        let folder = folder.display();
        return refused(flag, path, &format!("expected a folder {folder}, and there is none"));
    }
    may_write_into(folder).or_else(|error| {
        let folder = folder.display();
        refused(flag, path, &format!("the folder {folder} cannot be written into: {error}"))
    })
}

fn refused(flag: &str, path: &Path, why: &str) -> Result<()> {
    Err(miette!("{flag}: cannot write {}: {why}", path.display()))
}

/// Checks the outputs of a command once its inputs are read, and before its work: every file that
/// was read until now is an input, those that other files name included. Also tells the warnings
/// about the inputs, makes the folder `out`, and removes what a killed run left in the folders.
///
/// # Errors
/// Those of [`check_targets`]; an output that is an input, settings that somebody wrote, or two
/// outputs in one file.
pub(crate) fn check_outputs(outputs: &[(&str, &Path)]) -> Result<()> {
    terminal::tell_warnings();
    check_targets(outputs)?;
    let inputs = files_read();
    let mut targets: Vec<(&str, PathBuf)> = Vec::new();
    for (flag, path) in outputs {
        let target = if *path == Path::new(STDOUT) {
            path.to_path_buf()
        } else if path.exists() && !path.is_file() {
            // Any number of results may go to a device.
            continue;
        } else {
            let folder = folder_of(path);
            if folder == Path::new(OUT) {
                std::fs::create_dir_all(folder)
                    .into_diagnostic()
                    .wrap_err("cannot create the folder out")?;
            }
            remove_stale(folder);
            let folder = folder.canonicalize().into_diagnostic()?;
            path.canonicalize().unwrap_or(folder.join(path.file_name().unwrap_or_default()))
        };
        if inputs.contains(&target) {
            return refused(flag, path, "it is an input of this command; expected another file");
        }
        let kept = ["toml", "rs", "h"].iter().any(|kept| target.extension() == Some(kept.as_ref()));
        if kept && !may_be_replaced(&target) {
            let why = "there is a file that trueweld did not write, or that is meant to be filled in; \
                       expected another name, or remove it";
            return refused(flag, path, why);
        }
        if let Some((other, _)) = targets.iter().find(|(_, other)| *other == target) {
            let why = format!("{other} goes there too; expected another file");
            return refused(flag, path, &why);
        }
        targets.push((flag, target));
    }
    Ok(())
}

/// True where no file of settings or source is, or one that a command wrote: its first lines say so. What a
/// person wrote is not written over.
fn may_be_replaced(path: &Path) -> bool {
    match std::fs::read_to_string(path) {
        Ok(text) => {
            text.lines().take(2).any(|line| line.contains("trueweld")) || is_template(&text)
        }
        Err(_) => !path.exists(),
    }
}
