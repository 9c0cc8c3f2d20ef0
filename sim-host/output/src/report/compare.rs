//! A model against measurements.

use super::error_fall::level;
use super::residuals::{ColumnComparison, map, score_bar};
use super::{PublishedResult, Report};
use crate::CompareReport;
use crate::color::{self, REFERENCE};
use crate::document::{
    Block, Document, Marked, Medium, Picture, Plot, PlotLine, Table, TableCell, Tone, number, words,
};
use crate::json::compare::CompareResult;
use crate::samples::{self, BlockTable};
use crate::text::compare::{TOLD_FINDINGS, headline, notes, setting};
use crate::text::finding::{category, map_title, sentence, x_name, y_name};
use crate::text::{Scale, fixed};
use trueweld_estimate::residuals::compare::{
    ChannelComparison, Comparison, LogComparison, NOISE_FLOOR_SCORE,
};
use trueweld_estimate::residuals::localize::{ConditionBin, Finding, foremost};

/// Findings that are drawn.
const DRAWN_FINDINGS: usize = 6;

impl Report for CompareReport<'_> {
    const SCHEMA: &'static str = "compare/1";

    fn json(&self) -> impl PublishedResult {
        CompareResult::of(self)
    }

    fn samples(&self) -> Option<BlockTable<'_>> {
        Some(samples::of_logs(vec![(["given", "compared"], &self.comparison.logs)]))
    }

    fn document(&self) -> Document {
        let comparison = self.comparison;
        let told = foremost(&comparison.worst, DRAWN_FINDINGS);
        let sentences = told.iter().take(TOLD_FINDINGS).map(|finding| sentence(finding)).collect();
        let mut document = Document::new("Compare", headline(comparison), self.provenance);
        document.push(Block::Note(setting(self.model, comparison)));
        document.push(Block::List(sentences));
        document.push(Block::Table(table(comparison)));
        document.figures(
            "What the difference follows",
            told.iter().map(|finding| finding_figure(finding)).collect(),
        );
        for (finding, over_two) in told.iter().filter_map(|f| Some((f, f.map.as_ref()?))) {
            let table = Block::Table(map(over_two, finding));
            document.section(Medium::Page, &map_title(finding, over_two), table);
        }
        let logs = comparison.logs.iter().flat_map(|log| {
            ColumnComparison::worst_of(log).map_or(Vec::new(), |columns| columns.figures())
        });
        document.figures("Measured and predicted: of every log the worst column", logs.collect());
        document.push(Block::List(notes(&comparison.notices)));
        document
    }
}

/// Every channel of every log.
fn table(comparison: &Comparison) -> Table {
    let channels = || comparison.logs.iter().flat_map(|log| &log.channels);
    let highest = channels().map(|channel| channel.score).fold(2.0, f64::max);
    let asked = channels().any(|channel| channel.accuracy > 0.0);
    let of_log = |log: &LogComparison| {
        let name = words(format!("{}, {}", log.name, log.kind)).tone(Tone::Strong);
        let name = name.over(if asked { 5 } else { 4 });
        vec![name, number(fixed(log.score, 2)).bad(log.score > NOISE_FLOOR_SCORE)]
    };
    let rows = comparison.logs.iter().flat_map(|log| {
        let channels = log.channels.iter().map(|channel| channel_row(channel, highest, asked));
        std::iter::once(of_log(log)).chain(channels)
    });
    let mut head = ["", "RMS", "largest", "noise", "score"].map(number).to_vec();
    if asked {
        head.insert(4, number("accuracy"));
    }
    Table { head: vec![head], rows: rows.collect() }
}

/// `highest`: the score at the end of the bar.
fn channel_row(channel: &ChannelComparison, highest: f64, asked: bool) -> Vec<TableCell> {
    let quantity = |value: f64| Scale::small(channel.unit).quantity(value);
    let sign = if channel.stated { "" } else { "≈ " };
    let mut row = vec![
        words(format!("  {}", channel.name)),
        number(quantity(channel.rmse)),
        number(quantity(channel.max)),
        number(format!("{sign}{}", quantity(channel.noise))),
    ];
    row.extend(asked.then(|| number(level(channel.accuracy, Scale::small(channel.unit)))));
    row.push(number(fixed(channel.score, 2)).with_bar(score_bar(channel.score, highest)));
    row
}

