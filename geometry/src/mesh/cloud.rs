//! The Laplacian of a point cloud: small triangulations around every point, joined in a tufted
//! cover.
//!
//! Source: Sharp and Crane, A Laplacian for Nonmanifold Triangle Meshes (2020), section 5.7.

use faer::Mat;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::vector::{Vector, cross, distance, dot, sub, unit};
use super::{Boundary, Laplacian, LaplacianKind, LaplacianOptions, TriMesh, laplacian};
use catamaran::base::{Error, Par, Result, Rng, options};
use catamaran::dense::symmetric_eigen;
use catamaran::sparse::Mass;

options! {
    /// Options of [`cloud_laplacian`].
    #[derive(Debug, Clone, PartialEq)]
    pub struct CloudOptions {
        /// Number of nearest points with which each point is triangulated.
        neighbours: usize = 30, check(at least 3);
        /// Condition at the boundary, which consists of the points around which the triangles leave
        /// a gap.
        boundary: Boundary = Boundary::Neumann;
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
    }
}

/// Points that a thread triangulates at a time.
const BLOCK: usize = 256;

/// Divisor of the matrices: most triangles are found three times, once from each corner.
const COPIES: f64 = 3.0;

/// Largest displacement of a point for the triangulation, relative to the distance of the nearest
/// neighbour. The displacement depends on the point only, so that cocircular points are
/// triangulated alike from each of them.
const DISORDER: f64 = 1e-6;

/// Largest sine of an angle that counts as 0 or pi, as at a straight boundary: more than the
/// displacement changes it.
const FLAT: f64 = 1e-4;

/// Computes the Laplacian of the surface that `points` were sampled from.
///
/// Around each point, the nearest points are projected into the plane that fits them best, and the
/// triangles at the point are those of the Delaunay triangulation there. The result is the tufted
/// Laplacian of all these triangles, divided by three.
///
/// ```
/// use catamaran_geometry::mesh::{CloudOptions, cloud_laplacian, families};
///
/// let points = families::icosphere(2)?.into_parts().0;
/// let found = cloud_laplacian(&points, &CloudOptions::new().neighbours(12))?;
/// assert_eq!(found.kept.len(), points.len());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::NonFinite`] for a coordinate; [`Error::Argument`] for fewer than 3 neighbours;
/// [`Error::Mesh`] for points at the same place, and as [`laplacian()`].
pub fn cloud_laplacian(points: &[[f64; 3]], options: &CloudOptions) -> Result<Laplacian> {
    let Triangles { mesh, open } = triangles(points, options)?;
    let boundary = match &options.boundary {
        Boundary::Dirichlet => Boundary::Mixed(open),
        other => other.clone(),
    };
    let settings = LaplacianOptions {
        kind: LaplacianKind::Tufted,
        boundary,
        par: options.par,
        ..LaplacianOptions::default()
    };
    let mut found = laplacian(&mesh, &settings)?;
    found.stiffness.data_mut().iter_mut().for_each(|weight| *weight /= COPIES);
    if let Mass::Lumped(masses) = &mut found.mass {
        masses.iter_mut().for_each(|mass| *mass /= COPIES);
    }
    Ok(found)
}

/// The triangles around all points.
struct Triangles {
    mesh: TriMesh,
    /// The points that are not surrounded, ascending.
    open: Vec<u32>,
}

fn triangles(points: &[[f64; 3]], options: &CloudOptions) -> Result<Triangles> {
    options.check_ranges()?;
    for (i, p) in points.iter().enumerate() {
        if let Some(j) = p.iter().position(|x| !x.is_finite()) {
            return Err(Error::NonFinite { what: "points", index: (i, j) });
        }
    }
    let numbered = (0u32..).zip(points).map(|(i, &p)| GeomWithData::new(p, i)).collect();
    let tree = RTree::bulk_load(numbered);
    let blocks = options.par.map_blocks(points.len(), BLOCK, |block| {
        block.map(|i| star(points, &tree, i as u32, options.neighbours)).collect::<Result<Vec<_>>>()
    });
    let (mut faces, mut open) = (Vec::new(), Vec::new());
    let mut i = 0;
    for block in blocks {
        for star in block? {
            if star.open {
                open.push(i);
            }
            faces.extend(star.faces);
            i += 1;
        }
    }
    Ok(Triangles { mesh: TriMesh::new(points.to_vec(), faces)?, open })
}

/// The triangles around a point.
struct Star {
    faces: Vec<[u32; 3]>,
    /// Whether the triangles leave a gap around the point.
    open: bool,
}

fn star(
    points: &[[f64; 3]],
    tree: &RTree<GeomWithData<[f64; 3], u32>>,
    centre: u32,
    neighbours: usize,
) -> Result<Star> {
    let at = points[centre as usize];
    let mut near: Vec<(f64, u32)> = tree
        .nearest_neighbor_iter(at)
        .take(neighbours + 1)
        .map(|other| (distance(*other.geom(), at), other.data))
        .filter(|&(_, i)| i != centre)
        .collect();
    near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    if let Some(&(_, other)) = near.first().filter(|first| first.0 == 0.0) {
        let what = format!("has the same position as point {other}");
        return Err(Error::Mesh { what, element: format!("point {centre}") });
    }
    let reach = DISORDER * near.first().map_or(0.0, |first| first.0);
    let [u, v] = plane(points, at, &near)?;
    let flat = |i: u32| {
        let d = sub(disordered(points, i, reach), disordered(points, centre, reach));
        [dot(d, u), dot(d, v)]
    };
    // An inversion at the point takes circles through it to lines, and circles without other points
    // inside to lines with all other points on one side: the edges of the convex hull.
    let inverted: Vec<([f64; 2], u32)> = near
        .iter()
        .map(|&(_, i)| (flat(i), i))
        .filter(|(p, _)| p[0] != 0.0 || p[1] != 0.0)
        .map(|(p, i)| (p.map(|x| x / (p[0] * p[0] + p[1] * p[1])), i))
        .collect();
    let hull = convex_hull(inverted);
    let mut star = Star { faces: Vec::new(), open: hull.len() < 3 };
    for (k, &(a, i)) in hull.iter().enumerate() {
        let (b, j) = hull[(k + 1) % hull.len()];
        let lengths = a[0].hypot(a[1]) * b[0].hypot(b[1]);
        let sine = (a[0] * b[1] - a[1] * b[0]) / lengths;
        if sine > FLAT {
            star.faces.push([centre, i, j]);
        } else if sine < -FLAT || a[0] * b[0] + a[1] * b[1] < 0.0 {
            star.open = true;
        }
    }
    Ok(star)
}

