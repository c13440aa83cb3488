//! Carries texture coordinates over to the new mesh.

use super::super::result::Decimation;
use super::charts::Charts;
use super::frame::{Frame, Uv, is_fair};
use super::home::Home;
use crate::mesh::TriMesh;
use crate::mesh::io::Attribute;
use crate::mesh::vector::{Vector, distance, sub};

/// Radius of the search of the texture around a vertex, relative to the distance to the farthest
/// home of its faces: on a curved surface, paths are longer.
const DETOUR: f64 = 1.25;

/// The possible texture coordinates of a corner.
#[derive(Clone, Copy)]
struct Choice {
    /// The coordinates of the nearest point on its side of the seams.
    nearest: Uv,
    /// The coordinates of the corner's own point, or otherwise the texture extended from the
    /// nearest point to the corner.
    continued: Uv,
}

/// Returns the texture of the new mesh: the texture of the input at the homes of its faces,
/// extended from there.
pub(super) fn carried(
    found: &Decimation,
    input: &TriMesh,
    uv: &Attribute<2>,
    homes: &[Home],
) -> Attribute<2> {
    let mesh = &found.mesh;
    let mut charts = Charts::of(input, uv);
    let choices = choices(found, &mut charts, homes);
    let corners: Vec<Option<[Uv; 3]>> = mesh
        .faces()
        .iter()
        .zip(homes)
        .zip(choices)
        .map(|((face, home), choices)| {
            let [a, b, c] = choices;
            let points = face.map(|v| mesh.vertices()[v as usize]);
            let frame = charts.frame_near(home.place.face);
            Some(fair(points, home, charts.at(&home.place)?, frame, [a?, b?, c?]))
        })
        .collect();
    numbered(mesh, &corners)
}

/// Returns the choices for each corner of each face; `None` where the home has no texture.
fn choices(
    found: &Decimation,
    charts: &mut Charts<'_>,
    homes: &[Home],
) -> Vec<[Option<Choice>; 3]> {
    let mesh = &found.mesh;
    let mut choices = vec![[None; 3]; mesh.faces().len()];
    let faces_of = mesh.vertex_faces();
    for ((v, &p), place) in (0..).zip(mesh.vertices()).zip(&found.places) {
        let faces = faces_of.row(v as usize);
        let homes = || faces.iter().map(|&f| &homes[f as usize]);
        let farthest = homes().map(|home| distance(home.point, p)).fold(0.0, f64::max);
        let at_homes = homes().map(|home| home.place.face);
        let (sides, of_faces) = charts.sides(p, place, DETOUR * farthest, at_homes);
        let sides: Vec<Option<Choice>> = sides
            .iter()
            .map(|side| {
                let nearest = charts.at(&side.place)?;
                let frame = if side.own { None } else { charts.frame(side.place.face) };
                let step = sub(p, side.point);
                let continued = frame.map_or(nearest, |frame| frame.continued(nearest, step));
                Some(Choice { nearest, continued })
            })
            .collect();
        for (&f, side) in faces.iter().zip(of_faces) {
            let corners = mesh.faces()[f as usize];
            for (_, choice) in
                corners.iter().zip(&mut choices[f as usize]).filter(|(w, _)| **w == v)
            {
                *choice = sides[side];
            }
        }
    }
    choices
}

/// Returns the first of the choices of a face that is fair to the texture of its home: neither
/// reversed nor much stretched. The last choice is that texture itself, extended.
fn fair(
    points: [Vector; 3],
    home: &Home,
    at_home: Uv,
    frame: Option<Frame>,
    choices: [Choice; 3],
) -> [Uv; 3] {
    let nearest = choices.map(|choice| choice.nearest);
    // Without area in the texture there is no orientation to preserve.
    let Some(frame) = frame else { return nearest };
    let unfolded = frame.unfolded(at_home, home.point, points, home.flipped);
    let continued = choices.map(|choice| choice.continued);
    let fair = |uv: &[Uv; 3]| is_fair(unfolded, *uv);
    [nearest, continued].into_iter().find(fair).unwrap_or(unfolded)
}

/// Returns the values of corners as an attribute, with equal values at a vertex merged.
fn numbered(mesh: &TriMesh, given: &[Option<[Uv; 3]>]) -> Attribute<2> {
    let mut corners = vec![[Attribute::<2>::ABSENT; 3]; given.len()];
    let mut values: Vec<Uv> = Vec::new();
    for (v, faces) in (0..).zip(mesh.vertex_faces().rows()) {
        let first = values.len();
        for &f in faces {
            let Some(of_face) = given[f as usize] else { continue };
            for k in (0..3).filter(|&k| mesh.faces()[f as usize][k] == v) {
                let known = values[first..].iter().position(|value| *value == of_face[k]);
                let number = first + known.unwrap_or(values.len() - first);
                if number == values.len() {
                    values.push(of_face[k]);
                }
                corners[f as usize][k] = number as u32;
            }
        }
    }
    let of_vertices = values.len() == mesh.vertices().len() && corners == mesh.faces();
    Attribute { values, corners: if of_vertices { None } else { Some(corners) } }
}
