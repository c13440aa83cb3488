//! The station of plants: one that dries out, and one whose stem is damaged.

use std::time::Instant;

use anyhow::Result;
use catamaran::Par;
use catamaran::base::Progress;
use catamaran::plant::families::{GrowthOptions, grow};
use catamaran::plant::{Bdf6, Start, Tissue, WaterModel, WaterOptions};
use catamaran_charts::svg;

use super::Site;
use super::page::{Figure, Station, Table};
use crate::progress::Bar;
use crate::wilt::{Simulation, Weather, chart, draw_strip, simulate};

/// Nodes, and the same when small inputs are wanted.
const NODES: usize = 1500;
const SMALL_NODES: usize = 200;
/// Nodes of the plants whose water is timed.
const TIMED: [usize; 3] = [2_000, 50_000, 1_000_000];
/// The node of the stem that is cut.
const CUT: usize = 14;

/// Computes and describes it.
pub fn station(site: &Site<'_>) -> Result<Station> {
    let bar = Bar::new("plants");
    let nodes = if site.small { SMALL_NODES } else { NODES };
    let plant = grow(&GrowthOptions::new().nodes(nodes).seed(2))?;
    let weather = Weather {
        hours: 48.0,
        frames: if site.small { 6 } else { 12 },
        loss: 60.0,
        nights: false,
        conductance: 1e-9,
        tissue: Tissue::default(),
        stomata: None,
        soil: None,
        rewatering: vec![],
        damage: vec![],
        film: None,
        par: Par::all(),
    };
    let update = |done| bar.update(done);
    let progress = Progress::new(&update);
    let start = Instant::now();
    let dry = simulate(&plant, &weather, progress.part(0.0..0.4))?;
    let seconds = start.elapsed().as_secs_f64();
    draw_strip(&plant, &dry, site.file("wilting.png")?)?;
    let damaged = Weather { damage: vec![(CUT, 0.0)], nights: true, ..weather };
    let cut = simulate(&plant, &damaged, progress.part(0.4..0.8))?;
    draw_strip(&plant, &cut, site.file("cut.png")?)?;
    let timed = if site.small { &TIMED[..1] } else { &TIMED[..] };
    let times = timed.iter().map(|&nodes| times(nodes)).collect::<Result<Vec<_>>>()?;
    drop(bar);
    let left = |run: &Simulation| {
        run.water.last().map_or(0.0, |w| w.iter().sum::<f64>()) / run.full.iter().sum::<f64>()
    };
    let picture = |name: &str, caption: String| Figure {
        body: format!("<img src=\"{name}\" alt=\"{caption}\" width=\"100%\">"),
        caption,
        wide: true,
    };
    Ok(Station {
        id: "plant",
        title: "Plants that wilt",
        text: "<p>Leaves lose water, the stem passes on what it has, and the stiffness of every piece follows from what is \
               left in it. The water comes from an elimination that takes a few nanoseconds a node and never subtracts; the \
               pose is the one in which elastic energy and weight are in balance.</p>"
            .into(),
        numbers: vec![
            (format!("{:.0} %", 100.0 * left(&dry)), "of the water left after 48 hours"),
            (format!("{seconds:.2} s"), "for all frames, water and poses"),
            (format!("{}", dry.iterations.max(cut.iterations)), "Newton iterations a pose, at most"),
        ],
        figures: vec![
            picture("wilting.png", format!("A plant of {nodes} nodes in 48 hours of drought. Colours: relative water content.")),
            picture("cut.png", "The same with a stem that passes no water, by days and nights.".into()),
            Figure {
                body: svg(&[chart(&plant, &dry)]),
                caption: "Relative water content of leaves, stem and all; thin lines are single nodes.".into(),
                wide: false,
            },
        ],
        tables: vec![Table {
            caption: "Time of the water, all cores.".into(),
            head: vec!["nodes", "a step of BDF6, ms", "any time at once, ms"],
            text_columns: 0,
            rows: times,
        }],
    })
}

/// A row of the table: a step, and an evaluation at some time.
fn times(nodes: usize) -> Result<Vec<String>> {
    const STEPS: usize = 10;
    let plant = grow(&GrowthOptions::new().nodes(nodes))?;
    let model = WaterModel::new(&plant, &WaterOptions::default())?;
    let full = model.full();
    let mut bdf = Bdf6::new(&model, &full, 600.0, Start::Radau, Par::all())?;
    (0..6).for_each(|_| bdf.step());
    let start = Instant::now();
    (0..STEPS).for_each(|_| bdf.step());
    let step = start.elapsed().as_secs_f64() / STEPS as f64;
    let start = Instant::now();
    model.water_after(&full, 3e4, Par::all())?;
    let evaluation = start.elapsed().as_secs_f64();
    Ok(vec![nodes.to_string(), format!("{:.3}", 1e3 * step), format!("{:.2}", 1e3 * evaluation)])
}