/// Returns the displaced position of a point. Its direction is the same in every star; `reach`
/// scales it.
fn disordered(points: &[[f64; 3]], i: u32, reach: f64) -> Vector {
    let mut rng = Rng::new(u64::from(i));
    points[i as usize].map(|x| x + reach * (2.0 * rng.uniform() - 1.0))
}

/// Returns two directions that span the plane that fits the neighbours best.
fn plane(points: &[[f64; 3]], at: Vector, near: &[(f64, u32)]) -> Result<[Vector; 2]> {
    let size = near.last().map_or(1.0, |last| last.0);
    let mut moments = Mat::<f64>::zeros(3, 3);
    for &(_, i) in near {
        let d = sub(points[i as usize], at).map(|x| x / size);
        for a in 0..3 {
            for b in 0..3 {
                moments[(a, b)] += d[a] * d[b];
            }
        }
    }
    let vectors = symmetric_eigen(moments.as_ref())?.vectors;
    let normal: Vector = std::array::from_fn(|a| vectors[(a, 0)]);
    let u: Vector = std::array::from_fn(|a| vectors[(a, 2)]);
    Ok([u, unit(cross(normal, u))])
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

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use catamaran::sparse::{EigenOptions, eigs};

    fn values(points: &[[f64; 3]], options: &CloudOptions, k: usize) -> Vec<f64> {
        let found = cloud_laplacian(points, options).unwrap();
        let wanted = EigenOptions::new().k(k);
        eigs(found.stiffness.view(), &found.mass, &wanted).unwrap().values
    }

    /// Returns points spread over the unit sphere along a spiral.
    fn sphere(n: usize) -> Vec<[f64; 3]> {
        let point = |i: usize| {
            let z = 1.0 - (2 * i + 1) as f64 / n as f64;
            let (sin, cos) = (i as f64 * PI * (3.0 - 5f64.sqrt())).sin_cos();
            let r = (1.0 - z * z).sqrt();
            [r * cos, r * sin, z]
        };
        (0..n).map(point).collect()
    }

    #[test]
    fn points_on_a_sphere_have_its_spectrum_and_area() {
        let points = sphere(2000);
        let found = cloud_laplacian(&points, &CloudOptions::default()).unwrap();
        let Mass::Lumped(masses) = &found.mass else { panic!() };
        assert!((masses.iter().sum::<f64>() / (4.0 * PI) - 1.0).abs() < 0.02);
        for (i, value) in values(&points, &CloudOptions::default(), 16).iter().enumerate() {
            let l = i.isqrt() as f64;
            assert!((value - l * (l + 1.0)).abs() < 0.02 * l * (l + 1.0) + 1e-9, "{i}: {value}");
        }
    }

    #[test]
    fn points_of_a_grid_have_the_spectrum_of_the_square() {
        let side = 41;
        let points: Vec<[f64; 3]> = (0..side * side)
            .map(|i| [(i / side) as f64 / 40.0, (i % side) as f64 / 40.0, 0.0])
            .collect();
        let options = CloudOptions { boundary: Boundary::Dirichlet, ..CloudOptions::default() };
        let found = cloud_laplacian(&points, &options).unwrap();
        assert_eq!(found.kept.len(), 39 * 39);
        let found = values(&points, &options, 4);
        for (value, squares) in found.iter().zip([2.0, 5.0, 5.0, 8.0]) {
            assert!((value / (squares * PI * PI) - 1.0).abs() < 0.02, "{value}");
        }
    }

    #[test]
    fn the_result_is_the_same_for_any_number_of_threads() {
        let points = sphere(700);
        let one = CloudOptions { par: Par::Seq, ..CloudOptions::default() };
        let other = CloudOptions { par: Par::Threads(3), ..CloudOptions::default() };
        assert_eq!(cloud_laplacian(&points, &one), cloud_laplacian(&points, &other));
    }

    #[test]
    fn what_is_no_cloud_is_refused() {
        let options = CloudOptions::default();
        assert!(cloud_laplacian(&[], &options).unwrap().kept.is_empty());
        assert!(cloud_laplacian(&[[0.0; 3]], &options).unwrap().kept.is_empty());
        let twice = [[0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]];
        assert!(matches!(cloud_laplacian(&twice, &options).unwrap_err(), Error::Mesh { .. }));
        let broken = [[0.0, f64::NAN, 0.0]];
        let refused = cloud_laplacian(&broken, &options).unwrap_err();
        assert_eq!(refused, Error::NonFinite { what: "points", index: (0, 1) });
        let few = CloudOptions { neighbours: 2, ..options };
        let refused = cloud_laplacian(&sphere(10), &few).unwrap_err();
        assert!(matches!(refused, Error::Argument { what: "neighbours", .. }));
    }
}
