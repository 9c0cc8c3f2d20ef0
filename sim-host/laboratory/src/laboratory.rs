//! The cell of a laboratory as its input files describe it.

use std::path::{Path, PathBuf};
use trueweld_plant::input::{Control, InputError, InputFile, Process, RobotFile, Sensors};

/// A cell as its input files describe it: what the model in a campaign states.
#[derive(Debug)]
pub struct Laboratory {
    /// The robot.
    pub robot: RobotFile,
    /// What welds are planned with; `None` where nothing is welded.
    pub(crate) process: Option<Process>,
    pub(crate) control: Control,
    pub(crate) sensors: Sensors,
    /// Paths of the robot and the process, which a campaign gets copies of.
    pub(crate) robot_path: PathBuf,
    pub(crate) process_path: Option<PathBuf>,
}

impl Laboratory {
    /// Reads the cell's files: robot, process, gains of the controllers, and sensors.
    ///
    /// # Errors
    /// The first thing in a file that does not fit.
    pub fn read(
        robot: impl AsRef<Path>,
        process: impl AsRef<Path>,
        control: impl AsRef<Path>,
        sensors: impl AsRef<Path>,
    ) -> Result<Self, InputError> {
        let (robot_path, process_path) = (robot.as_ref().into(), process.as_ref());
        Ok(Self {
            robot: RobotFile::read(&robot_path)?,
            process: Some(Process::read(process_path)?),
            control: Control::read(control)?,
            sensors: Sensors::read(sensors)?,
            robot_path,
            process_path: Some(process_path.into()),
        })
    }
}
