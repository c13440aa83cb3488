//! The documents: links lead somewhere, what they name exists, the book has every page, and the
//! README is short. The commands and options that they name are compared with the help of the
//! command line in `cli/tests/commands/documents.rs`.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Lines of the README at most (words.md).
const README_LINES: usize = 150;
/// Columns of a line of prose or of a comment at most.
const COLUMNS: usize = 100;
/// Bytes of a picture of the guide and the gallery at most.
const PICTURE_BYTES: u64 = 200_000;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Files with this extension below a folder of the repository.
fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let (mut found, mut open) = (vec![], vec![root().join(folder)]);
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// All documents that people read.
fn documents() -> Vec<PathBuf> {
    let mut found = files("docs", "md");
    found.extend(["README.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(|name| root().join(name)));
    found.push(root().join("bench/README.md"));
    found.extend(files("cli/src/topics", "md"));
    found
}

/// The text outside of code, in which links are links.
fn prose(text: &str) -> String {
    let mut is_code = false;
    let mut found = String::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
        } else if !is_code {
            // Every second part is between backticks.
            line.split('`').step_by(2).for_each(|part| found.push_str(part));
            found.push('\n');
        }
    }
    found
}

/// Targets of the links and pictures of a document.
fn links(text: &str) -> Vec<String> {
    let prose = prose(text);
    let targets = prose.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    targets.map(|(target, _)| target.to_owned()).collect()
}

