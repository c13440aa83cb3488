//! `catamaran help`: the help of commands, and pages about topics.

use anyhow::Result;
use clap::{ArgMatches, Command};

use crate::program::program;
use crate::report::row;
use crate::wrap::wrapped;

/// The word that lists the topics.
const LIST: &str = "topics";

/// Names of topics, and their pages.
const TOPICS: [(&str, &str); 5] = [
    ("files", include_str!("topics/files.md")),
    ("memory", include_str!("topics/memory.md")),
    ("ranks", include_str!("topics/ranks.md")),
    ("exit-codes", include_str!("topics/exit-codes.md")),
    ("reproducibility", include_str!("topics/reproducibility.md")),
];

/// Width of a name in the list, in characters.
const WIDTH: usize = 17;

/// Print the help of a command, or a page about a topic.
#[derive(clap::Args)]
pub struct Args {
    /// A command, such as `unions predict`, or a topic; `topics` lists the topics.
    #[arg(value_name = "COMMAND|TOPIC")]
    words: Vec<String>,
}

/// Returns what is wrong with the words after `catamaran help`, if they name nothing.
pub fn refusal(program: &Command, matches: &ArgMatches) -> Option<String> {
    let ("help", matches) = matches.subcommand()? else { return None };
    let words: Vec<&str> = matches.get_many::<String>("words")?.map(String::as_str).collect();
    let found = words.iter().try_fold(program, |above, word| above.find_subcommand(word));
    let is_topic = matches!(words.as_slice(), [word] if *word == LIST || page(word).is_some());
    let what = "is neither a command nor a topic: `catamaran help topics` lists the topics";
    (found.is_none() && !is_topic).then(|| format!("`{}` {what}", words.join(" ")))
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let [word] = args.words.as_slice() else { return help(&args.words) };
    if word == LIST {
        return TOPICS.into_iter().try_for_each(|(name, text)| {
            let title = text.lines().next().unwrap_or_default().trim_start_matches("# ");
            row!("topic", name = name, title = title; "{name:WIDTH$}{title}")
        });
    }
    match page(word) {
        Some(text) => row!("page", name = word, text = text; "{text}"),
        None => help(&args.words),
    }
}

/// Returns the page about a topic.
fn page(topic: &str) -> Option<&'static str> {
    TOPICS.into_iter().find(|(name, _)| *name == topic).map(|(_, text)| text.trim_end())
}

/// Prints the help of a command, or of the program if there are no words.
fn help(words: &[String]) -> Result<()> {
    let words = ["catamaran"].into_iter().chain(words.iter().map(String::as_str));
    let parsed = program().try_get_matches_from(words.chain(["--help"]));
    // clap returns help as an error.
    parsed.err().map_or(Ok(()), |help| Ok(wrapped(help).print()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_are_no_commands_and_name_a_page_of_the_documents() {
        let program = program();
        for (name, text) in TOPICS {
            assert!(program.find_subcommand(name).is_none(), "{name}");
            assert!(text.starts_with("# ") && text.contains("\nMore: `docs/"), "{name}");
            assert!(text.lines().all(|line| line.chars().count() <= 80), "{name}");
            assert!(text.lines().count() <= 30, "{name}");
        }
    }

    #[test]
    fn words_that_name_nothing_are_refused() {
        let program = program();
        let refusal = |line: &str| {
            let matches = program.clone().try_get_matches_from(line.split(' ')).unwrap();
            refusal(&program, &matches)
        };
        for line in ["help", "help topics", "help files", "help ata", "help unions predict", "info"]
        {
            assert_eq!(refusal(&format!("catamaran {line}")), None, "{line}");
        }
        for words in ["spectrun", "ata files", "files topics", "unions ata"] {
            let refused = refusal(&format!("catamaran help {words}")).unwrap();
            assert!(refused.starts_with(&format!("`{words}` is neither")), "{refused}");
        }
    }
}
