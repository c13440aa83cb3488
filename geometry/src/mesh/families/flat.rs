//! Surfaces with boundary.

use super::super::TriMesh;
use super::draft::{Draft, Seam, sheet, turn};
use catamaran::base::{Result, Rng, at_least, positive};

/// Generates the unit square in the plane z = 0, `columns` x `rows` cells: V = (columns + 1) (rows
/// + 1), F = 2 columns rows, one boundary loop.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let mesh = families::grid(4, 3)?;
/// assert_eq!((mesh.vertices().len(), mesh.faces().len()), (20, 24));
/// assert!((mesh.area() - 1.0).abs() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](catamaran::Error::Argument) without a cell, or for too many.
pub fn grid(columns: usize, rows: usize) -> Result<TriMesh> {
    sheet(columns, rows, Seam::Open, false, |i, j| {
        [i as f64 / columns as f64, j as f64 / rows as f64, 0.0]
    })
}

/// Generates the unit disk in the plane z = 0, a fan of `sectors` (at least 3) with `rings` (at
/// least 1) of equal width: V = 1 + rings sectors, F = sectors (2 rings - 1), one boundary loop.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let mesh = families::disk(3, 8)?;
/// assert_eq!((mesh.vertices().len(), mesh.faces().len()), (25, 40));
/// assert_eq!(mesh.validate().boundary_loops, Some(1));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](catamaran::Error::Argument) for too few or too many.
pub fn disk(rings: usize, sectors: usize) -> Result<TriMesh> {
    at_least("rings", rings, 1)?;
    at_least("sectors", sectors, 3)?;
    let vertices = rings.checked_mul(sectors).and_then(|n| n.checked_add(1));
    let faces = vertices.and_then(|n| n.checked_mul(2));
    let mut draft = Draft::with_counts(vertices, faces)?;
    draft.vertices.push([0.0; 3]);
    for ring in 1..=rings {
        let radius = ring as f64 / rings as f64;
        draft.vertices.extend((0..sectors).map(|sector| {
            let (sin, cos) = turn(sector, sectors).sin_cos();
            [radius * cos, radius * sin, 0.0]
        }));
    }
    let number = |ring: usize, sector: usize| (1 + ring * sectors + sector % sectors) as u32;
    for sector in 0..sectors {
        draft.faces.push([0, number(0, sector), number(0, sector + 1)]);
        for ring in 1..rings {
            let [a, b] = [number(ring - 1, sector), number(ring, sector)];
            let [c, d] = [number(ring, sector + 1), number(ring - 1, sector + 1)];
            draft.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    draft.finish()
}

/// Generates an open cylinder around the z axis from z = 0 to `height`: V = around (along + 1), F =
/// 2 around along, two boundary loops, Euler characteristic 0.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let mesh = families::cylinder(8, 2, 1.0, 3.0)?;
/// assert_eq!((mesh.vertices().len(), mesh.faces().len()), (24, 32));
/// assert_eq!(mesh.validate().boundary_loops, Some(2));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](catamaran::Error::Argument) for `around` below 3, `along` 0, too many cells,
/// or sizes that are not positive.
pub fn cylinder(around: usize, along: usize, radius: f64, height: f64) -> Result<TriMesh> {
    positive("radius", radius)?;
    positive("height", height)?;
    sheet(around, along, Seam::Joined, false, |i, j| {
        let (sin, cos) = turn(i, around).sin_cos();
        [radius * cos, radius * sin, height * j as f64 / along as f64]
    })
}

/// Generates a Moebius strip, a band of width 1 with a half-twist around a circle of radius 1: V =
/// around (across + 1), F = 2 around across, one boundary loop, not orientable (genus 1), Euler
/// characteristic 0.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let mesh = families::moebius(12, 2)?;
/// assert_eq!((mesh.vertices().len(), mesh.faces().len()), (36, 48));
/// assert_eq!(mesh.validate().boundary_loops, Some(1));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](catamaran::Error::Argument) for `around` below 3, `across` 0, or too many
/// cells.
pub fn moebius(around: usize, across: usize) -> Result<TriMesh> {
    sheet(around, across, Seam::Twisted, false, |i, j| {
        let angle = turn(i, around);
        let offset = j as f64 / across as f64 - 0.5;
        let radius = 1.0 + offset * (angle / 2.0).cos();
        [radius * angle.cos(), radius * angle.sin(), offset * (angle / 2.0).sin()]
    })
}

/// Noise of finer and finer scale is added up to this many times.
const OCTAVES: u32 = 6;

/// Generates hills over the unit square, between z = -0.2 and 0.2: [`grid`] with heights from value
/// noise of 6 octaves.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let mesh = families::terrain(8, 8, 1)?;
/// assert_eq!(mesh.faces(), families::grid(8, 8)?.faces());
/// assert!(mesh.vertices().iter().all(|p| p[2].abs() <= 0.2));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As those of [`grid`].
pub fn terrain(columns: usize, rows: usize, seed: u64) -> Result<TriMesh> {
    let mut rng = Rng::new(seed);
    let octaves: Vec<Noise> = (1..=OCTAVES).map(|k| Noise::new(1 << k, &mut rng)).collect();
    sheet(columns, rows, Seam::Open, false, |i, j| {
        let (x, y) = (i as f64 / columns as f64, j as f64 / rows as f64);
        let halves = (0..).map(|k| 0.1 * 0.5f64.powi(k));
        let height = octaves.iter().zip(halves).map(|(noise, scale)| scale * noise.at(x, y)).sum();
        [x, y, height]
    })
}

/// Random values in [-1, 1) on a lattice of the unit square, and smooth interpolation between them.
struct Noise {
    cells: usize,
    values: Vec<f64>,
}

impl Noise {
    fn new(cells: usize, rng: &mut Rng) -> Self {
        let values = (0..(cells + 1).pow(2)).map(|_| 2.0 * rng.uniform() - 1.0).collect();
        Self { cells, values }
    }

    fn at(&self, x: f64, y: f64) -> f64 {
        let place = |t: f64| {
            let t = t * self.cells as f64;
            let cell = (t as usize).min(self.cells - 1);
            let t = t - cell as f64;
            (cell, t * t * (3.0 - 2.0 * t))
        };
        let ((i, s), (j, t)) = (place(x), place(y));
        let value = |i: usize, j: usize| self.values[i * (self.cells + 1) + j];
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        mix(mix(value(i, j), value(i + 1, j), s), mix(value(i, j + 1), value(i + 1, j + 1), s), t)
    }
}
