//! The documents: links lead somewhere, the book has every page, and the README is short.

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
    let rooms =
        ["src", "cli", "bench", "training", "preload", "python", "tests", "fuzz", "scripts"];
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
