//! Studies of a cell.

mod layout;
mod limits;
mod paper;
mod sensitivity;
