//! The matrices of a Laplacian, and the vertices to which their rows belong.

use faer::{Mat, MatRef};
use sprs::CsMat;

use catamaran::base::{Error, Result};
use catamaran::sparse::{Mass, select};

/// The matrices of the eigenproblem `W phi = lambda M phi`: the stiffness W and the mass M. The
/// rows belong to the vertices in [`Laplacian::kept`]; those of [`laplacian_rows`] to some of them.
///
/// [`laplacian_rows`]: super::laplacian_rows
#[derive(Debug, Clone, PartialEq)]
pub struct Laplacian {
    /// W: symmetric, positive semi-definite, by rows, both triangles, a diagonal entry in every
    /// row. An entry off the diagonal is minus the weight of its edge: half the sum of the opposite
    /// cotangents. `W 1 = 0` up to rounding (Neumann).
    pub stiffness: CsMat<f64>,
    /// M: positive definite; its entries sum to the area (Neumann).
    pub mass: Mass,
    /// The vertices to which the rows belong, ascending: all vertices except those that the
    /// boundary conditions hold at zero, and those in no face, which have no area.
    pub kept: Vec<usize>,
    /// The number of vertices of the mesh.
    pub vertices: usize,
}

impl Laplacian {
    /// Returns functions on the mesh (one row a vertex, one column a function) from functions on
    /// the rows of the matrices; they are zero at vertices without a row.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Boundary, LaplacianOptions, families, laplacian};
    /// use faer::Mat;
    ///
    /// let square = families::grid(4, 4)?;
    /// let clamped = laplacian(&square, &LaplacianOptions::new().boundary(Boundary::Dirichlet))?;
    /// let inside = Mat::from_fn(clamped.kept.len(), 1, |_, _| 1.0);
    /// let all = clamped.extend(inside.as_ref())?;
    /// assert_eq!((all.nrows(), all[(0, 0)], all[(12, 0)]), (25, 0.0, 1.0));
    /// assert_eq!(clamped.restrict(all.as_ref())?, inside);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] unless `functions` has one row for each vertex kept.
    pub fn extend(&self, functions: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let columns = functions.ncols();
        let expected = (self.kept.len(), columns);
        Error::check_shape("functions", expected, (functions.nrows(), columns))?;
        let mut extended = Mat::zeros(self.vertices, columns);
        for j in 0..columns {
            for (row, &vertex) in self.kept.iter().enumerate() {
                extended[(vertex, j)] = functions[(row, j)];
            }
        }
        Ok(extended)
    }

    /// Returns the Laplacian with Dirichlet conditions at all vertices outside the mask: only rows
    /// and columns of vertices in the mask are kept.
    ///
    /// ```
    /// use catamaran_geometry::prelude::*;
    /// use catamaran_geometry::mesh::families;
    ///
    /// let mesh = families::icosphere(3)?;
    /// let north: Vec<bool> = mesh.vertices().iter().map(|p| p[2] > 1e-9).collect();
    /// let half = laplacian(&mesh, &LaplacianOptions::new())?.restricted(&north)?;
    /// let pairs = eigs(half.stiffness.view(), &half.mass, &EigenOptions::new().k(1))?;
    /// assert!((pairs.values[0] - 2.0).abs() < 0.05); // of the function z
    /// // The function is zero on the other half.
    /// let functions = half.extend(pairs.vectors.as_ref())?;
    /// assert!(north.iter().enumerate().all(|(v, &kept)| kept || functions[(v, 0)] == 0.0));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] unless the mask has an entry for each vertex of the mesh, and the matrices
    /// all rows.
    pub fn restricted(&self, mask: &[bool]) -> Result<Self> {
        Error::check_shape("mask", (self.vertices, 1), (mask.len(), 1))?;
        let all = self.kept.len();
        Error::check_shape("stiffness", (all, all), self.stiffness.shape())?;
        let all = &self.kept;
        let kept: Vec<usize> = (0..all.len()).filter(|&row| mask[all[row]]).collect();
        let mut rows = vec![None; all.len()];
        for (row, &old) in kept.iter().enumerate() {
            rows[old] = Some(row);
        }
        let mass = match &self.mass {
            Mass::Lumped(all) => Mass::Lumped(kept.iter().map(|&row| all[row]).collect()),
            Mass::Full(matrix) => Mass::Full(select(matrix.view(), &kept, &rows, kept.len())),
        };
        Ok(Self {
            stiffness: select(self.stiffness.view(), &kept, &rows, kept.len()),
            mass,
            kept: kept.iter().map(|&row| all[row]).collect(),
            vertices: self.vertices,
        })
    }

    /// Returns the rows of functions on the mesh (one row a vertex) that belong to kept vertices.
    /// The inverse of [`Laplacian::extend`], whose example shows both.
    ///
    /// # Errors
    /// [`Error::Shape`] unless `functions` has one row for each vertex of the mesh.
    pub fn restrict(&self, functions: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let columns = functions.ncols();
        let expected = (self.vertices, columns);
        Error::check_shape("functions", expected, (functions.nrows(), columns))?;
        Ok(Mat::from_fn(self.kept.len(), columns, |row, j| functions[(self.kept[row], j)]))
    }
}
