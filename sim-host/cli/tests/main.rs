//! The program as a user runs it.

mod certificate;
mod cli;
mod docs;
mod files;
mod first_day;
mod fleet;
mod milling;
mod mistakes;
mod rare;
mod record;
mod rsi;
mod samples;
mod session;
mod shards;
mod study;
mod support;
mod tune;
mod what_if;
