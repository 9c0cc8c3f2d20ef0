//! Diagnosis of logs and files as they come.

mod accuracy;
mod any_file;
mod evidence;
mod fit;
mod plan;
