//! The program, whose help lists the commands in sections.

use clap::{Command, CommandFactory as _};

use crate::examples::with_examples;
use crate::headings::with_headings;
use crate::{Cli, parse};

/// The commands of the program, in the sections of `catamaran --help`.
const SECTIONS: [(&str, &[&str]); 4] = [
    ("Matrices", &["ata", "ata-merge", "lstsq", "predict", "pca", "svd"]),
    (
        "Meshes",
        &[
            "mesh",
            "generate",
            "decimate",
            "farthest",
            "distance",
            "curve",
            "spectrum",
            "basis",
            "filter",
            "transfer",
            "descriptors",
            "shapedna",
            "unions",
        ],
    ),
    ("Simulations", &["wilt", "slime", "newton"]),
    ("Tools", &["info", "tune", "demo", "completions", "man", "help"]),
];

/// Returns the program that parses command lines, prints help and writes man pages.
pub fn program() -> Command {
    let program = with_headings(with_examples(Cli::command()));
    let template = template(&program);
    parse::with_negative_numbers(program.help_template(template))
}

/// Returns the template of the help of the program: its commands in sections, then its options.
fn template(program: &Command) -> String {
    let styles = program.get_styles();
    let (header, literal) = (styles.get_header(), styles.get_literal());
    let names = SECTIONS.iter().flat_map(|(_, names)| names.iter());
    let width = names.map(|name| name.len()).max().unwrap_or_default();
    let mut text = "{before-help}{about-with-newline}\n{usage-heading} {usage}\n".to_owned();
    for (title, names) in SECTIONS {
        text += &format!("\n{header}{title}:{header:#}\n");
        for name in names {
            let about = program.find_subcommand(name).and_then(Command::get_about);
            let about = about.map(ToString::to_string).unwrap_or_default();
            text += &format!("  {literal}{name:width$}{literal:#}  {about}\n");
        }
    }
    text + &format!("\n{header}Options:{header:#}\n{{options}}{{after-help}}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns of the sentence about a command at most.
    const COLUMNS: usize = 80;

    #[test]
    fn every_command_is_in_one_section() {
        let program = Cli::command();
        let mut commands: Vec<_> = program.get_subcommands().map(Command::get_name).collect();
        let mut listed: Vec<_> = SECTIONS.iter().flat_map(|(_, names)| names.to_vec()).collect();
        commands.sort_unstable();
        listed.sort_unstable();
        assert_eq!(listed, commands);
    }

    /// Adds the commands below this one whose sentence is too long, or is not one sentence.
    fn add_long(command: &Command, found: &mut Vec<String>) {
        for below in command.get_subcommands() {
            let about = below.get_about().map(ToString::to_string).unwrap_or_default();
            if about.is_empty() || about.chars().count() > COLUMNS || about.contains(". ") {
                found.push(format!("{}: {about}", below.get_name()));
            }
            add_long(below, found);
        }
    }

    #[test]
    fn lists_of_commands_have_one_short_sentence_for_each() {
        let mut long = Vec::new();
        add_long(&Cli::command(), &mut long);
        assert!(long.is_empty(), "{}", long.join("\n"));
    }

    #[test]
    fn the_help_of_the_program_has_its_sections_in_order() {
        let help = program().render_help().to_string();
        let mut rest = help.as_str();
        for (title, names) in SECTIONS {
            let lines = names.iter().map(|name| format!("\n  {name} "));
            for text in [format!("\n\n{title}:\n")].into_iter().chain(lines) {
                let at = rest.find(&text).unwrap_or_else(|| panic!("{text:?} in {help}"));
                // The end of a line begins the next text.
                rest = &rest[at + text.trim_end().len()..];
            }
        }
        assert!(rest.contains("\n\nOptions:\n") && rest.contains("--input-limit"), "{help}");
    }
}
