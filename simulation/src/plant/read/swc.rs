//! SWC (Cannon, Turner, Pyapali and Wheal 1998).

use std::collections::HashMap;

use super::super::{Plant, Segment};
use super::lines::Lines;
use catamaran::base::Result;

/// The type of nodes on leaves: "custom" in the format.
const LEAF: usize = 7;

pub(super) fn read(lines: &mut Lines<'_>) -> Result<Plant> {
    let (mut segments, mut parents) = (Vec::new(), Vec::new());
    let mut numbers = HashMap::new();
    while let Some(line) = lines.next()? {
        if line.starts_with('#') {
            continue;
        }
        let mut words = line.split_whitespace();
        let id = lines.count("id", words.next())?;
        let kind = lines.count("type", words.next())?;
        let mut number = |what| lines.number(what, words.next());
        let tail = [number("x")?, number("y")?, number("z")?];
        let mut segment = Segment::stem(tail, number("radius")?);
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
