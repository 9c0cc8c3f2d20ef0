//! The program `trueweld`, with the laws and effects of this project.

fn main() -> trueweld::Result<()> {
    trueweld::Program::new().run()
}
