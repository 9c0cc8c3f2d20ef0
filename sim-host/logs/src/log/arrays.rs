//! Files that hold arrays by their names, as NumPy and MATLAB write them: arrays with as many rows
//! make a table of columns.
//!
//! | array | columns |
//! |---|---|
//! | N, N × 1 or 1 × N | `NAME` |
//! | N × k, or k × N with k < N that stands beside no vector of k alone | `NAME[0]` …, or `NAME(1)` … as the program counts |
//! | a single number | `NAME`, the same in every row |
//! | without numbers, or of more than two dimensions | `NAME`, without a value |

use super::blocks::{BlockRows, Blocks, damaged};
use super::rows::{MOST_COLUMNS, RowSource};
use trueweld_plant::input::InputError;

/// Most bytes that an array may take, unpacked.
pub(super) const ARRAY_BYTES_MAX: u64 = 1 << 30;

/// An array.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NamedArray {
    pub name: String,
    /// Rows and columns; `None` of what holds no numbers.
    pub shape: Option<[usize; 2]>,
    /// True where the numbers of a row stand one after the other.
    pub by_rows: bool,
    pub values: Vec<f64>,
}

impl NamedArray {
    /// What holds no numbers.
    pub(super) fn unread(name: String) -> Self {
        Self { name, shape: None, by_rows: true, values: Vec::new() }
    }

    /// The column of numbers at a place, of rows, or of columns where it is transposed.
    fn column(&self, place: usize, transposed: bool) -> Vec<f64> {
        let Some([rows, columns]) = self.shape else { return Vec::new() };
        let (count, width) = if transposed { (columns, rows) } else { (rows, columns) };
        let value = |k: usize| match self.by_rows != transposed {
            true => self.values[k * width + place],
            false => self.values[place * count + k],
        };
        (0..count).map(value).collect()
    }
}

/// How the columns of an array are counted in their names.
#[derive(Debug, Clone, Copy)]
pub(super) enum ColumnIndex {
    /// From 0, in square brackets.
    Square,
    /// From 1, in round ones.
    Round,
}

impl ColumnIndex {
    fn name(self, array: &str, place: usize) -> String {
        match self {
            Self::Square if array.is_empty() => (place + 1).to_string(),
            Self::Square => format!("{array}[{place}]"),
            Self::Round => format!("{array}({})", place + 1),
        }
    }
}

/// Columns of one length.
struct ArrayTable {
    rows: usize,
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl ArrayTable {
    fn topic(&self) -> String {
        format!("{} rows", self.rows)
    }

    fn push(&mut self, name: String, values: Vec<f64>) {
        self.names.push(name);
        self.columns.push(values);
    }
}

/// The tables that arrays make, the largest first.
fn tables(arrays: &[NamedArray], index: ColumnIndex) -> Vec<ArrayTable> {
    let vector = |array: &NamedArray| match array.shape {
        Some([n, 1] | [1, n]) if n > 1 => Some(n),
        _ => None,
    };
    let lengths: Vec<usize> = arrays.iter().filter_map(vector).collect();
    let mut tables: Vec<ArrayTable> = Vec::new();
    let mut others = Vec::new();
    for array in arrays {
        let Some([rows, columns]) = array.shape.filter(|[r, c]| r * c > 1) else {
            others.push(array);
            continue;
        };
        // There are more rows than columns, but where a vector beside them says otherwise: six gains
        // beside the angles of six joints are no six rows.
        let transposed = columns > rows && (lengths.contains(&columns) || !lengths.contains(&rows));
        let (count, width) = if transposed { (columns, rows) } else { (rows, columns) };
        let place = tables.iter().position(|table| table.rows == count).unwrap_or_else(|| {
            tables.push(ArrayTable { rows: count, names: Vec::new(), columns: Vec::new() });
            tables.len() - 1
        });
        // Too wide a table is refused by its names: one more tells.
        for k in 0..width.min(MOST_COLUMNS + 1) {
            let named = width == 1 && !array.name.is_empty();
            let name = if named { array.name.clone() } else { index.name(&array.name, k) };
            tables[place].push(name, array.column(k, transposed));
        }
    }
    tables.retain(|table| table.rows > 0);
    tables.sort_by_key(|table| std::cmp::Reverse(table.rows * table.columns.len()));
    if let Some(first) = tables.first_mut() {
        for array in others {
            let value = array.values.first().copied().unwrap_or(f64::NAN);
            first.push(array.name.clone(), vec![value; first.rows]);
        }
    }
    tables
}

/// Tables of a file by their number of rows; nothing where there is one.
pub(super) fn topics(arrays: &[NamedArray], index: ColumnIndex) -> Vec<String> {
    let tables = tables(arrays, index);
    if tables.len() < 2 {
        return Vec::new();
    }
    tables.iter().map(ArrayTable::topic).collect()
}

/// Opens one table of a file, by its topic, or the only one. `help`: how such a file is written.
pub(super) fn open_table(
    file: String,
    arrays: &[NamedArray],
    index: ColumnIndex,
    topic: Option<&str>,
    help: &str,
) -> Result<Box<dyn RowSource>, InputError> {
    let tables = tables(arrays, index);
    let list: Vec<String> = tables.iter().map(|table| format!("{:?}", table.topic())).collect();
    let found = match (topic, tables.len()) {
        (Some(topic), _) => tables.into_iter().find(|table| table.topic() == topic),
        (None, 0 | 1) => tables.into_iter().next(),
        (None, count) => {
            let message = format!(
                "holds arrays of {count} lengths; expected `topic` in its entry of `files`, which says of which"
            );
            let help = format!("Name one: {}. Each is an entry of its own.", list.join(", "));
            return Err(damaged(&file, message, &help));
        }
    };
    let Some(table) = found else {
        let message = match topic {
            Some(topic) if !list.is_empty() => {
                format!("has no arrays of {topic:?}; expected one of {}", list.join(", "))
            }
            _ => "holds no array of numbers; expected the samples".to_owned(),
        };
        return Err(damaged(&file, message, help));
    };
    if table.names.len() > MOST_COLUMNS {
        let message = format!("has {} columns; expected at most {MOST_COLUMNS}", table.names.len());
        return Err(damaged(&file, message, help));
    }
    Ok(Box::new(BlockRows::new(file, table.names, WholeTable(Some(table.columns)))))
}

/// A table that is held.
struct WholeTable(Option<Vec<Vec<f64>>>);

impl Blocks for WholeTable {
    fn next(&mut self) -> Result<Option<Vec<Vec<f64>>>, InputError> {
        Ok(self.0.take())
    }
}
