//! KUKA's RobotSensorInterface (RSI), both sides.
//!
//! Every 4 or 12 ms the controller sends a packet `<Rob>` over UDP with what it measures, and
//! expects `<Sen>` with the same time stamp and a correction of its path. Here are a simulated
//! controller with the elastic robot and the process behind it, and a client that runs the laws
//! against a simulated or a real one.
//!
//! Layers, bottom up: [`packet`] writes and reads both packets; [`frame`] holds KUKA's X Y Z A B C;
//! [`guard`] clamps and monitors a correction as the controller does; [`counts`] says what became of
//! every packet; [`Link`] is the simulated controller's end, a law in the place of a law;
//! [`Client`] is the other end.
//!
//! What is known of RSI comes from public drivers and packet dumps, not from KUKA: how the
//! correction is clamped and monitored, that it acts one cycle after it was sent, when a missing
//! answer stops the robot. Left out: TCP, the drives' own latency (40 to 100 ms by how the position
//! is commanded), and how the brakes stop the arm: a run ends where RSI stops.
//!
//! ```
//! use std::net::UdpSocket;
//! use std::time::Duration;
//! use trueweld_rsi::{Client, Served, serve};
//!
//! /// Lets a client's law correct the controller that sends to this port.
//! fn correct(client: &mut Client<'_>) -> std::io::Result<Served> {
//!     let socket = UdpSocket::bind("0.0.0.0:49152")?;
//!     Ok(serve(&socket, client, Duration::from_secs(60), None, |client| {
//!         println!("{:.3} mm across the seam", 1e3 * client.correction().linear.y);
//!     }))
//! }
//! ```

pub mod client;
pub mod counts;
pub mod frame;
pub mod guard;
pub mod link;
pub mod packet;

pub use client::{Client, Seen, Served, serve};
pub use counts::{ClientCounts, LinkCounts};
pub use guard::{CorrectionBounds, StopReason};
pub use link::{CycleTimeout, Link, LinkError, pass_through};
