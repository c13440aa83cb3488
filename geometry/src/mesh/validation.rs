//! The validation report of a mesh: its counts and its problems.

use std::fmt;

use super::TriMesh;
use super::io::MeshFile;
use super::repair::{Seams, inside_out, near_points};
use super::topology::{Adjacency, Components, Edges, Genus, face_list, genus_of};
use super::vector::distance;

/// A defect that some algorithms can't handle, with the element that has it.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Problem {
    /// There is no face, and thus no surface.
    NoFace {
        /// The number of vertices.
        vertices: usize,
    },
    /// Faces of a file or of arrays that have a vertex twice. They are left out of the mesh, so
    /// that the numbers of other problems do not count them.
    CollapsedFaces {
        /// Their number.
        count: usize,
        /// The place of the first one, such as `line 12` or `face 4`.
        first: String,
    },
    /// No face has this vertex.
    UnreferencedVertex(u32),
    /// An edge with three faces or more.
    NonManifoldEdge {
        /// The vertices of the edge.
        ends: [u32; 2],
        /// The faces of the edge.
        faces: Vec<u32>,
    },
    /// A vertex whose faces are not connected over edges at this vertex: the surface meets itself
    /// in a point.
    NonManifoldVertex {
        /// The vertex.
        vertex: u32,
        /// The number of groups of faces there.
        fans: u32,
    },
    /// A face with the same vertices as an earlier face, in any order.
    RepeatedFace {
        /// The later face.
        face: u32,
        /// The first face with these vertices.
        first: u32,
    },
    /// A face without area ([`TriMesh::faces_without_area`]).
    ZeroArea(u32),
    /// An edge along which both faces run in the same direction, so that they disagree about which
    /// side is outside.
    Inconsistent {
        /// The vertices of the edge.
        ends: [u32; 2],
        /// The faces of the edge.
        faces: [u32; 2],
    },
    /// A closed component that is inside out, by its lowest face: from outside, all its faces are
    /// seen clockwise. Where it lies in an odd number of other closed components, it bounds a
    /// cavity, and its outside is within.
    InsideOut(u32),
    /// A vertex on the boundary that belongs together with another one there, as in a soup of
    /// triangles: they are in one place along a seam, where exactly two boundary edges coincide, or
    /// nearly in one place, at less than a thousandth of the lengths of their edges.
    CoincidentVertex {
        /// The vertex.
        vertex: u32,
        /// The first vertex there.
        first: u32,
    },
    /// A face that shares no edge with another face and has no coincident vertex, in a mesh of
    /// several faces.
    LooseFace(u32),
    /// The faces can't be flipped so that all agree; `why` names an edge.
    NotOrientable {
        /// The edge and its faces.
        why: String,
    },
}

