//! Kinds of logs.

use std::fmt;

/// What was done while a log was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LogKind {
    /// Rows at rest, in the order in which loads went up and down.
    StaticLoad,
    /// A joint stopped abruptly by its brake.
    RingDown,
    /// Motion without contact.
    FreeMotion,
    /// A weld.
    Weld,
}

impl LogKind {
    /// Every kind of log.
    pub const ALL: [Self; 4] = [Self::StaticLoad, Self::RingDown, Self::FreeMotion, Self::Weld];

    /// The name in `log.toml` and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::StaticLoad => "static-load",
            Self::RingDown => "ring-down",
            Self::FreeMotion => "free-motion",
            Self::Weld => "weld",
        }
    }
}

impl fmt::Display for LogKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
