//! Gradient and divergence of functions that are linear on triangles: Botsch et al., Polygon Mesh
//! Processing (2010), section 3.3.

use sprs::CsMat;

use super::TriMesh;
use super::vector::{Vector, cross, dot, doubled_normal, norm, scale, sub};
use catamaran::base::{Error, Result};

/// Returns the matrix that takes a function (one value a vertex) to its gradient, constant on
/// faces: 3 F rows, F faces, by V columns, V vertices. Rows 3 f to 3 f + 2 are the components x, y,
/// z in face f, per unit of length.
///
/// ```
/// use catamaran_geometry::mesh::{divergence, families, gradient};
///
/// let mesh = families::icosphere(1)?;
/// let (grad, div) = (gradient(&mesh)?, divergence(&mesh)?);
/// assert_eq!(grad.shape(), (3 * mesh.faces().len(), mesh.vertices().len()));
/// assert_eq!(div.shape(), (mesh.vertices().len(), 3 * mesh.faces().len()));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Mesh`] names a face without area, or one whose gradients are out of the range of `f64`.
pub fn gradient(mesh: &TriMesh) -> Result<CsMat<f64>> {
    let (faces, rows) = (mesh.faces(), 3 * mesh.faces().len());
    let mut columns = Vec::with_capacity(3 * rows);
    let mut values = Vec::with_capacity(3 * rows);
    for f in 0..faces.len() {
        let (gradients, _) = of_hats(mesh, f)?;
        let mut order = [0, 1, 2];
        order.sort_unstable_by_key(|&k| faces[f][k]);
        for axis in 0..3 {
            for k in order {
                columns.push(faces[f][k] as usize);
                values.push(gradients[k][axis]);
            }
        }
    }
    let starts = (0..=rows).map(|r| 3 * r).collect();
    Ok(CsMat::new((rows, mesh.vertices().len()), starts, columns, values))
}

/// Returns the matrix that takes a vector field constant on faces (3 F values, as [`gradient`]
/// returns them) to its divergence, integrated against the hat function of each vertex: V rows by 3
/// F columns, the adjoint of minus the gradient G. So for this matrix D, `D G = -W` with the
/// cotangent stiffness W of [`laplacian`](fn@super::laplacian), and with a lumped mass M the
/// divergence at vertex v is `(D x)_v / M_v`.
///
/// ```
/// use catamaran_geometry::mesh::{LaplacianOptions, divergence, families, gradient, laplacian};
/// use catamaran::sparse::CsMat;
///
/// let mesh = families::icosphere(1)?;
/// let stiffness = laplacian(&mesh, &LaplacianOptions::new())?.stiffness;
/// let product: CsMat<f64> = &divergence(&mesh)? * &gradient(&mesh)?;
/// let sum = &product + &stiffness;
/// assert!(sum.data().iter().all(|x| x.abs() < 1e-12)); // D G = -W
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`gradient`].
pub fn divergence(mesh: &TriMesh) -> Result<CsMat<f64>> {
    let (n, faces) = (mesh.vertices().len(), mesh.faces());
    let mut starts = vec![0; n + 1];
    for &v in faces.as_flattened() {
        starts[v as usize + 1] += 3;
    }
    for v in 0..n {
        starts[v + 1] += starts[v];
    }
    let mut next = starts.clone();
    let mut columns = vec![0; 9 * faces.len()];
    let mut values = vec![0.0; 9 * faces.len()];
    for f in 0..faces.len() {
        let (gradients, area) = of_hats(mesh, f)?;
        for (k, &v) in faces[f].iter().enumerate() {
            for axis in 0..3 {
                let place = &mut next[v as usize];
                columns[*place] = 3 * f + axis;
                values[*place] = -area * gradients[k][axis];
                *place += 1;
            }
        }
    }
    Ok(CsMat::new((n, 3 * faces.len()), starts, columns, values))
}

/// Returns a third of the area of the faces at each vertex, in units of area; zero for vertices
/// without faces. O(V + F).
///
/// ```
/// use catamaran_geometry::mesh::{families, vertex_areas};
///
/// let mesh = families::icosphere(3)?;
/// let area: f64 = vertex_areas(&mesh).iter().sum();
/// assert!((area - 4.0 * std::f64::consts::PI).abs() < 0.1);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn vertex_areas(mesh: &TriMesh) -> Vec<f64> {
    let mut areas = vec![0.0; mesh.vertices().len()];
    for face in mesh.faces() {
        let p = face.map(|v| mesh.vertices()[v as usize]);
        let area = norm(doubled_normal(p)) / 6.0;
        for &v in face {
            areas[v as usize] += area;
        }
    }
    areas
}

