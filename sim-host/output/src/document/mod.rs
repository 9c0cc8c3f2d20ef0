//! What a command has to show, described once: the terminal and the page are two ways to draw the
//! same document. The finding stands first, then its numbers, then what to do.

mod map;
mod page;
mod plot;
mod text;

pub(crate) use map::Map;
#[cfg(feature = "rerun")]
pub(crate) use map::within_limit;
pub(crate) use plot::{Marked, Plot, PlotLine, reference};

use crate::color::Rgb;
use crate::text::provenance;
use trueweld_plant::provenance::Provenance;

/// A form that a document can be written in, to a file of its own.
#[derive(Debug)]
pub struct Form {
    /// The option that asks for it.
    pub flag: &'static str,
    /// What the option's help says.
    pub help: &'static str,
    /// The document in this form.
    pub write: fn(&Document) -> String,
}

/// The forms that every command can write: one line each, the page first.
pub static FORMS: &[Form] = &[page::HTML_FORM];

/// Where a block is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Medium {
    /// Terminal, page and recording.
    All,
    Terminal,
    Page,
    #[cfg(feature = "rerun")]
    Recording,
}

/// A result as people read it, for the terminal, a page and a recording.
pub struct Document {
    /// Name of the page.
    title: &'static str,
    /// The verdict in a word or two, and whether it is good; none where nothing is judged.
    verdict: Option<(String, bool)>,
    /// The finding in a sentence or two.
    headline: String,
    blocks: Vec<(Medium, Block)>,
    /// What the result is of, at the end of pages and in recordings.
    provenance: Provenance,
}

/// A part of a document.
pub(crate) enum Block {
    /// What the finding means or asks for.
    Lead(String),
    /// How the result came about.
    Note(String),
    Heading(String),
    List(Vec<String>),
    /// What to do, in order.
    Steps(Vec<String>),
    Table(Table),
    /// Pictures, two in a row where they are not wide. On pages alone.
    Figures(Vec<Picture>),
    /// Maps, two in a row. On pages alone.
    Maps(Vec<Map>),
}

impl Document {
    pub(crate) fn new(title: &'static str, headline: String, of: &Provenance) -> Self {
        Self { title, verdict: None, headline, blocks: Vec::new(), provenance: of.clone() }
    }

    /// The finding in a sentence or two.
    pub fn headline(&self) -> &str {
        &self.headline
    }

    /// The same with a verdict before the headline.
    pub(crate) fn judged(self, verdict: impl Into<String>, good: bool) -> Self {
        Self { verdict: Some((verdict.into(), good)), ..self }
    }

    /// What the result is of: options, warnings and files.
    fn origin(&self) -> Vec<Block> {
        let of = &self.provenance;
        let table = |head: &[[&str; 3]], rows: Vec<Vec<TableCell>>| {
            Block::Table(Table { head: head.iter().map(|h| h.map(words).to_vec()).collect(), rows })
        };
        let options = provenance::options(of).into_iter().map(|row| row.map(words).to_vec());
        let files = of.files.iter().map(|f| [&f.file, &f.role, &f.sha256].map(words).to_vec());
        let blocks = [
            Block::Heading("What this is of".to_owned()),
            table(&[], options.collect()),
            Block::List(of.warnings.clone()),
            table(&[["file", "read as", "SHA-256"]], files.collect()),
        ];
        blocks.into_iter().filter(|block| !block.is_empty()).collect()
    }

    /// Adds a block; what is empty is left out.
    pub(crate) fn push(&mut self, block: Block) {
        self.push_on(Medium::All, block);
    }

    /// Adds a block of one medium.
    pub(crate) fn push_on(&mut self, medium: Medium, block: Block) {
        if !block.is_empty() {
            self.blocks.push((medium, block));
        }
    }

    /// Adds a block with a heading above it; neither where the block is empty.
    pub(crate) fn section(&mut self, medium: Medium, heading: &str, block: Block) {
        let before = self.blocks.len();
        self.push_on(medium, block);
        if self.blocks.len() > before {
            self.blocks.insert(before, (medium, Block::Heading(heading.to_owned())));
        }
    }

    /// Adds a table with a heading above it.
    pub(crate) fn table(&mut self, heading: &str, table: Table) {
        self.section(Medium::All, heading, Block::Table(table));
    }

    /// Adds a list with a heading above it.
    pub(crate) fn list(&mut self, heading: &str, items: Vec<String>) {
        self.section(Medium::All, heading, Block::List(items));
    }

