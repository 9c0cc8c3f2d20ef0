//! The command line that comes to the same result, for those who repeat it.

use crate::session;
use clap::CommandFactory;
use clap::parser::ValueSource;

/// The command line of the command that runs as a shell takes it, without options that do not matter
/// to others.
pub(crate) fn command_line(command: &str, without: &[&str]) -> String {
    let program = crate::Arguments::command();
    let all = program.clone().get_matches_from(session::arguments());
    let mut words = vec![program.get_name().to_owned(), command.to_owned()];
    if let (Some(given), Some(of)) =
        (all.subcommand_matches(command), program.find_subcommand(command))
    {
        for option in of.get_arguments() {
            let (id, name) = (option.get_id().as_str(), option.get_long().unwrap_or_default());
            if without.contains(&name) || given.value_source(id) != Some(ValueSource::CommandLine) {
                continue;
            }
            if !option.get_action().takes_values() {
                words.push(format!("--{name}"));
                continue;
            }
            for value in given.get_raw(id).into_iter().flatten() {
                words.extend([format!("--{name}"), value.to_string_lossy().into_owned()]);
            }
        }
    }
    shlex::try_join(words.iter().map(String::as_str)).unwrap_or_else(|_| words.join(" "))
}
