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
    let plant = Plant::from_edges(segments, &edges, None)?;
    let note = far_root(&plant);
    Ok(plant.noting(note))
}

/// Returns a note on a root far from the origin, where its segment begins.
fn far_root(plant: &Plant) -> Option<String> {
    /// The length of a usual root segment, relative to that of the longest other segment. It is at
    /// most 1.5 in the plants of the reference implementation.
    const USUAL: f64 = 10.0;
    let (root, lengths) = (plant.root(), plant.lengths());
    let others = (0..plant.len()).filter(|&v| v != root).map(|v| lengths[v]);
    let longest = others.fold(0.0, f64::max);
    (longest > 0.0 && lengths[root] > USUAL * longest).then(|| {
        format!(
            "the segment of the root, node {root}, is {:.3} m long, and no other more than \
             {longest:.3} m: it begins at the origin",
            lengths[root]
        )
    })
}

fn header(lines: &mut Lines<'_>, keyword: &str) -> Result<usize> {
    let line = lines.expect(&format!("`{keyword} COUNT`"))?;
    match line.split_once(char::is_whitespace) {
        Some((word, count)) if word == keyword => lines.count(keyword, Some(count)),
        _ => Err(lines.fail(format!("must be `{keyword} COUNT`, is {line:?}"))),
    }
}
