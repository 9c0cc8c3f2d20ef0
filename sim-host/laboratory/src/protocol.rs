//! What is measured: which logs a campaign holds, and how long they are.

/// Which logs a campaign holds, and how long they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Protocol {
    /// Postures of the static log, about eight rows each; 0 leaves the log out.
    pub postures: usize,
    /// Ring-down logs, among which the joints are divided; 0 to 6.
    pub rings: usize,
    /// Length of a ring-down, s.
    pub ring: f64,
    /// Length of the free motion, s; 0 leaves the log out.
    pub free: f64,
    /// Welds, besides one held out; 0 leaves all of them out.
    pub welds: usize,
    /// Length of a seam, m.
    pub seam: f64,
}

impl Protocol {
    /// What a laboratory measures in a day.
    pub fn usual() -> Self {
        Self { postures: 6, rings: 2, ring: 1.0, free: 12.0, welds: 2, seam: 0.2 }
    }

    /// One log of each kind, as short as it can be: for tests.
    pub fn short() -> Self {
        Self { postures: 4, rings: 1, ring: 0.6, free: 2.0, welds: 1, seam: 0.02 }
    }

    /// What is held out of a campaign: fewer static postures, a shorter motion and one weld, all of
    /// them elsewhere.
    pub(crate) fn held_out(&self) -> Self {
        Self {
            postures: self.postures.div_ceil(2),
            rings: 0,
            free: 0.6 * self.free,
            welds: self.welds.min(1),
            ..self.clone()
        }
    }
}
