//! Maps: a quantity over two coordinates as coloured fields, with its scale beside them.
//!
//! Blue is within what is allowed and orange beyond it, white the limit between them; where nothing is
//! allowed or forbidden, dark blue is most. Grey is where there is no value.

use super::plot::{PICTURE_SCALE, TEXT_HEIGHT};
use crate::color::{Rgb, css};
use maud::{Markup, PreEscaped, html};
use plotters::prelude::*;

/// Within the limit, at the limit, beyond it.
const GOOD: Rgb = [0, 90, 160];
const BAD: Rgb = [200, 75, 0];
const NO_VALUE_COLOUR: Rgb = [222, 222, 222];

/// A quantity over two coordinates.
#[derive(Clone)]
pub(crate) struct Map {
    pub title: String,
    pub x_label: String,
    pub y_label: String,
    /// Centres of the columns and of the rows, evenly apart.
    pub xs: Vec<f64>,
    pub ys: Vec<f64>,
    /// Row by row, in the unit shown; `None` where there is none.
    pub values: Vec<Vec<Option<f64>>>,
    /// What is allowed, and whether that is the least.
    pub allowed: Option<(f64, bool)>,
    /// Places marked by a letter.
    pub marks: Vec<(f64, f64, char)>,
}

/// Share of what is allowed at which a colour is full.
const WORST: f64 = 4.0;

const SIZE: (u32, u32) = (530 * PICTURE_SCALE, 300 * PICTURE_SCALE);
/// Width of the scale with its labels.
const SCALE_WIDTH: u32 = 92 * PICTURE_SCALE;

impl Map {
    pub(super) fn markup(&self) -> Markup {
        html! {
            figure {
                figcaption {
                    b { (self.title) }
                    span.key { i.band style={ "border-color:#999;background:" (css(NO_VALUE_COLOUR)) } {} "not reached" }
                    @if let Some((limit, least)) = self.allowed {
                        span.key { (if least { "at least " } else { "at most " }) (text(limit)) }
                    }
                }
                div.plot { (PreEscaped(self.svg())) }
            }
        }
    }

    /// The picture, to be put into a page as it stands.
    pub(super) fn svg(&self) -> String {
        let mut svg = String::new();
        self.draw(&mut svg).expect("drawing into a string does not fail");
        svg
    }

    /// Smallest and largest value; never of no width.
    fn span(&self) -> [f64; 2] {
        let all = self.values.iter().flatten().flatten().filter(|v| v.is_finite());
        let ends = [f64::INFINITY, f64::NEG_INFINITY];
        let [low, high] = all.fold(ends, |[l, h], v| [l.min(*v), h.max(*v)]);
        // What is four times too much is as bad as it gets.
        let high = match self.allowed {
            Some((limit, false)) => high.min(WORST * limit).max(low),
            _ => high,
        };
        match high - low {
            width if width > 0.0 => [low, high],
            _ if low.is_finite() => {
                [low - 0.05 * low.abs().max(1e-3), low + 0.05 * low.abs().max(1e-3)]
            }
            _ => [0.0, 1.0],
        }
    }

    fn color(&self, value: f64, [low, high]: [f64; 2]) -> Rgb {
        let Some((limit, least)) = self.allowed else {
            return mixed(GOOD, 0.1 + 0.9 * (value - low) / (high - low));
        };
        within_limit(if least { limit / value.max(f64::MIN_POSITIVE) } else { value / limit })
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error + '_>> {
        let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        let (field, scale) = root.split_horizontally(SIZE.0 - SCALE_WIDTH);
        let [wide, high] = [spacing(&self.xs), spacing(&self.ys)];
        let ends = |at: &[f64], half: f64| match at {
            [first, .., last] => [first - half, last + half],
            [one] => [one - half, one + half],
            [] => [0.0, 1.0],
        };
        let [x, y] = [ends(&self.xs, 0.5 * wide), ends(&self.ys, 0.5 * high)];
        let font = || ("sans-serif", TEXT_HEIGHT).into_font().color(&RGBColor(60, 60, 60));
        let mut chart = ChartBuilder::on(&field)
            .margin(6 * PICTURE_SCALE)
            .x_label_area_size(36 * PICTURE_SCALE)
            .y_label_area_size(62 * PICTURE_SCALE)
            .build_cartesian_2d(x[0]..x[1], y[0]..y[1])?;
        chart
            .configure_mesh()
            .disable_mesh()
            .axis_style(RGBColor(120, 120, 120))
            .label_style(font())
            .axis_desc_style(font())
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_labels(7)
            .y_labels(6)
            .x_label_formatter(&|v| text(*v))
            .y_label_formatter(&|v| text(*v))
            .draw()?;
        let span = self.span();
        for (row, y) in self.values.iter().zip(&self.ys) {
            chart.draw_series(row.iter().zip(&self.xs).map(|(value, x)| {
                let color = value.map_or(NO_VALUE_COLOUR, |value| self.color(value, span));
                let fill = RGBColor(color[0], color[1], color[2]).filled();
                let corners = [-0.5, 0.5].map(|side| (x + side * wide, y + side * high));
                Rectangle::new(corners, fill)
            }))?;
        }
        for (x, y, letter) in &self.marks {
            let place = chart.backend_coord(&(*x, *y));
            let radius = 11 * PICTURE_SCALE as i32;
            field.draw(&Circle::new(place, radius, WHITE.filled()))?;
            field.draw(&Circle::new(place, radius, BLACK.stroke_width(PICTURE_SCALE)))?;
            let at = (place.0 - 5 * PICTURE_SCALE as i32, place.1 - 7 * PICTURE_SCALE as i32);
            field.draw(&Text::new(
                letter.to_string(),
                at,
                ("sans-serif", TEXT_HEIGHT).into_font(),
            ))?;
        }
        self.draw_scale(&scale, span)?;
        root.present()?;
        Ok(())
    }

