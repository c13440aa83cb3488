//! Replaces the faces and vertices of a mesh, and carries over its attributes.

use std::collections::HashMap;

use super::super::io::{Attribute, Labels, MeshFile};
use super::super::vector::bits;
use super::super::{Part, TriMesh, has_corner_twice};
use catamaran::base::{Result, Sets};

/// Marks a vertex that was left out.
pub(super) const NONE: u32 = u32::MAX;

/// The result of a step: the origin of each vertex and corner of the new mesh.
pub(super) struct Rebuild {
    /// For each new vertex, the old one whose position and colour it has.
    pub vertices: Vec<u32>,
    pub faces: Vec<[u32; 3]>,
    /// For each new face, the corners whose values its corners have: old corners (3 f + i), or,
    /// from their number on, the insertions in their order.
    pub corners: Vec<[u32; 3]>,
    pub insertions: Vec<Insertion>,
    /// For each old vertex, the new one that it joined; `None` when no vertices were joined.
    pub joined: Option<Vec<u32>>,
}

/// A corner that is inserted on an edge of another face. The corners below are numbered as in
/// [`Rebuild::corners`], and are old ones or earlier insertions.
pub(super) struct Insertion {
    /// The corners at the ends of the edge and at the vertex, in the face that had the vertex.
    pub from: [u32; 3],
    /// The corners at the ends of the edge, in the face on the other side.
    pub on: [u32; 2],
    /// The position on the edge: 0 at its first end, 1 at its second one.
    pub at: f64,
}

/// Returns the three corners of face f.
pub(super) fn corners_of(f: u32) -> [u32; 3] {
    [3 * f, 3 * f + 1, 3 * f + 2]
}

impl Rebuild {
    /// Returns a rebuild that keeps some faces and all vertices.
    pub fn of_faces(mesh: &TriMesh, kept: &[bool]) -> Self {
        let own = (0..).zip(mesh.faces().iter().zip(kept)).filter(|(_, (_, kept))| **kept);
        let (corners, faces) = own.map(|(f, (face, _))| (corners_of(f), *face)).unzip();
        let vertices = (0..mesh.vertices().len() as u32).collect();
        Self { vertices, faces, corners, insertions: Vec::new(), joined: None }
    }

    /// Returns a rebuild to a part of the mesh.
    pub fn of_part(part: Part) -> Self {
        let (_, faces) = part.mesh.into_parts();
        let corners = part.faces.iter().map(|&f| corners_of(f)).collect();
        Self { vertices: part.vertices, faces, corners, insertions: Vec::new(), joined: None }
    }

    /// Returns a rebuild that moves each vertex v to vertex `to[v]`, which stays; faces that lose a
    /// corner are left out.
    pub fn joining(mesh: &TriMesh, to: Vec<u32>) -> Self {
        let all = (0..mesh.faces().len() as u32).map(corners_of).collect();
        Self::joined(mesh.faces().to_vec(), all, Vec::new(), to)
    }

    /// Returns a rebuild that joins vertices, with the given faces and their corners.
    pub fn joined(
        faces: Vec<[u32; 3]>,
        corners: Vec<[u32; 3]>,
        insertions: Vec<Insertion>,
        to: Vec<u32>,
    ) -> Self {
        let mut number = vec![NONE; to.len()];
        let mut vertices = Vec::new();
        for (v, _) in (0..).zip(&to).filter(|&(v, &to)| v == to) {
            number[v as usize] = vertices.len() as u32;
            vertices.push(v);
        }
        let joined: Vec<u32> = to.iter().map(|&v| number[v as usize]).collect();
        let mut new = Self { vertices, faces: vec![], corners: vec![], insertions, joined: None };
        for (face, corners) in faces.iter().zip(corners) {
            let face = face.map(|v| joined[v as usize]);
            if !has_corner_twice(&face) {
                new.faces.push(face);
                new.corners.push(corners);
            }
        }
        new.joined = Some(joined);
        new
    }

    /// Returns the new vertex of each of `count` old vertices; `None` when the numbering does not
    /// change.
    pub fn renumbering(&self, count: usize) -> Option<Vec<u32>> {
        if self.vertices.len() == count && self.vertices.iter().zip(0..).all(|(&v, new)| v == new) {
            return None;
        }
        if let Some(joined) = &self.joined {
            return Some(joined.clone());
        }
        let mut numbers = vec![NONE; count];
        for (&v, new) in self.vertices.iter().zip(0..) {
            // The lowest of several vertices that come from one.
            let number = &mut numbers[v as usize];
            *number = new.min(*number);
        }
        Some(numbers)
    }

    /// Returns the number of vertices that joined a vertex of another colour.
    pub fn lost_colors(&self, file: &MeshFile) -> usize {
        let (Some(colors), Some(joined)) = (&file.colors, &self.joined) else { return 0 };
        let stays = |new: u32| colors[self.vertices[new as usize] as usize];
        joined.iter().zip(colors).filter(|&(&new, color)| *color != stays(new)).count()
    }

