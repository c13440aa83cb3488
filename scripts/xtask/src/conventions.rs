//! The conventions at the top of include/catamaran.h, as tests of what it declares.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::header::{HEADER, SECTIONS};

/// A function of the header.
struct Function {
    section: String,
    returns: String,
    name: String,
    /// Type and name of each, such as `const double *a`.
    arguments: Vec<String>,
}

/// What the header declares, without its comments.
struct Header {
    text: String,
    functions: Vec<Function>,
    /// Fields of each struct.
    structs: BTreeMap<String, Vec<String>>,
}

impl Header {
    fn read() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(HEADER.name);
        Self::parse(std::fs::read_to_string(path).unwrap())
    }

    fn parse(text: String) -> Self {
        let (mut functions, mut structs) = (Vec::new(), BTreeMap::new());
        let (mut section, mut fields) = (String::new(), Vec::new());
        let mut is_comment = false;
        let mut declaration = String::new();
        for line in text.lines() {
            if let Some(group) = line.strip_prefix(" * @defgroup ") {
                section = group.split(' ').next().unwrap().to_owned();
            }
            let line = line.split(" /**<").next().unwrap_or_default();
            is_comment |= line.trim_start().starts_with("/*");
            if is_comment || line.starts_with('#') {
                is_comment &= !line.contains("*/");
                continue;
            }
            if let Some(name) = line.strip_prefix("} ") {
                structs.insert(name.trim_end_matches(';').to_owned(), std::mem::take(&mut fields));
                declaration.clear();
                continue;
            }
            if declaration.is_empty() && line.starts_with("    ") {
                fields.push(line.trim().trim_end_matches(';').to_owned());
                continue;
            }
            declaration += " ";
            declaration += line.trim();
            if declaration.ends_with('{') {
                declaration.clear();
            } else if declaration.ends_with(';') {
                let whole = std::mem::take(&mut declaration);
                functions.extend(Function::parse(&section, whole.trim()));
            }
        }
        Self { text, functions, structs }
    }
}

impl Function {
    fn parse(section: &str, declaration: &str) -> Option<Self> {
        let declaration = declaration.strip_suffix(");")?;
        if declaration.starts_with("typedef") {
            return None;
        }
        let (head, arguments) = declaration.split_once('(')?;
        let at = head.rfind([' ', '*'])? + 1;
        Some(Self {
            section: section.to_owned(),
            returns: head[..at].trim().to_owned(),
            name: head[at..].to_owned(),
            arguments: arguments.split(", ").map(str::to_owned).collect(),
        })
    }
}

/// All that `broken` says of something, or nothing.
fn none_of(broken: impl IntoIterator<Item = String>) {
    let broken: Vec<String> = broken.into_iter().collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn names_begin_with_a_chapter_of_their_section() {
    let header = Header::read();
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
    none_of(Header::read().functions.iter().filter_map(|f| {
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
    let header = Header::read();
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
    let header = Header::read();
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
    let header = Header::read();
    none_of(header.structs.iter().flat_map(|(name, fields)| {
        let negative = fields.iter().filter(|field| field.contains(" no_"));
        negative.map(move |field| format!("{name}: {field}"))
    }));
}

#[test]
fn meshes_are_four_arguments() {
    let four =
        ["size_t n_vertices", "const double *vertices", "size_t n_faces", "const uint32_t *faces"];
    none_of(Header::read().functions.iter().filter_map(|f| {
        let has_mesh = f.arguments.iter().any(|a| a.starts_with("const") && a.ends_with("*faces"));
        let fits = f.arguments.windows(4).any(|window| window == four);
        (has_mesh && !fits).then(|| format!("{}: {:?}", f.name, f.arguments))
    }));
}

#[test]
fn it_can_be_read() {
    let header = Header::read();
    let lines = header.text.lines().count();
    assert!(lines <= 3050, "{lines} lines");
    none_of(header.text.lines().filter(|line| line.chars().count() > 100).map(str::to_owned));
    none_of(header.text.split("@defgroup ").skip(1).filter_map(|section| {
        let title = section.lines().next().unwrap();
        (!section.contains("@code{.c}")).then(|| format!("no example: {title}"))
    }));
}

#[test]
fn declarations_are_parsed() {
    let text = "/**\n * @defgroup ata A^T A\n */\n/** F(x);\n * more */\ncata_status \
                cata_f(size_t n,\n    const double *a);\ntypedef struct cata_p {\n    /** n. */\n    \
                size_t n;\n    int32_t k; /**< k. */\n} cata_p;\nconst char *cata_name(void);\n";
    let header = Header::parse(text.to_owned());
    let names: Vec<_> = header.functions.iter().map(|f| (&*f.returns, &*f.name)).collect();
    assert_eq!(names, [("cata_status", "cata_f"), ("const char *", "cata_name")]);
    assert_eq!(header.functions[0].section, "ata");
    assert_eq!(header.functions[0].arguments, ["size_t n", "const double *a"]);
    assert_eq!(header.structs["cata_p"], ["size_t n", "int32_t k"]);
}
