//! Measures of inputs and of decimated meshes.

use catamaran::Par;
use catamaran_geometry::decimate::Quality;
use catamaran_geometry::mesh::{Comparison, Components, Edges, Genus, TriMesh};

use crate::Result;

/// The measures of a decimated mesh.
#[derive(Debug, Clone)]
pub struct Measures {
    /// Number of vertices with a face.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
    /// Topology and intersections.
    pub soundness: Soundness,
    /// Uniformity.
    pub quality: Quality,
    /// Distances from the input to the result, and back.
    pub distances: Comparison,
}

impl Measures {
    /// Measures the decimation `made` of `input`; `cgal` as in [`Soundness::of`].
    ///
    /// # Errors
    /// When the result has no face.
    pub fn new(input: &TriMesh, made: &TriMesh, cgal: Option<usize>) -> Result<Self> {
        Ok(Self {
            vertices: made.vertices().len() - made.unreferenced_vertices().len(),
            faces: made.faces().len(),
            soundness: Soundness::of(made, cgal),
            quality: Quality::of(made),
            distances: Comparison::between(input, made, Par::all())?,
        })
    }

    /// Returns the Hausdorff distance: the larger one of both directions.
    pub fn hausdorff(&self) -> f64 {
        self.distances.out.largest.max(self.distances.back.largest)
    }
}

/// The topology of a mesh, and the number of its faces that intersect.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Soundness {
    /// Number of connected components.
    pub components: usize,
    /// Number of boundary loops; `None` with edges of more than two faces.
    pub boundary_loops: Option<usize>,
    /// Number of handles or cross-caps; `None` when the mesh is not a manifold.
    pub genus: Option<Genus>,
    /// Number of edges of more than two faces.
    pub non_manifold_edges: usize,
    /// Faces that intersect others.
    pub intersecting: Intersecting,
}

impl Soundness {
    /// Measures this mesh, in which CGAL counted `cgal` intersecting faces.
    pub fn of(mesh: &TriMesh, cgal: Option<usize>) -> Self {
        let edges = Edges::new(mesh);
        Self {
            components: Components::new(mesh).len(),
            boundary_loops: mesh.boundary_loops(&edges).ok().map(|loops| loops.len()),
            genus: mesh.genus(&edges).ok(),
            non_manifold_edges: edges.non_manifold().count(),
            intersecting: Intersecting { ours: mesh.intersecting_faces(Par::all()).len(), cgal },
        }
    }

    /// Returns the columns of [`line`](Self::line), each after `prefix`.
    pub fn header(prefix: &str) -> String {
        let names = [
            "components",
            "boundary_loops",
            "genus",
            "non_manifold_edges",
            "intersecting_faces",
            "intersecting_faces_cgal",
        ];
        names.map(|name| format!("{prefix}{name}")).join(",")
    }

    /// Returns a line of a record; unknown values are empty.
    pub fn line(&self) -> String {
        let Self { components, boundary_loops, genus, non_manifold_edges, intersecting } = self;
        format!(
            "{components},{},{},{non_manifold_edges},{},{}",
            text(boundary_loops, ""),
            text(genus, ""),
            intersecting.ours,
            text(&intersecting.cgal, "")
        )
    }

    /// Returns whether components, boundary loops and genus are those of `other`; `None` when
    /// `other` is not a manifold.
    pub fn is_topology_of(&self, other: &Self) -> Option<bool> {
        other.genus?;
        let of = |it: &Self| (it.components, it.boundary_loops, it.genus);
        Some(of(self) == of(other))
    }
}

/// Returns the value as text, or `none` if it is missing.
pub(super) fn text(value: &Option<impl ToString>, none: &str) -> String {
    value.as_ref().map_or_else(|| none.to_owned(), ToString::to_string)
}

/// Numbers of faces that intersect others of their mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Intersecting {
    /// Counted by this library.
    pub ours: usize,
    /// Counted by CGAL; `None` where that is not installed.
    pub cgal: Option<usize>,
}

impl Intersecting {
    /// Returns how many more there are than in `input`, by CGAL where it counted both.
    pub fn more_than(&self, input: &Self) -> usize {
        let [now, before] = match (self.cgal, input.cgal) {
            (Some(now), Some(before)) => [now, before],
            _ => [self.ours, input.ours],
        };
        now.saturating_sub(before)
    }
}

impl std::fmt::Display for Intersecting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.cgal {
            Some(cgal) if cgal != self.ours => write!(f, "{} (CGAL: {cgal})", self.ours),
            _ => write!(f, "{}", self.ours),
        }
    }
}

#[cfg(test)]
mod tests {
    use catamaran_geometry::mesh::families;

    use super::*;

    #[test]
    fn topology_is_compared_and_recorded() {
        let sphere = Soundness::of(&families::icosphere(1).unwrap(), None);
        let square = Soundness::of(&families::grid(2, 2).unwrap(), Some(3));
        assert_eq!(sphere.line(), "1,0,0,0,0,");
        assert_eq!(square.line(), "1,1,0,0,0,3");
        assert_eq!(Soundness::header("x_").split(',').count(), square.line().split(',').count());
        assert_eq!(sphere.is_topology_of(&sphere), Some(true));
        assert_eq!(sphere.is_topology_of(&square), Some(false));
        // Three faces at one edge.
        let points =
            [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]];
        let book = TriMesh::new(points.to_vec(), vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]).unwrap();
        let book = Soundness::of(&book, None);
        assert_eq!(book.line(), "1,,,1,0,");
        assert_eq!(sphere.is_topology_of(&book), None);
    }

    #[test]
    fn intersections_are_compared_by_one_oracle() {
        let found = |ours, cgal| Intersecting { ours, cgal };
        assert_eq!(found(5, Some(9)).more_than(&found(2, Some(3))), 6);
        assert_eq!(found(5, Some(9)).more_than(&found(2, None)), 3);
        assert_eq!(found(1, None).more_than(&found(2, None)), 0);
    }
}
