use std::ops::Range;

use sprs::CsMat;

use super::super::{Components, Edges, TriMesh};
use super::matrices::Laplacian;
use super::options::Boundary;
use catamaran::base::{Error, Result};
use catamaran::sparse::{Mass, select};

/// Counts the eigenvalues zero of the Laplacian of a mesh: one for each connected component
/// ([`Components`]) without a vertex that is held at zero. Under [`Boundary::Neumann`] these are
/// all components, under [`Boundary::Dirichlet`] the closed ones.
///
/// ```
/// use catamaran_geometry::mesh::{Boundary, families, free_components};
///
/// let spheres = families::spheres(3, 1)?;
/// assert_eq!(free_components(&spheres, &Boundary::Neumann)?, 3);
/// // The first sphere has the vertices 0 to 41.
/// assert_eq!(free_components(&spheres, &Boundary::Mixed(vec![0, 1]))?, 2);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Mesh`] for a vertex of [`Boundary::Mixed`] that does not exist.
pub fn free_components(mesh: &TriMesh, boundary: &Boundary) -> Result<usize> {
    let components = Components::new(mesh);
    let mut free = vec![true; components.len()];
    for (&component, removed) in components.of_vertices().iter().zip(removed(mesh, boundary)?) {
        // A vertex without a face is removed, too, but belongs to no component.
        if removed && let Some(free) = free.get_mut(component as usize) {
            *free = false;
        }
    }
    Ok(free.into_iter().filter(|free| *free).count())
}

/// Returns which vertices have no row: those held at zero, and those in no face.
fn removed(mesh: &TriMesh, boundary: &Boundary) -> Result<Vec<bool>> {
    let n = mesh.vertices().len();
    let mut removed = vec![false; n];
    for v in mesh.unreferenced_vertices() {
        removed[v as usize] = true;
    }
    match boundary {
        Boundary::Neumann => {}
        Boundary::Dirichlet => {
            let edges = Edges::new(mesh);
            for v in edges.boundary().flat_map(|e| edges.ends()[e as usize]) {
                removed[v as usize] = true;
            }
        }
        Boundary::Mixed(vertices) => {
            for &v in vertices {
                *removed.get_mut(v as usize).ok_or_else(|| Error::Mesh {
                    what: format!("is out of range: {n} vertices, numbered from 0"),
                    element: format!("vertex {v}"),
                })? = true;
            }
        }
    }
    Ok(removed)
}

/// Which vertices have rows, ascending.
pub(super) struct Places {
    pub kept: Vec<usize>,
    vertices: usize,
}

impl Places {
    /// # Errors
    /// Those of [`free_components`].
    pub fn new(mesh: &TriMesh, boundary: &Boundary) -> Result<Self> {
        let removed = removed(mesh, boundary)?;
        let kept = (0..removed.len()).filter(|&v| !removed[v]).collect();
        Ok(Self { kept, vertices: removed.len() })
    }

    /// Returns the shortest range of vertices with those of these rows.
    pub fn vertices(&self, rows: Range<usize>) -> Range<usize> {
        match self.kept[rows].split_first() {
            None => 0..0,
            Some((&first, others)) => first..others.last().unwrap_or(&first) + 1,
        }
    }

    /// Returns the Laplacian of the rows and columns of kept vertices, of which these rows are
    /// among those of the matrices, the rows of the vertices from `first` on.
    pub fn restrict(
        self,
        stiffness: CsMat<f64>,
        mass: Mass,
        first: usize,
        rows: Range<usize>,
    ) -> Result<Laplacian> {
        let Self { kept, vertices } = self;
        let own: Vec<usize> = kept[rows.clone()].iter().map(|&v| v - first).collect();
        let (stiffness, mass) = if kept.len() == vertices {
            (stiffness, mass)
        } else {
            let mut places = vec![None; vertices];
            for (place, &v) in kept.iter().enumerate() {
                places[v] = Some(place);
            }
            let mass = match mass {
                Mass::Lumped(all) => Mass::Lumped(own.iter().map(|&v| all[v]).collect()),
                Mass::Full(matrix) => Mass::Full(select(matrix.view(), &own, &places, kept.len())),
            };
            (select(stiffness.view(), &own, &places, kept.len()), mass)
        };
        check(&stiffness, &mass, &kept[rows])?;
        Ok(Laplacian { stiffness, mass, kept, vertices })
    }
}

/// Returns an error unless all entries are finite: sums of finite numbers can overflow, and
/// products of tiny ones can vanish.
fn check(stiffness: &CsMat<f64>, mass: &Mass, kept: &[usize]) -> Result<()> {
    let culprit = |row: usize, what: &str| {
        Err(Error::Mesh { what: what.into(), element: format!("vertex {}", kept[row]) })
    };
    for (row, entries) in stiffness.outer_iterator().enumerate() {
        if entries.data().iter().any(|w| !w.is_finite()) {
            return culprit(row, "its weights are not finite");
        }
    }
    let sound = |m: f64| m > 0.0 && m.is_finite();
    let wrong = match mass {
        Mass::Lumped(all) => all.iter().position(|&m| !sound(m)),
        Mass::Full(matrix) => {
            matrix.outer_iterator().position(|row| !row.data().iter().all(|&m| sound(m)))
        }
    };
    match wrong {
        Some(row) => culprit(row, "its mass is not a positive finite number"),
        None => Ok(()),
    }
}
