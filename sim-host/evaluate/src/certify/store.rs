//! Runs that are kept as they are made, one a line, so that an interrupted certification goes on
//! where it was stopped.
//!
//! The first line names the key of everything that the runs depend on. Every line after it holds a
//! run and a SHA-256 of the digest before it and of the run: a line that was changed, moved or taken
//! out no longer fits, and the file is refused. A last line without its end was cut off by the
//! interruption and is run again. This finds accidents: whoever changes a line on purpose can
//! compute the digests anew. A sample of the kept runs, or all of them, is therefore run again, and
//! must come out as kept.

use super::evidence_error::{cannot, unwritten};
use miette::{IntoDiagnostic, Report, Result, miette};
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{SystemTime, UNIX_EPOCH};
use trueweld_plant::input::write_atomically;
use trueweld_plant::provenance::sha256;

/// Format of the files.
const EVIDENCE_SCHEMA: &str = "trials/3";

/// What the runs of a section must be of.
#[derive(Debug, Clone, Copy)]
pub struct EvidenceBasis<'a> {
    /// Digest of every input that the runs depend on.
    pub inputs: &'a str,
    /// Digest of the sources of the program that makes them.
    pub sources: &'a str,
}

/// The first line of a file.
#[derive(Serialize, Deserialize)]
struct EvidenceHeader {
    schema: String,
    inputs: String,
    sources: String,
}

/// Which of the kept runs are run again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Repeat {
    /// One in twenty.
    Sample,
    /// All of them.
    All,
}

/// One of so many kept runs is in the sample.
const REPEATED_SAMPLE: usize = 20;

/// The runs of one section of one weld, and their file.
pub struct TrialStore<R> {
    path: PathBuf,
    header: String,
    /// Of an interrupted certification of the same.
    kept: Vec<KeptRun<R>>,
    /// Those asked for so far, in their order, as they are written.
    done: Vec<String>,
    /// How many kept runs were made again.
    repeated: usize,
    /// The digest at the end of the file, once runs are added to it.
    last: Option<String>,
}

/// A run of an earlier call.
#[derive(Clone)]
struct KeptRun<R> {
    run: R,
    /// As it is written.
    text: String,
    /// It is run again.
    repeated: bool,
}

impl<R: Serialize + DeserializeOwned + Clone + Send + Sync> TrialStore<R> {
    /// Reads what there is of a section; nothing is written yet.
    ///
    /// # Errors
    /// A file of other inputs or of another build, or one that was changed.
    pub fn open(path: PathBuf, basis: EvidenceBasis<'_>, repeat: Repeat) -> Result<Self> {
        let [schema, inputs, sources] =
            [EVIDENCE_SCHEMA, basis.inputs, basis.sources].map(str::to_owned);
        let header = EvidenceHeader { schema, inputs, sources };
        let header = serde_json::to_string(&header).into_diagnostic()?;
        let kept = match std::fs::read(&path) {
            Ok(bytes) => read(&path, &bytes, &header, basis, repeat)?,
            Err(error) if error.kind() == ErrorKind::NotFound => Vec::new(),
            Err(source) => return Err(cannot("read", &path, source)),
        };
        Ok(Self { path, header, kept, done: Vec::new(), repeated: 0, last: None })
    }

    /// How many runs are kept.
    pub fn kept(&self) -> usize {
        self.kept.len()
    }

    /// How many of them were made again so far, and came out as they were kept.
    pub fn repeated(&self) -> usize {
        self.repeated
    }

    /// The runs that are kept and were not asked for: what is not asked for any more is no less
    /// true. `job`: that of a run; the others are as for [`TrialStore::complete`], which runs one in
    /// so many of these again as well.
    ///
    /// # Errors
    /// Those of [`TrialStore::complete`].
    pub fn others<J: Sync>(
        &mut self,
        job: impl Fn(&R) -> J,
        is: impl Fn(&J, &R) -> bool,
        run: impl Fn(&J) -> R + Sync,
    ) -> Result<Vec<R>> {
        let asked: HashSet<&str> = self.done.iter().map(String::as_str).collect();
        let others = self.kept.iter().filter(|kept| !asked.contains(kept.text.as_str()));
        let jobs: Vec<J> = others.map(|kept| job(&kept.run)).collect();
        self.complete(&jobs, is, run)
    }

    /// How many kept runs need not be made again.
    pub fn count(&self) -> usize {
        self.kept.iter().filter(|kept| !kept.repeated).count()
    }

