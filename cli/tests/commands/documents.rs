//! The commands and options that the documents name exist.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{Folder, subcommands};

/// The repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Files below a folder of the repository with one of these extensions; "" is none.
fn files(folder: &Path, extensions: &[&str], found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let extension = path.extension().map_or("", |e| e.to_str().unwrap());
        if path.is_dir() {
            files(&path, extensions, found);
        } else if extensions.contains(&extension) {
            found.push(path);
        }
    }
}

/// The help of each command and subcommand, by its words: "ata", "unions predict".
struct Help {
    folder: Folder,
    /// Options of each command.
    options: HashMap<String, HashSet<String>>,
}

impl Help {
    fn new() -> Self {
        let mut help = Self { folder: Folder::new(), options: HashMap::new() };
        let mut open = vec![String::new()];
        while let Some(command) = open.pop() {
            let text = help.folder.succeed(&format!("{command} --help"));
            let options = text.split_whitespace().filter_map(option).map(str::to_owned).collect();
            let below = subcommands(&text).into_iter();
            open.extend(below.map(|name| format!("{command} {name}").trim().into()));
            help.options.insert(command, options);
        }
        help
    }

    /// The command at the beginning of these words, and how many of them it is.
    fn command(&self, words: &[&str]) -> Option<(String, usize)> {
        let names = (1..=words.len().min(2)).rev().map(|n| (words[..n].join(" "), n));
        names.into_iter().find(|(name, _)| self.options.contains_key(name))
    }

    fn has_option(&self, option: &str) -> bool {
        self.options.values().any(|options| options.contains(option))
    }
}

/// The long option that a word begins with.
fn option(word: &str) -> Option<&str> {
    let word = word.trim_start_matches(['[', '(', '`', '"', '|']);
    let end = word.find(|c: char| !c.is_ascii_alphanumeric() && c != '-').unwrap_or(word.len());
    Some(&word[..end]).filter(|word| word.len() > 3 && word.starts_with("--"))
}

/// What a document names: code line by line, and what stands between backticks.
fn pieces(text: &str) -> Vec<String> {
    let (mut is_code, mut found) = (false, vec![]);
    let joined = text.replace("\\\n", " ");
    for line in joined.lines() {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
        } else if is_code {
            found.push(line.to_owned());
        } else {
            found.extend(line.split('`').skip(1).step_by(2).map(str::to_owned));
        }
    }
    found
}

/// Checks one call of the command line; returns what of it does not exist.
fn unknown(help: &Help, words: &[&str]) -> Option<String> {
    let end = words.iter().position(|w| ["|", "#", "&&", ";", ">", "2>", "<"].contains(w));
    let words = &words[..end.unwrap_or(words.len())];
    let first = *words.first()?;
    if first.starts_with('-') {
        return option(first).filter(|o| !help.options[""].contains(*o)).map(str::to_owned);
    }
    let Some((command, length)) = help.command(words) else {
        // A name in capitals stands for any command.
        return (!first.chars().all(char::is_uppercase)).then(|| first.to_owned());
    };
    let options = &help.options[&command];
    let named = words[length..].iter().filter_map(|word| option(word));
    named.into_iter().find(|o| !options.contains(*o)).map(|o| format!("{command} {o}"))
}

/// Texts in which the options of other programs stand: the bench tools (`--max-rows` is the field
/// `max_rows`), scripts, and programs of other people that documents mention.
fn others() -> String {
    let mut paths = vec![];
    for room in ["bench/src", "training/src", "scripts", "tests", "capi", "python"] {
        files(&root().join(room), &["rs", "py", "sh", ""], &mut paths);
    }
    let text = |path: &PathBuf| String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
    let ours: String = paths.iter().map(text).collect();
    // cargo, ld, CMake, pip, Open MPI and Slurm.
    ours + "--gc-sections --features --release --locked --no-default-features --workspace --path \
            --target --bin --open --config --preset --map-by --cpu-bind --ntasks-per-socket --mpi \
            --mem --signal --requeue --config-settings"
}

#[test]
fn commands_and_options_that_documents_name_exist() {
    let help = Help::new();
    let others = others();
    let mut documents = ["README.md", "bench/README.md", "python/README.md", "CONTRIBUTING.md"]
        .map(|name| root().join(name))
        .to_vec();
    files(&root().join("docs"), &["md"], &mut documents);
    files(&root().join("cli/src/topics"), &["md"], &mut documents);
    let mut missing = vec![];
    for document in documents {
        let mut note = |what: &str| missing.push(format!("{}: {what}", document.display()));
        for piece in pieces(&fs::read_to_string(&document).unwrap()) {
            let words: Vec<&str> = piece.split_whitespace().collect();
            let calls = words.iter().enumerate().filter(|(_, word)| **word == "catamaran");
            let mut is_call = false;
            for (at, _) in calls {
                // A package or a project of this name, not the program.
                let before = at.checked_sub(1).map_or("", |before| words[before]);
                if ["-p", "install", "uninstall", "import", "<", "--package"].contains(&before) {
                    continue;
                }
                is_call = true;
                unknown(&help, &words[at + 1..]).inspect(|what| note(what));
            }
            for name in words.iter().filter(|_| !is_call).filter_map(|word| option(word)) {
                let field = name.trim_start_matches('-').replace('-', "_");
                let exists = help.has_option(name) || others.contains(name);
                if !exists && !others.contains(&format!("{field}:")) {
                    note(name);
                }
            }
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
}
