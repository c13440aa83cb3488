//! Pinned segments at the end of free paths: the end of such a path must stay where it was at rest.

use faer::Mat;
use faer::linalg::solvers::Solve;

use super::Rods;
use catamaran::base::Result;
use catamaran::dense;
use catamaran_geometry::mesh::vector::{Vector, norm, sub};

/// A free path with a fixed end: the free segments from the one that ends at the pin back to a
/// fixed one.
#[derive(Debug, Clone)]
pub(super) struct Pin {
    /// The segment that ends at the pin.
    pub last: usize,
    /// The required position of the end.
    target: Vector,
    /// The free segments of the path.
    pub path: Vec<usize>,
}

impl Pin {
    /// Returns the vector from the required to the actual position of the end.
    pub fn gap(&self, tails: &[Vector]) -> Vector {
        sub(tails[self.last], self.target)
    }
}

/// Returns the pins of a plant.
pub(super) fn pins(rods: &Rods) -> Vec<Pin> {
    let entered = |v: &usize| rods.pinned[*v] && rods.parent(*v).is_some_and(|p| !rods.pinned[p]);
    (0..rods.len())
        .filter(entered)
        .filter_map(|v| {
            let last = rods.parent(v)?;
            let mut path = Vec::new();
            let mut at = Some(last);
            while let Some(u) = at.filter(|&u| !rods.pinned[u]) {
                path.push(u);
                at = rods.parent(u);
            }
            Some(Pin { last, target: rods.rest_heads[v], path })
        })
        .collect()
}

/// Connected free segments, and the pins at their ends: no other pin moves them.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// Indices of the pins.
    pub pins: Vec<usize>,
    /// The segments, every parent before its children.
    pub nodes: Vec<u32>,
}

/// Returns the pins in groups of pins that depend on each other.
pub(super) fn groups(rods: &Rods, pins: &[Pin]) -> Vec<Group> {
    let n = rods.len();
    // The group of the first segment of each free part, and then of all segments.
    let mut group = vec![usize::MAX; n];
    let mut groups: Vec<Group> = Vec::new();
    for (i, pin) in pins.iter().enumerate() {
        let Some(&first) = pin.path.last() else { continue };
        if group[first] == usize::MAX {
            group[first] = groups.len();
            groups.push(Group { pins: vec![], nodes: vec![] });
        }
        groups[group[first]].pins.push(i);
    }
    for &v in &rods.order {
        let at = v as usize;
        if rods.pinned[at] {
            continue;
        }
        if let Some(p) = rods.parent(at).filter(|&p| !rods.pinned[p]) {
            group[at] = group[p];
        }
        if let Some(group) = groups.get_mut(group[at]) {
            group.nodes.push(v);
        }
    }
    groups
}

/// Returns the sum of all gaps.
pub(super) fn total_gap(pins: &[Pin], tails: &[Vector]) -> f64 {
    pins.iter().map(|pin| norm(pin.gap(tails))).sum()
}

/// Solves the symmetric equations of the forces of pins, in place: by Cholesky's method if they are
/// to be positive definite, otherwise by elimination. Where paths do not determine a force, as for
/// a single segment, which can't change its length, a small multiple of the diagonal regularizes
/// the equations. Returns whether the solution succeeded.
pub(super) fn solve_forces(
    mut matrix: Mat<f64>,
    right: &mut Mat<f64>,
    is_definite: bool,
) -> Result<bool> {
    const RIDGE: f64 = 1e-12;
    let n = matrix.nrows();
    let largest = (0..n).map(|i| matrix[(i, i)].abs()).fold(0.0, f64::max);
    (0..n).for_each(|i| matrix[(i, i)] += RIDGE * largest);
    if !is_definite {
        matrix.partial_piv_lu().solve_in_place(right.as_mut());
        return Ok((0..n).all(|i| right[(i, 0)].is_finite()));
    }
    if dense::cholesky(matrix.as_mut())?.is_err() {
        return Ok(false);
    }
    dense::lower_solve_in_place(matrix.as_ref(), right.as_mut());
    dense::upper_solve_in_place(matrix.transpose(), right.as_mut());
    Ok(true)
}
