//! The station of slime moulds: a surface that is overgrown.

use std::time::Instant;

use anyhow::Result;
use catamaran::Par;
use catamaran_charts::svg;
use catamaran_geometry::mesh::families;
use catamaran_simulation::texture::slime::{Mask, Options, Simulation, Surface, atlas};
use minijinja::context;

use super::Site;
use super::page::Station;
use crate::picture::{Up, View};
use crate::progress::Bar;
use crate::slime::{chart, draw};

/// Pixels of a side of a picture.
const PIXELS: usize = 560;

/// Computes and describes it.
pub fn station(site: &Site<'_>) -> Result<Station> {
    let bar = Bar::new("slime");
    let (agents, size, steps) = if site.small { (20_000, 512, 60) } else { (200_000, 1024, 300) };
    let early = steps / 10;
    let mesh = families::knot(2, 3, 120, 16, 0.45)?;
    let surface = Surface::of_faces(&mesh, atlas(&mesh, size)?)?;
    let options = Options::new()
        .agents(agents)
        .size(size)
        .species(3)
        .vision_distance(1.5)
        .movement_speed(2.0);
    let mut all = Simulation::new(surface, &options, &Mask::default())?;
    let now =
        |s: &Simulation| (f64::from(s.state().step) * options.time_step, s.coverage(Par::all()));
    let mut moments = vec![now(&all)];
    let view = View { up: Up::Z, azimuth: 10.0, elevation: 60.0, ..View::DEFAULT };
    let start = Instant::now();
    for step in 1..=steps {
        all.step(Par::all());
        moments.push(now(&all));
        bar.step(f64::from(step) / f64::from(steps))?;
        if step == early {
            draw(&mesh, &all, view, PIXELS)?.write(site.file("slime-early.png")?)?;
        }
    }
    let milliseconds = 1e3 * start.elapsed().as_secs_f64() / f64::from(steps);
    draw(&mesh, &all, view, PIXELS)?.write(site.file("slime.png")?)?;
    drop(bar);
    let lost = usize::from(all.state().check(all.surface()).is_err());
    let species = all.coverage(Par::all()).into_iter().enumerate().map(|(number, c)| {
        let percent = |part: f64| format!("{:.1}", 100.0 * part);
        context! { number, coverage => percent(c.coverage), presence => percent(c.presence) }
    });
    let values = context! {
        agents,
        milliseconds => format!("{milliseconds:.1}"),
        agents_lost => lost,
        early,
        steps,
        coverage => svg(&[chart(&moments)]),
        species => species.collect::<Vec<_>>(),
    };
    Station::new("slime", "Slime moulds", include_str!("stations/slime.html"), values)
}
