//! Draws the lit surface with its texture.

use anyhow::Result;
use catamaran_geometry::mesh::TriMesh;
use catamaran_simulation::texture::MaterialMaps;
use catamaran_simulation::texture::slime::{GOAL, OBSTACLE, Simulation};

use crate::picture::{Image, Material, Paint, Panel, Scene, Texture, View, render};

/// Colours of bare ground, of attractors, and of obstacles.
const BARE: [f64; 3] = [40.0, 44.0, 52.0];
const ATTRACTOR: [f64; 3] = [46.0, 92.0, 60.0];
const WALL: [f64; 3] = [128.0, 128.0, 134.0];

/// Colours of pheromone; they repeat from the first for more species.
const COLORS: [[f64; 3]; 6] = [
    [255.0, 205.0, 80.0],
    [90.0, 190.0, 255.0],
    [255.0, 110.0, 140.0],
    [150.0, 230.0, 130.0],
    [200.0, 150.0, 255.0],
    [240.0, 240.0, 240.0],
];

/// Returns the colour of each texel.
pub fn colors(simulation: &Simulation) -> Vec<[u8; 3]> {
    let size = simulation.texels().size();
    let of = |texel: usize| {
        let mut color = match simulation.ground().get(texel) {
            Some(&OBSTACLE) => WALL,
            Some(&GOAL) => ATTRACTOR,
            _ => BARE,
        };
        for s in 0..simulation.species() {
            let part = f64::from(simulation.texture(s)[texel]);
            let own = COLORS[s % COLORS.len()];
            color = [0, 1, 2].map(|c| color[c] + part * (own[c] - color[c]));
        }
        color.map(|c| c.round() as u8)
    };
    (0..size * size).map(of).collect()
}

/// The subject of a picture.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// The mesh.
    pub mesh: &'a TriMesh,
    /// The texture coordinates of the corners of its faces.
    pub uv: &'a [[[f64; 2]; 3]],
    /// The simulation.
    pub simulation: &'a Simulation,
    /// The material, if there is one.
    pub maps: Option<&'a MaterialMaps>,
}

impl Subject<'_> {
    /// Draws the surface as it is now, `pixels` high and wide.
    pub fn draw(&self, view: View, pixels: usize) -> Result<Image> {
        let plain = if self.maps.is_none() { colors(self.simulation) } else { Vec::new() };
        let texture = Texture {
            uv: self.uv,
            size: self.simulation.texels().size(),
            texels: self.maps.map_or(&plain, |maps| &maps.albedo),
            material: self.maps.map(|maps| Material {
                normals: &maps.normal,
                roughness: &maps.roughness,
                metalness: &maps.metalness,
                glow: maps.glow.as_deref(),
            }),
        };
        let panel = Panel { mesh: self.mesh, paint: Paint::Texture(texture), view, title: "" };
        render(&Scene { panels: vec![panel], size: (pixels, pixels), ..Scene::default() })
    }
}

/// Draws the surface as it is now, `pixels` high and wide, with a colour for each species.
pub fn draw(mesh: &TriMesh, simulation: &Simulation, view: View, pixels: usize) -> Result<Image> {
    let uv = simulation.surface().uv();
    Subject { mesh, uv, simulation, maps: None }.draw(view, pixels)
}

/// Returns four tiles, two each way, and their texture coordinates, to show that there is no seam.
pub fn four_tiles() -> Result<(TriMesh, Vec<[[f64; 2]; 3]>)> {
    let (mut vertices, mut faces, mut uv) = (Vec::new(), Vec::new(), Vec::new());
    for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let first = vertices.len() as u32;
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
        vertices.extend(corners.map(|[x, y]| [f64::from(i + x), f64::from(j + y), 0.0]));
        for face in [[0, 1, 2], [0, 2, 3]] {
            faces.push(face.map(|k| first + k));
            uv.push(face.map(|k| corners[k as usize].map(f64::from)));
        }
    }
    Ok((TriMesh::new(vertices, faces)?, uv))
}
