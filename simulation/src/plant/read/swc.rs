//! SWC (Cannon, Turner, Pyapali and Wheal 1998).

use std::collections::HashMap;

use super::super::{Plant, Segment};
use super::lines::Lines;
use catamaran::base::Result;

/// The type of nodes on leaves: "custom" in the format.
const LEAF: usize = 7;

pub(super) fn read(lines: &mut Lines<'_>, [length, thickness]: [f64; 2]) -> Result<Plant> {
    let (mut segments, mut parents) = (Vec::new(), Vec::new());
    let mut numbers = HashMap::new();
    while let Some(line) = lines.next()? {
        let text = line.split('#').next().unwrap_or_default();
        if text.is_empty() {
            continue;
        }
        // Columns after the parent are extensions, and not read.
        let mut words = text.split_whitespace();
        let id = lines.count("id", words.next())?;
        let kind = lines.count("type", words.next())?;
        let tail = lines.point(&mut words, length)?;
        let radius = thickness * lines.number("radius", words.next())?;
        let mut segment = Segment::stem(tail, radius);
        segment.leaf = kind == LEAF;
        let parent = match words.next() {
            Some("-1") => None,
            word => Some(lines.count("parent", word)?),
        };
        if numbers.insert(id, segments.len() as u32).is_some() {
            return Err(lines.fail(format!("node {id} occurs twice")));
        }
        segments.push(segment);
        parents.push(parent);
    }
    let mut known = Vec::with_capacity(parents.len());
    for parent in parents {
        known.push(match parent {
            None => None,
            Some(id) => match numbers.get(&id) {
                Some(&v) => Some(v),
                None => return Err(lines.fail(format!("node {id}, a parent, does not exist"))),
            },
        });
    }
    Plant::new(segments, &known, None)
}
