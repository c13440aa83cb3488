//! Vertices of the input that stay where they are, and the edges between them.

use std::collections::{HashMap, HashSet};

use super::farthest::without_face;
use super::patch::{Compact, Kept, edge};
use super::prepare::Prepared;
use catamaran::base::{Error, Result};

/// The locked vertices of a surface.
#[derive(Default)]
pub(super) struct Locks {
    /// The vertices, ascending: all parts of a vertex that was split.
    pub vertices: Vec<u32>,
    /// The edges between them before long edges are split.
    pub edges: Kept,
    /// For each vertex that the caller names, its first part.
    named: Vec<u32>,
}

impl Locks {
    /// Finds the vertices of `prepared` that are these vertices of the input, which has `given`.
    ///
    /// # Errors
    /// [`Error::Argument`] that names a vertex without a face, or one that is named twice.
    pub fn new(prepared: &Prepared<'_>, named: &[u32], given: usize) -> Result<Self> {
        if named.is_empty() {
            return Ok(Self::default());
        }
        let surface = &prepared.surface;
        let mut first: HashMap<u32, Option<u32>> = HashMap::with_capacity(named.len());
        for &v in named {
            if first.insert(v, None).is_some() {
                let why = format!("has vertex {v} twice");
                return Err(Error::Argument { what: "locked", why });
            }
        }
        let mut vertices = Vec::new();
        for v in (0..surface.len() as u32).filter(|&v| !surface.links(v).is_empty()) {
            let of = prepared.vertices.as_ref().map_or(v, |vertices| vertices[v as usize]);
            if let Some(place) = first.get_mut(&of) {
                place.get_or_insert(v);
                vertices.push(v);
            }
        }
        let part = |v: &u32| first[v].ok_or_else(|| without_face("locked", *v, given));
        let named = named.iter().map(part).collect::<Result<_>>()?;
        let is_locked = |v: u32| vertices.binary_search(&v).is_ok();
        let ends = vertices.iter().flat_map(|&v| {
            let others = surface.links(v).iter().map(|link| link.to);
            others.filter(move |&w| w > v).map(move |w| [v, w])
        });
        let edges = ends.filter(|&[_, w]| is_locked(w)).collect();
        Ok(Self { vertices, edges, named })
    }

    /// Returns whether a vertex of the surface is locked.
    pub fn contains(&self, v: u32) -> bool {
        self.vertices.binary_search(&v).is_ok()
    }

    /// Returns the vertices and faces with the vertices that the caller names first, in that order,
    /// and then the other parts of those that were split.
    pub fn first(&self, found: Compact) -> Compact {
        if self.named.is_empty() {
            return found;
        }
        let at = vertices_at(&found.anchors, &found.locked);
        let named = self.named.iter().filter_map(|v| at.get(v).copied());
        let mut order: Vec<u32> = named.collect();
        let mut known: HashSet<u32> = order.iter().copied().collect();
        let parts = self.vertices.iter().filter_map(|v| at.get(v).copied());
        order.extend(parts.filter(|&v| known.insert(v)));
        order.extend((0..found.positions.len() as u32).filter(|v| !known.contains(v)));
        let mut number = vec![0; order.len()];
        (0..).zip(&order).for_each(|(new, &old)| number[old as usize] = new);
        let from = || order.iter().map(|&v| v as usize);
        Compact {
            positions: from().map(|v| found.positions[v]).collect(),
            anchors: from().map(|v| found.anchors[v]).collect(),
            on_boundary: from().map(|v| found.on_boundary[v]).collect(),
            locked: from().map(|v| found.locked[v]).collect(),
            kept: found.kept,
            faces: found.faces.iter().map(|face| face.map(|v| number[v as usize])).collect(),
        }
    }

    /// Returns the number of edges between locked vertices that the result does not have.
    pub fn lost_edges(&self, Compact { anchors, locked, faces, .. }: &Compact) -> usize {
        let at = vertices_at(anchors, locked);
        let there = |v: &u32| at.get(v).copied();
        let ends = |[a, b]: &[u32; 2]| Some(edge(there(a)?, there(b)?));
        let mut edges: HashSet<[u32; 2]> = self.edges.iter().filter_map(ends).collect();
        for &[a, b, c] in faces {
            for [u, v] in [[a, b], [b, c], [c, a]] {
                edges.remove(&edge(u, v));
            }
        }
        edges.len()
    }
}

/// Returns the locked vertices of a result by their anchors, vertices of the surface.
fn vertices_at(anchors: &[u32], locked: &[bool]) -> HashMap<u32, u32> {
    let all = (0..).zip(anchors).zip(locked).filter(|x| *x.1);
    all.map(|((v, &anchor), _)| (anchor, v)).collect()
}

/// Returns an error unless `n` vertices are enough for the locked ones.
pub(super) fn check_number(locks: &Locks, n: usize) -> Result<()> {
    let count = locks.vertices.len();
    if n < count {
        let parts = if locks.named.len() < count { ", with all parts of split ones" } else { "" };
        let why = format!("{n}, but {count} vertices are locked{parts}");
        return Err(Error::Argument { what: "n", why });
    }
    Ok(())
}
