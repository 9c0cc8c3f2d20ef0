//! What many welds of uncertain cells prove of a law.

use crate::cell::{STEP_OF_MANY, WeldingCell};
use crate::fixture::read_input;
use miette::{Report, Result, miette};
use std::path::{Path, PathBuf};
use std::slice;
use trueweld_compensators::Entry;
use trueweld_evaluate::certify::{
    Certificate, CertificationOutcome, CertificationPlan, CertifyError, FaultsRefused,
    OpenCertification, Repeat, Shard, WeldToCertify, seed_of_inputs,
};
use trueweld_evaluate::{Requirements, UncertainCell};
use trueweld_plant::provenance::{FileDigest, Provenance};
use trueweld_plant::simulate::{ControllerKind, Scenario, WeldProgram};

/// Certifies a law in a cell, over one weld or several: many welds of drawn cells, against
/// requirements (the embedded ones of the lap weld where none are given).
///
/// Every run is kept in an evidence folder; the same options go on where they were stopped.
///
/// ```no_run
/// use trueweld::{CellFiles, Verdict, certify, law};
///
/// let cell = CellFiles::new().read()?;
/// let certificate = certify(&[cell], law("seam-tracking")?).trials(100).evidence("out").run()?;
/// assert_eq!(certificate.verdict(), Verdict::Pass);
/// # Ok::<(), miette::Report>(())
/// ```
pub fn certify(cells: &[WeldingCell], law: Entry) -> CertifyOptions<'_> {
    CertifyOptions {
        cells,
        law,
        controller: ControllerKind::EXTERNAL,
        requirements: None,
        trials: 100,
        failure_probability: None,
        worst: 60,
        passes: 1,
        draws: None,
        evidence: PathBuf::from("out/certify"),
        compare_assumed: false,
        shard: None,
        merge: Vec::new(),
        repeat: Repeat::Sample,
    }
}

/// Requirements and the file that they were read from.
#[derive(Debug, Clone)]
pub struct RequirementsFile {
    /// The requirements.
    pub requirements: Requirements,
    /// Digest of their file.
    pub digest: FileDigest,
}

impl RequirementsFile {
    /// Reads requirements; those of the lap weld where no file is given.
    ///
    /// # Errors
    /// A file that cannot be used, at its place.
    pub fn read(file: Option<&Path>) -> Result<Self> {
        let mut files = Vec::new();
        let requirements = read_input(file, &mut files)?;
        let digest = files.pop().ok_or_else(|| miette!("no file was read"))?;
        Ok(Self { requirements, digest })
    }
}

/// How a law is certified.
#[must_use]
#[derive(Clone)]
pub struct CertifyOptions<'a> {
    cells: &'a [WeldingCell],
    law: Entry,
    controller: ControllerKind,
    requirements: Option<RequirementsFile>,
    trials: u64,
    failure_probability: Option<f64>,
    worst: usize,
    passes: usize,
    draws: Option<u64>,
    evidence: PathBuf,
    compare_assumed: bool,
    shard: Option<Shard>,
    merge: Vec<PathBuf>,
    repeat: Repeat,
}

impl<'a> CertifyOptions<'a> {
    /// With this hybrid controller (default: external, (2.4)–(2.5)).
    pub fn controller(self, controller: ControllerKind) -> Self {
        Self { controller, ..self }
    }

    /// Against these requirements.
    pub fn requirements(self, requirements: RequirementsFile) -> Self {
        Self { requirements: Some(requirements), ..self }
    }

    /// Trials of each weld (default: 100).
    pub fn trials(self, trials: u64) -> Self {
        Self { trials, ..self }
    }

    /// Shows that a weld beyond any limit is rarer than this, by subset simulation; from 1e-9 to
    /// below 0.5.
    pub fn failure_probability(self, probability: Option<f64>) -> Self {
        Self { failure_probability: probability, ..self }
    }

    /// Runs of the search for the worst cell, of each weld (default: 60).
    pub fn worst(self, worst: usize) -> Self {
        Self { worst, ..self }
    }

