//! The headings of options in the help of commands that have many.

use clap::{Arg, ArgAction, Command};

use crate::{common, tables};

/// Options of a command without headings at most, without those of the program.
const MOST: usize = 15;

const INPUT: &str = "Input";
const COMPUTATION: &str = "Computation";
const OUTPUT: &str = "Output";
const PICTURE: &str = "Picture";
const PERFORMANCE: &str = "Performance";
const CHECKPOINTS: &str = "Checkpoints";

/// All headings, in the order of help.
const ORDER: [&str; 8] = [
    INPUT,
    tables::HEADING,
    COMPUTATION,
    OUTPUT,
    PICTURE,
    PERFORMANCE,
    CHECKPOINTS,
    common::HEADING,
];

/// The headings of options, by their names. All others are about the computation.
const HEADINGS: [(&str, &[&str]); 5] = [
    (
        INPUT,
        &[
            "by-column",
            "columns",
            "config",
            "drop-specks",
            "factor",
            "functions",
            "grow",
            "identity",
            "individual",
            "landmarks",
            "mask",
            "points",
            "require-finite",
            "samples",
            "segments",
            "spectrum",
            "strict",
            "tile",
            "times",
            "unit",
            "weights",
            "weld",
        ],
    ),
    (
        OUTPUT,
        &[
            "accumulator",
            "animation",
            "compress",
            "correlations",
            "cut",
            "every",
            "explain",
            "fps",
            "frames",
            "heights",
            "inlay",
            "left",
            "material",
            "output",
            "paint",
            "path-output",
            "points-output",
            "prolongation",
            "region",
            "report",
            "rest",
            "scores",
            "text",
            "write-material",
        ],
    ),
    (PICTURE, &["coverage", "picture", "render", "up", "view"]),
    (PERFORMANCE, &["backend", "block-rows", "device", "memory", "pin"]),
    (CHECKPOINTS, &["checkpoint", "checkpoint-every", "resume", "state"]),
];

/// Options that mean something else in a command: the command, the option and its heading.
const OTHERS: [(&str, &str, &str); 3] = [
    // Joined vertices and dropped components are results of this command.
    ("mesh", "drop-specks", COMPUTATION),
    ("mesh", "weld", COMPUTATION),
    // The format of the meshes.
    ("wilt", "mesh", OUTPUT),
];

/// Returns a program in which the options of commands with more than [`MOST`] of them have
/// headings, in one order.
pub fn with_headings(program: Command) -> Command {
    let mut command = program.mut_subcommands(with_headings);
    let options = command.get_arguments().filter(|arg| !arg.is_positional());
    let mut placed: Vec<_> = options.map(|arg| (place(&command, arg), id(arg))).collect();
    if placed.len() <= MOST {
        return command;
    }
    placed.sort_by_key(|(place, _)| *place);
    for (place, id) in placed {
        // Moves the option to the end. Headings are in the order of their first options.
        command = command.mut_arg(id, |arg| arg.help_heading(ORDER[place]));
    }
    // That of clap has no heading.
    let help = Arg::new("help").short('h').long("help").action(ArgAction::Help);
    let help = help.help("Print help (see more with '--help')");
    let help = help.long_help("Print help (see a summary with '-h')");
    command.disable_help_flag(true).arg(help.help_heading(common::HEADING))
}

fn id(arg: &Arg) -> String {
    arg.get_id().to_string()
}

/// Returns the number of the heading of an option in [`ORDER`].
fn place(command: &Command, option: &Arg) -> usize {
    let heading = option.get_help_heading().unwrap_or_else(|| heading(command, option));
    ORDER.iter().position(|known| *known == heading).expect("a heading in the order of help")
}

/// Returns the heading of an option that has none.
fn heading(command: &Command, option: &Arg) -> &'static str {
    let name = option.get_long().unwrap_or_default();
    let other =
        OTHERS.iter().find(|(owner, other, _)| *owner == command.get_name() && *other == name);
    let usual = HEADINGS.iter().find(|(_, names)| names.contains(&name));
    let found = other.map(|(.., heading)| *heading);
    found.or(usual.map(|(heading, _)| *heading)).unwrap_or(COMPUTATION)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::program::program;

    /// Returns the commands below a command that have headings, by their words.
    fn with_many_options(command: &Command, path: &str) -> Vec<(String, Command)> {
        let mut found = Vec::new();
        for below in command.get_subcommands() {
            let path = format!("{path} {}", below.get_name()).trim().to_owned();
            found.extend(with_many_options(below, &path));
            let has_heading = |arg: &Arg| arg.get_help_heading() == Some(COMPUTATION);
            if below.get_arguments().any(has_heading) {
                found.push((path, below.clone()));
            }
        }
        found
    }

    #[test]
    fn options_of_commands_with_many_have_headings_in_one_order() {
        let mut program = program();
        program.build();
        let commands = with_many_options(&program, "");
        let names: BTreeSet<&str> = commands.iter().map(|(path, _)| path.as_str()).collect();
        for name in
            ["ata", "lstsq", "decimate", "wilt", "slime", "mesh", "transfer", "unions shape"]
        {
            assert!(names.contains(name), "{name}: {names:?}");
        }
        for (path, command) in &commands {
            let options = command.get_arguments().filter(|arg| !arg.is_positional());
            let places: Vec<usize> = options.map(|option| place(command, option)).collect();
            assert!(places.is_sorted(), "{path}: {places:?}");
            let bare = command.get_arguments().filter(|arg| !arg.is_positional());
            let bare = bare.filter(|arg| arg.get_help_heading().is_none()).map(id);
            assert_eq!(bare.collect::<Vec<_>>(), Vec::<String>::new(), "{path}");
        }
    }

    #[test]
    fn the_names_of_options_with_headings_exist_where_there_are_headings() {
        let commands = with_many_options(&program(), "");
        let has = |command: &Command, name: &str| {
            command.get_arguments().any(|arg| arg.get_long() == Some(name))
        };
        for (heading, names) in HEADINGS {
            for name in names {
                let found = commands.iter().any(|(_, command)| has(command, name));
                assert!(found, "{heading}: {name}");
            }
        }
        for (owner, name, _) in OTHERS {
            let found = commands.iter().any(|(path, command)| path == owner && has(command, name));
            assert!(found, "{owner}: {name}");
        }
    }

    #[test]
    fn long_help_shows_the_headings_once_and_the_flag_for_help_among_the_common_options() {
        let error = program().try_get_matches_from(["catamaran", "ata", "--help"]).unwrap_err();
        let help = error.to_string();
        let titles = help.lines().filter_map(|line| line.strip_suffix(':'));
        let titles: Vec<&str> = titles.filter(|title| !title.starts_with(' ')).collect();
        let wanted = [&["Arguments"][..], &ORDER, &["Examples"]].concat();
        assert_eq!(titles, wanted, "{help}");
        let (_, common) = help.split_once("\nCommon options:\n").unwrap();
        assert!(common.contains("\n  -h, --help\n"), "{help}");
    }
}
