//! The station of Newton's fractals: on a surface, its speed of convergence, and on the plane.

use std::time::Instant;

use anyhow::Result;
use catamaran::Par;
use catamaran::base::Progress;
use catamaran_geometry::mesh::families;
use catamaran_simulation::texture::newton::{
    Fractal, Grid, Newton, NewtonOptions, Points, Polynomial, root_color,
};
use minijinja::context;
use minijinja::value::Value;

use super::Site;
use super::page::Station;
use crate::newton::{colors, surfaces};
use crate::picture::{Image, Paint, Panel, Scene, Up, View, render};
use crate::progress::Bar;

/// Pixels along each side of the plane whose time is taken, and the same when small inputs are
/// wanted.
const SIZE: u32 = 2048;
const SMALL_SIZE: u32 = 256;
/// Pixels along each side of the plane that is shown.
const SHOWN: u32 = 700;
/// Powers that are timed.
const POWERS: [u32; 4] = [3, 5, 7, 16];

/// Computes and describes it.
pub fn station(site: &Site<'_>) -> Result<Station> {
    let bar = Bar::new("newton");
    let vertices = surface(site)?;
    bar.step(0.4)?;
    let newton = power(5, 0.0)?;
    let plane = Points::Grid(Grid::plane(SHOWN, SHOWN, [0.0; 2], 3.0));
    let fractal = newton.evaluate(plane, Par::all(), Progress::none())?;
    Image::from_pixels(SHOWN as usize, colors(&newton, &fractal))
        .write(site.file("newton-plane.png")?)?;
    bar.step(0.6)?;
    let triangles = volume(site)?;
    bar.step(0.7)?;
    let size = if site.small { SMALL_SIZE } else { SIZE };
    let times = POWERS.iter().map(|&n| row(n, size)).collect::<Result<Vec<_>>>()?;
    drop(bar);
    let values = context! {
        vertices,
        most_roots => POWERS.map(roots).last(),
        triangles,
        size,
        times,
    };
    let template = include_str!("stations/newton.html");
    Station::new("newton", "Newton's fractals in four dimensions", template, values)
}

/// Draws a basin in space, and returns the number of triangles around it.
fn volume(site: &Site<'_>) -> Result<usize> {
    let newton = power(3, 0.0)?;
    let grid = Grid::cube(if site.small { 48 } else { 160 }, 3.0);
    let fractal = newton.evaluate(Points::Grid(grid), Par::all(), Progress::none())?;
    let file = surfaces(&newton, &grid, &fractal, &[0], Par::all(), Progress::none())?;
    let colors: Vec<[u8; 3]> = vec![root_color(0, 3); file.mesh.vertices().len()];
    let view = View { azimuth: 30.0, elevation: 20.0, ..View::DEFAULT };
    let panel = Panel { mesh: &file.mesh, paint: Paint::Colors(&colors), view, title: "" };
    let scene = Scene { panels: vec![panel], size: (700, 700), ..Scene::default() };
    render(&scene)?.write(site.file("newton-volume.png")?)?;
    Ok(file.mesh.faces().len())
}

fn power(n: u32, w: f64) -> Result<Newton> {
    let polynomial = Polynomial::Power(n);
    Ok(Newton::new(&NewtonOptions::new().polynomial(polynomial).w(w))?)
}

/// Draws the surface, and returns the number of its vertices.
fn surface(site: &Site<'_>) -> Result<usize> {
    let fine = if site.small { 120 } else { 600 };
    let mesh = families::torus(2 * fine, fine, 1.0, 0.45)?;
    let positions: Vec<_> = mesh.vertices().iter().map(|p| p.map(|x| x as f32)).collect();
    let at = |w: f64| -> Result<(Newton, Fractal)> {
        let newton = power(3, w)?;
        let fractal = newton.evaluate(Points::List(&positions), Par::all(), Progress::none())?;
        Ok((newton, fractal))
    };
    let ((newton, first), (other, moved)) = (at(0.0)?, at(0.4)?);
    let slow: Vec<f64> = first.convergence.iter().map(|&t| newton.share(t).sqrt()).collect();
    let [now, later] = [colors(&newton, &first), colors(&other, &moved)];
    let view = View { azimuth: 25.0, elevation: 40.0, up: Up::Z, ..View::DEFAULT };
    let panels = [
        (Paint::Colors(&now), "root"),
        (Paint::Values(&slow), "convergence"),
        (Paint::Colors(&later), "root at w = 0.4"),
    ];
    let panels = panels.map(|(paint, title)| Panel { mesh: &mesh, paint, view, title });
    let scene =
        Scene { panels: panels.into(), size: (520, 460), legend: false, ..Scene::default() };
    render(&scene)?.write(site.file("newton.png")?)?;
    Ok(positions.len())
}

/// Returns a row of the table.
fn row(n: u32, size: u32) -> Result<Value> {
    let newton = power(n, 0.0)?;
    let points = Points::Grid(Grid::plane(size, size, [0.0; 2], 3.0));
    let start = Instant::now();
    newton.evaluate(points, Par::all(), Progress::none())?;
    let seconds = start.elapsed().as_secs_f64();
    let rate = f64::from(size) * f64::from(size) / seconds / 1e6;
    Ok(context! {
        power => n,
        roots => roots(n),
        milliseconds => format!("{:.1}", 1e3 * seconds),
        rate => format!("{rate:.1}"),
    })
}

/// Returns the number of roots of z^n = 1 among bicomplex numbers.
fn roots(n: u32) -> u32 {
    n * n
}
