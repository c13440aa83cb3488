//! The conventions at the top of include/catamaran.h, as tests of what it declares.

use std::collections::BTreeSet;
use std::path::Path;

use crate::declarations::Header;
use crate::header::{HEADER, SECTIONS};

/// Returns the header's text.
fn text() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(HEADER.name);
    std::fs::read_to_string(path).unwrap()
}

/// Returns what the header declares.
fn header() -> Header {
    Header::parse(&text())
}

/// Collects all that `broken` reports, or nothing.
fn none_of(broken: impl IntoIterator<Item = String>) {
    let broken: Vec<String> = broken.into_iter().collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn names_begin_with_a_chapter_of_their_section() {
    let header = header();
    none_of(header.functions.iter().filter_map(|f| {
        let section = SECTIONS.iter().find(|section| section.name == f.section);
        let chapters = section.map_or(&[][..], |section| section.chapters);
        let fits = chapters.iter().any(|chapter| {
            let rest = f.name.strip_prefix("cata_").and_then(|name| name.strip_prefix(chapter));
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
        });
        (!fits).then(|| format!("{} is in the section {} ({chapters:?})", f.name, f.section))
    }));
}

#[test]
fn what_can_fail_returns_a_status() {
    none_of(header().functions.iter().filter_map(|f| {
        let fits = match f.returns.as_str() {
            "cata_status" => true,
            "void" => f.name.ends_with("_free"),
            // A name, a number: nothing can go wrong.
            "const char *" | "size_t" | "uint64_t" => f.arguments.len() <= 3,
            _ => false,
        };
        (!fits).then(|| format!("{} returns {}", f.name, f.returns))
    }));
}

#[test]
fn handles_that_are_made_can_be_freed() {
    let header = header();
    let names: BTreeSet<&str> = header.functions.iter().map(|f| f.name.as_str()).collect();
    none_of(header.functions.iter().flat_map(|f| {
        f.arguments.iter().filter_map(|argument| {
            let (kind, _) = argument.split_once(" **")?;
            let free = format!("{kind}_free");
            (!names.contains(free.as_str())).then(|| format!("{}: there is no {free}", f.name))
        })
    }));
}

#[test]
fn params_have_threads_and_progress_and_an_init() {
    let header = header();
    let names: BTreeSet<&str> = header.functions.iter().map(|f| f.name.as_str()).collect();
    let first =
        ["size_t struct_size", "size_t threads", "cata_progress progress", "void *progress_user"];
    let params = header.structs.iter().filter(|(name, _)| name.ends_with("_params"));
    none_of(params.flat_map(|(name, fields)| {
        let begins = fields.iter().map(String::as_str).take(4).eq(first);
        let init = format!("{name}_init");
        [
            (!begins).then(|| format!("{name} does not begin with {first:?}")),
            (!names.contains(init.as_str())).then(|| format!("there is no {init}")),
        ]
        .into_iter()
        .flatten()
    }));
}

#[test]
fn flags_say_what_is_and_not_what_is_not() {
    let header = header();
    none_of(header.structs.iter().flat_map(|(name, fields)| {
        let negative = fields.iter().filter(|field| field.contains(" no_"));
        negative.map(move |field| format!("{name}: {field}"))
    }));
}

#[test]
fn meshes_are_four_arguments() {
    let four =
        ["size_t n_vertices", "const double *vertices", "size_t n_faces", "const uint32_t *faces"];
    none_of(header().functions.iter().filter_map(|f| {
        let has_mesh = f.arguments.iter().any(|a| a.starts_with("const") && a.ends_with("*faces"));
        let fits = f.arguments.windows(4).any(|window| window == four);
        (has_mesh && !fits).then(|| format!("{}: {:?}", f.name, f.arguments))
    }));
}

#[test]
fn it_can_be_read() {
    let text = text();
    let lines = text.lines().count();
    assert!(lines <= 3340, "{lines} lines");
    none_of(text.lines().filter(|line| line.chars().count() > 100).map(str::to_owned));
    none_of(text.split("@defgroup ").skip(1).filter_map(|section| {
        let title = section.lines().next().unwrap();
        (!section.contains("@code{.c}")).then(|| format!("no example: {title}"))
    }));
}
