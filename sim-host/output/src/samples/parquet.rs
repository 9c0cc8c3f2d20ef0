//! Samples as Parquet: a block is a row group. Words are UTF-8 strings, numbers doubles; a value
//! that does not exist is NaN.

use super::{BlockTable, rows_of};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use std::io::{self, Write};
use std::sync::Arc;

impl BlockTable<'_> {
    pub(super) fn parquet(self, file: impl Write + Send) -> io::Result<()> {
        self.row_groups(file).map_err(io::Error::other)
    }

    fn row_groups(self, file: impl Write + Send) -> Result<(), ParquetError> {
        let field = |column: &super::SampleColumn| match column.words {
            true => format!("REQUIRED BYTE_ARRAY {} (STRING);", column.name),
            false => format!("REQUIRED DOUBLE {};", column.name),
        };
        let fields: String = self.columns.iter().map(field).collect();
        let schema = Arc::new(parse_message_type(&format!("message samples {{ {fields} }}"))?);
        let properties = Arc::new(WriterProperties::builder().build());
        let mut writer = SerializedFileWriter::new(file, schema, properties)?;
        for block in self.blocks {
            let rows = rows_of(&block);
            let mut group = writer.next_row_group()?;
            for (values, of) in block.iter().zip(&self.columns) {
                let Some(mut column) = group.next_column()? else { break };
                match of.words {
                    true => {
                        let words: Vec<ByteArray> =
                            (0..rows).map(|row| ByteArray::from(values.word(row))).collect();
                        column.typed::<ByteArrayType>().write_batch(&words, None, None)?;
                    }
                    false => {
                        column.typed::<DoubleType>().write_batch(values.numbers(), None, None)?;
                    }
                }
                column.close()?;
            }
            group.close()?;
        }
        writer.close().map(drop)
    }
}
