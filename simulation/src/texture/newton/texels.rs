//! The points of a surface at the centres of the texels of its texture.

use catamaran::base::{Error, Result, reserved};
use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::mesh::io::Attribute;

/// The texels that a mesh covers, and their positions on it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Texels {
    /// Their numbers, column + width row, rows from the top (v = 1) downwards; ascending.
    pub numbers: Vec<u32>,
    /// Their positions on the surface.
    pub positions: Vec<[f32; 3]>,
    /// Number of texels whose centre is in several faces: these share texture.
    pub shared: usize,
}

/// Finds the texels of a `width` x `height` texture whose centre is in a face of `mesh` laid out by
/// `uv`, u to the right and v up, both from 0 to 1. Where faces overlap, the first one counts;
/// faces without UV, and parts outside of the texture, are left out.
///
/// ```
/// use catamaran_geometry::mesh::{families, io::Attribute};
/// use catamaran_simulation::texture::newton::texels;
///
/// let mesh = families::grid(1, 1)?;
/// let values = mesh.vertices().iter().map(|p| [p[0], p[1]]).collect();
/// let found = texels(&mesh, &Attribute { values, corners: None }, 4, 4)?;
/// assert_eq!(found.numbers, (0..16).collect::<Vec<_>>());
/// assert_eq!(found.positions[0], [0.125, 0.875, 0.0]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for sides of 0 or more than 65,536, or a face whose UV are not finite;
/// [`Error::OutOfMemory`].
pub fn texels(mesh: &TriMesh, uv: &Attribute<2>, width: u32, height: u32) -> Result<Texels> {
    if [width, height].iter().any(|side| !(1..=1 << 16).contains(side))
        || u64::from(width) * u64::from(height) >= 1 << 31
    {
        let why = format!("sides must be 1 to 65,536, below 2^31 texels, are {width} x {height}");
        return Err(Error::Argument { what: "texture", why });
    }
    let (columns, rows) = (f64::from(width), f64::from(height));
    let mut owners: Vec<u32> = reserved(width as usize * height as usize)?;
    owners.resize(width as usize * height as usize, u32::MAX);
    let mut found = 0;
    let mut shared: Vec<bool> = reserved(owners.len())?;
    shared.resize(owners.len(), false);
    for f in 0..mesh.faces().len() {
        let Some(corners) = uv.of_face(mesh, f) else { continue };
        if !corners.as_flattened().iter().all(|x| x.is_finite()) {
            let why = format!("face {f} must have finite coordinates, has {corners:?}");
            return Err(Error::Argument { what: "uv", why });
        }
        // In texels, whose centres are at integers.
        let corners = corners.map(|[u, v]| [u * columns - 0.5, (1.0 - v) * rows - 0.5]);
        let span = |axis: usize, count: u32| {
            let all = corners.map(|c| c[axis]);
            let low = all.iter().copied().fold(f64::INFINITY, f64::min).ceil().max(0.0);
            let high = all.iter().copied().fold(f64::NEG_INFINITY, f64::max).floor();
            let end = (high + 1.0).clamp(0.0, f64::from(count));
            low.min(end) as u32..end as u32
        };
        for row in span(1, height) {
            for column in span(0, width) {
                let owner = &mut owners[(row * width + column) as usize];
                let Some(weights) = weights(corners, f64::from(column), f64::from(row)) else {
                    continue;
                };
                if *owner == u32::MAX {
                    *owner = f as u32;
                    found += 1;
                } else if weights.iter().all(|w| *w > INSIDE) {
                    shared[(row * width + column) as usize] = true;
                }
            }
        }
    }
    let shared = shared.iter().filter(|shared| **shared).count();
    let mut texels = Texels { numbers: reserved(found)?, positions: reserved(found)?, shared };
    for (number, &f) in owners.iter().enumerate().filter(|(_, f)| **f != u32::MAX) {
        let Some(corners) = uv.of_face(mesh, f as usize) else { continue };
        let corners = corners.map(|[u, v]| [u * columns - 0.5, (1.0 - v) * rows - 0.5]);
        let number = number as u32;
        let Some(weights) = weights(corners, f64::from(number % width), f64::from(number / width))
        else {
            continue;
        };
        let places = mesh.faces()[f as usize].map(|v| mesh.vertices()[v as usize]);
        texels.numbers.push(number);
        texels.positions.push(
            [0, 1, 2].map(|c| {
                (0..3).map(|corner| weights[corner] * places[corner][c]).sum::<f64>() as f32
            }),
        );
    }
    Ok(texels)
}