    /// The runs of these jobs in their order: those that are kept, and the missing ones on all
    /// cores. `is`: whether a run is of a job; `run` makes one.
    ///
    /// # Errors
    /// A file that cannot be written; a kept run that comes out otherwise when it is run again.
    pub fn complete<J: Sync>(
        &mut self,
        jobs: &[J],
        is: impl Fn(&J, &R) -> bool,
        run: impl Fn(&J) -> R + Sync,
    ) -> Result<Vec<R>> {
        let file = Mutex::new(self.appended()?);
        let kept = jobs.iter().enumerate().map(|(i, job)| self.kept_run(i, |run| is(job, run)));
        let kept: Vec<Option<&KeptRun<R>>> = kept.collect();
        let repeated = kept.iter().flatten().filter(|kept| kept.repeated).count();
        let runs = jobs.par_iter().zip(kept).map(|(job, kept)| {
            if let Some(kept) = kept.filter(|kept| !kept.repeated) {
                return Ok((kept.run.clone(), kept.text.clone()));
            }
            let run = run(job);
            let text = serde_json::to_string(&run).into_diagnostic()?;
            match kept {
                Some(kept) if kept.text != text => return Err(self.otherwise(&kept.text, &text)),
                Some(_) => {}
                None => {
                    let mut file = file.lock().map_err(|_| stopped())?;
                    file.append(&text).map_err(|source| self.unwritable(source))?;
                }
            }
            Ok((run, text))
        });
        let runs: Vec<Result<(R, String)>> = runs.collect();
        let (runs, texts): (Vec<R>, Vec<String>) =
            runs.into_iter().collect::<Result<Vec<_>>>()?.into_iter().unzip();
        self.done.extend(texts);
        self.repeated += repeated;
        self.last = Some(file.into_inner().map_err(|_| stopped())?.last);
        Ok(runs)
    }

    /// A kept run, which is most likely the one of this number.
    fn kept_run(&self, number: usize, is: impl Fn(&R) -> bool) -> Option<&KeptRun<R>> {
        let there = self.kept.get(number).filter(|kept| is(&kept.run));
        there.or_else(|| self.kept.iter().find(|kept| is(&kept.run)))
    }

    /// Takes over what shards have kept: of the jobs of a whole certification, number k is in shard
    /// k modulo their number. Nothing is written yet.
    ///
    /// # Errors
    /// The shard that lacks a run.
    pub fn merge<J>(
        &mut self,
        jobs: &[J],
        shards: &[Self],
        is: impl Fn(&J, &R) -> bool,
    ) -> Result<(), usize> {
        let merged = jobs.iter().enumerate().map(|(k, job)| {
            let shard = k % shards.len();
            let run = shards[shard].kept_run(k / shards.len(), |run| is(job, run));
            run.cloned().ok_or(shard)
        });
        let mut merged = merged.collect::<Result<Vec<_>, usize>>()?;
        let texts: HashSet<String> = merged.iter().map(|kept| kept.text.clone()).collect();
        merged.extend(self.kept.drain(..).filter(|kept| !texts.contains(&kept.text)));
        self.kept = merged;
        Ok(())
    }

    /// Writes the runs in the order in which they were asked for, whoever was first, and then what
    /// else was kept.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn close(self) -> Result<()> {
        let asked: HashSet<&str> = self.done.iter().map(String::as_str).collect();
        let others = self.kept.iter().map(|kept| kept.text.as_str());
        let others = others.filter(|text| !asked.contains(text));
        let all = self.done.iter().map(String::as_str).chain(others);
        self.write(&chained(&self.header, all).0)
    }

    /// The file, ready for further runs: whole lines that were kept, and nothing else.
    fn appended(&self) -> Result<EvidenceChain> {
        let last = match &self.last {
            Some(last) => last.clone(),
            None => {
                let kept = self.kept.iter().map(|kept| kept.text.as_str());
                let (text, last) = chained(&self.header, kept);
                self.write(&text)?;
                last
            }
        };
        let file = OpenOptions::new().append(true).open(&self.path);
        Ok(EvidenceChain { file: file.map_err(|source| self.unwritable(source))?, last })
    }

    /// The file as a whole.
    fn write(&self, text: &str) -> Result<()> {
        write_atomically(&self.path, text.as_bytes()).map_err(unwritten)
    }

    /// That no run can be added to the file.
    fn unwritable(&self, source: std::io::Error) -> Report {
        cannot("write", &self.path, source)
    }

    /// That a kept run comes out otherwise, with what stands about the first difference.
    fn otherwise(&self, kept: &str, again: &str) -> Report {
        let differ = kept.bytes().zip(again.bytes()).take_while(|(a, b)| a == b).count();
        let excerpt = |text: &str| {
            let from = differ.saturating_sub(60);
            String::from_utf8_lossy(&text.as_bytes()[from..text.len().min(differ + 40)])
                .into_owned()
        };
        miette!(
            help = "Another version of a law of one's own made these runs, or another compiler, or they were changed: give another --evidence folder.",
            "{}: a kept run comes out otherwise when it is run again: kept …{}…, now …{}…",
            self.path.display(),
            excerpt(kept),
            excerpt(again)
        )
    }
}

