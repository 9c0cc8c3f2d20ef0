//! The file: an archive of model description, resources and shared libraries.

use crate::contents::{Contents, FmuModel};
use crate::description::{FmiVersion, Heading, describe};
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::borrow::Cow;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::{env, fs};
use trueweld::{CellFiles, WeldingCell};
use trueweld_plant::controllers::ControllerKind;
use trueweld_plant::input::hexadecimal;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// A cell, or a law for it, to be exported.
#[derive(Debug, Clone)]
pub struct FmuExport<'a> {
    /// Files and options that the cell was read from.
    pub files: &'a CellFiles,
    /// Its hybrid controller.
    pub controller: ControllerKind,
    /// What is exported of it.
    pub model: FmuModel,
    /// Version of FMI.
    pub version: FmiVersion,
}

/// What an FMU is, to be said to a user.
#[derive(Debug, Clone, PartialEq)]
pub struct FmuSummary {
    /// Digest of files, options and program: the GUID or instantiation token.
    pub token: String,
    /// Step, s.
    pub step: f64,
    /// Platforms that it has a library for.
    pub platforms: Vec<&'static str>,
}

/// Processor and system of a shared library, as both versions of FMI call them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Platform {
    fmi2: &'static str,
    fmi3: &'static str,
    ending: &'static str,
}

impl Platform {
    /// Of a shared library, by its first bytes.
    fn of(library: &[u8]) -> Option<Self> {
        let of = |fmi2, fmi3, ending| Some(Self { fmi2, fmi3, ending });
        match library {
            // Class and machine of an ELF header.
            [0x7f, b'E', b'L', b'F', 2, ..] => match library.get(18..20)? {
                [0x3e, 0] => of("linux64", "x86_64-linux", "so"),
                [0xb7, 0] => of("aarch64-linux", "aarch64-linux", "so"),
                _ => None,
            },
            // Machine of a PE header, whose place the DOS header states.
            [b'M', b'Z', ..] => {
                let place = u32::from_le_bytes(library.get(0x3c..0x40)?.try_into().ok()?) as usize;
                match library.get(place..place.checked_add(6)?)? {
                    [b'P', b'E', 0, 0, 0x64, 0x86] => of("win64", "x86_64-windows", "dll"),
                    [b'P', b'E', 0, 0, 0x64, 0xaa] => {
                        of("aarch64-windows", "aarch64-windows", "dll")
                    }
                    _ => None,
                }
            }
            // Type of processor in a Mach-O header.
            [0xcf, 0xfa, 0xed, 0xfe, rest @ ..] => match rest.get(..4)? {
                [7, 0, 0, 1] => of("darwin64", "x86_64-darwin", "dylib"),
                [12, 0, 0, 1] => of("aarch64-darwin", "aarch64-darwin", "dylib"),
                _ => None,
            },
            _ => None,
        }
    }
}

/// A shared library of this version, of any platform.
#[derive(Debug, Clone)]
pub struct FmuLibrary {
    /// Where it was found.
    name: String,
    bytes: Cow<'static, [u8]>,
}

/// The library that this program has inside.
static CARRIED: OnceLock<&'static [u8]> = OnceLock::new();

/// Says that this program has the library of its platform inside: FMUs are made with it.
pub fn carry_library(bytes: &'static [u8]) {
    // Whoever carries one has no other.
    CARRIED.get_or_init(|| bytes);
}

impl FmuLibrary {
    /// That of a file.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn read(path: &Path) -> Result<Self> {
        let name = path.display().to_string();
        let bytes = fs::read(path)
            .into_diagnostic()
            .wrap_err_with(|| format!("cannot read the library {name}"))?;
        Ok(Self { name, bytes: bytes.into() })
    }

    /// That which was built with this program: inside it, beside it, or where Cargo puts it.
    ///
    /// # Errors
    /// None is there.
    pub fn of_program() -> Result<Self> {
        match CARRIED.get() {
            Some(bytes) => {
                Ok(Self { name: "the program's own library".to_owned(), bytes: (*bytes).into() })
            }
            None => Self::read(&beside_program()?),
        }
    }
}

