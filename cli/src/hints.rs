//! Checks of the options that messages, notes and help texts name, of their values, and of the
//! options that they need.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use clap::error::ErrorKind;
use clap::{ArgGroup, Command, CommandFactory as _, Id};

use crate::{Cli, parse};

/// Options of scripts and of launchers, and of cargo in prose.
const OTHERS: [&str; 7] = [
    "--features",
    "--sanitize",
    "--transformer",
    "--mpi",
    "--bind-to",
    "--cpus-per-task",
    "--signal",
];

/// Returns the options of a command and of those below it.
fn options(command: &Command) -> BTreeSet<String> {
    let own = command.get_arguments().filter_map(|argument| argument.get_long());
    let own = own.map(|name| format!("--{name}"));
    own.chain(command.get_subcommands().flat_map(options)).collect()
}

/// Adds the options of the commands below this one, by the names of the commands.
fn by_name(command: &Command, found: &mut BTreeMap<String, BTreeSet<String>>) {
    for below in command.get_subcommands() {
        found.entry(below.get_name().to_owned()).or_default().extend(options(below));
        by_name(below, found);
    }
}

/// Returns the command that a file of the command line belongs to; the program, if there are
/// several.
fn owner<'a>(program: &'a Command, file: &Path) -> &'a Command {
    // A page about all commands.
    if file.starts_with("demo") {
        return program;
    }
    let mut owner = program;
    for part in file {
        let name = Path::new(part).file_stem().and_then(|name| name.to_str()).unwrap_or_default();
        let Some(below) = owner.find_subcommand(name) else { break };
        owner = below;
    }
    owner
}

/// Returns the word at the end of a text, placeholders in braces left out.
fn last_word(mut text: &str) -> &str {
    text = text.trim_end();
    while let Some((before, _)) = text.strip_suffix('}').and_then(|text| text.rsplit_once('{')) {
        text = before.trim_end();
    }
    text.rsplit(|c: char| !c.is_ascii_lowercase() && c != '-').next().unwrap_or_default()
}

/// Returns the options in a line, each after the word before it, which may be a command.
fn named(line: &str) -> Vec<(&str, &str)> {
    let mut found = Vec::new();
    for (at, _) in line.match_indices("--") {
        let (before, rest) = line.split_at(at);
        let is_part = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        let end = rest.find(|c: char| !is_part(c)).unwrap_or(rest.len());
        let begins = !before.ends_with(|c: char| c.is_alphanumeric() || c == '-');
        if begins && rest[2..].starts_with(|c: char| c.is_ascii_lowercase()) {
            found.push((last_word(before), &rest[..end]));
        }
    }
    found
}

/// Returns the source files in a folder and below it.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let files = entries.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] });
    files.filter(|path| path.extension().is_some_and(|extension| extension == "rs")).collect()
}

/// Other programs, whose options stand in the lines that name them.
const PROGRAMS: [&str; 3] = ["cargo ", "`meshio ", "`psql "];

#[test]
fn options_in_texts_are_those_of_their_command_or_of_the_command_named_before_them() {
    let mut program = Cli::command();
    program.build();
    let mut commands = BTreeMap::new();
    by_name(&program, &mut commands);
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut faults, mut count) = (Vec::new(), 0);
    let library = ["../src", "../geometry/src", "../simulation/src"].map(|f| (here.join(f), false));
    for (root, is_program) in [(here.join("src"), true)].into_iter().chain(library) {
        for file in sources(&root) {
            let inside = file.strip_prefix(&root).unwrap();
            let own = options(if is_program { owner(&program, inside) } else { &program });
            for (number, line) in (1..).zip(fs::read_to_string(&file).unwrap().lines()) {
                for (command, option) in named(line) {
                    if PROGRAMS.iter().any(|program| line.contains(program)) {
                        continue;
                    }
                    let other = commands.get(command).is_some_and(|own| own.contains(option));
                    if !own.contains(option) && !other && !OTHERS.contains(&option) {
                        faults.push(format!("{}:{number}: {option}", file.display()));
                    }
                    count += 1;
                }
            }
        }
    }
    assert!(count > 150, "{count}");
    assert!(faults.is_empty(), "options that do not exist there:\n{}", faults.join("\n"));
}

#[test]
fn options_are_found_in_lines() {
    let line = "note: `catamaran mesh {path}{flag} --compact -o FILE` (--weld joins; a--b --- --9)";
    assert_eq!(named(line), [("mesh", "--compact"), ("", "--weld")]);
    assert_eq!(named("(ata --center)"), [("ata", "--center")]);
}

