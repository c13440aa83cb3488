//! Computes components, boundary loops and genus of a manifold, from the edges at its vertices.

use super::result::Topology;
use super::surface::Surface;
use crate::mesh::Genus;

/// A connected component.
pub(super) struct Component {
    /// Its lowest vertex.
    pub first: u32,
    pub closed: bool,
}

impl Component {
    /// Returns the least number of vertices of the component: those of a tetrahedron, or of a
    /// triangle.
    pub fn least_vertices(&self) -> usize {
        if self.closed { 4 } else { 3 }
    }
}

/// Returns the components, ordered by their lowest vertices.
pub(super) fn components(surface: &Surface<'_>) -> Vec<Component> {
    let mut seen = vec![false; surface.len()];
    let mut found = Vec::new();
    let mut open = Vec::new();
    for first in 0..surface.len() as u32 {
        if seen[first as usize] || surface.links(first).is_empty() {
            continue;
        }
        let mut closed = true;
        seen[first as usize] = true;
        open.push(first);
        while let Some(v) = open.pop() {
            closed &= !surface.on_boundary[v as usize];
            for link in surface.links(v) {
                if !std::mem::replace(&mut seen[link.to as usize], true) {
                    open.push(link.to);
                }
            }
        }
        found.push(Component { first, closed });
    }
    found
}

/// Returns the topology of these components.
pub(super) fn topology(surface: &Surface<'_>, components: usize) -> Topology {
    let (mut vertices, mut ends) = (0i64, 0i64);
    let mut loops = 0;
    let mut seen = vec![false; surface.len()];
    for v in 0..surface.len() as u32 {
        let links = surface.links(v).len() as i64;
        vertices += i64::from(links > 0);
        ends += links;
        if surface.on_boundary[v as usize] && !seen[v as usize] {
            loops += 1;
            walk_loop(surface, v, &mut seen);
        }
    }
    let euler = vertices - ends / 2 + surface.mesh.faces().len() as i64;
    let caps = (2 * components as i64 - loops as i64 - euler).max(0) as usize;
    let genus =
        if surface.oriented { Genus::Orientable(caps / 2) } else { Genus::NonOrientable(caps) };
    Topology { components, boundary_loops: loops, genus }
}

fn walk_loop(surface: &Surface<'_>, start: u32, seen: &mut [bool]) {
    let mut at = Some(start);
    while let Some(v) = at {
        seen[v as usize] = true;
        let ends = surface.along_boundary(v).unwrap_or([v; 2]);
        at = ends.into_iter().find(|&w| !seen[w as usize]);
    }
}
