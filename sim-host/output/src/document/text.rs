//! A document for a terminal.

use super::{Block, Document, Medium, Table, TableCell, Tone};
use crate::text::lines_of;

/// Longest line.
const TEXT_WIDTH: usize = 110;
/// Between columns.
const COLUMN_GAP: usize = 3;
/// Narrowest column of words.
const NARROWEST: usize = 24;

impl Document {
    /// The document as lines of text.
    pub(crate) fn text(&self) -> String {
        let verdict = self.verdict.as_ref().map_or(String::new(), |(word, _)| format!("{word}. "));
        let mut out = wrapped(&format!("{verdict}{}", self.headline), "", "");
        let mut after_table = false;
        for block in self.blocks(Medium::Terminal) {
            let table = matches!(block, Block::Table(_));
            if table || after_table || matches!(block, Block::Heading(_)) {
                out.push('\n');
            }
            after_table = table;
            match block {
                Block::Lead(text) | Block::Note(text) => out += &wrapped(text, "", ""),
                Block::Heading(text) => out += &format!("{text}\n"),
                Block::List(items) => {
                    items.iter().for_each(|item| out += &wrapped(item, "  - ", "    "));
                }
                Block::Steps(steps) => {
                    for (k, step) in steps.iter().enumerate() {
                        out += &wrapped(step, &format!("  {}. ", k + 1), "     ");
                    }
                }
                Block::Table(table) => table.write(&mut out),
                Block::Figures(_) | Block::Maps(_) => {}
            }
        }
        out.replace("\n\n\n", "\n\n")
    }
}

#[cfg(feature = "rerun")]
impl Document {
    /// The document as Markdown, which recordings show.
    pub(crate) fn markdown(&self) -> String {
        let blocks = self.blocks(Medium::Recording).map(Block::markdown);
        format!("**{}**\n{}", self.headline, blocks.collect::<String>())
    }

    /// What the result is of, as Markdown.
    pub(crate) fn origin_markdown(&self) -> String {
        self.origin().iter().map(Block::markdown).collect()
    }
}

#[cfg(feature = "rerun")]
impl Block {
    fn markdown(&self) -> String {
        match self {
            Self::Lead(text) | Self::Note(text) => format!("\n{text}\n"),
            Self::Heading(text) => format!("\n### {text}\n"),
            Self::List(items) | Self::Steps(items) => {
                items.iter().fold("\n".to_owned(), |list, item| list + &format!("- {item}\n"))
            }
            Self::Table(table) => format!("\n{}", table.markdown()),
            Self::Figures(_) | Self::Maps(_) => "\n".to_owned(),
        }
    }
}

#[cfg(feature = "rerun")]
impl Table {
    fn markdown(&self) -> String {
        let row = |cells: &Vec<TableCell>| -> String {
            let cells = cells.iter().map(|cell| {
                format!("| {} {}", cell.lines.join("; ").trim(), "| ".repeat(cell.more_columns))
            });
            cells.collect::<String>() + "|\n"
        };
        let mut rows = self.all().map(row);
        let head = rows.next().unwrap_or_default();
        let rule = format!("|{}\n", " --- |".repeat(self.widths().len()));
        head + &rule + &rows.collect::<String>()
    }
}

/// Words in lines that fit, the first after `first`, the others after `rest`.
fn wrapped(text: &str, first: &str, rest: &str) -> String {
    let lines = lines_of(text, TEXT_WIDTH - rest.chars().count());
    let before = std::iter::once(first).chain(std::iter::repeat(rest));
    lines.iter().zip(before).map(|(line, before)| format!("{before}{line}\n")).collect()
}

/// Width of a cell's longest line.
fn width_of(cell: &TableCell) -> usize {
    cell.lines.iter().map(|line| line.chars().count()).max().unwrap_or(0)
}

/// Cells with the first column of each.
fn placed(row: &[TableCell]) -> impl Iterator<Item = (usize, &TableCell)> {
    row.iter().scan(0, |column, cell| {
        let here = *column;
        *column += 1 + cell.more_columns;
        Some((here, cell))
    })
}

impl Table {
    fn all(&self) -> impl Iterator<Item = &Vec<TableCell>> {
        self.head.iter().chain(&self.rows)
    }

