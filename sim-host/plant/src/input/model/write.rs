//! The text of a model file.

use super::{Comments, EffectComments, KnownEffect, ModelEffect, ModelFile, Scope};
use crate::effects::Action;
use crate::effects::formula::{CustomParameter, CustomRole, Formula};
use crate::effects::table::Places;
use crate::input::posterior::{MeasuredNumber, Posterior};
use crate::input::{FileKind, InputError, Source, folder_of, toml_string, write_atomically};
use std::fmt::Write;
use std::path::{Component, Path};

impl ModelFile {
    /// The text of this model for a file in `folder`, from which the paths in it lead.
    pub fn to_toml(&self, folder: &Path, comments: &Comments) -> String {
        let mut text = String::new();
        comment(&mut text, &comments.file);
        line(&mut text, "schema", toml_string(FileKind::Model.schema()));
        line(&mut text, "robot", toml_string(&from_folder(folder, &self.robot_path)));
        if let Some(process) = &self.process_path {
            line(&mut text, "process", toml_string(&from_folder(folder, process)));
        }
        let none = EffectComments::default();
        for (i, model_effect) in self.effects.iter().enumerate() {
            text.push('\n');
            self.write_effect(&mut text, model_effect, comments.effects.get(i).unwrap_or(&none));
        }
        for known in &self.known {
            text.push('\n');
            self.write_known(&mut text, known);
        }
        self.write_accuracy(&mut text);
        if let Some(posterior) = &self.posterior {
            text.push('\n');
            self.write_posterior(&mut text, posterior, &comments.posterior);
            line(&mut text, "sha256", toml_string(&posterior.seal));
        }
        text
    }

    /// The table but for its seal.
    pub(super) fn write_posterior(&self, text: &mut String, of: &Posterior, said: &str) {
        comment(text, said);
        text.push_str("[posterior]\n");
        let mut texts = |key: &str, list: &mut dyn Iterator<Item = String>| {
            let list: Vec<String> = list.map(|one| toml_string(&one)).collect();
            if !list.is_empty() {
                line(text, key, rows(&list));
            }
        };
        texts("logs", &mut of.logs.iter().cloned());
        texts("names", &mut of.numbers.iter().map(|n| n.key()));
        let at = |n: &MeasuredNumber| n.at.name(&self.robot).to_owned();
        texts("at", &mut of.numbers.iter().map(at));
        texts("at_bound", &mut of.at_bound.iter().cloned());
        texts("undetermined", &mut of.undetermined.iter().cloned());
        texts("not_measured", &mut of.not_measured.iter().cloned());
        let numbers =
            |list: &mut dyn Iterator<Item = f64>| rows(&list.map(number).collect::<Vec<_>>());
        line(text, "values", numbers(&mut of.numbers.iter().map(|n| n.value)));
        line(text, "between_logs", numbers(&mut of.numbers.iter().map(|n| n.between_logs)));
        line(text, "covariance", numbers(&mut of.covariance.iter().copied()));
        line(text, "score", number(of.score));
        line(text, "campaign_sha256", toml_string(&of.campaign));
    }

    pub(super) fn write_known(&self, text: &mut String, known: &KnownEffect) {
        text.push_str("[[known]]\n");
        line(text, "id", toml_string(known.kind.id));
        if let Some(at) = known.at {
            line(text, "at", toml_string(at.name(&self.robot)));
        }
        let deviations = known.kind.parameters.iter().zip(&known.deviation);
        let open: Vec<String> = deviations
            .filter(|(_, deviation)| **deviation > 0.0)
            .map(|(parameter, deviation)| format!("{} = {}", parameter.name, number(*deviation)))
            .collect();
        if !open.is_empty() {
            line(text, "deviation", format!("{{ {} }}", open.join(", ")));
        }
    }

    /// Nothing where any error that is seen counts.
    pub(super) fn write_accuracy(&self, text: &mut String) {
        for (k, (key, value)) in self.accuracy.entries().enumerate() {
            text.push_str(if k == 0 { "\n[accuracy]\n" } else { "" });
            line(text, key, number(value));
        }
    }

