//! A folder in which the program runs as a user runs it.

// Each test file uses its part of it.
#![allow(dead_code, unreachable_pub)]

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A folder with short welds; commands run in it.
pub struct Workspace(TempDir);

/// The repository's fixtures.
pub fn fixture(name: &str) -> String {
    format!("{}/../../fixtures/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// Requirements with one limit, on how far the tool may leave its line, m; drawn is what few welds
/// show.
pub fn requirements(failure_probability: f64, confidence: f64, lateral_max: f64) -> String {
    format!(
        "schema = \"requirements/1\"
failure_probability = {failure_probability}
confidence = {confidence}
[limits]
lateral_max_m = {lateral_max}
[uncertainty]
stiffness = 0.3
process = 0.3
ripple = 0.5
crosstalk = 0.02
delay_periods = [1.0, 2.0]
"
    )
}

impl Workspace {
    pub fn new() -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        place.weld("short.toml", "[1.700, -1.000, 0.500]", "[1.700, -0.940, 0.500]");
        place
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// A fixture under another name, where `change` gives for key and line what stands in the line's
    /// place; the line itself where it gives none.
    fn changed(&self, from: &str, name: &str, change: impl Fn(&str, &str) -> Option<String>) {
        let text = fs::read_to_string(fixture(from)).unwrap();
        let line = |line: &str| {
            let key = line.split(" = ").next().unwrap_or_default();
            change(key, line).unwrap_or_else(|| format!("{line}\n"))
        };
        fs::write(self.path().join(name), text.lines().map(line).collect::<String>()).unwrap();
    }

    /// The first weld as published, between other points.
    pub fn weld(&self, name: &str, start: &str, end: &str) {
        self.changed("welds/published-vertical.toml", name, |key, _| match key {
            "start_m" => Some(format!("start_m = {start}\n")),
            "end_m" => Some(format!("end_m = {end}\n")),
            _ => None,
        });
    }

    /// Requirements whose faults are as few and as long as the short weld has room for, with `change`
    /// besides.
    pub fn requirements(&self, change: impl Fn(&str, &str) -> Option<String>) {
        self.changed("requirements/lap-weld.toml", "requirements.toml", |key, line| match key {
            "duration_s" => Some("duration_s = 0.1\n".to_owned()),
            "recovery_s" => Some("recovery_s = 0.5\n".to_owned()),
            // Of faults, at one place of the nominal weld.
            "places" if !line.contains("11") => Some("places = 1\n".to_owned()),
            "draws" if !line.contains('4') => Some(String::new()),
            _ => change(key, line),
        });
    }

    /// Runs the program; every JSON file that it writes must be valid by its published schema.
    pub fn run(&self, arguments: &[&str]) -> Output {
        self.run_with(arguments, &[])
    }

    /// The same with variables of the environment.
    pub fn run_with(&self, arguments: &[&str], environment: &[(&str, &str)]) -> Output {
        let output = Command::new(env!("CARGO_BIN_EXE_trueweld"))
            .args(arguments)
            .envs(environment.iter().copied())
            .current_dir(self.path())
            .output()
            .unwrap();
        assert_results_valid(arguments, self.path(), &output);
        output
    }

    /// Runs what must succeed; its standard output.
    pub fn done(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert!(
            output.status.success(),
            "{arguments:?}\n{}",
            String::from_utf8_lossy(&output.stderr)
        );
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs what must fail with one message and no new file; the message on one line.
    pub fn refused(&self, arguments: &[&str]) -> String {
        let before = self.files();
        let output = self.run(arguments);
        assert!(!output.status.success(), "{arguments:?}");
        assert_eq!(self.files(), before, "{arguments:?}");
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(!text.contains("panicked"), "{text}");
        assert_eq!(text.to_lowercase().matches("error:").count(), 1, "{text}");
        one_line(&text)
    }

    pub fn files(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path().join(name)).unwrap()
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).unwrap()
    }
}

/// Panics where a JSON file that a run has written is not valid by the published schema that it
/// names. What a refused run left there is not its own.
pub fn assert_results_valid(arguments: &[&str], folder: &Path, output: &Output) {
    if !output.status.success() && !output.stderr.is_empty() {
        return;
    }
    let read = |name: &str| fs::read(folder.join(name)).unwrap();
    for pair in arguments.windows(2) {
        match pair {
            ["--json", "-"] => assert_valid(&output.stdout),
            ["--json", name] if !name.starts_with("/dev/") => assert_valid(&read(name)),
            // A shard has no certificate, nor has a study.
            ["--evidence", name]
                if arguments[0] == "certify" && !arguments.contains(&"--shard") =>
            {
                assert_valid(&read(&format!("{name}/certify.json")));
            }
            _ => {}
        }
    }
}

/// Panics where a result is not valid by the published schema that it names.
pub fn assert_valid(result: &[u8]) {
    let result: Value = serde_json::from_slice(result).unwrap();
    let name = result["schema"].as_str().and_then(|s| s.split('/').next()).expect("a schema");
    let file = format!("{}/../../docs/schema/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let schema: Value = serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap();
    jsonschema::validate(&schema, &result).unwrap_or_else(|error| panic!("{name}: {error}"));
}

/// A message on one line: as wide as the terminal, messages are broken into lines.
pub fn one_line(text: &str) -> String {
    text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}
