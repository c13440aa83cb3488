//! Texture coordinates and colours carried over.

use std::borrow::Cow;

use super::closest::on_surface;
use super::result::{Decimation, Place};
use super::surface::Surface;
use crate::base::{Error, Par, Result};
use crate::mesh::TriMesh;
use crate::mesh::io::{Attribute, MeshFile};
use crate::mesh::topology::Sets;
use crate::mesh::vector::{Vector, cross, dot, sub};

impl Decimation {
    /// The new mesh as a file with the colours and texture coordinates that the input has: those at the places of its vertices.
    /// Where a texture is cut, each new face takes the side that its middle is on. Normals are left out.
    ///
    /// ```
    /// use catamaran::decimate::{DecimateOptions, decimate};
    /// use catamaran::mesh::{families, io::MeshFile};
    ///
    /// let mut sphere = MeshFile::from(families::icosphere(3)?);
    /// sphere.colors = Some(vec![[1.0, 0.5, 0.0, 1.0]; sphere.mesh.vertices().len()]);
    /// let found = decimate(&sphere.mesh, 100, &DecimateOptions::new())?.carry(&sphere)?;
    /// assert_eq!(found.colors, Some(vec![[1.0, 0.5, 0.0, 1.0]; 100]));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] when `input` is not of the mesh that was decimated.
    pub fn carry(&self, input: &MeshFile) -> Result<MeshFile> {
        let vertices = input.mesh.vertices().len();
        Error::check_shape("input", (self.cells.of_vertices().len(), 3), (vertices, 3))?;
        if let Some(place) =
            self.places.iter().find(|p| p.face as usize >= input.mesh.faces().len())
        {
            let faces = input.mesh.faces().len();
            return Err(Error::Shape {
                what: "input",
                expected: (place.face as usize + 1, 3),
                got: (faces, 3),
            });
        }
        let mut file = MeshFile::from(self.mesh.clone());
        if let Some(colors) = &input.colors {
            Error::check_shape("colors", (vertices, 4), (colors.len(), 4))?;
            let at = |place: &Place| {
                let corners = input.mesh.faces()[place.face as usize];
                let given = corners.map(|v| colors[v as usize]);
                let color = mean(given, place.weights);
                // Rounded beyond 1, it would be read as one from 0 to 255.
                std::array::from_fn(|k| {
                    let [a, b, c] = given.map(|color| color[k]);
                    color[k].max(a.min(b).min(c)).min(a.max(b).max(c))
                })
            };
            file.colors = Some(self.places.iter().map(at).collect());
        }
        if let Some(uv) = &input.uv {
            file.uv = Some(match uv.of_vertices() {
                Some(_) => self.of_vertices(uv, &input.mesh)?,
                None => self.of_corners(uv, &input.mesh)?,
            });
        }
        Ok(file)
    }

    fn of_vertices(&self, uv: &Attribute<2>, input: &TriMesh) -> Result<Attribute<2>> {
        let at = |place: &Place| {
            let corners = uv.of_face(input, place.face as usize);
            corners.map(|corners| mean(corners, place.weights)).ok_or(Error::Shape {
                what: "uv",
                expected: (input.vertices().len(), 2),
                got: (uv.values.len(), 2),
            })
        };
        let values = self.places.iter().map(at).collect::<Result<_>>()?;
        Ok(Attribute { values, corners: None })
    }

    fn of_corners(&self, uv: &Attribute<2>, input: &TriMesh) -> Result<Attribute<2>> {
        let surface = Surface::of_edges(Cow::Borrowed(input), Par::Seq)?;
        let charts = charts(uv, input);
        let mut values: Vec<[f64; 2]> = Vec::new();
        // For each vertex the values that its corners have so far.
        let mut known: Vec<Vec<u32>> = vec![Vec::new(); self.mesh.vertices().len()];
        let mut corners = Vec::with_capacity(self.mesh.faces().len());
        for face in self.mesh.faces() {
            let points = face.map(|v| self.mesh.vertices()[v as usize]);
            let middle: Vector = std::array::from_fn(|k| points.iter().map(|p| p[k] / 3.0).sum());
            let start = self.places[face[0] as usize];
            let found = on_surface(&surface, input.faces()[start.face as usize][0], middle);
            let home = found.map_or(start.face, |found| found.place.face);
            let Some(at_home) = uv.of_face(input, home as usize) else {
                corners.push([Attribute::<2>::ABSENT; 3]);
                continue;
            };
            corners.push([0, 1, 2].map(|k| {
                let v = face[k] as usize;
                let place = self.places[v];
                let same_chart = charts[place.face as usize] == charts[home as usize];
                let own = uv.of_face(input, place.face as usize).filter(|_| same_chart);
                let value = match own {
                    Some(own) => mean(own, place.weights),
                    None => mean(at_home, weights_in_plane(input, home, points[k])),
                };
                let mut of_vertex = known[v].iter().copied();
                of_vertex.find(|&i| values[i as usize] == value).unwrap_or_else(|| {
                    values.push(value);
                    known[v].push(values.len() as u32 - 1);
                    values.len() as u32 - 1
                })
            }));
        }
        Ok(Attribute { values, corners: Some(corners) })
    }
}

/// For each face a number of its chart: faces with a common value are in the same one.
fn charts(uv: &Attribute<2>, input: &TriMesh) -> Vec<u32> {
    let numbers = uv.corners.as_deref().unwrap_or(input.faces());
    let mut sets = Sets::new(uv.values.len());
    let present = |corners: &[u32; 3]| corners.iter().all(|&i| (i as usize) < uv.values.len());
    for corners in numbers.iter().filter(|corners| present(corners)) {
        sets.join(corners[0], corners[1]);
        sets.join(corners[1], corners[2]);
    }
    let chart =
        |corners: &[u32; 3]| if present(corners) { sets.find(corners[0]) } else { u32::MAX };
    numbers.iter().map(chart).collect()
}

fn mean<const N: usize>(values: [[f64; N]; 3], weights: [f64; 3]) -> [f64; N] {
    std::array::from_fn(|k| (0..3).map(|i| weights[i] * values[i][k]).sum())
}

/// Barycentric coordinates of p in the plane of a face, also beyond the face; its first corner where it has no area.
fn weights_in_plane(mesh: &TriMesh, face: u32, p: Vector) -> [f64; 3] {
    let [a, b, c] = mesh.faces()[face as usize].map(|v| mesh.vertices()[v as usize]);
    let normal = cross(sub(b, a), sub(c, a));
    let square = dot(normal, normal);
    let v = dot(cross(sub(p, a), sub(c, a)), normal) / square;
    let w = dot(cross(sub(b, a), sub(p, a)), normal) / square;
    if v.is_finite() && w.is_finite() { [1.0 - v - w, v, w] } else { [1.0, 0.0, 0.0] }
}
