//! Options that have an effect only with some values of another option.

use clap::parser::ValueSource;
use clap::{ArgMatches, Args as _, Command};

use crate::tables::TableArgs;

/// A command, an option of it, another option, and the values of the latter with which the former
/// has an effect.
type Rule = (&'static str, &'static str, &'static str, &'static [&'static str]);

const RULES: &[Rule] = &[
    ("curve", "candidates", "mode", &["faithful"]),
    ("curve", "start", "mode", &["faithful"]),
    ("decimate", "cut_handles", "method", &["uniform"]),
    ("decimate", "lloyd", "method", &["uniform"]),
    ("decimate", "relax", "method", &["uniform"]),
    ("descriptors", "laplacian", "kind", &["hks", "wks", "gps"]),
    ("distance", "laplacian", "method", &["heat"]),
    ("distance", "time", "method", &["heat"]),
    ("transfer", "zoom", "refine", &["zoomout"]),
];

/// A command, and an option of it that names a table, without which the options of input tables
/// have no effect.
const TABLES: &[(&str, &str)] = &[("descriptors", "functions"), ("filter", "functions")];

/// Returns a complaint about the first option on the command line that has no effect, if there is
/// one.
pub fn missing(matches: &ArgMatches) -> Option<String> {
    let (name, matches) = matches.subcommand()?;
    let is_given = |option: &str| matches.value_source(option) == Some(ValueSource::CommandLine);
    let has_none = |(command, option, other, values): &&Rule| {
        *command == name
            && is_given(option)
            && !value(matches, other).is_some_and(|value| values.contains(&value))
    };
    if let Some((_, option, other, values)) = RULES.iter().find(has_none) {
        return Some(format!("{} is for --{other} {} only", long(option), values.join(" or ")));
    }
    let (_, table) = TABLES.iter().find(|(command, table)| *command == name && !is_given(table))?;
    let option = of_tables().into_iter().find(|option| is_given(option))?;
    Some(format!("{} is for {} only", long(&option), long(table)))
}

/// Returns the options of input tables.
fn of_tables() -> Vec<String> {
    let command = TableArgs::augment_args(Command::new("tables"));
    command.get_arguments().map(|argument| argument.get_id().to_string()).collect()
}

/// Returns an option as it is on the command line.
fn long(option: &str) -> String {
    format!("--{}", option.replace('_', "-"))
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
        let decimate = "catamaran decimate a.obj -n 9 -o d.obj --method";
        for option in ["--lloyd 2", "--relax 2", "--cut-handles"] {
            let name = option.split(' ').next().unwrap();
            let says = format!("{name} is for --method uniform only");
            assert_eq!(complaint(&format!("{decimate} thesis {option}")), Some(says));
            assert_eq!(complaint(&format!("{decimate} uniform {option}")), None);
        }
        let shot = "catamaran descriptors a.obj -o d.csv --laplacian tufted --radius 1 --kind";
        let says = "--laplacian is for --kind hks or wks or gps only";
        assert_eq!(complaint(&format!("{shot} shot")).unwrap(), says);
        assert_eq!(complaint(&format!("{shot} wks")), None);
    }

    #[test]
    fn options_of_tables_are_refused_without_a_table() {
        for line in ["descriptors a.obj -o d.csv --kind hks", "filter a.obj -o b.obj --heat 1"] {
            let line = format!("catamaran {line}");
            assert_eq!(complaint(&line), None);
            for option in ["--no-header", "--separator tab", "--missing error"] {
                let name = option.split(' ').next().unwrap();
                let says = format!("{name} is for --functions only");
                assert_eq!(complaint(&format!("{line} {option}")), Some(says));
                assert_eq!(complaint(&format!("{line} {option} --functions f.csv")), None);
            }
        }
    }

    #[test]
    fn rules_name_options_and_values_that_exist() {
        let program = Cli::command();
        for &(name, option, other, values) in RULES {
            let command = program.find_subcommand(name).unwrap();
            let named = |id: &str| {
                let argument = command.get_arguments().find(|argument| argument.get_id() == id);
                let is_long = |name: &str| long(id).strip_prefix("--") == Some(name);
                argument.filter(|argument| argument.get_long().is_some_and(is_long)).unwrap()
            };
            named(option);
            let known = named(other).get_possible_values();
            for value in values {
                assert!(known.iter().any(|known| known.get_name() == *value), "{other} {value}");
            }
        }
        for &(name, table) in TABLES {
            let command = program.find_subcommand(name).unwrap();
            for option in of_tables().iter().map(String::as_str).chain([table]) {
                assert!(command.get_arguments().any(|argument| argument.get_id() == option));
            }
        }
    }
}
