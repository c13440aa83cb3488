//! Finds vertices in the same place.

use std::collections::HashMap;

use super::super::vector::{Vector, bits, distance};
use super::super::{Edges, TriMesh};
use catamaran::base::{Result, Sets, at_least_zero};

/// Returns for each point the lowest point, itself or an earlier one, that is at most `tolerance`
/// away and is its own representative. O(n) for points that are spread out.
///
/// # Errors
/// [`Error::Argument`](catamaran::Error::Argument) for a tolerance that is negative or not finite.
pub(super) fn representatives(points: &[Vector], tolerance: f64) -> Result<Vec<u32>> {
    at_least_zero("tolerance", tolerance)?;
    Ok(if tolerance > 0.0 { near(points, tolerance) } else { equal(points) })
}

fn equal(points: &[Vector]) -> Vec<u32> {
    let mut first: HashMap<[u64; 3], u32> = HashMap::with_capacity(points.len());
    points.iter().zip(0..).map(|(&p, v)| *first.entry(bits(p)).or_insert(v)).collect()
}

/// Returns the representatives by a grid of boxes twice as wide as the tolerance. The distance
/// between representatives exceeds the tolerance, so that a box has few of them.
fn near(points: &[Vector], tolerance: f64) -> Vec<u32> {
    let mut boxes: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    // Points beyond the range of integers share the outermost boxes, where distances tell them
    // apart.
    let place = |p: &Vector| p.map(|x| (x / tolerance / 2.0).floor() as i64);
    let mut found = Vec::with_capacity(points.len());
    for (v, p) in (0..).zip(points) {
        let middle = place(p);
        let around = (0..27).map(|i: i64| {
            let step = [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1];
            std::array::from_fn(|k| middle[k].saturating_add(step[k]))
        });
        let close = around.filter_map(|at: [i64; 3]| boxes.get(&at)).flatten().copied();
        let close = close.filter(|&u| distance(points[u as usize], *p) <= tolerance);
        let lowest = close.min().unwrap_or(v);
        if lowest == v {
            boxes.entry(middle).or_default().push(v);
        }
        found.push(lowest);
    }
    found
}

/// The seams of a mesh: boundary edges that coincide.
pub(in crate::mesh) struct Seams {
    /// For each vertex, the lowest vertex that it joins along seams; itself elsewhere.
    pub to: Vec<u32>,
    /// The boundary edges that stay, because more than two coincide.
    pub ambiguous: Vec<u32>,
}

impl Seams {
    /// Finds the seams: places where exactly two boundary edges coincide. Vertices in one place
    /// that are not connected by such edges stay apart.
    pub fn of(mesh: &TriMesh) -> Self {
        let place = equal(mesh.vertices());
        let apart = || (0..place.len() as u32).collect();
        if place.iter().zip(0..).all(|(&first, v)| first == v) {
            return Self { to: apart(), ambiguous: Vec::new() };
        }
        let edges = Edges::new(mesh);
        let mut found: Vec<([u32; 2], u32)> = edges
            .boundary()
            .map(|e| {
                let [a, b] = edges.ends()[e as usize].map(|v| place[v as usize]);
                ([a.min(b), a.max(b)], e)
            })
            .filter(|([a, b], _)| a != b)
            .collect();
        found.sort_unstable();
        let mut sets = Sets::new(place.len());
        let mut ambiguous = Vec::new();
        for group in found.chunk_by(|a, b| a.0 == b.0) {
            match group {
                [_] => {}
                [(_, e), (_, other)] => {
                    let face = |e: &u32| edges.faces(*e as usize).next();
                    // The two long edges of a face without area are no seam.
                    if face(e) != face(other) {
                        let [a, b] = edges.ends()[*e as usize];
                        let [c, d] = edges.ends()[*other as usize];
                        let same = place[a as usize] == place[c as usize];
                        sets.join(a, if same { c } else { d });
                        sets.join(b, if same { d } else { c });
                    }
                }
                more => ambiguous.extend(more.iter().map(|(_, e)| *e)),
            }
        }
        Self { to: (0..place.len() as u32).map(|v| sets.find(v)).collect(), ambiguous }
    }
}
