//! Line plots as small SVG pictures: every pixel column keeps its smallest and largest value, so
//! that a ripple of the spindle stays visible as a band however many rows there are.

use crate::color::{Dash, LIMIT, REFERENCE, Rgb, css, run};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use serde::Serialize;
use std::borrow::Cow;

/// One line of a plot.
pub(crate) struct PlotLine {
    pub name: String,
    pub color: Rgb,
    pub dash: Dash,
    /// x not decreasing; a y that is NaN breaks the line.
    pub points: Vec<(f64, f64)>,
}

impl PlotLine {
    /// A solid line.
    pub(crate) fn new(name: impl Into<String>, color: Rgb, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), color, dash: Dash::Solid, points }
    }

    pub(crate) fn dashed(self, dash: Dash) -> Self {
        Self { dash, ..self }
    }

    fn is_reference(&self) -> bool {
        self.color == REFERENCE
    }
}

/// A point with its standard error.
#[derive(Clone, Copy)]
pub(crate) struct Marked {
    pub x: f64,
    pub y: f64,
    pub error: f64,
}

/// One plot: lines, and a band of y that is allowed.
#[derive(Default)]
pub(crate) struct Plot {
    pub x_label: String,
    pub y_label: String,
    pub lines: Vec<PlotLine>,
    /// Shaded between its two limits, which the y axis then includes.
    pub band: Option<[f64; 2]>,
    /// What the band is.
    pub band_name: Cow<'static, str>,
    /// Limits of y where the lines' own are not wanted.
    pub y_range: Option<[f64; 2]>,
    /// Limits of x where the lines' own are not wanted.
    pub x_range: Option<[f64; 2]>,
    /// Ripples of several lines cover the same band: the first line's is drawn pale, and all lines
    /// as running means.
    pub rippled: bool,
    /// Full width of the page, or half of it.
    pub wide: bool,
    /// Points with their errors, in the first run's colour.
    pub marked: Vec<Marked>,
    /// What they are; measured, where nothing is said.
    pub marked_name: &'static str,
    /// Places ringed in the second run's colour: where points are expected.
    pub rings: Vec<(f64, f64)>,
    /// What they are; as fitted, where nothing is said.
    pub rings_name: &'static str,
    /// Names of the categories at x = 0, 1, …, where x is no number.
    pub categories: Vec<String>,
    /// Lines of few points: every point is dotted, and the line's name, if it has one, stands at
    /// its end.
    pub named: bool,
    /// y by its logarithm; what is not positive is left out.
    pub logarithmic: bool,
}

impl Plot {
    /// Lines over x, their axes labelled.
    pub(crate) fn new(
        x_label: impl Into<String>,
        y_label: impl Into<String>,
        lines: Vec<PlotLine>,
    ) -> Self {
        Self { x_label: x_label.into(), y_label: y_label.into(), lines, ..Self::default() }
    }
}

/// Points of a line that a script gets for each pixel of a page's column: enough to enlarge it.
const SCRIPT_POINTS_MAX: usize = 700;

/// What a script draws a plot from.
#[derive(Serialize)]
pub(super) struct PlotData<'a> {
    x_label: &'a str,
    y_label: &'a str,
    categories: &'a [String],
    band: Option<[f64; 2]>,
    y_range: Option<[f64; 2]>,
    wide: bool,
    logarithmic: bool,
    series: Vec<PlotSeries>,
}

/// One line, or points that none joins.
#[derive(Serialize)]
struct PlotSeries {
    name: String,
    color: String,
    /// Pixels drawn and left out, over and over.
    #[serde(skip_serializing_if = "Option::is_none")]
    dash: Option<[u32; 2]>,
    joined: bool,
    dotted: bool,
    x: Vec<f64>,
    y: Vec<Option<f64>>,
    /// Standard error of each point.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<Vec<f64>>,
}

/// Drawn at twice the size it is shown at, since the coordinates of the picture are whole numbers.
pub(super) const PICTURE_SCALE: u32 = 2;

/// Least and largest room for the names of lines, right of them, and the room of a letter.
const NAME_ROOM: [u32; 2] = [108 * PICTURE_SCALE, 240 * PICTURE_SCALE];
const LETTER: u32 = 8 * PICTURE_SCALE;

/// Height of a line of text.
pub(super) const TEXT_HEIGHT: u32 = 15 * PICTURE_SCALE;

impl Plot {
    /// The picture, to be put into a page as it stands.
    pub(super) fn svg(&self) -> String {
        let mut svg = String::new();
        self.draw(&mut svg).expect("drawing into a string does not fail");
        svg
    }

