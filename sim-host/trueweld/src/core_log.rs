//! The recorded run of a controller's core: two files of numbers, as the example of the C interface
//! reads and writes them, and the core's header.

use crate::cell::{PLANT_STEP, WeldingCell};
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::fs;
use std::path::{Path, PathBuf};
use trueweld_compensators::{Configuration, Entry, HeaderError};
use trueweld_core::compensation::Observation;
use trueweld_evaluate::{CoreOutputs, CorePeriod, CoreRun, MEASUREMENT_NUMBERS, PERIOD_NUMBERS};
use trueweld_plant::input::{read_text, write_atomically};
use trueweld_plant::provenance::FileDigest;
use trueweld_plant::simulate::{ControllerKind, RunError, Scenario, Simulation, WeldProgram};

/// What a core is given, and what it commands: names in a folder.
pub const CORE_INPUTS_FILE: &str = "inputs.bin";
/// See [`CORE_INPUTS_FILE`].
pub const CORE_OUTPUTS_FILE: &str = "outputs.bin";

/// Name of the header of C that `export-core` writes.
const CORE_HEADER_FILE: &str = "cell.h";

/// Most measurements in a period: what the C interface takes.
const CORE_MEASUREMENTS: usize = 8;

/// Numbers of a period in [`CORE_OUTPUTS_FILE`].
const OUTPUT_NUMBERS: usize = 13;

/// A core and the files that it was read from.
pub struct CoreFile {
    /// What it is built from.
    pub configuration: Configuration,
    /// The header.
    pub file: FileDigest,
}

impl CoreFile {
    /// Reads the header that `export-core` wrote. `path`: the header, or the folder it is in.
    ///
    /// # Errors
    /// A file that is none, or whose numbers are not those of its digest.
    pub fn read(path: &Path) -> Result<Self> {
        let path = if path.is_dir() { path.join(CORE_HEADER_FILE) } else { path.to_owned() };
        let (name, text) = read_text(&path)?;
        let configuration = Configuration::from_c_header(&text).map_err(|error| {
            let read = match error {
                HeaderError::Missing(what) => format!("it does not define `{what}`"),
                HeaderError::Length => "it has not as many numbers as a core".to_owned(),
                HeaderError::Value(value) => format!("{value} stands where another value belongs"),
                HeaderError::Digest => "its numbers are not those of its digest".to_owned(),
            };
            miette!(
                help = "`trueweld export-core` writes it anew; a gain is changed in the control file, and the core exported again.",
                "{name}: {read}; expected {CORE_HEADER_FILE} as `trueweld export-core` writes it"
            )
        })?;
        Ok(Self { configuration, file: FileDigest::new("core", &name, text.as_bytes()) })
    }
}

/// Numbers of a file of doubles, in their order.
struct Doubles {
    path: PathBuf,
    numbers: Vec<f64>,
    read: usize,
}

impl Doubles {
    fn read(path: PathBuf) -> Result<(Self, FileDigest)> {
        let name = path.display().to_string();
        let bytes =
            fs::read(&path).into_diagnostic().wrap_err_with(|| format!("cannot read {name}"))?;
        let (doubles, rest) = bytes.as_chunks::<8>();
        if !rest.is_empty() {
            return Err(miette!(
                "{name}: {} bytes; expected doubles, of 8 bytes each",
                bytes.len()
            ));
        }
        let numbers = doubles.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        let digest = FileDigest::new("core log", &name, &bytes);
        Ok((Self { path, numbers, read: 0 }, digest))
    }

    fn is_over(&self) -> bool {
        self.read == self.numbers.len()
    }

    /// The next numbers of a period.
    fn next<const N: usize>(&mut self, period: usize) -> Result<[f64; N]> {
        let left = &self.numbers[self.read..];
        let Some(next) = left.first_chunk::<N>() else {
            return Err(miette!(
                "{}: it ends within period {period}, after {} numbers; expected {N} more, and {} are left",
                self.path.display(),
                self.read,
                left.len()
            ));
        };
        let next = *next;
        self.read += N;
        Ok(next)
    }

    /// What is wrong with a number, `at` from 0.
    fn wrong(&self, at: usize, period: usize, expected: &str) -> miette::Report {
        let value = self.numbers[at];
        miette!(
            help = "The order of the numbers is in docs/embedded.md.",
            "{}: period {period}, number {at}: {value}; expected {expected}",
            self.path.display()
        )
    }
}

