use catamaran_geometry::mesh::vector::{Vector, dot, sub, unit};
use catamaran_geometry::mesh::{Adjacency, TriMesh};

use super::camera::{Camera, Projected};
use super::lamp::LAMPS;
use super::raster::Hit;
use super::tangent::{Finish, Tangent};
use super::{Paint, Panel, SAMPLES, Scene, Texture};
use crate::picture::color::{Lights, to_light};

/// Ambient light, and the change of it from the horizon to above and below.
const AMBIENT: (f64, f64) = (0.30, 0.08);
/// Brightness and sharpness of the reflection of the first lamp.
pub const GLOSS: (f64, i32) = (0.10, 28);
/// Share of the light where the surface turns away from the viewer.
const RIM: f64 = 0.45;
/// Share of the light on the inside of an open surface.
const INSIDE: f64 = 0.55;
/// Cosine of the angle between a face and the normal of its vertex beyond which the vertex is drawn
/// as a sharp one (41 degrees): those of a cube are, those of an icosahedron are not.
const CREASE: f64 = 0.75;
/// Half the width of an edge, in pixels, and the share of the light on it.
const EDGE: (f64, f64) = (0.5, 0.45);
/// Faces thinner than this many pixels have fainter edges, in proportion: otherwise the edges would
/// cover them.
const THIN: f64 = 6.0;

/// Turns hits into light.
pub struct Shader<'a> {
    panel: &'a Panel<'a>,
    lights: &'a Lights,
    points: &'a [Projected],
    edges: bool,
    /// Normals as the viewer sees them.
    face_normals: Vec<Vector>,
    /// Not for flat faces.
    smooth: Option<Smooth>,
    /// Tangents of the faces, where a texture has normals.
    tangents: Vec<Tangent>,
}

/// What a surface is smoothed by.
struct Smooth {
    /// Normals of the vertices; `None` for sharp ones.
    normals: Vec<Option<Vector>>,
    /// The faces around each vertex.
    around: Adjacency,
}

impl<'a> Shader<'a> {
    pub fn new(
        panel: &'a Panel<'a>,
        scene: &Scene<'_>,
        lights: &'a Lights,
        camera: &Camera,
        points: &'a [Projected],
    ) -> Self {
        let normals = panel.mesh.face_normals().into_iter();
        let face_normals: Vec<Vector> = normals.map(|n| camera.turn(n)).collect();
        let smooth = scene.smooth.then(|| Smooth {
            normals: vertex_normals(panel.mesh, &face_normals),
            around: panel.mesh.vertex_faces(),
        });
        let tangents = match panel.paint {
            Paint::Texture(texture @ Texture { material: Some(_), .. }) => {
                Tangent::of_faces(panel.mesh, texture.uv, camera)
            }
            _ => Vec::new(),
        };
        Self { panel, lights, points, edges: scene.edges, face_normals, smooth, tangents }
    }

    /// Returns the light that a sample sends to the viewer.
    pub fn light(&self, hit: Hit) -> Vector {
        let face = self.panel.mesh.faces()[hit.face].map(|v| v as usize);
        // Shares in space, not on the screen.
        let weighted: [f64; 3] =
            std::array::from_fn(|k| hit.shares[k] * self.points[face[k]].weight);
        let sum: f64 = weighted.iter().sum();
        let shares = weighted.map(|w| w / sum);
        let flat = self.face_normals[hit.face];
        let outside = self.is_outside(face);
        let smooth = match &self.smooth {
            None => flat,
            Some(Smooth { normals, around }) => {
                let at = |v: usize| normals[v].unwrap_or_else(|| self.mean(around.row(v), v, flat));
                mix(shares, face.map(at))
            }
        };
        let mut normal = unit(if smooth == [0.0; 3] { flat } else { smooth });
        let finish = match self.panel.paint {
            Paint::Texture(texture) => Finish::at(&texture, hit.face, shares),
            _ => None,
        };
        if let (Some(finish), Some(tangent)) = (&finish, self.tangents.get(hit.face)) {
            normal = tangent.raised(normal, finish.normal);
        }
        if !outside {
            normal = normal.map(|x| -x);
        }
        let lit = lambert(normal);
        let shine = GLOSS.0 * gloss(normal);
        let facing = normal[2].clamp(0.0, 1.0);
        let mut factor = lit * (RIM + (1.0 - RIM) * (facing * 1.9).min(1.0).powf(0.7));
        if !outside {
            factor *= INSIDE;
        }
        if self.edges {
            factor *= self.edge(face, hit.shares);
        }
        let color = self.color(hit.face, shares);
        match finish {
            None => color.map(|c| c * factor + shine),
            Some(finish) => finish.light(color, factor, normal),
        }
    }

