//! Polylines of Wavefront OBJ.

use super::super::{Plant, Segment};
use super::lines::Lines;
use catamaran::base::Result;

/// The default radius of a vertex, in metres.
const RADIUS: f64 = 1e-3;

pub(super) fn read(lines: &mut Lines<'_>, [length, thickness]: [f64; 2]) -> Result<Plant> {
    let mut segments: Vec<Segment> = Vec::new();
    let mut edges: Vec<[u32; 2]> = Vec::new();
    while let Some(line) = lines.next()? {
        let mut words = line.split('#').next().unwrap_or_default().split_whitespace();
        match words.next() {
            Some("v") => {
                let tail = lines.point(&mut words, length)?;
                let radius = match words.next() {
                    Some(word) => thickness * lines.number("radius", Some(word))?,
                    None => RADIUS,
                };
                lines.end(words, "x, y, z and perhaps a radius, no colours")?;
                segments.push(Segment::stem(tail, radius));
            }
            Some("l") => {
                let (mut before, mut count) = (None, 0);
                for word in words {
                    count += 1;
                    let v = vertex(lines, word, segments.len())?;
                    if let Some(u) = before.replace(v) {
                        edges.push([u, v]);
                    }
                }
                if count < 2 {
                    return Err(lines.fail("a line (`l`) of fewer than two vertices"));
                }
            }
            Some("f") => return Err(lines.fail("a face (`f`): a plant has lines (`l`) only")),
            _ => {}
        }
    }
    let Some(&[root, _]) = edges.first() else {
        return Err(lines.fail("no line (`l`) of at least two vertices"));
    };
    let mut degrees = vec![0; segments.len()];
    for v in edges.iter().flatten() {
        degrees[*v as usize] += 1;
    }
    for (v, segment) in segments.iter_mut().enumerate() {
        segment.leaf = degrees[v] == 1 && v != root as usize;
    }
    let base = segments[root as usize].tail;
    Plant::from_edges(segments, &edges, Some(base))
}

/// Parses the number of a vertex, from 1, or negative from the end; of `v/vt` the first part.
fn vertex(lines: &Lines<'_>, word: &str, count: usize) -> Result<u32> {
    let number = word.split('/').next().and_then(|w| w.parse::<i64>().ok());
    let index = number.and_then(|i| {
        if i < 0 { count.checked_add_signed(i as isize) } else { usize::try_from(i - 1).ok() }
    });
    match index.filter(|&v| v < count) {
        Some(v) => Ok(v as u32),
        None => Err(lines.fail(format!("{word:?} is none of the {count} vertices so far"))),
    }
}