    /// Widths of the columns: words are broken where the whole is too wide.
    fn widths(&self) -> Vec<usize> {
        let columns = self.all().map(|row| placed(row).map(|(k, c)| k + 1 + c.more_columns).max());
        let mut widths = vec![0; columns.flatten().max().unwrap_or(0)];
        let mut of_words = vec![false; widths.len()];
        for (k, cell) in self.all().flat_map(|row| placed(row)) {
            if cell.more_columns == 0 && cell.tone != Tone::Strong {
                widths[k] = widths[k].max(width_of(cell));
            }
        }
        for (k, cell) in self.rows.iter().flat_map(|row| placed(row)) {
            of_words[k] |= cell.left && k > 0;
        }
        for (k, cell) in self.all().flat_map(|row| placed(row)).filter(|(_, c)| c.more_columns > 0)
        {
            let last = k + cell.more_columns;
            let there = widths[k..=last].iter().sum::<usize>() + COLUMN_GAP * cell.more_columns;
            if cell.tone != Tone::Strong {
                widths[last] += width_of(cell).saturating_sub(there);
            }
        }
        loop {
            let whole = widths.iter().sum::<usize>() + COLUMN_GAP * widths.len().saturating_sub(1);
            let widest = (0..widths.len()).filter(|k| of_words[*k]).max_by_key(|k| widths[*k]);
            match widest.filter(|k| whole > TEXT_WIDTH && widths[*k] > NARROWEST) {
                Some(k) => {
                    widths[k] = (widths[k] + TEXT_WIDTH).saturating_sub(whole).max(NARROWEST)
                }
                None => return widths,
            }
        }
    }

    /// Columns side by side that fit, the first in every block.
    fn write(&self, out: &mut String) {
        let widths = self.widths();
        // A block ends only where no cell goes on.
        let bound = |k: usize| {
            self.all().flat_map(|row| placed(row)).all(|(start, cell)| {
                cell.tone == Tone::Strong || k <= start || k > start + cell.more_columns
            })
        };
        let mut from = 1;
        while from < widths.len() || from == 1 {
            let mut until = from + 1;
            let mut wide = widths[0];
            for k in from..widths.len() {
                wide += COLUMN_GAP + widths[k];
                if bound(k + 1) && (wide <= TEXT_WIDTH || until == from + 1) {
                    until = k + 1;
                }
            }
            if from > 1 {
                out.push('\n');
            }
            for row in self.all() {
                write_row(row, &widths, [from, until], out);
            }
            from = until;
        }
    }
}

fn write_row(row: &[TableCell], widths: &[usize], [from, until]: [usize; 2], out: &mut String) {
    let cells: Vec<(usize, usize, Vec<String>, bool)> = placed(row)
        .filter(|(k, _)| *k == 0 || (*k >= from && *k < until))
        .map(|(k, cell)| {
            let last = (k + cell.more_columns).min(widths.len() - 1);
            let width = widths[k..=last].iter().sum::<usize>() + COLUMN_GAP * (last - k);
            let lines = cell.lines.iter().flat_map(|line| match cell.left && k > 0 {
                true => lines_of(line, width),
                false => vec![line.clone()],
            });
            (k, width, lines.collect(), cell.left || k == 0)
        })
        .collect();
    let height = cells.iter().map(|(_, _, lines, _)| lines.len()).max().unwrap_or(0);
    for n in 0..height {
        let mut line = String::new();
        for (k, width, lines, left) in &cells {
            let text = lines.get(n).map_or("", String::as_str);
            line += &" ".repeat(if *k == 0 { 0 } else { COLUMN_GAP });
            line += &if *left { format!("{text:<width$}") } else { format!("{text:>width$}") };
        }
        out.push_str(line.trim_end());
        out.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::super::{number, words};
    use super::*;

    fn table(runs: usize) -> Document {
        let mut head = vec![vec![words("")], vec![words("")]];
        let mut rows = vec![vec![words("lateral, mm")], vec![words("push, mean")]];
        for k in 0..runs {
            head[0].push(number(format!("a run of a long name, number {k}")).over(3));
            head[1].extend(["mean", "RMS", "|max|"].map(number));
            rows[0].extend(["4.226", "4.286", "5.215"].map(number));
            rows[1].push(number("18.017 kN").over(3));
        }
        let mut document =
            Document::new("Test", "A finding.".to_owned(), crate::sample::provenance());
        document.push(Block::Table(Table { head, rows }));
        document
    }

    #[test]
    fn a_table_that_is_too_wide_goes_on_below_and_no_run_is_split() {
        for runs in 1..8 {
            let text = table(runs).text();
            assert!(text.lines().all(|line| line.chars().count() <= TEXT_WIDTH), "{text}");
            assert_eq!(text.matches("number ").count(), runs, "{text}");
            assert_eq!(text.matches("18.017 kN").count(), runs, "{text}");
            let head = text.lines().find(|line| line.contains("number 0")).unwrap();
            let units = text.lines().find(|line| line.contains("|max|")).unwrap();
            assert_eq!(head.chars().count(), units.chars().count(), "{text}");
        }
    }

    #[test]
    fn long_words_are_broken_and_numbers_are_not() {
        let mut document =
            Document::new("Test", "A finding.".to_owned(), crate::sample::provenance());
        let row = vec![words("step"), words("because ".repeat(30)), number("0.98")];
        document.push(Block::Table(Table { head: Vec::new(), rows: vec![row] }));
        let text = document.text();
        assert!(text.lines().all(|line| line.chars().count() <= TEXT_WIDTH), "{text}");
        assert_eq!(text.matches("because").count(), 30);
        assert!(text.contains("0.98"));
    }
}
