//! Removes faces without area so that the surface stays closed: a face with two corners in one
//! place by joining these corners, a face with a corner on the opposite edge by flipping this edge.

use std::collections::VecDeque;

use super::super::TriMesh;
use super::super::measure::is_flat;
use super::super::vector::{Vector, distance, dot, sub};
use super::rebuild::{Insertion, Rebuild, corners_of};
use super::report::RepairStep;
use catamaran::base::Result;

/// Two corners are in one place when their distance is at most this times the longest edge of their
/// face: then the face has no area, wherever the third corner is.
const ONE_PLACE: f64 = 16.0 * f64::EPSILON;

/// Returns the mesh without faces that have no area; `None` when there are none. Faces that can be
/// removed neither by joining nor by flipping are left out if `may_open`, and stay otherwise.
///
/// # Errors
/// [`TriMesh::check_size`], where there are such faces: lengths that overflow or vanish do not tell
/// which corners are in one place.
pub(super) fn without(mesh: &TriMesh, may_open: bool) -> Result<(Option<Rebuild>, RepairStep)> {
    let flat = mesh.faces_without_area();
    let first = flat.first().copied();
    if flat.is_empty() {
        let step = RepairStep::DroppedDegenerate { joined: 0, flipped: 0, faces: 0, first };
        return Ok((None, step));
    }
    mesh.check_size()?;
    let mut faces = Faces::of(mesh);
    let stuck = faces.remove(flat.into());
    if may_open {
        stuck.iter().for_each(|&f| faces.take_out(f));
        faces.dropped = stuck.len();
    }
    let Faces { faces, corners, insertions, mut to, joined, flipped, dropped, .. } = faces;
    for v in 0..to.len() {
        // Vertices join vertices of lower number, whose entries are final.
        to[v] = to[to[v] as usize];
    }
    let (faces, corners) =
        faces.into_iter().zip(corners).filter_map(|(f, c)| Some((f?, c))).unzip();
    let step = RepairStep::DroppedDegenerate { joined, flipped, faces: dropped, first };
    Ok((step.changed().then(|| Rebuild::joined(faces, corners, insertions, to)), step))
}

/// Faces under change.
struct Faces<'m> {
    points: &'m [Vector],
    /// `None` for a removed face.
    faces: Vec<Option<[u32; 3]>>,
    /// As [`Rebuild::corners`].
    corners: Vec<[u32; 3]>,
    insertions: Vec<Insertion>,
    of_vertex: Vec<Vec<u32>>,
    /// For each vertex the vertex that it joined.
    to: Vec<u32>,
    joined: usize,
    flipped: usize,
    dropped: usize,
}

impl<'m> Faces<'m> {
    fn of(mesh: &'m TriMesh) -> Self {
        let count = mesh.faces().len() as u32;
        Self {
            points: mesh.vertices(),
            faces: mesh.faces().iter().copied().map(Some).collect(),
            corners: (0..count).map(corners_of).collect(),
            insertions: Vec::new(),
            of_vertex: mesh.vertex_faces().rows().map(<[u32]>::to_vec).collect(),
            to: (0..mesh.vertices().len() as u32).collect(),
            joined: 0,
            flipped: 0,
            dropped: 0,
        }
    }

    /// Removes these faces, and those that lose their area thereby, and returns the faces that
    /// could not be removed. Terminates, because each step leaves fewer faces, or fewer without
    /// area, or shorter edges.
    fn remove(&mut self, mut open: VecDeque<u32>) -> VecDeque<u32> {
        let mut stuck = VecDeque::new();
        let mut changed = false;
        loop {
            while let Some(f) = open.pop_front() {
                let Some(face) = self.faces[f as usize].filter(|&face| self.is_flat(face)) else {
                    continue;
                };
                match self.join(face).or_else(|| self.flip(f, face)) {
                    Some(doubtful) => {
                        open.extend(doubtful);
                        changed = true;
                    }
                    None => stuck.push_back(f),
                }
            }
            if !std::mem::take(&mut changed) {
                return stuck;
            }
            // Other changes may have made these faces removable.
            std::mem::swap(&mut open, &mut stuck);
        }
    }

    fn points_of(&self, face: [u32; 3]) -> [Vector; 3] {
        face.map(|v| self.points[v as usize])
    }

    fn is_flat(&self, face: [u32; 3]) -> bool {
        is_flat(self.points_of(face))
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        distance(self.points[a as usize], self.points[b as usize])
    }

    fn take_out(&mut self, f: u32) {
        for v in self.faces[f as usize].take().into_iter().flatten() {
            self.of_vertex[v as usize].retain(|&other| other != f);
        }
    }

    fn put(&mut self, f: u32, face: [u32; 3], corners: [u32; 3]) {
        self.faces[f as usize] = Some(face);
        self.corners[f as usize] = corners;
        face.iter().for_each(|&v| self.of_vertex[v as usize].push(f));
    }

