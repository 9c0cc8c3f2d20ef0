//! What an FMU is of: files and options of a cell, as they lie in its folder `resources`.
//!
//! The folder holds every file that the cell was read from, and `fmu.toml` with the options. An
//! instance reads them as the program does. A digest over all of them and the sources of the
//! program is the instantiation token: a file that was changed, or a library of another version, is
//! refused.

use crate::instance::Instance;
use crate::law::LawModel;
use crate::model::Model;
use crate::plant::{CellInput, CellModel};
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use trueweld::laws::{Entry, Law, Visitor, for_each};
use trueweld::{CellFiles, WeldingCell};
use trueweld_plant::controllers::ControllerKind;
use trueweld_plant::input::{Control, Process, RobotFile, Sensors, Weld, hexadecimal, read_text};
use trueweld_plant::provenance::FileDigest;

/// What an FMU runs.
#[derive(Debug, Clone)]
pub enum FmuModel {
    /// A controller with a compensation law.
    Law(Entry),
    /// The cell itself.
    Plant(CellInput),
}

/// Name of the file with the options.
const OPTIONS_FILE: &str = "fmu.toml";

/// `schema` of that file.
const OPTIONS_SCHEMA: &str = "fmu/1";

/// The options of an FMU, as its file has them.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FmuOptions {
    schema: String,
    /// The law; none of a plant.
    #[serde(skip_serializing_if = "Option::is_none")]
    law: Option<String>,
    /// What drives a plant: `torque` or `correction`.
    #[serde(skip_serializing_if = "Option::is_none")]
    input: Option<String>,
    controller: String,
    informed: bool,
    effects: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stiffness_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    spindle_rpm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    period: Option<f64>,
    /// A text: TOML has no number as large as a seed may be.
    #[serde(skip_serializing_if = "Option::is_none")]
    seed: Option<String>,
}

/// The files of a folder `resources`, by their names.
#[derive(Debug, Clone)]
pub(crate) struct Contents(pub BTreeMap<String, Vec<u8>>);

impl Contents {
    /// Those of a cell that was read from `files`.
    ///
    /// # Errors
    /// A file that was changed or removed since; a law of one's own, which the library does not have.
    pub(crate) fn of(
        files: &CellFiles,
        cell: &WeldingCell,
        controller: ControllerKind,
        model: &FmuModel,
    ) -> Result<Self> {
        let (law, input) = match model {
            FmuModel::Law(law) => (Some(law.name().to_owned()), None),
            FmuModel::Plant(input) => (None, Some(input.name().to_owned())),
        };
        if let Some(own) = law.iter().flat_map(|law| law.split('+')).find(|law| !is_of_table(law)) {
            return Err(miette!(
                "{own} is a law of your own, which the library of an FMU does not hold; expected a law of the library"
            ));
        }
        let options = FmuOptions {
            schema: OPTIONS_SCHEMA.to_owned(),
            law,
            input,
            controller: controller.name().to_owned(),
            informed: files.informed,
            effects: files.effects.clone(),
            stiffness_error: files.stiffness_error,
            spindle_rpm: files.spindle_rpm,
            period: files.period,
            seed: files.seed.map(|seed| seed.to_string()),
        };
        let mut contents = BTreeMap::new();
        let mut add = |name: &str, text: String| {
            contents.insert(name.to_owned(), text.into_bytes());
        };
        add(OPTIONS_FILE, toml::to_string(&options).into_diagnostic()?);
        add("weld.toml", cell.text::<Weld>()?);
        add("robot.toml", cell.text::<RobotFile>()?);
        add("process.toml", cell.text::<Process>()?);
        add("control.toml", cell.text::<Control>()?);
        add("sensors.toml", cell.text::<Sensors>()?);
        if let Some(path) = &files.model {
            add("model.toml", beside_its_files(path, cell)?);
        }
        Ok(Self(contents))
    }

