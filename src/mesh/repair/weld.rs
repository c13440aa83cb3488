//! Vertices in one place found.

use std::collections::HashMap;

use super::super::vector::{Vector, distance};
use super::super::{Edges, TriMesh};
use super::rebuild::Rebuild;
use super::refused;
use crate::base::Result;

/// For each point the lowest one, itself or an earlier one, that is at most `tolerance` away and is its
/// own representative. O(n) for points that are spread out.
///
/// # Errors
/// [`Error::Argument`](crate::Error::Argument) for a tolerance that is negative or not finite.
pub(super) fn representatives(points: &[Vector], tolerance: f64) -> Result<Vec<u32>> {
    if !(tolerance >= 0.0 && tolerance.is_finite()) {
        let why = format!("{tolerance}, where a length of at least 0 is needed");
        return Err(refused("tolerance", why));
    }
    Ok(if tolerance > 0.0 { near(points, tolerance) } else { equal(points) })
}

fn equal(points: &[Vector]) -> Vec<u32> {
    let mut first: HashMap<[u64; 3], u32> = HashMap::with_capacity(points.len());
    // Adding 0 makes -0 to 0.
    let key = |p: &Vector| p.map(|x| (x + 0.0).to_bits());
    points.iter().zip(0..).map(|(p, v)| *first.entry(key(p)).or_insert(v)).collect()
}

/// A grid of boxes twice as wide as the tolerance, with the representatives in each. They are farther
/// from each other than the tolerance, so that a box has few.
fn near(points: &[Vector], tolerance: f64) -> Vec<u32> {
    let mut boxes: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    // Beyond the range of integers all are in the outermost box, where distances tell them apart.
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

/// What joining vertices does to a mesh.
pub(super) struct Gain {
    /// There are fewer boundary edges.
    pub closes: bool,
    /// There are more edges of more than two faces, or more vertices at which the surface meets itself;
    /// repeated faces are not counted.
    pub tangles: bool,
}

pub(super) fn gain(mesh: &TriMesh, joined: &Rebuild) -> Result<Gain> {
    let before = Counts::of(mesh)?;
    let positions = joined.vertices.iter().map(|&v| mesh.vertices()[v as usize]).collect();
    let after = Counts::of(&TriMesh::new(positions, joined.faces.clone())?)?;
    Ok(Gain {
        closes: after.boundary < before.boundary,
        tangles: after.edges > before.edges || after.vertices > before.vertices,
    })
}

/// What is not as in a closed manifold, repeated faces left out.
struct Counts {
    boundary: usize,
    edges: usize,
    vertices: usize,
}

impl Counts {
    fn of(mesh: &TriMesh) -> Result<Self> {
        let mut kept = vec![true; mesh.faces().len()];
        mesh.repeated_faces().iter().for_each(|[face, _]| kept[*face as usize] = false);
        let kept: Vec<u32> = (0..).zip(kept).filter(|(_, kept)| *kept).map(|(f, _)| f).collect();
        let mesh = mesh.submesh(&kept)?.mesh;
        let edges = Edges::new(&mesh);
        Ok(Self {
            boundary: edges.boundary().count(),
            edges: edges.non_manifold().count(),
            vertices: mesh.fans(&edges).into_iter().filter(|&fans| fans > 1).count(),
        })
    }
}