/// Adds a command line for each option with a value, of this command and of those below it: -1 is
/// the value.
fn negative(command: &Command, words: &[String], found: &mut Vec<Vec<String>>) {
    for argument in command.get_arguments().filter(|argument| !argument.is_positional()) {
        let long = argument.get_long().map(|name| format!("--{name}"));
        let flag = long.or_else(|| argument.get_short().map(|name| format!("-{name}")));
        if argument.get_action().takes_values() && !argument.is_require_equals_set() {
            found.push(words.iter().cloned().chain(flag).chain(["-1".to_owned()]).collect());
        }
    }
    for below in command.get_subcommands() {
        negative(below, &[words, &[below.get_name().to_owned()]].concat(), found);
    }
}

#[test]
fn minus_one_is_a_value_of_every_option() {
    let program = parse::with_negative_numbers(Cli::command());
    let mut lines = Vec::new();
    negative(&program, &["catamaran".to_owned()], &mut lines);
    assert!(lines.len() > 200, "{}", lines.len());
    for line in lines {
        if let Err(error) = program.clone().try_get_matches_from(&line) {
            assert_ne!(error.kind(), ErrorKind::UnknownArgument, "{line:?}: {error}");
        }
    }
}

/// Returns the fields in a source file whose option requires another one, and that one. clap does
/// not tell.
fn requirements(text: &str) -> Vec<(String, String)> {
    let pairs = text.split("requires = \"").skip(1).filter_map(|rest| {
        let (needed, rest) = rest.split_once('"')?;
        let (_, rest) = rest.split_once(")]")?;
        let (field, _) = rest.split_once(':')?;
        Some((field.split_whitespace().last()?.to_owned(), needed.to_owned()))
    });
    pairs.collect()
}

/// Returns the arguments of a command that exclude each other: each pair in both orders.
fn exclusions(command: &Command) -> BTreeSet<(String, String)> {
    let mut found = BTreeSet::new();
    let mut add = |a: &Id, b: &Id| {
        found.insert((a.to_string(), b.to_string()));
        found.insert((b.to_string(), a.to_string()));
    };
    for argument in command.get_arguments() {
        for other in command.get_arg_conflicts_with(argument) {
            add(argument.get_id(), other.get_id());
        }
    }
    for group in command.get_groups().filter(|group| !ArgGroup::clone(group).is_multiple()) {
        for one in group.get_args() {
            group.get_args().filter(|other| *other != one).for_each(|other| add(one, other));
        }
    }
    found
}

/// Adds the options of a command, and of those below it, that clap accepts without what they
/// require: beside an argument that excludes what is required, but not the option.
fn unsupported(command: &Command, required: &[(String, String)], found: &mut Vec<String>) {
    let exclusions = exclusions(command);
    let has = |id: &str| command.get_arguments().any(|argument| argument.get_id().as_str() == id);
    for (option, needed) in required.iter().filter(|(option, needed)| has(option) && has(needed)) {
        for (_, other) in exclusions.iter().filter(|(one, _)| one == needed) {
            if !exclusions.contains(&(option.clone(), other.clone())) {
                let name = command.get_name();
                found.push(format!("{name}: {option} requires {needed}, which excludes {other}"));
            }
        }
    }
    command.get_subcommands().for_each(|below| unsupported(below, required, found));
}

#[test]
fn what_excludes_a_required_option_excludes_those_that_require_it() {
    let mut program = Cli::command();
    program.build();
    let files = sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    let required: Vec<_> =
        files.iter().flat_map(|file| requirements(&fs::read_to_string(file).unwrap())).collect();
    assert!(required.len() > 20, "{required:?}");
    let mut faults = Vec::new();
    unsupported(&program, &required, &mut faults);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn options_without_what_they_require_are_found() {
    let text = "#[arg(long, requires = \"b\", value_name = \"N\")]\n    pub(crate) a: bool,\n";
    let required = requirements(text);
    assert_eq!(required, [("a".to_owned(), "b".to_owned())]);
    let option = |name: &'static str| clap::Arg::new(name).long(name);
    let command = |b: clap::Arg| Command::new("x").args([option("a"), b, option("c")]);
    let faults = |command: Command| {
        let mut found = Vec::new();
        unsupported(&command, &required, &mut found);
        found
    };
    let excluding = command(option("b").conflicts_with("c"));
    let all = [excluding.clone(), command(option("b")).group(ArgGroup::new("g").args(["b", "c"]))];
    for command in all {
        assert_eq!(faults(command), ["x: a requires b, which excludes c"]);
    }
    assert!(faults(excluding.mut_arg("a", |a| a.conflicts_with("c"))).is_empty());
}