    /// Those that lie in a folder.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let read = |path: &Path| {
            fs::read(path).into_diagnostic().wrap_err_with(|| path.display().to_string())
        };
        let mut contents = BTreeMap::new();
        let entries = fs::read_dir(folder)
            .into_diagnostic()
            .wrap_err_with(|| format!("cannot read the resources {}", folder.display()))?;
        for entry in entries {
            let path = entry.into_diagnostic()?.path();
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
            // Importers may put folders of their own there.
            if let Some(name) = name.filter(|name| name.ends_with(".toml")) {
                contents.insert(name, read(&path)?);
            }
        }
        Ok(Self(contents))
    }

    /// Writes them into a folder.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn write(&self, folder: &Path) -> Result<()> {
        for (name, bytes) in &self.0 {
            fs::write(folder.join(name), bytes).into_diagnostic()?;
        }
        Ok(())
    }

    /// SHA-256 of all of them and of the sources that this program was built from.
    pub(crate) fn token(&self) -> [u8; 32] {
        let mut hash = Sha256::new();
        hash.update(trueweld::SOURCES);
        for (name, bytes) in &self.0 {
            for part in [name.as_bytes(), bytes] {
                hash.update((part.len() as u64).to_le_bytes());
                hash.update(part);
            }
        }
        hash.finalize().into()
    }

    /// The model of the files in a folder, which are these.
    ///
    /// # Errors
    /// Files that are none of an FMU, or hold what cannot be.
    pub(crate) fn model(&self, folder: &Path) -> Result<Box<dyn Model>> {
        let text = self.0.get(OPTIONS_FILE).ok_or_else(|| miette!("there is no {OPTIONS_FILE}"))?;
        let text = std::str::from_utf8(text).into_diagnostic()?;
        let options: FmuOptions = toml::from_str(text).into_diagnostic()?;
        if options.schema != OPTIONS_SCHEMA {
            return Err(miette!("the schema is {}; expected {OPTIONS_SCHEMA}", options.schema));
        }
        let file = |name: &str| Some(folder.join(name));
        let is_model = self.0.contains_key("model.toml");
        let own = |name: &str| if is_model { None } else { file(name) };
        let seed = options.seed.map(|seed| seed.parse()).transpose().into_diagnostic()?;
        let files = CellFiles {
            found: Default::default(),
            law_files: Vec::new(),
            robot: own("robot.toml"),
            process: own("process.toml"),
            model: if is_model { file("model.toml") } else { None },
            informed: options.informed,
            control: file("control.toml"),
            sensors: file("sensors.toml"),
            effects: options.effects,
            stiffness_error: options.stiffness_error,
            spindle_rpm: options.spindle_rpm,
            period: options.period,
            seed,
        };
        let cell = files.weld(folder.join("weld.toml"))?;
        let controller = ControllerKind::find(&options.controller)
            .map_err(|_| miette!("{}: there is no such controller", options.controller))?;
        let input = options.input.as_deref().map(|name| {
            let input = CellInput::ALL.into_iter().find(|input| input.name() == name);
            input.ok_or_else(|| miette!("{name}: a plant has no such input"))
        });
        match (options.law, input.transpose()?) {
            (Some(law), None) => {
                Ok(Box::new(LawModel::new(cell, controller, trueweld::law(&law)?)))
            }
            (None, Some(input)) => {
                let model = CellModel::new(cell, controller, input);
                Ok(Box::new(model.map_err(|error| miette!("{error}"))?))
            }
            _ => Err(miette!("{OPTIONS_FILE} names neither a law nor the input of a plant")),
        }
    }
}

/// An instance of the FMU whose resources lie in a folder.
///
/// # Errors
/// Another token than that of the files and of this library; files that cannot be read.
pub(crate) fn instantiate(folder: &Path, token: &str) -> Result<Instance> {
    let contents = Contents::read(folder)?;
    let own = contents.token();
    if hexadecimal(&own) != token {
        return Err(miette!(
            "the token {token} is not that of the files in {} and of this library: a file was changed, or the library is of \
             another version than modelDescription.xml",
            folder.display()
        ));
    }
    let model = contents.model(folder)?;
    Ok(Instance::new(model, own))
}

/// Whether a law is one of this project.
fn is_of_table(name: &str) -> bool {
    struct Is<'a>(&'a str, bool);
    impl Visitor<f64> for Is<'_> {
        fn visit<L: Law<f64>>(&mut self) {
            self.1 |= L::NAME == self.0;
        }
    }
    let mut is = Is(name, false);
    for_each(&mut is);
    is.1
}

/// A model file's text, with the robot and the process that lie beside it.
fn beside_its_files(path: &Path, cell: &WeldingCell) -> Result<String> {
    const NAMED_FILES: [(&str, &str); 2] = [("robot", "robot.toml"), ("process", "process.toml")];
    let (name, text) = read_text(path)?;
    let digest = FileDigest::new("model", &name, text.as_bytes()).sha256;
    if !cell.files.iter().any(|file| file.role == "model" && file.sha256 == digest) {
        return Err(miette!("{name}: it was changed since it was read"));
    }
    let mut is_head = true;
    let lines = text.lines().map(|line| {
        is_head &= !line.trim_start().starts_with('[');
        let key = line.split('=').next().unwrap_or_default().trim();
        let named = NAMED_FILES.iter().find(|(role, _)| is_head && key == *role);
        named.map_or_else(|| line.to_owned(), |(role, file)| format!("{role} = \"{file}\""))
    });
    Ok(lines.collect::<Vec<_>>().join("\n") + "\n")
}
