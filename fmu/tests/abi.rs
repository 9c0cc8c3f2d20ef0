//! Law and plant through the functions of FMI 2.0 and 3.0, against the simulation itself; and what
//! is refused.

use crate::package::{Unpacked, export, law, unpacked};
use std::ffi::{CString, c_int, c_void};
use std::fs;
use std::path::PathBuf;
use std::ptr::{null, null_mut};
use tempfile::TempDir;
use trueweld::CellFiles;
use trueweld_fmu::abi::{fmi2, fmi3};
use trueweld_fmu::{CellInput, FmiVersion, FmuExport, FmuModel};
use trueweld_plant::controllers::ControllerKind;
use trueweld_plant::simulate::{Simulation, WeldProgram};

const OK: c_int = 0;
const WARNING: c_int = 1;
const ERROR: c_int = 3;
const STEP: f64 = 0.012;

/// A weld of 4 cm whose loop closes at once.
fn weld(folder: &TempDir) -> PathBuf {
    let path = folder.path().join("short.toml");
    let text = "schema = \"weld/1\"\nstart_m = [1.7, 0.0, 0.5]\nend_m = [1.7, 0.04, 0.5]\n\
                tool_axis = [0.0, 0.0, -1.0]\nfeed_m_s = 0.02\nfeed_ramp_s = 0.1\nforce_n = 18000.0\n\
                force_ramp_s = 0.2\ninitial_depth_m = 0.0003\nsettle_s = 0.1\n";
    fs::write(&path, text).expect("a file");
    path
}

/// References of an FMI 3.0 description by names: of a variable's first value.
fn reference(fmu: &Unpacked, name: &str) -> u32 {
    let place = fmu.description.find(&format!("name=\"{name}\"")).expect(name);
    let rest = &fmu.description[place..];
    let (_, rest) = rest.split_once("valueReference=\"").expect("a reference");
    rest.split('"').next().and_then(|digits| digits.parse().ok()).expect("a number")
}

/// An instance of FMI 2.0, freed at the end.
struct Instance2(*mut c_void);

impl Drop for Instance2 {
    fn drop(&mut self) {
        // SAFETY: of `fmi2Instantiate`, and not used again.
        unsafe { fmi2::fmi2FreeInstance(self.0) }
    }
}

impl Instance2 {
    fn new(fmu: &Unpacked) -> Self {
        let token = CString::new(fmu.token.as_str()).expect("a token");
        let uri = format!("file://{}", fmu.resources().display());
        let uri = CString::new(uri).expect("a URI");
        // SAFETY: texts that end with 0, and no callbacks.
        let pointer = unsafe {
            fmi2::fmi2Instantiate(c"one".as_ptr(), 1, token.as_ptr(), uri.as_ptr(), null(), 0, 0)
        };
        assert!(!pointer.is_null());
        Self(pointer)
    }

