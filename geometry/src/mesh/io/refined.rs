//! Attributes on refined meshes.

use std::collections::HashMap;

use super::attributes::{Attribute, MeshFile, Scalars};
use super::labels::Labels;
use crate::mesh::{Refined, interpolate};
use catamaran::base::{Error, Result};

impl MeshFile {
    /// Returns the file of a finer mesh. Colours, scalars, texture coordinates and normals of new
    /// vertices are interpolated between those of the vertices around them, and each piece of a
    /// face has the material, group and object of the face.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Refined, families, io::MeshFile};
    ///
    /// let mesh = families::grid(1, 1)?;
    /// let mut file = MeshFile::from(mesh.clone());
    /// file.colors = Some(vec![[1.0; 4]; 4]);
    /// let same = file.refined(&Refined::new(mesh))?;
    /// assert_eq!(same.colors, file.colors);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] and [`Error::Argument`] when attributes do not fit the mesh,
    /// [`Error::Argument`] when `refined` refines another mesh.
    pub fn refined(&self, refined: &Refined) -> Result<MeshFile> {
        self.check()?;
        let (vertices, faces) = (self.mesh.vertices().len(), self.mesh.faces().len());
        let fits = refined.vertices.len() == refined.mesh.vertices().len()
            && refined.faces.len() == refined.mesh.faces().len()
            && refined.mesh.vertices().starts_with(self.mesh.vertices())
            && refined.vertices.iter().flat_map(|o| o.vertices).all(|v| (v as usize) < vertices)
            && refined.faces.iter().all(|&f| (f as usize) < faces);
        if !fits {
            let why = format!("does not refine this mesh of {vertices} vertices and {faces} faces");
            return Err(Error::Argument { what: "refined", why });
        }
        let labels = |labels: &Option<Labels>| {
            labels.as_ref().map(|labels| Labels {
                names: labels.names.clone(),
                of_faces: refined.faces.iter().map(|&f| labels.of_faces[f as usize]).collect(),
            })
        };
        Ok(MeshFile {
            mesh: refined.mesh.clone(),
            uv: self.uv.as_ref().map(|uv| self.attribute(uv, refined)),
            normals: self.normals.as_ref().map(|normals| self.attribute(normals, refined)),
            colors: self.colors.as_ref().map(|all| of_vertices(all, refined)),
            materials: labels(&self.materials),
            groups: labels(&self.groups),
            objects: labels(&self.objects),
            scalars: self.scalars.iter().map(|scalars| finer(scalars, refined)).collect(),
            material_files: self.material_files.clone(),
            collapsed_faces: self.collapsed_faces,
            first_collapsed: self.first_collapsed.clone(),
            notes: self.notes.clone(),
        })
    }

    fn attribute<const N: usize>(&self, old: &Attribute<N>, refined: &Refined) -> Attribute<N> {
        let Some(corners) = &old.corners else {
            return Attribute { values: of_vertices(&old.values, refined), corners: None };
        };
        let mut values = old.values.clone();
        // New values are keyed by the values that they lie between, so that pieces of a face share
        // them.
        let mut known: HashMap<Vec<(u32, u64)>, u32> = HashMap::new();
        let absent = [Attribute::<N>::ABSENT; 3];
        let mut of_corners = Vec::with_capacity(refined.faces.len());
        for (face, &origin) in refined.mesh.faces().iter().zip(&refined.faces) {
            let (old_face, numbers) =
                (self.mesh.faces()[origin as usize], corners[origin as usize]);
            if numbers == absent {
                of_corners.push(absent);
                continue;
            }
            of_corners.push(face.map(|v| {
                let shares = old_face.map(|u| refined.vertices[v as usize].share(u));
                let mut parts: Vec<(u32, u64)> = (numbers.into_iter().zip(shares))
                    .filter(|(_, share)| *share != 0.0)
                    .map(|(number, share)| (number, share.to_bits()))
                    .collect();
                if let &[(number, _)] = &parts[..] {
                    return number;
                }
                parts.sort_unstable();
                *known.entry(parts).or_insert_with_key(|parts| {
                    let between = |k: usize| {
                        let part = |&(i, share): &(u32, u64)| {
                            f64::from_bits(share) * old.values[i as usize][k]
                        };
                        parts.iter().map(part).sum()
                    };
                    values.push(std::array::from_fn(between));
                    values.len() as u32 - 1
                })
            }));
        }
        Attribute::simplified(values, of_corners, &refined.mesh)
    }
}

fn finer(scalars: &Scalars, refined: &Refined) -> Scalars {
    let values = of_vertices(scalars.values.as_chunks::<1>().0, refined).into_flattened();
    Scalars { name: scalars.name.clone(), values }
}

