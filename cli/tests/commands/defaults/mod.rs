//! Defaults of the C and C++ headers, of the Python package and of the command line beside those of
//! the library: what `table.txt` says, which names every one of them.

mod faces;
mod library;

use std::collections::BTreeMap;

const TABLE: &str = include_str!("table.txt");

/// Names of parameters or fields, and their defaults.
type Defaults = BTreeMap<String, String>;

/// A default in one spelling: numbers and lists of numbers as numbers, truth values as 0 and 1,
/// words without blanks, case, underscores and hyphens.
fn spelled(text: &str) -> String {
    let text = text.trim().trim_matches(['"', '\'', '(', ')', '[', ']']);
    let number = |part: &str| part.trim().replace('_', "").parse::<f64>().ok();
    let quotient = |part: &str| match part.split_once(" / ") {
        Some((a, b)) => Some(number(a)? / number(b)?),
        None => number(part),
    };
    match text.split(',').map(quotient).collect::<Option<Vec<f64>>>() {
        Some(numbers) => format!("{numbers:?}"),
        None => match text {
            "true" | "True" => spelled("1"),
            "false" | "False" => spelled("0"),
            _ => text.to_lowercase().replace([' ', '_', '-'], ""),
        },
    }
}

/// A line of the table: the field of the library or "=", the values that are right, and the places.
struct Line {
    field: Option<&'static str>,
    values: Vec<&'static str>,
    places: Vec<&'static str>,
}

fn table() -> Vec<Line> {
    let lines = TABLE.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    let line = |line: &'static str| {
        let (head, places) = line.split_once(" :").unwrap_or_else(|| panic!("no colon: {line}"));
        let mut words = head.split_whitespace();
        let field = words.next().filter(|&word| word != "=");
        let places = places.split(',').map(str::trim).filter(|place| !place.is_empty());
        Line { field, values: words.collect(), places: places.collect() }
    };
    lines.map(line).collect()
}

#[test]
fn every_default_of_every_face_is_that_of_the_library() {
    let (mut library, mut faces) = (library::defaults(), faces::defaults());
    let mut wrong = Vec::new();
    for Line { field, values, places } in table() {
        let mut right: Vec<String> = values.into_iter().map(spelled).collect();
        if let Some(field) = field {
            match library.remove(field) {
                Some(value) => right.push(spelled(&value)),
                None => wrong.push(format!("{field}: not in the library, or in the table twice")),
            }
        }
        for place in places {
            match faces.remove(place) {
                Some(value) if right.contains(&spelled(&value)) => {}
                Some(value) => wrong.push(format!("{place}: {value}, but expected {right:?}")),
                None => wrong.push(format!("{place}: not there, or in the table twice")),
            }
        }
    }
    let missing = |(name, value): (&String, &String)| format!("{name} ({value}): not in the table");
    wrong.extend(library.iter().chain(&faces).map(missing));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_struct_of_options_is_compared() {
    let [with_defaults, others] = library::declared();
    let known = library::structs();
    let all = with_defaults.iter().chain(&others);
    let forgotten: Vec<&String> = all.filter(|name| !known.contains(&name.as_str())).collect();
    assert!(forgotten.is_empty(), "compare or exempt: {forgotten:?}");
}

#[test]
fn every_struct_of_options_is_in_the_list_of_its_crate() {
    let [mut declared, _] = library::declared();
    let mut listed = library::listed();
    assert!(listed.len() > 25, "{listed:?}");
    declared.sort();
    listed.sort_unstable();
    assert_eq!(declared, listed);
}
