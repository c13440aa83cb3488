//! The station of plants: one that dries out, and one whose stem is damaged.

use std::time::Instant;

use anyhow::Result;
use catamaran::Par;
use catamaran::base::Progress;
use catamaran_charts::svg;
use catamaran_simulation::plant::families::{GrowthOptions, grow};
use catamaran_simulation::plant::{Bdf6, Start, Tissue, WaterModel, WaterOptions};
use minijinja::context;
use minijinja::value::Value;

use super::Site;
use super::page::Station;
use crate::progress::Bar;
use crate::wilt::{Simulation, Weather, chart, draw_strip, simulate};

/// Nodes: of many fewer, most are stem, which does not wilt in two days.
const NODES: usize = 1500;
/// Nodes of the plants whose water is timed.
const TIMED: [usize; 3] = [2_000, 50_000, 1_000_000];
/// The node of the stem that is cut.
const CUT: usize = 14;

/// Computes and describes it.
pub fn station(site: &Site<'_>) -> Result<Station> {
    let bar = Bar::new("plants");
    let plant = grow(&GrowthOptions::new().nodes(NODES).seed(2))?;
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
    let values = context! {
        water_left => format!("{:.0}", 100.0 * left(&dry)),
        seconds => format!("{seconds:.2}"),
        iterations => dry.iterations.max(cut.iterations),
        nodes => NODES,
        water => svg(&[chart(&plant, &dry)]),
        times,
    };
    Station::new("plant", "Plants that wilt", include_str!("stations/plant.html"), values)
}

/// Returns a row of the table: the times of a step and of an evaluation.
fn times(nodes: usize) -> Result<Value> {
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
    Ok(context! {
        nodes,
        step => format!("{:.3}", 1e3 * step),
        evaluation => format!("{:.2}", 1e3 * evaluation),
    })
}
