use std::f64::consts::TAU;

use super::{Plant, Pose};
use catamaran::base::{Error, Result, reserved};
use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::mesh::vector::{cross, sub, unit};

/// Returns a plant as a mesh of tubes: for each segment a frustum of `sides` >= 3 flat sides, from
/// the radius of its parent to its own, where each radius is at least `thinnest` metres. Segment v
/// has the vertices `2 sides v .. 2 sides (v + 1)`.
///
/// ```
/// use catamaran_simulation::plant::{RodOptions, Rods, families, tubes};
///
/// let plant = families::chain(10, 0.3, 1e-3)?;
/// let pose = Rods::new(&plant, &RodOptions::new())?.rest_pose();
/// let mesh = tubes(&plant, &pose, 6, 0.0)?;
/// assert_eq!(mesh.vertices().len(), 2 * 6 * 10);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] for a pose of another plant, [`Error::Argument`] for fewer than 3 sides, more
/// vertices than can be numbered, or a radius that is negative; [`Error::Mesh`] for a pose that is
/// not finite; [`Error::OutOfMemory`].
pub fn tubes(plant: &Plant, pose: &Pose, sides: usize, thinnest: f64) -> Result<TriMesh> {
    let n = plant.len();
    Error::check_shape("pose", (n, 3), (pose.tails.len(), 3))?;
    Error::check_shape("pose", (n, 3), (pose.heads.len(), 3))?;
    if sides < 3 || !(thinnest >= 0.0 && thinnest.is_finite()) {
        let why = format!("must have at least 3 sides and 0 m, has {sides} and {thinnest} m");
        return Err(Error::Argument { what: "tubes", why });
    }
    let count = n.saturating_mul(sides).saturating_mul(2);
    if count > u32::MAX as usize / 3 {
        let why = format!("would have {count} vertices, more than indices can number");
        return Err(Error::Argument { what: "tubes", why });
    }
    let mut vertices: Vec<[f64; 3]> = reserved(count)?;
    let mut faces: Vec<[u32; 3]> = reserved(count)?;
    for v in 0..n {
        let radius = plant.segments()[v].radius;
        let above = plant.parent(v).map_or(radius, |p| plant.segments()[p].radius);
        // A branch does not start with the thickness of its stem.
        let first_radius = above.min(1.5 * radius).max(thinnest);
        let along = unit(sub(pose.tails[v], pose.heads[v]));
        let (across, third) = frame(along);
        let first = vertices.len() as u32;
        for (centre, radius) in
            [(pose.heads[v], first_radius), (pose.tails[v], radius.max(thinnest))]
        {
            for i in 0..sides {
                let (s, c) = (TAU * i as f64 / sides as f64).sin_cos();
                vertices
                    .push([0, 1, 2].map(|k| centre[k] + radius * (c * across[k] + s * third[k])));
            }
        }
        let sides = sides as u32;
        for i in 0..sides {
            let next = (i + 1) % sides;
            let [a, b, c, d] = [i, next, sides + next, sides + i].map(|k| first + k);
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    TriMesh::new(vertices, faces)
}

/// Returns two unit vectors orthogonal to a third one and to each other.
fn frame(along: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let least = (0..3).min_by(|&i, &j| along[i].abs().total_cmp(&along[j].abs())).unwrap_or(0);
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let across = unit(cross(along, axis));
    (across, cross(along, across))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::families::chain;
    use crate::plant::{RodOptions, Rods};
    use catamaran_geometry::mesh::vector::doubled_normal;

    #[test]
    fn tubes_have_the_area_of_their_sides_and_face_outwards() {
        let plant = chain(3, 0.3, 1e-3).unwrap();
        let pose = Rods::new(&plant, &RodOptions::default()).unwrap().rest_pose();
        for sides in [3, 8, 31] {
            let mesh = tubes(&plant, &pose, sides, 0.0).unwrap();
            assert_eq!((mesh.vertices().len(), mesh.faces().len()), (6 * sides, 6 * sides));
            let edge = 2e-3 * (TAU / 2.0 / sides as f64).sin();
            assert!((mesh.area() - 0.3 * edge * sides as f64).abs() < 1e-12);
            let corners = mesh.faces()[0].map(|v| mesh.vertices()[v as usize]);
            let (normal, a) = (doubled_normal(corners), corners[0]);
            assert!(normal[0] * a[0] + normal[1] * a[1] > 0.0);
        }
        assert!(tubes(&plant, &pose, 2, 0.0).is_err());
    }
}
