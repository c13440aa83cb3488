//! The boundary of a cloud: loops of points beside which the surface ends.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::super::vector::Vector;
use super::sheet::{Neighbourhoods, principal};
use catamaran::base::Result;

/// Radius of an empty circle through a point, in mean distances of its neighbours, above which the
/// surface may end there. In regular triangles it is 0.6, in squares 0.7, and among random points
/// one in 140 has more.
pub(super) const EMPTY: f64 = 1.5;

/// The same beside a boundary that has been found.
pub(super) const NEARLY_EMPTY: f64 = 1.1;

/// Distance in spacings within which points of a loop follow each other.
const FOLLOWS: f64 = 2.5;

/// Distance in spacings within which points beside a loop belong to it.
const BESIDE: f64 = 1.5;

/// Least deviation of the points of a loop along their second principal axis, in spacings: a circle
/// about a hole of a width of two spacings. Points with gaps that form no loop are in creases, in
/// gaps between limbs, or where samples are sparse.
const LOOP: f64 = 0.75;

/// The deviation below which a loop must also be hollow, as is the end of a cut limb; the points
/// with gaps of an ear are not.
const LARGE: f64 = 1.5;

/// Least distance of a point from the centre of a hollow loop, in spacings.
const HOLLOW: f64 = 0.75;

/// Returns which points are on the boundary, where `emptiest` says how empty the emptiest circle
/// through each point is.
pub(super) fn boundary(cloud: &Neighbourhoods<'_>, emptiest: &[f64]) -> Result<Vec<bool>> {
    let spacing: Vec<f64> = (0..emptiest.len() as u32).map(|i| cloud.spacing(i)).collect();
    let place = |i: usize| GeomWithData::new(cloud.points[i], i);
    let strong: Vec<usize> = (0..emptiest.len()).filter(|&i| emptiest[i] > EMPTY).collect();
    let tree: RTree<GeomWithData<Vector, usize>> =
        RTree::bulk_load(strong.iter().map(|&i| place(i)).collect());
    let mut found = vec![false; emptiest.len()];
    for group in groups(cloud.points, &strong, &tree, &spacing) {
        let points: Vec<Vector> = group.iter().map(|&i| cloud.points[i]).collect();
        let mean = group.iter().map(|&i| spacing[i]).sum::<f64>() / group.len() as f64;
        let ([_, second, _], _) = principal(&points)?;
        let width = second.max(0.0).sqrt() / mean;
        if width > LARGE || (width > LOOP && cloud.distance(centroid(&points)) > HOLLOW * mean) {
            group.iter().for_each(|&i| found[i] = true);
        }
    }
    let loops = RTree::bulk_load(strong.into_iter().filter(|&i| found[i]).map(place).collect());
    for i in (0..emptiest.len()).filter(|&i| emptiest[i] > NEARLY_EMPTY) {
        let reach = BESIDE * spacing[i];
        found[i] |= loops.locate_within_distance(cloud.points[i], reach * reach).next().is_some();
    }
    Ok(found)
}

fn centroid(points: &[Vector]) -> Vector {
    let count = points.len() as f64;
    std::array::from_fn(|a| points.iter().map(|p| p[a]).sum::<f64>() / count)
}

/// Returns the groups of points that follow each other, each ascending.
fn groups(
    points: &[Vector],
    members: &[usize],
    tree: &RTree<GeomWithData<Vector, usize>>,
    spacing: &[f64],
) -> Vec<Vec<usize>> {
    // Neighbours in both directions, because the larger spacing of two points counts.
    let mut next: Vec<Vec<usize>> = vec![Vec::new(); points.len()];
    for &i in members {
        let reach = FOLLOWS * spacing[i];
        for other in tree.locate_within_distance(points[i], reach * reach) {
            next[i].push(other.data);
            next[other.data].push(i);
        }
    }
    let mut seen = vec![false; points.len()];
    let mut groups = Vec::new();
    for &first in members {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let (mut group, mut at) = (vec![first], 0);
        while let Some(&i) = group.get(at) {
            at += 1;
            for &j in &next[i] {
                if !std::mem::replace(&mut seen[j], true) {
                    group.push(j);
                }
            }
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}