/// That a thread came to no end.
fn stopped() -> Report {
    miette!("a thread stopped")
}

/// A file that grows by lines, each with a digest of itself and all before it.
struct EvidenceChain {
    file: File,
    last: String,
}

impl EvidenceChain {
    fn append(&mut self, run: &str) -> std::io::Result<()> {
        let (line, last) = line(&self.last, run);
        self.file.write_all(line.as_bytes())?;
        self.last = last;
        self.file.flush()
    }
}

/// A line with its end, and its digest.
fn line(before: &str, run: &str) -> (String, String) {
    let digest = sha256(format!("{before}\n{run}").as_bytes());
    (format!("{{\"sha256\":\"{digest}\",\"run\":{run}}}\n"), digest)
}

/// A whole file, and its last digest.
fn chained<'a>(header: &str, runs: impl Iterator<Item = &'a str>) -> (String, String) {
    let mut text = format!("{header}\n");
    let mut last = sha256(header.as_bytes());
    for run in runs {
        let (line, digest) = line(&last, run);
        text += &line;
        last = digest;
    }
    (text, last)
}

/// The runs of a file.
fn read<R: DeserializeOwned>(
    path: &Path,
    bytes: &[u8],
    header: &str,
    basis: EvidenceBasis<'_>,
    repeat: Repeat,
) -> Result<Vec<KeptRun<R>>> {
    // Cut off while the header was written.
    if !bytes.contains(&b'\n') && header.as_bytes().starts_with(bytes) {
        return Ok(Vec::new());
    }
    let mut lines = bytes.split_inclusive(|byte| *byte == b'\n');
    let first = lines.next().and_then(|first| first.strip_suffix(b"\n")).unwrap_or_default();
    if first != header.as_bytes() {
        let found = serde_json::from_slice::<EvidenceHeader>(first);
        if let Some(found) = found.ok().filter(|found| found.inputs == basis.inputs) {
            return Err(miette!(
                help = "Build the program from those sources again, or give another --evidence folder.",
                "{} holds runs of another build, of the sources {}; this program is built from {}",
                path.display(),
                found.sources,
                basis.sources
            ));
        }
        return Err(miette!(
            help = "Each law, weld and set of options has an --evidence folder of its own: give another, or remove this one.",
            "{} holds runs of something else; expected none, or some of the same law, files and options",
            path.display()
        ));
    }
    let mut last = sha256(header.as_bytes());
    let mut kept = Vec::new();
    for (i, bytes) in lines.enumerate() {
        if !bytes.ends_with(b"\n") {
            break;
        }
        let found = std::str::from_utf8(bytes).ok().and_then(|text| {
            let run = text.strip_prefix("{\"sha256\":\"")?.split_once("\",\"run\":")?.1;
            let run = run.strip_suffix("}\n")?;
            let (expected, digest) = line(&last, run);
            let read = serde_json::from_str(run).ok()?;
            (expected == text)
                .then(|| (KeptRun { run: read, text: run.to_owned(), repeated: false }, digest))
        });
        let Some((run, digest)) = found else {
            return Err(miette!(
                help = "Keep the lines before it, or give another --evidence folder: what is missing is run again.",
                "{}, line {}: not as it was written; expected a run and the digest of it and the lines before",
                path.display(),
                i + 2
            ));
        };
        kept.push(run);
        last = digest;
    }
    let [first, step] = match repeat {
        Repeat::All => [0, 1],
        Repeat::Sample => {
            let now = SystemTime::now().duration_since(UNIX_EPOCH);
            let now = now.map_or(0, |time| time.subsec_nanos());
            [now as usize % kept.len().clamp(1, REPEATED_SAMPLE), REPEATED_SAMPLE]
        }
    };
    kept.iter_mut().skip(first).step_by(step).for_each(|kept| kept.repeated = true);
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn basis(inputs: &str) -> EvidenceBasis<'_> {
        EvidenceBasis { inputs, sources: "sources" }
    }

    fn squares(path: &Path, key: &str, jobs: &[u64]) -> Result<Vec<[u64; 2]>> {
        let mut store = TrialStore::<[u64; 2]>::open(path.to_owned(), basis(key), Repeat::Sample)?;
        let runs = store.complete(jobs, |job, run| run[0] == *job, |job| [*job, job * job])?;
        store.close()?;
        Ok(runs)
    }

    #[test]
    fn fewer_runs_than_before_delete_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trials.jsonl");
        squares(&path, "key", &[0, 1, 2, 3, 4]).unwrap();
        let whole = std::fs::read(&path).unwrap();
        assert_eq!(squares(&path, "key", &[0, 1]).unwrap(), [[0, 0], [1, 1]]);
        assert!(std::fs::read(&path).unwrap() == whole);
    }

    #[test]
    fn kept_runs_that_are_not_asked_for_count_once_each() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trials.jsonl");
        squares(&path, "key", &[0, 1, 2, 3]).unwrap();
        let mut store = TrialStore::<[u64; 2]>::open(path, basis("key"), Repeat::Sample).unwrap();
        let (is, run) = (|job: &u64, run: &[u64; 2]| run[0] == *job, |job: &u64| [*job, job * job]);
        store.complete(&[1, 4], is, run).unwrap();
        assert_eq!(store.others(|run| run[0], is, run).unwrap(), [[0, 0], [2, 4], [3, 9]]);
        assert!(store.others(|run| run[0], is, run).unwrap().is_empty());
    }

    #[test]
    fn what_was_cut_off_is_run_again_and_ends_with_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trials.jsonl");
        let jobs = [0, 1, 2, 3, 4];
        squares(&path, "key", &jobs).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for kept in 0..whole.len() {
            std::fs::write(&path, &whole[..kept]).unwrap();
            squares(&path, "key", &jobs).unwrap();
            assert!(std::fs::read(&path).unwrap() == whole, "{kept} bytes kept");
        }
    }

    #[test]
    fn a_changed_byte_anywhere_is_refused_and_the_file_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trials.jsonl");
        let jobs = [0, 1, 2];
        squares(&path, "key", &jobs).unwrap();
        let whole = std::fs::read(&path).unwrap();
        // But for the end of the last line, without which it was cut off.
        for at in 0..whole.len() - 1 {
            let mut changed = whole.clone();
            // 0xff is in no UTF-8 text.
            changed[at] = if at % 2 == 0 { 0xff } else { changed[at] ^ 1 };
            std::fs::write(&path, &changed).unwrap();
            assert!(squares(&path, "key", &jobs).is_err(), "byte {at}");
            assert!(std::fs::read(&path).unwrap() == changed, "byte {at}");
        }
        let lines: Vec<&[u8]> = whole.split_inclusive(|b| *b == b'\n').collect();
        std::fs::write(&path, [lines[0], lines[2], lines[3]].concat()).unwrap();
        let error = squares(&path, "key", &jobs).unwrap_err().to_string();
        assert!(error.contains("trials.jsonl, line 2"), "{error}");
    }

    #[test]
    fn runs_of_another_key_are_not_taken() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trials.jsonl");
        squares(&path, "key", &[0, 1]).unwrap();
        let error = squares(&path, "other", &[0, 1]).unwrap_err().to_string();
        assert!(error.contains("runs of something else"), "{error}");
    }

    #[test]
    fn runs_of_another_build_are_not_taken_and_both_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trials.jsonl");
        squares(&path, "key", &[0, 1]).unwrap();
        let other = EvidenceBasis { inputs: "key", sources: "others" };
        let opened = TrialStore::<[u64; 2]>::open(path, other, Repeat::Sample);
        let error = opened.err().expect("another build").to_string();
        assert!(error.contains("of the sources sources; this program is built from others"));
    }

    #[test]
    fn a_kept_run_with_digests_of_its_own_is_found_by_running_all_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trials.jsonl");
        let jobs: Vec<u64> = (0..50).collect();
        squares(&path, "key", &jobs).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let mut lines = text.lines();
        let header = lines.next().unwrap();
        let runs = lines.map(|line| line.split_once("\"run\":").unwrap().1.trim_end_matches('}'));
        let forged = runs.map(|run| if run == "[33,1089]" { "[33,0]" } else { run });
        std::fs::write(&path, chained(header, forged).0).unwrap();
        let mut store = TrialStore::<[u64; 2]>::open(path, basis("key"), Repeat::All).unwrap();
        assert_eq!(store.count(), 0);
        let again = store.complete(&jobs, |job, run| run[0] == *job, |job| [*job, job * job]);
        let error = again.unwrap_err().to_string();
        assert!(error.contains("comes out otherwise"), "{error}");
    }

    #[test]
    fn of_kept_runs_one_in_twenty_is_run_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trials.jsonl");
        let jobs: Vec<u64> = (0..100).collect();
        squares(&path, "key", &jobs).unwrap();
        let store = TrialStore::<[u64; 2]>::open(path, basis("key"), Repeat::Sample).unwrap();
        assert_eq!(jobs.len() - store.count(), 5);
    }
}
