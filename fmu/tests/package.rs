//! FMUs as files, and what is taken out of one.

use std::fs;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use trueweld::CellFiles;
use trueweld_fmu::{CellInput, FmiVersion, FmuExport, FmuLibrary, FmuModel};
use trueweld_plant::controllers::ControllerKind;

/// First bytes of a shared library for 64-bit Linux.
fn elf(machine: u8) -> Vec<u8> {
    let mut header = vec![0x7f, b'E', b'L', b'F', 2, 1, 1, 0];
    header.resize(18, 0);
    header.extend([machine, 0]);
    header
}

/// An FMU without its archive: what an importer hands to its library.
pub(crate) struct Unpacked {
    folder: TempDir,
    pub token: String,
    pub description: String,
}

impl Unpacked {
    /// The folder `resources`, as a path.
    pub(crate) fn resources(&self) -> PathBuf {
        self.folder.path().join("resources")
    }
}

/// The FMU of a model, unpacked.
pub(crate) fn unpacked(files: &CellFiles, weld: Option<&Path>, export: &FmuExport<'_>) -> Unpacked {
    let cell = files.read_weld(weld).expect("a cell");
    let (bytes, summary) = export.package(&cell, &[]).expect("an FMU");
    let folder = TempDir::new().expect("a folder");
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).expect("an archive");
    archive.extract(folder.path()).expect("room for it");
    let description = folder.path().join("modelDescription.xml");
    let description = fs::read_to_string(description).expect("a description");
    Unpacked { folder, token: summary.token, description }
}

/// What is exported of the embedded cell.
pub(crate) fn export(files: &CellFiles, model: FmuModel, version: FmiVersion) -> FmuExport<'_> {
    FmuExport { files, controller: ControllerKind::EXTERNAL, model, version }
}

pub(crate) fn law(name: &str) -> FmuModel {
    FmuModel::Law(trueweld::law(name).expect("a law of the library"))
}

#[test]
fn the_same_cell_gives_the_same_bytes_with_a_library_for_each_platform() {
    let files = CellFiles::new();
    let cell = files.read().expect("the embedded cell");
    let folder = TempDir::new().expect("a folder");
    let libraries = [0x3e, 0xb7].map(|machine| {
        let path = folder.path().join(format!("{machine}.so"));
        fs::write(&path, elf(machine)).expect("a file");
        FmuLibrary::read(&path).expect("a library")
    });
    let of = export(&files, FmuModel::Plant(CellInput::Torque), FmiVersion::Fmi3);
    let (bytes, summary) = of.package(&cell, &libraries).expect("an FMU");
    assert_eq!(summary.platforms, ["x86_64-linux", "aarch64-linux"]);
    assert_eq!(of.package(&cell, &libraries).expect("an FMU").0, bytes);
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).expect("an archive");
    let mut library = Vec::new();
    let name = "binaries/aarch64-linux/trueweld_plant.so";
    archive.by_name(name).expect(name).read_to_end(&mut library).expect("bytes");
    assert_eq!(library, elf(0xb7));

    let twice = [libraries[0].clone(), libraries[0].clone()];
    let error = of.package(&cell, &twice).expect_err("one platform").to_string();
    assert!(error.contains("x86_64-linux"), "{error}");
    let text = folder.path().join("library.so");
    fs::write(&text, "no library").expect("a file");
    let text = FmuLibrary::read(&text).expect("a file");
    let error = of.package(&cell, &[text]).expect_err("a text").to_string();
    assert!(error.contains("library.so"), "{error}");
}

#[test]
fn a_model_file_lies_beside_the_files_that_it_names() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures");
    let folder = TempDir::new().expect("a folder");
    let model = folder.path().join("improved.toml");
    let text = format!(
        "schema = \"model/1\"\nrobot = {:?}\n process={:?} # of the cell\n\n\
         [[effect]]\nid = \"backlash\"\nat = \"A5\"\nhalf_gap_rad = 2e-4\n",
        fixtures.join("robots/kr500-mt.toml"),
        fixtures.join("processes/lap-weld-2024-t3.toml")
    );
    fs::write(&model, text).expect("a file");
    let files = CellFiles::new().model(&model);
    let fmu = unpacked(&files, None, &export(&files, law("none"), FmiVersion::Fmi2));
    let written = fs::read_to_string(fmu.resources().join("model.toml")).expect("a model file");
    assert!(written.contains("robot = \"robot.toml\"\nprocess = \"process.toml\"\n"), "{written}");
    // Nothing outside the folder is named.
    assert!(!written.contains('/') || written.contains("model/1"), "{written}");
    let cell = CellFiles::new().model(fmu.resources().join("model.toml")).read().expect("a cell");
    assert_eq!(cell.effects.len(), 1);
}

#[test]
fn a_description_says_units_types_and_where_values_lie() {
    let files = CellFiles::new();
    let fmu = unpacked(&files, None, &export(&files, law("learning"), FmiVersion::Fmi3));
    for expected in [
        "fixedInternalStepSize=\"0.012\"",
        "name=\"gain_rate_rad_s\"",
        "<Unit name=\"N.m\">",
        "declaredType=\"Torque\" unit=\"N.m\"",
        "canSerializeFMUState=\"true\"",
        &format!("instantiationToken=\"{}\"", fmu.token),
    ] {
        assert!(fmu.description.contains(expected), "{expected} in {}", fmu.description);
    }
}
