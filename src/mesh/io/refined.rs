//! Attributes on meshes that were cut finer.

use std::collections::HashMap;

use super::attributes::{Attribute, MeshFile};
use super::labels::Labels;
use crate::base::{Error, Result};
use crate::mesh::Refined;

impl MeshFile {
    /// The file of a finer mesh: colours, texture coordinates and normals of new vertices lie between those of the vertices
    /// around them, and a piece of a face has its material, group and object.
    ///
    /// # Errors
    /// [`Error::Shape`] and [`Error::Argument`] when attributes do not fit the mesh, [`Error::Argument`] when `refined` was
    /// made of another mesh.
    pub fn refined(&self, refined: &Refined) -> Result<MeshFile> {
        self.check()?;
        let (vertices, faces) = (self.mesh.vertices().len(), self.mesh.faces().len());
        let beyond =
            refined.vertices.iter().flat_map(|o| o.vertices).any(|v| v as usize >= vertices)
                || refined.faces.iter().any(|&f| f as usize >= faces);
        if beyond {
            let why = format!("not of a mesh of {vertices} vertices and {faces} faces");
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
            material_files: self.material_files.clone(),
            collapsed_faces: self.collapsed_faces,
            notes: self.notes.clone(),
        })
    }

    fn attribute<const N: usize>(&self, old: &Attribute<N>, refined: &Refined) -> Attribute<N> {
        let Some(corners) = &old.corners else {
            return Attribute { values: of_vertices(&old.values, refined), corners: None };
        };
        let mut values = old.values.clone();
        // New values by the values that they lie between, so that pieces of a face share them.
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

fn of_vertices<const N: usize>(values: &[[f64; N]], refined: &Refined) -> Vec<[f64; N]> {
    let mut all = values.to_vec();
    for origin in &refined.vertices[values.len()..] {
        let between = |k: usize| {
            let part = |i: usize| origin.weights[i] * values[origin.vertices[i] as usize][k];
            (0..3).map(part).sum()
        };
        all.push(std::array::from_fn(between));
    }
    all
}
