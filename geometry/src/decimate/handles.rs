//! Cuts handles that are too narrow for the triangles of the result.

use std::collections::{HashMap, VecDeque};

use super::collapse::reduce;
use super::patch::Patch;
use catamaran::base::{Result, spend};

/// Handles with a loop of three edges shorter than this number of edges of the result are cut,
/// because triangles around them would be smaller than the others.
const NARROW: f64 = 2.0;

/// Operations that looking for a loop at an edge is equal to.
const TRIED: f64 = 200.0;

/// Cuts narrow handles where a loop of three edges goes around them, closes both ends with a face,
/// and collapses edges to restore the number of vertices, as far as possible. `length` is the
/// stretched length of an edge of the result.
pub(super) fn cut_narrow_handles(patch: &mut Patch, length: f64) -> Result<()> {
    let n = patch.count;
    loop {
        let mut cut = false;
        for [a, b] in patch.edges() {
            spend(TRIED)?;
            if patch.stretched(a, b) > NARROW * length / 2.0 {
                continue; // no loop of that length has a longer edge
            }
            while let Some(c) = narrow_loop(patch, a, b, NARROW * length) {
                let Some(ends) = sides(patch, [a, b, c]) else { break };
                if separates(patch, [a, b, c], &ends) {
                    break;
                }
                patch.pinch([a, b, c], &ends);
                cut = true;
            }
        }
        if !cut {
            return Ok(());
        }
        reduce(patch, n)?;
    }
}

/// Returns a vertex that may complete the edge from a to b to a loop around a handle.
fn narrow_loop(patch: &Patch, a: u32, b: u32, longest: f64) -> Option<u32> {
    let sides = patch.sides(a, b)?;
    let second = sides.second?;
    let filled = [sides.first, second].map(|f| patch.opposite(f, a, b));
    let of_b = patch.neighbours(b);
    let candidates = patch.neighbours(a).into_iter().filter(|c| {
        let loop_length = patch.stretched(a, b) + patch.stretched(b, *c) + patch.stretched(*c, a);
        of_b.contains(c) && !filled.contains(c) && loop_length < longest
    });
    let inside = |&c: &u32| {
        [a, b, c].iter().all(|&v| {
            let v = v as usize;
            !patch.on_boundary[v] && !patch.locked[v]
        })
    };
    candidates.into_iter().find(inside)
}

/// Returns for each vertex of the loop its faces on one side; `None` when the loop is one-sided.
fn sides(patch: &Patch, corners: [u32; 3]) -> Option<[Vec<u32>; 3]> {
    let [a, b, c] = corners;
    let first = patch.sides(a, b)?.first;
    let (of_a, at_c) = fan(patch, a, first, b, c)?;
    let (of_c, at_b) = fan(patch, c, at_c, a, b)?;
    let (of_b, back) = fan(patch, b, at_b, c, a)?;
    (back == first).then_some([of_a, of_b, of_c])
}

/// Returns the faces around v from `first`, which has the edge from v to `from`, away from that
/// edge, to the one that has the edge from v to `to`.
fn fan(patch: &Patch, v: u32, first: u32, from: u32, to: u32) -> Option<(Vec<u32>, u32)> {
    let mut faces = vec![first];
    let mut face = first;
    let mut edge = patch.opposite(first, v, from);
    while edge != to {
        let sides = patch.sides(v, edge)?;
        let next = if sides.first == face { sides.second? } else { sides.first };
        if faces.contains(&next) {
            return None;
        }
        faces.push(next);
        edge = patch.opposite(next, v, edge);
        face = next;
    }
    Some((faces, face))
}

/// Returns whether no path over faces leads from one side of the loop to the other. The search
/// alternates between both sides, so that it ends soon where the smaller side is small.
fn separates(patch: &Patch, corners: [u32; 3], ends: &[Vec<u32>; 3]) -> bool {
    let on_loop = |u: u32, v: u32| corners.contains(&u) && corners.contains(&v);
    let here = ends[0][0];
    let [a, b, _] = corners;
    let across = patch
        .sides(a, b)
        .and_then(|sides| if sides.first == here { sides.second } else { Some(sides.first) });
    let Some(across) = across else { return true };
    let mut sides = HashMap::from([(here, 0), (across, 1)]);
    let mut open = [VecDeque::from([here]), VecDeque::from([across])];
    loop {
        for side in 0..2 {
            let Some(face) = open[side].pop_front() else { return true };
            let [x, y, z] = patch.faces[face as usize];
            for (u, v) in [(x, y), (y, z), (z, x)] {
                let Some(found) = patch.sides(u, v).filter(|_| !on_loop(u, v)) else { continue };
                for next in [Some(found.first), found.second].into_iter().flatten() {
                    match sides.insert(next, side) {
                        None => open[side].push_back(next),
                        Some(before) if before != side => return false,
                        Some(_) => {}
                    }
                }
            }
        }
    }
}