/// Returns the gradients of the functions that are 1 at one corner of a face and 0 at the others,
/// and its area.
fn of_hats(mesh: &TriMesh, f: usize) -> Result<([Vector; 3], f64)> {
    let p = mesh.faces()[f].map(|v| mesh.vertices()[v as usize]);
    let normal = doubled_normal(p);
    let square = dot(normal, normal);
    let gradients: [Vector; 3] = std::array::from_fn(|k| {
        let opposite = sub(p[(k + 2) % 3], p[(k + 1) % 3]);
        scale(cross(normal, opposite), 1.0 / square)
    });
    let finite = gradients.as_flattened().iter().all(|x| x.is_finite());
    if !(finite && square > 0.0 && square.is_finite()) {
        let what = "no gradient: the face has no area, or lengths out of range".into();
        return Err(Error::Mesh { what, element: format!("face {f}") });
    }
    Ok((gradients, 0.5 * norm(normal)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{LaplacianOptions, families, laplacian, shapes};
    use catamaran::base::Par;

    fn apply(matrix: &CsMat<f64>, x: &[f64]) -> Vec<f64> {
        matrix.outer_iterator().map(|row| row.iter().map(|(j, a)| a * x[j]).sum()).collect()
    }

    #[test]
    fn the_gradient_of_a_linear_function_is_its_slope_along_the_face() {
        let slope = [0.3, -2.0, 1.5];
        let mesh = shapes::shaken(&shapes::sphere(2), 0.1, 4);
        let values: Vec<f64> = mesh.vertices().iter().map(|&p| dot(p, slope) + 7.0).collect();
        let found = apply(&gradient(&mesh).unwrap(), &values);
        for (f, face) in mesh.faces().iter().enumerate() {
            let p = face.map(|v| mesh.vertices()[v as usize]);
            let normal = super::super::vector::unit(doubled_normal(p));
            let expected = sub(slope, scale(normal, dot(slope, normal)));
            for axis in 0..3 {
                assert!((found[3 * f + axis] - expected[axis]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn divergence_of_gradient_is_minus_the_stiffness() {
        let meshes = [
            shapes::shaken(&shapes::grid(4, 3), 0.2, 5),
            families::pages(3).unwrap(),
            shapes::sphere(1),
        ];
        for mesh in meshes {
            let options = LaplacianOptions { par: Par::Seq, ..Default::default() };
            let w = laplacian(&mesh, &options).unwrap().stiffness;
            let product = &divergence(&mesh).unwrap() * &gradient(&mesh).unwrap();
            for i in 0..w.rows() {
                for j in 0..w.cols() {
                    let at = |m: &CsMat<f64>| m.get(i, j).copied().unwrap_or(0.0);
                    assert!((at(&w) + at(&product)).abs() < 1e-13, "{i} {j}");
                }
            }
        }
    }

    #[test]
    fn vertex_areas_sum_to_the_area() {
        let grid = shapes::grid(3, 3);
        let areas = vertex_areas(&grid);
        assert!((areas[5] - 1.0).abs() < 1e-15 && (areas.iter().sum::<f64>() - 9.0).abs() < 1e-14);
        let lonely = TriMesh::new(vec![[2.0; 3]], vec![]).unwrap();
        assert_eq!(vertex_areas(&lonely), [0.0]);
    }

    #[test]
    fn a_face_without_area_is_named() {
        let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let mesh = TriMesh::new(vertices, vec![[0, 1, 2]]).unwrap();
        for error in [gradient(&mesh).unwrap_err(), divergence(&mesh).unwrap_err()] {
            assert!(
                error.to_string().starts_with("face 0: no gradient: the face has no area"),
                "{error}"
            );
        }
        let empty = TriMesh::new(vec![], vec![]).unwrap();
        assert_eq!(gradient(&empty).unwrap().shape(), (0, 0));
        assert_eq!(divergence(&empty).unwrap().shape(), (0, 0));
    }
}
