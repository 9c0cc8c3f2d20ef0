//! What every kind of file is read as: named columns, and rows of numbers one after the other, each
//! value with its place for errors.

use trueweld_plant::input::InputError;

/// Most bytes of a file of rows: the columns are held in memory, where they take about as much.
pub(super) const ROW_FILE_BYTES_MAX: u64 = 4 << 30;

/// Most columns of a file that holds their names apart from the rows.
pub(super) const MOST_COLUMNS: usize = 4096;

/// A file of rows. It stands before its first row when it was opened.
pub(super) trait RowSource {
    /// Names of the columns.
    fn names(&self) -> &[String];

    /// Goes on to the next row; false at the end of the file.
    ///
    /// # Errors
    /// A file that cannot be read on, or a row that has not a field for every column.
    fn advance(&mut self) -> Result<bool, InputError>;

    /// The number in a column of the row; NaN where the field is empty, `None` where it is no
    /// finite number.
    fn value(&self, column: usize) -> Option<f64>;

    /// The time in a column of the row, s where it is written as a time of day or a date.
    fn time(&self, column: usize) -> Option<f64> {
        self.value(column)
    }

    /// Number of decimals that it is written with.
    fn decimals(&self, column: usize) -> i32;

    /// What stands in a column of the row, or of the header before the first row.
    fn text(&self, column: usize) -> String;

    /// An error at a column of the row, or of the header before the first row; at all columns
    /// where none is given.
    fn error_at(
        &self,
        column: Option<usize>,
        message: String,
        label: &str,
        help: &str,
    ) -> InputError;

    /// An error of the file as a whole.
    fn error_of_file(&self, message: String, help: &str) -> InputError;

    /// What seems to be wrong where no name is known to `known`: another separator.
    fn misread(&self, _known: &dyn Fn(&str) -> bool) -> Option<InputError> {
        None
    }

    /// [`RowSource::text`] as an error shows it: on one line, and cut where it is long.
    fn shown(&self, column: usize) -> String {
        let text = self.text(column);
        let short: String = text.chars().take(40).collect();
        let dots = if short.len() < text.len() { " …" } else { "" };
        format!("`{}{dots}`", short.escape_debug())
    }
}