    /// The same for the page's script.
    pub(super) fn data(&self) -> PlotData<'_> {
        let [x, _] = self.ranges();
        let columns = if self.wide { 2 * SCRIPT_POINTS_MAX } else { SCRIPT_POINTS_MAX };
        let points = |line: &PlotLine| match self.named {
            true => line.points.clone(),
            false => envelope(line.points.iter().copied(), x, columns),
        };
        let lines = self.lines.iter().filter(|line| !line.points.is_empty());
        let lines = lines.map(|line| PlotSeries {
            joined: true,
            dotted: self.named,
            dash: line.dash.pixels(),
            ..PlotSeries::of(&line.name, line.color, points(line))
        });
        let mut series: Vec<PlotSeries> = lines.collect();
        let named = |name: &'static str, usual| if name.is_empty() { usual } else { name };
        if !self.rings.is_empty() {
            series.push(PlotSeries::of(
                named(self.rings_name, "as fitted"),
                run(1),
                self.rings.clone(),
            ));
        }
        if !self.marked.is_empty() {
            let points = self.marked.iter().map(|m| (m.x, m.y)).collect();
            let error = Some(self.marked.iter().map(|m| five_digits(m.error)).collect());
            series.push(PlotSeries {
                error,
                ..PlotSeries::of(named(self.marked_name, "measured"), run(0), points)
            });
        }
        PlotData {
            x_label: &self.x_label,
            y_label: &self.y_label,
            categories: &self.categories,
            band: self.band,
            y_range: self.y_range,
            wide: self.wide,
            logarithmic: self.logarithmic,
            series,
        }
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error + '_>> {
        let size = match (self.wide, self.named) {
            (true, _) => (1080 * PICTURE_SCALE, 300 * PICTURE_SCALE),
            (false, false) => (530 * PICTURE_SCALE, 230 * PICTURE_SCALE),
            // A line of text for every name, and as many below them as the axis takes.
            (false, true) => {
                (530 * PICTURE_SCALE, (320 * PICTURE_SCALE).max((self.names() + 5) * TEXT_HEIGHT))
            }
        };
        // The SVG backend writes sizes smaller than asked for by 1.24.
        let font = TEXT_HEIGHT;
        // Powers of ten are written out.
        let margin = if self.logarithmic { 76 } else { 62 } * PICTURE_SCALE;
        let root = SVGBackend::with_string(svg, size).into_drawing_area();
        let [x, y] = self.ranges();
        let logarithmic = self.logarithmic;
        let mut chart = ChartBuilder::on(&root)
            .margin(6 * PICTURE_SCALE)
            .margin_right(if self.named { self.room() } else { 16 * PICTURE_SCALE })
            .x_label_area_size(36 * PICTURE_SCALE)
            .y_label_area_size(margin)
            .build_cartesian_2d(x[0]..x[1], Upright { range: (y[0]..y[1]).into(), logarithmic })?;
        if let Some([low, high]) = self.band {
            let [r, g, b] = LIMIT;
            let fill = RGBColor(r, g, b).mix(0.12).filled();
            chart.draw_series([Rectangle::new([(x[0], low), (x[1], high)], fill)])?;
            for limit in [low, high] {
                chart.draw_series(LineSeries::new(
                    [(x[0], limit), (x[1], limit)],
                    RGBColor(r, g, b).stroke_width(PICTURE_SCALE),
                ))?;
            }
        }
        let decimals = decimals(y[1] - y[0]);
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(225, 225, 225))
            .axis_style(RGBColor(120, 120, 120))
            .label_style(("sans-serif", font).into_font().color(&RGBColor(60, 60, 60)))
            .axis_desc_style(("sans-serif", font).into_font().color(&RGBColor(60, 60, 60)))
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_labels(match (self.categories.len(), self.wide) {
                (0, true) => 12,
                (0, false) => 6,
                // One a category, and one at either end.
                (n, _) => n + 2,
            })
            .y_labels(if self.wide { 8 } else { 6 })
            .y_label_formatter(&|v| match logarithmic {
                true => format!("{}", (10f64.powf(*v) * 1e6).round() / 1e6),
                false => format!("{:.decimals$}", if v.abs() < 1e-9 { 0.0 } else { *v }),
            })
            .x_label_formatter(&|v| self.x_text(*v))
            .draw()?;
        // Zero, where the axis crosses it.
        if !logarithmic && y[0] < 0.0 && y[1] > 0.0 {
            chart.draw_series(LineSeries::new(
                [(x[0], 0.0), (x[1], 0.0)],
                RGBColor(150, 150, 150).stroke_width(PICTURE_SCALE),
            ))?;
        }
        let columns = (size.0 - margin - 22 * PICTURE_SCALE) as usize / PICTURE_SCALE as usize;
        for (k, line) in self.lines.iter().enumerate() {
            let [r, g, b] = line.color;
            let rippled = self.rippled && !line.is_reference();
            let opacity = if rippled { 0.35 } else { 1.0 };
            let style = RGBColor(r, g, b).mix(opacity).stroke_width(3 * PICTURE_SCALE / 2);
            let inside = || self.drawn(line).filter(|p| p.0 >= x[0] && p.0 <= x[1]);
            let shown = match () {
                () if rippled && k > 0 => Vec::new(),
                () if self.named => inside().collect(),
                () => envelope(inside(), x, columns),
            };
            for points in clipped(&shown, y) {
                match line.dash.pixels().map(|pixels| pixels.map(|p| p * PICTURE_SCALE)) {
                    Some([on, off]) => {
                        chart.draw_series(DashedLineSeries::new(points, on, off, style))?
                    }
                    None => chart.draw_series(LineSeries::new(points, style))?,
                };
            }
            if rippled {
                let inside: Vec<(f64, f64)> = inside().collect();
                let style = RGBColor(r, g, b).stroke_width(3 * PICTURE_SCALE / 2);
                for means in clipped(&running_means(&inside, columns / 4), y) {
                    chart.draw_series(LineSeries::new(means, style))?;
                }
            }
            if self.named && !line.is_reference() {
                chart.draw_series(
                    shown
                        .iter()
                        .filter(|p| p.1.is_finite())
                        .map(|place| Circle::new(*place, 3 * PICTURE_SCALE, style.filled())),
                )?;
            }
        }
        if self.named {
            let named = self.lines.iter().filter(|l| !l.name.is_empty());
            let end = |l: &PlotLine| self.drawn(l).filter(|p| p.1.is_finite()).last();
            let ends = named.map(|l| Some((l, chart.backend_coord(&end(l)?))));
            write_names(&root, self.room(), ends.flatten().collect())?;
        }
        let [r, g, b] = run(1);
        let ring = RGBColor(r, g, b).stroke_width(3 * PICTURE_SCALE / 2);
        chart.draw_series(
            self.rings.iter().map(|place| Circle::new(*place, 6 * PICTURE_SCALE, ring)),
        )?;
        let [r, g, b] = run(0);
        let ink = RGBColor(r, g, b);
        for point in &self.marked {
            let (low, high) = (point.y - point.error, point.y + point.error);
            chart.draw_series(LineSeries::new(
                [(point.x, low), (point.x, high)],
                ink.stroke_width(PICTURE_SCALE),
            ))?;
            chart.draw_series([Circle::new(
                (point.x, point.y),
                3 * PICTURE_SCALE,
                ink.filled(),
            )])?;
        }
        root.present()?;
        Ok(())
    }

    /// Lines that have a name.
    fn names(&self) -> u32 {
        self.lines.iter().filter(|line| !line.name.is_empty()).count() as u32
    }

    /// Room for the longest name.
    fn room(&self) -> u32 {
        let longest = self.lines.iter().map(|line| line.name.chars().count()).max().unwrap_or(0);
        ((longest as u32 + 2) * LETTER).clamp(NAME_ROOM[0], NAME_ROOM[1])
    }

    /// A line's points as they are drawn.
    fn drawn<'a>(&self, line: &'a PlotLine) -> impl Iterator<Item = (f64, f64)> + use<'a> {
        let logarithmic = self.logarithmic;
        line.points.iter().map(move |p| (p.0, if logarithmic { p.1.log10() } else { p.1 }))
    }

    /// Label of a place on the x axis.
    fn x_text(&self, x: f64) -> String {
        if self.categories.is_empty() {
            return format!("{}", (x * 1e3).round() / 1e3);
        }
        let whole = x >= 0.0 && (x - x.round()).abs() < 1e-6;
        if whole {
            self.categories.get(x.round() as usize).cloned().unwrap_or_default()
        } else {
            String::new()
        }
    }

    fn ranges(&self) -> [[f64; 2]; 2] {
        let marked =
            || self.marked.iter().flat_map(|m| [-1.0, 1.0].map(|side| (m.x, m.y + side * m.error)));
        let points = || {
            let of_lines = self.lines.iter().flat_map(|l| self.drawn(l));
            of_lines
                .chain(marked())
                .chain(self.rings.iter().copied())
                .filter(|p| p.0.is_finite() && p.1.is_finite())
        };
        let x = self.x_range.unwrap_or_else(|| match self.categories.len() {
            0 => {
                let [low, high] = span(points().map(|p| p.0));
                let room = if self.marked.is_empty() { 0.0 } else { 0.04 * (high - low) };
                [low - room, high + room]
            }
            n => [-0.5, n as f64 - 0.5],
        });
        let given = self.y_range.map(|y| if self.logarithmic { y.map(f64::log10) } else { y });
        let y = given.unwrap_or_else(|| {
            let [low, high] = span(points().map(|p| p.1).chain(self.band.into_iter().flatten()));
            let room = 0.06 * (high - low);
            [low - room, high + room]
        });
        [x, y]
    }
}

