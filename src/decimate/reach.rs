//! Thin parts of the surface that the new mesh misses, since it reaches no farther than its
//! vertices do.

use std::collections::HashSet;
use std::hash::BuildHasherDefault;

use super::batches::Multiply;
use super::collapse::reduce;
use super::guard::allows_move;
use super::loss::gap_of_move;
use super::patch::Patch;
use super::surface::Surface;
use crate::base::Par;
use crate::mesh::vector::{Vector, distance, norm};

/// Vertices that one thread looks at at a time.
const BLOCK: usize = 512;

/// What is farther than this part of the mean edge from the faces around the nearest vertex is missed.
const MISSED: f64 = 0.4;

/// How far from a vertex is looked for what is missed, in mean edges.
const NEAR: f64 = 1.0;

/// A vertex does not move where it would have edges longer than this part of the mean.
const LONGEST: f64 = 1.5;

/// The sum of normals is above this part of the sum of areas where faces look so much the same way that they miss nothing.
const FLAT: f64 = 0.9;

/// Moves vertices to what is missed, so that thin parts that were cut short are reached again. Where that would miss what the
/// vertex reaches now, an edge is split instead, and a short one elsewhere collapsed.
pub(super) fn reach_out(surface: &Surface<'_>, patch: &mut Patch, par: Par) {
    let mean = patch.mean_length();
    let least = MISSED * mean;
    let missed = par.map_blocks(patch.positions().len(), BLOCK, |range| {
        range.map(|v| farthest_missed(surface, patch, v as u32, mean)).collect::<Vec<_>>()
    });
    let n = patch.count;
    for (v, found) in (0..).zip(missed.into_iter().flatten()) {
        let Some(w) = found else { continue };
        let (here, p) = (patch.position(v), surface.position(w));
        if norm(gap_of_move(patch, v, here, p)) <= least {
            continue; // reached by now
        }
        let away = |u: u32| distance(patch.position(u), p);
        let neighbours = patch.neighbours(v);
        let stays = norm(gap_of_move(patch, v, p, here)) <= 0.5 * least;
        if stays
            && patch.stays_upright(v, None, p)
            && neighbours.iter().all(|&u| away(u) <= LONGEST * mean)
            && allows_move(patch, v, p)
        {
            patch.place(v, p);
            patch.anchors[v as usize] = w;
            continue;
        }
        let nearest = neighbours.iter().copied().min_by(|&a, &b| away(a).total_cmp(&away(b)));
        let Some(new) = nearest.and_then(|u| patch.split(v, u)) else { continue };
        if patch.stays_upright(new, None, p) && allows_move(patch, new, p) {
            patch.place(new, p);
            patch.anchors[new as usize] = w;
        }
    }
    reduce(patch, n);
}

/// Of the vertices of the input that are missed around v, connected to its anchor and nearer to it than to its neighbours, the
/// farthest from its faces, then the lowest.
fn farthest_missed(surface: &Surface<'_>, patch: &Patch, v: u32, mean: f64) -> Option<u32> {
    let interior = !patch.on_boundary[v as usize] && !patch.around(v).is_empty();
    if !interior || is_flat(patch, v) {
        return None;
    }
    let here = patch.position(v);
    let neighbours: Vec<Vector> =
        patch.neighbours(v).into_iter().map(|w| patch.position(w)).collect();
    let anchor = patch.anchors[v as usize];
    let mut seen: HashSet<u32, BuildHasherDefault<Multiply>> = HashSet::from_iter([anchor]);
    let mut open = vec![anchor];
    let mut farthest = (MISSED * mean, None);
    while let Some(w) = open.pop() {
        let q = surface.position(w);
        let own = distance(q, here);
        if own > NEAR * mean || neighbours.iter().any(|&p| distance(p, q) < own) {
            continue;
        }
        let missed = norm(gap_of_move(patch, v, here, q));
        if missed > farthest.0 || (missed == farthest.0 && farthest.1.is_some_and(|u| w < u)) {
            farthest = (missed, Some(w));
        }
        open.extend(surface.links(w).iter().map(|link| link.to).filter(|&to| seen.insert(to)));
    }
    farthest.1
}

fn is_flat(patch: &Patch, v: u32) -> bool {
    let mut sum = [0.0; 3];
    let mut areas = 0.0;
    for &f in patch.around(v) {
        let normal = patch.normal(patch.faces[f as usize]);
        areas += norm(normal);
        (0..3).for_each(|k| sum[k] += normal[k]);
    }
    norm(sum) >= FLAT * areas
}
