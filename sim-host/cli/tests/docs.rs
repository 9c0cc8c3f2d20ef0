//! The commands in README.md and docs/ run, and the figures shown are those printed.
//!
//! * In a code block, a line that begins with `trueweld ` or `cargo ` is a command and must
//!   succeed, or end with N where `# status N` is behind it. Lines after it in the same block are
//!   its output: they must be printed in this order; `…` stands for output left out. Spaces and
//!   line breaks do not matter.
//! * `<!-- figures: COMMAND`, lines of `TEXT = POINTER, … * FACTOR`, `-->`: TEXT must stand in the
//!   section above, and its numbers, in order, must be the values at the pointers in the command's
//!   JSON, times FACTOR.
//! * A number shown may differ from the computed one by half a unit of its last digit.
//! * `<!-- long -->` before a block, `<!-- long figures: …`: only run by docs/check-long.sh.
//!
//! `trueweld …` and `cargo run --release -- …` run the program under test, beside a copy of
//! fixtures/. Any other cargo command runs in the repository and must be marked as long. A build
//! without recordings leaves out `--rrd` and `--exaggeration`; one without Parquet writes CSV.

use crate::support::{assert_results_valid, assert_valid};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A command of a page, and what the page says of it.
#[derive(Debug, Default)]
struct Step {
    long: bool,
    command: String,
    /// The status with which it must end.
    status: i32,
    /// Lines of output shown.
    shown: Vec<String>,
    figures: Vec<Figure>,
    /// The section above the figures.
    section: String,
}

/// Text of a page whose numbers are values of a command's JSON, times a factor.
#[derive(Debug, PartialEq)]
struct Figure {
    text: String,
    pointers: Vec<String>,
    factor: f64,
}

impl Figure {
    /// From a line of the comment.
    fn new(line: &str) -> Self {
        let (text, source) = line.split_once(" = ").expect("TEXT = POINTER");
        let (pointers, factor) = source.split_once(" * ").unwrap_or((source, "1"));
        Self {
            text: text.trim().to_owned(),
            pointers: pointers.split(", ").map(|p| p.trim().to_owned()).collect(),
            factor: factor.trim().parse().expect("factor"),
        }
    }

    /// What is wrong with it, if anything.
    fn wrong(&self, section: &str, json: &Value) -> Option<String> {
        let shown: Vec<Token> =
            tokens(&self.text).into_iter().filter(|t| matches!(t, Token::Number(..))).collect();
        let value = |pointer: &String| Some(json.pointer(pointer)?.as_f64()? * self.factor);
        let values: Vec<Option<f64>> = self.pointers.iter().map(value).collect();
        let shows = |(shown, value): (&Token, &Option<f64>)| {
            value.is_some_and(|value| shown.shows(&Token::Number(value, 0.0)))
        };
        let stands = section.contains(&self.text);
        let right = shown.len() == values.len() && shown.iter().zip(&values).all(shows);
        (!stands || !right).then(|| {
            format!("\"{}\": computed {values:?}; in the section above: {stands}", self.text)
        })
    }
}

/// The steps of a page, in order.
fn steps(page: &str) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    let (mut section, mut long, mut fenced, mut open) = (String::new(), false, false, false);
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let comment = line.strip_prefix("<!-- ");
        let marked = comment.and_then(|c| c.strip_prefix("long ")).or(comment);
        if let Some(command) = marked.and_then(|m| m.strip_prefix("figures: ")) {
            steps.push(Step {
                long: marked != comment,
                command: command.to_owned(),
                figures: lines.by_ref().take_while(|l| *l != "-->").map(Figure::new).collect(),
                section: section.clone(),
                ..Step::default()
            });
            continue;
        }
        if line.starts_with("```") {
            (fenced, open) = (!fenced, false);
        }
        if !fenced && !line.starts_with("    ") {
            match line {
                "<!-- long -->" => long = true,
                "" => {}
                _ => (long, open) = (false, false),
            }
            if line.starts_with('#') {
                section.clear();
            }
        } else if let Some(command) = ["cargo ", "trueweld "]
            .iter()
            .find_map(|p| line.trim().strip_prefix(p).map(|_| line.trim()))
        {
            let (command, remark) = command.split_once(" # ").unwrap_or((command, ""));
            let status =
                remark.trim().strip_prefix("status ").map_or(0, |s| s.parse().expect("status"));
            steps.push(Step {
                long,
                command: command.trim().to_owned(),
                status,
                ..Step::default()
            });
            open = true;
        } else if open && let Some(step) = steps.last_mut() {
            step.shown.push(line.to_owned());
        }
        section += line;
        section.push('\n');
    }
    steps
}

