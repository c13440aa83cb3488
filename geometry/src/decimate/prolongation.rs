//! Interpolation of functions from the new mesh to the input.

use std::borrow::Cow;

use sprs::CsMat;

use super::cells::Cells;
use super::closest::on_surface;
use super::result::Decimation;
use super::surface::Surface;
use crate::mesh::TriMesh;
use catamaran::base::{Error, Par, Result};

/// Number of vertices that one thread takes at a time.
const BLOCK: usize = 4096;

impl Decimation {
    /// Computes the matrix that takes functions on the new mesh to the input, one row for each
    /// vertex of the input, one column for each of the new mesh: the barycentric coordinates of the
    /// nearest point, which is found by walking from the vertex of its cell. A row has at most
    /// three entries, which are positive and sum to 1; rows of vertices without a face are empty.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_geometry::{decimate::{DecimateOptions, decimate}, mesh::families};
    ///
    /// let sphere = families::icosphere(2)?;
    /// let found = decimate(&sphere, 60, &DecimateOptions::new())?;
    /// let weights = found.weights(&sphere, Par::Seq)?;
    /// assert_eq!(weights.shape(), (162, 60));
    /// for row in weights.outer_iterator() {
    ///     assert!((row.data().iter().sum::<f64>() - 1.0).abs() < 1e-12);
    /// }
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] when the numbers of vertices of `input` and of the decimated mesh differ,
    /// [`Error::OutOfMemory`].
    pub fn weights(&self, input: &TriMesh, par: Par) -> Result<CsMat<f64>> {
        let rows = input.vertices().len();
        let cells = self.cells.of_vertices();
        Error::check_shape("input", (cells.len(), 3), (rows, 3))?;
        let surface = Surface::of_edges(Cow::Borrowed(&self.mesh), par)?;
        let blocks = par.map_blocks(rows, BLOCK, |range| {
            range.map(|v| row(&surface, cells[v], input.vertices()[v])).collect::<Vec<_>>()
        });
        let mut starts = vec![0];
        let (mut columns, mut values) = (Vec::new(), Vec::new());
        for row in blocks.into_iter().flatten() {
            for (column, value) in row {
                if value > 0.0 {
                    columns.push(column as usize);
                    values.push(value);
                }
            }
            starts.push(columns.len());
        }
        Ok(CsMat::new((rows, self.mesh.vertices().len()), starts, columns, values))
    }
}

/// Returns columns and values of a row, in the order of columns.
fn row(surface: &Surface<'_>, cell: u32, p: [f64; 3]) -> [(u32, f64); 3] {
    let nothing = [(0, 0.0); 3];
    if cell == Cells::NONE {
        return nothing;
    }
    let Some(found) = on_surface(surface, cell, p) else {
        // A vertex without a face in the new mesh, which only the method of the thesis leaves.
        return [(cell, 1.0), (0, 0.0), (0, 0.0)];
    };
    let corners = surface.mesh.faces()[found.place.face as usize];
    let mut row = [0, 1, 2].map(|k| (corners[k], found.place.weights[k]));
    row.sort_unstable_by_key(|entry| entry.0);
    row
}
