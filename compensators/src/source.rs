//! A configuration as a constant of Rust or C.

use crate::configuration::Configuration;
use std::fmt::Write;

/// How Rust writes a name, before its text and after it.
const NAME: [&str; 2] = ["Name::new(", ")"];

impl Configuration {
    /// Its digest in hexadecimal digits, as a certificate has it.
    pub fn digest_text(&self) -> String {
        self.digest().iter().fold(String::new(), |text, byte| format!("{text}{byte:02x}"))
    }

    /// A file of Rust that defines it as `CONFIGURATION`, with its digest. `heading`: lines of text
    /// that say what it is of.
    pub fn rust_source(&self, heading: &str) -> String {
        let comment: String = heading.lines().map(|line| format!("// {line}\n")).collect();
        format!(
            "{comment}use trueweld_compensators::{{\n    Configuration, ControlNumbers, GainNumbers, \
             JointNumbers, LawNumbers, LimitNumbers, Name,\n    RobotNumbers,\n}};\n\n\
             /// SHA-256 of the configuration.\npub const DIGEST: [u8; 32] = {:?};\n\n\
             /// All that the controller's core is built from.\n\
             // Some angle is a quarter turn.\n#[allow(clippy::approx_constant)]\n\
             pub const CONFIGURATION: Configuration = {self:#?};\n",
            self.digest()
        )
    }

    /// A header of C99 and C++ that defines it as `trueweld_cell`, with its digest and the bytes of memory
    /// that the core takes in `float` and in `double`. `heading` as of
    /// [`rust_source`](Self::rust_source).
    pub fn c_header(&self, heading: &str, bytes: [usize; 2]) -> String {
        let comment: String = heading.lines().map(|line| format!("   {line}\n")).collect();
        let digest: Vec<String> = self.digest().iter().map(u8::to_string).collect();
        let digest = digest.join(", ");
        let [single, double] = bytes;
        let mut header = format!(
            "/*\n{comment}*/\n#ifndef TRUEWELD_CELL_H\n#define TRUEWELD_CELL_H\n\n\
             #include \"trueweld.h\"\n\n\
             /* Bytes of memory that the core takes in float and in double, at most. */\n\
             #define TRUEWELD_CELL_BYTES_F32 {single}u\n#define TRUEWELD_CELL_BYTES_F64 {double}u\n\n\
             /* SHA-256 of the configuration. */\n\
             static const uint8_t trueweld_cell_digest[32] = {{{digest}}};\n\n\
             /* All that the controller's core is built from. */\n\
             static const TrueweldConfiguration trueweld_cell = "
        );
        // Debug of structs, arrays, names and numbers differs from C in so much. Names of fields are
        // comments: C++ knows no initialiser by name before C++20.
        for line in format!("{self:#?}").lines() {
            let value = line.trim_start();
            let indent = " ".repeat(line.len() - value.len());
            let (key, value) = match value.split_once(": ") {
                Some((key, value)) => (format!("/* {key} */ "), value),
                None => (String::new(), value),
            };
            let value = value.strip_prefix(NAME[0]).map_or_else(
                || match value.strip_suffix('{') {
                    Some(_) => "{".to_owned(),
                    None => value.replace('[', "{").replace(']', "}"),
                },
                |name| name.replace(NAME[1], ""),
            );
            // Writing to a string does not fail.
            let _ = writeln!(header, "{indent}{key}{value}");
        }
        header.truncate(header.trim_end().len());
        header + ";\n\n#endif\n"
    }
}