/// What a comparison sees of a text: words, and numbers with half a unit of their last digit.
#[derive(Debug, PartialEq)]
enum Token {
    Word(String),
    Number(f64, f64),
}

impl Token {
    /// Whether a page may show this where `printed` was computed.
    fn shows(&self, printed: &Self) -> bool {
        match (self, printed) {
            (Self::Number(shown, half), Self::Number(value, _)) => {
                (shown - value).abs() <= half * (1.0 + 1e-6)
            }
            (Self::Word(shown), Self::Word(word)) => shown == word,
            _ => false,
        }
    }
}

fn tokens(text: &str) -> Vec<Token> {
    let mut tokens = Vec::new();
    let text: Vec<char> = text.replace('−', "-").chars().collect();
    let mut at = 0;
    while at < text.len() {
        let start = at;
        let numeral = |c: &char| c.is_ascii_digit() || *c == '.';
        let sign = text[at] == '-' && !(at > 0 && text[at - 1].is_alphanumeric());
        let first = at + usize::from(sign);
        if text.get(first).is_some_and(char::is_ascii_digit) {
            at = first + text[first..].iter().take_while(|c| numeral(c)).count();
            while text[at - 1] == '.' {
                at -= 1;
            }
            let number: String = text[start..at].iter().collect();
            if let Ok(value) = number.parse() {
                let decimals = number.split_once('.').map_or(0, |(_, d)| d.len() as i32);
                tokens.push(Token::Number(value, 0.5 * 10f64.powi(-decimals)));
                continue;
            }
            tokens.push(Token::Word(number));
        } else if text[at].is_alphabetic() {
            at += text[at..].iter().take_while(|c| c.is_alphabetic()).count();
            tokens.push(Token::Word(text[start..at].iter().collect()));
        } else {
            at += 1;
            if !text[start].is_whitespace() {
                tokens.push(Token::Word(text[start].to_string()));
            }
        }
    }
    tokens
}

/// The first part of what is shown that was not printed.
fn missing(shown: &str, printed: &str) -> Option<String> {
    let printed = tokens(printed);
    let mut at = 0;
    for part in shown.split('…') {
        let wanted = tokens(part);
        let found = (at..=printed.len().saturating_sub(wanted.len()))
            .find(|&i| wanted.iter().zip(&printed[i..]).all(|(shown, p)| shown.shows(p)))
            .filter(|_| wanted.len() <= printed.len());
        match found {
            Some(i) => at = i + wanted.len(),
            None => return Some(part.to_owned()),
        }
    }
    None
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if from.is_dir() { copy(&from, &to) } else { fs::copy(from, to).map(|_| ()).unwrap() }
    }
}

/// Runs a step in `folder`; what is wrong with it.
fn problems(step: &Step, folder: &Path) -> Vec<String> {
    let json = folder.join("figures.json");
    let arguments = match step.command.as_str() {
        "cargo run --release" => Some(""),
        other => {
            ["cargo run --release -- ", "trueweld "].iter().find_map(|p| other.strip_prefix(p))
        }
    };
    let mut command = match arguments {
        Some(arguments) => {
            let mut command = Command::new(env!("CARGO_BIN_EXE_trueweld"));
            // A recording's options and their values, which a build without recordings lacks.
            let mut value_of_recording = false;
            let recording = |argument: &&str| {
                let option = ["--rrd", "--exaggeration"].contains(argument);
                let kept = cfg!(feature = "rerun") || !(option || value_of_recording);
                value_of_recording = option;
                kept
            };
            // The same table in a form that every build has.
            let table = |argument: &str| match cfg!(feature = "parquet") {
                true => argument.to_owned(),
                false => argument.replace(".parquet", ".csv"),
            };
            let arguments = arguments.split_whitespace().filter(recording).map(table);
            command.args(arguments).current_dir(folder);
            if !step.figures.is_empty() {
                command.arg("--json").arg(&json);
            }
            command
        }
        None if step.long => {
            let mut command = Command::new("sh");
            command.arg("-c").arg(&step.command).current_dir(repository());
            command
        }
        None => return vec!["not run: mark it as long".to_owned()],
    };
    let output = command.output().unwrap();
    let printed = String::from_utf8_lossy(&output.stdout);
    if output.status.code() != Some(step.status) {
        return vec![format!(
            "{}\n{printed}{}",
            output.status,
            String::from_utf8_lossy(&output.stderr)
        )];
    }
    if let Some(arguments) = arguments {
        let arguments: Vec<&str> = arguments.split_whitespace().collect();
        assert_results_valid(&arguments, folder, &output);
    }
    if !step.figures.is_empty() {
        assert_valid(&fs::read(&json).unwrap());
        let values: Value = serde_json::from_slice(&fs::read(&json).unwrap()).unwrap();
        return step.figures.iter().filter_map(|f| f.wrong(&step.section, &values)).collect();
    }
    let shown = step.shown.join("\n");
    let shown = if cfg!(feature = "parquet") { shown } else { shown.replace(".parquet", ".csv") };
    let part = missing(&shown, &printed);
    part.map(|part| format!("not printed:\n{part}\nprinted:\n{printed}")).into_iter().collect()
}

