//! Units of one type beside each other: what they share, how far they spread, which is an outlier.

use super::{PublishedResult, Report};
use crate::ImproveFleetReport;
use crate::document::{
    Block, Column, Document, Marked, Picture, Plot, Table, TableCell, Tone, number, reference,
    words,
};
use crate::json::improve_fleet::ImproveFleetResult;
use crate::text::diagnose::{INCOMPLETE_HEADING, incomplete, spoken};
use crate::text::error::channel;
use crate::text::improve_fleet::{headline, of_type, remark, setting, some_have, with_interval};
use crate::text::{Scale, score};
use trueweld_diagnose::fleet::{FleetEffect, FleetParameter};
use trueweld_estimate::residuals::error::ChannelError;
use trueweld_logs::HALF_95;
use trueweld_plant::effects::Parameter;

/// A row of the table of values: of the type, or of one of its units.
struct FleetRow<'a> {
    of: &'a FleetEffect,
    parameter: usize,
    unit: Option<usize>,
}

impl<'a> FleetRow<'a> {
    fn kind(&self) -> &'static Parameter {
        &self.of.effect.kind.parameters[self.parameter]
    }

    fn over(&self) -> &'a FleetParameter {
        &self.of.parameters[self.parameter]
    }
}

impl Report for ImproveFleetReport<'_> {
    const SCHEMA: &'static str = "improve-fleet/1";

    fn json(&self) -> impl PublishedResult {
        ImproveFleetResult::of(self)
    }

    fn document(&self) -> Document {
        let fleet = self.fleet;
        let mut document = Document::new("Improve a fleet", headline(self), self.provenance);
        let apart = fleet.effects.iter().filter(|effect| !effect.is_shared());
        document
            .list("Effects that not all units have", apart.map(|e| some_have(e, self)).collect());
        document.table("Effects", self.values(&fleet.effects));
        document.table("Calibrations", self.values(&fleet.calibrations));
        let all = fleet.effects.iter().chain(&fleet.calibrations);
        document.figures(
            "Each unit with its 95 % interval beside the type",
            all.flat_map(|of| self.pictures(of)).collect(),
        );
        document.table("RMS errors where nothing was fitted, as given → improved", self.errors());
        let told = self.units.iter();
        let told = told.map(|(name, of)| format!("{name}: {} {}", of.headline(), of.out.display()));
        let left_out = self.units.iter().flat_map(|(name, of)| {
            let left_out = incomplete(&of.improvement.incomplete, self.robot());
            left_out.into_iter().map(move |what| format!("{name}: {what}"))
        });
        document.list(INCOMPLETE_HEADING, left_out.collect());
        document.list("Each unit alone, and its improved model", told.collect());
        let notes = self.units.iter().flat_map(|(name, of)| {
            let notes = crate::text::compare::notes(of.notices);
            notes.into_iter().map(move |note| format!("{name}: {note}"))
        });
        document.push(Block::List(notes.collect()));
        document.push(Block::Note(setting(self)));
        document
    }
}

