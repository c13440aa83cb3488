//! The edges of a set of triangles.

/// An edge and where it occurs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Edge<'a> {
    /// Its ends, the lower first.
    pub vertices: [u32; 2],
    /// The faces it is in, ascending: slot 3 f + k is the edge of face f from its corner k to k + 1 (mod 3).
    pub slots: &'a [u32],
}

/// The slots of all faces, grouped by edge.
#[derive(Debug, Clone)]
pub(crate) struct Edges {
    slots: Vec<u32>,
    /// Ends of each edge, and where its slots start.
    edges: Vec<([u32; 2], u32)>,
}

impl Edges {
    /// Edges, sorted by their ends.
    pub fn iter(&self) -> impl Iterator<Item = Edge<'_>> {
        (0..self.edges.len()).map(|e| {
            let (vertices, start) = self.edges[e];
            let end = self.edges.get(e + 1).map_or(self.slots.len(), |next| next.1 as usize);
            Edge { vertices, slots: &self.slots[start as usize..end] }
        })
    }
}

/// The edges of faces among n vertices; at most 2^32 / 3 faces. O(n + faces) unless many edges meet at a vertex.
pub(crate) fn edges(n: usize, faces: &[[u32; 3]]) -> Edges {
    let ends = |slot: usize| {
        let face = &faces[slot / 3];
        let (a, b) = (face[slot % 3], face[(slot + 1) % 3]);
        if a < b { [a, b] } else { [b, a] }
    };
    let mut starts = vec![0; n + 1];
    for slot in 0..3 * faces.len() {
        starts[ends(slot)[0] as usize + 1] += 1;
    }
    for v in 0..n {
        starts[v + 1] += starts[v];
    }
    let mut next = starts.clone();
    let mut by_lower = vec![(0, 0); 3 * faces.len()];
    for slot in 0..3 * faces.len() {
        let [lower, upper] = ends(slot);
        by_lower[next[lower as usize]] = (upper, slot as u32);
        next[lower as usize] += 1;
    }
    let mut edges = Vec::with_capacity(faces.len() + faces.len() / 2);
    for v in 0..n {
        let range = starts[v]..starts[v + 1];
        by_lower[range.clone()].sort_unstable();
        let mut start = range.start;
        for run in by_lower[range].chunk_by(|a, b| a.0 == b.0) {
            edges.push(([v as u32, run[0].0], start as u32));
            start += run.len();
        }
    }
    Edges { slots: by_lower.into_iter().map(|(_, slot)| slot).collect(), edges }
}
