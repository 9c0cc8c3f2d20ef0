//! Measurements beside a model's predictions, or beside those of two models: the way of the tool in
//! space, and every column's difference over time.

use super::signals;
use super::writer::{RecordError, Store, Writer, refused};
use crate::color::{JOINT_COLOURS, LIMIT, REFERENCE, Rgb, run};
use crate::text::compare::{TOLD_FINDINGS, headline, setting};
use crate::text::finding::sentence;
use crate::text::{Scale, score};
use nalgebra::Vector3;
use re_chunk::TimeColumn;
use re_log_types::{TimeCell, TimePoint, Timeline};
use re_sdk_types::archetypes::{
    LineStrips3D, Scalars, SeriesLines, TextDocument, TextLog, ViewCoordinates,
};
use re_sdk_types::components::{MediaType, TextLogLevel};
use std::io::Write;
use std::path::Path;
use trueweld_estimate::residuals::compare::{ChannelComparison, Comparison, LogComparison, Trace};
use trueweld_estimate::residuals::localize::foremost;

/// Points of a drawn way.
const WAY_POINTS: usize = 600;

/// Largest deviation as drawn, as a share of the way's extent.
const DRAWN_DEVIATION_SHARE: f64 = 0.05;

/// Entity of a verdict's entries.
pub(super) const VERDICT: &str = "/verdict";

/// One log and how it appears in the recording.
pub(super) struct ShownLog<'a> {
    pub log: &'a LogComparison,
    /// The same log under a better model.
    pub after: Option<&'a LogComparison>,
    /// Root of its entities.
    pub root: String,
    /// Factor by which deviations are drawn too large; none where no position was tracked.
    pub exaggeration: Option<f64>,
}

impl<'a> ShownLog<'a> {
    /// All logs of a comparison; `after`: under a better model, in the same order, or none.
    pub(crate) fn all(logs: &'a [LogComparison], after: &'a [LogComparison]) -> Vec<Self> {
        let plain = |c: char| {
            if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }
        };
        logs.iter()
            .enumerate()
            .map(|(k, log)| Self {
                log,
                after: after.get(k),
                // Logs of two campaigns may bear one name.
                root: format!("{}_{}", k + 1, log.name.chars().map(plain).collect::<String>()),
                exaggeration: way(log).map(|way| exaggeration(&way)),
            })
            .collect()
    }

    /// Middle of the tool's way as the model has it, and how far from there it reaches.
    pub(crate) fn place(&self) -> Option<(Vector3<f64>, f64)> {
        let way = way(self.log)?;
        let [first, _] = way.first()?;
        let (low, high) =
            way.iter().fold((*first, *first), |(low, high), [p, _]| (low.inf(p), high.sup(p)));
        Some(((low + high) / 2.0, (high - low).norm() / 2.0))
    }

    /// Score of the tracked positions.
    pub(crate) fn way_score(&self) -> Option<f64> {
        self.log.channels.iter().find(|c| c.name == "tcp_position").map(|c| c.score)
    }

    /// Entity of a channel's difference.
    pub(crate) fn difference(&self, channel: &str) -> String {
        format!("/{}/difference/{channel}", self.root)
    }

    /// Range of the differences in a channel's plot, with nothing in it.
    pub(crate) fn extent(&self, channel: &ChannelComparison) -> [f64; 2] {
        let factor = Scale::small(channel.unit).factor;
        let logs = std::iter::once(self.log).chain(self.after);
        let traces = logs.flat_map(|log| &log.traces).filter(|t| t.channel == channel.name);
        let readings = traces.flat_map(|t| t.measured.iter().zip(&t.predicted));
        readings
            .map(|(measured, predicted)| (measured - predicted) * factor)
            .fold([0.0; 2], |[low, high], v| [low.min(v), high.max(v)])
    }

    /// Title of a channel's plot.
    pub(crate) fn title(&self, channel: &ChannelComparison) -> String {
        let unit = Scale::small(channel.unit).unit;
        let after = self.after.and_then(|log| log.channels.iter().find(|c| c.name == channel.name));
        let after = after.map_or(String::new(), |after| format!(" → {}", score(after.score)));
        format!(
            "{}: {}, measured − predicted [{unit}], score {}{after}",
            self.log.name,
            channel.name,
            score(channel.score)
        )
    }
}

/// Predicted and measured positions.
type TrackedPositions = Vec<[Vector3<f64>; 2]>;

