//! Line plots as small SVG pictures: every pixel column keeps its smallest and largest value, so that a ripple of the
//! spindle stays visible as a band however many rows there are.

use crate::color::{REFERENCE, Rgb};
use plotters::prelude::*;

/// One line of a plot.
pub(crate) struct Line {
    pub name: String,
    pub color: Rgb,
    pub dashed: bool,
    /// x not decreasing.
    pub points: Vec<(f64, f64)>,
}

/// One plot: lines, and a band of y that is allowed.
#[derive(Default)]
pub(crate) struct Plot {
    pub x_label: String,
    pub y_label: String,
    pub lines: Vec<Line>,
    /// Shaded between its two limits, which the y axis then includes.
    pub band: Option<[f64; 2]>,
    /// Limits of y where the lines' own are not wanted.
    pub y_range: Option<[f64; 2]>,
    /// Full width of the page, or half of it.
    pub wide: bool,
}

/// Drawn at twice the size it is shown at, since the coordinates of the picture are whole numbers.
const SCALE: u32 = 2;

impl Plot {
    /// The picture, to be put into a page as it stands.
    pub(crate) fn svg(&self) -> String {
        let mut svg = String::new();
        self.draw(&mut svg).expect("drawing into a string does not fail");
        svg
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error + '_>> {
        let size = if self.wide { (1080 * SCALE, 300 * SCALE) } else { (530 * SCALE, 230 * SCALE) };
        let font = 12 * SCALE;
        let margin = 62 * SCALE;
        let root = SVGBackend::with_string(svg, size).into_drawing_area();
        let [x, y] = self.ranges();
        let mut chart = ChartBuilder::on(&root)
            .margin(6 * SCALE)
            .margin_right(16 * SCALE)
            .x_label_area_size(36 * SCALE)
            .y_label_area_size(margin)
            .build_cartesian_2d(x[0]..x[1], y[0]..y[1])?;
        if let Some([low, high]) = self.band {
            let fill = GREEN_BAND.filled();
            chart.draw_series([Rectangle::new([(x[0], low), (x[1], high)], fill)])?;
            for limit in [low, high] {
                chart.draw_series(LineSeries::new([(x[0], limit), (x[1], limit)], GREEN_LIMIT.stroke_width(SCALE)))?;
            }
        }
        let decimals = decimals(y[1] - y[0]);
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(225, 225, 225))
            .axis_style(RGBColor(120, 120, 120))
            .label_style(("sans-serif", font).into_font().color(&RGBColor(60, 60, 60)))
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_labels(if self.wide { 12 } else { 6 })
            .y_labels(if self.wide { 8 } else { 6 })
            .y_label_formatter(&|v| format!("{v:.decimals$}"))
            .x_label_formatter(&|v| format!("{}", (v * 1e3).round() / 1e3))
            .draw()?;
        // Zero, where the axis crosses it.
        if y[0] < 0.0 && y[1] > 0.0 {
            chart.draw_series(LineSeries::new(
                [(x[0], 0.0), (x[1], 0.0)],
                RGBColor(150, 150, 150).stroke_width(SCALE),
            ))?;
        }
        let columns = (size.0 - margin - 22 * SCALE) as usize / SCALE as usize;
        for line in &self.lines {
            let [r, g, b] = line.color;
            let style = RGBColor(r, g, b).stroke_width(3 * SCALE / 2);
            let inside = line.points.iter().copied().filter(|p| p.0 >= x[0] && p.0 <= x[1]);
            let points = envelope(inside, x, columns);
            if line.dashed {
                chart.draw_series(DashedLineSeries::new(points, 6 * SCALE, 4 * SCALE, style))?;
            } else {
                chart.draw_series(LineSeries::new(points, style))?;
            }
        }
        root.present()?;
        Ok(())
    }

    fn ranges(&self) -> [[f64; 2]; 2] {
        let points = || self.lines.iter().flat_map(|l| l.points.iter()).filter(|p| p.0.is_finite() && p.1.is_finite());
        let x = span(points().map(|p| p.0));
        let y = self.y_range.unwrap_or_else(|| {
            let [low, high] = span(points().map(|p| p.1).chain(self.band.into_iter().flatten()));
            let room = 0.06 * (high - low);
            [low - room, high + room]
        });
        [x, y]
    }
}

const GREEN_BAND: RGBAColor = RGBAColor(0, 158, 115, 0.10);
const GREEN_LIMIT: RGBAColor = RGBAColor(0, 128, 90, 0.8);

/// A dashed line of the reference colour.
pub(crate) fn reference(name: &str, points: Vec<(f64, f64)>) -> Line {
    Line { name: name.to_owned(), color: REFERENCE, dashed: true, points }
}

/// Smallest and largest of some values; never empty, never of no width.
fn span(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
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

/// Digits after the point for labels over a range.
fn decimals(range: f64) -> usize {
    (1.0 - (range / 2.0).log10()).ceil().clamp(0.0, 6.0) as usize
}

/// At most two points a column, in the order they came: where the line was lowest and where it was highest.
fn envelope(points: impl Iterator<Item = (f64, f64)>, x: [f64; 2], columns: usize) -> Vec<(f64, f64)> {
    let mut out = Vec::with_capacity(2 * columns);
    let mut column = usize::MAX;
    // Index and point of the lowest and of the highest of this column.
    let mut extremes: Option<[(usize, (f64, f64)); 2]> = None;
    let mut flush = |extremes: Option<[(usize, (f64, f64)); 2]>| {
        if let Some(mut both) = extremes {
            both.sort_by_key(|e| e.0);
            out.push(both[0].1);
            if both[0].0 != both[1].0 {
                out.push(both[1].1);
            }
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_envelope_keeps_every_extreme_in_few_points() {
        // 10 Hz of ripple over 200 s, with one spike.
        let mut points: Vec<(f64, f64)> = (0..20_000).map(|k| (k as f64, (0.75 * k as f64).sin())).collect();
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