impl PlotSeries {
    /// Points, drawn as dots.
    fn of(name: &str, color: Rgb, mut points: Vec<(f64, f64)>) -> Self {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self {
            name: name.to_owned(),
            color: css(color),
            dash: None,
            joined: false,
            dotted: true,
            x: points.iter().map(|p| five_digits(p.0)).collect(),
            y: points.iter().map(|p| p.1.is_finite().then(|| five_digits(p.1))).collect(),
            error: None,
        }
    }
}

/// A number to five digits, which a picture does not show more of.
fn five_digits(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

/// Names at the ends of their lines, moved apart where ends lie close together. `room`: for them.
fn write_names(
    root: &DrawingArea<SVGBackend<'_>, Shift>,
    room: u32,
    mut ends: Vec<(&PlotLine, (i32, i32))>,
) -> Result<(), Box<dyn std::error::Error>> {
    const LABEL_GAP: i32 = 4 * PICTURE_SCALE as i32;
    let (width, height) = root.dim_in_pixel();
    let (left, apart) = ((width - room) as i32 + 2 * LABEL_GAP, TEXT_HEIGHT as i32);
    ends.sort_by_key(|(_, end)| end.1);
    let mut places: Vec<i32> = ends.iter().map(|(_, end)| end.1).collect();
    for k in 1..places.len() {
        places[k] = places[k].max(places[k - 1] + apart);
    }
    // What was pushed out at the bottom pushes back.
    let mut lowest = height as i32 - 3 * apart;
    for place in places.iter_mut().rev() {
        *place = (*place).min(lowest);
        lowest = *place - apart;
    }
    for ((line, end), place) in ends.iter().zip(places) {
        let [r, g, b] = line.color;
        let ink = RGBColor(r, g, b);
        let leader = vec![(end.0 + LABEL_GAP, end.1), (left - LABEL_GAP, place)];
        root.draw(&PathElement::new(leader, ink.mix(0.5).stroke_width(PICTURE_SCALE / 2)))?;
        let style = ("sans-serif", TEXT_HEIGHT)
            .into_font()
            .color(&ink)
            .pos(Pos::new(HPos::Left, VPos::Center));
        root.draw(&Text::new(line.name.as_str(), (left, place), style))?;
    }
    Ok(())
}

/// A dashed line of the reference colour.
pub(crate) fn reference(name: &str, points: Vec<(f64, f64)>) -> PlotLine {
    PlotLine::new(name, REFERENCE, points).dashed(Dash::Dashed)
}

/// Smallest and largest of some values; never empty, never of no width.
fn span(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if !low.is_finite() || !high.is_finite() {
        return [0.0, 1.0];
    }
    if high - low > 1e-9 * high.abs().max(1e-6) {
        [low, high]
    } else {
        let half = (0.05 * high.abs()).max(1e-3);
        [low - half, high + half]
    }
}

/// The y axis: of numbers, or of their logarithms to the base ten.
struct Upright {
    range: RangedCoordf64,
    logarithmic: bool,
}

impl Ranged for Upright {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.range.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        let range = self.range();
        if self.logarithmic {
            readable_logarithms([range.start, range.end])
        } else {
            self.range.key_points(hint)
        }
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.range.range()
    }
}