fn beside_program() -> Result<PathBuf> {
    let name = format!("{}trueweld_fmu{}", env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
    let program = env::current_exe().into_diagnostic()?;
    let folder = program.parent().unwrap_or(Path::new("."));
    let places = [folder.to_owned(), folder.join("deps"), folder.join("../lib")];
    let found = places.iter().map(|place| place.join(&name)).find(|path| path.is_file());
    found.ok_or_else(|| {
        miette!(
            help = format!(
                "Build it in the sources of this program with `cargo build --release -p trueweld-fmu`, and name it by --library \
                 target/release/{name}, or put it beside the program."
            ),
            "there is no {name} beside {}, which an FMU is made with",
            program.display()
        )
    })
}

impl FmuExport<'_> {
    /// The bytes of the FMU. `libraries`: shared libraries of this version, one a platform.
    ///
    /// # Errors
    /// A cell that cannot be run; a library that is none, or two of one platform.
    pub fn package(
        &self,
        cell: &WeldingCell,
        libraries: &[FmuLibrary],
    ) -> Result<(Vec<u8>, FmuSummary)> {
        let contents = Contents::of(self.files, cell, self.controller, &self.model)?;
        // From the files as they will lie in the FMU.
        let folder = tempfile::tempdir().into_diagnostic()?;
        contents.write(folder.path())?;
        let mut model = contents.model(folder.path())?;
        let start = &mut model.table().start.clone();
        model.initialise(start).map_err(|error| miette!("{error}"))?;
        let token = hexadecimal(&contents.token());
        let (identifier, name, text) = self.names(cell);
        let heading = Heading {
            version: self.version,
            identifier,
            name: &name,
            text: &text,
            token: &token,
            tool: concat!("trueweld ", env!("CARGO_PKG_VERSION")),
        };
        let description = describe(model.as_ref(), &heading).into_diagnostic()?;
        let mut files = vec![("modelDescription.xml".to_owned(), description.into())];
        let mut platforms = Vec::new();
        for FmuLibrary { name, bytes } in libraries {
            let platform = Platform::of(bytes).ok_or_else(|| {
                miette!("{name}: it is no shared library of a platform that FMI has")
            })?;
            let folder = match self.version {
                FmiVersion::Fmi2 => platform.fmi2,
                FmiVersion::Fmi3 => platform.fmi3,
            };
            if platforms.contains(&folder) {
                return Err(miette!("two libraries are of {folder}; expected one a platform"));
            }
            platforms.push(folder);
            let file = format!("binaries/{folder}/{identifier}.{}", platform.ending);
            files.push((file, bytes.clone()));
        }
        for (name, bytes) in contents.0 {
            files.push((format!("resources/{name}"), bytes.into()));
        }
        files.extend(SOURCE_FILES.map(|(name, bytes)| (name.to_owned(), bytes.into())));
        let summary = FmuSummary { token, step: model.period(), platforms };
        Ok((archive(&files)?, summary))
    }

    /// Name of the library in the FMU, name of the model, and what it is.
    fn names(&self, cell: &WeldingCell) -> (&'static str, String, String) {
        let robot = &cell.robot.name;
        match &self.model {
            FmuModel::Law(law) => (
                "trueweld_law",
                format!("trueweld law {}", law.name()),
                format!("{} for {robot}, on {} control", law.summary(), self.controller.name()),
            ),
            FmuModel::Plant(input) => (
                "trueweld_plant",
                format!("trueweld plant {robot}"),
                format!("{robot} in its welding cell, driven by {}", input.name()),
            ),
        }
    }
}

/// The sources of this library, and how another one is built of them.
const SOURCE_FILES: [(&str, &[u8]); 2] = [
    ("extra/trueweld/README.txt", include_bytes!("sources.txt")),
    ("extra/trueweld/sources.zip", include_bytes!(concat!(env!("OUT_DIR"), "/sources.zip"))),
];

/// The same files give the same bytes.
fn archive(files: &[(String, Cow<'static, [u8]>)]) -> Result<Vec<u8>> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(name.as_str(), options).into_diagnostic()?;
        zip.write_all(bytes).into_diagnostic()?;
    }
    Ok(zip.finish().into_diagnostic()?.into_inner())
}
