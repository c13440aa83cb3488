//! The files of `--material`.

use std::path::Path;

use anyhow::{Context, Result};
use catamaran_geometry::mesh::io::{Attribute, Material, MeshFile, Picture};
use catamaran_simulation::texture::{Look, MaterialMaps, Preset};
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::images;
use super::look::named;
use crate::common::Force;
use crate::output;

/// The file of the mesh with its material.
pub const MODEL: &str = "material.glb";
const ALBEDO: &str = "albedo.png";
const ROUGHNESS: &str = "roughness.png";
const METALNESS: &str = "metalness.png";
const HEIGHT: &str = "height.png";
const NORMAL: &str = "normal.png";
const GLOW: &str = "glow.png";

/// Parses the name of a look on the command line.
pub fn parser() -> impl TypedValueParser<Value = Preset> {
    let names = Preset::ALL.map(|(name, _)| name);
    PossibleValuesParser::new(names).try_map(|name| named(&name))
}

/// Returns the name of the default look.
pub fn usual() -> &'static str {
    let found = Preset::ALL.into_iter().find(|(_, preset)| *preset == Preset::default());
    found.map_or("another", |(name, _)| name)
}

/// Returns the names of the files of a look.
pub fn names(look: &Look) -> Vec<&'static str> {
    let glows = look.species.iter().chain([&look.bare]).any(|finish| finish.glow > 0.0);
    let mut all = vec![ALBEDO, ROUGHNESS, METALNESS, HEIGHT, NORMAL];
    if glows {
        all.push(GLOW);
    }
    all.push(MODEL);
    all
}

/// Returns the statements of a Wavefront material that name the pictures (roughness, metalness and
/// normals as most programs write them).
pub fn statements(look: &Look) -> String {
    let glow = if names(look).contains(&GLOW) {
        format!("Ke 1 1 1\nmap_Ke {GLOW}\n")
    } else {
        String::new()
    };
    format!("map_Kd {ALBEDO}\nmap_Pr {ROUGHNESS}\nmap_Pm {METALNESS}\nnorm {NORMAL}\n{glow}")
}

/// Writes the textures, and the mesh with texture coordinates in them, into `folder`.
pub fn write(
    maps: &MaterialMaps,
    mesh: &MeshFile,
    name: &str,
    folder: &Path,
    force: Force,
) -> Result<()> {
    let size = maps.size;
    let create = |name: &str| force.create(&folder.join(name));
    let albedo = Picture::rgb(size, &maps.albedo)?;
    let height = Picture::gray16(size, &maps.height)?;
    let normal = Picture::rgb(size, &maps.normal)?;
    images::save(create(ALBEDO)?, albedo.clone())?;
    images::save(create(ROUGHNESS)?, Picture::gray(size, &maps.roughness)?)?;
    images::save(create(METALNESS)?, Picture::gray(size, &maps.metalness)?)?;
    images::save(create(HEIGHT)?, height.clone())?;
    images::save(create(NORMAL)?, normal.clone())?;
    let finish = Material::finish(size, &maps.roughness, &maps.metalness)?;
    // Rows of textures are from v = 0, those of pictures from the top.
    let mut material = Material::new()
        .name(name)
        .base_color(albedo.flipped())
        .roughness_metalness(finish.flipped())
        .normal(normal.flipped())
        .extra([("height".to_owned(), height.flipped())]);
    if let Some(glow) = &maps.glow {
        let glow = Picture::rgb(size, glow)?;
        images::save(create(GLOW)?, glow.clone())?;
        material = material.emission(glow.flipped());
    }
    let mut model = mesh.clone();
    // Those of mesh.obj, in place of which is this one.
    (model.materials, model.material_files) = (None, vec![]);
    // Without normals viewers show flat faces.
    let values = model.mesh.vertex_normals();
    model.normals = Some(Attribute { values, corners: None });
    output::mesh_with_material(create(MODEL)?, &model, &material)
        .with_context(|| folder.join(MODEL).display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_looks_that_glow_have_a_texture_of_glow() {
        let count = |preset| names(&Look::of(preset)).len();
        assert_eq!([Preset::Wood, Preset::Lava].map(count), [6, 7]);
    }
}
