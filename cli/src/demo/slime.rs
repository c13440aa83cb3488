//! The station of slime moulds: a surface that is overgrown.

use std::time::Instant;

use anyhow::Result;
use catamaran::Par;
use catamaran::mesh::families;
use catamaran::texture::slime::{Mask, Options, Simulation, Surface, atlas};
use catamaran_charts::svg;

use super::Site;
use super::page::{Figure, Station, Table};
use crate::picture::{Up, View};
use crate::progress::Bar;
use crate::slime::{chart, draw};

/// Pixels of a side of a picture.
const PIXELS: usize = 560;

/// Computes and describes it.
pub fn station(site: &Site<'_>) -> Result<Station> {
    let bar = Bar::new("slime");
    let (agents, size, steps) = if site.small { (20_000, 512, 60) } else { (200_000, 1024, 300) };
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
        if step == steps / 10 {
            draw(&mesh, &all, view, PIXELS)?.write_png(site.file("slime-early.png")?)?;
        }
    }
    let milliseconds = 1e3 * start.elapsed().as_secs_f64() / f64::from(steps);
    draw(&mesh, &all, view, PIXELS)?.write_png(site.file("slime.png")?)?;
    drop(bar);
    let lost = usize::from(all.state().check(all.surface()).is_err());
    let picture = |name: &str, caption: String| Figure {
        body: format!("<img src=\"{name}\" alt=\"{caption}\" width=\"100%\">"),
        caption,
        wide: false,
    };
    let rows = all.coverage(Par::all()).into_iter().enumerate().map(|(s, c)| {
        let percent = |part: f64| format!("{:.1}", 100.0 * part);
        vec![format!("{s}"), percent(c.coverage), percent(c.presence)]
    });
    Ok(Station {
        id: "slime",
        title: "Slime moulds",
        text: "<p>Agents walk straight over the triangles, smell what others left in a texture, and turn towards it. Three species \
               attract their own kind and repel the others. The mesh has no texture coordinates: each triangle has its own place \
               in the texture, and pheromone spreads across the seams.</p>"
            .into(),
        numbers: vec![
            (format!("{agents}"), "agents"),
            (format!("{milliseconds:.1} ms"), "a step, on all cores"),
            (format!("{lost}"), "agents lost"),
        ],
        figures: vec![
            picture("slime-early.png", format!("After {} steps.", steps / 10)),
            picture("slime.png", format!("After {steps} steps.")),
            Figure {
                body: svg(&[chart(&moments)]),
                caption: "What the species cover: pheromone, and dashed the part of the surface with any.".into(),
                wide: false,
            },
        ],
        tables: vec![Table {
            caption: "In the end, in percent of the surface.".into(),
            head: vec!["species", "coverage", "presence"],
            text_columns: 0,
            rows: rows.collect(),
        }],
    })
}
