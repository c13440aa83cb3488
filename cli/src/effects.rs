//! Options that have an effect only with some values of another option.

use clap::ArgMatches;
use clap::parser::ValueSource;

/// A command, an option of it, another option, and the values of the latter with which the former
/// has an effect.
type Rule = (&'static str, &'static str, &'static str, &'static [&'static str]);

const RULES: &[Rule] = &[
    ("curve", "candidates", "mode", &["faithful"]),
    ("curve", "start", "mode", &["faithful"]),
    ("distance", "laplacian", "method", &["heat"]),
    ("distance", "time", "method", &["heat"]),
    ("transfer", "zoom", "refine", &["zoomout"]),
];

/// Returns a complaint about the first option on the command line that has no effect, if there is
/// one.
pub fn missing(matches: &ArgMatches) -> Option<String> {
    let (name, matches) = matches.subcommand()?;
    let has_none = |(command, option, other, values): &&Rule| {
        *command == name
            && matches.value_source(option) == Some(ValueSource::CommandLine)
            && !value(matches, other).is_some_and(|value| values.contains(&value))
    };
    let (_, option, other, values) = RULES.iter().find(has_none)?;
    Some(format!("--{option} is for --{other} {} only", values.join(" or ")))
}

/// Returns the value of an option as text.
fn value<'a>(matches: &'a ArgMatches, option: &str) -> Option<&'a str> {
    matches.get_raw(option)?.next_back()?.to_str()
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;
    use crate::Cli;

    fn complaint(line: &str) -> Option<String> {
        missing(&Cli::command().try_get_matches_from(line.split(' ')).unwrap())
    }

    #[test]
    fn options_are_refused_only_where_they_are_given_and_have_no_effect() {
        let distance = "catamaran distance a.obj --from 1 -o d.csv";
        assert_eq!(complaint(distance), None);
        assert_eq!(complaint(&format!("{distance} --time 2")), None);
        assert_eq!(complaint(&format!("{distance} --method edges")), None);
        for (option, value) in [("time", "2"), ("laplacian", "cotan")] {
            let line = format!("{distance} --method edges --{option} {value}");
            let says = format!("--{option} is for --method heat only");
            assert_eq!(complaint(&line), Some(says));
        }
        let curve = "catamaran curve a.obj --samples s.txt -o c.obj --start 1";
        assert_eq!(complaint(curve).unwrap(), "--start is for --mode faithful only");
        assert_eq!(complaint(&format!("{curve} --mode faithful -l 3")), None);
    }

    #[test]
    fn rules_name_options_and_values_that_exist() {
        let program = Cli::command();
        for &(name, option, other, values) in RULES {
            let command = program.find_subcommand(name).unwrap();
            let long = |id: &str| {
                let argument = command.get_arguments().find(|argument| argument.get_id() == id);
                argument.filter(|argument| argument.get_long() == Some(id)).unwrap()
            };
            long(option);
            let known = long(other).get_possible_values();
            for value in values {
                assert!(known.iter().any(|known| known.get_name() == *value), "{other} {value}");
            }
        }
    }
}