/// Logarithms of the numbers 1, 2 and 5 times a power of ten within a range; of the powers alone
/// where those are many.
fn readable_logarithms([low, high]: [f64; 2]) -> Vec<f64> {
    let of_a_decade: &[f64] = if high - low > 3.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let decades = low.floor() as i32..=high.ceil() as i32;
    let all = decades.flat_map(|d| of_a_decade.iter().map(move |v| f64::from(d) + v.log10()));
    all.filter(|v| *v >= low && *v <= high).collect()
}

/// Digits after the point for labels over a range.
fn decimals(range: f64) -> usize {
    (1.0 - (range / 2.0).log10()).ceil().clamp(0.0, 6.0) as usize
}

/// At most two points a column, in the order they came: where the line was lowest and where it was
/// highest.
fn envelope(
    points: impl Iterator<Item = (f64, f64)>,
    x: [f64; 2],
    columns: usize,
) -> Vec<(f64, f64)> {
    let mut out = Vec::with_capacity(2 * columns);
    let mut column = usize::MAX;
    // Index and point of the lowest and of the highest of this column.
    let mut extremes: Option<[(usize, (f64, f64)); 2]> = None;
    let mut flush = |extremes: Option<[(usize, (f64, f64)); 2]>| {
        let mut both = extremes.map_or(Vec::new(), Vec::from);
        both.sort_by_key(|e| e.0);
        both.dedup_by_key(|e| e.0);
        out.extend(both.into_iter().map(|e| e.1));
    };
    for (index, point) in points.filter(|p| p.1.is_finite()).enumerate() {
        let here = ((point.0 - x[0]) / (x[1] - x[0]) * columns as f64) as usize;
        if here != column {
            flush(extremes.take());
            column = here;
        }
        extremes = Some(match extremes {
            None => [(index, point); 2],
            Some([low, high]) => [
                if point.1 < low.1.1 { (index, point) } else { low },
                if point.1 > high.1.1 { (index, point) } else { high },
            ],
        });
    }
    flush(extremes);
    out
}

