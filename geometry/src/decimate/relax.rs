//! Relaxation passes over the new mesh, which make its triangles similar.

use super::closest::{Found, on_boundary, on_surface};
use super::collapse::exchange;
use super::fit::fit;
use super::guard::{allows_flip, move_all};
use super::handles::cut_narrow_handles;
use super::loss::{gap_of_move, loss_of_flip};
use super::patch::Patch;
use super::quadric::Quadrics;
use super::resolve::stays_regular;
use super::surface::Surface;
use crate::mesh::vector::{Vector, cross, dot, norm, scale, sub, unit};
use catamaran::base::{Par, Progress, Result, spend};

/// Number of vertices that one thread moves at a time.
const BLOCK: usize = 512;

/// Largest number of sweeps of flips over all edges: on a surface in space, flips need not end.
const SWEEPS: usize = 4;

/// Runs passes over the mesh: edges flipped towards six at each vertex, in the last passes to be
/// Delaunay; short edges exchanged for long ones, except in the last passes; vertices moved to the
/// centroids of their faces and back onto the surface, or to its creases and tips; at the end they
/// are raised off it by half its height above the faces. Handles that are too narrow for edges of
/// length `narrow` are cut. With `uniform`, areas are made even before the end.
pub(super) fn relax(
    surface: &Surface<'_>,
    quadrics: &Quadrics<'_, '_>,
    patch: &mut Patch,
    passes: usize,
    narrow: f64,
    uniform: bool,
    par: Par,
    progress: Progress<'_>,
) -> Result<()> {
    // The last fifth of the passes has no exchanges, so that the mesh settles.
    let lively = 4 * passes / 5;
    for pass in 0..passes {
        progress.report(pass as f64 / passes as f64)?;
        if pass < lively {
            if narrow > 0.0 && pass % 3 == 1 {
                cut_narrow_handles(patch, narrow)?;
            }
            if pass > 0 {
                exchange(patch)?;
            }
            make_regular(patch)?;
        } else {
            make_delaunay(patch)?;
        }
        let flat = if pass < lively { FLAT_AT_FIRST } else { FLAT };
        move_vertices(surface, quadrics, patch, (Aim::Regular, flat), par)?;
    }
    if passes > 0 {
        make_delaunay(patch)?;
        let even = if uniform { EVEN_PASSES } else { 0 };
        for _ in 0..even {
            move_vertices(surface, quadrics, patch, (Aim::Even, FLAT), par)?;
        }
        fit(surface, patch, par)?;
    }
    Ok(())
}

/// Where vertices move.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Aim {
    /// To the centroid of their faces, which makes triangles equilateral.
    Regular,
    /// Towards the largest of their faces, which makes areas equal.
    Even,
}

/// Number of passes that make areas equal, the power of the areas by which the centroids of faces
/// have weights in these passes, and the part of the way to their mean that a vertex moves. On a
/// torus and on terrains, the variation of areas falls from .13 to .065 with them, to .10 with the
/// power 2, and mean quality from .91 to .89; with larger steps, passes do not come to rest.
const EVEN_PASSES: usize = 20;
const EVEN_POWER: i32 = 8;
const EVEN_STEP: f64 = 1.5 / EVEN_POWER as f64;

/// Regularity of faces (see [`quality`](crate::mesh::quality)) below which these passes bring none.
const EVEN_LEAST: f64 = 0.4;

/// Operations that deciding about a flip is equal to.
const TRIED: f64 = 500.0;

/// Operations that finding the new position of a vertex is equal to.
const MOVED: f64 = 5000.0;

/// Flips edges whose opposite angles have a sum above pi.
fn make_delaunay(patch: &mut Patch) -> Result<()> {
    let mut edges = patch.edges();
    for _ in 0..SWEEPS {
        let mut changed = Vec::new();
        for &[a, b] in &edges {
            spend(TRIED)?;
            let Some(flip) = patch.flipped(a, b) else { continue };
            let [c, d, _] = flip.new[0];
            if cotangent(patch, a, b, c) + cotangent(patch, a, b, d) >= -1e-9 {
                continue;
            }
            if folds(patch, a, b, &flip.new) || !allows_flip(patch, &flip) {
                continue;
            }
            patch.flip(&flip);
            for v in [a, b] {
                for w in [c, d] {
                    changed.push([v.min(w), v.max(w)]);
                }
            }
        }
        if changed.is_empty() {
            break;
        }
        edges = changed;
    }
    Ok(())
}

