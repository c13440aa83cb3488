//! `docs/guide/options.md`: the options of the library, from the structs that declare them.

use std::path::Path;

use catamaran::base::Field;

use crate::generated::Generated;

/// `docs/guide/options.md`.
pub const OPTIONS: Generated = Generated {
    name: "docs/guide/options.md",
    source: "the structs of options",
    command: "cargo xtask options",
    generate,
};

const INTRODUCTION: &str = "\
# All options

The structs of options of the library, written by `cargo xtask options`. Defaults are Rust
expressions. C, C++, Python and the command line have the same defaults, unless their documentation
says otherwise.
";

const HEAD: &str = "\
| Option | Type | Default | Unit | Must be | Meaning |
|---|---|---|---|---|---|
";

/// A crate, and the paths and fields of its structs.
type Crate = (&'static str, &'static [(&'static str, &'static [Field])]);

const CRATES: [Crate; 3] = [
    ("catamaran", catamaran::OPTIONS),
    ("catamaran_geometry", catamaran_geometry::OPTIONS),
    ("catamaran_simulation", catamaran_simulation::OPTIONS),
];

fn generate(_: &Path) -> Result<String, String> {
    let mut page = String::from(INTRODUCTION);
    for (name, structs) in CRATES {
        for (path, fields) in structs {
            page += &format!("\n## {name}::{path}\n\n{HEAD}");
            page.extend(fields.iter().map(row));
        }
    }
    Ok(page)
}

/// Returns the row of a field in the table of its struct.
fn row(field: &Field) -> String {
    let code = |text: &str| format!("`{text}`");
    let cells = [
        code(field.name),
        code(field.kind),
        code(field.default),
        field.unit.to_owned(),
        field.range.to_owned(),
        without_links(&first_sentence(field.doc)),
    ];
    let cells = cells.map(|cell| cell.replace('|', "\\|"));
    format!("| {} |\n", cells.join(" | "))
}

fn first_sentence(doc: &str) -> String {
    let paragraph = doc.split("\n\n").next().unwrap_or(doc);
    let words: Vec<&str> = paragraph.split_whitespace().collect();
    let text = words.join(" ");
    match text.split_once(". ") {
        Some((sentence, _)) => format!("{sentence}."),
        None => text,
    }
}

/// Returns the text with the names of items in place of links to them.
fn without_links(text: &str) -> String {
    let (mut found, mut rest) = (String::new(), text);
    while let Some((before, link)) = rest.split_once("[`") {
        let Some((name, after)) = link.split_once("`]") else { break };
        found += &format!("{before}`{name}`");
        rest = match after.strip_prefix('(').and_then(|target| target.split_once(')')) {
            // The target may be a function, such as `super::eigs()`.
            Some((target, after)) if target.ends_with('(') => after.trim_start_matches(')'),
            Some((_, after)) => after,
            None => after,
        };
    }
    found + rest
}

#[cfg(test)]
mod tests {
    use super::{first_sentence, without_links};

    #[test]
    fn links_become_the_names_of_items() {
        let text = "As [`A::b`](super::A::b()), [`C`] (d) and [`e`](f): [g].";
        assert_eq!(without_links(text), "As `A::b`, `C` (d) and `e`: [g].");
    }

    #[test]
    fn the_first_sentence_may_have_several_lines_and_decimal_points() {
        assert_eq!(first_sentence("From 0.5\n to 1. More."), "From 0.5 to 1.");
        assert_eq!(first_sentence("All.\n\n```\na. b\n```"), "All.");
    }
}
