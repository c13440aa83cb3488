//! Parses samples of curves. The file is also part of a fuzz target, so that it uses nothing of the
//! command line.

use std::ops::Range;

use anyhow::{Context, Result, bail};
use catamaran_geometry::curve::{Outcome, Side, Site};
use catamaran_geometry::mesh::SurfacePoint;

/// The samples of one curve, or of curves that are found together.
#[derive(Debug)]
pub struct Group {
    /// The name in the file; `None` in a file without names.
    pub name: Option<String>,
    /// Whether the curve is open.
    pub open: bool,
    /// Whether there is one curve, whatever the gaps.
    pub single: bool,
    /// Which side is inside.
    pub side: Option<Side>,
    /// The samples of the group among those of the file.
    pub samples: Range<usize>,
}

impl Group {
    /// Returns the numbers in the file of samples with these indices in the group.
    pub fn numbers(&self, indices: &[u32]) -> impl Iterator<Item = usize> {
        indices.iter().map(|&i| self.samples.start + i as usize)
    }

    /// Returns an outcome of the group with the number in the file of the sample that it names.
    pub fn outcome(&self, outcome: Outcome) -> Outcome {
        match outcome {
            Outcome::Blocked { at, remaining } => {
                Outcome::Blocked { at: self.samples.start as u32 + at, remaining }
            }
            outcome => outcome,
        }
    }
}

/// The content of a file of samples.
#[derive(Debug)]
pub struct Samples {
    /// All samples, in the order of the file.
    pub sites: Vec<Site>,
    /// The line of each sample, from 1.
    pub lines: Vec<usize>,
    /// At least one.
    pub groups: Vec<Group>,
}

/// Parses the text of the file `name`: one sample per line; `#` begins a comment. A line `curve
/// NAME` begins another curve.
pub fn parse(text: &str, name: &str) -> Result<Samples> {
    let (mut sites, mut lines): (Vec<Site>, Vec<usize>) = (Vec::new(), Vec::new());
    let mut groups: Vec<Group> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let place = || format!("{name}:{}", i + 1);
        let words: Vec<&str> =
            line.split('#').next().unwrap_or_default().split_whitespace().collect();
        match words[..] {
            [] => {}
            ["curve", name, ref options @ ..] => {
                if groups.is_empty() && !sites.is_empty() {
                    bail!("{}: samples before the first curve", place());
                }
                if groups.iter().any(|group| group.name.as_deref() == Some(name)) {
                    bail!("{}: a second curve {name}", place());
                }
                groups.push(group(name, options, sites.len()).with_context(place)?);
            }
            _ => {
                let site = site(&words).with_context(|| {
                    format!(
                        "{}: neither a vertex, nor a face and three barycentric coordinates, nor a \
                         point x y z (numbers between blanks), nor `curve NAME`",
                        place()
                    )
                })?;
                sites.push(site);
                lines.push(i + 1);
                if let Some(group) = groups.last_mut() {
                    group.samples.end = sites.len();
                }
            }
        }
    }
    if groups.is_empty() {
        let samples = 0..sites.len();
        groups.push(Group { name: None, open: false, single: false, side: None, samples });
    }
    Ok(Samples { sites, lines, groups })
}

/// Parses `small`, `large` or `seed:V,W`.
pub fn side(text: &str) -> Result<Side, String> {
    match text.split_once(':') {
        None if text == "small" => Ok(Side::Small),
        None if text == "large" => Ok(Side::Large),
        Some(("seed", list)) => {
            let all: Result<Vec<u32>, _> = list.split(',').map(str::parse).collect();
            all.map(Side::Seeds).map_err(|_| format!("{list}: expected vertex numbers, from 0"))
        }
        _ => Err("expected small, large or seed:V, such as seed:120".into()),
    }
}

/// Returns a curve with this name and without samples.
fn group(name: &str, options: &[&str], start: usize) -> Result<Group> {
    if name.contains(|c: char| c.is_control() || c == '"' || c == '\\') {
        bail!("the name {name:?} has a quote, a backslash or a control character");
    }
    let name = Some(name.to_owned());
    let mut group = Group { name, open: false, single: false, side: None, samples: start..start };
    for &option in options {
        match option.split_once('=') {
            None if option == "open" => group.open = true,
            None if option == "single" => group.single = true,
            Some(("side", text)) => group.side = Some(side(text).map_err(anyhow::Error::msg)?),
            _ => bail!("{option}: expected open, single or side=SIDE"),
        }
    }
    Ok(group)
}

/// Returns the position of a sample: a vertex, a face and three barycentric coordinates, or a point
/// in space.
pub fn site(words: &[&str]) -> Option<Site> {
    let numbers = |words: &[&str]| -> Option<[f64; 3]> {
        let all: Option<Vec<f64>> = words.iter().map(|word| word.parse().ok()).collect();
        all?.try_into().ok()
    };
    match words {
        [vertex] => Some(Site::Vertex(index(vertex)?)),
        [_, _, _] => Some(Site::Near(numbers(words)?)),
        [face, weights @ ..] => {
            Some(Site::Face(SurfacePoint { face: index(face)?, weights: numbers(weights)? }))
        }
        [] => None,
    }
}

/// Parses the number of a vertex or face; tables of real numbers write 7 as 7.0.
fn index(word: &str) -> Option<u32> {
    word.strip_suffix(".0").unwrap_or(word).parse().ok()
}
