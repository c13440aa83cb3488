//! Carries attributes of the input over to the new mesh.
//!
//! Colours are interpolated at the points of the input nearest to the new vertices. Each new face
//! has a home, the face of the input nearest to its middle: its labels and its side of texture
//! seams are those of its home.

mod charts;
mod frame;
mod home;
mod texture;

use std::borrow::Cow;

use self::home::{Home, homes};
use super::result::Decimation;
use super::surface::Surface;
use crate::mesh::io::{Labels, MeshFile, Scalars};
use crate::mesh::{SurfacePoint, TriMesh};
use catamaran::base::{Error, Par, Result};

impl Decimation {
    /// Returns the new mesh as a file with the attributes of `input`, except for those that
    /// [`left_out`](Self::left_out) names.
    ///
    /// - Colours and scalars are those at the places of the vertices.
    /// - Materials, groups and objects of a face are those of the input's face nearest to its
    ///   middle.
    /// - Texture coordinates come from the chart of that face. A corner beyond the chart has those
    ///   of the chart's nearest point. A face that would be turned over by that, or stretched more
    ///   than threefold, continues the texture of its face of the input in its plane.
    ///
    /// ```
    /// use catamaran_geometry::decimate::{DecimateOptions, decimate};
    /// use catamaran_geometry::mesh::{families, io::MeshFile};
    ///
    /// let mut sphere = MeshFile::from(families::icosphere(3)?);
    /// sphere.colors = Some(vec![[1.0, 0.5, 0.0, 1.0]; sphere.mesh.vertices().len()]);
    /// let found = decimate(&sphere.mesh, 100, &DecimateOptions::new())?.carry(&sphere)?;
    /// assert_eq!(found.colors, Some(vec![[1.0, 0.5, 0.0, 1.0]; 100]));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] when `input` is not the mesh that was decimated; [`Error::Shape`] and
    /// [`Error::Argument`] when its attributes do not fit it.
    pub fn carry(&self, input: &MeshFile) -> Result<MeshFile> {
        self.check_input(input)?;
        let mut file = MeshFile::from(self.mesh.clone());
        file.colors = input.colors.as_ref().map(|colors| self.colors(colors, input));
        for Scalars { name, values } in &input.scalars {
            let values = self.carry_values(&input.mesh, 1, values)?;
            file.scalars.push(Scalars { name: name.clone(), values });
        }
        file.material_files = input.material_files.clone();
        let labels = [&input.materials, &input.groups, &input.objects];
        if input.uv.is_none() && labels.iter().all(|labels| labels.is_none()) {
            return Ok(file);
        }
        let surface = Surface::of_edges(Cow::Borrowed(&input.mesh), Par::Seq)?;
        let homes = homes(self, &surface);
        file.uv = input.uv.as_ref().map(|uv| texture::carried(self, &input.mesh, uv, &homes));
        [file.materials, file.groups, file.objects] =
            labels.map(|labels| labels.as_ref().map(|labels| at_homes(labels, &homes)));
        Ok(file)
    }

    /// Returns the values at the new vertices of functions that are linear on the faces of `input`.
    /// `values` holds `width` numbers for each vertex of `input`, one vertex after the other.
    ///
    /// ```
    /// use catamaran_geometry::{decimate::{DecimateOptions, decimate}, mesh::families};
    ///
    /// let sphere = families::icosphere(3)?;
    /// let heights: Vec<f64> = sphere.vertices().iter().map(|p| p[2]).collect();
    /// let found = decimate(&sphere, 100, &DecimateOptions::new())?;
    /// let carried = found.carry_values(&sphere, 1, &heights)?;
    /// assert!(found.mesh.vertices().iter().zip(&carried).all(|(p, z)| (p[2] - z).abs() < 0.05));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] when `input` is not the mesh that was decimated, or `values` does not hold
    /// `width` numbers for each vertex.
    pub fn carry_values(&self, input: &TriMesh, width: usize, values: &[f64]) -> Result<Vec<f64>> {
        self.check_mesh(input)?;
        let vertices = input.vertices().len();
        if Some(values.len()) != vertices.checked_mul(width) {
            let (expected, got) = ((vertices, width), (values.len(), 1));
            return Err(Error::Shape { what: "values", expected, got });
        }
        let mut carried = Vec::with_capacity(self.places.len() * width);
        for place in &self.places {
            let corners = input.faces()[place.face as usize].map(|v| v as usize * width);
            carried.extend(
                (0..width).map(|k| place.interpolate(corners.map(|at| [values[at + k]]))[0]),
            );
        }
        Ok(carried)
    }

    /// Returns the attributes of a file that [`carry`](Self::carry) leaves out, in plain words;
    /// empty if all are carried over.
    ///
    /// ```
    /// use catamaran_geometry::decimate::Decimation;
    /// use catamaran_geometry::mesh::{families, io::{Attribute, MeshFile}};
    ///
    /// let mut sphere = MeshFile::from(families::icosphere(1)?);
    /// assert!(Decimation::left_out(&sphere).is_empty());
    /// let values = sphere.mesh.vertices().to_vec();
    /// sphere.normals = Some(Attribute { values, corners: None });
    /// assert_eq!(Decimation::left_out(&sphere), ["normals"]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn left_out(input: &MeshFile) -> Vec<&'static str> {
        // Normals belong to the surface of the input, not to the new faces.
        if input.normals.is_some() { vec!["normals"] } else { Vec::new() }
    }

    /// Returns an error unless `input` can be the mesh that was decimated, and its attributes fit
    /// it.
    fn check_input(&self, input: &MeshFile) -> Result<()> {
        self.check_mesh(&input.mesh)?;
        input.check()
    }

    /// Returns an error unless `input` can be the mesh that was decimated.
    fn check_mesh(&self, input: &TriMesh) -> Result<()> {
        let vertices = input.vertices().len();
        Error::check_shape("input", (self.cells.of_vertices().len(), 3), (vertices, 3))?;
        let faces = input.faces().len();
        if let Some(place) = self.places.iter().find(|p| p.face as usize >= faces) {
            return Err(Error::Shape {
                what: "input",
                expected: (place.face as usize + 1, 3),
                got: (faces, 3),
            });
        }
        Ok(())
    }

    fn colors(&self, colors: &[[f64; 4]], input: &MeshFile) -> Vec<[f64; 4]> {
        let at = |place: &SurfacePoint| {
            let given = input.mesh.faces()[place.face as usize].map(|v| colors[v as usize]);
            let color = place.interpolate(given);
            // Rounding beyond 1 would make a reader take the colours as from 0 to 255.
            std::array::from_fn(|k| {
                let [a, b, c] = given.map(|color| color[k]);
                color[k].max(a.min(b).min(c)).min(a.max(b).max(c))
            })
        };
        self.places.iter().map(at).collect()
    }
}

fn at_homes(labels: &Labels, homes: &[Home]) -> Labels {
    let of_faces = homes.iter().map(|home| labels.of_faces[home.place.face as usize]).collect();
    Labels { names: labels.names.clone(), of_faces }
}
