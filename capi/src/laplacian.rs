//! # Laplacians
//!
//! The matrices of the Laplacian of a mesh or of points, of gradients and of divergences, by rows:
//! the entries of row i are those from `row_starts[i]` to `row_starts[i + 1] - 1`.
//!
//! ```c
//! double v[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, w[16]; // a tetrahedron
//! uint32_t f[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
//! cata_laplacian *laplacian;
//! size_t n, entries, starts[5], columns[16];
//! cata_laplacian_new(4, v, 4, f, 0, NULL, NULL, &laplacian);
//! cata_laplacian_size(laplacian, &n, &entries, NULL);
//! cata_laplacian_get(laplacian, NULL, starts, columns, w);
//! printf("%zu rows, %zu entries, first %g\n", n, entries, w[0]); // 4 rows, 16 entries, first 3
//! cata_laplacian_free(laplacian);
//! ```

use super::boundary::boundary;
use super::eigs::{cata_eigs_params, with_eigen_options};
use super::outputs::{copy, copy_wanted, fill_slice, tell};
use super::pointer::{free, hand_over, known, mesh, optional_slice_mut, output, slice, slice_mut};
use super::progress::reported;
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use catamaran::sparse::{CsMat, EigenOptions, Mass};
use catamaran_geometry::mesh::{
    Boundary, CloudOptions, Laplacian, LaplacianOptions, cloud_laplacian, divergence, gradient,
    laplacian, vertex_areas,
};

/// The matrices of W phi = lambda M phi: the stiffness W and the mass M. Constant.
pub struct cata_laplacian {
    found: Laplacian,
}

/// Computes the Laplacian of a triangle mesh: W, positive semi-definite, minus the weight of an
/// edge off the diagonal, and M, whose entries sum to the area. Vertices in no face and those where
/// functions are zero have no row.
///
/// - `n_held`, `held`: vertices where functions are zero, with CATA_BOUNDARY_NEUMANN elsewhere; 0
///   and NULL: none.
/// - `params`: the Laplacian, `threads` and `progress` are used, the rest is only checked.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_laplacian_new(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    n_held: usize,
    held: *const u32,
    params: *const cata_eigs_params,
    laplacian: *mut *mut cata_laplacian,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `held`,
        // `n_held` elements; `laplacian`, one value).
        let (mesh, held, place) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                slice("held", held, n_held)?,
                output("laplacian", laplacian)?,
            )
        };
        let work = |options: &EigenOptions<'_>, of: &LaplacianOptions| {
            let mut of = of.clone();
            if !held.is_empty() {
                if of.boundary != Boundary::Neumann {
                    let why = "n_held: must be 0 with CATA_BOUNDARY_DIRICHLET";
                    return Err(Failure::new(CATA_ERR_ARGUMENT, why));
                }
                of.boundary = Boundary::Mixed(held.to_vec());
            }
            reported(options.progress, || self::laplacian(&mesh, &of))
        };
        // SAFETY: clause `structs` (`params`).
        let found = unsafe { with_eigen_options(0, params, work) }?;
        hand_over(place, cata_laplacian { found });
        Ok(())
    })
}

/// Computes the Laplacian of the surface that points are samples of: the tufted one of small
/// triangulations around every point.
///
/// - `n`, `points`: 3 doubles each, x, y, z.
/// - `neighbours`: nearest points with which each one is triangulated, at least 3; 0: 30.
/// - `params`: `boundary`, `threads` and `progress` are used, the rest is only checked.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_cloud_laplacian(
    n: usize,
    points: *const f64,
    neighbours: usize,
    params: *const cata_eigs_params,
    laplacian: *mut *mut cata_laplacian,
) -> cata_status {
    boundary(|| {
        let points = points.cast::<[f64; 3]>();
        // SAFETY: clause `memory` (`points`, `3 * n` elements; `laplacian`, one value).
        let (points, place) =
            unsafe { (slice("points", points, n)?, output("laplacian", laplacian)?) };
        let work = |options: &EigenOptions<'_>, of: &LaplacianOptions| {
            let mut how = CloudOptions::new().boundary(of.boundary.clone()).par(of.par);
            if neighbours > 0 {
                how.neighbours = neighbours;
            }
            reported(options.progress, || cloud_laplacian(points, &how))
        };
        // SAFETY: clause `structs` (`params`).
        let found = unsafe { with_eigen_options(0, params, work) }?;
        hand_over(place, cata_laplacian { found });
        Ok(())
    })
}

/// Frees a Laplacian.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_laplacian_free(laplacian: *mut cata_laplacian) {
    // SAFETY: clause `handles` (`laplacian`).
    unsafe { free(laplacian) };
}

/// Gets the numbers of rows, of entries of W, and of numbers of M: one for each row of a diagonal,
/// one for each entry of W with CATA_MASS_CONSISTENT. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_laplacian_size(
    laplacian: *const cata_laplacian,
    rows: *mut usize,
    entries: *mut usize,
    masses: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`rows`, `entries`, `masses`, one value each), clause `handles`
        // (`laplacian`).
        unsafe {
            let found = &known("laplacian", laplacian)?.found;
            let w = &found.stiffness;
            tell!(rows: w.rows(), entries: w.nnz(), masses: masses_of(found).len());
        }
        Ok(())
    })
}

