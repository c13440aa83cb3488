//! A lit picture of the surface in its texture.

use anyhow::Result;
use catamaran::mesh::TriMesh;
use catamaran::texture::slime::{GOAL, OBSTACLE, Simulation};

use crate::picture::{Image, Paint, Panel, Scene, Texture, View, render};

/// Where nothing is, in an attractor, and on an obstacle.
const BARE: [f64; 3] = [40.0, 44.0, 52.0];
const ATTRACTOR: [f64; 3] = [46.0, 92.0, 60.0];
const WALL: [f64; 3] = [128.0, 128.0, 134.0];

/// Colours of pheromone, again from the first when there are more species.
const COLORS: [[f64; 3]; 6] = [
    [255.0, 205.0, 80.0],
    [90.0, 190.0, 255.0],
    [255.0, 110.0, 140.0],
    [150.0, 230.0, 130.0],
    [200.0, 150.0, 255.0],
    [240.0, 240.0, 240.0],
];

/// The colour of each texel.
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

/// The surface as it is now, `pixels` high and wide.
pub fn draw(mesh: &TriMesh, simulation: &Simulation, view: View, pixels: usize) -> Result<Image> {
    let texels = colors(simulation);
    let texture = Texture {
        uv: simulation.surface().uv(),
        size: simulation.texels().size(),
        texels: &texels,
    };
    let panel = Panel { mesh, paint: Paint::Texture(texture), view, title: "" };
    render(&Scene { panels: vec![panel], size: (pixels, pixels), ..Scene::default() })
}
