//! Finds and flips faces so that they agree, and so that closed surfaces bound a volume.

use std::cell::OnceCell;

use super::super::TriMesh;
use super::super::intersections::{Bounds, BoxTree};
use super::super::topology::{Adjacency, Edges};
use super::super::vector::{Vector, cross, dot, doubled_normal, norm, sub};
use super::rebuild::{Rebuild, corners_of};
use super::report::RepairStep;

/// Bound of rounding errors, relative to products of the lengths that they come from.
const ROUND: f64 = 16.0 * f64::EPSILON;

/// Flips faces so that the faces of each group, which is connected over edges of two faces, agree.
/// Closed groups bound a volume: they are counter-clockwise as seen from outside, or from inside
/// where they lie in an odd number of other closed groups. In open groups, as few faces as possible
/// are flipped. Returns `None` when there is nothing to flip.
pub(super) fn outward(mesh: &TriMesh) -> (Option<Rebuild>, RepairStep) {
    let edges = Edges::new(mesh);
    let groups = Groups::of(mesh, &edges);
    let mut flip = groups.flip.clone();
    for (g, turn) in groups.turns(mesh).into_iter().enumerate() {
        let faces = groups.members.row(g).iter().map(|&f| f as usize);
        match groups.conflicts[g] {
            // A group that is not orientable stays as it is.
            Some(_) => faces.for_each(|f| flip[f] = false),
            None => faces.for_each(|f| flip[f] ^= turn),
        }
    }
    let conflict = groups.conflicts.iter().flatten().next();
    let step = RepairStep::Oriented {
        faces: flip.iter().filter(|flip| **flip).count(),
        not_orientable: groups.conflicts.iter().flatten().count(),
        edge: conflict.and_then(|&e| edges.ends().get(e as usize).copied()),
    };
    (step.changed().then(|| flipped(mesh, &flip)), step)
}

/// Returns the lowest face of each closed group whose faces agree, and all of which [`outward`]
/// flips.
pub(in crate::mesh) fn inside_out(mesh: &TriMesh, edges: &Edges) -> Vec<u32> {
    let groups = Groups::of(mesh, edges);
    let agree = |faces: &[u32]| faces.iter().all(|&f| !groups.flip[f as usize]);
    let turned = groups.members.rows().zip(groups.turns(mesh));
    let inside_out = turned.filter(|(faces, turn)| *turn && agree(faces));
    inside_out.filter_map(|(faces, _)| faces.first().copied()).collect()
}

fn flipped(mesh: &TriMesh, flip: &[bool]) -> Rebuild {
    let turned = |[a, b, c]: [u32; 3], flip: bool| if flip { [a, c, b] } else { [a, b, c] };
    let faces = mesh.faces().iter().zip(flip).map(|(&face, &flip)| turned(face, flip)).collect();
    let corners = (0..).zip(flip).map(|(f, &flip)| turned(corners_of(f), flip)).collect();
    let vertices = (0..mesh.vertices().len() as u32).collect();
    Rebuild { vertices, faces, corners, insertions: Vec::new(), joined: None }
}

/// The groups of faces that are connected over edges of two faces.
struct Groups {
    /// The faces of each group, ascending.
    members: Adjacency,
    /// Whether each face must be flipped to agree with the lowest one of its group.
    flip: Vec<bool>,
    /// For each group that is not orientable, an edge whose faces disagree.
    conflicts: Vec<Option<u32>>,
    /// Whether all edges of each group have two faces.
    closed: Vec<bool>,
}

impl Groups {
    fn of(mesh: &TriMesh, edges: &Edges) -> Self {
        let sides = mesh.sides(edges);
        let mut closed = vec![true; sides.conflicts.len()];
        for row in edges.corners().rows().filter(|row| row.len() != 2) {
            row.iter()
                .for_each(|&corner| closed[sides.group[corner as usize / 3] as usize] = false);
        }
        let members = Adjacency::from_pairs(closed.len(), || sides.group.iter().copied().zip(0..));
        Self { members, flip: sides.flip, conflicts: sides.conflicts, closed }
    }

    /// Returns for each group whether all its faces must be flipped once they agree with the lowest
    /// one.
    fn turns(&self, mesh: &TriMesh) -> Vec<bool> {
        let is_flipped = |f: &&u32| self.flip[**f as usize];
        let most_flip = |faces: &[u32]| 2 * faces.iter().filter(is_flipped).count() > faces.len();
        let open = |g: usize| !self.closed[g] && self.conflicts[g].is_none();
        let rows = self.members.rows().enumerate();
        let mut turns: Vec<bool> = rows.map(|(g, faces)| open(g) && most_flip(faces)).collect();
        let shells = self.shells(mesh);
        let tree = BoxTree::new(shells.len(), |i| Some(shells[i].bounds));
        for (own, shell) in (0..).zip(&shells) {
            let mut depth = 0;
            let corner = Bounds { high: shell.bounds.low, ..shell.bounds };
            tree.visit(&corner, |i| {
                depth += u32::from(i != own && shells[i as usize].holds(mesh, shell));
            });
            let volume = volume(mesh, shell.faces, &self.flip);
            turns[shell.group] = (volume < 0.0) != (depth % 2 == 1 && volume != 0.0);
        }
        turns
    }

