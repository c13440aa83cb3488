//! Triangles in space and in textures by brute force: oracles that share no code with the library.

use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::mesh::io::Attribute;

type Point = [f64; 3];

fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn corners(mesh: &TriMesh, f: usize) -> [Point; 3] {
    mesh.faces()[f].map(|v| mesh.vertices()[v as usize])
}

/// An edge that is this near to the plane of a triangle (the sine of the angle), or passes this
/// near to one of its sides (a barycentric coordinate), touches it but for rounding.
const ROUNDING: f64 = 1e-9;

/// Whether an edge passes through the inside of a triangle (Moeller and Trumbore 1997); what only
/// touches it does not.
fn pierces([p, q]: [Point; 2], [a, b, c]: [Point; 3]) -> bool {
    let (ab, ac, pq, ap) = (sub(b, a), sub(c, a), sub(q, p), sub(p, a));
    let h = cross(pq, ac);
    let determinant = dot(ab, h);
    let lengths = [ab, ac, pq].map(|v| dot(v, v).sqrt());
    if determinant.abs() <= ROUNDING * lengths.iter().product::<f64>() {
        return false;
    }
    let k = cross(ap, ab);
    let [u, v, t] = [dot(ap, h), dot(pq, k), dot(ac, k)].map(|x| x / determinant);
    [u, v, 1.0 - u - v, t, 1.0 - t].iter().all(|&part| part > ROUNDING)
}

/// The faces that an edge of another face pierces, and those of these edges. An edge does not
/// pierce the faces at its own ends.
pub fn intersecting(mesh: &TriMesh) -> Vec<u32> {
    let count = mesh.faces().len();
    let boxes: Vec<[Point; 2]> = (0..count)
        .map(|f| {
            let corners = corners(mesh, f);
            let along = |fold: fn(f64, f64) -> f64| {
                std::array::from_fn(|k| corners.iter().map(|p| p[k]).reduce(fold).unwrap())
            };
            [along(f64::min), along(f64::max)]
        })
        .collect();
    let apart = |f: usize, g: usize| {
        let ([low, high], [from, to]) = (boxes[f], boxes[g]);
        (0..3).any(|k| high[k] < from[k] || to[k] < low[k])
    };
    let passes = |f: usize, g: usize| {
        let [face, other] = [f, g].map(|f| mesh.faces()[f]);
        (0..3).any(|i| {
            let ends = [face[i], face[(i + 1) % 3]];
            let edge = ends.map(|v| mesh.vertices()[v as usize]);
            !ends.iter().any(|v| other.contains(v)) && pierces(edge, corners(mesh, g))
        })
    };
    let mut met = vec![false; count];
    for f in 0..count {
        for g in (0..f).filter(|&g| !apart(f, g)) {
            if passes(f, g) || passes(g, f) {
                (met[f], met[g]) = (true, true);
            }
        }
    }
    (0..count as u32).filter(|&f| met[f as usize]).collect()
}

/// The squared distance of p from a triangle: from its plane above the inside, else from its sides.
fn square_from([a, b, c]: [Point; 3], p: Point) -> f64 {
    let normal = cross(sub(b, a), sub(c, a));
    let inside = [[a, b], [b, c], [c, a]]
        .into_iter()
        .all(|[from, to]| dot(cross(sub(to, from), sub(p, from)), normal) >= 0.0);
    if inside && dot(normal, normal) > 0.0 {
        return dot(sub(p, a), normal).powi(2) / dot(normal, normal);
    }
    let from_side = |[from, to]: [Point; 2]| {
        let side = sub(to, from);
        let t = (dot(sub(p, from), side) / dot(side, side)).clamp(0.0, 1.0);
        let away: Point = std::array::from_fn(|k| p[k] - from[k] - t * side[k]);
        dot(away, away)
    };
    [[a, b], [b, c], [c, a]].into_iter().map(from_side).fold(f64::INFINITY, f64::min)
}

/// For each face of `mesh` the face of `input` nearest to its middle.
pub fn nearest_faces(mesh: &TriMesh, input: &TriMesh) -> Vec<usize> {
    let nearest = |f: usize| {
        let corners = corners(mesh, f);
        let middle = std::array::from_fn(|k| corners.iter().map(|p| p[k]).sum::<f64>() / 3.0);
        let square = |g: usize| square_from(self::corners(input, g), middle);
        let all = (0..input.faces().len()).map(|g| (square(g), g));
        all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap().1
    };
    (0..mesh.faces().len()).map(nearest).collect()
}

/// How the texture of a new mesh differs from that of the input's face nearest to each of its
/// faces.
#[derive(Debug)]
pub struct TextureFaults {
    /// The part of the faces that are turned over.
    pub turned: f64,
    /// The part of the other ones whose area in the texture, by that on the surface, is not within
    /// a ninth and nine times the input's there.
    pub stretched: f64,
}

impl TextureFaults {
    /// Faces that have no texture, or none with area at the input, have no fault.
    pub fn between(
        (mesh, uv): (&TriMesh, &Attribute<2>),
        (input, input_uv): (&TriMesh, &Attribute<2>),
    ) -> Self {
        let density = |mesh: &TriMesh, uv: &Attribute<2>, f: usize| {
            let flat = uv.of_face(mesh, f)?.map(|[u, v]| [u, v, 0.0]);
            let [on_texture, on_surface] =
                [flat, corners(mesh, f)].map(|[a, b, c]| cross(sub(b, a), sub(c, a)));
            Some(on_texture[2] / dot(on_surface, on_surface).sqrt())
        };
        let (mut turned, mut stretched) = (0, 0);
        for (f, g) in nearest_faces(mesh, input).into_iter().enumerate() {
            let densities = density(mesh, uv, f).zip(density(input, input_uv, g));
            let Some((new, old)) = densities.filter(|(_, old)| *old != 0.0) else { continue };
            turned += usize::from(new / old < 0.0);
            stretched += usize::from(new / old >= 0.0 && !(1.0 / 9.0..=9.0).contains(&(new / old)));
        }
        let part = |count: usize| count as f64 / mesh.faces().len() as f64;
        Self { turned: part(turned), stretched: part(stretched) }
    }
}
