//! `trueweld identify`: stiffness, damping and process of a cell from its logs.

use crate::measured::{LogArguments, say_unwritten};
use crate::results::{Results, check_outputs, check_targets, write};
use clap::{Args, Subcommand};
use miette::{IntoDiagnostic, Result, miette};
use nalgebra::Vector3;
use std::path::PathBuf;
use trueweld::{identify, measured_provenance};
use trueweld_estimate::identify::plan::{PlanOptions, plan, protocol_text};
use trueweld_estimate::identify::{IdentificationTarget, IdentifyError, file};
use trueweld_output::{
    IdentifyReport, MistakesReport, StiffnessPlanReport, identified_head, identified_source,
};
use trueweld_plant::input::{ModelFile, folder_of};

/// Arguments of `identify`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Stiffness of the joints, from loads at rest
    ///
    /// With --plan it chooses postures and loads instead, and writes them as a protocol for `record`.
    Stiffness(Stiffness),
    /// Damping of the joints, from ring-downs after a brake's stop
    Damping(Identified),
    /// The welding process with its ripple, from the forces of welds
    Process(Identified),
}

#[derive(Args)]
struct Stiffness {
    /// Model file (default: the campaign's)
    #[arg(long, value_name = "FILE", required_unless_present = "logs")]
    model: Option<PathBuf>,
    /// Folders of logs or of campaigns
    #[arg(required_unless_present = "plan", value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Choose the loads that tell the stiffness best, and write them as a protocol
    #[arg(long, value_name = "FILE", conflicts_with_all = ["logs", "out"])]
    plan: Option<PathBuf>,
    /// Loads to choose
    #[arg(long, value_name = "N", default_value_t = 6, conflicts_with = "logs")]
    loads: usize,
    /// Heaviest payload on the flange, kg
    #[arg(long, value_name = "KG", default_value_t = 500.0, conflicts_with = "logs")]
    payload: f64,
    /// Largest push against a fixture, N
    #[arg(long, value_name = "N", default_value_t = 6000.0, conflicts_with = "logs")]
    push: f64,
    /// Noise of a reflector's coordinate, m
    #[arg(long, value_name = "M", default_value_t = 3e-5, conflicts_with = "logs")]
    noise: f64,
    /// Where to write the robot file with the numbers found
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    results: Results,
}

#[derive(Args)]
struct Identified {
    #[command(flatten)]
    measurements: LogArguments,
    /// Where to write the robot file, or the process file, with the numbers found
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    results: Results,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    match &arguments.what {
        What::Stiffness(arguments) => arguments.run(),
        What::Damping(arguments) => arguments.run(IdentificationTarget::Damping),
        What::Process(arguments) => arguments.run(IdentificationTarget::Process),
    }
}

/// Where a payload hangs, from the flange, m: beside axis 6, which it does not turn otherwise; and
/// where three reflectors sit on a tool, in T, m.
const CENTRE: [f64; 3] = [0.15, 0.2, 0.0];
const REFLECTORS: [[f64; 3]; 3] = [[0.2, 0.0, -0.15], [-0.1, 0.18, -0.15], [-0.1, -0.18, -0.15]];

impl Stiffness {
    fn run(&self) -> Result<()> {
        let Some(out) = &self.plan else {
            let measurements = LogArguments::new(self.model.clone(), self.logs.clone());
            let (out, results) = (self.out.clone(), self.results.clone());
            return Identified { measurements, out, results }.run(IdentificationTarget::Stiffness);
        };
        let within = |flag: &str, value: f64, low: f64, high: f64| {
            let fits = (low..=high).contains(&value);
            fits.then_some(value)
                .ok_or_else(|| miette!("{flag} {value}: expected a number from {low} to {high}"))
        };
        if !(1..=100).contains(&self.loads) {
            return Err(miette!("--loads {}: expected from 1 to 100 loads", self.loads));
        }
        let options = PlanOptions {
            loads: self.loads,
            payload: within("--payload", self.payload, 1.0, 1e4)?,
            centre: CENTRE.into(),
            push: within("--push", self.push, 1.0, 1e5)?,
            reflectors: REFLECTORS.map(Vector3::from),
            noise: within("--noise", self.noise, 1e-7, 1e-2)?,
        };
        let mut outputs = self.results.outputs();
        outputs.push(("--plan", out));
        check_targets(&outputs)?;
        let path = self.model.as_ref().ok_or_else(|| miette!("--model is missing"))?;
        let model = ModelFile::read(path)?;
        check_outputs(&outputs)?;
        let plan = plan(&model.robot.robot, &options).ok_or_else(|| {
            miette!(
                help = "Give a lighter --payload or a smaller --push.",
                "there is no posture in which this arm may bear these loads"
            )
        })?;
        let provenance = measured_provenance("identify stiffness --plan", &model, &[])?;
        let report = StiffnessPlanReport {
            model: &model,
            plan: &plan,
            options: &options,
            out,
            provenance: &provenance,
        };
        self.results.write(&report)?;
        let folder = folder_of(out).canonicalize().into_diagnostic()?;
        let robot = model.robot_path.canonicalize().into_diagnostic()?;
        let robot = robot.strip_prefix(&folder).unwrap_or(&robot).display().to_string();
        write(out, &protocol_text(&plan, &options, &robot))
    }
}

impl Identified {
    fn run(&self, target: IdentificationTarget) -> Result<()> {
        let mut outputs = self.results.outputs();
        outputs.extend(self.out.as_deref().map(|path| ("--out", path)));
        check_targets(&outputs)?;
        let given = self.measurements.read_files()?;
        let provenance = given.provenance(&format!("identify {}", target.name()))?;
        check_outputs(&outputs)?;
        let progress = self.results.progress("fitting", 1.0);
        let model = given.model.clone();
        let done = identify(target, given, &|stage, share| progress.stage(stage, share));
        progress.finish();
        let found = match done {
            Err(IdentifyError::Mistakes(found)) => {
                let report =
                    MistakesReport { model: &model, found: &found, provenance: &provenance };
                self.results.write(&report)?;
                return self.out.iter().try_for_each(|path| say_unwritten("result", path));
            }
            other => other.into_diagnostic()?,
        };
        let report = IdentifyReport { model: &model, found: &found, provenance: &provenance };
        self.results.write(&report)?;
        if let Some(out) = &self.out {
            let head = identified_head(&report);
            let source = |number: &_| identified_source(&report, number);
            let text = match target {
                IdentificationTarget::Process => file::process_text(&found, out, &source, &head)?,
                _ => file::robot_text(&found, out, &source, &head)?,
            };
            write(out, &text)?;
        }
        Ok(())
    }
}
