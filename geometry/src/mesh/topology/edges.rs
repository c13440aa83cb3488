use std::borrow::Cow;

use super::super::TriMesh;
use super::adjacency::Adjacency;
use catamaran::base::{Error, Result};

/// The edges of a mesh, sorted by their lower vertex, then by the other one, and numbered from 0 in
/// this order.
///
/// ```
/// use catamaran_geometry::mesh::{Edges, families};
///
/// let edges = Edges::new(&families::grid(1, 1)?);
/// assert_eq!(edges.len(), 5);
/// assert_eq!(edges.boundary().count(), 4);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Edges {
    ends: Vec<[u32; 2]>,
    corners: Adjacency,
    of_corner: Vec<u32>,
    /// The faces of the mesh, which identify it.
    mesh_faces: Vec<[u32; 3]>,
}

impl Edges {
    /// Finds the edges of `mesh`.
    pub fn new(mesh: &TriMesh) -> Self {
        let faces = mesh.faces();
        let end = |corner: u32| {
            let [f, i] = [corner as usize / 3, corner as usize % 3];
            [faces[f][i], faces[f][(i + 1) % 3]]
        };
        // Corners are grouped by the lower end of their edge, then sorted by the other end.
        let count = 3 * faces.len() as u32;
        let by_lower = Adjacency::from_pairs(mesh.vertices().len(), || {
            (0..count).map(|corner| (end(corner).into_iter().min().unwrap_or(0), corner))
        });
        let mut ends = Vec::with_capacity(count as usize / 2 + 1);
        let mut starts = Vec::with_capacity(count as usize / 2 + 2);
        let mut items = Vec::with_capacity(count as usize);
        let mut of_corner = vec![0; count as usize];
        let mut at_vertex: Vec<(u32, u32)> = Vec::new();
        for (lower, row) in by_lower.rows().enumerate() {
            let lower = lower as u32;
            at_vertex.clear();
            at_vertex.extend(row.iter().map(|&corner| {
                let [a, b] = end(corner);
                (a.max(b), corner)
            }));
            at_vertex.sort_unstable();
            for &(upper, corner) in &at_vertex {
                if ends.last() != Some(&[lower, upper]) {
                    ends.push([lower, upper]);
                    starts.push(items.len() as u32);
                }
                of_corner[corner as usize] = ends.len() as u32 - 1;
                items.push(corner);
            }
        }
        starts.push(items.len() as u32);
        Self {
            ends,
            corners: Adjacency::from_parts(starts, items),
            of_corner,
            mesh_faces: faces.to_vec(),
        }
    }

    /// Returns `self` if these are the edges of `mesh`; otherwise finds the edges of `mesh`.
    pub(super) fn of<'a>(&'a self, mesh: &TriMesh) -> Cow<'a, Self> {
        if self.mesh_faces == mesh.faces() {
            Cow::Borrowed(self)
        } else {
            Cow::Owned(Self::new(mesh))
        }
    }

    /// Returns the number of edges.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns whether there are no edges.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Returns the vertices of each edge, the lower number first.
    pub fn ends(&self) -> &[[u32; 2]] {
        &self.ends
    }

    /// Returns for each edge the corners (3 f + i, ascending) at which it starts in its faces.
    pub fn corners(&self) -> &Adjacency {
        &self.corners
    }

    /// Returns the faces of edge e, ascending.
    pub fn faces(&self, e: usize) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.corners.row(e).iter().map(|corner| corner / 3)
    }

    /// Returns for each corner 3 f + i the edge from corner i of face f to the next one.
    pub fn of_corners(&self) -> &[u32] {
        &self.of_corner
    }

    /// Returns for each face the faces across its edges, ascending by corner, then by face.
    pub fn face_neighbors(&self) -> Adjacency {
        let pairs = || {
            (0..).zip(&self.of_corner).flat_map(|(corner, &e)| {
                let others = self.corners.row(e as usize).iter().filter(move |&&c| c != corner);
                others.map(move |other| (corner / 3, other / 3))
            })
        };
        Adjacency::from_pairs(self.of_corner.len() / 3, pairs)
    }

    /// Returns the edges with one face.
    pub fn boundary(&self) -> impl Iterator<Item = u32> + '_ {
        self.with(|faces| faces == 1)
    }

    /// Returns the edges with three faces or more.
    pub fn non_manifold(&self) -> impl Iterator<Item = u32> + '_ {
        self.with(|faces| faces > 2)
    }

    fn with(&self, wanted: impl Fn(usize) -> bool) -> impl Iterator<Item = u32> {
        (0..).zip(self.corners.rows()).filter(move |(_, row)| wanted(row.len())).map(|(e, _)| e)
    }

    /// Returns the name of the edge in errors and reports.
    pub fn name(&self, e: usize) -> String {
        match self.ends.get(e) {
            Some([a, b]) => format!("edge {a}-{b}"),
            None => format!("edge number {e}"),
        }
    }

    /// Returns an error unless every edge has one or two faces.
    ///
    /// # Errors
    /// [`Error::Mesh`] names the first edge with another number of faces, and the faces.
    pub fn require_manifold(&self) -> Result<()> {
        match self.non_manifold().next() {
            None => Ok(()),
            Some(e) => Err(Error::Mesh {
                what: format!("has {}, not one or two", face_list(self.faces(e as usize))),
                element: self.name(e as usize),
            }),
        }
    }
}

/// Returns a text such as "3 faces (1, 5, 7)", shortened for many faces.
pub(in super::super) fn face_list(faces: impl ExactSizeIterator<Item = u32>) -> String {
    const SHOWN: usize = 6;
    let count = faces.len();
    let numbers: Vec<_> = faces.take(SHOWN).map(|f| f.to_string()).collect();
    let more = if count > SHOWN { ", ..." } else { "" };
    format!("{count} faces ({}{more})", numbers.join(", "))
}