    /// Welds of one seam in a trial, the law kept; the last one counts (default: 1).
    pub fn passes(self, passes: usize) -> Self {
        Self { passes, ..self }
    }

    /// Seed of the draws (default: follows from files and options).
    pub fn draws(self, seed: Option<u64>) -> Self {
        Self { draws: seed, ..self }
    }

    /// The folder in which every run is kept (default: `out/certify`).
    pub fn evidence(self, folder: impl Into<PathBuf>) -> Self {
        Self { evidence: folder.into(), ..self }
    }

    /// Makes the trials with what the requirements assume of measured numbers as well.
    pub fn compare_assumed(self, compare: bool) -> Self {
        Self { compare_assumed: compare, ..self }
    }

    /// Makes this part of the runs alone; no certificate yet.
    pub fn shard(self, shard: Option<Shard>) -> Self {
        Self { shard, ..self }
    }

    /// Takes over the runs of shards that were made with the same options.
    pub fn merge(self, folders: &[PathBuf]) -> Self {
        Self { merge: folders.to_vec(), ..self }
    }

    /// Which of the kept runs are made again, and must come out as they were kept (default: one in
    /// twenty).
    pub fn repeat(self, repeat: Repeat) -> Self {
        Self { repeat, ..self }
    }

    /// Certifies the law.
    ///
    /// # Errors
    /// Those of [`CertifyOptions::prepare`], [`PreparedCertification::open`] and
    /// [`StartedCertification::run`]; a shard, which has no certificate.
    pub fn run(self) -> Result<Certificate> {
        match self.prepare()?.open()?.run(&|_, _| {})? {
            CertificationOutcome::Whole(certificate) => Ok(*certificate),
            CertificationOutcome::Part(_) => Err(miette!("a shard has no certificate yet")),
        }
    }

    /// Finds out what is not known of the cell, and the seed of the draws.
    ///
    /// # Errors
    /// No cell, or two welds of one name; requirements that are not of this cell; a posterior that is
    /// of another model, or none where its use is to be shown.
    pub fn prepare(mut self) -> Result<PreparedCertification<'a>> {
        let first =
            self.cells.first().ok_or_else(|| miette!("no weld to certify; expected one"))?;
        self.check_names()?;
        for cell in self.cells {
            cell.must_bear_push("certify")?;
        }
        let requirements = match self.requirements.take() {
            Some(requirements) => requirements,
            None => RequirementsFile::read(None)?,
        };
        let assumed = requirements
            .requirements
            .uncertain_cell(&first.robot, &first.planned, &first.sensors)
            .map_err(|error| {
                miette!(
                    help = "Numbers in [[uncertain]] are of the cell that is certified.",
                    "{error}"
                )
            })?;
        let measured = first.measured(&assumed)?;
        if self.compare_assumed && measured.is_none() {
            return Err(miette!(
                help = "`improve` writes what it measured into the model file, as [posterior].",
                "--compare-assumed: nothing of this cell is measured; expected --model with a posterior"
            ));
        }
        let files = slice::from_ref(&requirements.digest);
        let natural_seed = seed_of_inputs(&self.provenance(first, files))?;
        Ok(PreparedCertification { options: self, requirements, assumed, measured, natural_seed })
    }

    /// Evidence is named after the weld: two of one name would share it.
    fn check_names(&self) -> Result<()> {
        for (k, one) in self.cells.iter().enumerate() {
            let earlier = &self.cells[..k];
            if let Some(other) = earlier.iter().find(|other| other.weld_name == one.weld_name) {
                return Err(miette!(
                    help = "Evidence and results are named after the weld file: give one of them another name.",
                    "--weld {} and --weld {}: two welds of the name {}; expected each weld once, by a name of its own",
                    other.weld_file,
                    one.weld_file,
                    one.weld_name
                ));
            }
        }
        Ok(())
    }

    /// What the runs of a weld are of, but for the seed of the draws. `files`: read for all welds.
    fn provenance(&self, cell: &WeldingCell, files: &[FileDigest]) -> Provenance {
        let (controller, law) = (self.controller, &self.law);
        let mut simulation =
            cell.simulation(&[controller], slice::from_ref(law), self.passes, STEP_OF_MANY);
        simulation.cores = cell.cores(controller, law);
        let mut provenance = cell.provenance("certify", simulation);
        provenance.files.extend_from_slice(files);
        provenance
    }
}

