//! The text format of the reference implementation of the thesis.

use super::super::{Plant, Segment};
use super::lines::Lines;
use catamaran::base::Result;

pub(super) fn read(lines: &mut Lines<'_>, [length, thickness]: [f64; 2]) -> Result<Plant> {
    let count = header(lines, "verts")?;
    let mut segments = Vec::new();
    for expected in 0..count {
        let line = lines.expect("a line of a node")?;
        let mut words = line.split(',');
        let id = lines.count("id", words.next())?;
        if id != expected {
            return Err(lines.fail(format!("the next id must be {expected}, is {id}")));
        }
        let tail = lines.point(&mut words, length)?;
        let radius = thickness * lines.number("radius", words.next())?;
        let mut segment = Segment::stem(tail, radius);
        segment.leaf = lines.flag("on_leaf", words.next())?;
        segment.pinned = match words.next() {
            Some(word) => lines.flag("fixed", Some(word))?,
            None => false,
        };
        lines.end(words, "id,x,y,z,radius,on_leaf and perhaps fixed")?;
        segments.push(segment);
    }
    let count = header(lines, "edges")?;
    let mut edges = Vec::new();
    for _ in 0..count {
        let line = lines.expect("a line of an edge")?;
        let mut words = line.split(',');
        let mut node = || lines.count("node", words.next()).map(|v| v as u32);
        edges.push([node()?, node()?]);
        lines.end(words, "the two nodes of an edge")?;
    }
    if lines.next()?.is_some() {
        return Err(lines.fail(format!("more than the announced {count} edges")));
    }
    Plant::from_edges(segments, &edges, None)
}

fn header(lines: &mut Lines<'_>, keyword: &str) -> Result<usize> {
    let line = lines.expect(&format!("`{keyword} COUNT`"))?;
    match line.split_once(char::is_whitespace) {
        Some((word, count)) if word == keyword => lines.count(keyword, Some(count)),
        _ => Err(lines.fail(format!("must be `{keyword} COUNT`, is {line:?}"))),
    }
}
