//! What both commands of RSI share: their socket, and what became of the packets.

use miette::{IntoDiagnostic, Result, WrapErr};
use std::net::{SocketAddr, UdpSocket};
use trueweld_rsi::packet::PacketError;
use trueweld_rsi::{ClientCounts, LinkCounts};

/// A UDP socket at an address.
pub(crate) fn bound(address: SocketAddr) -> Result<UdpSocket> {
    UdpSocket::bind(address).into_diagnostic().wrap_err_with(|| {
        format!("{address}: expected an address of this machine with a free port")
    })
}

/// What became of the packets of a controller.
pub(crate) fn of_link(counts: &LinkCounts) -> String {
    table(&[
        ("cycles", counts.cycles),
        ("answered in time", counts.answered),
        ("late", counts.late),
        ("lost", counts.lost()),
        ("out of order", counts.out_of_order),
        ("doubled", counts.doubled),
        ("malformed", counts.malformed),
        ("from another address", counts.foreign),
        ("corrections cut off", counts.clamped),
        ("cycles that began late", counts.overruns),
    ])
}

/// What became of the packets of a client.
pub(crate) fn of_client(counts: &ClientCounts) -> String {
    table(&[
        ("answered", counts.answered),
        ("late, says the robot", counts.late),
        ("lost", counts.lost),
        ("out of order", counts.out_of_order),
        ("doubled", counts.doubled),
        ("malformed", counts.malformed),
        ("from another address", counts.foreign),
        ("periods at fault", counts.faults),
    ])
}

/// Why a packet could not be read, where one could not.
pub(crate) fn of_malformed(error: Option<&PacketError>) -> String {
    error.map_or(String::new(), |error| format!("first malformed packet  {error}\n"))
}

/// Counts, one a line; those of nothing are left out after the first.
fn table(rows: &[(&str, u64)]) -> String {
    let shown = rows.iter().enumerate().filter(|(k, (_, count))| *k == 0 || *count > 0);
    shown.map(|(_, (what, count))| format!("{what:<24}{count:>9}\n")).collect()
}
