//! The program `trueweld`, with the laws and effects of this project.

fn main() -> trueweld_cli::Result<()> {
    trueweld_cli::run(trueweld::Program::new())
}
