//! What a result is of: everything that it depends on. Results of a sweep are told apart by it, and
//! every file is checked with `sha256sum`.

use crate::effects::Effect;
use crate::input::{InputError, ModelFile, RobotFile, hash_of_file, hexadecimal};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::Path;

/// Everything that a result depends on.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Version of the program.
    pub version: String,
    /// SHA-256 of the sources that the program was built from.
    pub sources: String,
    /// The command, as it is written on the command line.
    pub command: String,
    /// Name of the robot.
    pub robot: String,
    /// Effects of the real cell that the controller does not know, or of the model that measurements
    /// are compared with.
    pub effects: Vec<EffectRecord>,
    /// How the cell was simulated; `None` where measurements were looked at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulation: Option<SimulationRecord>,
    /// Every file that was read.
    pub files: Vec<FileDigest>,
    /// Values of the files that are possible but not plausible.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// An effect and its values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EffectRecord {
    /// Identifier of its kind.
    pub id: String,
    /// What it is attached to, as files write it; empty for the whole cell.
    pub at: String,
    /// Values by their names, SI units.
    pub values: BTreeMap<String, f64>,
}

/// The options of a simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimulationRecord {
    /// Names of the welds.
    pub welds: Vec<String>,
    /// Names of the hybrid controllers.
    pub controllers: Vec<String>,
    /// Names of the compensation laws.
    pub laws: Vec<String>,
    /// Relative error of the joint stiffness that the controller believes in; where a sweep varies
    /// it, the error of the other sweeps.
    pub stiffness_error: f64,
    /// True where the controller knows the effects of the model file.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub informed: bool,
    /// Speed of the spindle, positive about the tool's z axis, rad/s.
    pub spindle_rad_s: f64,
    /// Control period, s.
    pub control_period_s: f64,
    /// Longest step of the plant, s.
    pub plant_step_s: f64,
    /// Welds of one seam, the law kept; the last one counts.
    pub passes: usize,
    /// Seed of the sensors' noise in the nominal cell.
    pub noise_seed: u64,
    /// Seed of the drawn cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub draws_seed: Option<u64>,
    /// Height of a step of the force set-point, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_step_n: Option<f64>,
    /// What the cores on a controller are built from, one a weld, where that is certified.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cores: Vec<CoreRecord>,
}

/// The constants from which a controller's core is built for a weld.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoreRecord {
    /// Name of the weld.
    pub weld: String,
    /// Name of the compensation law.
    pub law: String,
    /// SHA-256 of the constants, as `export-core` prints it and the running core tells it.
    pub sha256: String,
}

/// A file and the digest of its bytes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileDigest {
    /// What it was read as.
    pub role: String,
    /// Its path as given, or its name where it is embedded in the program.
    pub file: String,
    /// SHA-256 of its bytes, as `sha256sum` prints it.
    pub sha256: String,
}

impl Provenance {
    /// Adds what another result of the same command is of besides: its welds and files.
    pub fn join(&mut self, other: &Self) {
        if let (Some(all), Some(more)) = (&mut self.simulation, &other.simulation) {
            all.welds.extend_from_slice(&more.welds);
            all.cores.extend_from_slice(&more.cores);
        }
        let new = other.files.iter().filter(|file| !self.files.contains(file));
        self.files.extend(new.cloned().collect::<Vec<_>>());
    }
}

impl FileDigest {
    /// Of bytes that were read.
    pub fn new(role: &str, file: &str, bytes: &[u8]) -> Self {
        Self { role: role.to_owned(), file: file.to_owned(), sha256: sha256(bytes) }
    }

    /// Of a file, as it was read: a change since then is not in it.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn of_file(role: &str, path: &Path) -> Result<Self, InputError> {
        let sha256 = hexadecimal(&hash_of_file(path)?);
        Ok(Self { role: role.to_owned(), file: path.display().to_string(), sha256 })
    }

    /// Of a model file and of the files that it names.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn of_model(model: &ModelFile) -> Result<Vec<Self>, InputError> {
        let mut files =
            vec![Self::of_file("model", &model.path)?, Self::of_file("robot", &model.robot_path)?];
        if let Some(process) = &model.process_path {
            files.push(Self::of_file("process", process)?);
        }
        Ok(files)
    }
}

impl EffectRecord {
    /// Of an effect of a robot.
    pub fn new(effect: &Effect, robot: &RobotFile) -> Self {
        let names = effect.kind.parameters.iter().map(|p| p.name.to_owned());
        Self {
            id: effect.kind.id.to_owned(),
            at: effect.at.name(robot).to_owned(),
            values: names.zip(effect.values.iter().copied()).collect(),
        }
    }
}

/// SHA-256 of bytes, hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_digest_is_what_sha256sum_prints() {
        // FIPS 180-2, appendix B.1.
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("abc.toml");
        std::fs::write(&path, "abc").unwrap();
        assert_eq!(FileDigest::of_file("weld", &path).unwrap().sha256, expected);
        assert_eq!(FileDigest::new("weld", "abc.toml", b"abc").sha256, expected);
        // What was read, and not what stands there since.
        std::fs::write(&path, "abcd").unwrap();
        assert_eq!(FileDigest::of_file("weld", &path).unwrap().sha256, expected);
        assert_eq!(crate::input::read_text(&path).unwrap().1, "abcd");
        assert_eq!(FileDigest::of_file("weld", &path).unwrap().sha256, sha256(b"abcd"));
    }
}