/// The way of the tool in a log, thinned; `None` where no position was tracked.
fn way(log: &LogComparison) -> Option<TrackedPositions> {
    let axes: Vec<&Trace> = log.traces.iter().filter(|t| t.channel == "tcp_position").collect();
    let [x, y, z] = axes.as_slice() else {
        return None;
    };
    let rows = x.time.len().min(y.time.len()).min(z.time.len());
    let every = rows.div_ceil(WAY_POINTS).max(1);
    let at = |of: fn(&Trace) -> &Vec<f64>, k: usize| Vector3::new(of(x)[k], of(y)[k], of(z)[k]);
    Some(
        (0..rows)
            .step_by(every)
            .map(|k| [at(|t| &t.predicted, k), at(|t| &t.measured, k)])
            .collect(),
    )
}

/// A round factor that makes the largest deviation of a way a few percent of its extent.
fn exaggeration(way: &[[Vector3<f64>; 2]]) -> f64 {
    let Some([first, _]) = way.first() else {
        return 1.0;
    };
    let extent = way.iter().map(|[predicted, _]| (predicted - first).norm()).fold(0.0, f64::max);
    let most =
        way.iter().map(|[predicted, measured]| (measured - predicted).norm()).fold(0.0, f64::max);
    let wanted = DRAWN_DEVIATION_SHARE * extent / most;
    if !wanted.is_finite() || wanted < 2.0 {
        return 1.0;
    }
    let decade = 10f64.powf(wanted.log10().floor());
    [5.0, 2.0].iter().map(|step| step * decade).find(|factor| *factor <= wanted).unwrap_or(decade)
}

/// Writes everything but the layout. `about`: the result in words.
pub(super) fn all<W: Write>(
    writer: &mut Writer<W>,
    about: String,
    shown: &[ShownLog],
) -> Result<(), RecordError> {
    let text = TextDocument::new(about + &legend(shown)).with_media_type(MediaType::MARKDOWN);
    writer.fixed(Store::Recording, "/about", &text)?;
    for shown in shown {
        tool(writer, shown)?;
        for channel in &shown.log.channels {
            let entity = shown.difference(&channel.name);
            match shown.after {
                None => difference(writer, shown.log, channel, &entity, "")?,
                Some(after) => {
                    difference(writer, shown.log, channel, &format!("{entity}/before"), " before")?;
                    difference(writer, after, channel, &format!("{entity}/after"), " after")?;
                }
            }
        }
    }
    Ok(())
}

/// Writes a verdict as entries of a log.
pub(super) fn verdict<W: Write>(
    writer: &mut Writer<W>,
    said: &[String],
) -> Result<(), RecordError> {
    for line in said {
        let when = TimePoint::default()
            .with(Timeline::new_duration("time"), TimeCell::from_duration_nanos(0));
        let entry = TextLog::new(line.as_str()).with_level(TextLogLevel::INFO);
        writer.one(Store::Recording, VERDICT, when, &entry)?;
    }
    Ok(())
}

/// A comparison in words.
pub(super) fn about(model: &Path, comparison: &Comparison) -> String {
    let mut text = format!("**{}**\n\n{}\n\n", headline(comparison), setting(model, comparison));
    for finding in foremost(&comparison.worst, TOLD_FINDINGS) {
        text += &format!("- {}\n", sentence(finding));
    }
    text
}

/// What the pictures mean.
fn legend(shown: &[ShownLog]) -> String {
    let mut text = "\n".to_owned();
    let improved = shown.iter().any(|s| s.after.is_some());
    let factors: Vec<(&str, f64)> =
        shown.iter().filter_map(|s| Some((s.log.name.as_str(), s.exaggeration?))).collect();
    if improved {
        text += "In the plots: greyish before, in full colour after. ";
    }
    if !factors.is_empty() {
        text += &format!(
            "In space: grey where the model has the tool, coloured where it was measured: green within twice the noise, \
             {} from ten times on.{} How much too large deviations are drawn:\n\n",
            crate::color::run_in_words(0),
            if improved { " Blue where the better model has it." } else { "" },
        );
    }
    for (log, factor) in factors {
        match factor {
            1.0 => text += &format!("- {log}: to scale\n"),
            factor => text += &format!("- {log}: {factor:.0} ×\n"),
        }
    }
    text
}