/// Runs the steps of every page, pages beside each other.
fn check_pages(long: bool) {
    let mut pages: Vec<PathBuf> = fs::read_dir(repository().join("docs"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .collect();
    pages.push(repository().join("README.md"));
    let check = |page: &PathBuf| {
        let name = page.file_name().unwrap().to_string_lossy().into_owned();
        let folder = tempfile::tempdir().unwrap();
        copy(&repository().join("fixtures"), &folder.path().join("fixtures"));
        fs::create_dir(folder.path().join("out")).unwrap();
        steps(&fs::read_to_string(page).unwrap())
            .iter()
            .filter(|step| long || !step.long)
            .flat_map(|step| {
                let found = problems(step, folder.path()).into_iter();
                found.map(|p| format!("{name}: {}\n{p}\n", step.command)).collect::<Vec<_>>()
            })
            .collect::<Vec<_>>()
    };
    let problems: Vec<String> = std::thread::scope(|scope| {
        let threads: Vec<_> = pages.iter().map(|page| scope.spawn(move || check(page))).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn every_command_in_the_docs_runs_and_prints_what_is_shown() {
    check_pages(false);
}

#[test]
#[ignore = "long: docs/check-long.sh"]
fn every_long_command_in_the_docs_runs_and_prints_what_is_shown() {
    check_pages(true);
}

/// The pages' `cargo run --release` is the program under test here; for a reader it is what cargo
/// takes it for, which is the one package that says so.
#[test]
fn cargo_runs_the_program_and_nothing_else() {
    let manifest = |folder: &str| -> toml::Table {
        let text = fs::read_to_string(repository().join(folder).join("Cargo.toml"));
        text.expect("a manifest").parse().expect("TOML")
    };
    let workspace = manifest(".");
    let members = workspace["workspace"]["default-members"].as_array().expect("members");
    let runs = |folder: &str| -> Option<String> {
        Some(manifest(folder)["package"].get("default-run")?.as_str()?.to_owned())
    };
    let run: Vec<String> = members.iter().filter_map(|m| runs(m.as_str()?)).collect();
    assert_eq!(run, ["trueweld"]);
}

#[test]
fn a_stale_figure_is_found() {
    let printed = "lateral, mm   4.226\nlongitudinal, mm  -2.553  (95 %)";
    assert_eq!(missing("lateral, mm 4.226 … -2.55 (95 %)", printed), None);
    assert!(missing("lateral, mm 4.22", printed).is_some());
    assert!(missing("longitudinal … lateral", printed).is_some());
    let json = serde_json::json!({ "time": 0.3838, "share": 0.04 });
    let wrong = |line: &str, page: &str| Figure::new(line).wrong(page, &json).is_some();
    assert!(!wrong("384 ms = /time * 1e3", "settles in 384 ms."));
    assert!(wrong("385 ms = /time * 1e3", "settles in 385 ms."));
    assert!(wrong("384 ms = /time * 1e3", "settles in 380 ms."));
    assert!(wrong("384 ms = /absent * 1e3", "settles in 384 ms."));
    assert!(!wrong("| 0.38 | 0.04 | = /time, /share", "| 0.38 | 0.04 |"));
    assert!(wrong("| 0.38 | 0.05 | = /time, /share", "| 0.38 | 0.05 |"));
}

#[test]
fn commands_output_and_figures_are_found_in_a_page() {
    let page = "# Title\n\n    trueweld weld  # the first\n    lateral 1.0\n\n<!-- long -->\n\n```\n\
                cargo bench\n```\nis 2 mm off.\n\n<!-- figures: trueweld weld\n2 mm = /a * 1e3\n-->\n";
    let [weld, bench, figures] = &steps(page)[..] else { panic!("{:?}", steps(page)) };
    assert_eq!((weld.command.as_str(), weld.long), ("trueweld weld", false));
    assert_eq!(weld.shown, ["    lateral 1.0"]);
    assert_eq!((bench.command.as_str(), bench.long), ("cargo bench", true));
    assert_eq!(figures.figures, [Figure::new("2 mm = /a * 1e3")]);
    assert!(figures.section.contains("is 2 mm off."));
}