impl Problem {
    /// Returns the kind of the problem in a few words, such as "faces without area".
    pub fn kind(&self) -> &'static str {
        match self {
            Self::NoFace { .. } => "no faces",
            Self::CollapsedFaces { .. } => "faces that have a vertex twice",
            Self::UnreferencedVertex(_) => "vertices without a face",
            Self::NonManifoldEdge { .. } => "edges with more than two faces",
            Self::NonManifoldVertex { .. } => "vertices at which the surface meets itself",
            Self::RepeatedFace { .. } => "repeated faces",
            Self::ZeroArea(_) => "faces without area",
            Self::Inconsistent { .. } => "edges whose faces run the same way",
            Self::InsideOut(_) => "closed components that are inside out",
            Self::CoincidentVertex { .. } => "boundary vertices that coincide with others",
            Self::LooseFace(_) => "faces that share no edge with others",
            Self::NotOrientable { .. } => "not orientable",
        }
    }

    /// Returns how many elements have the problem.
    fn count(&self) -> usize {
        match self {
            Self::CollapsedFaces { count, .. } => *count,
            _ => 1,
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFace { vertices } => write!(f, "a mesh of {vertices} vertices"),
            Self::CollapsedFaces { count: 1, first } => write!(f, "left out, at {first}"),
            Self::CollapsedFaces { first, .. } => write!(f, "left out, the first at {first}"),
            Self::UnreferencedVertex(vertex) => write!(f, "vertex {vertex}"),
            Self::NonManifoldEdge { ends: [a, b], faces } => {
                write!(f, "edge {a}-{b} of {}", face_list(faces.iter().copied()))
            }
            Self::NonManifoldVertex { vertex, fans } => {
                write!(f, "vertex {vertex} of {fans} groups of faces")
            }
            Self::RepeatedFace { face, first } => write!(f, "face {face} as face {first}"),
            Self::ZeroArea(face) => write!(f, "face {face}"),
            Self::Inconsistent { ends: [a, b], faces: [s, t] } => {
                write!(f, "edge {a}-{b} of faces {s} and {t}")
            }
            Self::InsideOut(face) => write!(f, "that of face {face}"),
            Self::CoincidentVertex { vertex, first } => {
                write!(f, "vertex {vertex} as vertex {first}")
            }
            Self::LooseFace(face) => write!(f, "face {face}"),
            Self::NotOrientable { why } => f.write_str(why),
        }
    }
}

/// The validation report of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of faces.
    pub faces: usize,
    /// Number of connected components ([`Components`]).
    pub components: usize,
    /// Number of edges with one face.
    pub boundary_edges: usize,
    /// Number of boundary loops; `None` when they are undefined because of non-manifold edges.
    pub boundary_loops: Option<usize>,
    /// V - E + F, V without vertices that no face has.
    pub euler_characteristic: i64,
    /// The genus; `None` when the mesh is not a manifold.
    pub genus: Option<Genus>,
    /// The problems, by kind, then by element in ascending order.
    pub problems: Vec<Problem>,
}

impl Validation {
    /// Returns whether every edge has two faces or more.
    pub fn is_closed(&self) -> bool {
        self.boundary_edges == 0
    }

    /// Returns the problems by kind; kinds without a problem are left out.
    fn groups(&self) -> impl Iterator<Item = &[Problem]> {
        self.problems.chunk_by(|a, b| a.kind() == b.kind())
    }
}

impl fmt::Display for Validation {
    /// Writes the counts, then for each kind of problem its number and its first elements, without
    /// a newline at the end.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 5;
        let Self { vertices, edges, faces, components, .. } = self;
        let unknown = || "undefined (not a manifold)".to_owned();
        writeln!(f, "vertices    {vertices}")?;
        writeln!(f, "edges       {edges}, {} on the boundary", self.boundary_edges)?;
        writeln!(f, "faces       {faces}")?;
        writeln!(f, "components  {components}")?;
        let loops = self.boundary_loops.map_or_else(unknown, |loops| loops.to_string());
        writeln!(f, "loops       {loops}")?;
        writeln!(f, "Euler       {}", self.euler_characteristic)?;
        let genus = self.genus.map_or_else(unknown, |genus| genus.to_string());
        write!(f, "genus       {genus}")?;
        if self.problems.is_empty() {
            return write!(f, "\nproblems    none");
        }
        for group in self.groups() {
            let shown: Vec<_> = group.iter().take(SHOWN).map(Problem::to_string).collect();
            let more = if group.len() > SHOWN { "; ..." } else { "" };
            let list = shown.join("; ");
            let count: usize = group.iter().map(Problem::count).sum();
            write!(f, "\nproblem     {}: {count} ({list}{more})", group[0].kind())?;
        }
        Ok(())
    }
}

