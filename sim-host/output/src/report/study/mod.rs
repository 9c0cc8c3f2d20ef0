//! Studies of a cell.

mod paper;
mod sensitivity;
