//! Resolves intersections of faces, which the dual triangulation of very thin sheets may leave.

use super::closest::nearest;
use super::guard::{untangles_flip, untangles_move};
use super::patch::Patch;
use super::surface::Surface;
use crate::mesh::intersections::intersect;
use crate::mesh::vector::Vector;
use crate::mesh::{TriMesh, quality};
use catamaran::base::{Par, Result, spend};

/// Largest number of searches for all pairs.
const ROUNDS: usize = 4;

/// Operations that finding the faces which a face meets is equal to.
const MET: f64 = 500.0;

/// Least regularity of faces (see [`quality`]) after a change, unless they were less regular
/// before.
const REGULAR: f64 = 0.1;

/// Moves vertices and flips edges of intersecting faces as long as that reduces their number; does
/// nothing unless there are more than in `input`.
pub(super) fn resolve(
    surface: &Surface<'_>,
    input: &TriMesh,
    patch: &mut Patch,
    par: Par,
) -> Result<()> {
    let mut allowed = None;
    for _ in 0..ROUNDS {
        spend(MET * patch.faces.len() as f64)?;
        patch.plant_tree();
        let meet = |f, g| intersect(&patch.corners_of(f), &patch.corners_of(g));
        let pairs = patch.tree().pairs(par, meet);
        let mut faces = pairs.concat();
        faces.sort_unstable();
        faces.dedup();
        if faces.is_empty() {
            break;
        }
        let allowed = *allowed.get_or_insert_with(|| input.intersecting_faces(par).len());
        if faces.len() <= allowed {
            break;
        }
        let changes = faces.into_iter().filter(|&f| untangle(surface, patch, f)).count();
        if changes == 0 {
            break;
        }
    }
    Ok(())
}

/// Changes the mesh at this face; returns whether that helped.
fn untangle(surface: &Surface<'_>, patch: &mut Patch, f: u32) -> bool {
    let Some(face) = patch.face(f as usize) else { return false };
    for v in face {
        if patch.locked[v as usize] {
            continue;
        }
        for target in targets(patch, v) {
            let anchor = patch.anchors[v as usize];
            let is_on_boundary = patch.on_boundary[v as usize];
            let Some(found) = nearest(surface, anchor, is_on_boundary, target) else { continue };
            let is_regular = stays_regular(patch, v, found.point, REGULAR);
            if is_regular && untangles_move(patch, v, found.point) {
                patch.move_to(v, (found.point, found.vertex));
                return true;
            }
        }
    }
    let [a, b, c] = face;
    for [a, b] in [[a, b], [b, c], [c, a]] {
        let Some(flip) = patch.flipped(a, b) else { continue };
        if untangles_flip(patch, &flip) {
            patch.flip(&flip);
            return true;
        }
    }
    false
}

/// Returns the positions to try for v: back to the surface, and towards the middle of its
/// neighbours.
fn targets(patch: &Patch, v: u32) -> [Vector; 3] {
    let here = patch.position(v);
    let neighbours = patch.neighbours(v);
    let share = 1.0 / neighbours.len().max(1) as f64;
    let mut middle = [0.0; 3];
    for w in neighbours {
        let p = patch.position(w);
        (0..3).for_each(|k| middle[k] += share * p[k]);
    }
    [0.0, 0.5, 1.0].map(|part| std::array::from_fn(|k| here[k] + part * (middle[k] - here[k])))
}

/// Returns whether no face around v becomes less regular than `regular` by a move of v to p, unless
/// it is so before.
pub(super) fn stays_regular(patch: &Patch, v: u32, p: Vector, regular: f64) -> bool {
    patch.around(v).iter().map(|&f| patch.faces[f as usize]).all(|face| {
        let least = quality(patch.corners_at(face)).min(regular);
        quality(patch.corners_with(face, [v, v], p)) >= least
    })
}