impl MeshFile {
    /// Checks the mesh as [`TriMesh::validate`] does. Faces that have a vertex twice, which are
    /// left out of the mesh, are the first problem of the report.
    ///
    /// ```
    /// use catamaran_geometry::mesh::io::MeshFile;
    ///
    /// let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let report = MeshFile::from_arrays(vertices, vec![[0, 1, 2], [2, 1, 1]])?.validate();
    /// assert_eq!(report.faces, 1);
    /// let line = "faces that have a vertex twice: 1 (left out, at face 1)";
    /// assert!(report.to_string().ends_with(line));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn validate(&self) -> Validation {
        let mut report = self.mesh.validate();
        if self.collapsed_faces > 0 {
            let (count, first) = (self.collapsed_faces, self.first_collapsed.clone());
            report.problems.insert(0, Problem::CollapsedFaces { count, first });
        }
        report
    }
}

impl TriMesh {
    /// Checks the mesh for every [`Problem`], and counts vertices, edges, faces, components and
    /// boundary loops. No face of a mesh has a vertex twice: [`MeshFile::validate`] tells how many
    /// of its file have.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Problem, TriMesh};
    ///
    /// let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], vec![[0, 1, 2]])?;
    /// let report = mesh.validate();
    /// assert_eq!((report.edges, report.boundary_loops), (3, Some(1)));
    /// assert!(matches!(report.problems[..], [Problem::ZeroArea(0)]));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn validate(&self) -> Validation {
        let edges = Edges::new(self);
        let fans = self.fans(&edges);
        let flips = self.flips(&edges);
        let components = Components::new(self).len();
        let loops = self.boundary_loops(&edges).ok().map(|loops| loops.len());
        let euler_characteristic = self.euler_characteristic(&edges);