    /// Turns `file` into the new mesh, with the attributes of the old one.
    ///
    /// # Errors
    /// [`Error::Argument`](catamaran::Error::Argument) for more vertices or corners than indices
    /// can number.
    pub fn apply(self, file: &mut MeshFile) -> Result<()> {
        let points = file.mesh.vertices();
        let positions = self.vertices.iter().map(|&v| points[v as usize]).collect();
        let mesh = TriMesh::new(positions, self.faces.clone())?;
        file.uv = file.uv.as_ref().map(|uv| self.values(uv, &file.mesh, &mesh));
        file.normals = file.normals.as_ref().map(|values| self.values(values, &file.mesh, &mesh));
        if let Some(colors) = &mut file.colors {
            *colors = self.vertices.iter().map(|&v| colors[v as usize]).collect();
        }
        for scalars in &mut file.scalars {
            *scalars = scalars.at(&self.vertices);
        }
        let old_corners = 3 * file.mesh.faces().len();
        for labels in [&mut file.materials, &mut file.groups, &mut file.objects] {
            let Some(Labels { of_faces, .. }) = labels else { continue };
            let origins = self.corners.iter().map(|&[first, ..]| self.face_of(first, old_corners));
            *of_faces = origins.map(|f| of_faces[f]).collect();
        }
        file.mesh = mesh;
        Ok(())
    }

    /// Returns the old face to which a corner belongs, or into which it was inserted.
    fn face_of(&self, corner: u32, old_corners: usize) -> usize {
        let mut corner = corner as usize;
        while corner >= old_corners {
            corner = self.insertions[corner - old_corners].from[2] as usize;
        }
        corner / 3
    }

    fn values<const N: usize>(
        &self,
        given: &Attribute<N>,
        old: &TriMesh,
        mesh: &TriMesh,
    ) -> Attribute<N> {
        let absent = Attribute::<N>::ABSENT;
        let mut numbers = given.corners.as_deref().unwrap_or(old.faces()).as_flattened().to_vec();
        let mut values = given.values.clone();
        for insertion in &self.insertions {
            let [a, b, c] = insertion.from.map(|corner| numbers[corner as usize]);
            let on = insertion.on.map(|corner| numbers[corner as usize]);
            let there = |i: u32| values.get(i as usize).copied();
            let continuous = same(there(a), there(on[0])) && same(there(b), there(on[1]));
            numbers.push(match on.map(there) {
                // The edge is no seam of the attribute.
                _ if continuous => c,
                [Some(p), Some(q)] => {
                    let t = insertion.at;
                    values.push(std::array::from_fn(|k| (1.0 - t) * p[k] + t * q[k]));
                    values.len() as u32 - 1
                }
                _ => absent,
            });
        }
        let mut corners: Vec<[u32; 3]> =
            self.corners.iter().map(|c| c.map(|corner| numbers[corner as usize])).collect();
        for face in corners.iter_mut().filter(|face| face.contains(&absent)) {
            *face = [absent; 3];
        }
        if given.corners.is_none() {
            let own: Vec<[f64; N]> =
                self.vertices.iter().map(|&v| given.values[v as usize]).collect();
            let fits = |(&v, &i): (&u32, &u32)| {
                same(own.get(v as usize).copied(), values.get(i as usize).copied())
            };
            if mesh.faces().as_flattened().iter().zip(corners.as_flattened()).all(fits) {
                return Attribute { values: own, corners: None };
            }
        }
        unify(&values, &mut corners, mesh);
        used(&values, corners, mesh)
    }
}

/// Returns whether two values are equal; two absent values are equal.
fn same<const N: usize>(a: Option<[f64; N]>, b: Option<[f64; N]>) -> bool {
    a.map(bits) == b.map(bits)
}

/// Gives corners with equal values at one vertex the same index: their faces are on the same side
/// of a seam.
fn unify<const N: usize>(values: &[[f64; N]], corners: &mut [[u32; 3]], mesh: &TriMesh) {
    let mut sets = Sets::new(values.len());
    let mut first: HashMap<(u32, [u64; N]), u32> = HashMap::new();
    for (&v, &i) in mesh.faces().as_flattened().iter().zip(corners.as_flattened()) {
        if let Some(&value) = values.get(i as usize) {
            sets.join(i, *first.entry((v, bits(value))).or_insert(i));
        }
    }
    for i in corners.as_flattened_mut().iter_mut().filter(|i| (**i as usize) < values.len()) {
        *i = sets.find(*i);
    }
}

/// Returns an attribute with only the values that the corners use, in their order.
fn used<const N: usize>(
    values: &[[f64; N]],
    mut corners: Vec<[u32; 3]>,
    mesh: &TriMesh,
) -> Attribute<N> {
    let absent = Attribute::<N>::ABSENT;
    let mut number = vec![absent; values.len()];
    for &i in corners.as_flattened().iter().filter(|i| **i != absent) {
        number[i as usize] = 0;
    }
    let mut kept = Vec::new();
    for (number, value) in number.iter_mut().zip(values).filter(|(n, _)| **n == 0) {
        *number = kept.len() as u32;
        kept.push(*value);
    }
    for i in corners.as_flattened_mut().iter_mut().filter(|i| **i != absent) {
        *i = number[*i as usize];
    }
    Attribute::simplified(kept, corners, mesh)
}
