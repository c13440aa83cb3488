//! `-` as the name of a file.

use std::any::TypeId;
use std::path::PathBuf;

use clap::{Arg, ArgMatches, Command};

use crate::parse::levels;

/// Returns the first option whose file is called `-`, if there is one: the name of a file must
/// select its format. Options that can read stdin have another type,
/// [`TextFile`](crate::input::TextFile).
pub fn dash(command: &Command, matches: &ArgMatches) -> Option<String> {
    levels(command, matches).find_map(|(command, matches)| {
        let is_dash = |arg: &&Arg| {
            let values = matches.try_get_raw(arg.get_id().as_str()).ok().flatten();
            arg.get_value_parser().type_id() == TypeId::of::<PathBuf>()
                && values.is_some_and(|mut values| values.any(|value| value == "-"))
        };
        command.get_arguments().find(is_dash).map(ToString::to_string)
    })
}
