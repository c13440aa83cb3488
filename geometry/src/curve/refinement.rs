use std::borrow::Cow;
use std::collections::HashMap;

use crate::mesh::vector::Vector;
use crate::mesh::{Adjacency, Origin, Refined, TriMesh};
use catamaran::base::{Error, Result};

/// A mesh with cuts of edges and faces at points, which are stored separately: the cost is that of
/// the cuts only.
pub(super) struct Refinement<'m> {
    mesh: Cow<'m, TriMesh>,
    /// The faces of each vertex of the mesh; created by the first cut.
    vertex_faces: Option<Adjacency>,
    /// Positions of the new vertices, whose indices follow those of the mesh.
    positions: Vec<Vector>,
    /// Origins of the new vertices on the mesh.
    origins: Vec<Origin>,
    /// New faces, whose indices follow those of the mesh.
    faces: Vec<[u32; 3]>,
    /// For each new face, the face of the mesh that contains it.
    roots: Vec<u32>,
    /// For each face that was cut, its pieces.
    cut: HashMap<u32, Vec<u32>>,
    /// The faces of each vertex that has other faces than in the mesh.
    changed: HashMap<u32, Vec<u32>>,
}

impl<'m> Refinement<'m> {
    /// Creates a refinement without cuts.
    pub fn new(mesh: Cow<'m, TriMesh>) -> Self {
        Self {
            mesh,
            vertex_faces: None,
            positions: Vec::new(),
            origins: Vec::new(),
            faces: Vec::new(),
            roots: Vec::new(),
            cut: HashMap::new(),
            changed: HashMap::new(),
        }
    }

    /// Returns the mesh that is refined.
    pub fn mesh(&self) -> &TriMesh {
        &self.mesh
    }

    /// Returns the positions of the new vertices.
    pub fn positions(&self) -> &[Vector] {
        &self.positions
    }

    /// Returns the position of a vertex.
    pub fn position(&self, vertex: u32) -> Vector {
        let old = self.mesh.vertices();
        match (vertex as usize).checked_sub(old.len()) {
            None => old[vertex as usize],
            Some(new) => self.positions[new],
        }
    }

    /// Returns the corners of a face.
    pub fn face(&self, face: u32) -> [u32; 3] {
        let old = self.mesh.faces();
        match (face as usize).checked_sub(old.len()) {
            None => old[face as usize],
            Some(new) => self.faces[new],
        }
    }

    /// Returns the vertices that share a face with this one, ascending.
    pub fn neighbours(&mut self, vertex: u32) -> Vec<u32> {
        let faces = self.faces_of(vertex).clone();
        let others = faces.iter().flat_map(|&f| self.face(f)).filter(|&u| u != vertex);
        let mut others: Vec<u32> = others.collect();
        others.sort_unstable();
        others.dedup();
        others
    }

    /// Cuts an edge, and each of its faces in two, at the point `at` of the edge, which is at this
    /// share of the way from a to b. Returns the new vertex, and the vertices whose neighbours
    /// changed.
    ///
    /// # Errors
    /// [`Error::Argument`] when vertices or faces can't be numbered any more.
    pub fn cut_edge(
        &mut self,
        [a, b]: [u32; 2],
        share: f64,
        at: Vector,
    ) -> Result<(u32, Vec<u32>)> {
        let origin = Origin::between(&[(self.origin(a), 1.0 - share), (self.origin(b), share)]);
        let new = self.add_vertex(at, origin)?;
        let mut around = vec![a, b, new];
        for f in self.faces_of(a).clone() {
            let face = self.face(f);
            if face.contains(&b) {
                let with = |old: u32| face.map(|v| if v == old { new } else { v });
                self.replace(f, &[with(b), with(a)]);
                around.extend(face.into_iter().filter(|&v| v != a && v != b));
            }
        }
        Ok((new, around))
    }

    /// Cuts an edge in its middle, as [`Refinement::cut_edge`] does.
    ///
    /// # Errors
    /// Those of [`Refinement::cut_edge`].
    pub fn bisect(&mut self, ends: [u32; 2]) -> Result<(u32, Vec<u32>)> {
        let [p, q] = ends.map(|v| self.position(v));
        // Halves do not overflow where the sum would.
        self.cut_edge(ends, 0.5, std::array::from_fn(|k| p[k] / 2.0 + q[k] / 2.0))
    }

