//! Input files, effects and the motion of the cell.

mod cell;
mod input;
mod model;
