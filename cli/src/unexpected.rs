//! Errors of unexpected arguments that say what to write instead: the new name of an option that
//! earlier versions called otherwise (clap suggests the nearest name, that of another option), the
//! option of a number or a file that stands alone, and the way to give a value that begins with a
//! minus.

use std::ffi::OsString;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};

/// A command ([`ALL`] for every command), the old name of one of its options, and the name now.
const RENAMED: [(&str, &str, &str); 10] = [
    (ALL, "max-memory", "input-limit"),
    ("ata", "strict", "require-finite"),
    ("demo", "out", "output"),
    ("decimate", "weights", "prolongation"),
    ("newton", "material", "write-material"),
    ("transfer", "smooth", "smooth-functions"),
    ("wilt", "cut", "block-flow"),
    ("wilt", "pin", "hold"),
    ("wilt", "shift", "steepest-at"),
    ("wilt", "fps", "steps-per-second"),
];

const ALL: &str = "";

/// Returns the error of a command line, with the new name where it has an old one, and with the
/// option where it has a number only.
pub fn explained(error: clap::Error, program: &Command, words: &[OsString]) -> clap::Error {
    let inner = words
        .iter()
        .skip(1)
        .fold(program, |outer, word| outer.find_subcommand(word).unwrap_or(outer));
    let command = inner.get_name();
    let Some(ContextValue::String(wrong)) = error.get(ContextKind::InvalidArg) else {
        return error;
    };
    let what = match error.kind() {
        ErrorKind::UnknownArgument => new_name(command, wrong)
            .map(|new| format!("unexpected argument '{wrong}' found: its name is '{new}' now"))
            .or_else(|| names_state(command, wrong, words).then(state_of_resume))
            .or_else(|| number_of_option(inner, wrong, words))
            .or_else(|| value_with_minus(inner, wrong, words)),
        ErrorKind::TooManyValues if command == "slime" && wrong == "--resume" => {
            Some(state_of_resume())
        }
        _ => None,
    };
    let Some(what) = what else { return error };
    let text = format!("{what}\n\nFor more information, try '--help'.\n");
    clap::Error::raw(error.kind(), text).with_cmd(program)
}

/// Returns the new name of an option of a command, with dashes as the old one has.
fn new_name(command: &str, old: &str) -> Option<String> {
    let old = old.strip_prefix("--")?;
    let found = RENAMED
        .iter()
        .find(|(owner, name, _)| *name == old && (*owner == command || *owner == ALL));
    found.map(|(_, _, new)| format!("--{new}"))
}

/// Returns what is wrong with a whole number where the command has an option of one letter only,
/// such as -n, which takes one and is not given.
fn number_of_option(command: &Command, argument: &str, words: &[OsString]) -> Option<String> {
    argument.parse::<u64>().ok()?;
    let is_only = |arg: &&Arg| arg.get_long().is_none() && arg.get_action().takes_values();
    let short = command.get_arguments().filter(is_only).find_map(Arg::get_short)?;
    let option = format!("-{short}");
    let is_given = words.iter().any(|word| word.to_string_lossy().starts_with(&option));
    (!is_given).then(|| {
        format!("unexpected argument '{argument}' found: '{option} {argument}' gives the number")
    })
}

/// Returns what is wrong with a value that begins with a minus: `wrong` is its beginning, which
/// would be an option, and what is before it takes a value.
fn value_with_minus(command: &Command, wrong: &str, words: &[OsString]) -> Option<String> {
    let takes_value = |word: &str| {
        let is_named = |arg: &Arg| arg.get_long().is_some_and(|long| word == format!("--{long}"));
        command.get_arguments().any(|arg| is_named(arg) && arg.get_action().takes_values())
    };
    words.windows(2).find_map(|pair| {
        let [option, value] = [&pair[0], &pair[1]].map(|word| word.to_string_lossy());
        let is_value = wrong.starts_with('-') && !wrong.starts_with("--");
        (is_value && value.starts_with(wrong) && takes_value(&option)).then(|| {
            format!("unexpected argument '{value}' found: '{option}={value}' gives it as a value")
        })
    })
}

/// Returns whether an unexpected argument is the file that `slime --resume` once took.
fn names_state(command: &str, argument: &str, words: &[OsString]) -> bool {
    let mut pairs = words.windows(2);
    command == "slime" && pairs.any(|pair| pair[0] == "--resume" && pair[1] == argument)
}

