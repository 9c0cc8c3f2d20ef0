//! Two logs of one experiment beside each other.

use super::{PublishedResult, Report};
use crate::CompareLogsReport;
use crate::color::{self, REFERENCE};
use crate::document::{
    Block, Column, Document, Picture, Plot, PlotLine, Table, Tone, number, words,
};
use crate::json::compare_logs::CompareLogsResult;
use crate::text::compare_logs::{column_name, exceeds_noise, headline, of, setting};
use crate::text::{Scale, fixed, share};
use trueweld_logs::pair::{ChannelDifference, ColumnDifference};

/// A channel with one of its columns.
type DifferenceRow<'a> = (&'a ChannelDifference, &'a ColumnDifference);

impl Report for CompareLogsReport<'_> {
    const SCHEMA: &'static str = "compare-logs/1";

    fn json(&self) -> impl PublishedResult {
        CompareLogsResult::of(self)
    }

    fn document(&self) -> Document {
        let mut document = Document::new("Compare logs", headline(self), self.provenance);
        document.push(Block::Note(setting(self)));
        document.push(Block::Table(self.table()));
        let drawn = self.pair.channels.iter().flat_map(|channel| self.figures(channel));
        document
            .figures("Both logs: of every channel the column that differs most", drawn.collect());
        document
    }
}

impl CompareLogsReport<'_> {
    /// Every column of every channel.
    fn table(&self) -> Table {
        let columns = self
            .pair
            .channels
            .iter()
            .flat_map(|channel| channel.columns.iter().map(move |column| (channel, column)));
        let robot = &self.logs[0].robot;
        let scale = |(channel, _): &DifferenceRow<'_>| Scale::small(channel.channel.unit());
        let columns_of: [Column<'_, DifferenceRow<'_>>; 7] = [
            (words(""), &|(channel, column)| {
                let name =
                    format!("{} {}", channel.channel.name(), column_name(channel, column, robot));
                words(name).tone(if exceeds_noise(channel.score()) {
                    Tone::Strong
                } else {
                    Tone::Plain
                })
            }),
            (number("RMS"), &|row| number(scale(row).quantity(row.1.rms))),
            (number("largest"), &|row| number(scale(row).quantity(row.1.largest.0))),
            (number("mean, 95 %"), &|row| {
                let [mean, half] = row.1.mean;
                number(scale(row).with_interval(mean, [mean - half, mean + half]))
            }),
            (number("noise makes"), &|row| {
                number(row.1.noise.map_or("not known".to_owned(), |n| scale(row).quantity(n)))
            }),
            (number("ratio"), &|row| {
                number(row.1.score().map_or(String::new(), |ratio| fixed(ratio, 2)))
            }),
            (words("beside the mean"), &|row| {
                let told = row.1.follows.as_ref().filter(|_| exceeds_noise(row.1.score()));
                let told = told.map(|f| format!("{} {}", share(f.share), of(f, scale(row), self)));
                words(told.unwrap_or_default())
            }),
        ];
        Table::of(columns, &columns_of)
    }

    /// The column that differs most: both logs, and the difference.
    fn figures(&self, channel: &ChannelDifference) -> Vec<Picture> {
        let Some(column) = channel.worst() else { return Vec::new() };
        let name = column_name(channel, column, &self.logs[0].robot);
        let scale = Scale::small(channel.channel.unit());
        let line = |label: &str, color, value: &dyn Fn(&[f64; 3]) -> f64| {
            let points = column.series.iter().map(|at| (at[0], value(at) * scale.factor));
            PlotLine::new(label, color, points.collect())
        };
        let plot = |lines| Plot::new("time, s", scale.named(&name), lines);
        let both = plot(vec![
            line("first", REFERENCE, &|at| at[1]),
            line("second", color::run(1), &|at| at[2]),
        ]);
        let noise = 2.0 * column.noise.unwrap_or(0.0) * scale.factor;
        let difference = Plot {
            band: column.noise.map(|_| [-noise, noise]),
            band_name: "twice the noise".into(),
            ..plot(vec![line("second less first", color::run(0), &|at| at[2] - at[1])])
        };
        let title = format!("{}, {name}", channel.channel.name());
        vec![Picture::new(title, both), Picture::new("Second less first", difference)]
    }
}
