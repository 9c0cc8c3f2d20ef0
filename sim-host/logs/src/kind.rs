//! Kinds of logs.

use std::fmt;
use trueweld_plant::named;

named! {
    /// What was done while a log was recorded.
    #[derive(Hash)]
    pub enum LogKind {
        /// Rows at rest, in the order in which loads went up and down.
        StaticLoad = "static-load",
        /// A joint stopped abruptly by its brake.
        RingDown = "ring-down",
        /// Motion without contact.
        FreeMotion = "free-motion",
        /// A weld.
        Weld = "weld",
    }
}

impl fmt::Display for LogKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
