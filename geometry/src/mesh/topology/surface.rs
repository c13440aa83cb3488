use std::fmt;

use super::super::TriMesh;
use super::{Components, Edges};
use catamaran::base::{Error, Result};

/// The genus of a surface with its boundary loops closed by disks, summed over its components.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Genus {
    /// The genus of an orientable surface: the number of its handles.
    Orientable(usize),
    /// The genus of a surface with a component that is not orientable: the number of its
    /// cross-caps, where a handle counts as two.
    NonOrientable(usize),
}

impl fmt::Display for Genus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Orientable(genus) => write!(f, "{genus}"),
            Self::NonOrientable(genus) => write!(f, "{genus} (not orientable)"),
        }
    }
}

impl TriMesh {
    /// Returns the Euler characteristic V - E + F, where V does not count vertices without a face.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Edges, families};
    ///
    /// let torus = families::torus(12, 6, 2.0, 0.5)?;
    /// assert_eq!(torus.euler_characteristic(&Edges::new(&torus)), 0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn euler_characteristic(&self, edges: &Edges) -> i64 {
        let edges = &*edges.of(self);
        let used = self.referenced().into_iter().filter(|&used| used).count();
        used as i64 - edges.len() as i64 + self.faces().len() as i64
    }

    /// Returns the genus g, from the Euler characteristic V - E + F = sum over components of 2 - 2
    /// g - (boundary loops), or of 2 - g - (boundary loops) when not orientable.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Edges, Genus, families};
    ///
    /// let torus = families::torus(12, 6, 2.0, 0.5)?;
    /// assert_eq!(torus.genus(&Edges::new(&torus))?, Genus::Orientable(1));
    /// let strip = families::moebius(12, 2)?;
    /// assert_eq!(strip.genus(&Edges::new(&strip))?, Genus::NonOrientable(1));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Mesh`] names an edge of more than two faces, or a vertex at which the surface meets
    /// itself.
    pub fn genus(&self, edges: &Edges) -> Result<Genus> {
        let edges = &*edges.of(self);
        edges.require_manifold()?;
        if let Some(v) = self.fans(edges).into_iter().position(|fans| fans > 1) {
            return Err(meets_itself(v));
        }
        let loops = self.boundary_loops(edges)?.len();
        let components = Components::new(self).len();
        let orientable = self.flips(edges).is_ok();
        Ok(genus_of(self.euler_characteristic(edges), components, loops, orientable))
    }

    /// Returns an error unless the mesh is a manifold, with or without boundary: every edge has one
    /// or two faces, and the faces at every vertex are connected over edges.
    ///
    /// ```
    /// use catamaran_geometry::mesh::families;
    ///
    /// assert!(families::grid(2, 2)?.require_manifold().is_ok());
    /// assert!(families::bow_tie()?.require_manifold().is_err());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Mesh`] names the first edge or vertex at which the mesh is not a manifold.
    pub fn require_manifold(&self) -> Result<()> {
        let edges = Edges::new(self);
        edges.require_manifold()?;
        match self.fans(&edges).into_iter().position(|fans| fans > 1) {
            None => Ok(()),
            Some(v) => Err(meets_itself(v)),
        }
    }

    /// Returns an error unless every edge has two faces.
    ///
    /// ```
    /// use catamaran_geometry::mesh::families;
    ///
    /// assert!(families::icosphere(0)?.require_closed().is_ok());
    /// assert!(families::grid(1, 1)?.require_closed().is_err());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Mesh`] names the first edge that does not have two faces.
    pub fn require_closed(&self) -> Result<()> {
        let edges = Edges::new(self);
        edges.require_manifold()?;
        match edges.boundary().next() {
            None => Ok(()),
            Some(e) => Err(Error::Mesh {
                what: format!(
                    "is on the boundary: its only face is {}",
                    edges.corners().row(e as usize)[0] / 3
                ),
                element: edges.name(e as usize),
            }),
        }
    }
}

fn meets_itself(vertex: usize) -> Error {
    Error::Mesh {
        what: "the surface meets itself in this vertex".into(),
        element: format!("vertex {vertex}"),
    }
}

/// Returns the genus of a manifold with these counts.
pub(in super::super) fn genus_of(
    euler: i64,
    components: usize,
    loops: usize,
    orientable: bool,
) -> Genus {
    // Never negative: with its loops closed, the characteristic of a component is at most 2.
    let caps = (2 * components as i64 - loops as i64 - euler).max(0) as usize;
    if orientable { Genus::Orientable(caps / 2) } else { Genus::NonOrientable(caps) }
}
