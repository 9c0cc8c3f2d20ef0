//! Typed access to a TOML file in which every value knows its place.
//!
//! A reader opens a [`TomlDocument`], states the keys a [`TomlTable`] may have
//! ([`TomlTable::only`]) and asks for values with the [`Bounds`](super::Bounds) they must keep.
//! Whatever does not fit becomes an [`InputError`] that names file, line, table, key, what was read
//! and what was expected. The unit in a message is taken from the key's ending
//! (`stiffness_nm_rad`), so that it cannot contradict the file. Left out: defaults. A number that
//! is not in the file is an error.

use super::error::{InputError, Source};
use super::nearest::nearest;
use super::table::TomlTable;
use super::value::Text;
use super::{FILE_KINDS, FileKind};
use std::ops::Range;
use toml::de::DeTable;
use toml_parser::lexer::TokenKind;

/// Brackets open at once from which on a text is refused; no file nests as deep.
const TOO_DEEP: usize = 100;

/// A TOML file that parsed, with the place of every value.
#[derive(Debug)]
pub struct TomlDocument<'a> {
    source: Source,
    root: DeTable<'a>,
}

impl<'a> TomlDocument<'a> {
    /// Parses TOML; `name` is what errors call the file.
    ///
    /// # Errors
    /// Text that is not TOML.
    pub fn parse(text: &'a str, name: &str) -> Result<Self, InputError> {
        let source = Source::new(name, text);
        if let Some(span) = too_deep(text) {
            let message = format!(
                "this is not TOML: {TOO_DEEP} brackets are open here, one within the other"
            );
            return Err(source.error(
                span,
                message,
                "one too many",
                "Close every `[` by `]` and every `{` by `}`.",
            ));
        }
        match DeTable::parse(text) {
            Ok(root) => Ok(Self { source, root: root.into_inner() }),
            Err(error) => {
                let help = if text.trim_start().starts_with('<') {
                    "This looks like XML. A URDF must be imported into a robot file first; input files are TOML."
                } else {
                    "Input files are TOML: `key = value` lines under [table] headers, text in double quotes."
                };
                let (problem, span) =
                    (error.message().replace('\n', "; "), error.span().unwrap_or(0..0));
                let message =
                    format!("this is not TOML: {problem}; read `{}`", source.line_at(span.start));
                Err(source.error(span, message, problem, help))
            }
        }
    }

    /// The top-level table.
    pub fn root(&self) -> TomlTable<'_> {
        TomlTable {
            source: &self.source,
            table: &self.root,
            place: "at the top level".to_owned(),
            span: 0..0,
        }
    }

    /// The top-level table, after checking that the file says it is of this schema (for example
    /// `"robot/1"`).
    ///
    /// # Errors
    /// `schema` missing or another one.
    pub fn root_of(&self, schema: &str) -> Result<TomlTable<'_>, InputError> {
        self.root_of_one(&[schema])
    }

    /// As [`TomlDocument::root_of`], of one of several schemas.
    ///
    /// # Errors
    /// As [`TomlDocument::root_of`].
    pub fn root_of_one(&self, schemas: &[&str]) -> Result<TomlTable<'_>, InputError> {
        let root = self.root();
        let found = self.schema()?;
        if !schemas.contains(&found.text) {
            let what = FILE_KINDS.iter().find(|k| k.schemas().contains(&found.text));
            let found_is = what.map(|k| format!(", {}", k.describe())).unwrap_or_default();
            let quoted: Vec<_> = schemas.iter().map(|schema| format!("\"{schema}\"")).collect();
            let expected = format!("expected {}", quoted.join(" or "));
            let message = format!("`schema` is {:?}{found_is}; {expected}", found.text);
            return Err(self.source.error(found.span, message, expected, list_of_kinds()));
        }
        Ok(root)
    }

    /// The kind of file, by its `schema`.
    ///
    /// # Errors
    /// `schema` missing, or none of [`FILE_KINDS`].
    pub fn kind(&self) -> Result<FileKind, InputError> {
        let found = self.schema()?;
        FILE_KINDS.into_iter().find(|k| k.schemas().contains(&found.text)).ok_or_else(|| {
            let near = nearest(found.text, FILE_KINDS.map(FileKind::schema));
            let guess = near.map(|s| format!(" Did you mean \"{s}\"?")).unwrap_or_default();
            let message =
                format!("`schema` is {:?}; expected one of the kinds that exist", found.text);
            self.source.error(
                found.span,
                message,
                "no such kind of file",
                format!("{}{guess}", list_of_kinds()),
            )
        })
    }

    /// An error for every entry that is still to be filled in, in the file's order.
    pub fn open_entries(&self) -> Vec<InputError> {
        let mut open = self.root().open_entries();
        open.sort_by_key(|(at, _)| *at);
        open.into_iter().map(|(_, error)| error).collect()
    }

    fn schema(&self) -> Result<Text<'_>, InputError> {
        let root = self.root();
        if !self.root.contains_key("schema") {
            let message = "missing key `schema` at the top level; expected the kind of this file";
            return Err(self.source.error(
                0..0,
                message,
                "no `schema` in this file",
                list_of_kinds(),
            ));
        }
        root.text("schema")
    }
}

/// The bracket with which [`TOO_DEEP`] are open. The parser's own limit can be passed by text that is not
/// TOML (`{[s]" = {[s]" = …`), down to the end of its stack.
fn too_deep(text: &str) -> Option<Range<usize>> {
    let mut open = Vec::new();
    for token in toml_parser::Source::new(text).lex() {
        let closes = match token.kind() {
            opens @ (TokenKind::LeftSquareBracket | TokenKind::LeftCurlyBracket) => {
                open.push(opens);
                if open.len() >= TOO_DEEP {
                    return Some(token.span().start()..token.span().end());
                }
                continue;
            }
            TokenKind::RightSquareBracket => TokenKind::LeftSquareBracket,
            TokenKind::RightCurlyBracket => TokenKind::LeftCurlyBracket,
            _ => continue,
        };
        // One that closes nothing, or something else, leaves open what is.
        if open.last() == Some(&closes) {
            open.pop();
        }
    }
    None
}

fn list_of_kinds() -> String {
    let list: Vec<_> =
        FILE_KINDS.iter().map(|k| format!("\"{}\" ({})", k.schema(), k.describe())).collect();
    format!("The kinds of file are {}.", list.join(", "))
}