    /// Adds pictures with a heading above them.
    pub(crate) fn figures(&mut self, heading: &str, figures: Vec<Picture>) {
        self.section(Medium::Page, heading, Block::Figures(figures));
    }

    /// The blocks of a medium, in order.
    fn blocks(&self, medium: Medium) -> impl Iterator<Item = &Block> {
        let shown = move |of: Medium| of == Medium::All || of == medium;
        self.blocks.iter().filter(move |(of, _)| shown(*of)).map(|(_, block)| block)
    }
}

impl Block {
    fn is_empty(&self) -> bool {
        match self {
            Self::Lead(text) | Self::Note(text) | Self::Heading(text) => text.is_empty(),
            Self::List(items) | Self::Steps(items) => items.is_empty(),
            Self::Table(table) => table.rows.is_empty(),
            Self::Figures(figures) => figures.is_empty(),
            Self::Maps(maps) => maps.is_empty(),
        }
    }
}

/// A table; every row has cells for the same columns.
#[derive(Default)]
pub(crate) struct Table {
    pub head: Vec<Vec<TableCell>>,
    pub rows: Vec<Vec<TableCell>>,
}

/// A column of a table: its heading, and the cell of a row.
pub(crate) type Column<'c, T> = (TableCell, &'c dyn Fn(&T) -> TableCell);

impl Table {
    pub(crate) fn of<T>(rows: impl IntoIterator<Item = T>, columns: &[Column<'_, T>]) -> Self {
        let cells = |row: T| columns.iter().map(|(_, cell)| cell(&row)).collect();
        let head = columns.iter().map(|(heading, _)| heading.clone()).collect();
        Self { head: vec![head], rows: rows.into_iter().map(cells).collect() }
    }
}

/// A cell of a table.
#[derive(Clone, Default)]
pub(crate) struct TableCell {
    /// What it says, a line each.
    pub lines: Vec<String>,
    /// Words stand left, numbers right.
    pub left: bool,
    /// Columns that it takes, less one.
    pub more_columns: usize,
    pub tone: Tone,
    /// Colour of the run that the column is of.
    pub color: Option<Rgb>,
    /// A bar behind the text on a page.
    pub bar: Option<Bar>,
    /// Colour behind the text on a page.
    pub shade: Option<Rgb>,
}

/// How a cell is meant.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Tone {
    #[default]
    Plain,
    /// Something is not as it should be.
    Bad,
    /// Beside the point.
    Aside,
    /// Heads the rows below it.
    Strong,
}

/// A bar of a share of the cell's width, and a mark in it.
#[derive(Clone, Copy)]
pub(crate) struct Bar {
    pub share: f64,
    pub mark: Option<f64>,
    pub color: Rgb,
}

/// Words in a cell.
pub(crate) fn words(text: impl Into<String>) -> TableCell {
    TableCell { left: true, ..number(text) }
}

/// A number in a cell.
pub(crate) fn number(text: impl Into<String>) -> TableCell {
    TableCell { lines: vec![text.into()], ..TableCell::default() }
}

impl TableCell {
    pub(crate) fn over(self, columns: usize) -> Self {
        Self { more_columns: columns - 1, ..self }
    }

    pub(crate) fn tone(self, tone: Tone) -> Self {
        Self { tone, ..self }
    }

    /// Something is not as it should be.
    pub(crate) fn bad(self, bad: bool) -> Self {
        if bad { self.tone(Tone::Bad) } else { self }
    }

    pub(crate) fn colored(self, color: Rgb) -> Self {
        Self { color: Some(color), ..self }
    }

    pub(crate) fn shaded(self, shade: Rgb) -> Self {
        Self { shade: Some(shade), ..self }
    }

    pub(crate) fn with_bar(self, bar: Bar) -> Self {
        Self { bar: Some(bar), ..self }
    }
}

/// A picture with what it shows.
pub(crate) struct Picture {
    pub title: String,
    /// What it means, above it.
    pub text: String,
    pub plot: Plot,
}

impl Picture {
    pub(crate) fn new(title: impl Into<String>, plot: Plot) -> Self {
        Self { title: title.into(), text: String::new(), plot }
    }
}

/// The addresses in a page are the name of the SVG name space and the home of the vendored library.
#[cfg(test)]
pub(crate) fn assert_self_contained(page: &str) {
    let outside = page
        .replace("http://www.w3.org/2000/svg", "")
        .replace("https://github.com/leeoniya/uPlot", "");
    assert!(!outside.contains("http"), "an address in the page");
    for word in ["<link", "@import", "src=", "<script>fetch"] {
        assert!(!page.contains(word), "{word}");
    }
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
}
