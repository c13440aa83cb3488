//! `-` as the name of a file.

use std::any::TypeId;
use std::path::PathBuf;

use clap::{Arg, ArgMatches, Command};

use crate::input::TextFile;
use crate::parse::levels;
use crate::tables::MatrixFile;

/// Returns why a `-` of the command line can't be the name of a file, if there is such a one: the
/// name of a file must select its format, unless the file may be stdin, and stdin is read once.
pub fn refusal(command: &Command, matches: &ArgMatches) -> Option<String> {
    let mut reader: Option<&Arg> = None;
    for (command, matches) in levels(command, matches) {
        for arg in command.get_arguments() {
            let values = matches.try_get_raw(arg.get_id().as_str()).ok().flatten();
            let dashes = values.into_iter().flatten().filter(|value| *value == "-").count();
            let kind = arg.get_value_parser().type_id();
            if kind == TypeId::of::<PathBuf>() && dashes > 0 {
                let what = "`-` is not accepted; the name of a file must select its format";
                return Some(format!("{arg}: {what}"));
            }
            if kind != TypeId::of::<TextFile>() && kind != TypeId::of::<MatrixFile>() {
                continue;
            }
            for _ in 0..dashes {
                if let Some(first) = reader.replace(arg) {
                    return Some(format!("stdin (`-`) can't be both {first} and {arg}"));
                }
            }
        }
    }
    None
}
