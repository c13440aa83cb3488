//! Collapses short edges: to reach the requested number of vertices, and in exchange for splits of
//! long edges.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::guard::allows_collapse;
use super::loss::loss_of_collapse;
use super::patch::Patch;
use crate::mesh::vector::Vector;
use catamaran::base::{Result, spend};

/// Largest stretched distance of the ends of a collapsed edge from the new faces, relative to the
/// mean stretched length.
const LOSS: f64 = 0.15;

/// Operations that deciding about a collapse is equal to.
const TRIED: f64 = 2000.0;

/// Collapses the shortest edges that can collapse, until `n` vertices are left, and returns the
/// number left. Collapses first without turning faces over or losing thin parts, then without
/// making faces intersect, then, if that is not enough, in any case.
pub(super) fn reduce(patch: &mut Patch, n: usize) -> Result<usize> {
    if patch.count <= n {
        return Ok(patch.count);
    }
    let loss = LOSS * patch.mean_length();
    for care in [Care::Shape(loss), Care::Intersections, Care::Topology] {
        let mut waiting: BinaryHeap<Reverse<(u64, [u32; 2])>> =
            patch.edges().into_iter().map(|[a, b]| Reverse((key(patch, a, b), [a, b]))).collect();
        while patch.count > n {
            let Some(Reverse((was, [a, b]))) = waiting.pop() else { break };
            spend(TRIED)?;
            if patch.sides(a, b).is_none() || was != key(patch, a, b) {
                continue; // the edge is gone, or has moved and is in the heap again
            }
            if let Some(left) = collapse(patch, a, b, care) {
                // The lengths of edges nearby have changed, and edges that could not collapse
                // before may now.
                let mut near = patch.neighbours(left);
                near.push(left);
                for &v in &near {
                    for w in patch.neighbours(v) {
                        waiting.push(Reverse((key(patch, v, w), [v.min(w), v.max(w)])));
                    }
                }
            }
        }
    }
    Ok(patch.count)
}

/// The restrictions of a collapse, besides the topology, which never changes.
#[derive(Debug, Clone, Copy)]
enum Care {
    /// No face turns over, neither end is farther than this, stretched, from the new faces, and no
    /// new intersections of faces arise.
    Shape(f64),
    /// No new intersections of faces arise.
    Intersections,
    Topology,
}

/// Returns a key in the order of stretched lengths, which are not negative, so that their bits have
/// the order of the numbers.
fn key(patch: &Patch, a: u32, b: u32) -> u64 {
    patch.stretched(a, b).to_bits()
}

/// Collapses the edge, if possible, into its middle, otherwise into an end, or into its end on the
/// boundary or its locked end. Returns the vertex that is left.
fn collapse(patch: &mut Patch, a: u32, b: u32, care: Care) -> Option<u32> {
    if !patch.can_collapse(a, b) {
        return None;
    }
    // The second vertex is left: the locked one.
    let [a, b] = if patch.locked[a as usize] { [b, a] } else { [a, b] };
    let [p, q] = [a, b].map(|v| patch.position(v));
    let middle = patch.middle(a, b);
    let places: &[_] = match [a, b].map(|v| patch.on_boundary[v as usize]) {
        [true, false] => &[p],
        [false, true] => &[q],
        _ if patch.locked[b as usize] => &[q],
        _ => &[middle, p, q],
    };
    let allowed = |at: Vector| match care {
        Care::Shape(loss) => {
            patch.stays_upright(a, Some(b), at)
                && patch.stays_upright(b, Some(a), at)
                && loss_of_collapse(patch, a, b, at) * patch.stretch_of([a, b]) <= loss
                && allows_collapse(patch, a, b, at)
        }
        Care::Intersections => allows_collapse(patch, a, b, at),
        Care::Topology => true,
    };
    let at = places.iter().copied().find(|&at| allowed(at))?;
    patch.collapse(a, b, at);
    Some(b)
}

/// Thresholds of short and of long edges, relative to the mean stretched length. In measurements,
/// exchanges do not come to rest with thresholds nearer to 1.
const SHORT: f64 = 0.78;
const LONG: f64 = 1.3;

/// Collapses short edges and splits as many long ones: vertices move from dense to sparse regions.
pub(super) fn exchange(patch: &mut Patch) -> Result<()> {
    let edges: Vec<(f64, [u32; 2])> =
        patch.edges().into_iter().map(|[a, b]| (patch.stretched(a, b), [a, b])).collect();
    let mean = edges.iter().map(|edge| edge.0).sum::<f64>() / edges.len().max(1) as f64;
    let sorted = |wanted: fn(f64) -> bool| {
        let mut some: Vec<_> = edges.iter().copied().filter(|edge| wanted(edge.0 / mean)).collect();
        some.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        some
    };
    let (short, long) = (sorted(|part| part < SHORT), sorted(|part| part > LONG));
    let mut pairs = long.iter().rev();
    // Only edges that no earlier exchange has touched.
    let untouched = |patch: &Patch, &(was, [a, b]): &(f64, [u32; 2])| {
        patch.sides(a, b).is_some() && patch.stretched(a, b) == was
    };
    for edge in &short {
        spend(TRIED)?;
        let [a, b] = edge.1;
        if !untouched(patch, edge) || !patch.can_collapse(a, b) {
            continue;
        }
        let may_split = |edge: &&(f64, [u32; 2])| {
            untouched(patch, edge) && !patch.is_kept(edge.1[0], edge.1[1])
        };
        let Some(&(_, [c, d])) = pairs.find(may_split) else { break };
        if [c, d].iter().any(|v| *v == a || *v == b) {
            continue;
        }
        if collapse(patch, a, b, Care::Shape(LOSS * mean)).is_some() && patch.sides(c, d).is_some()
        {
            patch.split(c, d);
        }
    }
    Ok(())
}
