//! Finds for each new face the point of the input from which it takes its attributes.

use super::super::closest::on_surface;
use super::super::result::Decimation;
use super::super::surface::Surface;
use crate::mesh::vector::{Vector, dot, doubled_normal, sub, unit};
use crate::mesh::{Genus, SurfacePoint};

/// Cosine between normals (120 degrees) below which a face of the input is on another sheet than a
/// new face: faces across a crease differ less.
const OTHER_SHEET: f64 = -0.5;

/// The point of the input nearest to the middle of a new face.
pub(super) struct Home {
    pub place: SurfacePoint,
    pub point: Vector,
    /// Whether the face of the input there has the opposite orientation.
    pub flipped: bool,
}

/// Returns the homes of all new faces: points on the sheet of the surface with the same
/// orientation, if one is near.
pub(super) fn homes(found: &Decimation, input: &Surface<'_>) -> Vec<Home> {
    // Faces of the input may have been flipped before the decimation.
    let either_way = found.repairs.oriented || !matches!(found.before.genus, Genus::Orientable(_));
    found.mesh.faces().iter().map(|&face| home(found, input, face, either_way)).collect()
}

fn home(found: &Decimation, input: &Surface<'_>, face: [u32; 3], either_way: bool) -> Home {
    let corners = face.map(|v| found.mesh.vertices()[v as usize]);
    let middle: Vector = std::array::from_fn(|k| corners.iter().map(|p| p[k] / 3.0).sum());
    let normal = unit(doubled_normal(corners));
    // The candidates for homes; the better one is lower in order.
    let of_face = |face: u32| {
        let (place, point) = SurfacePoint::nearest(&input.mesh, face, middle);
        let there = input.mesh.faces()[face as usize].map(|v| input.position(v));
        let along = dot(normal, unit(doubled_normal(there)));
        let away = sub(point, middle);
        let order = (!either_way && along < OTHER_SHEET, dot(away, away));
        let flipped = either_way && along < 0.0;
        (order, Home { place, point, flipped })
    };
    let places = face.map(|v| &found.places[v as usize]);
    let mut best = of_face(places[0].face);
    for place in places {
        let start = input.mesh.faces()[place.face as usize][place.heaviest()];
        let met = on_surface(input, start, middle).map(|met| met.place.face);
        for face in [Some(place.face), met].into_iter().flatten() {
            let other = of_face(face);
            if other.0 < best.0 {
                best = other;
            }
        }
    }
    best.1
}