    /// Returns the faces of a vertex.
    fn around(&self, v: u32) -> impl Iterator<Item = (u32, [u32; 3])> + '_ {
        self.of_vertex[v as usize].iter().filter_map(|&f| Some((f, self.faces[f as usize]?)))
    }

    /// Returns the faces of an edge, ascending.
    fn at_edge(&self, a: u32, b: u32) -> Vec<u32> {
        let both = self.around(a).filter(|(_, face)| face.contains(&b));
        let mut found: Vec<u32> = both.map(|(f, _)| f).collect();
        found.sort_unstable();
        found
    }

    /// Returns the vertices that an edge joins to v, each as often as there are faces at the edge,
    /// ascending.
    fn neighbors(&self, v: u32) -> Vec<u32> {
        let mut found: Vec<u32> =
            self.around(v).flat_map(|(_, face)| face).filter(|&u| u != v).collect();
        found.sort_unstable();
        found
    }

    /// Joins the ends of the shortest edge of a face when they are in one place, and the topology
    /// of the surface does not change (the link condition: Dey, Edelsbrunner, Guha and Nekhayev,
    /// 1999). Returns the faces at the joined vertex.
    fn join(&mut self, face: [u32; 3]) -> Option<Vec<u32>> {
        let [a, b, c] = face;
        let edges = [[a, b], [b, c], [c, a]].map(|[u, v]| (self.length(u, v), u.min(v), u.max(v)));
        let longest = edges.iter().fold(0.0, |most: f64, edge| most.max(edge.0));
        let mut short: Vec<_> =
            edges.into_iter().filter(|edge| edge.0 <= ONE_PLACE * longest).collect();
        short.sort_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
        let &(_, keep, gone) = short.iter().find(|&&(_, u, v)| self.may_join(u, v))?;
        for f in self.at_edge(keep, gone) {
            self.take_out(f);
        }
        for f in std::mem::take(&mut self.of_vertex[gone as usize]) {
            if let Some(face) = &mut self.faces[f as usize] {
                *face = face.map(|v| if v == gone { keep } else { v });
                self.of_vertex[keep as usize].push(f);
            }
        }
        self.to[gone as usize] = keep;
        self.joined += 1;
        Some(self.of_vertex[keep as usize].clone())
    }

    fn may_join(&self, u: u32, v: u32) -> bool {
        let faces = self.at_edge(u, v);
        let apexes: Vec<u32> = faces
            .iter()
            .filter_map(|&f| self.faces[f as usize]?.into_iter().find(|w| *w != u && *w != v))
            .collect();
        let [of_u, of_v] = [u, v].map(|w| self.neighbors(w));
        let mut common: Vec<u32> =
            of_u.iter().copied().filter(|w| of_v.binary_search(w).is_ok()).collect();
        common.dedup();
        let on_boundary = |of: &[u32]| of.chunk_by(|a, b| a == b).any(|same| same.len() == 1);
        let opposite = |w: u32, without: u32| {
            let own = self.around(w).filter(move |(_, face)| !face.contains(&without));
            let mut own: Vec<[u32; 2]> = own
                .map(|(_, face)| {
                    let mut ends = [0; 2];
                    let others = face.into_iter().filter(|x| *x != w);
                    ends.iter_mut().zip(others).for_each(|(end, x)| *end = x);
                    [ends[0].min(ends[1]), ends[0].max(ends[1])]
                })
                .collect();
            own.sort_unstable();
            own
        };
        let (ours, theirs) = (opposite(u, v), opposite(v, u));
        let interior = faces.len() == 2;
        (1..=2).contains(&faces.len())
            && common.len() == apexes.len()
            && apexes.iter().all(|w| common.contains(w))
            && !(interior && on_boundary(&of_u) && on_boundary(&of_v))
            && !ours.iter().any(|edge| theirs.binary_search(edge).is_ok())
    }

    /// Flips the longest edge of a face, on which its third corner lies: the face on the other side
    /// is cut in two at that corner. Returns the two new faces.
    fn flip(&mut self, f: u32, face: [u32; 3]) -> Option<Vec<u32>> {
        let length = |i: usize| self.length(face[i], face[(i + 1) % 3]);
        let i = (0..3).max_by(|&i, &j| length(i).total_cmp(&length(j)).then(j.cmp(&i)))?;
        let [j, k] = [(i + 1) % 3, (i + 2) % 3];
        let [a, b, c] = [face[i], face[j], face[k]];
        let at_edge = self.at_edge(a, b);
        let &beyond = match at_edge.as_slice() {
            [s, t] if *s == f => t,
            [s, t] if *t == f => s,
            _ => return None,
        };
        let other = self.faces[beyond as usize]?;
        let y = other.iter().position(|&v| v != a && v != b)?;
        let d = other[y];
        // The other face runs along the edge from x to z.
        let [x, z] = [other[(y + 1) % 3], other[(y + 2) % 3]];
        if d == c || !self.at_edge(c, d).is_empty() {
            return None;
        }
        let new = [[x, c, d], [c, z, d]];
        let flat = |faces: [[u32; 3]; 2]| faces.iter().filter(|&&f| self.is_flat(f)).count();
        let (before, after) = (flat([face, other]), flat(new));
        if after > before || (after == before && self.length(c, d) >= self.length(a, b)) {
            return None;
        }
        let ours = self.corners[f as usize];
        let theirs = self.corners[beyond as usize];
        let own = |v: u32| if v == a { ours[i] } else { ours[j] };
        let on = [theirs[(y + 1) % 3], theirs[(y + 2) % 3]];
        let insertion = Insertion { from: [own(x), own(z), ours[k]], on, at: self.along(x, z, c) };
        // Old corners come first; the last number means that there is no corner.
        let number = u32::try_from(3 * self.faces.len() + self.insertions.len()).ok();
        let middle = number.filter(|&number| number < u32::MAX)?;
        self.insertions.push(insertion);
        self.take_out(f);
        self.take_out(beyond);
        let apex = theirs[y];
        self.put(f, new[0], [on[0], middle, apex]);
        self.put(beyond, new[1], [middle, on[1], apex]);
        self.flipped += 1;
        Some(vec![f, beyond])
    }

    /// Returns the position of vertex c on the way from x (0) to z (1).
    fn along(&self, x: u32, z: u32, c: u32) -> f64 {
        let [p, q, r] = self.points_of([x, z, c]);
        let edge = sub(q, p);
        let t = dot(sub(r, p), edge) / dot(edge, edge);
        if t.is_nan() { 0.5 } else { t.clamp(0.0, 1.0) }
    }
}
