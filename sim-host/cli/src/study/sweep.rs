//! Runs of a study in a folder: kept as they are made, resumed, made in parts and put together as
//! those of `certify`; at the end as one table with a manifest.

use crate::results::{Results, check_new_folder};
use clap::Args;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};
use trueweld_evaluate::certify::{
    EvidenceBasis, Repeat, Shard, Shards, TrialStore, begin_shard, check_shard_folder,
    digest_of_inputs,
};
use trueweld_output::{Progress, Report, write_file};
use trueweld_plant::provenance::{FileDigest, Provenance};

/// Where the runs of a study are kept, and which of them are made.
#[derive(Args, Default)]
pub(crate) struct SweepFolder {
    /// Keep the runs in this folder: a study that was stopped goes on there, and ends with them as a
    /// table with a manifest
    #[arg(long, value_name = "FOLDER")]
    evidence: Option<PathBuf>,
    /// Make part I of N of the runs, in an evidence folder of its own; no result yet
    #[arg(long, value_name = "I/N", conflicts_with = "merge", requires = "evidence")]
    pub shard: Option<Shard>,
    /// Put shards together that were made with the same options
    #[arg(long, value_name = "FOLDER", num_args = 1.., requires = "evidence")]
    merge: Vec<PathBuf>,
}

/// What is swept.
pub(crate) struct Sweep<'a> {
    /// What the runs are of.
    pub provenance: &'a Provenance,
    /// How many runs there are.
    pub runs: u64,
    /// Where progress is shown.
    pub results: &'a Results,
}

/// The runs, one a line.
const RUNS: &str = "runs.jsonl";

/// What the table is of.
const MANIFEST: &str = "manifest.json";

/// The runs as a table: Parquet, in a build that has it.
const TABLE: &str = if cfg!(feature = "parquet") { "runs.parquet" } else { "runs.csv" };

/// What a table of runs says of itself.
#[derive(Serialize)]
struct Manifest<'a> {
    schema: &'static str,
    /// Runs, a row each.
    runs: u64,
    /// What the runs are of.
    provenance: &'a Provenance,
    /// The table and the runs as they were kept.
    files: Vec<FileDigest>,
}

impl SweepFolder {
    /// Checks the folder, and that a part of a study is not asked for a result.
    pub(crate) fn check(&self, results: &Results) -> Result<()> {
        if let Some(folder) = &self.evidence {
            check_new_folder("--evidence", folder)?;
        }
        match (self.shard, results.outputs().first()) {
            (Some(shard), Some((flag, _))) => Err(miette!(
                "{flag}: shard {shard} has no result yet; expected this option with --merge"
            )),
            _ => Ok(()),
        }
    }

    /// The files that are written besides the results, in a folder that is there.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let names = [RUNS, MANIFEST, TABLE];
        let there = self.evidence.iter().filter(|folder| folder.exists());
        there.flat_map(|folder| names.map(|name| folder.join(name))).collect()
    }

    /// The runs in their order: those that are kept, and the missing ones on all cores. `more`: runs
    /// that the caller makes beside them, which the progress counts. `None` for a part, which has no
    /// result yet.
    pub(crate) fn complete<R: Serialize + DeserializeOwned + Clone + Send + Sync>(
        &self,
        sweep: &Sweep<'_>,
        more: usize,
        is: impl Fn(&u64, &R) -> bool,
        run: impl Fn(&u64) -> R + Sync,
    ) -> Result<Option<(Vec<R>, Progress)>> {
        let jobs: Vec<u64> = (0..sweep.runs).collect();
        let Some(folder) = &self.evidence else {
            let progress = sweep.results.progress("welding", (jobs.len() + more) as f64);
            let runs = jobs.par_iter().map(|job| {
                let run = run(job);
                progress.advance_by(1);
                run
            });
            let runs = runs.collect();
            return Ok(Some((runs, progress)));
        };
        let inputs = digest_of_inputs(sweep.provenance)?;
        let basis = EvidenceBasis { inputs: &inputs, sources: &sweep.provenance.sources };
        let open = |path| TrialStore::<R>::open(path, basis, Repeat::Sample);
        let path = folder.join(RUNS);
        let mut store = open(path.clone())?;
        check_shard_folder(folder, self.shard)?;
        if !self.merge.is_empty() {
            let shards = Shards::read(&self.merge, sweep.provenance, sweep.runs)?;
            let parts = shards.folders().map(|folder| open(folder.join(RUNS)));
            let parts = parts.collect::<Result<Vec<_>, _>>()?;
            let weld = sweep.provenance.simulation.as_ref().map_or("", |of| &of.welds[0]);
            store.merge(&jobs, &parts, &is).map_err(|shard| shards.lacks(shard, weld))?;
        }
        std::fs::create_dir_all(folder)
            .into_diagnostic()
            .wrap_err_with(|| format!("cannot create {}", folder.display()))?;
        if self.shard.is_some() {
            begin_shard(folder)?;
        }
        let jobs = self.shard.map_or(jobs.clone(), |shard| shard.part(jobs));
        let kept = store.count().min(jobs.len());
        let progress =
            sweep.results.progress("welding", (jobs.len() + more) as f64).counting_from(kept);
        let runs = store.complete(&jobs, is, |job| {
            let run = run(job);
            progress.advance_by(1);
            run
        })?;
        store.close()?;
        let Some(shard) = self.shard else {
            return Ok(Some((runs, progress)));
        };
        progress.finish();
        shard.finish(folder, &[path], sweep.provenance.clone(), sweep.runs)?;
        say!("shard {shard}: {} runs in {}\n", runs.len(), folder.display());
        Ok(None)
    }

    /// The runs as a table beside those that are kept, and the manifest of both.
    pub(crate) fn write(
        &self,
        report: &impl Report,
        provenance: &Provenance,
        runs: u64,
    ) -> Result<()> {
        let (Some(folder), Some(samples)) = (&self.evidence, report.samples()) else {
            return Ok(());
        };
        samples.write(&folder.join(TABLE))?;
        let digest = |name: &str| {
            let bytes = std::fs::read(folder.join(name)).into_diagnostic()?;
            Ok(FileDigest::new("runs", name, &bytes))
        };
        let files = [TABLE, RUNS].into_iter().map(digest).collect::<Result<_>>()?;
        let manifest = Manifest { schema: "study-runs/1", runs, provenance, files };
        let text = serde_json::to_string_pretty(&manifest).into_diagnostic()?;
        let path: &Path = &folder.join(MANIFEST);
        write_file(path, text + "\n")?;
        say!("wrote {}\n", path.display());
        Ok(())
    }
}
