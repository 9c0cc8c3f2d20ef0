//! The file itself: chunks of columns, encoded one after the other, with identifiers that are counted and not drawn from
//! the clock, so that the same run gives the same bytes.
//!
//! Rerun's own recording stream numbers rows by time of day and writes from a second thread; this goes one level below
//! it, to the chunk and its encoder.

use super::APPLICATION;
use re_log_encoding::{Encoder, EncodingOptions};
use re_log_types::{BlueprintActivationCommand, SetStoreInfo, StoreId, StoreInfo, StoreKind, StoreSource};
use rerun::external::re_log_types::external::re_tuid::Tuid;
use rerun::external::{re_log_encoding, re_log_types};
use rerun::log::{Chunk, ChunkComponents, ChunkId, LogMsg, RowId, TimeColumn};
use rerun::{AsComponents, SerializedComponentColumn, TimePoint};
use std::io::Write;

/// Why a recording could not be written.
#[derive(Debug)]
pub(super) enum RecordError {
    /// The file system refused.
    File(std::io::Error),
    /// The recording library refused.
    Library(String),
}

/// Anything but a file error ends here.
pub(super) fn refused(error: impl std::fmt::Display) -> RecordError {
    RecordError::Library(error.to_string())
}

fn encoding(error: re_log_encoding::EncodeError) -> RecordError {
    match error {
        re_log_encoding::EncodeError::Write(source) => RecordError::File(source),
        other => refused(other),
    }
}

/// Into which of the file's two stores a chunk goes.
#[derive(Clone, Copy)]
pub(super) enum Store {
    Recording,
    Layout,
}

/// A recording being written.
pub(super) struct Writer<W: Write> {
    encoder: Encoder<W>,
    recording: StoreId,
    layout: StoreId,
    next: u64,
}

impl<W: Write> Writer<W> {
    /// Begins a recording of this identifier.
    pub fn new(file: W, recording_id: &str) -> Result<Self, RecordError> {
        let version = rerun::build_info().version;
        let mut encoder = Encoder::new_eager(version, EncodingOptions::PROTOBUF_COMPRESSED, file).map_err(encoding)?;
        // The footer lists the stores in an order that changes from run to run; viewers read the file without it.
        encoder.do_not_emit_footer();
        let recording = StoreId::recording(APPLICATION, recording_id);
        let layout = StoreId::new(StoreKind::Blueprint, APPLICATION, "layout");
        let mut writer = Self { encoder, recording, layout, next: 1 };
        for store_id in [writer.recording.clone(), writer.layout.clone()] {
            let source = StoreSource::Other(APPLICATION.to_owned());
            let row_id = writer.identifier(1);
            writer.append(&LogMsg::SetStoreInfo(SetStoreInfo { row_id, info: StoreInfo::new(store_id, source) }))?;
        }
        Ok(writer)
    }

    /// Makes the layout written so far the one that the viewer opens with.
    pub fn activate_layout(&mut self) -> Result<(), RecordError> {
        self.append(&LogMsg::BlueprintActivationCommand(BlueprintActivationCommand {
            blueprint_id: self.layout.clone(),
            make_active: true,
            make_default: true,
        }))
    }

    /// Something that holds at all times.
    pub fn fixed(&mut self, store: Store, entity: &str, what: &dyn AsComponents) -> Result<(), RecordError> {
        self.one(store, entity, TimePoint::default(), what)
    }

    /// Something that holds from one instant on.
    pub fn one(
        &mut self,
        store: Store,
        entity: &str,
        when: TimePoint,
        what: &dyn AsComponents,
    ) -> Result<(), RecordError> {
        let (chunk, row) = (self.identifier(1), self.identifier(1));
        let chunk = Chunk::builder_with_id(ChunkId::from_tuid(chunk), entity)
            .with_archetype(RowId::from_tuid(row), when, what)
            .build()
            .map_err(refused)?;
        self.chunk(store, &chunk)
    }

    /// A chunk of `rows` rows of the recording.
    pub fn columns(
        &mut self,
        entity: &str,
        rows: usize,
        times: impl IntoIterator<Item = TimeColumn>,
        columns: impl IntoIterator<Item = SerializedComponentColumn>,
    ) -> Result<(), RecordError> {
        let id = ChunkId::from_tuid(self.identifier(1 + rows as u64));
        let times = times.into_iter().map(|t| (*t.timeline().name(), t)).collect();
        let components: ChunkComponents = columns.into_iter().map(|c| (c.descriptor, c.list_array)).collect();
        let chunk = Chunk::from_auto_row_ids(id, entity.into(), times, components).map_err(refused)?;
        self.chunk(Store::Recording, &chunk)
    }

    /// Ends the file.
    pub fn finish(mut self) -> Result<(), RecordError> {
        self.encoder.finish().map_err(encoding)
    }

    fn chunk(&mut self, store: Store, chunk: &Chunk) -> Result<(), RecordError> {
        let store = match store {
            Store::Recording => self.recording.clone(),
            Store::Layout => self.layout.clone(),
        };
        self.append(&LogMsg::ArrowMsg(store, chunk.to_arrow_msg().map_err(refused)?))
    }

    fn append(&mut self, message: &LogMsg) -> Result<(), RecordError> {
        self.encoder.append(message).map(|_| ()).map_err(encoding)
    }

    /// The next of `count` consecutive identifiers.
    fn identifier(&mut self, count: u64) -> Tuid {
        let id = Tuid::from_nanos_and_inc(0, self.next);
        self.next += count;
        id
    }
}
