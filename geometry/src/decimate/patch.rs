//! The new mesh during changes: faces, the faces at each vertex, and the changes that preserve a
//! manifold.

use std::collections::HashSet;

use super::density::Stretch;
use crate::mesh::intersections::{Bounds, BoxTree, Corners};
use crate::mesh::vector::{Vector, distance, dot, doubled_normal, middle, unit};

/// Largest number of faces that were added after the tree was built, and that are searched one by
/// one.
const LATE: usize = 128;

/// The new position of a vertex, and its anchor there.
pub(super) type Move = (Vector, u32);

/// Edges between anchors, the lower one first.
pub(super) type Kept = HashSet<[u32; 2]>;

/// Returns an edge in the form in which [`Kept`] has it.
pub(super) fn edge(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Marks a removed face.
const GONE: [u32; 3] = [u32::MAX; 3];

/// A manifold mesh, with boundary or without, whose edges can be collapsed, split and flipped.
pub(super) struct Patch {
    positions: Vec<Vector>,
    /// For each vertex, a vertex of the input near it, which is on the boundary if the vertex is.
    pub anchors: Vec<u32>,
    pub on_boundary: Vec<bool>,
    /// Whether each vertex stays where it is.
    pub locked: Vec<bool>,
    /// Edges between the anchors of locked vertices that stay.
    kept: Kept,
    /// The factors by which lengths are stretched, at vertices of the input.
    pub stretch: Stretch,
    pub faces: Vec<[u32; 3]>,
    /// For each vertex its faces; empty for a removed vertex.
    around: Vec<Vec<u32>>,
    /// Number of vertices that are not removed.
    pub count: usize,
    /// The boxes of the faces that existed when the tree was built.
    tree: BoxTree,
}

/// The one or two faces of an edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sides {
    pub first: u32,
    pub second: Option<u32>,
}

impl Patch {
    /// Creates a patch of these vertices and faces.
    pub fn new(positions: Vec<Vector>, anchors: Vec<u32>, faces: Vec<[u32; 3]>) -> Self {
        let mut around = vec![Vec::with_capacity(8); positions.len()];
        for (face, f) in faces.iter().zip(0..) {
            face.iter().for_each(|&v| around[v as usize].push(f));
        }
        let count = around.iter().filter(|faces| !faces.is_empty()).count();
        let on_boundary = vec![false; positions.len()];
        let (locked, kept) = (vec![false; positions.len()], Kept::new());
        let tree = BoxTree::new(0, |_| None);
        let mut patch = Self {
            positions,
            anchors,
            on_boundary,
            locked,
            kept,
            stretch: Stretch::default(),
            faces,
            around,
            count,
            tree,
        };
        for v in 0..patch.positions.len() as u32 {
            let neighbours = patch.neighbours(v);
            patch.on_boundary[v as usize] = neighbours.len() > patch.around[v as usize].len();
        }
        patch.plant_tree();
        patch
    }

    /// Locks vertices, and the edges between them whose ends have these anchors.
    pub fn lock(&mut self, locked: Vec<bool>, kept: Kept) {
        (self.locked, self.kept) = (locked, kept);
    }

