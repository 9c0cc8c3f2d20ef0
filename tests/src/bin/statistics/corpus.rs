//! The corpus experiment: hides effects in synthetic campaigns, has them diagnosed, and counts the
//! answers.

use clap::Args;
use std::collections::BTreeMap;
use std::fs::{OpenOptions, read_to_string};
use std::io::{ErrorKind, Write as _};
use std::path::PathBuf;
use std::time::Instant;
use trueweld_laboratory::{CorpusCase, Hidden, Protocol};
use trueweld_plant::input::write_atomically;
use trueweld_tests::corpus::{Judged, Tally, examine};
use trueweld_tests::{LABORATORY, outside};

/// Measures how well a diagnosis names what is hidden in synthetic campaigns.
///
/// Appends a line of JSON to OUT for each case; cases already there are not done again.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Seed of the corpus.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of cases.
    #[arg(long, default_value_t = 200)]
    cases: usize,
    /// File of results.
    #[arg(long)]
    out: PathBuf,
    /// File for the tables, as Markdown; printed without it.
    #[arg(long)]
    table: Option<PathBuf>,
    /// Campaigns as short as they can be.
    #[arg(long)]
    short: bool,
    /// The laws outside the library by which discovery is judged, in place of the corpus.
    #[arg(long)]
    outside: bool,
    /// Campaigns in which nothing is missing, though the laboratory errs by more than is expected,
    /// in place of the corpus.
    #[arg(long, conflicts_with = "outside")]
    flawless: bool,
    /// Only the case of this number.
    #[arg(long)]
    only: Option<usize>,
    /// Only cases in which one of these is hidden: an effect, `none`, `two`, or one outside the
    /// library.
    #[arg(long, value_delimiter = ',')]
    hidden: Vec<String>,
    /// Only cases that are to show so many times the limit of detection; those with nothing hidden
    /// all the same.
    #[arg(long)]
    target: Option<f64>,
    /// Every link mounted off by this much besides, m and rad, one standard deviation.
    #[arg(long, default_value_t = 0.0)]
    geometry: f64,
}

impl Arguments {
    fn wants(&self, index: usize, case: &CorpusCase) -> bool {
        let what = case.name.split_once('-').map_or("", |(_, what)| what);
        let nothing = matches!(case.hidden, Hidden::None);
        let two = matches!(case.hidden, Hidden::Two(..));
        let is = |hidden: &String| hidden == what || (two && hidden == "two");
        self.only.is_none_or(|only| only == index)
            && (self.hidden.is_empty() || self.hidden.iter().any(is))
            && self.target.is_none_or(|target| nothing || target == case.target)
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn std::error::Error>> {
    for file in [Some(&arguments.out), arguments.table.as_ref()].into_iter().flatten() {
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder)
                .map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
        }
    }
    let protocol = if arguments.short { Protocol::short() } else { Protocol::usual() };
    let mut cases = match (arguments.outside, arguments.flawless) {
        (true, _) => outside::cases(arguments.seed, arguments.cases, &protocol),
        (_, true) => LABORATORY.flawless(arguments.seed, arguments.cases, &protocol),
        _ => LABORATORY.corpus(arguments.seed, arguments.cases, &protocol),
    };
    cases.iter_mut().for_each(|case| case.recipe.geometry_error = arguments.geometry);
    let written = match read_to_string(&arguments.out) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
        Err(error) => {
            return Err(format!("cannot read {}: {error}", arguments.out.display()).into());
        }
    };
    let mut known: BTreeMap<(String, u64), Judged> = BTreeMap::new();
    for (number, line) in written.lines().enumerate() {
        let judged: Judged = serde_json::from_str(line).map_err(|error| {
            format!(
                "{}:{}: no result of this program: {error}",
                arguments.out.display(),
                number + 1
            )
        })?;
        known.insert((judged.name.clone(), judged.seed), judged);
    }
    let missing: Vec<_> = cases
        .iter()
        .enumerate()
        .filter(|(index, c)| arguments.wants(*index, c))
        .filter(|(_, c)| !known.contains_key(&(c.name.clone(), c.seed)))
        .map(|(_, case)| case)
        .collect();
    let mut file = OpenOptions::new().create(true).append(true).open(&arguments.out)?;
    let start = Instant::now();
    for (done, case) in missing.iter().enumerate() {
        match examine(case) {
            Ok(judged) => {
                // One write for each line, so that no reader meets half of one.
                file.write_all((serde_json::to_string(&judged)? + "\n").as_bytes())?;
                let each = start.elapsed().as_secs_f64() / (done + 1) as f64;
                let left = each * (missing.len() - done - 1) as f64;
                eprintln!(
                    "{}/{} {}: {:?}, {:.0} min left",
                    done + 1,
                    missing.len(),
                    case.name,
                    judged.outcome,
                    left / 60.0
                );
                known.insert((case.name.clone(), case.seed), judged);
            }
            // A campaign that cannot be made is reported and not counted.
            Err(error) => eprintln!("{}/{} {}: {error}", done + 1, missing.len(), case.name),
        }
    }
    let judged = cases.iter().filter_map(|c| known.remove(&(c.name.clone(), c.seed))).collect();
    let table = Tally::new(judged).markdown();
    match &arguments.table {
        Some(path) => write_atomically(path, table.as_bytes())?,
        None => print!("{table}"),
    }
    Ok(())
}