/// The residual over the condition that it follows.
fn finding_figure(finding: &Finding) -> Picture {
    let curve = &finding.curve;
    let (x, y) = (Scale::large(finding.variable.unit()), Scale::small(curve.y_unit));
    let numbered = curve.categories.is_empty();
    let mark = |(k, point): (usize, &ConditionBin)| Marked {
        x: if numbered { point.x * x.factor } else { k as f64 },
        y: point.y * y.factor,
        error: point.error * y.factor,
    };
    let marked: Vec<Marked> = curve.points.iter().enumerate().map(mark).collect();
    let points = marked.iter().filter(|_| numbered).map(|m| (m.x, m.y)).collect();
    Picture {
        title: format!("{}: {}", finding.channel, y_name(finding)),
        text: sentence(finding),
        plot: Plot {
            marked,
            categories: curve.categories.iter().map(|c| category(*c, finding)).collect(),
            ..Plot::new(
                x.named(&x_name(finding)),
                y.named("residual"),
                vec![PlotLine::new("", color::run(0), points)],
            )
        },
    }
}

impl ColumnComparison<'_> {
    /// The worst column of a log.
    fn worst_of(log: &LogComparison) -> Option<ColumnComparison<'_>> {
        let mut columns: Vec<_> = log.channels.iter().flat_map(|c| &c.columns).collect();
        columns.sort_by(|a, b| b.score.total_cmp(&a.score));
        columns.iter().find_map(|column| {
            let trace = log
                .traces
                .iter()
                .find(|t| format!("{}[{}]", t.channel, t.column) == column.name)?;
            Some(ColumnComparison {
                log: &log.name,
                scores: fixed(column.score, 1),
                predictions: vec![("predicted", REFERENCE, trace)],
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::assert_self_contained;
    use crate::sample;
    use std::path::Path;

    #[test]
    fn text_and_page_say_the_score_and_where_the_model_fails() {
        let comparison = sample::comparison();
        let report = CompareReport {
            model: Path::new("model.toml"),
            comparison: &comparison,
            provenance: sample::provenance(),
        };
        let (text, page) = (report.text(), report.page());
        assert_self_contained(&page);
        for said in ["0.0816 mm", "0.200 mm", "0.0300 mm", "2.72"] {
            assert!(text.contains(said) && page.contains(said), "{said}: {text}");
        }
        // The finding's curve; of the positions the difference alone.
        assert_eq!(page.matches("<svg").count(), 2);
        // What follows two conditions: −0.1 mm as blue as it gets, a cell without rows pale.
        let together = "A5's spring torque and the direction of A5's motion together 80 %";
        let words: Vec<&str> = text.split_whitespace().collect();
        assert!(words.join(" ").contains(together), "{text}");
        assert!(page.contains("mean residual in x, mm, over two conditions"));
        assert_eq!(page.matches("background:#4c9cc9").count(), 2);
    }

    #[test]
    fn names_of_files_are_no_markup_and_end_no_script() {
        let mut comparison = sample::comparison();
        let name = "</script><script>alert(1)</script><b>";
        comparison.logs[0].name = name.to_owned();
        comparison.logs[0].traces.iter_mut().for_each(|t| t.label = name.to_owned());
        comparison.worst[0].joints[4] = name.to_owned();
        let page = CompareReport {
            model: Path::new(name),
            comparison: &comparison,
            provenance: sample::provenance(),
        }
        .page();
        assert!(!page.contains("alert(1)</script>") && !page.contains("<b>: "), "a name is markup");
        assert_eq!(page.matches("</script>").count(), page.matches("<script").count());
    }

    #[test]
    fn at_the_noise_floor_nothing_is_drawn_as_a_failure() {
        let mut comparison = sample::comparison();
        comparison.score = 0.99;
        comparison.logs[0].score = 0.99;
        comparison.logs[0].channels[0].score = 0.99;
        comparison.worst.clear();
        let page = CompareReport {
            model: Path::new("m.toml"),
            comparison: &comparison,
            provenance: sample::provenance(),
        }
        .page();
        assert!(page.contains("is as good as these measurements can tell"));
        assert!(!page.contains("What the difference follows"));
    }
}
