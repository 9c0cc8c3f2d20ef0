//! One part of a certification, or of a study, that is made apart from the others.

use serde::{Deserialize, Serialize};
use std::fmt::{Display, Formatter};
use std::str::FromStr;

/// One part of so many: number from 1 on, and how many there are. Written `2/8`.
///
/// Shard i of n makes every n-th run, from the i-th on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shard {
    pub(super) number: usize,
    pub(super) of: usize,
}

/// Most shards: as many as there may be trials.
const MOST_SHARDS: usize = 100_000;

/// A text that names no shard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected I/N with I from 1 to N and N up to {MOST_SHARDS}, as 2/8")]
pub struct NoShardName;

impl Display for Shard {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = NoShardName;

    fn from_str(text: &str) -> Result<Self, NoShardName> {
        let numbers = text.split_once('/').and_then(|(number, of)| {
            Some(Self { number: number.parse().ok()?, of: of.parse().ok()? })
        });
        let is_possible = |shard: &Self| {
            (1..=MOST_SHARDS).contains(&shard.of) && (1..=shard.of).contains(&shard.number)
        };
        numbers.filter(is_possible).ok_or(NoShardName)
    }
}

impl Shard {
    /// What this shard makes of the whole.
    pub fn part<J>(self, jobs: Vec<J>) -> Vec<J> {
        jobs.into_iter().skip(self.number - 1).step_by(self.of).collect()
    }
}