    /// Returns the closed groups that are orientable.
    fn shells(&self, mesh: &TriMesh) -> Vec<Shell<'_>> {
        let rows = self.members.rows().enumerate();
        rows.filter(|&(g, _)| self.closed[g] && self.conflicts[g].is_none())
            .filter_map(|(g, faces)| Shell::of(mesh, g, faces))
            .collect()
    }
}

/// Returns six times the volume inside of these faces, some of them flipped; 0 where it is within
/// rounding errors, as between two sheets in one place.
fn volume(mesh: &TriMesh, faces: &[u32], flip: &[bool]) -> f64 {
    let tip = faces.first().map_or([0.0; 3], |&f| points(mesh, f)[0]);
    let (mut sum, mut sizes) = (0.0, 0.0);
    for &f in faces {
        let [a, b, c] = points(mesh, f);
        let [away, u, v] = [sub(a, tip), sub(b, a), sub(c, a)];
        let cone = dot(away, cross(u, v));
        sum += if flip[f as usize] { -cone } else { cone };
        sizes += norm(away) * norm(u) * norm(v);
    }
    if sum.abs() > ROUND * sizes { sum } else { 0.0 }
}

fn points(mesh: &TriMesh, f: u32) -> [Vector; 3] {
    mesh.faces()[f as usize].map(|v| mesh.vertices()[v as usize])
}

/// A closed group of faces.
struct Shell<'a> {
    /// Its number.
    group: usize,
    faces: &'a [u32],
    bounds: Bounds,
    /// The boxes of the faces, once another shell may be inside.
    tree: OnceCell<BoxTree>,
}

impl<'a> Shell<'a> {
    /// Returns the shell; `None` without a face.
    fn of(mesh: &TriMesh, group: usize, faces: &'a [u32]) -> Option<Self> {
        let boxes = faces.iter().map(|&f| Bounds::of(&points(mesh, f)));
        let bounds = boxes.reduce(|all, one| all.join(&one))?;
        Some(Self { group, faces, bounds, tree: OnceCell::new() })
    }

    /// Returns whether another shell is inside: whether the ray from its first corner along x
    /// crosses an odd number of faces.
    fn holds(&self, mesh: &TriMesh, other: &Shell<'_>) -> bool {
        let (outer, inner) = (&self.bounds, &other.bounds);
        let inside = (0..3).all(|k| outer.low[k] <= inner.low[k] && inner.high[k] <= outer.high[k]);
        let Some(&first) = other.faces.first().filter(|_| inside) else { return false };
        let p = points(mesh, first)[0];
        let face = |i: u32| points(mesh, self.faces[i as usize]);
        let bounds = |i: usize| Some(Bounds::of(&face(i as u32)));
        let tree = self.tree.get_or_init(|| BoxTree::new(self.faces.len(), bounds));
        let mut is_odd = false;
        tree.visit(&self.line_through(p), |i| is_odd ^= crosses(face(i), p));
        is_odd
    }

    /// Returns the box of the line along x through a point inside of the bounds, which is as wide
    /// as the rounding errors of [`crosses`].
    fn line_through(&self, p: Vector) -> Bounds {
        let Bounds { low, high } = self.bounds;
        let width = ROUND * low[1].abs().max(high[1].abs());
        Bounds { low: [low[0], p[1] - width, p[2]], high: [high[0], p[1] + width, p[2]] }
    }
}

/// Returns whether the ray from p along x crosses a triangle. Edges are tested from their lower
/// end, so that both faces of an edge give the same result and no crossing is lost or counted
/// twice.
fn crosses(triangle: [Vector; 3], p: Vector) -> bool {
    let [a, b, c] = triangle;
    let mut odd = false;
    for [u, v] in [[a, b], [b, c], [c, a]] {
        let [u, v] = if (u[2], u[1]) < (v[2], v[1]) { [u, v] } else { [v, u] };
        if u[2] <= p[2] && p[2] < v[2] {
            let side = (v[1] - u[1]) * (p[2] - u[2]) - (p[1] - u[1]) * (v[2] - u[2]);
            odd ^= side > 0.0;
        }
    }
    if !odd {
        return false;
    }
    let normal = doubled_normal(triangle);
    // The position of the plane of the triangle at the y and z of p.
    let rest = normal[1] * (p[1] - a[1]) + normal[2] * (p[2] - a[2]);
    let x = a[0] - rest / normal[0];
    x > p[0]
}
