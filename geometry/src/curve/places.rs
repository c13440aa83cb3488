use super::result::{Curve, Waypoint};
use crate::mesh::{Origin, Refined, SurfacePoint, TriMesh};
use catamaran::base::{Error, Result};

/// Returns the points of curves as points of the faces of a coarser mesh, of which `refined` is the
/// refinement to the mesh that the curves are on. A point of several faces is that of the first.
///
/// ```
/// use catamaran_geometry::curve::{CurveOptions, Drawing, places};
/// use catamaran_geometry::mesh::families;
///
/// let mesh = families::grid(8, 8)?;
/// let mut drawing = Drawing::new(mesh.clone())?;
/// drawing.add(&[10, 64, 16, 70], &CurveOptions::new())?;
/// drawing.smooth()?;
/// let curves = &drawing.found().next().unwrap().curves;
/// let found = places(curves, drawing.refinement(), &mesh)?;
/// for (place, point) in found[0].iter().zip(&curves[0].points) {
///     let position = place.position(&mesh);
///     assert!((0..3).all(|k| (position[k] - point[k]).abs() < 1e-14));
/// }
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for a curve that is not on the mesh of `refined`, and for one with a point
/// that no face of `mesh` has.
pub fn places(
    curves: &[Curve],
    refined: &Refined,
    mesh: &TriMesh,
) -> Result<Vec<Vec<SurfacePoint>>> {
    let faces = mesh.vertex_faces();
    let place = |waypoint: &Waypoint| {
        let origin = origin(waypoint, refined)?;
        let (vertices, weights) = (origin.vertices, origin.weights);
        let on: Vec<u32> = (0..3).filter(|&k| weights[k] > 0.0).map(|k| vertices[k]).collect();
        let around = on.first().map_or(&[][..], |&v| faces.row(v as usize));
        let has_all = |face: &&u32| {
            let corners = mesh.faces()[**face as usize];
            on.iter().all(|v| corners.contains(v))
        };
        let Some(&face) = around.iter().find(has_all) else {
            let why = format!("no face has a point between the vertices {on:?}");
            return Err(Error::Argument { what: "mesh", why });
        };
        let weights = mesh.faces()[face as usize].map(|v| origin.share(v));
        Ok(SurfacePoint { face, weights })
    };
    curves.iter().map(|curve| curve.waypoints.iter().map(place).collect()).collect()
}

/// Returns where a point of a curve is on the coarser mesh.
fn origin(waypoint: &Waypoint, refined: &Refined) -> Result<Origin> {
    let of = |v: u32| {
        let why = || format!("a curve has vertex {v}, which the refined mesh does not have");
        let found = refined.vertices.get(v as usize).copied();
        found.ok_or_else(|| Error::Argument { what: "curves", why: why() })
    };
    Ok(match *waypoint {
        Waypoint::Vertex(v) => of(v)?,
        Waypoint::Edge { ends: [a, b], share } => {
            Origin::between(&[(of(a)?, 1.0 - share), (of(b)?, share)])
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::{CurveOptions, Drawing, Placement, place};
    use crate::mesh::vector::distance;
    use crate::mesh::{Site, families};

    #[test]
    fn points_of_curves_are_on_faces_of_the_mesh_before_samples_and_steiner_points_cut_it() {
        let mesh = families::torus(24, 12, 2.0, 0.8).unwrap();
        let at = |face, weights| Site::Face(SurfacePoint { face, weights });
        let sites = [
            at(10, [0.2, 0.3, 0.5]),
            at(150, [0.5, 0.5, 0.0]),
            at(300, [0.0, 0.4, 0.6]),
            at(470, [0.6, 0.2, 0.2]),
        ];
        let placed = place(&mesh, &sites, Placement::Insert).unwrap();
        let inserted = placed.mesh.unwrap();
        let mut drawing = Drawing::new(inserted.mesh.clone()).unwrap();
        drawing.add(&placed.vertices, &CurveOptions::new()).unwrap();
        drawing.smooth().unwrap();
        let refined = inserted.then(drawing.refinement().clone());
        let curves = &drawing.found().next().unwrap().curves;
        let found = places(curves, &refined, &mesh).unwrap();
        assert_eq!((curves.len(), found.len()), (1, 1));
        assert_eq!(found[0].len(), curves[0].points.len());
        let mut crossings = 0;
        for (place, &point) in found[0].iter().zip(&curves[0].points) {
            assert!(distance(place.position(&mesh), point) < 1e-13, "{place:?} {point:?}");
            assert!((place.weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            crossings += usize::from(place.weights.iter().all(|&w| w < 1.0));
        }
        assert!(crossings > 10, "{crossings}");
        // Another mesh has other vertices and edges.
        let other = families::grid(2, 2).unwrap();
        assert!(places(curves, &refined, &other).is_err());
    }
}
