//! Which input files are in order.

use schemars::JsonSchema;
use serde::Serialize;

/// Which input files are in order.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct CheckResult {
    /// Every file, in the order given.
    pub files: Vec<CheckedFile>,
}

impl CheckResult {
    /// Name and version of this format.
    pub const SCHEMA: &'static str = "check/1";
}

/// One input file: of which kind it is, or what is wrong with it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct CheckedFile {
    /// The path as it was given.
    pub file: String,
    /// Whether it is in order.
    pub ok: bool,
    /// Its kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// What is wrong with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// What a reader should know of it: how a log was read, and values that are implausible.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notices: Vec<String>,
}
