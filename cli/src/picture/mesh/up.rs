//! Guesses which axis of a mesh is up, without --up.

use std::path::Path;

use catamaran::io::Packing;
use catamaran_geometry::mesh::TriMesh;

use super::camera::Up;

/// The least sum of the normals of a height field along the upward axis, weighted by areas, as a
/// share of the area of the mesh.
const HEIGHT_FIELD: f64 = 0.8;
/// A surface thinner than this share of its longest side is a flat figure, not a height field.
const FLAT: f64 = 1e-6;

/// Guesses the axis that is up.
///
/// 1. A height field, such as a terrain, has the axis that its normals point along: y or z.
/// 2. Files for 3D printing (.stl) have z up.
/// 3. All others have y up.
pub fn guess(mesh: &TriMesh, path: &Path) -> Up {
    height_field(mesh).unwrap_or_else(|| if is_printed(path) { Up::Z } else { Up::Y })
}

/// Returns whether the name, packed or not, is that of a file for 3D printing.
fn is_printed(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    Packing::of(&name).0.ends_with(".stl")
}

/// Returns the axis over which the mesh is a height field, if it is one.
fn height_field(mesh: &TriMesh) -> Option<Up> {
    let areas = mesh.face_areas();
    let total: f64 = areas.iter().sum();
    let [low, high] = mesh.bounding_box()?;
    let sides: [f64; 3] = std::array::from_fn(|k| high[k] - low[k]);
    let longest = sides.into_iter().fold(0.0, f64::max);
    let normals = mesh.face_normals();
    [(Up::Y, 1), (Up::Z, 2)].into_iter().find_map(|(up, k)| {
        let along: f64 = normals.iter().zip(&areas).map(|(normal, area)| normal[k] * area).sum();
        (along >= HEIGHT_FIELD * total && sides[k] > FLAT * longest).then_some(up)
    })
}

#[cfg(test)]
mod tests {
    use catamaran_geometry::mesh::families;

    use super::*;

    #[test]
    fn a_terrain_says_itself_what_is_up_and_other_meshes_by_their_kind_of_file() {
        let terrain = families::terrain(30, 30, 7).unwrap();
        let turned = |mesh: &TriMesh| {
            let (vertices, faces) = mesh.clone().into_parts();
            let vertices = vertices.into_iter().map(|[x, y, z]| [y, z, x]).collect();
            TriMesh::new(vertices, faces).unwrap()
        };
        let [obj, stl] = ["a.obj", "b.STL.zip"].map(Path::new);
        assert_eq!(guess(&terrain, obj), Up::Z);
        assert_eq!(guess(&turned(&terrain), stl), Up::Y);
        let sphere = families::icosphere(2).unwrap();
        assert_eq!(guess(&sphere, obj), Up::Y);
        assert_eq!(guess(&sphere, stl), Up::Z);
        // A figure in the plane is seen from the front.
        assert_eq!(guess(&families::grid(3, 3).unwrap(), obj), Up::Y);
        let nothing = TriMesh::new(vec![], vec![]).unwrap();
        assert_eq!(guess(&nothing, obj), Up::Y);
    }
}
