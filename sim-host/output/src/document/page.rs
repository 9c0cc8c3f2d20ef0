//! A document as a page: one file that needs no network and prints as it stands. Its pictures are
//! SVG; a script turns them into plots that answer the mouse, and without it they stay pictures.

use super::plot::PlotData;
use super::{Bar, Block, Document, Form, Medium, Picture, Table, TableCell, Tone};
use crate::color::{Dash, css};
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// uPlot 1.6.32, MIT, © Leon Sorokin: `assets/uPlot.LICENSE`.
const UPLOT: &str = include_str!("../../assets/uPlot.iife.min.js");
const UPLOT_CSS: &str = include_str!("../../assets/uPlot.min.css");

pub(super) const HTML_FORM: Form =
    Form { flag: "--html", help: "Write one self-contained HTML page", write: Document::page };

impl Document {
    /// The document as one self-contained page.
    pub(crate) fn page(&self) -> String {
        let drawn = self.blocks(Medium::Page).any(|block| matches!(block, Block::Figures(_)));
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (self.title) " – Trueweld" }
                    style {
                        @if drawn { (PreEscaped(UPLOT_CSS)) }
                        (PreEscaped(include_str!("page.css")))
                    }
                }
                body {
                    main {
                        h1 {
                            @if let Some((word, good)) = &self.verdict {
                                span.verdict.failed[!*good] { (word) }
                            }
                            (self.headline)
                        }
                        @for block in self.blocks(Medium::Page) { (block.markup()) }
                        @for block in self.origin() { (block.markup()) }
                    }
                    @if drawn {
                        script { (PreEscaped(UPLOT)) }
                        script { (PreEscaped(include_str!("plots.js"))) }
                    }
                }
            }
        }
        .into_string()
    }
}

impl Block {
    fn markup(&self) -> Markup {
        html! {
            @match self {
                Self::Lead(text) => p.lead { (text) },
                Self::Note(text) => p.note { (text) },
                Self::Heading(text) => h2 { (text) },
                Self::List(items) => ul { @for item in items { li { (item) } } },
                Self::Steps(items) => ol { @for item in items { li { (item) } } },
                Self::Table(table) => (table.markup()),
                Self::Figures(figures) => div.figures { @for figure in figures { (figure.markup()) } },
                Self::Maps(maps) => div.figures { @for map in maps { (map.markup()) } },
            }
        }
    }
}

impl Table {
    fn markup(&self) -> Markup {
        html! {
            table {
                @if !self.head.is_empty() {
                    thead { @for row in &self.head { tr { @for cell in row { (cell.markup(true)) } } } }
                }
                tbody {
                    @for row in &self.rows {
                        @let tone = row.first().map_or(Tone::Plain, |cell| cell.tone);
                        tr.group[tone == Tone::Strong].aside[tone == Tone::Aside] {
                            @for (k, cell) in row.iter().enumerate() { (cell.markup(k == 0)) }
                        }
                    }
                }
            }
        }
    }
}

impl TableCell {
    fn markup(&self, head: bool) -> Markup {
        let span = (self.more_columns > 0).then_some(self.more_columns + 1);
        let line = self.color.map(|color| format!("border-bottom:3px solid {}", css(color)));
        let color = line.or(self.shade.map(|shade| format!("background:{}", css(shade))));
        let lines = html! {
            @for (k, line) in self.lines.iter().enumerate() { @if k > 0 { br; } (line) }
        };
        html! {
            @if head {
                th.left[self.left] colspan=[span] style=[color] { (lines) }
            } @else {
                td.left[self.left].bad[self.tone == Tone::Bad].aside[self.tone == Tone::Aside].barred[self.bar.is_some()]
                    colspan=[span] style=[color] {
                    @if let Some(bar) = self.bar { (bar.markup()) }
                    (lines)
                }
            }
        }
    }
}

impl Bar {
    fn markup(self) -> Markup {
        let percent = |share: f64| format!("{:.1}%", 100.0 * share.clamp(0.0, 1.0));
        html! {
            span.bar {
                i style={ "width:" (percent(self.share)) ";background:" (css(self.color)) } {}
                @if let Some(mark) = self.mark { b style={ "left:" (percent(mark)) } {} }
            }
        }
    }
}

impl Picture {
    fn markup(&self) -> Markup {
        let plot = &self.plot;
        html! {
            figure.wide[plot.wide] {
                @if !self.text.is_empty() { p { (self.text) } }
                figcaption {
                    b { (self.title) }
                    @for line in plot.lines.iter().filter(|line| !line.name.is_empty() && !plot.named) {
                        span.key { i class=[line.dash.name()] style={ "border-color:" (css(line.color)) } {} (line.name) }
                    }
                    @if plot.rippled {
                        span.key { "pale: ripple" @if plot.lines.iter().filter(|l| l.dash == Dash::Solid).count() > 1 { " of the first" } }
                    }
                    @if plot.band.is_some() { span.key { i.band {} (plot.band_name) } }
                }
                div.plot { (PreEscaped(plot.svg())) }
                script type="application/json" { (PreEscaped(for_script(&plot.data()))) }
            }
        }
    }
}

/// JSON that may stand within a script element, whatever names it holds.
fn for_script(data: &PlotData<'_>) -> String {
    let json = serde_json::to_string(data).expect("numbers and text are written as JSON");
    json.replace('<', "\\u003c").replace('\u{2028}', "\\u2028")
}