impl ImproveFleetReport<'_> {
    /// Every parameter: the type, then each unit.
    fn values(&self, effects: &[FleetEffect]) -> Table {
        let rows = effects.iter().flat_map(|of| {
            let units = || std::iter::once(None).chain((0..self.units.len()).map(Some));
            let told = |k: &usize| of.parameters[*k].units.iter().any(Option::is_some);
            let parameters = (0..of.parameters.len()).filter(told);
            parameters.flat_map(move |parameter| {
                units().map(move |unit| FleetRow { of, parameter, unit })
            })
        });
        let name = |row: &FleetRow<'_>| {
            format!("{}, {}", row.of.effect.name(self.robot()), spoken(row.kind()))
        };
        let columns: [Column<'_, FleetRow<'_>>; 4] = [
            (words(""), &|row| match row.unit {
                None => words(name(row)).tone(Tone::Strong),
                Some(unit) => words(self.units[unit].0),
            }),
            (number("mean of the type, value of a unit, 95 %"), &|row| {
                number(match row.unit {
                    None => of_type(row.kind(), row.over())[0].clone(),
                    Some(unit) => row.over().units[unit]
                        .map_or("–".to_owned(), |own| with_interval(row.kind(), &own)),
                })
            }),
            (number("spread, 95 %"), &|row| match row.unit {
                None => number(of_type(row.kind(), row.over())[1].clone()),
                Some(_) => number(""),
            }),
            (words(""), &|row| {
                words(row.unit.map_or(String::new(), |unit| remark(row.of, row.over(), unit)))
            }),
        ];
        Table::of(rows, &columns)
    }

    /// Each unit's value beside the mean of the type and its spread.
    fn pictures(&self, of: &FleetEffect) -> Vec<Picture> {
        let parameters = of.effect.kind.parameters.iter().zip(&of.parameters);
        let drawn = parameters.filter(|(_, of)| of.fleet.is_some());
        drawn.map(|(kind, over)| self.picture(of, kind, over)).collect()
    }

    fn picture(&self, of: &FleetEffect, kind: &Parameter, over: &FleetParameter) -> Picture {
        let scale = Scale::of_parameter(kind);
        let units = over.units.iter().enumerate();
        let marked = units.filter_map(|(k, value)| {
            let own = (*value)?;
            let error = HALF_95 * own.deviation * scale.factor;
            Some(Marked { x: k as f64, y: own.value * scale.factor, error })
        });
        let marked: Vec<Marked> = marked.collect();
        let band = over
            .fleet
            .map(|of| [of.mean - of.spread, of.mean + of.spread].map(|end| end * scale.factor));
        // The intervals whole.
        let shown = marked.iter().flat_map(|m| [m.y - m.error, m.y + m.error]);
        let shown = shown.chain(band.into_iter().flatten());
        let [low, high] = shown
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], y| [low.min(y), high.max(y)]);
        let ends = [-0.5, self.units.len() as f64 - 0.5];
        let level = |value: f64| ends.map(|x| (x, value * scale.factor)).into();
        let plot = Plot {
            y_label: scale.named(&spoken(kind)),
            lines: over.fleet.iter().map(|of| reference("mean", level(of.mean))).collect(),
            band,
            band_name: "mean ± spread between units".into(),
            y_range: (low < high).then_some([low, high]),
            marked,
            marked_name: "unit, 95 %",
            categories: self.units.iter().map(|(name, _)| (*name).to_owned()).collect(),
            ..Plot::default()
        };
        Picture::new(format!("{}, {}", of.effect.name(self.robot()), spoken(kind)), plot)
    }

    /// Score and errors of each unit, before and after.
    fn errors(&self) -> Table {
        let Some((_, first)) = self.units.first() else { return Table::default() };
        let channels = &first.improvement.first().errors;
        let rows = self.units.iter().map(|(name, of)| {
            let (before, after) = (of.improvement.first(), of.improvement.last());
            let scores = format!("{} → {}", score(before.held_out), score(after.held_out));
            let errors = channels.iter().map(|of| {
                let rmse = |errors: &[ChannelError]| {
                    let same = |e: &&ChannelError| (e.channel, e.ripple) == (of.channel, of.ripple);
                    errors.iter().find(same).map(|e| e.rmse)
                };
                let scale = Scale::small(of.unit);
                match (rmse(&before.errors), rmse(&after.errors)) {
                    (Some(a), Some(b)) => {
                        number(format!("{} → {}", scale.number(a), scale.quantity(b)))
                    }
                    _ => number(""),
                }
            });
            [words(*name), number(scores)].into_iter().chain(errors).collect::<Vec<TableCell>>()
        });
        let head = [words(""), number("score")].into_iter();
        let head = head.chain(channels.iter().map(|e| number(channel(e)))).collect();
        Table { head: vec![head], rows: rows.collect() }
    }
}
