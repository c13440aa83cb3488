use faer::Mat;

use super::by_rows;
use super::cells::Cells;
use crate::mesh::TriMesh;
use crate::mesh::vector::{Vector, cross, dot, scale, sub};
use catamaran::base::{Par, Progress, Result, builder, positive};
use catamaran::dense::symmetric_eigen;

/// Numbers of sectors around the axis, halves along it, shells, and cosines of normals.
const PARTS: [usize; 4] = [8, 2, 2, 11];

/// Number of entries of a descriptor: 8 sectors x 2 halves x 2 shells x 11 cosines.
pub const SHOT_BINS: usize = PARTS[0] * PARTS[1] * PARTS[2] * PARTS[3];

/// Least number of neighbours for a frame.
const FEWEST: usize = 5;

/// Number of vertices that a thread takes at a time.
const BLOCK: usize = 128;

/// Options of [`shot()`]. There is no default, because no radius suits all meshes.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct ShotOptions<'a> {
    /// Radius of the ball around each vertex, in units of length; positive.
    pub radius: f64,
    /// Threads. Does not change the result.
    pub par: Par,
    /// Callback for progress, which may cancel.
    pub progress: Progress<'a>,
}

impl ShotOptions<'_> {
    /// Returns the options with these values, [`Par::all`], and no progress.
    pub fn new(radius: f64) -> Self {
        Self { radius, par: Par::all(), progress: Progress::none() }
    }
}

builder! { ShotOptions<'a> {
    radius: f64,
    par: Par,
    #[into] progress: Progress<'a>,
}}

/// A neighbour: its offset from the vertex, its distance and its normal.
struct Neighbour {
    offset: Vector,
    distance: f64,
    normal: Vector,
}

/// Computes the signatures of histograms of orientations of Tombari, Salti and Di Stefano, Unique
/// Signatures of Histograms for Local Surface Description (2010): for every vertex (row), a
/// histogram of the cosines between the axis of a local frame and the normals of the vertices in
/// each of 32 parts of a ball. A row has [`SHOT_BINS`] columns and norm 1; the index of a column is
/// `((sector * 2 + half) * 2 + shell) * 11 + cosine`.
///
/// The descriptor is invariant under rigid motions and scale (with the radius), not under
/// reflections. A vertex with fewer than five others in its ball has no frame, and its row is zero.
///
/// The axis points to the side of the vertex normal. The paper counts points above and below
/// instead, which is arbitrary in a flat neighbourhood. The weighted sum decides ties of the other
/// axes.
///
/// ```
/// use catamaran_geometry::{mesh::families, spectral::descriptors::{SHOT_BINS, ShotOptions, shot}};
///
/// let sphere = families::icosphere(2)?;
/// let found = shot(&sphere, &ShotOptions::new(0.6))?;
/// assert_eq!((found.nrows(), found.ncols()), (sphere.vertices().len(), SHOT_BINS));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](catamaran::Error::Argument) for a radius that is not positive and finite;
/// [`Error::Cancelled`](catamaran::Error::Cancelled).
pub fn shot(mesh: &TriMesh, options: &ShotOptions<'_>) -> Result<Mat<f64>> {
    let &ShotOptions { radius, par, progress } = options;
    positive("radius", radius)?;
    let points = mesh.vertices();
    let normals = mesh.vertex_normals();
    let cells = Cells::new(points, radius);
    by_rows(points.len(), SHOT_BINS, BLOCK, par, progress, |range, rows| {
        let mut ball = Vec::new();
        for (v, row) in range.zip(rows.chunks_exact_mut(SHOT_BINS)) {
            ball.clear();
            cells.near(&points[v], radius, |i, distance| {
                if i as usize != v {
                    let offset = sub(points[i as usize], points[v]);
                    ball.push(Neighbour { offset, distance, normal: normals[i as usize] });
                }
            });
            if ball.len() >= FEWEST
                && let Some(frame) = frame(&ball, radius, normals[v])
            {
                for neighbour in &ball {
                    count(neighbour, &frame, radius, row);
                }
                let norm = row.iter().map(|x| x * x).sum::<f64>().sqrt();
                if norm > 0.0 {
                    row.iter_mut().for_each(|x| *x /= norm);
                }
            }
        }
        Ok(())
    })
}

/// Returns the axes x, y, z: eigenvectors of the covariance of the offsets, weighted by nearness
/// (Tombari et al., equation 2).
fn frame(ball: &[Neighbour], radius: f64, normal: Vector) -> Option<[Vector; 3]> {
    let mut covariance = Mat::<f64>::zeros(3, 3);
    for Neighbour { offset, distance, .. } in ball {
        for i in 0..3 {
            for j in 0..3 {
                // Relative to the radius, so that no scale overflows or vanishes.
                covariance[(i, j)] +=
                    (1.0 - distance / radius) * (offset[i] / radius) * (offset[j] / radius);
            }
        }
    }
    let axes = symmetric_eigen(covariance.as_ref()).ok()?.vectors;
    let vector = |j: usize| -> Vector { std::array::from_fn(|i| axes[(i, j)]) };
    let (x, z) = (vector(2), vector(0));
    let z = if dot(z, normal) < 0.0 { scale(z, -1.0) } else { z };
    let mut balance = 0_i64;
    let mut sum = 0.0;
    for Neighbour { offset, distance, .. } in ball {
        let along = dot(*offset, x);
        balance += if along >= 0.0 { 1 } else { -1 };
        sum += (radius - distance) * along;
    }
    let flipped = if balance == 0 { sum < 0.0 } else { balance < 0 };
    let x = if flipped { scale(x, -1.0) } else { x };
    Some([x, cross(z, x), z])
}

/// Adds a neighbour to the bins nearest to it, in each of the four directions in proportion to
/// nearness.
fn count(neighbour: &Neighbour, [x, y, z]: &[Vector; 3], radius: f64, bins: &mut [f64]) {
    let Neighbour { offset, distance, normal } = *neighbour;
    let turn = dot(offset, *y).atan2(dot(offset, *x)) / std::f64::consts::TAU;
    let height = if distance > 0.0 { (dot(offset, *z) / distance).clamp(-1.0, 1.0) } else { 0.0 };
    let fractions = [
        turn.rem_euclid(1.0),
        height.acos() / std::f64::consts::PI,
        distance / radius,
        (dot(normal, *z).clamp(-1.0, 1.0) + 1.0) / 2.0,
    ];
    let mut shares = [[(0, 0.0); 2]; 4];
    for (k, fraction) in fractions.into_iter().enumerate() {
        shares[k] = nearest_two(fraction, PARTS[k], k == 0);
    }
    for (a, s) in shares[0] {
        for (b, t) in shares[1] {
            for (c, u) in shares[2] {
                for (d, v) in shares[3] {
                    let bin = ((a * PARTS[1] + b) * PARTS[2] + c) * PARTS[3] + d;
                    bins[bin] += s * t * u * v;
                }
            }
        }
    }
}

/// Returns the two of `parts` equal bins of [0, 1] whose middles are nearest to `fraction`, and
/// their weights. At the ends there is one bin, unless the bins are cyclic.
pub(super) fn nearest_two(fraction: f64, parts: usize, cyclic: bool) -> [(usize, f64); 2] {
    let place = fraction * parts as f64 - 0.5;
    let below = place.floor();
    let share = place - below;
    let bin = |i: f64| match cyclic {
        true => (i.rem_euclid(parts as f64) as usize).min(parts - 1),
        false => i.clamp(0.0, (parts - 1) as f64) as usize,
    };
    [(bin(below), 1.0 - share), (bin(below + 1.0), share)]
}
