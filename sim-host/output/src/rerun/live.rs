//! A weld as it is made, streamed to a running Rerun viewer.
//!
//! The messages are those of a recording's file, sent by Rerun's own client of its proxy service as
//! they come. Two threads: one makes chunks of rows, so that who makes the weld never waits; the
//! other has the connection.

use super::shown::{Beside, DrawnRun};
use super::writer::{RecordError, Writer};
use super::{layout, scene, signals};
use crate::OutputError;
use re_protos::sdk_comms::v1alpha1::WriteMessagesRequest;
use re_protos::sdk_comms::v1alpha1::message_proxy_service_client::MessageProxyServiceClient;
use std::io::{Sink, sink};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, SystemTime};
use tokio::runtime::Builder;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tokio_stream::wrappers::UnboundedReceiverStream;
use tonic::transport::Endpoint;
use trueweld_core::Robot;
use trueweld_plant::simulate::{RecordRow, Recording, Seam};

/// Longest that a viewer may take to answer.
const VIEWER_TIMEOUT: Duration = Duration::from_secs(3);

/// Time whose rows are sent together, s.
const BATCH_TIME: f64 = 0.25;

/// What is known of a weld before it is made.
#[derive(Debug)]
pub struct LiveWeld {
    /// What it is, without rows.
    pub recording: Recording,
    /// The robot, to draw it.
    pub robot: Robot<f64>,
    /// The seam as it was taught.
    pub seam: Seam,
    /// Factor by which deviations are drawn too large.
    pub exaggeration: f64,
}

/// A weld in a viewer.
#[derive(Debug)]
pub struct Live {
    rows: Sender<RecordRow>,
    encoder: JoinHandle<Result<(), RecordError>>,
    connection: JoinHandle<Result<(), String>>,
    url: String,
}

impl Live {
    /// Connects to the viewer at a URL, as it names it itself: `rerun+http://127.0.0.1:9876/proxy`.
    ///
    /// # Errors
    /// No such URL; no viewer there.
    pub fn connect(url: &str, weld: LiveWeld) -> Result<Self, OutputError> {
        let refused = |reason: String| OutputError::Live { url: url.to_owned(), reason };
        let address = url.strip_prefix("rerun+").unwrap_or(url);
        let address = address.strip_suffix("/proxy").unwrap_or(address).to_owned();
        if !address.starts_with("http://") {
            return Err(refused("expected rerun+http://HOST:PORT/proxy".to_owned()));
        }
        let endpoint = Endpoint::from_shared(address)
            .map_err(|error| refused(error.to_string()))?
            .connect_timeout(VIEWER_TIMEOUT);
        let (messages, queue) = unbounded_channel();
        let (answer, answered) = channel();
        let connection = thread::spawn(move || connection(&endpoint, queue, &answer));
        match answered.recv() {
            Ok(Ok(())) => {}
            Ok(Err(reason)) => return Err(refused(reason)),
            Err(_) => return Err(refused("the connection's thread stopped".to_owned())),
        }
        // Every weld is a recording of its own.
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let id = format!("{}, {} s", weld.recording.weld, now.as_secs());
        let (rows, given) = channel();
        let encoder =
            thread::spawn(move || encode(Writer::new(sink(), &id, Some(messages))?, weld, &given));
        Ok(Self { rows, encoder, connection, url: url.to_owned() })
    }

    /// Shows one more row; returns at once.
    pub fn row(&self, row: &RecordRow) {
        // Where nobody listens any more, `finish` says why.
        let _ = self.rows.send(*row);
    }

    /// Waits until all is sent.
    ///
    /// # Errors
    /// A connection that did not last.
    pub fn finish(self) -> Result<(), OutputError> {
        let Self { rows, encoder, connection, url } = self;
        drop(rows);
        let stopped = || "its thread stopped".to_owned();
        let encoded = encoder.join().map_err(|_| stopped());
        let sent = connection.join().map_err(|_| stopped());
        let result = sent
            .and_then(|sent| sent)
            .and(encoded.and_then(|encoded| encoded.map_err(|RecordError(reason)| reason)));
        result.map_err(|reason| OutputError::Live { url, reason })
    }
}

/// Sends what comes out of a queue. `answer`: whether there is a viewer.
fn connection(
    endpoint: &Endpoint,
    queue: UnboundedReceiver<WriteMessagesRequest>,
    answer: &Sender<Result<(), String>>,
) -> Result<(), String> {
    let runtime = Builder::new_current_thread().enable_all().build();
    let connected = runtime.map_err(|error| error.to_string()).and_then(|runtime| {
        let channel = runtime.block_on(endpoint.connect());
        Ok((runtime, channel.map_err(|error| cause(&error))?))
    });
    // Whoever asked has gone where nobody takes the answer.
    match connected {
        Ok((runtime, channel)) => {
            let _ = answer.send(Ok(()));
            let mut client = MessageProxyServiceClient::new(channel);
            let sent = client.write_messages(UnboundedReceiverStream::new(queue));
            runtime.block_on(sent).map(|_| ()).map_err(|status| status.to_string())
        }
        Err(reason) => {
            let _ = answer.send(Err(reason));
            Ok(())
        }
    }
}

/// What an error came from in the end: what wraps it says less.
fn cause(error: &dyn std::error::Error) -> String {
    let mut last = error;
    while let Some(source) = last.source() {
        last = source;
    }
    last.to_string()
}

/// Makes chunks of the rows that come, until none do.
fn encode(
    mut writer: Writer<Sink>,
    weld: LiveWeld,
    rows: &Receiver<RecordRow>,
) -> Result<(), RecordError> {
    let LiveWeld { mut recording, robot, seam, exaggeration } = weld;
    recording.rows.clear();
    let names = [match recording.compensator.as_str() {
        "none" => "no compensation".to_owned(),
        law => law.to_owned(),
    }];
    let together = (BATCH_TIME / recording.period.max(1e-3)).ceil() as usize;
    let beside = |r: &Recording| Beside::Path(crate::path::travelled(&r.rows));
    let mut largest = 0.0_f64;
    let mut is_open = true;
    {
        let shown = DrawnRun::all(std::iter::once(&recording), &names, beside);
        layout::weld(&mut writer, &shown, exaggeration)?;
        let seam = scene::DrawnSeam::taught(&seam);
        let limit = (recording.half_pin, recording.tolerance_name);
        scene::surroundings(&mut writer, &seam, limit, exaggeration)?;
    }
    while is_open {
        let from = recording.rows.len();
        while recording.rows.len() < from + together {
            match rows.recv() {
                Ok(row) => {
                    largest = largest.max(row.deviation_w.linear.y.abs());
                    recording.rows.push(row);
                }
                Err(_) => {
                    is_open = false;
                    break;
                }
            }
        }
        if recording.rows.len() == from {
            break;
        }
        let shown = DrawnRun::all(std::iter::once(&recording), &names, beside);
        for shown in &shown {
            scene::arm(&mut writer, &robot, shown, [exaggeration, largest], from)?;
            signals::all(&mut writer, shown, from)?;
        }
    }
    Ok(())
}
