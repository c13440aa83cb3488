//! Closed surfaces.

use std::collections::HashMap;

use super::super::TriMesh;
use super::super::vector::cross;
use super::draft::{Draft, Seam, sheet, turn};
use super::voxels;
use catamaran::base::{Error, Result, at_least, positive, spend};

/// The golden ratio, which gives the corners of an icosahedron.
const PHI: f64 = 1.618_033_988_749_895;

#[rustfmt::skip]
const ICOSAHEDRON: [[u32; 3]; 20] = [
    [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11],
    [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
    [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9],
    [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
];

/// Operations for a face that is cut into four, roughly.
const CUT: f64 = 200.0;

/// Generates the unit sphere: an icosahedron whose faces are cut into four `subdivisions` times. F
/// = 20 4^s, V = 10 4^s + 2, genus 0.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let mesh = families::icosphere(2)?;
/// assert_eq!((mesh.vertices().len(), mesh.faces().len()), (162, 320));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for more than 13 subdivisions.
pub fn icosphere(subdivisions: u32) -> Result<TriMesh> {
    let faces = 4usize.checked_pow(subdivisions).and_then(|n| n.checked_mul(20));
    let mut draft = Draft::with_counts(faces.map(|n| n / 2 + 2), faces)?;
    let corner = |s: f64, t: f64| [[-s, t * PHI, 0.0], [0.0, -s, t * PHI], [t * PHI, 0.0, -s]];
    // The order is that of the table of faces: by axis, then by signs.
    for axis in 0..3 {
        for (s, t) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            draft.vertices.push(on_sphere(corner(s, t)[axis]));
        }
    }
    draft.faces.extend(ICOSAHEDRON);
    for _ in 0..subdivisions {
        let coarse = std::mem::take(&mut draft.faces);
        draft.faces.reserve_exact(4 * coarse.len());
        let mut middles = HashMap::with_capacity(coarse.len() * 3 / 2);
        for [a, b, c] in coarse {
            spend(CUT)?;
            let [d, e, f] = [(a, b), (b, c), (c, a)].map(|(u, v)| {
                *middles.entry((u.min(v), u.max(v))).or_insert_with(|| {
                    let [p, q] = [u, v].map(|w| draft.vertices[w as usize]);
                    draft.vertices.push(on_sphere([p[0] + q[0], p[1] + q[1], p[2] + q[2]]));
                    draft.vertices.len() as u32 - 1
                })
            });
            draft.faces.extend([[a, d, f], [b, e, d], [c, f, e], [d, e, f]]);
        }
    }
    draft.finish()
}

fn on_sphere(p: [f64; 3]) -> [f64; 3] {
    let length = p.map(|x| x * x).iter().sum::<f64>().sqrt();
    p.map(|x| x / length)
}

/// Generates `count` separate unit spheres ([`icosphere`]) in a row along x, 3 apart: components
/// that differ only in position.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let mesh = families::spheres(3, 0)?;
/// assert_eq!((mesh.vertices().len(), mesh.faces().len()), (36, 60));
/// assert_eq!(mesh.validate().components, 3);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for too many vertices.
pub fn spheres(count: usize, subdivisions: u32) -> Result<TriMesh> {
    let sphere = icosphere(subdivisions)?;
    let times = |n: usize| n.checked_mul(count);
    let mut draft =
        Draft::with_counts(times(sphere.vertices().len()), times(sphere.faces().len()))?;
    for i in 0..count {
        let first = (i * sphere.vertices().len()) as u32;
        draft
            .vertices
            .extend(sphere.vertices().iter().map(|p| [p[0] + 3.0 * i as f64, p[1], p[2]]));
        draft.faces.extend(sphere.faces().iter().map(|f| f.map(|v| v + first)));
    }
    draft.finish()
}

/// Generates a torus around the z axis whose middle is a circle of radius `major` and whose tube
/// has radius `minor`: V = around tube, F = 2 V, genus 1.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let mesh = families::torus(12, 6, 1.0, 0.3)?;
/// assert_eq!((mesh.vertices().len(), mesh.faces().len()), (72, 144));
/// assert_eq!(mesh.validate().euler_characteristic, 0);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for fewer than 3 steps either way, too many, or radii that are not 0 < minor
/// < major.
pub fn torus(around: usize, tube: usize, major: f64, minor: f64) -> Result<TriMesh> {
    positive("minor", minor)?;
    positive("major", major)?;
    if minor >= major {
        let why = format!("must be less than the major radius {major}, is {minor}");
        return Err(Error::Argument { what: "minor", why });
    }
    sheet(around, tube, Seam::Joined, true, |i, j| {
        let ((sin_u, cos_u), (sin_v, cos_v)) = (turn(i, around).sin_cos(), turn(j, tube).sin_cos());
        let distance = major + minor * cos_v;
        [distance * cos_u, distance * sin_u, minor * sin_v]
    })
}

/// Generates a tube of radius `radius` around the (p, q) torus knot on the torus of radii 2 and 1,
/// p times around its axis and q times around its tube (trefoil: 2, 3): V = along tube, F = 2 V,
/// genus 1. A tube thinner than about 1 / (p + q) does not intersect itself.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let mesh = families::knot(2, 3, 60, 6, 0.2)?;
/// assert_eq!((mesh.vertices().len(), mesh.faces().len()), (360, 720));
/// assert!(mesh.validate().problems.is_empty());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] unless p and q are positive and have no common divisor, for fewer than 3
/// steps either way, too many, or a radius that is not positive.
pub fn knot(p: u32, q: u32, along: usize, tube: usize, radius: f64) -> Result<TriMesh> {
    positive("radius", radius)?;
    if p == 0 || q == 0 || common_divisor(p, q) != 1 {
        let why = format!("must be positive numbers without a common divisor, are ({p}, {q})");
        return Err(Error::Argument { what: "p, q", why });
    }
    let (p, q) = (f64::from(p), f64::from(q));
    sheet(along, tube, Seam::Joined, true, |i, j| {
        let t = turn(i, along);
        let ((sin_u, cos_u), (sin_v, cos_v)) = ((p * t).sin_cos(), (q * t).sin_cos());
        let distance = 2.0 + cos_v;
        // The normal of the torus is normal to every curve on the torus: the frame closes without a
        // twist.
        let normal = [cos_v * cos_u, cos_v * sin_u, sin_v];
        let tangent = on_sphere([
            -q * sin_v * cos_u - p * distance * sin_u,
            -q * sin_v * sin_u + p * distance * cos_u,
            q * cos_v,
        ]);
        let side = cross(normal, tangent);
        let (sin, cos) = turn(j, tube).sin_cos();
        let centre = [distance * cos_u, distance * sin_u, sin_v];
        std::array::from_fn(|k| centre[k] + radius * (cos * normal[k] + sin * side[k]))
    })
}

fn common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

/// Generates a rounded slab with `genus` holes in a row, made of cubes with `cells` x `cells` cells
/// a side: F = 2 cells^2 (18 genus + 14), V = F / 2 + 2 - 2 genus.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let mesh = families::genus(2, 1)?;
/// assert_eq!((mesh.vertices().len(), mesh.faces().len()), (48, 100));
/// assert_eq!(mesh.validate().euler_characteristic, 2 - 2 * 2);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] without cells, or for too many vertices.
pub fn genus(genus: usize, cells: usize) -> Result<TriMesh> {
    at_least("cells", cells, 1)?;
    // Above this limit the vertices could not be numbered; below it, the coordinates fit the
    // integers.
    let squares = genus.checked_mul(18).and_then(|n| n.checked_add(14));
    let faces = squares.and_then(|n| n.checked_mul(cells)?.checked_mul(cells)?.checked_mul(2));
    let draft = Draft::with_counts(faces.map(|n| n / 2 + 2), faces)?;
    let length = 2 * genus as i32 + 1;
    let hole = |x: i32, y: i32| x % 2 == 1 && y == 1;
    let cubes = (0..length).flat_map(|x| (0..3).map(move |y| [x, y, 0]));
    let cubes: Vec<_> = cubes.filter(|&[x, y, _]| !hole(x, y)).collect();
    voxels::surface(&cubes, cells as i32, draft)
}