/// Returns what is wrong with a file behind `slime --resume`.
fn state_of_resume() -> String {
    "'--resume' takes no file: give it with '--state <FILE>', beside '--resume'".into()
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;
    use crate::Cli;

    /// Returns the message for a command line that is wrong.
    fn message(line: &str) -> String {
        let words: Vec<OsString> = line.split_whitespace().map(OsString::from).collect();
        let mut program = Cli::command();
        let error = program.try_get_matches_from_mut(&words).unwrap_err();
        explained(error, &program, &words).to_string()
    }

    #[test]
    fn old_names_are_errors_that_say_the_new_ones() {
        let mut program = Cli::command();
        program.build();
        for (owner, old, new) in RENAMED {
            let commands = if owner == ALL { vec!["ata", "mesh", "slime"] } else { vec![owner] };
            for name in commands {
                let command = program.find_subcommand(name).unwrap();
                let has = |option: &str| {
                    command.get_arguments().any(|known| known.get_long() == Some(option))
                };
                assert!(has(new) && !has(old), "{name}: {old}, {new}");
                for option in [format!("--{old} 3"), format!("--{old}=3"), format!("--{old}")] {
                    let message = message(&format!("catamaran --quiet {name} {option}"));
                    let wanted = format!(
                        "error: unexpected argument '--{old}' found: its name is '--{new}'"
                    );
                    assert!(message.starts_with(&wanted), "{name} {option}: {message}");
                }
            }
        }
    }

    #[test]
    fn a_file_behind_resume_belongs_to_state() {
        for line in ["slime a.obj -o b --resume c.state", "slime a.obj --resume=c.state -o b"] {
            let message = message(&format!("catamaran {line}"));
            assert!(message.starts_with("error: '--resume' takes no file"), "{message}");
            assert!(message.contains("'--state <FILE>'"), "{message}");
        }
    }

    #[test]
    fn a_number_alone_belongs_to_the_option_of_one_letter() {
        for (line, option) in [
            ("decimate a.obj", "-n"),
            ("decimate a.obj -o b.obj", "-n"),
            ("farthest a.obj", "-n"),
            ("spectrum a.obj", "-k"),
            ("basis a.obj", "-k"),
            ("filter a.obj", "-k"),
            ("descriptors a.obj", "-k"),
            ("transfer a.obj b.obj", "-k"),
            ("pca a.csv", "-k"),
            ("unions shape a.obj", "-k"),
        ] {
            let message = message(&format!("catamaran {line} 20"));
            let wanted = format!("error: unexpected argument '20' found: '{option} 20' gives");
            assert!(message.starts_with(&wanted), "{line}: {message}");
        }
        for line in ["decimate a.obj -n 30 20", "decimate a.obj b.obj", "ata a.csv 20"] {
            let message = message(&format!("catamaran {line}"));
            assert!(message.contains("' found\n"), "{line}: {message}");
        }
    }

    #[test]
    fn a_value_that_begins_with_a_minus_is_given_behind_an_equals_sign() {
        for (option, value) in [("--columns", "-a,b"), ("--encoding", "-9,none")] {
            let message = message(&format!("catamaran ata a.csv {option} {value}"));
            let wanted = format!(
                "error: unexpected argument '{value}' found: '{option}={value}' gives it as a value"
            );
            assert!(message.starts_with(&wanted), "{message}");
        }
        for line in ["ata a.csv --header -9,none", "ata a.csv -a,b"] {
            let message = message(&format!("catamaran {line}"));
            assert!(message.contains("' found\n"), "{line}: {message}");
        }
    }

    #[test]
    fn other_mistakes_keep_their_messages() {
        // The second is an old name, but of another command.
        for (line, option) in [("ata a.npy", "verfy"), ("lstsq a.csv", "strict")] {
            let message = message(&format!("catamaran {line} --{option}"));
            let unexpected = format!("error: unexpected argument '--{option}' found\n");
            assert!(message.starts_with(&unexpected), "{message}");
        }
        let extra = message("catamaran slime a.obj b.obj -o c");
        assert!(extra.contains("'b.obj'") && !extra.contains("takes no file"), "{extra}");
    }
}