    /// Returns the normal of a sharp vertex in a face with the normal `flat`: the mean over the
    /// faces around that are not turned away from it.
    fn mean(&self, faces: &[u32], vertex: usize, flat: Vector) -> Vector {
        let faces = faces.iter().map(|&f| f as usize);
        let near = faces.filter(|&f| is_near(self.face_normals[f], flat));
        unit(near.fold([0.0; 3], |sum, f| {
            let angle = angle_at(self.panel.mesh, f, vertex);
            std::array::from_fn(|i| sum[i] + angle * self.face_normals[f][i])
        }))
    }

    /// Returns whether the visible side is the one from which the corners are counter-clockwise (y
    /// points down on the screen).
    fn is_outside(&self, face: [usize; 3]) -> bool {
        let [a, b, c] = face.map(|v| self.points[v]);
        (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) < 0.0
    }

    fn color(&self, number: usize, shares: [f64; 3]) -> Vector {
        let face = self.panel.mesh.faces()[number].map(|v| v as usize);
        match self.panel.paint {
            Paint::Plain(color) => to_light(color),
            Paint::Values(values) => {
                self.lights.of((0..3).map(|k| shares[k] * values[face[k]]).sum())
            }
            Paint::Colors(colors) => mix(shares, face.map(|v| to_light(colors[v]))),
            Paint::Texture(texture) => texture.light(number, shares),
        }
    }

    /// Returns the share of the light on or beside an edge, which is darker over a pixel.
    fn edge(&self, face: [usize; 3], shares: [f64; 3]) -> f64 {
        let p = face.map(|v| self.points[v]);
        let doubled =
            ((p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x)).abs();
        let nearest = (0..3).map(|k| {
            let (a, b) = (p[(k + 1) % 3], p[(k + 2) % 3]);
            shares[k] * doubled / (b.x - a.x).hypot(b.y - a.y)
        });
        let pixels = nearest.fold(f64::INFINITY, f64::min) / SAMPLES as f64;
        if pixels >= EDGE.0 {
            return 1.0;
        }
        let longest = (0..3).map(|k| {
            let (a, b) = (p[k], p[(k + 1) % 3]);
            (b.x - a.x).hypot(b.y - a.y)
        });
        let thin = doubled / longest.fold(0.0, f64::max) / SAMPLES as f64;
        1.0 - (1.0 - EDGE.1) * (thin / THIN).min(1.0)
    }
}

/// Returns the light from the lamps and the ambient light on a surface with this normal.
pub fn lambert(normal: Vector) -> f64 {
    let lamps: f64 = LAMPS.iter().map(|(to, bright)| bright * dot(normal, *to).max(0.0)).sum();
    AMBIENT.0 + AMBIENT.1 * normal[1] + lamps
}

/// Returns the reflection of the first lamp (Blinn 1977).
pub fn gloss(normal: Vector) -> f64 {
    let half = unit(std::array::from_fn(|k| LAMPS[0].0[k] + [0.0, 0.0, 1.0][k]));
    dot(normal, half).max(0.0).powi(GLOSS.1)
}

/// Returns whether a normal is near that of a face, which may be zero.
fn is_near(normal: Vector, flat: Vector) -> bool {
    dot(normal, flat) >= CREASE * dot(flat, flat)
}

/// Returns the angle of a face at one of its vertices.
fn angle_at(mesh: &TriMesh, face: usize, vertex: usize) -> f64 {
    let corners = mesh.faces()[face].map(|v| v as usize);
    let k = corners.iter().position(|&v| v == vertex).unwrap_or(0);
    let [p, a, b] = [0, 1, 2].map(|i| mesh.vertices()[corners[(k + i) % 3]]);
    dot(unit(sub(a, p)), unit(sub(b, p))).clamp(-1.0, 1.0).acos()
}

/// Returns the normals of the vertices: means over the faces around, weighted by angles, so that it
/// does not matter how a flat side is divided into faces. A vertex is sharp, and has none, if one
/// of its faces is turned away from the mean.
fn vertex_normals(mesh: &TriMesh, face_normals: &[Vector]) -> Vec<Option<Vector>> {
    let mut sums = vec![[0.0; 3]; mesh.vertices().len()];
    for (f, (face, normal)) in mesh.faces().iter().zip(face_normals).enumerate() {
        for v in face.map(|v| v as usize) {
            let angle = angle_at(mesh, f, v);
            sums[v] = std::array::from_fn(|i| sums[v][i] + angle * normal[i]);
        }
    }
    let mut normals: Vec<Option<Vector>> = sums.into_iter().map(|sum| Some(unit(sum))).collect();
    for (face, &flat) in mesh.faces().iter().zip(face_normals) {
        for v in face.map(|v| v as usize) {
            normals[v] = normals[v].filter(|&normal| is_near(normal, flat));
        }
    }
    normals
}

fn mix(shares: [f64; 3], corners: [Vector; 3]) -> Vector {
    std::array::from_fn(|i| (0..3).map(|k| shares[k] * corners[k][i]).sum())
}
