use std::sync::{Mutex, PoisonError};

use faer::{Mat, MatRef};

use super::by_rows;
use super::shot::nearest_two;
use crate::mesh::{Dijkstra, Graph, SearchLimits, TriMesh, vertex_areas};
use crate::spectral::dense::check_finite;
use catamaran::base::{Error, Par, Progress, Result, at_least, builder, positive};

/// Number of vertices that a thread takes at a time.
const BLOCK: usize = 128;

/// Options of [`geodesic_rings`]. There is no default, because no radius suits all meshes.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct RingOptions<'a> {
    /// Radius of the patch, along edges, in units of length; positive.
    pub radius: f64,
    /// Number of rings that divide the patch; at least 1.
    pub rings: usize,
    /// Threads. Does not change the result.
    pub par: Par,
    /// Callback for progress, which may cancel.
    pub progress: Progress<'a>,
}

impl RingOptions<'_> {
    /// Returns the options with these values, [`Par::all`], and no progress.
    pub fn new(radius: f64, rings: usize) -> Self {
        Self { radius, rings, par: Par::all(), progress: Progress::none() }
    }
}

builder! { RingOptions<'a> {
    radius: f64,
    rings: usize,
    par: Par,
    #[into] progress: Progress<'a>,
}}

/// Computes means of functions over rings around every vertex: an intrinsic local descriptor of
/// this crate, in place of the anisotropic windowed Fourier transform (Melzi, Rodola, Castellani
/// and Bronstein 2018) that the thesis uses. Like that transform, it samples functions, such as
/// heat kernel signatures, in windows on the surface.
///
/// `functions` are c values for each vertex (n x c). The patch of a vertex consists of the vertices
/// at most the radius away along edges. Each of them has the weight of a third of the area of its
/// faces, and divides it between the two rings whose middles are nearest, by distance. The result
/// has `rings * (1 + c)` columns, ring after ring from the middle: the share of the ring in the
/// area of the patch, then the means of the functions. A ring without area has the values of the
/// vertex itself.
///
/// The result is the same for meshes with the same connectivity and edge lengths, if the functions
/// are the same.
///
/// ```
/// use catamaran::faer::Mat;
/// use catamaran_geometry::mesh::families;
/// use catamaran_geometry::spectral::descriptors::{RingOptions, geodesic_rings};
///
/// let mesh = families::icosphere(2)?;
/// let ones = Mat::<f64>::ones(mesh.vertices().len(), 1);
/// let found = geodesic_rings(&mesh, ones.as_ref(), &RingOptions::new(0.5, 2))?;
/// for row in found.row_iter() {
///     assert!((row[0] + row[2] - 1.0).abs() < 1e-12); // shares of the area
///     assert!((row[1] - 1.0).abs() < 1e-12 && (row[3] - 1.0).abs() < 1e-12); // means
/// }
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] unless the functions have a row for each vertex, [`Error::NonFinite`],
/// [`Error::Argument`] for a radius that is not positive and finite or no rings;
/// [`Error::Cancelled`].
pub fn geodesic_rings(
    mesh: &TriMesh,
    functions: MatRef<'_, f64>,
    options: &RingOptions<'_>,
) -> Result<Mat<f64>> {
    let &RingOptions { radius, rings, par, progress } = options;
    let (n, c) = (mesh.vertices().len(), functions.ncols());
    Error::check_shape("functions", (n, c), (functions.nrows(), c))?;
    check_finite("functions", functions)?;
    positive("radius", radius)?;
    at_least("rings", rings, 1)?;
    let areas = vertex_areas(mesh);
    let graph = Graph::of_mesh(mesh);
    // One solver for each thread, created on first use.
    let solvers: Mutex<Vec<Dijkstra<'_>>> = Mutex::default();
    let lock = || solvers.lock().unwrap_or_else(PoisonError::into_inner);
    let width = rings * (1 + c);
    by_rows(n, width, BLOCK, par, progress, |range, rows| {
        let idle = lock().pop();
        let mut search = idle.unwrap_or_else(|| Dijkstra::new(&graph));
        let limits = SearchLimits { cutoff: radius, ..Default::default() };
        for (v, row) in range.zip(rows.chunks_exact_mut(width)) {
            search.search(&[(v as u32, 0.0)], &limits)?;
            let mut patch = 0.0;
            for &u in search.reached() {
                let (fraction, u_row) = (search.distance(u) / radius, u as usize);
                patch += areas[u_row];
                for (ring, share) in nearest_two(fraction, rings, false) {
                    let area = share * areas[u_row];
                    let sums = &mut row[ring * (1 + c)..(ring + 1) * (1 + c)];
                    sums[0] += area;
                    for (j, sum) in sums[1..].iter_mut().enumerate() {
                        *sum += area * functions[(u_row, j)];
                    }
                }
            }
            for sums in row.chunks_exact_mut(1 + c) {
                let area = sums[0];
                for (j, sum) in sums[1..].iter_mut().enumerate() {
                    *sum = if area > 0.0 { *sum / area } else { functions[(v, j)] };
                }
                sums[0] = if patch > 0.0 { area / patch } else { 0.0 };
            }
        }
        lock().push(search);
        Ok(())
    })
}