/// Reads a recorded run from a folder, with digests of its files.
///
/// # Errors
/// A file that cannot be read, ends early, or holds numbers that cannot be.
pub fn read_core_log(folder: &Path) -> Result<(CoreRun, Vec<FileDigest>)> {
    let (mut inputs, input_file) = Doubles::read(folder.join(CORE_INPUTS_FILE))?;
    let (mut outputs, output_file) = Doubles::read(folder.join(CORE_OUTPUTS_FILE))?;
    let start = [inputs.next(0)?, inputs.next(0)?];
    let mut run = CoreRun { start, ..CoreRun::default() };
    while !inputs.is_over() {
        run.periods.push(period(&mut inputs, run.periods.len())?);
    }
    while !outputs.is_over() {
        let [status, rest @ ..] = outputs.next::<OUTPUT_NUMBERS>(run.outputs.len())?;
        let torque = std::array::from_fn(|k| rest[k]);
        let correction = std::array::from_fn(|k| rest[6 + k]);
        run.outputs.push(CoreOutputs { status, torque, correction });
    }
    let [given, commanded] = [run.periods.len(), run.outputs.len()];
    if given != commanded || given == 0 {
        return Err(miette!(
            "{}: {given} periods in {CORE_INPUTS_FILE} and {commanded} in {CORE_OUTPUTS_FILE}; expected as many in both, one at \
             least",
            folder.display()
        ));
    }
    Ok((run, vec![input_file, output_file]))
}

fn period(inputs: &mut Doubles, k: usize) -> Result<CorePeriod> {
    let numbers = inputs.next::<PERIOD_NUMBERS>(k)?;
    if numbers[0] != 0.0 && numbers[0] != 1.0 {
        let at = inputs.read - PERIOD_NUMBERS;
        return Err(inputs.wrong(at, k, "1 where the force loop is closed, else 0"));
    }
    let count = numbers[PERIOD_NUMBERS - 1];
    if !(0..=CORE_MEASUREMENTS).any(|possible| count == possible as f64) {
        return Err(inputs.wrong(inputs.read - 1, k, "the number of measurements, 0 to 8"));
    }
    let measurements = (0..count as usize)
        .map(|_| inputs.next::<MEASUREMENT_NUMBERS>(k))
        .collect::<Result<_>>()?;
    Ok(CorePeriod { numbers, measurements })
}

/// Writes a recorded run into a folder, which is made.
///
/// # Errors
/// The operating system's.
pub fn write_core_log(folder: &Path, run: &CoreRun) -> Result<()> {
    fs::create_dir_all(folder)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot make the folder {}", folder.display()))?;
    let periods = run
        .periods
        .iter()
        .flat_map(|period| period.numbers.iter().chain(period.measurements.iter().flatten()));
    let inputs = run.start.iter().flatten().chain(periods);
    let of_period = |of: &CoreOutputs| {
        std::iter::once(of.status).chain(of.torque).chain(of.correction).collect::<Vec<_>>()
    };
    let outputs: Vec<f64> = run.outputs.iter().flat_map(of_period).collect();
    for (file, numbers) in
        [(CORE_INPUTS_FILE, inputs.copied().collect()), (CORE_OUTPUTS_FILE, outputs)]
    {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        write_atomically(folder.join(file), &bytes).into_diagnostic()?;
    }
    Ok(())
}

/// Simulates the weld of a cell, and records what its controller is given and what it commands, from
/// rest before the force loop closes.
///
/// # Errors
/// A run that does not come to its end.
pub fn record_core(cell: &WeldingCell, controller: ControllerKind, law: &Entry) -> Result<CoreRun> {
    let scenario =
        Scenario { plant_step: PLANT_STEP, ..cell.scenario(WeldProgram::Weld, controller, law) };
    let failed = |error: &RunError| cell.failed(controller, error);
    let mut simulation = Simulation::new(&scenario).map_err(|error| failed(&error))?;
    let start = simulation.cell.start().map(Into::into);
    let mut run = CoreRun { start, ..CoreRun::default() };
    while !simulation.cell.is_done() {
        let seen = simulation.cell.observe(&scenario);
        run.periods.push(CorePeriod::of(&Observation {
            setpoint: &seen.reference.setpoint,
            nominal: &seen.reference.nominal,
            sensed: &seen.readings.sensed,
            path: seen.reference.path,
            planned: seen.reference.planned,
            measurements: &seen.readings.measurements,
            taught: None,
        }));
        let row = simulation.control(&scenario, &seen);
        run.outputs.push(CoreOutputs {
            status: f64::from(u8::from(row.fault.is_some())),
            torque: row.torque.into(),
            correction: row.correction_w.to_vector().into(),
        });
        simulation.cell.advance(&scenario).map_err(|source| failed(&RunError::from(source)))?;
    }
    Ok(run)
}
