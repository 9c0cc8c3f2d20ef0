//! A weld shown as it is made, against the service that Rerun's viewer serves.

#![cfg(feature = "rerun")]

use re_chunk::Chunk;
use re_log_encoding::{CachingApplicationIdInjector, ToApplication};
use re_log_types::{LogMsg, StoreKind};
use re_protos::log_msg::v1alpha1::LogMsg as SentMessage;
use re_protos::sdk_comms::v1alpha1::message_proxy_service_server::{
    MessageProxyService, MessageProxyServiceServer,
};
use re_protos::sdk_comms::v1alpha1::{
    ReadMessagesRequest, ReadMessagesResponse, ReadTablesRequest, ReadTablesResponse,
    WriteMessagesRequest, WriteMessagesResponse, WriteTableRequest, WriteTableResponse,
};
use std::collections::BTreeMap;
use std::sync::mpsc::{Sender, channel};
use std::thread;
use tokio::runtime::Builder;
use tokio_stream::Empty;
use tonic::transport::Server;
use tonic::transport::server::TcpIncoming;
use tonic::{Request, Response, Status, Streaming};
use trueweld_output::{Live, LiveWeld};
use trueweld_plant::simulate::{Recording, Seam};

/// Takes messages as a viewer does.
struct Viewer(Sender<SentMessage>);

#[tonic::async_trait]
impl MessageProxyService for Viewer {
    async fn write_messages(
        &self,
        request: Request<Streaming<WriteMessagesRequest>>,
    ) -> Result<Response<WriteMessagesResponse>, Status> {
        let mut messages = request.into_inner();
        while let Some(message) = messages.message().await? {
            self.0.send(message.log_msg.expect("a message")).expect("the test listens");
        }
        Ok(Response::new(WriteMessagesResponse {}))
    }

    type ReadMessagesStream = Empty<Result<ReadMessagesResponse, Status>>;

    async fn read_messages(
        &self,
        _: Request<ReadMessagesRequest>,
    ) -> Result<Response<Self::ReadMessagesStream>, Status> {
        Err(Status::unimplemented("nobody reads"))
    }

    async fn write_table(
        &self,
        _: Request<WriteTableRequest>,
    ) -> Result<Response<WriteTableResponse>, Status> {
        Err(Status::unimplemented("nobody writes tables"))
    }

    type ReadTablesStream = Empty<Result<ReadTablesResponse, Status>>;

    async fn read_tables(
        &self,
        _: Request<ReadTablesRequest>,
    ) -> Result<Response<Self::ReadTablesStream>, Status> {
        Err(Status::unimplemented("nobody reads tables"))
    }
}

/// A viewer on a thread of its own; its URL.
fn viewer(to: Sender<SentMessage>) -> String {
    let (tell, told) = channel();
    thread::spawn(move || {
        let runtime = Builder::new_current_thread().enable_all().build().expect("a runtime");
        runtime.block_on(async {
            let address = "127.0.0.1:0".parse().expect("an address");
            let incoming = TcpIncoming::bind(address).expect("loopback");
            tell.send(incoming.local_addr().expect("it is bound")).expect("the test listens");
            let service = MessageProxyServiceServer::new(Viewer(to));
            Server::builder().serve_with_incoming(service, incoming).await
        })
    });
    format!("rerun+http://{}/proxy", told.recv().expect("a viewer"))
}

fn begun() -> (LiveWeld, Recording) {
    let crate::sample::Welds { robot, mut recordings, .. } = crate::sample::welds(100);
    let recording = recordings.remove(1);
    let mut seam = Seam::from(recording.rows[0].nominal);
    seam.length = 2.0;
    let before = Recording { rows: Vec::new(), ..recording.clone() };
    (LiveWeld { recording: before, robot, seam, exaggeration: 50.0 }, recording)
}

#[test]
fn a_viewer_gets_every_row_once_with_the_layout_to_see_it_in() {
    let (to, got) = channel();
    let url = viewer(to);
    let (weld, recording) = begun();
    let live = Live::connect(&url, weld).expect("a viewer");
    recording.rows.iter().for_each(|row| live.row(row));
    live.finish().expect("all is shown");
    let (mut rows, mut activations, mut begun) = (BTreeMap::new(), 0, 0);
    let mut injector = CachingApplicationIdInjector::default();
    for message in got.try_iter() {
        match message.to_application((&mut injector, None)).expect("a message of Rerun") {
            LogMsg::SetStoreInfo(_) => begun += 1,
            LogMsg::BlueprintActivationCommand(_) => activations += 1,
            LogMsg::ArrowMsg(store, message) if store.kind() == StoreKind::Recording => {
                let chunk = Chunk::from_arrow_msg(&message).expect("a chunk");
                let entity = chunk.entity_path().to_string();
                *rows.entry(entity).or_insert(0) += chunk.num_rows();
            }
            LogMsg::ArrowMsg(..) => {}
        }
    }
    assert_eq!((begun, activations), (2, 1));
    // One more for the style of each series.
    for signal in ["deviation/lateral", "force/real", "torque", "health/spindle_lines"] {
        assert_eq!(rows.get(&format!("/elastostatic/{signal}")), Some(&101), "{signal}");
    }
    // A change of phase each, and the first: nothing is told anew with every batch.
    let changes = recording.rows.windows(2).filter(|pair| pair[0].phase != pair[1].phase);
    assert_eq!(rows["/elastostatic/events"], changes.count() + 1);
    for entity in ["/cell/plate", "/cell/seam", "/elastostatic/cell/real/a3"] {
        assert!(rows.contains_key(entity), "{entity}");
    }
}

#[test]
fn without_a_viewer_or_with_another_address_it_is_said() {
    for (url, reason) in [
        ("rerun+http://127.0.0.1:1/proxy", "refused"),
        ("rerun+https://example.org/proxy", "expected rerun+http://"),
    ] {
        let refused = Live::connect(url, begun().0).expect_err("nobody is there").to_string();
        assert!(refused.starts_with(url) && refused.contains(reason), "{refused}");
    }
}
