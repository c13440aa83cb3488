//! Samples of curves in files.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use catamaran::curve::Site;

/// The samples in the file at `path`, one a line; `#` begins a comment.
pub fn read(path: &Path) -> Result<Vec<Site>> {
    let text = fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let mut sites = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let words: Vec<&str> =
            line.split('#').next().unwrap_or_default().split_whitespace().collect();
        if words.is_empty() {
            continue;
        }
        let site = site(&words).with_context(|| {
            format!(
                "{}:{}: neither a vertex, nor a face and three shares, nor a point x y z",
                path.display(),
                i + 1
            )
        })?;
        sites.push(site);
    }
    Ok(sites)
}

fn site(words: &[&str]) -> Option<Site> {
    let numbers = |words: &[&str]| -> Option<[f64; 3]> {
        let all: Vec<f64> = words.iter().filter_map(|word| word.parse().ok()).collect();
        all.try_into().ok()
    };
    match words {
        [vertex] => Some(Site::Vertex(index(vertex)?)),
        [_, _, _] => Some(Site::Near(numbers(words)?)),
        [face, weights @ ..] => Some(Site::Face { face: index(face)?, weights: numbers(weights)? }),
        [] => None,
    }
}

/// A number of a vertex or face; tables of real numbers have it as 7.0.
fn index(word: &str) -> Option<u32> {
    word.strip_suffix(".0").unwrap_or(word).parse().ok()
}
