//! `trueweld init`: the folder of a campaign, with what is to be filled in.

use crate::folder::make_folder;
use clap::Args;
use miette::{IntoDiagnostic, Result};
use std::fmt::Write as _;
use std::path::PathBuf;
use trueweld_logs::log::{LOG_FILE, LogKind, SAMPLES_FILE};
use trueweld_plant::input::FILL_IN;

/// Arguments of `init`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Folder to write, which must not be there yet
    folder: PathBuf,
}

/// Fixtures whose values become examples of what to fill in: file, path, what is said above it.
const EXAMPLES: [(&str, &str, &str); 3] = [
    (
        "robot.toml",
        include_str!("../../../fixtures/robots/kr500-mt.toml"),
        "The robot and its tool. Values behind \"FILL IN\" are those of a KR 500 MT; `trueweld import-urdf` fills in many.",
    ),
    (
        "process.toml",
        include_str!("../../../fixtures/processes/lap-weld-2024-t3.toml"),
        "The welding process. Values behind \"FILL IN\" are those of a lap weld in 2024-T3. Without welds it is not needed.",
    ),
    (
        "weld/weld.toml",
        include_str!("../../../fixtures/welds/vertical.toml"),
        "The weld that was recorded in this folder. Values behind \"FILL IN\" are an example's.",
    ),
];

/// A log of every kind: folder, kind, what is recorded, columns of its samples, its further entries.
const LOGS: [(&str, LogKind, &str, &str, &str); 4] = [
    (
        "static",
        LogKind::StaticLoad,
        "The robot at rest, a row a load, in the order in which loads went up and down.",
        "fx_n,fy_n,fz_n,mx_nm,my_nm,mz_nm,px_m,py_m,pz_m,rx_rad,ry_rad,rz_rad,payload_kg,cx_m,cy_m,cz_m",
        "",
    ),
    (
        "ring",
        LogKind::RingDown,
        "A joint stopped abruptly by its brake; 1 kHz.",
        "px_m,py_m,pz_m",
        "period_s = \"FILL IN: 0.001\"        # leave it out where sampling is uneven\n",
    ),
    (
        "free",
        LogKind::FreeMotion,
        "Motion without contact, some minutes, all axes, both directions, slow and fast.",
        "tm1_nm,tm2_nm,tm3_nm,tm4_nm,tm5_nm,tm6_nm,px_m,py_m,pz_m,rx_rad,ry_rad,rz_rad",
        "period_s = \"FILL IN: 0.004\"        # leave it out where sampling is uneven\n",
    ),
    (
        "weld",
        LogKind::Weld,
        "A weld.",
        "fx_n,fy_n,fz_n,mx_nm,my_nm,mz_nm,px_m,py_m,pz_m,rx_rad,ry_rad,rz_rad,spindle_rad_s",
        "weld = \"weld.toml\"\nprocess = \"../process.toml\"\nperiod_s = \"FILL IN: 0.012\"        # leave it out where \
         sampling is uneven\n",
    ),
];

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let folder = &arguments.folder;
    make_folder(folder)?;
    for (name, ..) in LOGS {
        make_folder(&folder.join(name))?;
    }
    let write = |file: &str, text: String| {
        trueweld_output::write_file(&folder.join(file), text).into_diagnostic()
    };
    for (file, text, about) in EXAMPLES {
        write(file, format!("# {about}\n{}", to_fill_in(text)))?;
    }
    write(
        "model.toml",
        "# What the logs are compared with: the robot and the process as the files state them. [[effect]] tables add more.\n\
         schema = \"model/1\"\nrobot = \"robot.toml\"\nprocess = \"process.toml\"        # only where you weld\n"
            .to_owned(),
    )?;
    let names: Vec<String> = LOGS.iter().map(|(name, ..)| format!("\"{name}\"")).collect();
    write(
        "campaign.toml",
        format!(
            "# Logs of one cell, and the model to compare them with. Remove the logs that you do not have.\n\
             schema = \"campaign/1\"\nmodel = \"model.toml\"\nlogs = [{}]\n",
            names.join(", ")
        ),
    )?;
    for (name, kind, about, columns, more) in LOGS {
        write(&format!("{name}/{LOG_FILE}"), log(kind, about, more))?;
        let encoders = "t_s,qe1_rad,qe2_rad,qe3_rad,qe4_rad,qe5_rad,qe6_rad";
        write(&format!("{name}/{SAMPLES_FILE}"), format!("{encoders},{columns}\n"))?;
    }
    say!(
        "wrote {0}: a campaign with a log of each kind\n\
         Put your recordings in place of its samples.csv files (`trueweld import-log` writes the log.toml for files as they \
         are), fill in what is marked, then: trueweld check {0}\n",
        folder.display()
    );
    Ok(())
}

/// True for the `log.toml` of a log that nobody has filled in.
pub(crate) fn is_template(text: &str) -> bool {
    LOGS.iter().any(|(_, kind, about, _, more)| log(*kind, about, more) == text)
}

/// The `log.toml` of a kind of log.
fn log(kind: LogKind, about: &str, more: &str) -> String {
    format!(
        "# {about}\n\
         # What you did not measure you leave out: the column, and its line under [noise].\n\
         schema = \"log/1\"\nkind = \"{kind}\"\nrobot = \"../robot.toml\"\n{more}\n\
         # Files as your instruments write them, instead of samples.csv:\n\
         # files = [ {{ path = \"krc.csv\", delimiter = \";\", decimal = \",\" }}, {{ path = \"tracker.txt\", clock = \"tracker\" }} ]\n\
         # [columns]\n\
         # \"AXIS_1\" = {{ channel = \"qe1\", unit = \"deg\" }}\n\n\
         [noise]                           # one standard deviation, as the maker states it; what is not known is left out\n\
         encoder_rad = \"{FILL_IN}: 2e-6\"\n\
         tcp_position_m = \"{FILL_IN}: 3e-5\"\n"
    )
}

/// A file with its values as examples of what is to be filled in.
fn to_fill_in(text: &str) -> String {
    let mut out = String::new();
    // What is said of the example's origin is not true of what takes its place.
    let body = text.lines().skip_while(|line| line.starts_with('#'));
    for line in body {
        let value = line.split_once(" = ").filter(|(key, _)| !key.trim_start().starts_with('#'));
        let filled = value.and_then(|(key, rest)| {
            let (value, remark) = match rest.split_once('#') {
                Some((value, remark)) => (value.trim(), format!("    # {}", remark.trim())),
                None => (rest.trim(), String::new()),
            };
            let number = value.starts_with(|c: char| c.is_ascii_digit() || "-[{".contains(c));
            number.then(|| format!("{key} = \"{FILL_IN}: {value}\"{remark}"))
        });
        // Text into a string of our own cannot fail.
        let _ = writeln!(out, "{}", filled.as_deref().unwrap_or(line));
    }
    out
}
