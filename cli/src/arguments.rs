//! Names the options of the command line in errors of the library, which name its arguments.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use catamaran::Error;
use clap::{ArgMatches, Command};

use crate::parse::levels;

/// Arguments of the library whose options have other names: command, argument and option.
const OTHERS: &[(&str, &str, &str)] = &[
    ("distance", "sources", "--from"),
    ("distance", "targets", "--to"),
    ("distance", "end", "--to"),
    ("distance", "through", "--to"),
    ("distance", "start", "--from"),
    ("distance", "direction", "--trace"),
    ("distance", "length", "--length"),
    ("decimate", "relaxation", "--relax"),
];

/// The options of the command that runs, by the arguments of the library.
static OPTIONS: OnceLock<BTreeMap<String, String>> = OnceLock::new();

/// Notes which command runs.
pub fn set_command(program: &Command, matches: &ArgMatches) {
    let innermost = levels(program, matches).last().map_or(program, |(command, _)| command);
    OPTIONS.get_or_init(|| options(innermost));
}

/// Returns the options of a command by the arguments of the library that would puzzle its users:
/// those whose name is not that of an option, or has another form.
fn options(command: &Command) -> BTreeMap<String, String> {
    let longs = command.get_arguments().filter_map(|argument| argument.get_long());
    let longs = longs.filter(|long| long.contains('-'));
    let mut found: BTreeMap<String, String> =
        longs.map(|long| (long.replace('-', "_"), format!("--{long}"))).collect();
    let others = OTHERS.iter().filter(|(name, ..)| *name == command.get_name());
    found.extend(others.map(|(_, argument, option)| ((*argument).into(), (*option).into())));
    found
}

/// Returns the text of an error of the library, in which an option stands for its argument.
pub fn message(error: &Error) -> String {
    match OPTIONS.get() {
        Some(options) => with(options, error),
        None => error.to_string(),
    }
}

fn with(options: &BTreeMap<String, String>, error: &Error) -> String {
    match error {
        Error::Argument { what, why } if options.contains_key(*what) => {
            format!("{}: {why}", options[*what])
        }
        error => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;
    use crate::Cli;

    fn said(command: &str, what: &'static str) -> String {
        let program = Cli::command();
        let options = options(program.find_subcommand(command).unwrap());
        with(&options, &Error::Argument { what, why: "no".into() })
    }

    #[test]
    fn errors_name_the_option_of_the_command_for_an_argument_of_the_library() {
        assert_eq!(said("mesh", "drop_specks"), "--drop-specks: no");
        assert_eq!(said("decimate", "drop_specks"), "--drop-specks: no");
        assert_eq!(said("distance", "sources"), "--from: no");
        assert_eq!(said("distance", "through"), "--to: no");
        assert_eq!(said("mesh", "sources"), "sources: no");
        assert_eq!(said("slime", "movement_speed"), "movement_speed: no");
    }

    #[test]
    fn other_names_are_those_of_options_that_exist() {
        let program = Cli::command();
        for &(name, _, option) in OTHERS {
            let command = program.find_subcommand(name).unwrap();
            let mut longs = command.get_arguments().filter_map(|argument| argument.get_long());
            assert!(longs.any(|long| option == format!("--{long}")), "{name} {option}");
        }
    }
}
