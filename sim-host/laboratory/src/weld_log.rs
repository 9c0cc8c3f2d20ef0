//! The log of one weld that was just made, as a campaign folder of its own: what `compare`,
//! `diagnose` and `improve` take.

use crate::instruments::SimulatedLogKind;
use crate::logs::write_weld;
use crate::recipe::Recipe;
use crate::samples::SampleTable;
use std::fmt::Write as _;
use std::fs::create_dir_all;
use std::io;
use std::path::Path;
use trueweld_core::{JointVector, Wrench};
use trueweld_plant::cell::Cell;
use trueweld_plant::input::write_atomically;
use trueweld_plant::simulate::Recording;

/// Folder of the log in its campaign.
const LOG: &str = "weld";

/// The files that a weld is made with, as texts: they are written beside its log, so that the folder
/// stands by itself. The model is the robot and the process as they are believed to be.
#[derive(Debug, Clone, Copy)]
pub struct WeldLog<'a> {
    /// Robot file.
    pub robot: &'a str,
    /// Process file.
    pub process: &'a str,
    /// Weld file.
    pub weld: &'a str,
}

/// What is read off a controller in one period.
#[derive(Debug, Clone, Copy)]
pub struct ReadRow {
    /// Time, s.
    pub time: f64,
    /// Encoder angles, rad.
    pub encoder: JointVector<f64>,
    /// What the environment applies to the tool, in T.
    pub wrench: Wrench<f64>,
}

impl WeldLog<'_> {
    /// Writes a simulated weld as instruments would have recorded it: encoders, force sensor and
    /// tracker, with their usual noise. `cell`: the cell that welded, with its effects; `spindle`: its
    /// speed, rad/s.
    ///
    /// # Errors
    /// The operating system's.
    pub fn write_simulated(
        &self,
        folder: &Path,
        recording: &Recording,
        cell: &Cell,
        spindle: f64,
    ) -> io::Result<()> {
        self.write_campaign(folder)?;
        let recipe = Recipe::plain(recording.seed);
        let table = SampleTable::new(SimulatedLogKind::Weld, &recipe, 1);
        write_weld(table, recording, cell, spindle, (&folder.join(LOG), self.weld))
    }

    /// Writes what was read off a controller, every `period` s, as far as weld logs are compared by it.
    /// It holds nothing of a tracker: that is another instrument's file, which its `log.toml` is to name
    /// before anything can be compared.
    ///
    /// # Errors
    /// The operating system's.
    pub fn write_read(
        &self,
        folder: &Path,
        period: f64,
        spindle: f64,
        rows: &[ReadRow],
    ) -> io::Result<()> {
        self.write_campaign(folder)?;
        let log = folder.join(LOG);
        create_dir_all(&log)?;
        let text = format!(
            "schema = \"log/1\"\nkind = \"weld\"\nrobot = \"../robot.toml\"\n\
             weld = \"weld.toml\"\nprocess = \"../process.toml\"\nperiod_s = {period:?}\n\n\
             # The tracker's file makes it comparable: put it here and name it, as docs/logs.md says.\n\
             # files = [ {{ path = \"samples.csv\" }}, {{ path = \"tracker.txt\", clock = \"tracker\" }} ]\n"
        );
        write_atomically(log.join("log.toml"), text.as_bytes())?;
        write_atomically(log.join("weld.toml"), self.weld.as_bytes())?;
        write_atomically(log.join("samples.csv"), samples(spindle, rows).as_bytes())
    }

    fn write_campaign(&self, folder: &Path) -> io::Result<()> {
        create_dir_all(folder.join(LOG))?;
        let campaign = format!(
            "# A weld over RSI.\nschema = \"campaign/1\"\nmodel = \"model.toml\"\nlogs = [\"{LOG}\"]\n"
        );
        for (file, text) in [
            ("robot.toml", self.robot),
            ("process.toml", self.process),
            ("model.toml", crate::campaign::MODEL),
            ("campaign.toml", &campaign),
        ] {
            write_atomically(folder.join(file), text.as_bytes())?;
        }
        Ok(())
    }
}

/// The rows as a `samples.csv`.
fn samples(spindle: f64, rows: &[ReadRow]) -> String {
    let encoders: String = (1..=6).map(|k| format!(",qe{k}_rad")).collect();
    let mut text = format!("t_s{encoders},fx_n,fy_n,fz_n,mx_nm,my_nm,mz_nm,spindle_rad_s\n");
    for row in rows {
        let angles = row.encoder.iter().map(|v| format!(",{v:.8}"));
        let Wrench { force, moment } = &row.wrench;
        let loads = force.iter().chain(moment).map(|v| format!(",{v:.2}"));
        let numbers: String = angles.chain(loads).collect();
        let _ = writeln!(text, "{:.3}{numbers},{spindle:.5}", row.time);
    }
    text
}