/// Gets W, both triangles, as cata_eigs takes it; NULL where not wanted.
///
/// - `kept`: one element for each row, written: its vertex, ascending.
/// - `row_starts`: rows + 1 elements, written.
/// - `columns`, `w`: one element for each entry, written: columns ascending within a row.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_laplacian_get(
    laplacian: *const cata_laplacian,
    kept: *mut u32,
    row_starts: *mut usize,
    columns: *mut usize,
    w: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`kept`, one element a row; `row_starts`, one more; `columns` and
        // `w`, one element an entry), clause `handles` (`laplacian`).
        unsafe {
            let found = &known("laplacian", laplacian)?.found;
            // A mesh has fewer than 2^32 vertices.
            let vertices: Vec<u32> = found.kept.iter().map(|&v| v as u32).collect();
            let own = &found.stiffness;
            let starts = own.indptr();
            copy_wanted! {
                kept: &vertices,
                row_starts: starts.raw_storage(),
                columns: own.indices(),
                w: own.data(),
            }
        }
        Ok(())
    })
}

/// Gets M, as many numbers as cata_laplacian_size tells: its diagonal, or, with
/// CATA_MASS_CONSISTENT, its entries at the places of those of W.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_laplacian_masses(
    laplacian: *const cata_laplacian,
    masses: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`masses`, one element for each), clause `handles`
        // (`laplacian`).
        unsafe { copy("masses", masses, masses_of(&known("laplacian", laplacian)?.found)) }
    })
}

/// Computes the matrix that takes a function, a value for each vertex, to its gradient, which is
/// constant on faces: rows 3 f to 3 f + 2 are x, y, z in face f. NULL where not wanted.
///
/// - `row_starts`: 3 n_faces + 1 elements, written.
/// - `columns`, `entries`: 9 n_faces elements each, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_laplacian_gradient(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    row_starts: *mut usize,
    columns: *mut usize,
    entries: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face), clause
        // `passed on` (`Csr::new`).
        let (mesh, places) = unsafe {
            let mesh = mesh(n_vertices, vertices, n_faces, faces)?;
            let (rows, count) = (3 * n_faces, 9 * n_faces);
            (mesh, Csr::new(rows, count, row_starts, columns, entries)?)
        };
        places.write(&gradient(&mesh)?);
        Ok(())
    })
}

/// Computes the matrix that takes a field, x, y, z for each face, to its divergence, integrated
/// against the hat function of each vertex: times the gradient it is -W. NULL where not wanted.
///
/// - `row_starts`: n_vertices + 1 elements, written.
/// - `columns`, `entries`: 9 n_faces elements each, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_laplacian_divergence(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    row_starts: *mut usize,
    columns: *mut usize,
    entries: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face), clause
        // `passed on` (`Csr::new`).
        let (mesh, places) = unsafe {
            let mesh = mesh(n_vertices, vertices, n_faces, faces)?;
            let count = 9 * n_faces;
            (mesh, Csr::new(n_vertices, count, row_starts, columns, entries)?)
        };
        places.write(&divergence(&mesh)?);
        Ok(())
    })
}

/// Computes a third of the area of the faces at each vertex: n_vertices elements, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_laplacian_areas(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    areas: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `areas`,
        // `n_vertices` elements).
        let (mesh, areas) = unsafe {
            (mesh(n_vertices, vertices, n_faces, faces)?, slice_mut("areas", areas, n_vertices)?)
        };
        areas.copy_from_slice(&vertex_areas(&mesh));
        Ok(())
    })
}

/// The places for a sparse matrix.
struct Csr<'a> {
    row_starts: Option<&'a mut [usize]>,
    columns: Option<&'a mut [usize]>,
    entries: Option<&'a mut [f64]>,
}

impl<'a> Csr<'a> {
    /// Creates the places for `count` entries.
    ///
    /// # Safety
    /// The pointers are NULL, or have places for so many elements during `'a`.
    unsafe fn new(
        rows: usize,
        count: usize,
        row_starts: *mut usize,
        columns: *mut usize,
        entries: *mut f64,
    ) -> Result<Self, Failure> {
        // SAFETY: clause `memory` (`row_starts`, `rows + 1` elements; `columns`, `count` elements;
        // `entries`, `count` elements).
        unsafe {
            Ok(Self {
                row_starts: optional_slice_mut("row_starts", row_starts, rows + 1)?,
                columns: optional_slice_mut("columns", columns, count)?,
                entries: optional_slice_mut("entries", entries, count)?,
            })
        }
    }

    fn write(self, matrix: &CsMat<f64>) {
        fill_slice(self.row_starts, matrix.indptr().raw_storage());
        fill_slice(self.columns, matrix.indices());
        fill_slice(self.entries, matrix.data());
    }
}

/// Returns the numbers of M: a full one has its entries where W has them.
fn masses_of(laplacian: &Laplacian) -> &[f64] {
    match &laplacian.mass {
        Mass::Lumped(masses) => masses,
        Mass::Full(matrix) => matrix.data(),
    }
}