    /// The colours with their values.
    fn draw_scale(
        &self,
        area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
        span: [f64; 2],
    ) -> Result<(), Box<dyn std::error::Error>> {
        const FIELDS: i32 = 40;
        const LABELS: i32 = 4;
        let (top, height) = (8 * PICTURE_SCALE as i32, (SIZE.1 - 60 * PICTURE_SCALE) as i32);
        let (left, wide) = (4 * PICTURE_SCALE as i32, 18 * PICTURE_SCALE as i32);
        for k in 0..FIELDS {
            let share = (f64::from(k) + 0.5) / f64::from(FIELDS);
            let [r, g, b] = self.color(span[1] - share * (span[1] - span[0]), span);
            let corners = [k, k + 1].map(|edge| top + height * edge / FIELDS);
            let field = [(left, corners[0]), (left + wide, corners[1])];
            area.draw(&Rectangle::new(field, RGBColor(r, g, b).filled()))?;
        }
        for k in 0..=LABELS {
            let value = span[1] - f64::from(k) / f64::from(LABELS) * (span[1] - span[0]);
            let at = (
                left + wide + 5 * PICTURE_SCALE as i32,
                top + height * k / LABELS - 7 * PICTURE_SCALE as i32,
            );
            area.draw(&Text::new(text(value), at, ("sans-serif", TEXT_HEIGHT).into_font()))?;
        }
        Ok(())
    }
}

/// White mixed with a share of a colour.
fn mixed(to: Rgb, share: f64) -> Rgb {
    let share = share.clamp(0.0, 1.0);
    to.map(|full| (255.0 + share * (f64::from(full) - 255.0)) as u8)
}

/// The colour of a share of what is allowed: white at the limit; what is four times too much is as
/// bad as it gets.
pub(crate) fn within_limit(share: f64) -> Rgb {
    if share <= 1.0 {
        mixed(GOOD, 1.0 - share)
    } else {
        mixed(BAD, 0.15 + 0.85 * share.ln() / WORST.ln())
    }
}

/// Distance between neighbours; a tenth where there is one alone.
fn spacing(at: &[f64]) -> f64 {
    match at {
        [first, second, ..] => second - first,
        _ => 0.1,
    }
}

/// A number of three digits that count.
fn text(value: f64) -> String {
    let text = crate::text::digits(value, 3);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(values: Vec<Vec<Option<f64>>>, allowed: Option<(f64, bool)>) -> Map {
        Map {
            title: "lateral, mm".to_owned(),
            x_label: "x, m".to_owned(),
            y_label: "z, m".to_owned(),
            xs: vec![1.0, 2.0],
            ys: vec![0.5],
            values,
            allowed,
            marks: vec![(1.0, 0.5, 'B')],
        }
    }

    #[test]
    fn what_is_allowed_is_blue_and_what_is_not_is_orange() {
        let map = map(vec![vec![Some(1.0), None]], Some((2.0, false)));
        let blue = |[r, _, b]: Rgb| b > r;
        assert!(blue(map.color(1.0, [0.0, 4.0])));
        assert!(!blue(map.color(4.0, [0.0, 4.0])));
        let svg = map.svg();
        assert!(svg.ends_with("</svg>\n") && svg.contains(">B<") || svg.contains("B\n"), "{svg}");
        assert!(svg.to_lowercase().contains(&css(NO_VALUE_COLOUR)), "{svg}");
    }

    #[test]
    fn a_map_of_nothing_or_of_one_value_is_still_a_map() {
        for values in [vec![vec![None, None]], vec![vec![Some(3.0), Some(3.0)]], vec![]] {
            assert!(map(values, None).svg().ends_with("</svg>\n"));
        }
    }
}
