//! How the error falls from one model to the next, channel by channel, in the units of what is
//! measured.

use super::residuals::DRAWN_FALL_MIN;
use crate::color::{self, Dash};
use crate::document::{Picture, Plot, PlotLine, Table, TableCell, number, reference, words};
use crate::text::error::{channel, fall, pairs};
use crate::text::{Scale, share};
use trueweld_estimate::residuals::error::ChannelError;

/// Channels drawn at most.
const DRAWN_CHANNELS: usize = 4;

/// A quantity; nothing where it is none.
pub(super) fn level(value: f64, scale: Scale) -> String {
    if value > 0.0 { scale.quantity(value) } else { String::new() }
}

/// Names of models that half of a page's width has room for.
const NAMES_BESIDE_MAX: usize = 3;

/// Models, each with its name and its errors; the first is what the others are judged by.
pub(super) struct ErrorFall<'e> {
    pub steps: Vec<(String, &'e [ChannelError])>,
}

impl ErrorFall<'_> {
    /// A row a channel: root mean square errors of every model, noise, accuracy, and the share of the
    /// squared error that the last model explains.
    pub(super) fn table(&self) -> Table {
        let Some((_, first)) = self.steps.first() else { return Table::default() };
        let asked = first.iter().any(|e| e.accuracy > 0.0);
        let mut head = vec![words("RMS error")];
        head.extend(self.steps.iter().map(|(name, _)| number(name.clone())));
        head.push(number("noise"));
        head.extend(asked.then(|| number("accuracy")));
        head.push(number("explained"));
        let row = |k: usize, error: &ChannelError| {
            let scale = Scale::small(error.unit);
            let mut row = vec![words(channel(error))];
            let of_step = |(_, errors): &(String, &[ChannelError])| -> TableCell {
                number(errors.get(k).map_or(String::new(), |e| scale.quantity(e.rmse)))
            };
            row.extend(self.steps.iter().map(of_step));
            row.push(number(scale.quantity(error.noise)));
            row.extend(asked.then(|| number(level(error.accuracy, scale))));
            let last = self.steps.last().and_then(|(_, errors)| errors.get(k));
            let explained = last.map_or(0.0, |last| last.explained(error));
            row.push(number(if explained > 0.0 { share(explained) } else { String::new() }));
            row
        };
        let rows = first.iter().enumerate().map(|(k, error)| row(k, error)).collect();
        Table { head: vec![head], rows }
    }

    /// The channels whose error falls most, a picture each, with noise and accuracy beside it.
    pub(super) fn pictures(&self) -> Vec<Picture> {
        let [(_, first), .., (_, last)] = self.steps.as_slice() else { return Vec::new() };
        let mut all = pairs(first, last);
        all.retain(|(first, last)| last.explained(first) > DRAWN_FALL_MIN);
        all.sort_by(|a, b| fall(b).total_cmp(&fall(a)));
        all.into_iter().take(DRAWN_CHANNELS).map(|(first, _)| self.picture(first)).collect()
    }

    fn picture(&self, first: &ChannelError) -> Picture {
        let scale = Scale::small(first.unit);
        let same = |e: &&ChannelError| (e.channel, e.ripple) == (first.channel, first.ripple);
        let of_step = |(k, (_, errors)): (usize, &(String, &[ChannelError]))| {
            let rmse = errors.iter().find(same).map_or(f64::NAN, |e| e.rmse);
            (k as f64, rmse * scale.factor)
        };
        let ends = [-0.2, self.steps.len() as f64 - 0.8];
        let level = |name: &str, value: f64| {
            (value > 0.0).then(|| reference(name, ends.map(|x| (x, value * scale.factor)).into()))
        };
        let error = PlotLine {
            name: "error".to_owned(),
            color: color::run(0),
            dash: Dash::Solid,
            points: self.steps.iter().enumerate().map(of_step).collect(),
        };
        let levels = [level("noise", first.noise), level("accuracy", first.accuracy)];
        let plot = Plot {
            y_label: scale.named("RMS error"),
            lines: levels.into_iter().flatten().chain([error]).collect(),
            x_range: Some(ends),
            categories: self.steps.iter().map(|(name, _)| name.clone()).collect(),
            wide: self.steps.len() > NAMES_BESIDE_MAX,
            named: true,
            logarithmic: true,
            ..Plot::default()
        };
        Picture::new(channel(first), plot)
    }
}