/// Means of `count` consecutive stretches of a line.
fn running_means(points: &[(f64, f64)], count: usize) -> Vec<(f64, f64)> {
    let stretch = points.len().div_ceil(count.max(1)).max(1);
    let mean = |p: &[(f64, f64)]| {
        let n = p.len() as f64;
        (p.iter().map(|p| p.0).sum::<f64>() / n, p.iter().map(|p| p.1).sum::<f64>() / n)
    };
    points.chunks(stretch).map(mean).collect()
}

/// The pieces of a line that lie within limits of y, cut where it crosses them.
fn clipped(points: &[(f64, f64)], [low, high]: [f64; 2]) -> Vec<Vec<(f64, f64)>> {
    let mut pieces: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut open = false;
    for pair in points.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        if !(y0.is_finite() && y1.is_finite()) {
            open = false;
            continue;
        }
        // Part of the segment, from 0 to 1, that lies within both limits.
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (start, end) in [(y0 - low, y1 - low), (high - y0, high - y1)] {
            if start < 0.0 && end < 0.0 {
                to = -1.0;
            } else if start < 0.0 {
                from = from.max(start / (start - end));
            } else if end < 0.0 {
                to = to.min(start / (start - end));
            }
        }
        if from > to {
            open = false;
            continue;
        }
        let at = |t: f64| (x0 + (x1 - x0) * t, y0 + (y1 - y0) * t);
        if !open || from > 0.0 {
            pieces.push(vec![at(from)]);
        }
        if let Some(piece) = pieces.last_mut() {
            piece.push(at(to));
        }
        open = to == 1.0;
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_cut_where_it_leaves_the_picture() {
        let line =
            [(0.0, -2.0), (1.0, 0.0), (2.0, 4.0), (3.0, 0.0), (4.0, 0.5), (5.0, -9.0), (6.0, -9.0)];
        let pieces = clipped(&line, [-1.0, 1.0]);
        assert_eq!(pieces.len(), 2);
        assert_eq!(pieces[0], [(0.5, -1.0), (1.0, 0.0), (1.25, 1.0)]);
        assert_eq!(pieces[1][0], (2.75, 1.0));
        assert!(pieces.iter().flatten().all(|p| p.1.abs() <= 1.0));
    }

    #[test]
    fn the_envelope_keeps_every_extreme_in_few_points() {
        // 10 Hz of ripple over 200 s, with one spike.
        let mut points: Vec<(f64, f64)> =
            (0..20_000).map(|k| (k as f64, (0.75 * k as f64).sin())).collect();
        points[12_345].1 = 9.0;
        let thin = envelope(points.iter().copied(), [0.0, 20_000.0], 500);
        assert!(thin.len() <= 1000);
        assert!(thin.is_sorted_by(|a, b| a.0 <= b.0));
        assert!(thin.contains(&(12_345.0, 9.0)));
        let low = thin.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
        assert!(low < -0.999, "{low}");
    }

    #[test]
    fn a_plot_of_nothing_or_of_a_constant_is_still_a_plot() {
        for points in [vec![], vec![(0.0, 5.0), (1.0, 5.0)]] {
            let plot = Plot { lines: vec![reference("constant", points)], ..Plot::default() };
            assert!(plot.svg().ends_with("</svg>\n"));
        }
    }
}
