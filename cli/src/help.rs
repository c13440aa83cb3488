//! Checks of the help texts of all commands.

use std::collections::BTreeMap;

use clap::{Command, CommandFactory as _};

use crate::Cli;

/// Words that no sentence ends with.
const OPEN_ENDS: [&str; 9] = ["a", "an", "the", "and", "or", "of", "is", "are", "whose"];

/// Returns the help texts of a command and of those below, with the places that they are in.
fn texts(command: &Command, path: &str, found: &mut BTreeMap<String, String>) {
    let name = format!("{path} {}", command.get_name()).trim_start().to_owned();
    let mut add = |place: String, text: Option<String>| {
        if let Some(text) = text {
            found.insert(place, text);
        }
    };
    let text = |styled: Option<&clap::builder::StyledStr>| styled.map(ToString::to_string);
    add(name.clone(), text(command.get_about()));
    add(format!("{name} (long)"), text(command.get_long_about()));
    for argument in command.get_arguments() {
        let place = format!("{name} {}", argument.get_id());
        add(place.clone(), text(argument.get_help()));
        add(format!("{place} (long)"), text(argument.get_long_help()));
        for value in argument.get_possible_values() {
            add(format!("{place} {}", value.get_name()), text(value.get_help()));
        }
    }
    for below in command.get_subcommands() {
        texts(below, &name, found);
    }
}

/// Returns the sentences of a text: what ends with a stop before a blank, or with the paragraph.
fn sentences(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for paragraph in text.split("\n\n") {
        let line = paragraph.split_whitespace().collect::<Vec<_>>().join(" ");
        let mut start = 0;
        for (at, _) in line.match_indices(". ") {
            // Not after an abbreviation or within an enumeration such as `FIRST ... LAST`.
            let before = line[start..at].rsplit(' ').next().unwrap_or_default();
            if before.is_empty() || before.ends_with('.') || line[at + 2..].starts_with("..") {
                continue;
            }
            found.push(line[start..=at].to_owned());
            start = at + 2;
        }
        found.push(line[start..].to_owned());
    }
    found
}

/// Returns what is wrong with a sentence.
fn fault(sentence: &str) -> Option<&'static str> {
    let first = sentence.chars().next()?;
    // A sentence may begin with a format, an option or a literal.
    let begins = first.is_uppercase() || first.is_ascii_digit() || "`-.|[".contains(first);
    let last = sentence.trim_end_matches(|c: char| !c.is_alphanumeric());
    let last = last.rsplit(' ').next().unwrap_or_default();
    let ends = !sentence.ends_with([',', ';', ':', '-', '(']) && !OPEN_ENDS.contains(&last);
    let pairs = |open: char, close: char| {
        let count = |c: char| sentence.matches(c).count();
        count(open) == count(close)
    };
    match () {
        () if !begins => Some("does not begin like a sentence"),
        () if !ends => Some("does not end"),
        () if !pairs('(', ')') || !pairs('[', ']') => Some("has a bracket without its pair"),
        () if sentence.matches('`').count() % 2 == 1 => Some("has a quote without its pair"),
        () => None,
    }
}

#[test]
fn every_sentence_of_every_help_text_is_whole_and_stands_once() {
    let mut found = BTreeMap::new();
    let mut command = Cli::command();
    command.build();
    texts(&command, "", &mut found);
    assert!(found.len() > 300, "{}", found.len());
    let mut faults = Vec::new();
    for (place, text) in &found {
        let sentences = sentences(text);
        let begin = |sentence: &String| -> Vec<String> {
            sentence.split(' ').take(5).map(str::to_lowercase).collect()
        };
        for (i, sentence) in sentences.iter().enumerate() {
            if let Some(what) = fault(sentence) {
                faults.push(format!("{place}: {sentence:?} {what}"));
            }
            let begin_of = begin(sentence);
            if begin_of.len() == 5 && sentences[..i].iter().any(|other| begin(other) == begin_of) {
                faults.push(format!("{place}: {sentence:?} begins like another sentence"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn torn_texts_are_found() {
    let torn =
        "Reads a file, one sample a line; `#` begins a comment. `-` reads stdin. # is left out.";
    let faults: Vec<_> = sentences(torn).iter().filter_map(|s| fault(s)).collect();
    assert_eq!(faults, ["does not begin like a sentence"]);
    for torn in ["Writes the table of", "Writes (the table", "Writes `FILE", "Writes,", "a b"] {
        assert!(fault(torn).is_some(), "{torn}");
    }
    assert_eq!(sentences("One. Two of 1 ... 3.\n\nThree"), ["One.", "Two of 1 ... 3.", "Three"]);
}

/// Adds the defaults of the options of a command, and of those below, that have many zeros.
fn long_defaults(command: &Command, found: &mut Vec<String>) {
    for argument in command.get_arguments() {
        for value in argument.get_default_values() {
            let value = value.to_string_lossy();
            if value.contains("00000") {
                found.push(format!("{} {argument}: {value}", command.get_name()));
            }
        }
    }
    command.get_subcommands().for_each(|below| long_defaults(below, found));
}

#[test]
fn defaults_that_are_tiny_or_huge_have_an_exponent() {
    let mut found = Vec::new();
    long_defaults(&Cli::command(), &mut found);
    assert!(found.is_empty(), "{}", found.join("\n"));
}
