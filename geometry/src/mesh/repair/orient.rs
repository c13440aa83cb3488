//! Flips faces so that they agree, and so that closed surfaces bound a volume.

use super::super::TriMesh;
use super::super::topology::Edges;
use super::super::vector::{Vector, cross, dot, doubled_normal, sub};
use super::rebuild::{Rebuild, corners_of};
use super::report::RepairStep;

/// Flips faces so that the faces of each group, which is connected over edges of two faces, agree.
/// Closed groups bound a volume: they are counter-clockwise as seen from outside, or from inside
/// where they lie in an odd number of other closed groups. In open groups, as few faces as possible
/// are flipped. Returns `None` when there is nothing to flip.
pub(super) fn outward(mesh: &TriMesh) -> (Option<Rebuild>, RepairStep) {
    let edges = Edges::new(mesh);
    let mut sides = mesh.sides(&edges);
    let count = sides.conflicts.len();
    let mut closed = vec![true; count];
    for row in edges.corners().rows().filter(|row| row.len() != 2) {
        row.iter().for_each(|&corner| closed[sides.group[corner as usize / 3] as usize] = false);
    }
    let mut members = vec![Vec::new(); count];
    for (f, &group) in (0..).zip(&sides.group) {
        members[group as usize].push(f);
    }
    let shells: Vec<Shell> = (0..count)
        .filter(|&g| closed[g] && sides.conflicts[g].is_none())
        .map(|g| Shell::of(mesh, &members[g]))
        .collect();
    let mut shell = shells.iter().enumerate();
    for g in 0..count {
        let flipped = members[g].iter().filter(|&&f| sides.flip[f as usize]).count();
        let turn = if sides.conflicts[g].is_some() {
            // A group that is not orientable stays as it is.
            members[g].iter().for_each(|&f| sides.flip[f as usize] = false);
            false
        } else if closed[g] {
            shell.next().is_some_and(|(own, shell)| {
                let holders = shells.iter().enumerate().filter(|(i, _)| *i != own);
                let depth = holders.filter(|(_, other)| other.holds(mesh, shell)).count();
                let volume = volume(mesh, &members[g], &sides.flip);
                (volume < 0.0) != (depth % 2 == 1 && volume != 0.0)
            })
        } else {
            2 * flipped > members[g].len()
        };
        if turn {
            members[g].iter().for_each(|&f| sides.flip[f as usize] ^= true);
        }
    }
    let conflict = sides.conflicts.iter().flatten().next();
    let step = RepairStep::Oriented {
        faces: sides.flip.iter().filter(|flip| **flip).count(),
        not_orientable: sides.conflicts.iter().flatten().count(),
        edge: conflict.and_then(|&e| edges.ends().get(e as usize).copied()),
    };
    (step.changed().then(|| flipped(mesh, &sides.flip)), step)
}

fn flipped(mesh: &TriMesh, flip: &[bool]) -> Rebuild {
    let turned = |[a, b, c]: [u32; 3], flip: bool| if flip { [a, c, b] } else { [a, b, c] };
    let faces = mesh.faces().iter().zip(flip).map(|(&face, &flip)| turned(face, flip)).collect();
    let corners = (0..).zip(flip).map(|(f, &flip)| turned(corners_of(f), flip)).collect();
    let vertices = (0..mesh.vertices().len() as u32).collect();
    Rebuild { vertices, faces, corners, insertions: Vec::new(), joined: None }
}

/// Returns six times the volume inside of these faces, some of them flipped.
fn volume(mesh: &TriMesh, faces: &[u32], flip: &[bool]) -> f64 {
    let tip = faces.first().map_or([0.0; 3], |&f| points(mesh, f)[0]);
    let cone = |&f: &u32| {
        let [a, b, c] = points(mesh, f).map(|p| sub(p, tip));
        let signed = dot(a, cross(b, c));
        if flip[f as usize] { -signed } else { signed }
    };
    faces.iter().map(cone).sum()
}

fn points(mesh: &TriMesh, f: u32) -> [Vector; 3] {
    mesh.faces()[f as usize].map(|v| mesh.vertices()[v as usize])
}

/// A closed group of faces.
struct Shell<'a> {
    faces: &'a [u32],
    low: Vector,
    high: Vector,
}

impl<'a> Shell<'a> {
    fn of(mesh: &TriMesh, faces: &'a [u32]) -> Self {
        let start = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let [low, high] =
            faces.iter().flat_map(|&f| points(mesh, f)).fold(start, |[low, high], p| {
                let over = |k: usize| (low[k].min(p[k]), high[k].max(p[k]));
                [std::array::from_fn(|k| over(k).0), std::array::from_fn(|k| over(k).1)]
            });
        Self { faces, low, high }
    }

    /// Returns whether another shell is inside: whether the ray from its first corner along x
    /// crosses an odd number of faces.
    fn holds(&self, mesh: &TriMesh, other: &Shell<'_>) -> bool {
        let inside = (0..3).all(|k| self.low[k] <= other.low[k] && other.high[k] <= self.high[k]);
        let Some(&first) = other.faces.first().filter(|_| inside) else { return false };
        let p = points(mesh, first)[0];
        self.faces.iter().filter(|&&f| crosses(points(mesh, f), p)).count() % 2 == 1
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
