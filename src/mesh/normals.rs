use super::TriMesh;
use super::vector::{Vector, add, cross, norm, sub, unit};

/// Unit normals of the vertices: the mean of the faces around, weighted by their area, on the side from which they are
/// counter-clockwise. Zero where there is none. O(V + F).
pub fn vertex_normals(mesh: &TriMesh) -> Vec<Vector> {
    let mut normals = vec![[0.0; 3]; mesh.vertices().len()];
    for face in mesh.faces() {
        let p = face.map(|v| mesh.vertices()[v as usize]);
        let doubled = cross(sub(p[1], p[0]), sub(p[2], p[0]));
        for &v in face {
            normals[v as usize] = add(normals[v as usize], doubled);
        }
    }
    normals.into_iter().map(unit).collect()
}

/// A third of the area of the faces at each vertex, in units of area; zero where there are none. O(V + F).
pub fn vertex_areas(mesh: &TriMesh) -> Vec<f64> {
    let mut areas = vec![0.0; mesh.vertices().len()];
    for face in mesh.faces() {
        let p = face.map(|v| mesh.vertices()[v as usize]);
        let area = norm(cross(sub(p[1], p[0]), sub(p[2], p[0]))) / 6.0;
        for &v in face {
            areas[v as usize] += area;
        }
    }
    areas
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::vector::{distance, scale};

    #[test]
    fn a_sphere_has_its_points_for_normals_and_a_grid_unit_areas() {
        let mesh = shapes::sphere(3);
        for (normal, p) in vertex_normals(&mesh).into_iter().zip(mesh.vertices()) {
            assert!(distance(normal, *p) < 0.1);
        }
        let grid = shapes::grid(3, 3);
        assert_eq!(vertex_normals(&grid)[5], [0.0, 0.0, 1.0]);
        assert!((vertex_areas(&grid)[5] - 1.0).abs() < 1e-15);
        assert!((vertex_areas(&grid).iter().sum::<f64>() - 9.0).abs() < 1e-14);
        let lonely = TriMesh::new(vec![scale([1.0; 3], 2.0)], vec![]).unwrap();
        assert_eq!((vertex_normals(&lonely), vertex_areas(&lonely)), (vec![[0.0; 3]], vec![0.0]));
    }
}