    pub(super) fn write_effect(
        &self,
        text: &mut String,
        ModelEffect { effect, scope }: &ModelEffect,
        comments: &EffectComments,
    ) {
        comment(text, &comments.effect);
        text.push_str("[[effect]]\n");
        line(text, "id", toml_string(effect.kind.id));
        let at = effect.at.name(&self.robot);
        if !at.is_empty() {
            line(text, "at", toml_string(at));
        }
        if *scope == Scope::Log {
            line(text, "scope", toml_string("log"));
        }
        let said = |i: usize| comments.parameters.get(i).map_or("", String::as_str);
        let Action::Expression(Formula { definition, .. }) = effect.kind.action else {
            for (i, (parameter, value)) in
                effect.kind.parameters.iter().zip(&effect.values).enumerate()
            {
                comment(text, said(i));
                line(text, parameter.name, number(*value));
            }
            return;
        };
        line(text, "port", toml_string(definition.port.name));
        line(text, "unit", toml_string(definition.port.unit));
        line(text, "expression", toml_string(&definition.expression));
        line(text, "shows", toml_string(&definition.shows));
        let named = definition.named();
        if let Some(table) = &definition.table {
            let (of, values) =
                (&definition.parameters[named.len()..], &effect.values[named.len()..]);
            let list =
                |numbers: &[f64]| rows(&numbers.iter().map(|v| number(*v)).collect::<Vec<_>>());
            text.push_str("\n[effect.table]\n");
            for (i, parameter) in of.iter().enumerate() {
                let said = said(named.len() + i);
                if !said.is_empty() {
                    comment(text, &format!("{}: {said}", parameter.name));
                }
            }
            let Places { x, across } = &table.places;
            line(text, "x", list(x));
            if !across.is_empty() {
                line(text, "across", list(across));
            }
            line(text, "y", list(values));
            if table.bend.is_finite() {
                line(text, "bend", number(table.bend));
            }
            if let [CustomParameter { role: CustomRole::Size(step), low, high, .. }, ..] = of {
                line(text, "step", number(*step));
                line(text, "low", number(*low));
                line(text, "high", number(*high));
            }
        }
        for (i, (parameter, value)) in named.iter().zip(&effect.values).enumerate() {
            let _ = writeln!(text, "\n[effect.parameters.{}]", parameter.name);
            comment(text, said(i));
            line(text, "value", number(*value));
            line(text, "unit", toml_string(&parameter.unit));
            line(text, "meaning", toml_string(&parameter.meaning));
            line(text, "low", number(parameter.low));
            line(text, "high", number(parameter.high));
            match &parameter.role {
                CustomRole::Size(step) => line(text, "step", number(*step)),
                CustomRole::Shape(starts) => line(text, "shape", format!("{starts:?}")),
                CustomRole::Position(step, starts) => {
                    line(text, "step", number(*step));
                    line(text, "shape", format!("{starts:?}"));
                }
            }
        }
    }

    /// Writes this model to a file; its paths lead from there to the same robot and process.
    ///
    /// # Errors
    /// What a reader of the file would refuse (nothing is written then), or the operating system's.
    pub fn write(&self, path: impl AsRef<Path>, comments: &Comments) -> Result<(), InputError> {
        let path = path.as_ref();
        let text = self.to_toml(folder_of(path), comments);
        Self::parse(&text, path)?;
        write_atomically(path, text.as_bytes()).map_err(|error| {
            let help = "Check that its folder exists and may be written to.";
            Source::new(&path.display().to_string(), "").error_of_file(error.to_string(), help)
        })
    }
}

/// A list, a few entries a line.
fn rows(list: &[String]) -> String {
    if list.len() <= 4 {
        return format!("[{}]", list.join(", "));
    }
    let lines: Vec<String> = list.chunks(6).map(|row| format!("  {},\n", row.join(", "))).collect();
    format!("[\n{}]", lines.concat())
}

fn line(text: &mut String, key: &str, value: String) {
    let _ = writeln!(text, "{key} = {value}");
}

/// A number as TOML writes it, to the last bit.
fn number(value: f64) -> String {
    format!("{value:?}").to_lowercase()
}

/// A comment, line by line, without what TOML does not allow there.
fn comment(text: &mut String, said: &str) {
    for one in said.lines() {
        let plain: String = one.chars().filter(|c| !c.is_control()).collect();
        let _ = writeln!(text, "# {}", plain.trim());
    }
}

/// The path that leads from a folder to a file; from the root where the two share nothing.
fn from_folder(folder: &Path, file: &Path) -> String {
    let absolute = |path: &Path| path.canonicalize().or_else(|_| std::path::absolute(path));
    let (Ok(from), Ok(to)) = (absolute(folder), absolute(file)) else {
        return file.display().to_string();
    };
    let shared = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    if from.components().next() != to.components().next() {
        return to.display().to_string();
    }
    let up = from.components().skip(shared).map(|_| Component::ParentDir);
    let path: Vec<_> = up
        .chain(to.components().skip(shared))
        .map(|c| c.as_os_str().to_string_lossy().into_owned())
        .collect();
    path.join("/")
}