        let mut problems = Vec::new();
        problems.extend(self.unreferenced_vertices().into_iter().map(Problem::UnreferencedVertex));
        problems.extend(edges.non_manifold().map(|e| Problem::NonManifoldEdge {
            ends: edges.ends()[e as usize],
            faces: edges.faces(e as usize).collect(),
        }));
        problems.extend(
            (0..)
                .zip(&fans)
                .filter(|(_, fans)| **fans > 1)
                .map(|(vertex, &fans)| Problem::NonManifoldVertex { vertex, fans }),
        );
        let manifold = !problems.iter().any(|p| !matches!(p, Problem::UnreferencedVertex(_)));
        if self.faces().is_empty() {
            problems.push(Problem::NoFace { vertices: self.vertices().len() });
        }
        problems.extend(
            self.repeated_faces()
                .into_iter()
                .map(|[face, first]| Problem::RepeatedFace { face, first }),
        );
        problems.extend(self.faces_without_area().into_iter().map(Problem::ZeroArea));
        problems.extend(self.inconsistent_edges(&edges).into_iter().filter_map(|e| {
            let &[a, b] = edges.corners().row(e as usize) else { return None };
            let ends = edges.ends()[e as usize];
            Some(Problem::Inconsistent { ends, faces: [a / 3, b / 3] })
        }));
        problems.extend(inside_out(self, &edges).into_iter().map(Problem::InsideOut));
        let seams = Seams::of(self);
        let coincident = self.coincident_vertices(&edges, &seams);
        let loose = self.loose_faces(&edges, &seams, &coincident);
        let coincident = coincident.into_iter();
        problems
            .extend(coincident.map(|[vertex, first]| Problem::CoincidentVertex { vertex, first }));
        problems.extend(loose.into_iter().map(Problem::LooseFace));
        let orientable = flips.is_ok();
        if let Err(error) = flips {
            problems.push(Problem::NotOrientable { why: error.to_string() });
        }
        let genus = loops
            .filter(|_| manifold)
            .map(|loops| genus_of(euler_characteristic, components, loops, orientable));
        Validation {
            vertices: self.vertices().len(),
            edges: edges.len(),
            faces: self.faces().len(),
            components,
            boundary_edges: edges.boundary().count(),
            boundary_loops: loops,
            euler_characteristic,
            genus,
            problems,
        }
    }

    /// Returns the vertices on the boundary that belong together with others there, each with the
    /// first of these; ascending.
    fn coincident_vertices(&self, edges: &Edges, seams: &Seams) -> Vec<[u32; 2]> {
        let along_seams = (0..).zip(&seams.to).map(|(v, &to)| [v, to]).filter(|[v, to]| v != to);
        let mut found: Vec<[u32; 2]> = along_seams.chain(self.near_vertices(edges)).collect();
        found.sort_unstable();
        found.dedup_by_key(|[vertex, _]| *vertex);
        found
    }

    /// Returns the vertices on the boundary that are near an earlier one there, measured by the
    /// shortest edge of each of the two ([`near_points`]), but not in its place: the same place may
    /// be that of a cut. Vertices that an edge joins are not near each other.
    fn near_vertices(&self, edges: &Edges) -> Vec<[u32; 2]> {
        let place = |v: u32| self.vertices()[v as usize];
        let mut shortest = vec![f64::INFINITY; self.vertices().len()];
        for &[a, b] in edges.ends() {
            let length = distance(place(a), place(b));
            for v in [a, b] {
                shortest[v as usize] = shortest[v as usize].min(length);
            }
        }
        let mut boundary: Vec<u32> =
            edges.boundary().flat_map(|e| edges.ends()[e as usize]).collect();
        boundary.sort_unstable();
        boundary.dedup();
        let points: Vec<_> = boundary.iter().map(|&v| place(v)).collect();
        let lengths: Vec<_> = boundary.iter().map(|&v| shortest[v as usize]).collect();
        let pairs = near_points(&points, &lengths).into_iter();
        pairs.map(|pair| pair.map(|i| boundary[i as usize])).collect()
    }

    /// Returns the faces that share no edge with another face, and have no vertex of `coincident`,
    /// if there are several faces. Faces along a cut, where more than two edges are in one place,
    /// are no loose ones.
    fn loose_faces(&self, edges: &Edges, seams: &Seams, coincident: &[[u32; 2]]) -> Vec<u32> {
        if self.faces().len() < 2 {
            return Vec::new();
        }
        let mut is_known = vec![false; self.vertices().len()];
        coincident.as_flattened().iter().for_each(|&v| is_known[v as usize] = true);
        let mut is_cut = vec![false; edges.len()];
        seams.ambiguous.iter().for_each(|&e| is_cut[e as usize] = true);
        let is_loose = |face: &u32| {
            let mut own = (3 * face..3 * face + 3).map(|c| edges.of_corners()[c as usize] as usize);
            let corners = self.faces()[*face as usize];
            own.all(|e| edges.corners().row(e).len() == 1 && !is_cut[e])
                && !corners.iter().any(|&v| is_known[v as usize])
        };
        (0..self.faces().len() as u32).filter(is_loose).collect()
    }

    /// Returns the faces that have the vertices of an earlier face, in any order, each with the
    /// first face of these vertices; ascending.
    ///
    /// ```
    /// use catamaran_geometry::mesh::TriMesh;
    ///
    /// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = TriMesh::new(corners, vec![[0, 1, 2], [2, 1, 0]])?;
    /// assert_eq!(mesh.repeated_faces(), [[1, 0]]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn repeated_faces(&self) -> Vec<[u32; 2]> {
        let by_lowest = Adjacency::from_pairs(self.vertices().len(), || {
            let lowest = |&[a, b, c]: &[u32; 3]| a.min(b).min(c);
            self.faces().iter().zip(0..).map(move |(face, f)| (lowest(face), f))
        });
        let mut repeated = Vec::new();
        let mut keys: Vec<([u32; 3], u32)> = Vec::new();
        for row in by_lowest.rows() {
            keys.clear();
            keys.extend(row.iter().map(|&f| {
                let mut face = self.faces()[f as usize];
                face.sort_unstable();
                (face, f)
            }));
            keys.sort_unstable();
            for group in keys.chunk_by(|a, b| a.0 == b.0) {
                repeated.extend(group[1..].iter().map(|(_, face)| [*face, group[0].1]));
            }
        }
        repeated.sort_unstable();
        repeated
    }
}