/// Names that GitHub and mdBook give the headings of a document.
fn anchors(text: &str) -> HashSet<String> {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let name = |heading: &str| {
        let kept = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = kept.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(name).collect()
}

#[test]
fn links_lead_to_files_and_headings_that_exist() {
    let mut broken = vec![];
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        for link in links(&text).iter().filter(|link| !link.contains("://")) {
            let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = match path {
                "" => document.clone(),
                path => document.parent().unwrap().join(path),
            };
            let found = match anchor {
                "" => target.exists(),
                anchor => fs::read_to_string(&target).is_ok_and(|t| anchors(&t).contains(anchor)),
            };
            if !found {
                broken.push(format!("{}: {link}", document.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

/// What stands between single backticks outside of code.
fn spans(text: &str) -> Vec<String> {
    let mut is_code = false;
    let mut found = vec![];
    for line in text.lines() {
        is_code ^= line.trim_start().starts_with("```");
        if !is_code {
            found.extend(line.split('`').skip(1).step_by(2).map(str::to_owned));
        }
    }
    found
}

/// Words of letters, digits and underscores of a text.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

/// Returns whether a path stands for several files.
fn is_pattern(path: &str) -> bool {
    path.contains(['*', '{', '<'])
}

/// Reads all files with one of these extensions below the folders.
fn sources(folders: &[&str], extensions: &[&str]) -> String {
    let pairs = folders.iter().flat_map(|f| extensions.iter().map(move |e| (f, e)));
    let paths = pairs.flat_map(|(folder, extension)| files(folder, extension));
    paths.map(|path| fs::read_to_string(path).unwrap() + "\n").collect()
}

#[test]
fn files_that_documents_name_exist() {
    let folders = [
        "src/",
        "geometry/",
        "simulation/",
        "capi/",
        "cli/",
        "bench/",
        "charts/",
        "training/",
        "preload/",
        "python/",
        "tests/",
        "fuzz/",
        "include/",
        "scripts/",
        "docs/",
        "cmake/",
        "c_examples/",
    ];
    let mut missing = vec![];
    for document in documents().iter().filter(|path| !path.ends_with("CHANGELOG.md")) {
        for span in spans(&fs::read_to_string(document).unwrap()) {
            // Arguments may follow a script.
            let path = span.split([' ', ':']).next().unwrap_or_default();
            let is_file = folders.iter().any(|folder| path.starts_with(folder));
            if is_file && !is_pattern(path) && !root().join(path).exists() {
                missing.push(format!("{}: {path}", document.display()));
            }
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn functions_that_documents_name_exist() {
    let header = sources(&["include"], &["h", "hpp", "f90"]);
    let of_c: HashSet<&str> = words(&header).collect();
    let code = [
        "src",
        "geometry",
        "simulation",
        "capi",
        "cli",
        "bench",
        "charts",
        "training",
        "preload",
        "python",
        "tests",
    ];
    let rust = sources(&code, &["rs"]);
    let of_rust: HashSet<&str> = words(&rust).collect();
    let public = fs::read_to_string(root().join("python/python/catamaran/__init__.py")).unwrap();
    let rest = sources(&["python/python"], &["py", "pyi"]);
    let of_python: HashSet<&str> = words(&public).chain(words(&rest)).collect();
    let mut missing = vec![];
    for document in documents().iter().filter(|path| !path.ends_with("CHANGELOG.md")) {
        let text = fs::read_to_string(document).unwrap();
        let mut note = |name: &str| missing.push(format!("{}: {name}", document.display()));
        // Of C, in prose and in code. A name that ends with `_` stands for all that begin so.
        for name in words(&text).filter(|w| w.starts_with("cata_") || w.starts_with("CATA_")) {
            let exists = match name.strip_suffix('_') {
                Some(_) => of_c.iter().any(|c| c.starts_with(name)),
                None => of_c.contains(name),
            };
            if !exists {
                note(name);
            }
        }
        for span in spans(&text) {
            // Of Rust and C++: the last name of a path.
            for path in span.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':') {
                let Some((_, name)) = path.rsplit_once("::") else { continue };
                if !name.is_empty() && !of_rust.contains(name) && !of_c.contains(name) {
                    note(path);
                }
            }
            // Of Python: `catamaran.name`.
            let names = span.strip_prefix("catamaran.").and_then(|rest| words(rest).next());
            if let Some(name) = names.filter(|name| !of_python.contains(name)) {
                // Files of the library: `catamaran.h`.
                if !root().join("include").join(&span).exists() {
                    note(&format!("catamaran.{name}"));
                }
            }
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn the_book_has_every_page_once() {
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    let listed = links(&summary);
    let unique: HashSet<_> = listed.iter().collect();
    assert_eq!(unique.len(), listed.len(), "a page is listed twice");
    for page in files("docs", "md") {
        let name = page.strip_prefix(root().join("docs")).unwrap().to_str().unwrap();
        assert!(
            name == "SUMMARY.md" || listed.iter().any(|link| link == name),
            "{name} is missing"
        );
    }
}

#[test]
fn the_readme_is_short_and_pictures_are_small() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    assert!(readme.lines().count() <= README_LINES);
    let pictures = files("docs", "png");
    assert!(!pictures.is_empty());
    for picture in pictures {
        let bytes = fs::metadata(&picture).unwrap().len();
        assert!(bytes <= PICTURE_BYTES, "{}: {bytes} bytes", picture.display());
    }
}

#[test]
fn prose_and_comments_end_at_100_columns() {
    let mut long = vec![];
    for document in documents().into_iter().filter(|path| !path.ends_with("SUMMARY.md")) {
        let text = fs::read_to_string(&document).unwrap();
        let mut is_code = false;
        for (line, number) in text.lines().zip(1..) {
            is_code ^= line.trim_start().starts_with("```");
            // Tables and pictures can't be broken.
            let is_prose = !is_code && !line.starts_with(['|', '!']) && !line.starts_with("    ");
            if is_prose && line.chars().count() > COLUMNS {
                long.push(format!("{}:{number}", document.display()));
            }
        }
    }
    let rooms = [
        "src",
        "geometry",
        "simulation",
        "capi",
        "cli",
        "bench",
        "training",
        "preload",
        "python",
        "tests",
        "fuzz",
        "scripts",
    ];
    for source in rooms.iter().flat_map(|room| files(room, "rs")) {
        let text = fs::read_to_string(&source).unwrap();
        let mut is_code = false;
        for (line, number) in text.lines().zip(1..) {
            let Some(comment) = line.trim_start().strip_prefix("//") else {
                is_code = false;
                continue;
            };
            let prose = comment.trim_start_matches(['/', '!', ' ']);
            is_code ^= prose.starts_with("```");
            if !is_code && !prose.starts_with('|') && line.chars().count() > COLUMNS {
                long.push(format!("{}:{number}", source.display()));
            }
        }
    }
    assert!(long.is_empty(), "{long:#?}");
}
