//! What people and programs are shown of results.

mod live;
mod reports;
mod sample;