fn of_vertices<const N: usize>(values: &[[f64; N]], refined: &Refined) -> Vec<[f64; N]> {
    let mut all = values.to_vec();
    for origin in &refined.vertices[values.len()..] {
        all.push(interpolate(origin.weights, origin.vertices.map(|v| values[v as usize])));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Origin, TriMesh};

    /// Returns two triangles, and the refinement that cuts the edge between them at a quarter of
    /// its length.
    fn quarter() -> (TriMesh, Refined) {
        let vertices = vec![[0.0; 3], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]];
        let mesh = TriMesh::new(vertices.clone(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let finer = [vertices, vec![[1.0, 1.0, 0.0]]].concat();
        let faces = vec![[0, 1, 4], [4, 1, 2], [0, 4, 3], [4, 2, 3]];
        let corners = [(Origin::vertex(0), 0.75), (Origin::vertex(2), 0.25)];
        let origins = (0..4).map(Origin::vertex).chain([Origin::between(&corners)]).collect();
        let mesh_of = TriMesh::new(finer, faces).unwrap();
        (mesh, Refined { mesh: mesh_of, faces: vec![0, 0, 1, 1], vertices: origins })
    }

    #[test]
    fn attributes_lie_between_those_around_and_labels_stay() {
        let (mesh, refined) = quarter();
        let mut file = MeshFile::from(mesh);
        file.colors = Some((0..4).map(|i| [f64::from(i), 0.0, 1.0, 1.0]).collect());
        // A seam: the second face has texture coordinates of its own, but for its last corner.
        let values = (0..7).map(|i| [f64::from(i), 10.0]).collect();
        file.uv = Some(Attribute { values, corners: Some(vec![[0, 1, 2], [3, 4, 5]]) });
        let of_faces = vec![1, Labels::ABSENT];
        file.groups = Some(Labels { names: vec!["a".into(), "b".into()], of_faces });
        let finer = file.refined(&refined).unwrap();
        assert!(finer.check().is_ok());
        assert_eq!(finer.colors.as_ref().unwrap()[4], [0.5, 0.0, 1.0, 1.0]);
        let uv = |f: usize, corner: usize| {
            finer.uv.as_ref().unwrap().of_face(&finer.mesh, f).unwrap()[corner][0]
        };
        assert_eq!([uv(0, 0), uv(0, 1), uv(0, 2)], [0.0, 1.0, 0.5]);
        assert_eq!([uv(2, 0), uv(2, 1), uv(2, 2)], [3.0, 3.25, 5.0]);
        let groups = finer.groups.unwrap();
        assert_eq!(
            [groups.of_face(0), groups.of_face(1), groups.of_face(3)],
            [Some("b"), Some("b"), None]
        );
        // The trivial refinement leaves it unchanged.
        assert_eq!(file.refined(&Refined::new(file.mesh.clone())).unwrap(), file);
        let other = MeshFile::from(TriMesh::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]]).unwrap());
        let wrong = other.refined(&refined).unwrap_err().to_string();
        assert!(wrong.contains("does not refine this mesh of 3"), "{wrong}");
        // A larger mesh.
        let larger = MeshFile::from(refined.mesh.clone());
        assert!(larger.refined(&Refined::new(file.mesh.clone())).is_err());
    }

    #[test]
    fn refinements_of_refinements_are_on_the_first_mesh() {
        let (_, first) = quarter();
        // The middle of the edge from vertex 0 to the new one: an eighth of the diagonal.
        let middle = [(Origin::vertex(0), 0.5), (Origin::vertex(4), 0.5)];
        let vertices = [first.mesh.vertices(), &[[0.5, 0.5, 0.0]]].concat();
        let faces = vec![[0, 1, 5], [5, 1, 4], [4, 1, 2], [0, 5, 3], [5, 4, 3], [4, 2, 3]];
        let second = Refined {
            mesh: TriMesh::new(vertices, faces).unwrap(),
            faces: vec![0, 0, 1, 2, 2, 3],
            vertices: (0..5).map(Origin::vertex).chain([Origin::between(&middle)]).collect(),
        };
        let both = first.then(second);
        assert_eq!(both.faces, [0, 0, 0, 1, 1, 1]);
        assert_eq!((both.vertices[5].share(0), both.vertices[5].share(2)), (0.875, 0.125));
        let shares = both.shares(&[true, false, false, true, true, true]).unwrap();
        assert_eq!(shares, [0.125, 1.0]);
        assert!(both.shares(&[true]).is_err());
    }
}
