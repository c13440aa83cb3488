//! Which extensions of glTF change the triangles of a file, and which of them the reader applies.

use super::super::draft::{Checked, Fault};
use super::super::notes::Notes;
use super::document::{Document, Extensions};
use super::{draco, meshopt};

/// Extensions that compress the numbers of a mesh. A file may have the same numbers uncompressed;
/// then these are read.
const COMPRESSION: [&str; 2] = [draco::NAME, MESHOPT];

/// Extends the extension of the same name that begins with EXT, which is applied, by streams and
/// filters that are not supported.
const MESHOPT: &str = "KHR_meshopt_compression";

/// Extensions that the reader applies.
const APPLIED: [&str; 4] =
    ["KHR_mesh_quantization", "KHR_node_visibility", "EXT_mesh_gpu_instancing", meshopt::NAME];

/// Beginnings of the names of extensions that do not change the triangles: materials, textures,
/// lights, sound, physics, behaviour, descriptions, and coarser levels of detail.
#[rustfmt::skip]
const NO_TRIANGLES: [&str; 39] = [
    "KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_animation_", "KHR_audio_", "KHR_xmp",
    "KHR_physics_", "KHR_implicit_shapes", "KHR_interactivity", "KHR_environment_map",
    "KHR_technique", "KHR_blend", "KHR_node_hoverability", "KHR_node_selectability",
    "EXT_materials_", "EXT_texture_", "EXT_lights_", "EXT_mesh_features", "EXT_mesh_manifold",
    "EXT_instance_features", "EXT_feature_metadata", "EXT_structural_metadata",
    "EXT_property_", "EXT_skybox", "MSFT_texture_", "MSFT_packing_", "MSFT_audio_", "MSFT_lod",
    "MSFT_physics", "OMI_", "ADOBE_materials_", "AGI_", "NV_materials_", "MAXAR_", "VRM",
    "FB_geometry_metadata", "CESIUM_primitive_outline", "GODOT_single_root", "GRIFFEL_bim_data",
];

/// Returns an error unless the reader can read files that require their extensions.
pub(super) fn check_required(document: &Document) -> Checked<()> {
    match document.extensions_required.iter().find(|name| is_unsupported(name)) {
        Some(name) => Err(unsupported(name)),
        None => Ok(()),
    }
}

/// Returns the error about a file that can't be read without an extension.
pub(super) fn unsupported(name: &str) -> Fault {
    match COMPRESSION.contains(&name) {
        true => {
            let is_known = name == draco::NAME;
            let why =
                if is_known { "but its numbers are not there" } else { "which is not supported" };
            let what = format!("compressed by the extension {name}, {why}");
            format!("{what}: import it into Blender, and export without compression").into()
        }
        false => format!("requires the extension {name}, which is not supported").into(),
    }
}

/// Returns the extension that has the numbers of a primitive or a buffer with these extensions,
/// where the file has none outside of extensions.
pub(super) fn source<'a>(own: &'a Extensions, document: &'a Document) -> Option<&'a str> {
    let mut used = document.extensions_used.iter().map(String::as_str);
    let found = own.keys().map(String::as_str).find(|name| is_unsupported(name));
    found.or_else(|| used.find(|name| COMPRESSION.contains(name)))
}

/// Notes the extensions of objects that may change the triangles, and that are left out.
pub(super) fn note_left_out(document: &Document, notes: &mut Notes) {
    let mut note = |extensions: &Extensions, place: &dyn Fn() -> String| {
        for name in extensions.keys().filter(|name| changes_triangles(name)) {
            notes.add(format!("left out the extension {name}, which is not supported"), place);
        }
    };
    note(&document.extensions, &|| "the document".into());
    for (i, scene) in document.scenes.iter().enumerate() {
        note(&scene.extensions, &|| format!("scene {i}"));
    }
    for (i, node) in document.nodes.iter().enumerate() {
        note(&node.extensions.others, &|| format!("node {i}"));
    }
    for (i, mesh) in document.meshes.iter().enumerate() {
        note(&mesh.extensions, &|| format!("mesh {i}"));
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            note(&primitive.extensions.others, &|| format!("mesh {i}, primitive {p}"));
        }
    }
    for (i, accessor) in document.accessors.iter().enumerate() {
        note(&accessor.extensions, &|| format!("accessor {i}"));
    }
    for (i, view) in document.buffer_views.iter().enumerate() {
        note(&view.extensions.others, &|| format!("buffer view {i}"));
    }
    for (i, buffer) in document.buffers.iter().enumerate() {
        note(&buffer.extensions.others, &|| format!("buffer {i}"));
    }
}

/// Returns whether the reader lacks an extension that may hold or change the triangles.
fn is_unsupported(name: &str) -> bool {
    name == MESHOPT || changes_triangles(name)
}

/// Returns whether an extension may change the triangles in a way that the reader does not apply.
fn changes_triangles(name: &str) -> bool {
    let harmless = NO_TRIANGLES.iter().any(|start| name.starts_with(start));
    !harmless && !APPLIED.contains(&name) && !COMPRESSION.contains(&name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_source_of_missing_numbers_is_an_extension_that_may_have_them() {
        let found = |used: &str, own: &str| {
            let primitive = format!(r#"{{"extensions": {{{own}}}}}"#);
            let json = format!(
                r#"{{"extensionsUsed": [{used}], "meshes": [{{"primitives": [{primitive}]}}]}}"#
            );
            let document: Document = serde_json::from_str(&json).unwrap();
            let primitive = &document.meshes[0].primitives[0];
            source(&primitive.extensions.others, &document).map(str::to_owned)
        };
        let meshopt = r#""KHR_meshopt_compression""#;
        let (features, variants) = (r#""EXT_mesh_features""#, r#""KHR_materials_variants""#);
        let name = Some("KHR_meshopt_compression");
        let used = format!("{features}, {meshopt}");
        let draco = r#""KHR_draco_mesh_compression""#;
        assert_eq!(found(draco, "").as_deref(), Some("KHR_draco_mesh_compression"));
        assert_eq!(found(&used, &format!("{features}: {{}}")).as_deref(), name);
        assert_eq!(found("", &format!("{features}: {{}}, {meshopt}: {{}}")).as_deref(), name);
        assert_eq!(found(variants, &format!("{variants}: {{}}")), None);
        let other = r#""AGI_sky": {}, "FOO_points": {}"#;
        assert_eq!(found("", other).as_deref(), Some("FOO_points"));
    }
}