    /// Cuts a face into three at a point inside, which has these shares of its corners. Returns the
    /// new vertex.
    ///
    /// # Errors
    /// [`Error::Argument`] when vertices or faces can't be numbered any more.
    pub fn cut_face(&mut self, face: u32, at: Vector, weights: [f64; 3]) -> Result<u32> {
        let [a, b, c] = self.face(face);
        let corner = |v, weight| (self.origin(v), weight);
        let [x, y, z] = weights;
        let origin = Origin::between(&[corner(a, x), corner(b, y), corner(c, z)]);
        let new = self.add_vertex(at, origin)?;
        self.replace(face, &[[a, b, new], [b, c, new], [c, a, new]]);
        Ok(new)
    }

    /// Returns the pieces of a face: those of its faces that were not cut.
    pub fn pieces(&self, face: u32) -> impl Iterator<Item = u32> {
        let mut waiting = vec![face];
        std::iter::from_fn(move || {
            while let Some(f) = waiting.pop() {
                match self.cut.get(&f) {
                    None => return Some(f),
                    Some(pieces) => waiting.extend(pieces),
                }
            }
            None
        })
    }

    /// Returns the refined mesh: the vertices of the mesh, then the new ones in the order in which
    /// they came.
    ///
    /// # Errors
    /// None that a refinement could cause.
    pub fn to_mesh(&self) -> Result<Refined> {
        let vertices = [self.mesh.vertices(), &self.positions].concat();
        let all = self.mesh.faces().iter().chain(&self.faces);
        let kept = (0..).zip(all).filter(|(f, _)| !self.cut.contains_key(f));
        let (roots, faces) = kept.map(|(f, &face)| (self.root(f), face)).unzip();
        let old = (0..self.mesh.vertices().len() as u32).map(Origin::vertex);
        let origins = old.chain(self.origins.iter().copied()).collect();
        Ok(Refined { mesh: TriMesh::new(vertices, faces)?, faces: roots, vertices: origins })
    }

    /// Removes all cuts.
    pub fn forget(&mut self) {
        self.positions.clear();
        self.origins.clear();
        self.faces.clear();
        self.roots.clear();
        self.cut.clear();
        self.changed.clear();
    }

    fn add_vertex(&mut self, at: Vector, origin: Origin) -> Result<u32> {
        let number = self.mesh.vertices().len() + self.positions.len();
        let faces = self.mesh.faces().len() + self.faces.len();
        // Every cut makes a few faces; with this many more they can be numbered.
        if number >= u32::MAX as usize || faces > u32::MAX as usize / 2 {
            let why = "too many vertices or faces to add a point to".to_owned();
            return Err(Error::Argument { what: "mesh", why });
        }
        self.positions.push(at);
        self.origins.push(origin);
        self.changed.insert(number as u32, Vec::new());
        Ok(number as u32)
    }

    /// Returns the origin of a vertex on the mesh.
    pub fn origin(&self, vertex: u32) -> Origin {
        match (vertex as usize).checked_sub(self.mesh.vertices().len()) {
            None => Origin::vertex(vertex),
            Some(new) => self.origins[new],
        }
    }

    /// Returns the face of the mesh that contains a face.
    fn root(&self, face: u32) -> u32 {
        match (face as usize).checked_sub(self.mesh.faces().len()) {
            None => face,
            Some(new) => self.roots[new],
        }
    }

    /// Returns the faces of a vertex, which are stored here from now on.
    fn faces_of(&mut self, vertex: u32) -> &mut Vec<u32> {
        let (mesh, all) = (&self.mesh, &mut self.vertex_faces);
        self.changed.entry(vertex).or_insert_with(|| {
            let all = all.get_or_insert_with(|| mesh.vertex_faces());
            all.row(vertex as usize).to_vec()
        })
    }

    fn replace(&mut self, face: u32, pieces: &[[u32; 3]]) {
        for v in self.face(face) {
            self.faces_of(v).retain(|&f| f != face);
        }
        let mut numbers = Vec::new();
        let root = self.root(face);
        for &piece in pieces {
            let number = (self.mesh.faces().len() + self.faces.len()) as u32;
            self.faces.push(piece);
            self.roots.push(root);
            numbers.push(number);
            for v in piece {
                self.faces_of(v).push(number);
            }
        }
        self.cut.insert(face, numbers);
    }
}
