//! `trueweld import-log`: a `log.toml` for files as instruments wrote them.

use crate::init::is_template;
use crate::results::{FormFiles, Results, check_new_folder, check_outputs, check_targets};
use clap::Args;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::fs;
use std::path::{Component, Path, PathBuf};
use trueweld::{is_same_file, of_program};
use trueweld_logs::log::import::{Stated, propose};
use trueweld_logs::log::{LOG_FILE, LogKind};
use trueweld_output::{ImportReport, log_toml, write_file};
use trueweld_plant::input::{FILL_IN, InputFile, RobotFile, read_text};
use trueweld_plant::provenance::{FileDigest, Provenance};

/// Arguments of `import-log`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Files of one recording: text, Parquet, NumPy (.npz, .npy), MATLAB (.mat), KUKA traces (.dat), ROS 2
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Robot file, or what import-urdf wrote: signs are told by its limits, its motion and its torques
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// What was done: static-load, ring-down, free-motion or weld (default: by the channels)
    #[arg(long, value_name = "KIND", value_parser = kind)]
    kind: Option<LogKind>,
    /// Time from row to row of the encoders' file, s, where it has none
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    period: Option<f64>,
    /// Write guesses as if they were known, for programs that check them themselves
    #[arg(long)]
    yes: bool,
    /// Folder of the log, which is made where it is not there
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Write the proposal as JSON; `-` writes it to standard output, and the text to standard error
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    forms: FormFiles,
}

impl Arguments {
    /// Where the proposal goes beside the folder.
    fn results(&self) -> Results {
        let (json, forms) = (self.json.clone(), self.forms.clone());
        Results { json, forms, ..Results::default() }
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse::<f64>().ok().filter(|s| s.is_finite() && *s > 0.0);
    seconds.ok_or_else(|| "expected a time in s, above 0".to_owned())
}

fn kind(text: &str) -> Result<LogKind, String> {
    LogKind::ALL
        .into_iter()
        .find(|kind| kind.name() == text)
        .ok_or_else(|| format!("expected one of {}", LogKind::ALL.map(LogKind::name).join(", ")))
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let results = arguments.results();
    check_targets(&results.outputs())?;
    check_new_folder("--out", &arguments.out)?;
    for (k, file) in arguments.files.iter().enumerate() {
        if arguments.files[..k].iter().any(|other| is_same_file(other, file)) {
            return Err(miette!(
                help = "Name each file of the recording once.",
                "{}: this file is given twice; expected each once",
                file.display()
            ));
        }
    }
    let robot = arguments.robot.as_ref().map(|path| read_robot(path)).transpose()?;
    let out = arguments.out.join(LOG_FILE);
    if out.exists() && !fs::read_to_string(&out).is_ok_and(|text| is_template(&text)) {
        return Err(miette!(
            help =
                "Remove it, or give another folder: a log that was filled in is not written over.",
            "--out {}: there is a {LOG_FILE} already; expected a folder without one, or the template that `init` wrote",
            arguments.out.display()
        ));
    }
    let proposal = propose(
        &arguments.files,
        robot.as_ref(),
        Stated { kind: arguments.kind, period: arguments.period },
    )?;
    fs::create_dir_all(&arguments.out)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot make the folder {}", arguments.out.display()))?;
    let mut outputs = vec![("--out", out.as_path())];
    outputs.extend(results.outputs());
    check_outputs(&outputs)?;
    let paths: Vec<String> = proposal
        .files
        .iter()
        .map(|file| from_folder(&arguments.out, &file.path))
        .collect::<Result<_>>()?;
    let robot_path =
        arguments.robot.as_ref().map(|path| from_folder(&arguments.out, path)).transpose()?;
    let text = log_toml(&proposal, &paths, robot_path.as_deref(), arguments.yes);
    let mut files = Vec::new();
    for path in arguments.files.iter().chain(&arguments.robot) {
        files.push(FileDigest::of_file("file", path)?);
    }
    let provenance = Provenance {
        robot: robot.map_or(String::new(), |robot| robot.name),
        files,
        ..of_program("import-log")
    };
    let report = ImportReport { proposal: &proposal, out: &out, provenance: &provenance };
    results.write(&report)?;
    write_file(&out, text)?;
    say!("wrote {}\n", out.display());
    say!(
        "Look it over, fill in what is marked, then: trueweld check {}\n",
        arguments.out.display()
    );
    Ok(())
}

/// What stands in for values that a URDF does not hold: an import needs of them where down is alone.
const STAND_INS: [(&str, &str); 8] = [
    ("gravity_m_s2", "[0.0, 0.0, -9.80665]"),
    ("stiffness_nm_rad", "1e6"),
    ("damping_nms_rad", "1e3"),
    ("rotor_inertia_kg_m2", "1.0"),
    ("viscous_nms_rad", "[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]"),
    ("coulomb_nm", "[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]"),
    ("smoothing_rad_s", "0.001"),
    ("cos_nm", "[]"),
];

/// Reads a robot file, or one of `import-urdf` in which such values are still to be filled in.
fn read_robot(path: &Path) -> Result<RobotFile> {
    let (name, text) = read_text(path)?;
    let filled = |line: &str| {
        let open =
            line.split_once(" = ").filter(|(_, value)| value.starts_with(&format!("\"{FILL_IN}")));
        let stand_in = open.and_then(|(key, _)| STAND_INS.iter().find(|(known, _)| *known == key));
        stand_in.map_or(line.to_owned(), |(key, value)| format!("{key} = {value}"))
    };
    let lines: Vec<String> = text.lines().map(filled).collect();
    Ok(RobotFile::parse(&lines.join("\n"), &name)?)
}

/// The path of a file as a file in a folder writes it.
fn from_folder(folder: &Path, file: &Path) -> Result<String> {
    let canonical = |path: &Path| {
        path.canonicalize().into_diagnostic().wrap_err_with(|| format!("{}", path.display()))
    };
    let (folder, file) = (canonical(folder)?, canonical(file)?);
    let a: Vec<Component<'_>> = folder.components().collect();
    let b: Vec<Component<'_>> = file.components().collect();
    let shared = a.iter().zip(&b).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n("..", a.len() - shared).map(PathBuf::from);
    let path: PathBuf =
        up.chain(b[shared..].iter().map(|part| PathBuf::from(part.as_os_str()))).collect();
    Ok(path.display().to_string())
}
