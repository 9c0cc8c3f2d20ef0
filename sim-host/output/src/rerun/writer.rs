//! The file itself: chunks of columns, encoded one after the other, with identifiers that are
//! counted and not drawn from the clock, so that the same run gives the same bytes.
//!
//! Rerun's own recording stream numbers rows by the time of day, writes from a second thread, and
//! leaves its footer in an order that changes; this goes one level below it, to chunks, messages
//! and frames.

use re_chunk::external::arrow::datatypes::Schema;
use re_chunk::{Chunk, ChunkComponents, ChunkId, RowId, TimeColumn};
use re_log_encoding::{
    Compression, CrateVersion, Encodable, EncodingOptions, MessageHeader, MessageKind, RRD_FOURCC,
    RrdFooter, RrdManifestBuilder, StreamFooter, StreamHeader, ToTransport,
};
use re_log_types::external::re_tuid::Tuid;
use re_log_types::{
    ArrowMsg, BlueprintActivationCommand, LogMsg, SetStoreInfo, StoreId, StoreInfo, StoreKind,
    StoreSource, TimePoint,
};
use re_protos::sdk_comms::v1alpha1::WriteMessagesRequest;
use re_sdk_types::{AsComponents, SerializedComponentColumn};
use re_span::Span;
use std::io::Write;
use tokio::sync::mpsc::UnboundedSender;

/// Name under which the viewer files recordings and keeps their layout.
const APPLICATION: &str = "trueweld";

/// Why a recording could not be put together: what the recording library said.
#[derive(Debug)]
pub(super) struct RecordError(pub String);

/// The library refused.
pub(super) fn refused(error: impl std::fmt::Display) -> RecordError {
    RecordError(error.to_string())
}

/// Into which of the file's two stores a chunk goes.
#[derive(Clone, Copy)]
pub(super) enum Store {
    Recording,
    Layout,
}

/// A recording being written.
pub(super) struct Writer<W: Write> {
    file: W,
    /// Bytes written.
    written: u64,
    /// One message's bytes.
    message: Vec<u8>,
    stores: [StoreState; 2],
    /// The next identifier.
    next: u64,
    /// Who gets every message as well.
    live: Option<Listener>,
}

/// Gets messages as they are written.
pub(super) type Listener = UnboundedSender<WriteMessagesRequest>;

/// One store of the file, and the catalogue of its chunks for the footer.
struct StoreState {
    id: StoreId,
    catalogue: RrdManifestBuilder,
    chunks: usize,
}

impl<W: Write> Writer<W> {
    /// Begins a recording of this identifier.
    pub(crate) fn new(
        mut file: W,
        recording_id: &str,
        live: Option<Listener>,
    ) -> Result<Self, RecordError> {
        let mut message = Vec::new();
        let options = EncodingOptions::PROTOBUF_COMPRESSED;
        let version = CrateVersion::LOCAL.to_bytes();
        StreamHeader { fourcc: RRD_FOURCC, version, options }
            .to_rrd_bytes(&mut message)
            .map_err(refused)?;
        file.write_all(&message).map_err(refused)?;
        let recording = StoreId::recording(APPLICATION, recording_id);
        let layout = StoreId::new(StoreKind::Blueprint, APPLICATION, "layout");
        let stores = [recording, layout].map(|id| StoreState {
            id,
            catalogue: RrdManifestBuilder::default(),
            chunks: 0,
        });
        let written = message.len() as u64;
        let mut writer = Self { file, written, message, stores, next: 1, live };
        for store in [Store::Recording, Store::Layout] {
            let source = StoreSource::Other(APPLICATION.to_owned());
            let info = StoreInfo::new(writer.stores[store as usize].id.clone(), source);
            let row_id = writer.identifier(1);
            writer.append(&LogMsg::SetStoreInfo(SetStoreInfo { row_id, info }))?;
        }
        Ok(writer)
    }

    /// Makes the layout written so far the one that the viewer opens with.
    pub(crate) fn activate_layout(&mut self) -> Result<(), RecordError> {
        let blueprint_id = self.stores[Store::Layout as usize].id.clone();
        let command =
            BlueprintActivationCommand { blueprint_id, make_active: true, make_default: true };
        self.append(&LogMsg::BlueprintActivationCommand(command)).map(|_| ())
    }