    fn begun(fmu: &Unpacked) -> Self {
        let instance = Self::new(fmu);
        // SAFETY: an instance that lives.
        unsafe {
            assert_eq!(fmi2::fmi2SetupExperiment(instance.0, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi2::fmi2EnterInitializationMode(instance.0), OK);
            assert_eq!(fmi2::fmi2ExitInitializationMode(instance.0), OK);
        }
        instance
    }

    /// `count` reals from a reference on.
    fn reals(&self, first: u32, count: usize) -> Vec<f64> {
        let references: Vec<u32> = (first..).take(count).collect();
        let mut values = vec![0.0; count];
        // SAFETY: as many values as references.
        let status =
            unsafe { fmi2::fmi2GetReal(self.0, references.as_ptr(), count, values.as_mut_ptr()) };
        assert_eq!(status, OK);
        values
    }

    fn set_reals(&self, first: u32, values: &[f64]) -> c_int {
        let references: Vec<u32> = (first..).take(values.len()).collect();
        // SAFETY: as many values as references.
        unsafe { fmi2::fmi2SetReal(self.0, references.as_ptr(), values.len(), values.as_ptr()) }
    }

    fn step(&self, period: usize) -> c_int {
        // SAFETY: an instance that lives.
        unsafe { fmi2::fmi2DoStep(self.0, period as f64 * STEP, STEP, 1) }
    }
}

/// Copies what the plant sees to the law. The names, kinds and order are the same in both: values
/// from the first to the last, but for integers and flags.
fn couple(plant: &Instance2, law: &Instance2, fmus: [&Unpacked; 2]) {
    let [first, flag, after_flag, count, after_count] =
        ["setpoint_rotation", "force_closed", "push", "seam_count", "seam_deviation"]
            .map(|name| fmus.map(|fmu| reference(fmu, name)));
    let end = fmus.map(|fmu| reference(fmu, "start_torque") + 6);
    for [from, to] in [[first, flag], [after_flag, count], [after_count, end]] {
        let values = plant.reals(from[0], (to[0] - from[0]) as usize);
        assert_eq!(law.set_reals(from[1], &values), OK);
    }
    let mut value = 0;
    // SAFETY: one value each.
    unsafe {
        assert_eq!(fmi2::fmi2GetBoolean(plant.0, &flag[0], 1, &mut value), OK);
        assert_eq!(fmi2::fmi2SetBoolean(law.0, &flag[1], 1, &value), OK);
        assert_eq!(fmi2::fmi2GetInteger(plant.0, &count[0], 1, &mut value), OK);
        assert_eq!(fmi2::fmi2SetInteger(law.0, &count[1], 1, &value), OK);
    }
}

#[test]
fn law_and_plant_are_the_simulation_whatever_law_and_controller() {
    let folder = TempDir::new().expect("a folder");
    let weld = weld(&folder);
    let files = CellFiles::new().effect("backlash:A5:half_gap_rad=2e-4").stiffness_error(0.1);
    let cell = files.weld(&weld).expect("a cell");
    for (name, controller) in
        [("elastostatic", ControllerKind::PARALLEL), ("adaptive", ControllerKind::EXTERNAL)]
    {
        let of = |model| FmuExport { controller, ..export(&files, model, FmiVersion::Fmi3) };
        let fmus = [FmuModel::Plant(CellInput::Torque), law(name)]
            .map(|model| unpacked(&files, Some(&weld), &of(model)));
        let [plant_fmu, law_fmu] = &fmus;
        let [plant, law] = [plant_fmu, law_fmu].map(Instance2::begun);
        let [torque, motor] = [reference(law_fmu, "torque"), reference(plant_fmu, "motor")];
        let entry = trueweld::law(name).expect("a law");
        let scenario = cell.scenario(WeldProgram::Weld, controller, &entry);
        let mut simulation = Simulation::new(&scenario).expect("a start");
        for period in 0..60 {
            let expected = simulation.step(&scenario).expect("a period");
            assert_eq!(plant.reals(motor, 6), expected.motor.as_slice(), "{name}, {period}");
            couple(&plant, &law, [plant_fmu, law_fmu]);
            assert_eq!(law.step(period), OK, "{name}, {period}");
            let commanded = law.reals(torque, 6);
            assert_eq!(commanded, expected.torque.as_slice(), "{name}, {period}");
            assert_eq!(plant.set_reals(reference(plant_fmu, "torque"), &commanded), OK);
            assert_eq!(plant.step(period), OK, "{name}, {period}");
        }
    }
}

#[test]
fn a_state_of_one_version_goes_on_in_the_other() {
    let folder = TempDir::new().expect("a folder");
    let weld = weld(&folder);
    let files = CellFiles::new();
    let of = |version| export(&files, FmuModel::Plant(CellInput::Correction), version);
    let fmu = unpacked(&files, Some(&weld), &of(FmiVersion::Fmi3));
    let second = unpacked(&files, Some(&weld), &of(FmiVersion::Fmi2));
    // The same cell: the same token.
    assert_eq!(fmu.token, second.token);
    let plant = Instance2::begun(&second);
    (0..20).for_each(|period| assert_eq!(plant.step(period), OK));
    let (mut state, mut size) = (null_mut(), 0);
    let token = CString::new(fmu.token.as_str()).expect("a token");
    let path = CString::new(fmu.resources().to_str().expect("a path")).expect("a path");
    let motor = reference(&fmu, "motor");
    // SAFETY: instances that live, states of this library, room as is said.
    unsafe {
        assert_eq!(fmi2::fmi2GetFMUstate(plant.0, &mut state), OK);
        assert_eq!(fmi2::fmi2SerializedFMUstateSize(plant.0, state, &mut size), OK);
        let mut bytes = vec![0; size];
        assert_eq!(
            fmi2::fmi2SerializeFMUstate(plant.0, state, bytes.as_mut_ptr(), size - 1),
            ERROR
        );
        assert_eq!(fmi2::fmi2SerializeFMUstate(plant.0, state, bytes.as_mut_ptr(), size), OK);
        assert_eq!(fmi2::fmi2FreeFMUstate(plant.0, &mut state), OK);
        assert!(state.is_null());

        let (name, logger) = (c"three".as_ptr(), None);
        let third = fmi3::fmi3InstantiateCoSimulation(
            name,
            token.as_ptr(),
            path.as_ptr(),
            0,
            0,
            0,
            0,
            null(),
            0,
            null_mut(),
            logger,
            null(),
        );
        assert!(!third.is_null());
        assert_eq!(fmi3::fmi3DeserializeFMUState(third, bytes.as_ptr(), size, &mut state), OK);
        // Not even initialised, it goes on in the middle.
        assert_eq!(fmi3::fmi3SetFMUState(third, state), OK);
        assert_eq!(fmi3::fmi3FreeFMUState(third, &mut state), OK);
        for period in 20..40 {
            let (mut flags, mut last) = ([9_u8; 3], 0.0);
            let [event, terminates, early] = &mut flags;
            let time = period as f64 * STEP;
            let status =
                fmi3::fmi3DoStep(third, time, STEP, 1, event, terminates, early, &mut last);
            assert_eq!((status, flags, last), (OK, [0; 3], (period + 1) as f64 * STEP));
            assert_eq!(plant.step(period), OK);
            let mut found = [0.0; 6];
            assert_eq!(fmi3::fmi3GetFloat64(third, &motor, 1, found.as_mut_ptr(), 6), OK);
            assert_eq!(found.to_vec(), plant.reals(motor, 6));
            assert_eq!(fmi3::fmi3GetFloat64(third, &motor, 1, found.as_mut_ptr(), 5), ERROR);
        }
        fmi3::fmi3FreeInstance(third);
    }
}

#[test]
fn nothing_that_an_importer_gets_wrong_passes() {
    let files = CellFiles::new();
    let fmu = unpacked(&files, None, &export(&files, law("none"), FmiVersion::Fmi3));
    let token = CString::new(fmu.token.as_str()).expect("a token");
    let uri = CString::new(format!("file://{}", fmu.resources().display())).expect("a URI");
    let absent = c"file:///nowhere/resources";
    // SAFETY: null, or what the functions ask for.
    unsafe {
        let of = |kind, token, uri| {
            fmi2::fmi2Instantiate(c"one".as_ptr(), kind, token, uri, null(), 0, 0)
        };
        // Model exchange; another token; no token; no folder.
        assert!(of(0, token.as_ptr(), uri.as_ptr()).is_null());
        assert!(of(1, c"another".as_ptr(), uri.as_ptr()).is_null());
        assert!(of(1, null(), uri.as_ptr()).is_null());
        assert!(of(1, token.as_ptr(), absent.as_ptr()).is_null());
        assert!(of(1, token.as_ptr(), null()).is_null());

        assert_eq!(fmi2::fmi2DoStep(null_mut(), 0.0, STEP, 1), ERROR);
        assert_eq!(fmi2::fmi2ExitInitializationMode(null_mut()), ERROR);
        assert_eq!(fmi2::fmi2GetReal(null_mut(), null(), 0, null_mut()), ERROR);
        assert_eq!(fmi2::fmi2GetFMUstate(null_mut(), null_mut()), ERROR);
        assert_eq!(fmi2::fmi2FreeFMUstate(null_mut(), null_mut()), OK);
        fmi2::fmi2FreeInstance(null_mut());

        let one = Instance2::begun(&fmu);
        let reference = [1];
        assert_eq!(fmi2::fmi2GetReal(one.0, null(), 1, null_mut()), ERROR);
        assert_eq!(fmi2::fmi2GetReal(one.0, reference.as_ptr(), 1, null_mut()), ERROR);
        assert_eq!(fmi2::fmi2SetReal(one.0, reference.as_ptr(), 1, null()), ERROR);
        assert_eq!(fmi2::fmi2GetReal(one.0, null(), 0, null_mut()), OK);
        assert_eq!(fmi2::fmi2GetFMUstate(one.0, null_mut()), ERROR);
        assert_eq!(fmi2::fmi2SetFMUstate(one.0, null_mut()), ERROR);
        assert_eq!(fmi2::fmi2DeSerializeFMUstate(one.0, null(), 80, null_mut()), ERROR);
        assert_eq!(fmi2::fmi2GetString(one.0, reference.as_ptr(), 1, null_mut()), ERROR);
        assert_eq!(fmi2::fmi2EnterInitializationMode(one.0), ERROR);
        // A law that is given axes that are none: a fault, and a torque that is safe.
        assert_eq!(one.step(0), WARNING);
        let mut time = 0.0;
        assert_eq!(fmi2::fmi2GetRealStatus(one.0, 2, &mut time), OK);
        assert_eq!(time, STEP);
        assert_eq!(fmi2::fmi2Terminate(one.0), OK);
        assert_eq!(one.step(1), ERROR);
    }
    // A file that was changed.
    let file = fmu.resources().join("weld.toml");
    let text = fs::read_to_string(&file).expect("a weld file");
    fs::write(&file, text + "# changed\n").expect("a file");
    // SAFETY: as above.
    unsafe {
        let changed =
            fmi2::fmi2Instantiate(c"one".as_ptr(), 1, token.as_ptr(), uri.as_ptr(), null(), 0, 0);
        assert!(changed.is_null());
    }
}
