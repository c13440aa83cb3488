use std::io;

use serde_json::{Value, json};

use super::super::attributes::MeshFile;
use super::picture::Picture;
use catamaran::base::{Error, Result, options, reserved};

options! {
    /// A material for physically based rendering, as in glTF 2.0 (section 3.9). Texture coordinates
    /// map a picture onto the mesh; it repeats outside of 0 to 1.
    ///
    /// ```
    /// use catamaran_geometry::mesh::io::{Material, Picture};
    ///
    /// let red = Picture::rgb(1, &[[200, 30, 20]])?;
    /// let shiny = Material::new().name("paint").base_color(red).roughness(0.2);
    /// assert_eq!(shiny.metalness, 0.0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    #[derive(Debug, Clone, PartialEq)]
    pub struct Material {
        /// The name.
        name: String = "material".into(), setter into;
        /// Colours (sRGB), with opacity if the picture has it; white if `None`.
        base_color: Option<Picture> = None, setter into;
        /// The picture that [`Material::finish`] makes: green is roughness, blue is metalness.
        roughness_metalness: Option<Picture> = None, setter into;
        /// Roughness where there is no such picture.
        roughness: f64 = 1.0, check(from 0.0 to 1.0);
        /// Metalness where there is no such picture.
        metalness: f64 = 0.0, check(from 0.0 to 1.0);
        /// Normals in the frame of the surface, green up, as from
        /// `catamaran_simulation::texture::normal_colors`.
        normal: Option<Picture> = None, setter into;
        /// Ambient light that reaches the surface: red.
        occlusion: Option<Picture> = None, setter into;
        /// Light that is emitted (sRGB).
        emission: Option<Picture> = None, setter into;
        /// Pictures that glTF does not define, such as heights, with their names. They are stored
        /// in the file and listed in the `extras` of the material; viewers skip them.
        extra: Vec<(String, Picture)> = Vec::new(), setter into;
        /// Whether the back of faces is shown.
        double_sided: bool = true;
    }
}

impl Material {
    /// Combines roughness and metalness, 255 for 1, into one picture of rows of `width`, in the
    /// layout of glTF.
    ///
    /// # Errors
    /// As [`Picture::rgb`]; [`Error::Shape`] for different numbers of both.
    pub fn finish(width: usize, roughness: &[u8], metalness: &[u8]) -> Result<Picture> {
        Error::check_shape("metalness", (roughness.len(), 1), (metalness.len(), 1))?;
        let mut pixels = reserved(roughness.len())?;
        // Red is unused: it would be occlusion.
        pixels.extend(roughness.iter().zip(metalness).map(|(&r, &m)| [255, r, m]));
        Picture::rgb(width, &pixels)
    }

    /// Returns an error unless every number is in its range, and every face of the mesh has
    /// coordinates for the pictures, if there are any.
    pub(in super::super) fn check(&self, file: &MeshFile) -> Result<()> {
        self.check_ranges()?;
        let slots = [
            &self.base_color,
            &self.roughness_metalness,
            &self.normal,
            &self.occlusion,
            &self.emission,
        ];
        let count = file.mesh.faces().len();
        let without = match &file.uv {
            None => (count > 0).then_some(0),
            Some(uv) => (0..count).find(|&f| uv.of_face(&file.mesh, f).is_none()),
        };
        match without {
            Some(face) if slots.iter().any(|slot| slot.is_some()) => Err(Error::Argument {
                what: "uv",
                why: format!("face {face} has no texture coordinates for the pictures"),
            }),
            _ => Ok(()),
        }
    }

    /// Returns the JSON of the material; `add` takes a picture and its name, and returns the number
    /// of its image and of its texture, which are the same.
    pub(super) fn json(
        &self,
        add: &mut dyn FnMut(&str, &Picture) -> io::Result<usize>,
    ) -> io::Result<Value> {
        let mut texture = |name: &str, picture: &Option<Picture>| -> io::Result<Option<Value>> {
            let picture = picture.as_ref();
            picture.map(|picture| Ok(json!({ "index": add(name, picture)? }))).transpose()
        };
        let mut pbr = json!({});
        if let Some(found) = texture("albedo", &self.base_color)? {
            pbr["baseColorTexture"] = found;
        }
        match texture("roughness and metalness", &self.roughness_metalness)? {
            // Factors are 1 by default.
            Some(found) => pbr["metallicRoughnessTexture"] = found,
            None => {
                pbr["roughnessFactor"] = self.roughness.into();
                pbr["metallicFactor"] = self.metalness.into();
            }
        }
        let mut material = json!({ "name": self.name, "pbrMetallicRoughness": pbr });
        for (slot, name, picture) in [
            ("normalTexture", "normal", &self.normal),
            ("occlusionTexture", "occlusion", &self.occlusion),
            ("emissiveTexture", "emission", &self.emission),
        ] {
            if let Some(found) = texture(name, picture)? {
                material[slot] = found;
            }
        }
        if self.emission.is_some() {
            material["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
        }
        if self.base_color.as_ref().is_some_and(Picture::has_opacity) {
            material["alphaMode"] = "BLEND".into();
        }
        if self.double_sided {
            material["doubleSided"] = true.into();
        }
        for (name, picture) in &self.extra {
            material["extras"][name] = json!({ "texture": add(name, picture)? });
        }
        Ok(material)
    }
}
