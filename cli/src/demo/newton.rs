//! The station of Newton's fractals: on a surface, its speed of convergence, and on the plane.

use std::time::Instant;

use anyhow::Result;
use catamaran::Par;
use catamaran::base::Progress;
use catamaran::mesh::families;
use catamaran::texture::newton::{
    Fractal, Grid, Newton, NewtonOptions, Points, Polynomial, root_color,
};

use super::Site;
use super::page::{Figure, Station, Table};
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
    let points = surface(site)?;
    bar.step(0.4)?;
    let newton = power(5, 0.0)?;
    let plane = Points::Grid(Grid::plane(SHOWN, SHOWN, [0.0; 2], 3.0));
    let fractal = newton.evaluate(plane, Par::all(), Progress::none())?;
    Image::from_pixels(SHOWN as usize, colors(&newton, &fractal))
        .write_png(site.file("newton-plane.png")?)?;
    bar.step(0.6)?;
    let volume = volume(site)?;
    bar.step(0.7)?;
    let size = if site.small { SMALL_SIZE } else { SIZE };
    let rows = POWERS.iter().map(|&n| row(n, size)).collect::<Result<Vec<_>>>()?;
    drop(bar);
    let picture = |name: &str, caption: &str, wide| Figure {
        body: format!("<img src=\"{name}\" alt=\"{caption}\" width=\"100%\">"),
        caption: caption.into(),
        wide,
    };
    Ok(Station {
        id: "newton",
        title: "Newton's fractals in four dimensions",
        text: "<p>A point of a surface, with a fourth coordinate that may be the time, is a bicomplex number; Newton's method \
               takes it to one of the n<sup>2</sup> roots of z<sup>n</sup> = 1. In the idempotent basis that is two complex \
               iterations side by side, of multiplications alone, and the number of the root is read off two angles.</p>"
            .into(),
        numbers: vec![
            (points.to_string(), "vertices of the surface"),
            (rows.last().map_or_else(String::new, |row| row[1].clone()), "roots of the largest power below"),
        ],
        figures: vec![
            picture("newton.png", "z^3 = 1 on a torus: which root; how slowly it is found; which root, at w = 0.4.", true),
            picture("newton-plane.png", "z^5 = 1 on the plane, darker where it takes longer.", false),
            picture("newton-volume.png", &volume, false),
        ],
        tables: vec![Table {
            caption: format!("{size} x {size} points of the plane, 32 iterations, all cores, without OpenCL."),
            head: vec!["power", "roots", "time", "million points a second"],
            text_columns: 0,
            rows,
        }],
    })
}

/// Draws a basin in space; what is seen.
fn volume(site: &Site<'_>) -> Result<String> {
    let newton = power(3, 0.0)?;
    let grid = Grid::cube(if site.small { 48 } else { 160 }, 3.0);
    let fractal = newton.evaluate(Points::Grid(grid), Par::all(), Progress::none())?;
    let file = surfaces(&newton, &grid, &fractal, &[0], Par::all(), Progress::none())?;
    let colors: Vec<[u8; 3]> = vec![root_color(0, 3); file.mesh.vertices().len()];
    let view = View { azimuth: 30.0, elevation: 20.0, ..View::DEFAULT };
    let panel = Panel { mesh: &file.mesh, paint: Paint::Colors(&colors), view, title: "" };
    let scene = Scene { panels: vec![panel], size: (700, 700), ..Scene::default() };
    render(&scene)?.write_png(site.file("newton-volume.png")?)?;
    Ok(format!(
        "The basin of one root of z^3 = 1 in a cube: a closed surface of {} triangles.",
        file.mesh.faces().len()
    ))
}

fn power(n: u32, w: f64) -> Result<Newton> {
    let polynomial = Polynomial::Power(n);
    Ok(Newton::new(&NewtonOptions::new().polynomial(polynomial).w(w))?)
}

/// Draws the surface; the number of its vertices.
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
    render(&scene)?.write_png(site.file("newton.png")?)?;
    Ok(positions.len())
}

/// A row of the table.
fn row(n: u32, size: u32) -> Result<Vec<String>> {
    let newton = power(n, 0.0)?;
    let points = Points::Grid(Grid::plane(size, size, [0.0; 2], 3.0));
    let start = Instant::now();
    newton.evaluate(points, Par::all(), Progress::none())?;
    let seconds = start.elapsed().as_secs_f64();
    let rate = f64::from(size) * f64::from(size) / seconds / 1e6;
    Ok(vec![
        n.to_string(),
        (n * n).to_string(),
        format!("{:.1} ms", 1e3 * seconds),
        format!("{rate:.1}"),
    ])
}