    /// Returns whether the edge from a to b stays.
    pub fn is_kept(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|v| v as usize);
        self.locked[a]
            && self.locked[b]
            && self.kept.contains(&edge(self.anchors[a], self.anchors[b]))
    }

    /// Builds a tree of the current faces.
    pub fn plant_tree(&mut self) {
        self.tree = BoxTree::new(self.faces.len(), |f| self.bounds(f as u32));
    }

    /// Calls `found` for every face whose box meets `bounds`.
    pub fn visit(&self, bounds: &Bounds, mut found: impl FnMut(u32)) {
        self.tree.visit(bounds, &mut found);
        let late = self.tree.len() as u32..self.faces.len() as u32;
        late.filter(|&f| self.bounds(f).is_some_and(|own| own.meets(bounds))).for_each(found);
    }

    /// Returns the tree, which holds all faces after [`Patch::plant_tree`], until one is added.
    pub fn tree(&self) -> &BoxTree {
        &self.tree
    }

    fn bounds(&self, f: u32) -> Option<Bounds> {
        self.face(f as usize).map(|face| Bounds::of(&self.corners_at(face)))
    }

    /// Updates the box of a changed face in the tree.
    fn refresh(&mut self, f: u32) {
        if (f as usize) < self.tree.len() {
            self.tree.update(f, self.bounds(f));
        } else if self.faces.len() > self.tree.len() + LATE {
            self.plant_tree();
        }
    }

    /// Returns the positions of all vertices.
    pub fn positions(&self) -> &[Vector] {
        &self.positions
    }

    /// Returns the position of v.
    pub fn position(&self, v: u32) -> Vector {
        self.positions[v as usize]
    }

    /// Returns the positions of the corners of face f, which must exist.
    pub fn corners_of(&self, f: u32) -> Corners {
        self.corners_at(self.faces[f as usize])
    }

    /// Returns the positions of the corners of a face.
    pub fn corners_at(&self, face: [u32; 3]) -> Corners {
        face.map(|v| self.positions[v as usize])
    }

    /// Returns the positions of the corners of a face with the vertices `moved` at p.
    pub fn corners_with(&self, face: [u32; 3], moved: [u32; 2], p: Vector) -> Corners {
        face.map(|v| if moved.contains(&v) { p } else { self.positions[v as usize] })
    }

    /// Moves a vertex; the caller rebuilds the tree ([`Patch::plant_tree`]).
    pub fn displace(&mut self, v: u32, p: Vector) {
        self.positions[v as usize] = p;
    }

    /// Moves a vertex.
    pub fn place(&mut self, v: u32, p: Vector) {
        self.positions[v as usize] = p;
        for i in 0..self.around[v as usize].len() {
            self.refresh(self.around[v as usize][i]);
        }
    }

    /// Moves a vertex and its anchor.
    pub fn move_to(&mut self, v: u32, (p, anchor): Move) {
        self.place(v, p);
        self.anchors[v as usize] = anchor;
    }

    /// Returns the faces around v.
    pub fn around(&self, v: u32) -> &[u32] {
        &self.around[v as usize]
    }

    /// Returns the neighbours of v, each once.
    pub fn neighbours(&self, v: u32) -> Vec<u32> {
        let mut neighbours = Vec::with_capacity(12);
        for &f in self.around(v) {
            for w in self.faces[f as usize] {
                if w != v && !neighbours.contains(&w) {
                    neighbours.push(w);
                }
            }
        }
        neighbours
    }

    /// Returns the faces on both sides of the edge from a to b.
    pub fn sides(&self, a: u32, b: u32) -> Option<Sides> {
        let with_b = |&f: &u32| self.faces[f as usize].contains(&b);
        let mut sides = self.around(a).iter().copied().filter(with_b);
        Some(Sides { first: sides.next()?, second: sides.next() })
    }

    /// Returns the corner of face f that is neither a nor b.
    pub fn opposite(&self, f: u32, a: u32, b: u32) -> u32 {
        let [x, y, z] = self.faces[f as usize];
        if x != a && x != b {
            x
        } else if y != a && y != b {
            y
        } else {
            z
        }
    }

    /// Returns all edges, each once, the lower vertex first, in the order of faces.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::with_capacity(3 * self.count);
        for (&[a, b, c], f) in self.faces.iter().zip(0..) {
            if [a, b, c] == GONE {
                continue;
            }
            for (u, v) in [(a, b), (b, c), (c, a)] {
                if self.sides(u, v).is_some_and(|sides| sides.first == f) {
                    edges.push([u.min(v), u.max(v)]);
                }
            }
        }
        edges
    }

    /// Returns the mean stretched length of all edges; 0 without edges.
    pub fn mean_length(&self) -> f64 {
        let edges = self.edges();
        let total: f64 = edges.iter().map(|&[a, b]| self.stretched(a, b)).sum();
        total / edges.len().max(1) as f64
    }

    /// Returns the corners of a face; `None` if it was removed.
    pub fn face(&self, f: usize) -> Option<[u32; 3]> {
        Some(self.faces[f]).filter(|&face| face != GONE)
    }

    /// Returns the middle of the edge from a to b.
    pub fn middle(&self, a: u32, b: u32) -> Vector {
        middle(self.positions[a as usize], self.positions[b as usize])
    }

    /// Returns the length of the edge from a to b.
    pub fn length(&self, a: u32, b: u32) -> f64 {
        distance(self.positions[a as usize], self.positions[b as usize])
    }

    /// Returns the factor by which lengths at v are longer for their comparison with others.
    pub fn stretch_at(&self, v: u32) -> f64 {
        self.stretch.at(self.anchors[v as usize])
    }

    /// Returns the mean of these factors at the ends of an edge or the corners of a face.
    pub fn stretch_of<const N: usize>(&self, vertices: [u32; N]) -> f64 {
        match self.stretch.factors() {
            None => 1.0,
            Some(_) => vertices.map(|v| self.stretch_at(v)).iter().sum::<f64>() / N as f64,
        }
    }

    /// Returns the stretched length of the edge from a to b.
    pub fn stretched(&self, a: u32, b: u32) -> f64 {
        self.length(a, b) * self.stretch_of([a, b])
    }

    /// Returns twice the area of a face times its normal.
    pub fn normal(&self, face: [u32; 3]) -> Vector {
        doubled_normal(face.map(|v| self.positions[v as usize]))
    }

    /// Returns whether the edge can collapse without a change of the topology: the links of its
    /// ends meet in the link of the edge (Dey et al., Topology preserving edge contraction, 1999).
    /// Two locked ends can't be one vertex, and a locked end inside can't be on the boundary.
    pub fn can_collapse(&self, a: u32, b: u32) -> bool {
        let [at, bt] = [a, b].map(|v| (self.locked[v as usize], self.on_boundary[v as usize]));
        if at.0 && bt.0 || at == (true, false) && bt.1 || bt == (true, false) && at.1 {
            return false;
        }
        let Some(Sides { first, second }) = self.sides(a, b) else { return false };
        let both = self.on_boundary[a as usize] && self.on_boundary[b as usize];
        if both && second.is_some() {
            return false;
        }
        let c = self.opposite(first, a, b);
        let d = second.map(|second| self.opposite(second, a, b));
        let of_b = self.neighbours(b);
        let common = self.neighbours(a).into_iter().filter(|v| of_b.contains(v));
        if common.into_iter().any(|v| v != c && Some(v) != d) {
            return false;
        }
        let one_face = |u, v| self.sides(u, v).is_some_and(|sides| sides.second.is_none());
        match d {
            // A tetrahedron or a single triangle would not remain a surface.
            Some(d) => !(self.has_face(a, c, d) && self.has_face(b, c, d)),
            None => !(one_face(a, c) && one_face(b, c)),
        }
    }

    fn has_face(&self, a: u32, b: u32, c: u32) -> bool {
        self.around(a).iter().any(|&f| {
            let face = self.faces[f as usize];
            face.contains(&b) && face.contains(&c)
        })
    }

    /// Returns whether no face around a, except those at `but`, turns over when a moves to p.
    pub fn stays_upright(&self, a: u32, but: Option<u32>, p: Vector) -> bool {
        self.around(a).iter().map(|&f| self.faces[f as usize]).all(|face| {
            if but.is_some_and(|b| face.contains(&b)) {
                return true;
            }
            let new = doubled_normal(self.corners_with(face, [a, a], p));
            dot(unit(new), unit(self.normal(face))) > 0.2
        })
    }

    /// Replaces a by b in all faces of a, and moves b to p. The edge must be collapsible, and a not
    /// locked.
    pub fn collapse(&mut self, a: u32, b: u32, p: Vector) {
        debug_assert!(!self.locked[a as usize]);
        let mut gone = Vec::with_capacity(2);
        for f in std::mem::take(&mut self.around[a as usize]) {
            let face = &mut self.faces[f as usize];
            if face.contains(&b) {
                let [x, y, z] = *face;
                *face = GONE;
                gone.push(f);
                for v in [x, y, z].into_iter().filter(|&v| v != a) {
                    self.around[v as usize].retain(|&g| g != f);
                }
            } else {
                *face = face.map(|v| if v == a { b } else { v });
                self.around[b as usize].push(f);
            }
        }
        gone.into_iter().for_each(|f| self.refresh(f));
        self.place(b, p);
        if self.on_boundary[a as usize] && !self.on_boundary[b as usize] {
            self.on_boundary[b as usize] = true;
            self.anchors[b as usize] = self.anchors[a as usize];
        }
        self.count -= 1;
    }

    /// Inserts a vertex in the middle of the edge from a to b, and returns it; `None` if the edge
    /// stays.
    pub fn split(&mut self, a: u32, b: u32) -> Option<u32> {
        let sides = self.sides(a, b)?;
        if self.is_kept(a, b) {
            return None;
        }
        let new = self.positions.len() as u32;
        self.positions.push(self.middle(a, b));
        let on_boundary = sides.second.is_none();
        // On the boundary, both ends have their anchors there.
        self.anchors.push(self.anchors[a as usize]);
        self.on_boundary.push(on_boundary);
        self.locked.push(false);
        self.around.push(Vec::with_capacity(8));
        for f in [Some(sides.first), sides.second].into_iter().flatten() {
            let face = self.faces[f as usize];
            let half = self.faces.len() as u32;
            let c = self.opposite(f, a, b);
            self.faces[f as usize] = face.map(|v| if v == b { new } else { v });
            self.faces.push(face.map(|v| if v == a { new } else { v }));
            self.around[b as usize].iter_mut().filter(|g| **g == f).for_each(|g| *g = half);
            self.around[c as usize].push(half);
            self.around[new as usize].extend([f, half]);
            self.refresh(f);
            self.refresh(half);
        }
        self.count += 1;
        Some(new)
    }

    /// Returns the faces after a flip of the edge from a to b, which joins its opposite corners
    /// instead; `None` when the edge can't flip.
    pub fn flipped(&self, a: u32, b: u32) -> Option<Flip> {
        let Sides { first, second: Some(second) } = self.sides(a, b)? else { return None };
        let (c, d) = (self.opposite(first, a, b), self.opposite(second, a, b));
        let follows = |f: u32, u: u32, v: u32| {
            let [x, y, z] = self.faces[f as usize];
            [[x, y], [y, z], [z, x]].contains(&[u, v])
        };
        let (a, b) = if follows(first, a, b) { (a, b) } else { (b, a) };
        if c == d || !follows(second, b, a) || self.sides(c, d).is_some() {
            return None;
        }
        let least = |v: u32| if self.on_boundary[v as usize] { 1 } else { 3 };
        if self.is_kept(a, b) {
            return None;
        }
        if self.around(a).len() <= least(a) || self.around(b).len() <= least(b) {
            return None;
        }
        Some(Flip { old: [first, second], ends: [a, b], new: [[c, d, b], [d, c, a]] })
    }

    /// Flips an edge.
    pub fn flip(&mut self, flip: &Flip) {
        let Flip { old: [first, second], ends: [a, b], new } = *flip;
        let [c, d, _] = new[0];
        self.faces[first as usize] = new[0];
        self.faces[second as usize] = new[1];
        // The first face is now at b, the second at a, and both are at c and d.
        self.around[a as usize].retain(|&f| f != first);
        self.around[b as usize].retain(|&f| f != second);
        self.around[c as usize].push(second);
        self.around[d as usize].push(first);
        self.refresh(first);
        self.refresh(second);
    }

    /// Cuts along a loop of three edges that is no face, and closes both ends with a face. `ends`
    /// are the faces on one side of the loop at each of its corners, the first of them at the edge
    /// from the first corner to the second.
    pub fn pinch(&mut self, corners: [u32; 3], ends: &[Vec<u32>; 3]) {
        let [a, b, _] = corners;
        let [x, y, z] = self.faces[ends[0][0] as usize];
        let forward = [[x, y], [y, z], [z, x]].contains(&[a, b]);
        let new = [0, 1, 2].map(|k| self.positions.len() as u32 + k);
        for (k, &v) in corners.iter().enumerate() {
            self.positions.push(self.positions[v as usize]);
            self.anchors.push(self.anchors[v as usize]);
            self.on_boundary.push(false);
            self.locked.push(false);
            for &f in &ends[k] {
                self.faces[f as usize] =
                    self.faces[f as usize].map(|w| if w == v { new[k] } else { w });
            }
            self.around[v as usize].retain(|f| !ends[k].contains(f));
            self.around.push(ends[k].clone());
        }
        // A cap runs along each edge in the direction opposite to the face there.
        let caps = if forward {
            [corners, [new[1], new[0], new[2]]]
        } else {
            [[corners[1], corners[0], corners[2]], new]
        };
        for cap in caps {
            let f = self.faces.len() as u32;
            self.faces.push(cap);
            cap.iter().for_each(|&v| self.around[v as usize].push(f));
            self.refresh(f);
        }
        self.count += 3;
    }

    /// Returns the remaining vertices, renumbered, and faces.
    pub fn compact(self) -> Compact {
        let kept: Vec<usize> =
            (0..self.positions.len()).filter(|&v| !self.around[v].is_empty()).collect();
        let mut number = vec![u32::MAX; self.positions.len()];
        kept.iter().zip(0..).for_each(|(&v, new)| number[v] = new);
        let faces = self.faces.into_iter().filter(|&face| face != GONE);
        Compact {
            positions: kept.iter().map(|&v| self.positions[v]).collect(),
            anchors: kept.iter().map(|&v| self.anchors[v]).collect(),
            on_boundary: kept.iter().map(|&v| self.on_boundary[v]).collect(),
            locked: kept.iter().map(|&v| self.locked[v]).collect(),
            kept: self.kept,
            faces: faces.map(|face| face.map(|v| number[v as usize])).collect(),
        }
    }
}

/// The vertices and faces of a [`Patch`] without those that were removed.
pub(super) struct Compact {
    pub positions: Vec<Vector>,
    pub anchors: Vec<u32>,
    pub on_boundary: Vec<bool>,
    pub locked: Vec<bool>,
    pub kept: Kept,
    pub faces: Vec<[u32; 3]>,
}

/// A flip of an edge, which joins its opposite corners instead.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flip {
    pub old: [u32; 2],
    ends: [u32; 2],
    /// The faces after the flip.
    pub new: [[u32; 3]; 2],
}