/// Flips edges where that brings the numbers of edges at the four vertices nearer to 6, or 4 on the
/// boundary (Botsch and Kobbelt, A Remeshing Approach to Multiresolution Modeling, 2004), unless
/// the sum of the opposite angles is far below pi.
fn make_regular(patch: &mut Patch) -> Result<()> {
    for [a, b] in patch.edges() {
        spend(TRIED)?;
        let Some(flip) = patch.flipped(a, b) else { continue };
        let [c, d, _] = flip.new[0];
        if cotangent(patch, a, b, c) + cotangent(patch, a, b, d) > FAR_FROM_DELAUNAY {
            continue;
        }
        // The number of faces at a vertex is that of its edges, or one less on the boundary.
        let excess = |v: u32, change: i32| {
            let wanted = if patch.on_boundary[v as usize] { 3 } else { 6 };
            (patch.around(v).len() as i32 + change - wanted).pow(2)
        };
        let before = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0);
        let after = excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1);
        if after < before && !folds(patch, a, b, &flip.new) && allows_flip(patch, &flip) {
            patch.flip(&flip);
        }
    }
    Ok(())
}

/// Sum of the cotangents of the angles opposite to an edge above which a flip would make slivers.
const FAR_FROM_DELAUNAY: f64 = 2.0;

/// Returns the cotangent of the angle at v opposite to the edge from a to b.
fn cotangent(patch: &Patch, a: u32, b: u32, v: u32) -> f64 {
    let [a, b, v] = [a, b, v].map(|v| patch.position(v));
    let (p, q) = (sub(a, v), sub(b, v));
    dot(p, q) / norm(cross(p, q)).max(f64::MIN_POSITIVE)
}

/// Largest distance of a flipped edge from the old one, relative to its length.
const FLIP_LOSS: f64 = 0.25;

/// Returns whether the new faces have another direction than the old ones, bend more, or miss the
/// old edge.
fn folds(patch: &Patch, a: u32, b: u32, new: &[[u32; 3]; 2]) -> bool {
    let Some(sides) = patch.sides(a, b) else { return true };
    let Some(second) = sides.second else { return true };
    let [c, d, _] = new[0];
    if loss_of_flip(patch, [a, b], [c, d]) > FLIP_LOSS * patch.length(a, b) {
        return true;
    }
    let old = [sides.first, second].map(|f| unit(patch.normal(patch.faces[f as usize])));
    let new = new.map(|face| unit(patch.normal(face)));
    let bend = dot(old[0], old[1]);
    let mean: Vector = std::array::from_fn(|k| old[0][k] + old[1][k]);
    new.iter().any(|&normal| dot(normal, mean) <= 0.0) || dot(new[0], new[1]) < bend.min(0.5)
}

fn move_vertices(
    surface: &Surface<'_>,
    quadrics: &Quadrics<'_, '_>,
    patch: &mut Patch,
    (aim, flat): (Aim, f64),
    par: Par,
) -> Result<()> {
    let vertices = patch.positions().len();
    let operations = MOVED * BLOCK as f64;
    let moves = par.map_blocks_asking(vertices, BLOCK, operations, |range| {
        let found = range.map(|v| {
            let v = v as u32;
            let found = target(surface, quadrics, patch, (aim, flat), v)?;
            let is_regular = |p| stays_regular(patch, v, p, EVEN_LEAST);
            (aim == Aim::Regular || is_regular(found.point)).then_some(found)
        });
        found.map(|found| found.map(|found| (found.point, found.vertex))).collect::<Vec<_>>()
    })?;
    move_all(patch, &moves.concat(), par);
    Ok(())
}

