//! What became of every packet.

use std::collections::VecDeque;

/// How far back an answer is recognised, cycles.
const REMEMBERED_CYCLES: usize = 256;

/// The controller's side.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LinkCounts {
    /// Cycles, each with one packet sent.
    pub cycles: u64,
    /// Answers in time.
    pub answered: u64,
    /// Answers after their cycle: not obeyed.
    pub late: u64,
    /// Answers older than one that came before: not obeyed.
    pub out_of_order: u64,
    /// Answers to a cycle that was answered: not obeyed.
    pub doubled: u64,
    /// Packets that cannot be read, or answer no cycle that was: not obeyed.
    pub malformed: u64,
    /// Packets from another address: not read.
    pub foreign: u64,
    /// Corrections of which something was cut off.
    pub clamped: u64,
    /// Cycles in real time that began late, because the simulation was not done; none after a missed
    /// answer.
    pub overruns: u64,
}

impl LinkCounts {
    /// Cycles whose answer never came.
    pub fn lost(&self) -> u64 {
        self.cycles.saturating_sub(self.answered + self.late + self.out_of_order)
    }
}

/// The client's side.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ClientCounts {
    /// Packets answered, each with a period of the law.
    pub answered: u64,
    /// Packets with the time stamp of the last one: answered as the last one, the law not asked.
    pub doubled: u64,
    /// Packets older than one that came before, or with a time stamp that cannot be: not answered.
    pub out_of_order: u64,
    /// Cycles whose packet never came, while RSI was on.
    pub lost: u64,
    /// Packets that cannot be read, or lack what the law needs: not answered.
    pub malformed: u64,
    /// Packets from another address than the controller's: not read.
    pub foreign: u64,
    /// Answers that the controller missed, as its packets say.
    pub late: u64,
    /// Periods in which the law was at fault, and its last correction held.
    pub faults: u64,
}

/// What an answer's time stamp says of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Timing {
    /// Of the running cycle.
    InTime,
    /// Of a cycle that is over.
    Late,
    /// Older than one that came.
    OutOfOrder,
    /// Of a cycle that was answered.
    Doubled,
    /// Of no cycle that was.
    Unknown,
}

/// Which cycles were answered.
#[derive(Debug, Clone, Default)]
pub struct Answers {
    /// Time stamps sent, the newest last, and whether they were answered.
    sent: VecDeque<(u64, bool)>,
    newest_answered: Option<u64>,
}

impl Answers {
    /// A cycle begins.
    pub fn sent(&mut self, ipoc: u64) {
        if self.sent.len() == REMEMBERED_CYCLES {
            self.sent.pop_front();
        }
        self.sent.push_back((ipoc, false));
    }

    /// An answer with this time stamp.
    pub fn came(&mut self, ipoc: u64) -> Timing {
        let current = self.sent.back().map(|(current, _)| *current);
        let Some((_, answered)) = self.sent.iter_mut().find(|(sent, _)| *sent == ipoc) else {
            return Timing::Unknown;
        };
        if std::mem::replace(answered, true) {
            return Timing::Doubled;
        }
        let older = self.newest_answered.is_some_and(|newest| ipoc < newest);
        if !older {
            self.newest_answered = Some(ipoc);
        }
        match (older, current == Some(ipoc)) {
            (true, _) => Timing::OutOfOrder,
            (false, true) => Timing::InTime,
            (false, false) => Timing::Late,
        }
    }
}
