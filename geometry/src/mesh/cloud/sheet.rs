//! The neighbours of a point on its own sheet of the surface.

use faer::Mat;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::super::vector::{Vector, distance, dot, sub};
use catamaran::base::{Error, Par, Result};
use catamaran::dense::symmetric_eigen;

/// Points that a thread processes at a time.
pub(super) const BLOCK: usize = 256;

/// Points of which a plane gives the normal: enough for noise, few enough for a finger.
const PLANE: usize = 11;

/// Nearest points whose mean distance is the spacing of the points.
const RING: usize = 6;

/// Largest sine of the angle between a step on the surface and the tangent planes at its ends:
/// 45 degrees. A step to the other side of a thin gap or limb is steeper.
const STEEP: f64 = 0.7;

/// Least cosine between the normals of a point and of a neighbour on the same sheet.
const AGREE: f64 = 0.2;

/// Points of a surface with their nearest neighbours and normals.
pub(super) struct Neighbourhoods<'p> {
    pub points: &'p [Vector],
    tree: RTree<GeomWithData<Vector, u32>>,
    /// For each point the nearest others: distance and number, ascending.
    near: Vec<Vec<(f64, u32)>>,
    /// Unit normals, of either sign.
    pub normals: Vec<Vector>,
}

impl<'p> Neighbourhoods<'p> {
    /// Finds the nearest `count` points of each point, and its normal.
    ///
    /// # Errors
    /// [`Error::Mesh`] for points at the same place.
    pub fn new(points: &'p [Vector], count: usize, par: Par) -> Result<Self> {
        let numbered = (0u32..).zip(points).map(|(i, &p)| GeomWithData::new(p, i)).collect();
        let tree = RTree::bulk_load(numbered);
        let blocks = par.map_blocks(points.len(), BLOCK, |block| {
            let of = |i: usize| {
                let near = nearest(points, &tree, i, count)?;
                let normal = normal(points, i, &near)?;
                Ok((near, normal))
            };
            block.map(of).collect::<Result<Vec<_>>>()
        });
        let (mut near, mut normals) = (Vec::new(), Vec::new());
        for block in blocks {
            for (own, normal) in block? {
                near.push(own);
                normals.push(normal);
            }
        }
        Ok(Self { points, tree, near, normals })
    }

    /// Returns the `count` nearest points of a point, ascending by distance.
    pub fn nearest(&self, centre: u32, count: usize) -> Vec<u32> {
        self.near[centre as usize].iter().take(count).map(|&(_, i)| i).collect()
    }

    /// Returns the distance of the nearest point; 0 for a single point.
    pub fn least_distance(&self, centre: u32) -> f64 {
        self.near[centre as usize].first().map_or(0.0, |first| first.0)
    }

    /// Returns the distance of a place from the nearest point; infinite for no points.
    pub fn distance(&self, place: Vector) -> f64 {
        let nearest = self.tree.nearest_neighbor(place);
        nearest.map_or(f64::INFINITY, |point| distance(*point.geom(), place))
    }

    /// Returns the mean distance of the nearest points; 0 for a single point.
    pub fn spacing(&self, centre: u32) -> f64 {
        let ring = &self.near[centre as usize][..RING.min(self.near[centre as usize].len())];
        ring.iter().map(|(d, _)| d).sum::<f64>() / ring.len().max(1) as f64
    }

    /// Returns the neighbours of a point on its own sheet. Steps between neighbours, the shortest
    /// first, lead there, none of them steep, and carry the normal along, which must not turn away
    /// from that of the point. So points across a gap, or on the other side of a finger, stay out.
    pub fn sheet(&self, centre: u32) -> Vec<u32> {
        let own = &self.near[centre as usize];
        let all: Vec<u32> = [centre].into_iter().chain(own.iter().map(|&(_, i)| i)).collect();
        let place = |a: usize| self.points[all[a] as usize];
        let mut normals: Vec<Vector> = all.iter().map(|&i| self.normals[i as usize]).collect();
        // For each point that is not reached yet: the length of the shortest step, and from where.
        let mut steps = vec![(f64::INFINITY, 0); all.len()];
        let mut reached = vec![false; all.len()];
        let mut sheet = Vec::with_capacity(own.len());
        let mut last = 0;
        loop {
            reached[last] = true;
            for next in (1..all.len()).filter(|&next| !reached[next]) {
                let step = sub(place(next), place(last));
                let length = dot(step, step).sqrt();
                let steep = |a: usize| dot(step, normals[a]).abs() > STEEP * length;
                if length < steps[next].0 && !steep(last) && !steep(next) {
                    steps[next] = (length, last);
                }
            }
            // Points that turn away are reached, but no step leads on from them.
            loop {
                let open = (1..all.len()).filter(|&a| !reached[a] && steps[a].0.is_finite());
                let Some(next) = open.min_by(|&a, &b| steps[a].0.total_cmp(&steps[b].0)) else {
                    return sheet;
                };
                if dot(normals[next], normals[steps[next].1]) < 0.0 {
                    normals[next] = normals[next].map(|x| -x);
                }
                reached[next] = true;
                if dot(normals[next], normals[0]) > AGREE {
                    sheet.push(all[next]);
                    last = next;
                    break;
                }
            }
        }
    }
}

fn nearest(
    points: &[Vector],
    tree: &RTree<GeomWithData<Vector, u32>>,
    centre: usize,
    count: usize,
) -> Result<Vec<(f64, u32)>> {
    let at = points[centre];
    let mut near: Vec<(f64, u32)> = tree
        .nearest_neighbor_iter(at)
        .take(count + 1)
        .map(|other| (distance(*other.geom(), at), other.data))
        .filter(|&(_, i)| i as usize != centre)
        .collect();
    near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near.truncate(count);
    match near.first() {
        Some(&(0.0, other)) => {
            let what = format!("has the same position as point {other}");
            Err(Error::Mesh { what, element: format!("point {centre}") })
        }
        _ => Ok(near),
    }
}

/// Returns the unit normal of the plane that fits a point and its nearest neighbours best.
fn normal(points: &[Vector], centre: usize, near: &[(f64, u32)]) -> Result<Vector> {
    let near = &near[..near.len().min(PLANE - 1)];
    let size = near.last().map_or(1.0, |last| last.0);
    let from = |i: u32| sub(points[i as usize], points[centre]).map(|x| x / size);
    let offsets: Vec<Vector> =
        [[0.0; 3]].into_iter().chain(near.iter().map(|&(_, i)| from(i))).collect();
    let (_, vectors) = principal(&offsets)?;
    Ok(std::array::from_fn(|a| vectors[(a, 0)]))
}

/// Computes the variances along the principal axes of some points, ascending, and the axes.
pub(super) fn principal(points: &[Vector]) -> Result<([f64; 3], Mat<f64>)> {
    let count = points.len().max(1) as f64;
    let mean: Vector = std::array::from_fn(|a| points.iter().map(|p| p[a]).sum::<f64>() / count);
    let moments = Mat::from_fn(3, 3, |a, b| {
        points.iter().map(|p| (p[a] - mean[a]) * (p[b] - mean[b])).sum::<f64>() / count
    });
    let found = symmetric_eigen(moments.as_ref())?;
    Ok((std::array::from_fn(|a| found.values[a]), found.vectors))
}
