//! The defaults that the faces state: in comments and initializers of the headers, in signatures of
//! Python, in the help of the command line.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::Defaults;
use super::library::split;
use crate::common::subcommands;

/// Parameters of every call.
const COMMON: [&str; 6] = ["threads", "progress", "progress_user", "comm", "struct_size", "self"];

/// Options of the command line for files and pictures, and threads.
const OWN: [&str; 4] = ["--input-limit", "--threads", "--up", "--view"];

/// Modules of Python without options of the library: generated shapes, and the preload.
const WITHOUT: [&str; 3] = ["_preload.py", "preload.py", "shapes.py"];

/// The place and the default of every parameter of every face.
pub fn defaults() -> Defaults {
    let mut found = Defaults::new();
    c(&mut found);
    for path in files("include/catamaran", "hpp") {
        cpp(&text(&path), &mut found);
    }
    for path in files("python/python/catamaran", "py") {
        if !WITHOUT.iter().any(|name| path.ends_with(name)) {
            python(&text(&path), &mut found);
        }
    }
    help(&[], &mut found);
    found
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn files(folder: &str, end: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join(folder)).expect("a folder of the project");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths.filter(|path| path.extension().is_some_and(|e| e == end)).collect()
}

/// The value that a comment gives to 0, if it is a number, numbers or a constant.
fn documented(comment: &str) -> Option<String> {
    let at = comment.rfind(" 0: ")? + " 0: ".len();
    let ends = [". ", "; ", ", or ", ", which "];
    let rest = ends.iter().fold(&comment[at..], |text, end| text.split(end).next().unwrap_or(text));
    let value = rest.trim().trim_end_matches('.');
    let digits = value.replace(", ", "\t").replace(',', "").replace('\t', ", ");
    let is_number = |c: char| c.is_ascii_digit() || "+-.e/, ".contains(c);
    let is_value = digits.chars().all(is_number) || value.starts_with("CATA_");
    is_value.then_some(digits)
}

/// Adds the fields of the parameter structs of the C header: what comments give to 0, or else 0.
fn c(found: &mut Defaults) {
    let (mut name, mut comment) = (None, String::new());
    for line in text(&root().join("include/catamaran.h")).lines() {
        let line = line.trim();
        if line.starts_with('}') {
            name = None;
        } else if let Some(of) = line.strip_prefix("typedef struct cata_") {
            name = of.strip_suffix("_params {").map(str::to_owned);
            comment.clear();
        } else if let Some(size) = line.strip_prefix("#define CATA_SLIME_SIZE ") {
            let digits = size.split_whitespace().next().unwrap_or_default();
            found.insert("c CATA_SLIME_SIZE".into(), digits.to_owned());
        } else if line.starts_with(['/', '*']) {
            comment += " ";
            comment += line.trim_matches(['/', '*', ' ']);
        } else if let Some((field, beside)) = line.split_once(';') {
            let field = field.split('[').next().unwrap_or_default();
            let field = field.rsplit([' ', '*']).next().unwrap_or_default();
            let all = format!(" {comment} {}", beside.trim_matches(['/', '*', '<', ' ']));
            if let Some(name) = name.as_ref().filter(|_| !COMMON.contains(&field)) {
                let value = documented(&all).unwrap_or_else(|| "0".into());
                found.insert(format!("c {name}.{field}"), value);
            }
            comment.clear();
        }
    }
}

/// Adds the fields of the options of a C++ header: what comments give to 0, or else initializers.
fn cpp(text: &str, found: &mut Defaults) {
    let (mut name, mut comment) = (None, String::new());
    for line in text.lines().map(str::trim) {
        if let Some(of) = line.strip_prefix("struct ") {
            let of = of.trim_end_matches(" {");
            name = match of {
                "options" => Some("ata"),
                _ => of.strip_suffix("_options"),
            };
            comment.clear();
        } else if line.starts_with("};") {
            name = None;
        } else if let Some(more) = line.strip_prefix("///") {
            comment += more;
        } else if let (Some(name), Some(field)) = (name, line.strip_suffix(';')) {
            let (field, value) = match field.split_once(" = ") {
                Some((field, value)) => (field, value.rsplit("::").next().unwrap_or(value)),
                None if field.ends_with("{}") => (field.trim_end_matches("{}"), "0"),
                None => (field, "None"),
            };
            let field = field.rsplit(' ').next().unwrap_or_default();
            if !COMMON.contains(&field) {
                let value = documented(&format!(" {comment}")).unwrap_or_else(|| value.into());
                found.insert(format!("c++ {name}.{field}"), value);
            }
            comment.clear();
        }
    }
}

/// Adds the keywords with defaults of public functions and methods.
fn python(text: &str, found: &mut Defaults) {
    let (mut class, mut at) = ("", 0);
    for line in text.split_inclusive('\n') {
        at += line.len();
        if let Some(of) = line.strip_prefix("class ") {
            class = of.split(['(', ':']).next().unwrap_or_default();
        }
        let Some((before, start)) = line.split_once("def ") else { continue };
        if !before.trim().is_empty() {
            continue;
        }
        let function = start.split('(').next().unwrap_or_default();
        let name = match (before.is_empty(), function) {
            (_, "__new__" | "__init__") => class.to_owned(),
            (_, private) if private.starts_with('_') => continue,
            (true, function) => function.to_owned(),
            (false, method) => format!("{class}.{method}"),
        };
        let open = at - line.len() + line.find('(').expect("parameters");
        for parameter in split(inside(&text[open..])) {
            if let Some((declared, value)) = parameter.split_once('=') {
                let parameter = declared.split(':').next().unwrap_or_default().trim();
                if !COMMON.contains(&parameter) {
                    found.insert(format!("python {name}.{parameter}"), value.trim().to_owned());
                }
            }
        }
    }
}

/// What is between the bracket at the start and the one that closes it.
fn inside(text: &str) -> &str {
    let mut depth = 0;
    let end = text.find(|c: char| {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            _ => {}
        }
        depth == 0
    });
    &text[1..end.expect("a closing bracket")]
}

/// Adds the options of a command, or of its subcommands, that have a default.
fn help(command: &[&str], found: &mut Defaults) {
    let run = Command::new(env!("CARGO_BIN_EXE_catamaran")).args(command).arg("--help").output();
    let text = String::from_utf8(run.expect("the program starts").stdout).expect("UTF-8");
    let below = subcommands(&text);
    if !below.is_empty() {
        for name in below {
            help(&[command, &[&*name]].concat(), found);
        }
        return;
    }
    let (mut option, mut said) = (String::new(), String::new());
    for line in text.lines().chain(["  --end"]) {
        // Descriptions are indented further than options.
        let is_option = line.trim_start().starts_with('-') && !line.starts_with("        ");
        if is_option {
            let default = said.split_once("[default: ").and_then(|(_, rest)| rest.split_once(']'));
            if let Some((value, _)) = default.filter(|_| !OWN.contains(&option.as_str())) {
                let value = value.split(';').next().unwrap_or(value);
                found.insert(format!("command {} {option}", command.join("_")), value.to_owned());
            }
            let words = line.split([' ', ',', '[']).filter(|word| word.starts_with('-'));
            option = words.max_by_key(|word| word.starts_with("--")).unwrap_or_default().to_owned();
            said.clear();
        }
        said += line.trim();
        said += " ";
    }
}
