//! `-` as the name of a file.

use std::any::TypeId;
use std::path::PathBuf;

use clap::{Arg, ArgMatches, Command};

/// Returns the first option whose file is called `-`, if there is one: the name of a file must
/// select its format. Options that can read stdin have another type,
/// [`TextFile`](crate::input::TextFile).
pub fn dash(command: &Command, matches: &ArgMatches) -> Option<String> {
    let is_dash = |arg: &&Arg| {
        let values = matches.try_get_raw(arg.get_id().as_str()).ok().flatten();
        arg.get_value_parser().type_id() == TypeId::of::<PathBuf>()
            && values.is_some_and(|mut values| values.any(|value| value == "-"))
    };
    let found = command.get_arguments().find(is_dash).map(ToString::to_string);
    found.or_else(|| {
        let (name, matches) = matches.subcommand()?;
        dash(command.find_subcommand(name)?, matches)
    })
}
