//! Campaign folders: the model, the logs, the logs held out, and the truth.

use crate::error::CampaignError;
use crate::laboratory::Laboratory;
use crate::logs::{LogWriter, Recorder};
use crate::protocol_file::ProtocolFile;
use crate::recipe::Recipe;
use crate::truth::Truth;
use std::fmt::{self, Write as _};
use std::fs;
use std::path::{Path, PathBuf};
use trueweld_plant::effects::Location;
use trueweld_plant::input::{Comments, Control, ModelFile, Sensors, write_atomically};

pub(crate) const MODEL: &str =
    "schema = \"model/1\"\nrobot = \"robot.toml\"\nprocess = \"process.toml\"\n";

impl ProtocolFile {
    /// Records the logs of the protocol into a new campaign folder: robot, process, model, logs, and
    /// their list. The same protocol and seed give the same bytes. `control` and `sensors`: of the
    /// cell that welds; `done` is called with the number of logs recorded so far. What was built in is
    /// returned as the text of a `truth.toml`.
    ///
    /// # Errors
    /// [`CampaignError`].
    pub fn record(
        &self,
        control: &Control,
        sensors: &Sensors,
        folder: &Path,
        done: &dyn Fn(usize),
    ) -> Result<String, CampaignError> {
        let laboratory = self.laboratory(control.clone(), sensors.clone());
        let recipe = self.recipe();
        fs::create_dir_all(folder)?;
        let copied = |name: &str, from: &Path| -> Result<PathBuf, CampaignError> {
            let to = folder.join(name);
            write_atomically(&to, &fs::read(from)?)?;
            Ok(to)
        };
        let model = ModelFile {
            path: folder.join("model.toml"),
            robot_path: copied("robot.toml", &self.model.robot_path)?,
            process_path: match &self.model.process_path {
                Some(path) => Some(copied("process.toml", path)?),
                None => None,
            },
            ..self.model.clone()
        };
        let said = "The model that the logs are compared with.";
        let comments = Comments { file: said.to_owned(), ..Comments::default() };
        model.write(&model.path, &comments)?;
        let truth = Truth { laboratory: &laboratory, recipe: &recipe };
        let recorder = Recorder { truth: &truth };
        for (number, log) in self.logs.iter().enumerate() {
            recorder.record(number as u64 + 1, log, &folder.join(&log.name))?;
            done(number + 1);
        }
        let names: Vec<String> = self.logs.iter().map(|log| format!("{:?}", log.name)).collect();
        let text = format!(
            "# Recorded of a simulated cell, seed {}.\nschema = \"campaign/1\"\n\
             model = \"model.toml\"\nlogs = [{}]\n",
            self.seed,
            names.join(", ")
        );
        write_atomically(folder.join("campaign.toml"), text.as_bytes())?;
        Ok(laboratory.truth_file(&recipe).expect("a string takes all"))
    }
}

impl Laboratory {
    /// Simulates a campaign and writes it into a folder, with the campaign held out in `holdout/`
    /// and the truth in `truth.toml`. The same recipe gives the same bytes.
    ///
    /// # Errors
    /// [`CampaignError`].
    pub fn write(&self, recipe: &Recipe, folder: &Path) -> Result<(), CampaignError> {
        let truth = Truth { laboratory: self, recipe };
        for held_out in [false, true] {
            let (folder, protocol) = if held_out {
                (folder.join("holdout"), recipe.protocol.held_out())
            } else {
                (folder.to_owned(), recipe.protocol.clone())
            };
            fs::create_dir_all(&folder)?;
            write_atomically(folder.join("robot.toml"), &fs::read(&self.robot_path)?)?;
            if let Some(process) = &self.process_path {
                write_atomically(folder.join("process.toml"), &fs::read(process)?)?;
            }
            write_atomically(folder.join("model.toml"), MODEL.as_bytes())?;
            let names =
                LogWriter { truth: &truth, protocol: &protocol, held_out }.write(&folder)?;
            let list = names.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
            let what = if held_out { ", held out" } else { "" };
            let text = format!(
                "# Simulated measurements{what}, seed {}.\nschema = \"campaign/1\"\n\
                 model = \"model.toml\"\nlogs = [{list}]\n",
                recipe.seed
            );
            write_atomically(folder.join("campaign.toml"), text.as_bytes())?;
        }
        let text = self.truth_file(recipe).expect("a string takes all");
        Ok(write_atomically(folder.join("truth.toml"), text.as_bytes())?)
    }

    fn truth_file(&self, recipe: &Recipe) -> Result<String, fmt::Error> {
        let verdict = match (&recipe.out_of_library, recipe.effects.is_empty()) {
            (Some(_), _) => "unknown-effect",
            (None, false) => "effect-found",
            (None, true) => "adequate",
        };
        let mut text = format!(
            "# What was built into this campaign.\nschema = \"truth/1\"\nverdict = \"{verdict}\"\n\
             seed = {}\nnoise = {:?}\nnoise_stated = {}\n\n[nuisance]\n\
             stiffness_relative = {:?}\nencoder_offset_rad = {:?}\nregistration_per_log_m = {:?}\n\
             geometry_m_rad = {:?}\n",
            recipe.seed,
            recipe.noise,
            recipe.noise_stated,
            recipe.stiffness_error,
            recipe.encoder_offset,
            recipe.registration_per_log,
            recipe.geometry_error
        );
        for effect in &recipe.effects {
            writeln!(text, "\n[[effect]]\nid = \"{}\"", effect.kind.id)?;
            if effect.at != Location::Cell {
                writeln!(text, "at = \"{}\"", effect.at.name(&self.robot))?;
            }
            for (parameter, value) in effect.kind.parameters.iter().zip(&effect.values) {
                writeln!(text, "{} = {value:?}", parameter.name)?;
            }
        }
        if let Some(foreign) = &recipe.out_of_library {
            writeln!(
                text,
                "\n[stranger]\nname = \"{}\"\nequation = \"{}\"\nat = \"{}\"\nsize = {:?}",
                foreign.kind.name(),
                foreign.kind.equation(),
                self.robot.joint_names[foreign.joint],
                foreign.size
            )?;
        }
        Ok(text)
    }
}
