//! The triangles around a point of a cloud.

use super::super::vector::{Vector, cross, dot, square, sub, unit};
use super::sheet::Neighbourhoods;
use catamaran::base::Rng;

/// Largest displacement of a point for the triangulation, relative to the distance of the nearest
/// neighbour. The displacement depends on the point only, so that cocircular points are
/// triangulated alike from each of them.
const DISORDER: f64 = 1e-6;

/// Largest sine of an angle that counts as 0 or pi, as at a straight boundary: more than the
/// displacement changes it.
const FLAT: f64 = 1e-4;

/// The triangles around a point.
pub(super) struct Star {
    /// Triangles, and how empty each is: the radius of the circle through its corners, which has no
    /// point inside, over the mean distance of the neighbours in the star.
    pub faces: Vec<([u32; 3], f64)>,
    /// How empty the emptiest circle through the point is; infinite where the triangles leave a
    /// gap.
    pub emptiest: f64,
}

impl Star {
    /// Finds the triangles at a point in the Delaunay triangulation of the point and of these
    /// neighbours, turned into its tangent plane with their distances.
    pub fn new(cloud: &Neighbourhoods<'_>, centre: u32, neighbours: &[u32]) -> Self {
        let normal = cloud.normals[centre as usize];
        let across = if normal[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let u = unit(cross(normal, across));
        let v = cross(normal, u);
        let reach = DISORDER * cloud.least_distance(centre);
        let at = disordered(cloud.points, centre, reach);
        let flat = |i: u32| {
            let d = sub(disordered(cloud.points, i, reach), at);
            let p = [dot(d, u), dot(d, v)];
            let longer = square(d).sqrt() / p[0].hypot(p[1]);
            p.map(|x| longer * x)
        };
        // An inversion at the point takes circles through it to lines, and circles without other
        // points inside to lines with all other points on one side: the edges of the convex hull.
        let inverted: Vec<([f64; 2], u32)> = neighbours
            .iter()
            .map(|&i| (flat(i), i))
            .map(|(p, i)| (p.map(|x| x / (p[0] * p[0] + p[1] * p[1])), i))
            .filter(|(p, _)| p.iter().all(|x| x.is_finite()))
            .collect();
        let hull = convex_hull(inverted);
        let mean =
            hull.iter().map(|(a, _)| 1.0 / a[0].hypot(a[1])).sum::<f64>() / hull.len() as f64;
        let emptiest = if hull.len() < 3 { f64::INFINITY } else { 0.0 };
        let mut star = Self { faces: Vec::new(), emptiest };
        for (k, &(a, i)) in hull.iter().enumerate() {
            let (b, j) = hull[(k + 1) % hull.len()];
            let area = a[0] * b[1] - a[1] * b[0];
            let sine = area / (a[0].hypot(a[1]) * b[0].hypot(b[1]));
            if sine > FLAT {
                // The circle's diameter is one over the distance of the line from the point.
                let radius = (a[0] - b[0]).hypot(a[1] - b[1]) / (2.0 * area);
                star.faces.push(([centre, i, j], radius / mean));
                star.emptiest = star.emptiest.max(radius / mean);
            } else if sine < -FLAT || a[0] * b[0] + a[1] * b[1] < 0.0 {
                star.emptiest = f64::INFINITY;
            }
        }
        star
    }
}

/// Returns the displaced position of a point. Its direction is the same in every star; `reach`
/// scales it.
fn disordered(points: &[Vector], i: u32, reach: f64) -> Vector {
    let mut rng = Rng::new(u64::from(i));
    points[i as usize].map(|x| x + reach * (2.0 * rng.uniform() - 1.0))
}

/// Returns the corners of the convex hull, counter-clockwise (Andrew 1979).
fn convex_hull(mut points: Vec<([f64; 2], u32)>) -> Vec<([f64; 2], u32)> {
    points.sort_unstable_by(|(p, i), (q, j)| {
        p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(i.cmp(j))
    });
    if points.len() < 3 {
        return points;
    }
    let right_turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) <= 0.0
    };
    let mut hull: Vec<([f64; 2], u32)> = Vec::new();
    for pass in 0..2 {
        let start = hull.len();
        for k in 0..points.len() {
            let next = points[if pass == 0 { k } else { points.len() - 1 - k }];
            while hull.len() >= start + 2
                && right_turn(hull[hull.len() - 2].0, hull[hull.len() - 1].0, next.0)
            {
                hull.pop();
            }
            hull.push(next);
        }
        hull.pop();
    }
    hull
}