/// Returns the new position of a vertex; `None` if it stays. Where the sum of normals is below the
/// share `flat` of the sum of areas, the planes of the surface are searched for a crease.
fn target(
    surface: &Surface<'_>,
    quadrics: &Quadrics<'_, '_>,
    patch: &Patch,
    (aim, flat): (Aim, f64),
    v: u32,
) -> Option<Found> {
    let here = patch.position(v);
    let anchor = patch.anchors[v as usize];
    if patch.around(v).is_empty() || patch.locked[v as usize] {
        return None;
    }
    if patch.on_boundary[v as usize] {
        let along = boundary_target(patch, v, here)?;
        let target = if aim == Aim::Even { even_target(patch, v, here) } else { along };
        return on_boundary(surface, anchor, target);
    }
    let mut sum = [0.0; 3];
    let mut normals = [0.0; 3];
    let (mut weight, mut shares) = (0.0, 0.0);
    for &f in patch.around(v) {
        let face = patch.faces[f as usize];
        let [a, b, c] = face.map(|v| patch.position(v));
        let doubled = patch.normal(face);
        let area = norm(doubled);
        let share = area * patch.stretch_of(face).powi(BALANCE);
        for k in 0..3 {
            sum[k] += share * (a[k] + b[k] + c[k]) / 3.0;
            normals[k] += doubled[k];
        }
        weight += area;
        shares += share;
    }
    if weight <= 0.0 {
        return on_surface(surface, anchor, here);
    }
    let normal = unit(normals);
    let step = match aim {
        Aim::Regular => sub(scale(sum, 1.0 / shares), here),
        Aim::Even => sub(even_target(patch, v, here), here),
    };
    let out = dot(step, normal);
    let p = std::array::from_fn(|k| here[k] + step[k] - out * normal[k]);
    let bent = norm(normals);
    if bent >= FLAT * weight {
        return on_surface(surface, anchor, p);
    }
    // Six equilateral triangles of side l have the area 3 sqrt(3) l^2 / 2, and `weight` is twice
    // that.
    let length = (weight / 27f64.sqrt()).sqrt();
    let is_sharp = bent < flat * weight;
    let p = if is_sharp { quadrics.sharpest(patch, v, p, length) } else { p };
    let found = on_surface(surface, anchor, p)?;
    let lost = norm(gap_of_move(patch, v, found.point, here));
    (lost <= MOVE_LOSS * length).then_some(found)
}

/// Returns a point on the way from v to the mean of the centroids of its faces, in which large
/// faces have by far the largest weights.
fn even_target(patch: &Patch, v: u32, here: Vector) -> Vector {
    let faces = patch.around(v).iter().map(|&f| patch.faces[f as usize]);
    let stretched = |face| norm(patch.normal(face)) * patch.stretch_of(face).powi(2);
    let areas: Vec<f64> = faces.clone().map(stretched).collect();
    let largest = areas.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut sum = [0.0; 3];
    let mut weight = 0.0;
    for (face, area) in faces.zip(areas) {
        let [a, b, c] = patch.corners_at(face);
        let share = (area / largest).powi(EVEN_POWER);
        (0..3).for_each(|k| sum[k] += share * (a[k] + b[k] + c[k]) / 3.0);
        weight += share;
    }
    if weight <= 0.0 {
        return here;
    }
    std::array::from_fn(|k| here[k] + EVEN_STEP * (sum[k] / weight - here[k]))
}

/// Power of the stretch by which faces have weights besides their areas: where triangles on both
/// sides of a vertex differ in size only, area times distance grows with the cube of the size.
const BALANCE: i32 = 3;

/// Ratio of the sum of normals to the sum of areas below which moving a vertex may lose detail.
const FLAT: f64 = 0.95;

/// The same ratio in the passes before the mesh settles, below which a vertex moves to a crease: at
/// a slight crease it finds its place in the last passes.
const FLAT_AT_FIRST: f64 = 0.8;

/// Largest distance of the faces from the old position of a moved vertex, relative to the length of
/// its edges.
const MOVE_LOSS: f64 = 0.2;

/// Cosine of the turn of the boundary (60 degrees) above which a vertex is a corner, which stays.
const CORNER: f64 = 0.5;

/// Returns the target between the neighbours along the boundary.
fn boundary_target(patch: &Patch, v: u32, here: Vector) -> Option<Vector> {
    let mut ends = patch
        .neighbours(v)
        .into_iter()
        .filter(|&w| patch.sides(v, w).is_some_and(|sides| sides.second.is_none()));
    let ends = [ends.next()?, ends.next()?];
    let [a, b] = ends.map(|w| patch.position(w));
    if dot(unit(sub(here, a)), unit(sub(b, here))) < CORNER {
        return None;
    }
    let [s, t] = ends.map(|w| patch.stretch_of([v, w]));
    let [s, t] = [s, t].map(|x| 0.5 * x / (s + t));
    Some(std::array::from_fn(|k| 0.5 * here[k] + (s * a[k] + t * b[k])))
}