/// The way of the tool, predicted and measured.
fn tool<W: Write>(writer: &mut Writer<W>, shown: &ShownLog) -> Result<(), RecordError> {
    let (Some(way), Some(factor)) = (way(shown.log), shown.exaggeration) else {
        return Ok(());
    };
    let point = |p: &Vector3<f64>| p.map(|v| v as f32).data.0[0];
    let drawn: Vec<[f32; 3]> = way.iter().map(|[p, m]| point(&(p + (m - p) * factor))).collect();
    let extent = way.iter().map(|[p, _]| (p - way[0][0]).norm()).fold(0.0, f64::max);
    let radius = (0.002 * extent).max(1e-5) as f32;
    let deviations = shown
        .log
        .traces
        .iter()
        .filter(|t| t.channel == "tcp_position")
        .flat_map(|t| t.deviation.first());
    let noise = deviations.map(|d| d * d).sum::<f64>().sqrt();
    let colors = way.windows(2).map(|pair| {
        let off = (pair[0][1] - pair[0][0]).norm() / noise.max(f64::MIN_POSITIVE);
        let share = ((off - 2.0) / 8.0).clamp(0.0, 1.0);
        let mixed = std::array::from_fn(|i| {
            let (low, high) = (f64::from(LIMIT[i]), f64::from(run(0)[i]));
            (low + share * (high - low)) as u8
        });
        signals::rgb(mixed)
    });
    let entity = |what: &str| format!("/{}/tool/{what}", shown.root);
    writer.fixed(
        Store::Recording,
        &format!("/{}/tool", shown.root),
        &ViewCoordinates::RIGHT_HAND_Z_UP(),
    )?;
    let predicted = LineStrips3D::new([way.iter().map(|[p, _]| point(p)).collect::<Vec<_>>()])
        .with_radii([radius])
        .with_colors([signals::rgb(REFERENCE)]);
    writer.fixed(Store::Recording, &entity("predicted"), &predicted)?;
    if let Some(better) = shown.after.and_then(self::way) {
        let drawn = way.iter().zip(&better).map(|([p, _], [b, _])| point(&(p + (b - p) * factor)));
        let improved = LineStrips3D::new([drawn.collect::<Vec<_>>()])
            .with_radii([0.6 * radius])
            .with_colors([signals::rgb(run(1))]);
        writer.fixed(Store::Recording, &entity("improved"), &improved)?;
    }
    let measured = LineStrips3D::new(drawn.windows(2).map(<[_]>::to_vec))
        .with_radii([radius])
        .with_colors(colors);
    writer.fixed(Store::Recording, &entity("measured"), &measured)
}

/// Measured less predicted of one channel, a line a column; `which` model's is said after their
/// names.
fn difference<W: Write>(
    writer: &mut Writer<W>,
    log: &LogComparison,
    channel: &ChannelComparison,
    entity: &str,
    which: &str,
) -> Result<(), RecordError> {
    let traces: Vec<&Trace> = log.traces.iter().filter(|t| t.channel == channel.name).collect();
    let rows = traces.iter().map(|t| t.time.len()).min().unwrap_or(0);
    if rows == 0 {
        return Ok(());
    }
    // Greyish before, on a dark ground as on a light one, so that what is left after stands out.
    let shade = |v: u8| {
        if which == " before" { ((u16::from(v) + 2 * 128) / 3) as u8 } else { v }
    };
    let color = |t: &&Trace| -> Rgb {
        JOINT_COLOURS[usize::from(t.column) % JOINT_COLOURS.len()].map(shade)
    };
    let style = SeriesLines::new()
        .with_names(traces.iter().map(|t| format!("{}{which}", t.label)))
        .with_colors(traces.iter().map(|t| signals::rgb(color(t))))
        .with_widths(vec![1.5; traces.len()]);
    writer.fixed(Store::Recording, entity, &style)?;
    let factor = Scale::small(channel.unit).factor;
    let picked: Vec<usize> = (0..rows).collect();
    for chunk in picked.chunks(signals::CHUNK_ROWS) {
        let values = chunk
            .iter()
            .flat_map(|k| traces.iter().map(|t| (t.measured[*k] - t.predicted[*k]) * factor));
        let columns = Scalars::new(values)
            .columns(std::iter::repeat_n(traces.len(), chunk.len()))
            .map_err(refused)?;
        let time = TimeColumn::new_duration_secs("time", chunk.iter().map(|k| traces[0].time[*k]));
        writer.columns(entity, chunk.len(), [time], columns)?;
    }
    Ok(())
}