    /// Something that holds at all times.
    pub(crate) fn fixed(
        &mut self,
        store: Store,
        entity: &str,
        what: &dyn AsComponents,
    ) -> Result<(), RecordError> {
        self.one(store, entity, TimePoint::default(), what)
    }

    /// Something that holds from one instant on.
    pub(crate) fn one(
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
    pub(crate) fn columns(
        &mut self,
        entity: &str,
        rows: usize,
        times: impl IntoIterator<Item = TimeColumn>,
        columns: impl IntoIterator<Item = SerializedComponentColumn>,
    ) -> Result<(), RecordError> {
        let id = ChunkId::from_tuid(self.identifier(1 + rows as u64));
        let times = times.into_iter().map(|t| (*t.timeline().name(), t)).collect();
        let components: ChunkComponents =
            columns.into_iter().map(|c| (c.descriptor, c.list_array)).collect();
        let chunk =
            Chunk::from_auto_row_ids(id, entity.into(), times, components).map_err(refused)?;
        self.chunk(Store::Recording, &chunk)
    }

    /// Ends the file with the catalogue of its chunks.
    pub(crate) fn finish(mut self) -> Result<(), RecordError> {
        let mut footers = Vec::new();
        for store in self.stores.into_iter().filter(|s| s.chunks > 0) {
            let mut manifest = store.catalogue.build(store.id.clone()).map_err(refused)?;
            // The library leaves the columns of the schema in the order of a hash map.
            let mut fields: Vec<_> = manifest.sorbet_schema.fields.iter().cloned().collect();
            fields.sort_by(|a, b| a.name().cmp(b.name()));
            manifest.sorbet_schema =
                Schema::new_with_metadata(fields, manifest.sorbet_schema.metadata);
            // One store each: with both in one map, their order would change from run to run.
            let footer = RrdFooter { manifests: [(store.id, manifest)].into() };
            footers.push(footer.to_transport(()).map_err(refused)?);
        }
        let footer = footers.into_iter().reduce(|mut all, next| {
            all.manifests.extend(next.manifests);
            all
        });
        let mut payload = Vec::new();
        if let Some(footer) = footer {
            footer.to_rrd_bytes(&mut payload).map_err(refused)?;
        }
        let mut end = Vec::new();
        MessageHeader { kind: MessageKind::End, len: payload.len() as u64 }
            .to_rrd_bytes(&mut end)
            .map_err(refused)?;
        let offset = self.written + end.len() as u64;
        end.extend_from_slice(&payload);
        StreamFooter::from_rrd_footer_bytes(offset, &payload)
            .to_rrd_bytes(&mut end)
            .map_err(refused)?;
        self.file.write_all(&end).map_err(refused)
    }

    fn chunk(&mut self, store: Store, chunk: &Chunk) -> Result<(), RecordError> {
        let id = self.stores[store as usize].id.clone();
        let batch = chunk.to_chunk_batch().map_err(refused)?;
        let message = ArrowMsg {
            chunk_id: chunk.id().as_tuid(),
            batch: batch.clone().into(),
            on_release: None,
        };
        let (span, uncompressed) = self.append(&LogMsg::ArrowMsg(id, message))?;
        let state = &mut self.stores[store as usize];
        state.chunks += 1;
        state.catalogue.append(&batch, span, uncompressed).map_err(refused)
    }

    /// Writes one message; where its payload went, and its size before compression.
    fn append(&mut self, message: &LogMsg) -> Result<(Span<u64>, u64), RecordError> {
        let transport = message.to_transport(Compression::LZ4).map_err(refused)?;
        self.message.clear();
        transport.to_rrd_bytes(&mut self.message).map_err(refused)?;
        self.file.write_all(&self.message).map_err(refused)?;
        let header = MessageHeader::ENCODED_SIZE_BYTES as u64;
        let length = self.message.len() as u64;
        let span = Span { start: self.written + header, len: length - header };
        self.written += length;
        let size = transport.byte_size_uncompressed();
        if let Some(live) = &self.live {
            let message = WriteMessagesRequest { log_msg: Some(transport.into()) };
            live.send(message).map_err(|_| RecordError("the viewer went away".to_owned()))?;
        }
        Ok((span, size))
    }

    /// The next of `count` consecutive identifiers.
    fn identifier(&mut self, count: u64) -> Tuid {
        let id = Tuid::from_nanos_and_inc(0, self.next);
        self.next += count;
        id
    }
}
