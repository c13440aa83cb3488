//! Draws the plant at some moments, side by side, in one picture.

use anyhow::Result;
use catamaran::io::Output;
use catamaran_geometry::mesh::TriMesh;
use catamaran_simulation::plant::{Plant, tubes};

use super::Simulation;
use crate::picture::{ColorMap, ColorScale, Paint, Panel, Scene, Up, View, render};

/// Number of moments that are shown, the first and the last among them.
const SHOWN: usize = 7;

/// Number of sides of a tube.
const SIDES: usize = 8;

/// Height of the picture, in pixels.
const HEIGHT: usize = 520;
/// Largest width of the picture, in pixels.
const LARGEST_WIDTH: usize = 2400;

/// Least thickness of tubes, as a fraction of the height of the plant, so that veins are visible.
const THINNEST: f64 = 1.0 / 400.0;

/// Draws the plant as it wilts, from left to right and to one scale, coloured by relative water
/// content.
pub fn draw_strip(plant: &Plant, simulation: &Simulation, output: Output) -> Result<()> {
    let frames = simulation.poses.len();
    let shown: Vec<usize> = match frames {
        0..=SHOWN => (0..frames).collect(),
        _ => (0..SHOWN).map(|i| i * (frames - 1) / (SHOWN - 1)).collect(),
    };
    let tails = || shown.iter().flat_map(|&i| &simulation.poses[i].tails);
    let (width, height) = (extent(tails(), 0), extent(tails(), 2));
    let size = width.max(height).max(f64::MIN_POSITIVE);
    let drawn = |&i: &usize| tubes(plant, &simulation.poses[i], SIDES, THINNEST * size);
    let moments: Vec<TriMesh> = shown.iter().map(drawn).collect::<catamaran::Result<_>>()?;
    // Tubes may be wider than the plant is by its nodes.
    let points = || moments.iter().flat_map(|mesh| mesh.vertices());
    let pitch = width.max(0.4 * height) * 1.1 + 0.02 * size;
    let pitch = pitch.max(1.05 * extent(points(), 0));
    let tall = (1.1 * height.max(0.2 * size)).max(extent(points(), 2));
    let (mut vertices, mut faces, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for (place, (mesh, &i)) in moments.into_iter().zip(&shown).enumerate() {
        let (points, triangles) = mesh.into_parts();
        let first = vertices.len() as u32;
        let shift = place as f64 * pitch;
        vertices.extend(points.into_iter().map(|[x, y, z]| [x + shift, y, z]));
        faces.extend(triangles.into_iter().map(|face| face.map(|v| v + first)));
        for (water, full) in simulation.water[i].iter().zip(&simulation.full) {
            values.extend([water / full; 2 * SIDES]);
        }
    }
    let mesh = TriMesh::new(vertices, faces)?;
    // The view is from the front, so that all moments are equally far.
    let projection = crate::picture::Projection::Orthographic;
    let view = View { azimuth: 0.0, elevation: 8.0, up: Up::Z, projection };
    let wide = HEIGHT as f64 * pitch * shown.len() as f64 / tall;
    let panel = Panel { mesh: &mesh, paint: Paint::Values(&values), view, title: "" };
    let scale = ColorScale { map: ColorMap::Sequential, low: 0.0, high: 1.0 };
    let scene = Scene {
        panels: vec![panel],
        size: ((wide as usize).clamp(HEIGHT / 2, LARGEST_WIDTH), HEIGHT),
        scale: Some(scale),
        ..Scene::default()
    };
    render(&scene)?.write(output)
}

/// Returns the extent of points along an axis.
fn extent<'a>(points: impl Iterator<Item = &'a [f64; 3]>, axis: usize) -> f64 {
    let (low, high) = points.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
        (low.min(p[axis]), high.max(p[axis]))
    });
    high - low
}