/// Barycentric coordinates of a point that is inside of a triangle, and not on an edge but for
/// rounding.
const INSIDE: f64 = 1e-6;

/// Returns barycentric coordinates of (x, y) in a triangle; `None` outside.
fn weights([a, b, c]: [[f64; 2]; 3], x: f64, y: f64) -> Option<[f64; 3]> {
    let cross = |p: [f64; 2], q: [f64; 2]| (p[0] - x) * (q[1] - y) - (p[1] - y) * (q[0] - x);
    let parts = [cross(b, c), cross(c, a), cross(a, b)];
    let all: f64 = parts.iter().sum();
    let weights = parts.map(|part| part / all);
    // A triangle without area gives NaN, which is not >= 0.
    if weights.iter().all(|w| *w >= 0.0) { Some(weights) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran_geometry::mesh::families;

    fn flat_uv(mesh: &TriMesh, scale: f64) -> Attribute<2> {
        let values = mesh.vertices().iter().map(|p| [p[0] * scale, p[1] * scale]).collect();
        Attribute { values, corners: None }
    }

    /// Returns a square of side 1.
    fn square() -> TriMesh {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let vertices = corners.map(|[x, y]| [x, y, 0.25]).to_vec();
        TriMesh::new(vertices, vec![[0, 1, 2], [0, 2, 3]]).unwrap()
    }

    #[test]
    fn a_square_covers_its_texture_once() {
        for (width, height) in [(1, 1), (2, 3), (7, 5), (128, 127)] {
            let mesh = square();
            let found = texels(&mesh, &flat_uv(&mesh, 1.0), width, height).unwrap();
            assert_eq!(found.numbers, (0..width * height).collect::<Vec<_>>());
            for (&number, p) in found.numbers.iter().zip(&found.positions) {
                let x = (f64::from(number % width) + 0.5) / f64::from(width);
                let y = 1.0 - (f64::from(number / width) + 0.5) / f64::from(height);
                assert!((f64::from(p[0]) - x).abs() < 1e-6, "{p:?}");
                assert!((f64::from(p[1]) - y).abs() < 1e-6 && p[2] == 0.25, "{p:?}");
            }
        }
    }

    #[test]
    fn what_is_outside_of_the_texture_is_left_out() {
        let mesh = square();
        let half = texels(&mesh, &flat_uv(&mesh, 0.5), 16, 16).unwrap();
        assert_eq!(half.numbers.len(), 64);
        let double = texels(&mesh, &flat_uv(&mesh, 2.0), 16, 16).unwrap();
        assert_eq!(double.numbers.len(), 256);
        let none = texels(&mesh, &flat_uv(&mesh, 1e-9), 16, 16).unwrap();
        assert!(none.numbers.is_empty());
    }

    #[test]
    fn faces_without_area_or_uv_cover_nothing() {
        let mesh = families::icosphere(0).unwrap();
        let flat = Attribute { values: vec![[0.5, 0.5]; mesh.vertices().len()], corners: None };
        assert!(texels(&mesh, &flat, 9, 9).unwrap().numbers.is_empty());
        let absent = [Attribute::<2>::ABSENT; 3];
        let none = Attribute { values: vec![], corners: Some(vec![absent; mesh.faces().len()]) };
        assert!(texels(&mesh, &none, 9, 9).unwrap().numbers.is_empty());
        let wrong = Attribute { values: vec![[f64::NAN; 2]; mesh.vertices().len()], corners: None };
        assert!(matches!(texels(&mesh, &wrong, 9, 9), Err(Error::Argument { what: "uv", .. })));
        assert!(
            texels(&mesh, &flat, 0, 9).is_err() && texels(&mesh, &flat, 1 << 16, 1 << 16).is_err()
        );
    }
}
