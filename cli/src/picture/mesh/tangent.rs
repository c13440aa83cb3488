//! Normal maps, and the light of rough and shining, plain and metallic surfaces.

use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::mesh::vector::{Vector, dot, unit};

use super::Texture;
use super::camera::Camera;
use super::lamp::LAMPS;
use crate::picture::color::to_light;

/// Share of the light that a surface other than metal reflects straight back.
const DIELECTRIC: f64 = 0.04;
/// The ambient light that a mirror shows: at the horizon, and the change of it to above and below.
const SKY: (f64, f64) = (0.42, 0.34);
/// Least roughness that is drawn, because lamps have a size.
const SMOOTHEST: f64 = 0.12;

/// The direction of growing u on a face as the viewer sees it, and whether growing v is to the left
/// of this direction, seen from outside.
#[derive(Debug, Clone, Copy)]
pub struct Tangent {
    along: Vector,
    side: f64,
}

impl Tangent {
    /// Returns the tangents of all faces; zero where the texture has no area.
    pub fn of_faces(mesh: &TriMesh, uv: &[[[f64; 2]; 3]], camera: &Camera) -> Vec<Self> {
        let of = |(face, [p, q, r]): (&[u32; 3], &[[f64; 2]; 3])| {
            let [a, b, c] = face.map(|v| mesh.vertices()[v as usize]);
            let (d, e) = ([q[0] - p[0], q[1] - p[1]], [r[0] - p[0], r[1] - p[1]]);
            let side = (d[0] * e[1] - d[1] * e[0]).signum();
            let along = |k: usize| side * (e[1] * (b[k] - a[k]) - d[1] * (c[k] - a[k]));
            Self { along: camera.turn(unit([0, 1, 2].map(along))), side }
        };
        mesh.faces().iter().zip(uv).map(of).collect()
    }

    /// Returns the normal that is given in the frame of tangent, bitangent and `normal`.
    pub fn raised(&self, normal: Vector, [x, y, z]: Vector) -> Vector {
        let out = dot(self.along, normal);
        let t = unit([0, 1, 2].map(|k| self.along[k] - out * normal[k]));
        let b = [
            normal[1] * t[2] - normal[2] * t[1],
            normal[2] * t[0] - normal[0] * t[2],
            normal[0] * t[1] - normal[1] * t[0],
        ];
        unit([0, 1, 2].map(|k| x * t[k] + self.side * y * b[k] + z * normal[k]))
    }
}

/// The material of a texture at a point.
#[derive(Debug, Clone, Copy)]
pub struct Finish {
    /// The normal in the frame of the surface.
    pub normal: Vector,
    roughness: f64,
    metalness: f64,
    glow: Vector,
}

impl Finish {
    /// Returns the finish of a point of a face, if the texture has a material.
    pub fn at(texture: &Texture<'_>, face: usize, shares: [f64; 3]) -> Option<Self> {
        let material = texture.material?;
        let normal = |t: usize| material.normals[t].map(|x| f64::from(x) / 127.5 - 1.0);
        let numbers = |t: usize| {
            [material.roughness[t], material.metalness[t], 0].map(|x| f64::from(x) / 255.0)
        };
        let [roughness, metalness, _] = texture.mixed(face, shares, numbers);
        let glow = material
            .glow
            .map_or([0.0; 3], |glow| texture.mixed(face, shares, |t| to_light(glow[t])));
        Some(Self { normal: texture.mixed(face, shares, normal), roughness, metalness, glow })
    }

    /// Returns the light that is sent to the viewer by a surface of this colour and normal; `lit`
    /// is the share that a dull surface sends of its colour.
    pub fn light(&self, color: Vector, lit: f64, normal: Vector) -> Vector {
        let facing = normal[2].clamp(0.0, 1.0);
        let reflected = self.reflected(normal);
        // Grazing angles reflect more (Schlick 1994), unless the surface is rough.
        let grazing = (1.0 - facing).powi(5) * (1.0 - self.roughness);
        [0, 1, 2].map(|k| {
            let straight = DIELECTRIC + self.metalness * (color[k] - DIELECTRIC);
            let mirror = straight + (1.0 - straight) * grazing;
            color[k] * (1.0 - self.metalness) * lit + mirror * reflected + self.glow[k]
        })
    }

    /// Returns the reflection of a mirror of this roughness: a sky, and both lamps, wider for a
    /// rougher mirror (Phong 1975).
    fn reflected(&self, normal: Vector) -> f64 {
        let back = [0, 1, 2].map(|k| 2.0 * normal[2] * normal[k] - [0.0, 0.0, 1.0][k]);
        let width = self.roughness.max(SMOOTHEST).powi(4);
        let sharpness = 0.5 / width;
        let lamps: f64 =
            LAMPS.iter().map(|(to, bright)| bright * dot(back, *to).max(0.0).powf(sharpness)).sum();
        let sky = SKY.0 + SKY.1 * back[1] * (1.0 - 0.6 * self.roughness);
        sky + lamps * (0.25 * (sharpness + 1.0)).clamp(0.5, 8.0)
    }
}
