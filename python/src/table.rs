//! Samples in Rust's memory as arrays of NumPy and, by the Arrow PyCapsule interface, as tables of
//! pandas, Polars, PyArrow or DuckDB.

use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::Int32Type;
use arrow_array::{
    Array, ArrayRef, DictionaryArray, Float64Array, Int32Array, RecordBatch, RecordBatchIterator,
    StringArray,
};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use numpy::ndarray::{Array2, ArrayView1};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use std::sync::Arc;
use trueweld_output::{CollectedSamples, SampleValues, SampleWords};

/// Name that the Arrow PyCapsule interface gives the capsule of a stream.
const STREAM_CAPSULE: &std::ffi::CStr = c"arrow_array_stream";

/// A table: a row for every sample, columns of numbers and of words.
#[pyclass(frozen, module = "trueweld._core")]
pub(crate) struct ResultTable {
    batch: RecordBatch,
    /// The same columns, one each, for views to keep alive.
    columns: Vec<TableColumn>,
}

/// One column.
enum TableColumn {
    Numbers(Py<SharedNumbers>),
    Words(DictionaryArray<Int32Type>),
}

/// A column from Python.
#[derive(FromPyObject)]
enum GivenColumn<'py> {
    Numbers(PyReadonlyArray1<'py, f64>),
    Words(Vec<String>),
}

/// A column of numbers, which the arrays that show it keep alive.
#[pyclass(frozen, module = "trueweld._core")]
struct SharedNumbers(Float64Array);

impl ResultTable {
    pub(crate) fn new(py: Python<'_>, table: CollectedSamples) -> PyResult<Self> {
        let mut fields = Vec::new();
        let mut arrays: Vec<ArrayRef> = Vec::new();
        let mut columns = Vec::new();
        for (name, values) in table.columns {
            match values {
                SampleValues::Numbers(values) => {
                    // The vector moves; its values stay where they are.
                    let values = Float64Array::from(values);
                    fields.push(Field::new(name, DataType::Float64, false));
                    arrays.push(Arc::new(values.clone()));
                    columns.push(TableColumn::Numbers(Py::new(py, SharedNumbers(values))?));
                }
                SampleValues::Words(words) => {
                    let words = dictionary(words).map_err(refused)?;
                    fields.push(Field::new(name, words.data_type().clone(), false));
                    arrays.push(Arc::new(words.clone()));
                    columns.push(TableColumn::Words(words));
                }
            }
        }
        let batch = RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays).map_err(refused)?;
        Ok(Self { batch, columns })
    }

    fn column(&self, name: &str) -> PyResult<&TableColumn> {
        let schema = self.batch.schema();
        let (place, _) =
            schema.column_with_name(name).ok_or_else(|| PyKeyError::new_err(name.to_owned()))?;
        Ok(&self.columns[place])
    }

    fn numbers(&self, name: &str) -> PyResult<&Py<SharedNumbers>> {
        match self.column(name)? {
            TableColumn::Numbers(values) => Ok(values),
            TableColumn::Words(_) => {
                Err(PyKeyError::new_err(format!("{name} is a column of words")))
            }
        }
    }
}

/// Words with each of them kept once.
fn dictionary(
    SampleWords { words, rows }: SampleWords,
) -> Result<DictionaryArray<Int32Type>, ArrowError> {
    DictionaryArray::try_new(Int32Array::from(rows), Arc::new(StringArray::from(words)))
}

fn refused(error: ArrowError) -> PyErr {
    crate::error::fault(&error.to_string())
}

#[pymethods]
impl ResultTable {
    /// A table of such columns: of numbers an array, of words a list.
    #[staticmethod]
    fn from_columns(py: Python<'_>, columns: Vec<(String, GivenColumn<'_>)>) -> PyResult<Self> {
        let values = |column| match column {
            GivenColumn::Numbers(values) => SampleValues::Numbers(values.as_array().to_vec()),
            GivenColumn::Words(texts) => SampleValues::Words(SampleWords::of(&texts)),
        };
        let columns = columns.into_iter().map(|(name, column)| (name, values(column)));
        Self::new(py, CollectedSamples { columns: columns.collect() })
    }

    /// Names of the columns.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.batch.schema().fields().iter().map(|field| field.name().clone()).collect()
    }

    fn __len__(&self) -> usize {
        self.batch.num_rows()
    }

    /// A column of numbers: an array over Rust's memory that cannot be written. Of words: a list.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        match self.column(name)? {
            TableColumn::Numbers(values) => Ok(view(values.bind(py)).into_any()),
            TableColumn::Words(words) => {
                let texts = words.downcast_dict::<StringArray>();
                let texts = texts.ok_or_else(|| crate::error::fault("words without texts"))?;
                let texts = texts.into_iter().map(Option::unwrap_or_default).collect::<Vec<_>>();
                texts.into_pyobject(py)
            }
        }
    }

    /// Rows `first` to before `end` of columns of numbers, side by side: C-contiguous, of shape
    /// (row, column).
    fn matrix<'py>(
        &self,
        py: Python<'py>,
        names: Vec<String>,
        first: usize,
        end: usize,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let end = end.min(self.batch.num_rows());
        let rows = end.saturating_sub(first);
        let columns = names.iter().map(|name| Ok(self.numbers(name)?.get()));
        let columns = columns.collect::<PyResult<Vec<_>>>()?;
        let gather = || {
            Array2::from_shape_fn((rows, columns.len()), |(row, k)| columns[k].0.value(first + row))
        };
        Ok(PyArray2::from_owned_array(py, py.detach(gather)))
    }

    /// The rows at which a column of words changes: (word, first row, row after the last).
    fn sections(&self, names: Vec<String>) -> PyResult<Vec<(Vec<String>, usize, usize)>> {
        let columns = names.iter().map(|name| match self.column(name)? {
            TableColumn::Words(words) => Ok(words),
            TableColumn::Numbers(_) => {
                Err(PyKeyError::new_err(format!("{name} is a column of numbers")))
            }
        });
        let columns = columns.collect::<PyResult<Vec<_>>>()?;
        let codes = |row: usize| columns.iter().map(move |words| words.keys().value(row));
        let mut sections: Vec<(Vec<String>, usize, usize)> = Vec::new();
        for row in 0..self.batch.num_rows() {
            match sections.last_mut() {
                Some((_, _, end)) if codes(row).eq(codes(row - 1)) => *end = row + 1,
                _ => {
                    let texts = columns.iter().map(|words| {
                        let texts = words.values().as_any().downcast_ref::<StringArray>();
                        let code = words.keys().value(row) as usize;
                        texts.map_or(String::new(), |texts| texts.value(code).to_owned())
                    });
                    sections.push((texts.collect(), row, row + 1));
                }
            }
        }
        Ok(sections)
    }

    /// The table as a stream of Arrow, by the PyCapsule interface. No values are copied.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // The interface lets a producer that has one schema alone give that.
        let _ = requested_schema;
        let batches = RecordBatchIterator::new([Ok(self.batch.clone())], self.batch.schema());
        let stream = FFI_ArrowArrayStream::new(Box::new(batches));
        PyCapsule::new_with_value(py, stream, STREAM_CAPSULE)
    }
}

/// A column of numbers as an array that cannot be written.
fn view<'py>(column: &Bound<'py, SharedNumbers>) -> Bound<'py, PyArray1<f64>> {
    let values = ArrayView1::from(column.get().0.values().as_ref());
    // SAFETY: the values are never changed nor moved, and the array keeps the column, which owns
    // them, alive.
    #[allow(unsafe_code)]
    let array = unsafe { PyArray1::borrow_from_array(&values, column.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    array
}
