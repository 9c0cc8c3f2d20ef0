//! How far a weld can be driven.

use crate::StudyLimitsReport;
use crate::color;
use crate::document::{
    Block, Document, Map, Medium, Picture, Plot, PlotLine, Table, number, reference, words,
};
use crate::json::study::limits::StudyLimitsResult;
use crate::report::{PublishedResult, Report};
use crate::text::fixed;
use crate::text::study::layout::PLACEMENT_NUMBERS;
use crate::text::study::limits::{because, headline, largest, name, notices, setting, unit};
use crate::text::study::sensitivity::capital;
use trueweld_evaluate::study::{Driven, FoundLimit, Placement, numbers};

impl Report for StudyLimitsReport<'_> {
    const SCHEMA: &'static str = "study-limits/1";

    fn json(&self) -> impl PublishedResult {
        StudyLimitsResult::of(self)
    }

    fn document(&self) -> Document {
        let mut document = Document::new("Limits", headline(self), self.provenance);
        document.push(Block::Note(setting(self)));
        document.push(Block::List(notices(self)));
        document.push(Block::Table(self.own()));
        document.push_on(Medium::Page, Block::Figures(self.curves()));
        document.push_on(Medium::Page, Block::Maps(self.maps()));
        if self.places.len() > 1 {
            document.table("Place by place", self.by_place());
        }
        document
    }
}

impl StudyLimitsReport<'_> {
    /// The limits at the weld's own place.
    fn own(&self) -> Table {
        let rows = self.places.first().into_iter().flat_map(|place| {
            place.limits.iter().map(|found| {
                vec![
                    words(name(found.driven)),
                    number(unit(found.driven).quantity(found.nominal)),
                    number(largest(found)).bad(found.largest.is_none()),
                    words(because(found)),
                ]
            })
        });
        let head = [words(""), number("weld"), number("largest"), words("limited by")];
        Table { head: vec![head.to_vec()], rows: rows.collect() }
    }

    fn by_place(&self) -> Table {
        let rows = self.places.iter().map(|place| {
            let at = numbers(&place.at);
            let cells = at.iter().take(3).map(|v| number(fixed(*v, 2)));
            cells.chain(place.limits.iter().map(|found| number(largest(found)))).collect()
        });
        let head = PLACEMENT_NUMBERS
            .iter()
            .take(3)
            .map(|(name, unit, _)| number(format!("{name}, {unit}")));
        let driven = self.places.first().map_or(&[][..], |place| &place.limits);
        let head = head.chain(driven.iter().map(|found| number(name(found.driven))));
        Table { head: vec![head.collect()], rows: rows.collect() }
    }

    /// The largest share of any limit over what is driven.
    fn curves(&self) -> Vec<Picture> {
        let Some(place) = self.places.first() else { return Vec::new() };
        place.limits.iter().map(share_over_driven).collect()
    }

    /// Maps of the largest values over the places.
    fn maps(&self) -> Vec<Map> {
        let [xs, zs] = [0, 2].map(|k| {
            let mut all: Vec<f64> = self.places[1.min(self.places.len())..]
                .iter()
                .map(|place| numbers(&place.at)[k])
                .collect();
            all.sort_by(f64::total_cmp);
            all.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
            all
        });
        if xs.len() < 2 || zs.len() < 2 {
            return Vec::new();
        }
        let driven = self.places.first().map_or(&[][..], |place| &place.limits);
        driven.iter().map(|found| self.map(found.driven, &xs, &zs)).collect()
    }

    /// The largest value of what is driven over the grid of places.
    fn map(&self, driven: Driven, xs: &[f64], zs: &[f64]) -> Map {
        let value = |x: f64, z: f64| {
            let is_there = |at: &Placement| (at.x_m - x).abs() < 1e-9 && (at.z_m - z).abs() < 1e-9;
            let place = self.places[1..].iter().find(|place| is_there(&place.at))?;
            let found = place.limits.iter().find(|found| found.driven == driven)?;
            Some(found.largest? * unit(driven).factor)
        };
        let row = |z: &f64| xs.iter().map(|x| value(*x, *z)).collect();
        Map {
            title: format!("Largest {}", unit(driven).named(name(driven))),
            x_label: "x, m".to_owned(),
            y_label: "z, m".to_owned(),
            xs: xs.to_vec(),
            ys: zs.to_vec(),
            values: zs.iter().map(row).collect(),
            allowed: None,
            marks: Vec::new(),
        }
    }
}

/// The largest share of any limit over one quantity that is driven.
fn share_over_driven(found: &FoundLimit) -> Picture {
    let unit = unit(found.driven);
    // A run without figures breaks the line.
    let point = |probe: &trueweld_evaluate::study::LimitProbe| {
        let share = if probe.share.is_finite() { probe.share } else { f64::NAN };
        (probe.value * unit.factor, 100.0 * share)
    };
    let points: Vec<(f64, f64)> = found.probes.iter().map(point).collect();
    let ends = [points.first(), points.last()].map(|p| p.map_or(0.0, |p| p.0));
    let allowed = reference("allowed", ends.map(|x| (x, 100.0)).into());
    let lines = vec![PlotLine::new("", color::run(1), points), allowed];
    let x_label = unit.named(name(found.driven));
    let plot = Plot {
        named: true,
        logarithmic: true,
        ..Plot::new(x_label, "largest share of a limit, %", lines)
    };
    Picture::new(format!("{}: {}", capital(name(found.driven)), largest(found)), plot)
}
