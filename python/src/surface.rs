//! A mesh that a spectrum is taken of: its vertices welded on request, and what its caller should
//! know of its components.

use catamaran::faer::{Mat, MatRef};
use catamaran::sparse::Mass;
use catamaran_geometry::mesh::{
    Boundary, Components, RepairOptions, TriMesh, Weld, free_components, repair,
};
use pyo3::prelude::*;

use crate::error::exception;
use crate::mesh::mesh;

/// What a warning says of a mesh: its components, those that are not held at zero anywhere, those
/// that are left where vertices with equal positions are joined, its vertices in no face, and its
/// faces that repeat another.
pub type Pieces = (usize, usize, usize, usize, usize);

/// A mesh, and the vertices of the caller.
pub struct Surface {
    pub mesh: TriMesh,
    /// For each vertex of the caller, its vertex of the mesh; `None` where they are the same.
    joined: Option<Vec<u32>>,
}

impl Surface {
    /// Returns the mesh of two arrays; with `weld`, vertices with equal positions are one.
    pub fn new(v: &Bound<'_, PyAny>, f: &Bound<'_, PyAny>, weld: bool) -> PyResult<Self> {
        let mesh = mesh(v, f)?;
        match weld {
            true => welded(mesh).map_err(exception),
            false => Ok(Self { mesh, joined: None }),
        }
    }

    /// Returns the number of vertices of the caller.
    pub fn vertices(&self) -> usize {
        self.joined.as_ref().map_or(self.mesh.vertices().len(), Vec::len)
    }

    /// Returns the boundary, whose vertices are those of the caller, on the mesh.
    pub fn boundary(&self, boundary: Boundary) -> Boundary {
        let (Boundary::Mixed(vertices), Some(joined)) = (&boundary, &self.joined) else {
            return boundary;
        };
        // The mesh has fewer vertices, so that a vertex that is out of range stays so.
        let on_mesh = |&v: &u32| joined.get(v as usize).copied().unwrap_or(v);
        Boundary::Mixed(vertices.iter().map(on_mesh).collect())
    }

    /// Counts the components of the mesh.
    pub fn pieces(&self, boundary: &Boundary) -> catamaran::Result<Pieces> {
        let count = Components::new(&self.mesh).len();
        let free = free_components(&self.mesh, boundary)?;
        let left = match count > 1 && self.joined.is_none() {
            true => Components::new(&welded(self.mesh.clone())?.mesh).len(),
            false => count,
        };
        let alone = self.mesh.unreferenced_vertices().len();
        Ok((count, free, left, alone, self.mesh.repeated_faces().len()))
    }

    /// Functions on the vertices of the caller from those on the mesh.
    pub fn extend(&self, functions: Mat<f64>) -> Mat<f64> {
        match &self.joined {
            None => functions,
            Some(joined) => rows(functions.as_ref(), joined),
        }
    }

    /// Returns the masses at the vertices of the caller: equal shares of that of their vertex of
    /// the mesh, so that inner products of functions of [`Surface::extend`] stay the same.
    pub fn shares(&self, mass: Mass) -> Mass {
        let (Some(joined), Mass::Lumped(masses)) = (&self.joined, &mass) else { return mass };
        let mut copies = vec![0.0; masses.len()];
        joined.iter().for_each(|&v| copies[v as usize] += 1.0);
        Mass::Lumped(joined.iter().map(|&v| masses[v as usize] / copies[v as usize]).collect())
    }

    /// Returns a function from a vertex of the mesh to the first vertex of the caller there.
    pub fn firsts(&self) -> impl Fn(usize) -> usize {
        let firsts = self.joined.as_ref().map(|joined| {
            let mut firsts = vec![0; self.mesh.vertices().len()];
            (0..joined.len()).rev().for_each(|v| firsts[joined[v] as usize] = v);
            firsts
        });
        move |vertex| firsts.as_ref().map_or(vertex, |firsts| firsts[vertex])
    }
}

fn welded(mesh: TriMesh) -> catamaran::Result<Surface> {
    let found = repair(mesh.into(), &RepairOptions::new().weld(Weld::Exact))?;
    Ok(Surface { mesh: found.file.mesh, joined: found.vertices })
}

fn rows(functions: MatRef<'_, f64>, chosen: &[u32]) -> Mat<f64> {
    Mat::from_fn(chosen.len(), functions.ncols(), |i, j| functions[(chosen[i] as usize, j)])
}