/// A certification of which everything is known that its runs depend on.
pub struct PreparedCertification<'a> {
    options: CertifyOptions<'a>,
    requirements: RequirementsFile,
    assumed: UncertainCell,
    measured: Option<UncertainCell>,
    natural_seed: u64,
}

impl PreparedCertification<'_> {
    /// The seed of the draws that follows from files and options.
    pub fn natural_seed(&self) -> u64 {
        self.natural_seed
    }

    /// Finds out whether every weld can be made, and reads what is kept. Makes the evidence folder;
    /// nothing else is written yet.
    ///
    /// # Errors
    /// A weld that cannot be made or judged; evidence of something else, or that was changed; a
    /// shard that does not fit.
    pub fn open(&self) -> Result<StartedCertification<'_>> {
        let Self { options, requirements, assumed, measured, natural_seed } = self;
        let welds = options.cells.iter().map(|cell| self.weld(cell)).collect::<Result<_>>()?;
        let plan = CertificationPlan {
            welds,
            requirements: &requirements.requirements,
            uncertain: measured.as_ref().unwrap_or(assumed),
            assumed: options.compare_assumed.then_some(assumed),
            trials: options.trials,
            failure_probability: options.failure_probability,
            worst: options.worst,
            passes: options.passes,
            seed: options.draws.unwrap_or(*natural_seed),
            evidence: &options.evidence,
            repeat: options.repeat,
            shard: options.shard,
            merge: &options.merge,
        };
        let open = plan.open().map_err(|error| self.failed(error))?;
        Ok(StartedCertification { prepared: self, open })
    }

    /// One weld of the certification.
    fn weld<'c>(&'c self, cell: &'c WeldingCell) -> Result<WeldToCertify<'c>> {
        let CertifyOptions { controller, law, .. } = &self.options;
        let files = slice::from_ref(&self.requirements.digest);
        let scenario = cell.scenario(WeldProgram::Weld, *controller, law);
        Ok(WeldToCertify {
            scenario: Scenario { plant_step: STEP_OF_MANY, ..scenario },
            robot: &cell.robot.robot,
            effects: &cell.effects,
            requirements: cell.asked(&self.requirements.requirements, files)?,
            provenance: self.options.provenance(cell, files),
        })
    }

    /// What to say of a certification that came to no end.
    fn failed(&self, error: CertifyError) -> Report {
        let CertifyOptions { cells, controller, .. } = self.options;
        match error {
            CertifyError::Run { weld, error } => cells[weld].failed(controller, &error),
            CertifyError::TooShort { weld } => cells[weld].too_short(),
            CertifyError::Faults { weld, error: error @ FaultsRefused::TooShort { .. } } => {
                miette!(
                    help =
                        "Expected a longer seam, or shorter duration_s and recovery_s in [faults].",
                    "{}: {error}",
                    cells[weld].weld_file
                )
            }
            CertifyError::Faults { error: error @ FaultsRefused::NoLimit { .. }, .. } => {
                miette!("{}: {error}", self.requirements.digest.file)
            }
            CertifyError::Evidence(report) => report,
            other => other.into(),
        }
    }
}

/// A certification whose inputs are usable and whose kept runs are read.
pub struct StartedCertification<'p> {
    prepared: &'p PreparedCertification<'p>,
    open: OpenCertification<'p>,
}

impl StartedCertification<'_> {
    /// The files with runs that it writes, or would where there are such runs.
    pub fn files(&self) -> Vec<PathBuf> {
        self.open.files()
    }

    /// Makes the runs that are missing, on all cores, and judges all of them. `progress` is told
    /// what is made now and the share of the missing runs that is made, from any thread.
    ///
    /// # Errors
    /// A loop without margins; evidence that cannot be written; a kept run that comes out otherwise.
    pub fn run(self, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<CertificationOutcome> {
        self.open.run(progress).map_err(|error| self.prepared.failed(error))
    }
}
