//! Figures of shapes: naive stiffness in comparison with that of water, a hanging plant, a pinned
//! plant.

use catamaran::Par;
use catamaran_simulation::plant::{
    Elasticity, MotionOptions, Plant, Pose, RelaxOptions, RodOptions, Rods, Segment, SwayOptions,
    WaterModel, WaterOptions, WiltOptions, grams_per_hour, sway, wilt,
};

use super::{Part, Subject};
use crate::Result;
use crate::curves::Plot;

/// Returns the nodes as seen from the side, in cm.
fn side(name: &str, pose: &Pose) -> (String, Vec<(f64, f64)>) {
    let points = pose.tails.iter().map(|tail| (100.0 * tail[0], 100.0 * tail[2])).collect();
    (name.into(), points)
}

fn sideways(title: String, series: Vec<(String, Vec<(f64, f64)>)>) -> Plot {
    Plot { title, across: "cm".into(), logarithmic: false, scattered: true, series }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    values.sum::<f64>() / count
}

/// Returns the mean height above the base, in metres.
fn height(plant: &Plant, pose: &Pose) -> f64 {
    mean(pose.tails.iter().map(|tail| tail[2])) - plant.base()[2]
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// Returns the number of segments between the root and each node.
fn depths(plant: &Plant) -> Vec<f64> {
    let depth = |v: usize| {
        let mut depth = 0.0;
        let mut at = v;
        while let Some(p) = plant.parent(at) {
            depth += 1.0;
            at = p;
        }
        depth
    };
    (0..plant.len()).map(depth).collect()
}

/// Computes figure 4.5: poses of plants whose stiffness is `1 / (1 + d)`, where d is the distance
/// from the root in segments, or linear in the radius, or that of their water, all with the same
/// modulus at the root.
///
/// # Errors
/// The errors of the model and of the rods.
pub fn naive(subjects: &[Subject]) -> Result<Part> {
    let mut rows = Vec::new();
    let mut plots = Vec::new();
    for subject in subjects {
        let plant = &subject.plant;
        let mut model = subject.model.clone();
        model.set_loss(grams_per_hour(120.0))?;
        let full = model.full();
        let water = model.water_after(&full, 36.0 * 3600.0, Par::all())?;
        let ours = Elasticity::default().moduli(&water, &full)?;
        let (root, segments) = (plant.root(), plant.segments());
        let distance: Vec<f64> = depths(plant).iter().map(|d| ours[root] / (1.0 + d)).collect();
        let unit = ours[root] / segments[root].radius;
        let radius: Vec<f64> = segments.iter().map(|s| unit * s.radius).collect();
        let start = relaxed(plant, &Elasticity::default().moduli(&full, &full)?, &full)?;
        let reference = relaxed(plant, &ours, &water)?;
        let mut series = Vec::new();
        for (name, moduli) in [("1 / (1 + d)", distance), ("radius", radius), ("water", ours)] {
            let pose = relaxed(plant, &moduli, &water)?;
            let gaps = pose.tails.iter().zip(&reference.tails).map(|(a, b)| apart(*a, *b));
            let leaves: Vec<f64> =
                (0..plant.len()).filter(|&v| segments[v].leaf).map(|v| moduli[v]).collect();
            rows.push((
                format!("{}, {name}", subject.name),
                vec![
                    mean(leaves.into_iter()) / moduli[root],
                    height(plant, &pose) / height(plant, &start),
                    100.0 * mean(gaps),
                ],
            ));
            series.push(side(name, &pose));
        }
        series.insert(0, side("full", &start));
        plots.push(sideways(
            format!(
                "Figure 4.5: {} from the side, cm, by what its stiffness follows",
                subject.name
            ),
            series,
        ));
    }
    let columns = [
        "E of leaves / E of the root",
        "mean height / that when full",
        "mean distance from ours, cm",
    ];
    Ok(Part {
        figure: "figure 4.5",
        title: "naive stiffness beside that of the water after 36 hours at 120 g / (h m^2), the same at the root; \
                the thesis shows pictures only, and finds the variation of stiffness in the third"
            .into(),
        columns: columns.map(String::from).into(),
        rows,
        plots,
    })
}

fn relaxed(plant: &Plant, moduli: &[f64], water: &[f64]) -> Result<Pose> {
    let mut rods = Rods::new(plant, &RodOptions::default())?;
    rods.set_state(moduli, water)?;
    let mut pose = rods.rest_pose();
    rods.relax(&mut pose, &RelaxOptions::default())?;
    Ok(pose)
}

/// Returns the plant with other segments.
fn changed(plant: &Plant, segments: Vec<Segment>, base: [f64; 3]) -> Result<Plant> {
    let parents: Vec<Option<u32>> =
        (0..plant.len()).map(|v| plant.parent(v).map(|p| p as u32)).collect();
    Ok(Plant::new(segments, &parents, Some(base))?)
}

/// Computes figure 4.8: a plant that hangs from its base and dries slowly.
///
/// # Errors
/// The errors of the model and of the rods.
pub fn hanging(subjects: &[Subject]) -> Result<Part> {
    let upright = &subjects[0].plant;
    let down = |p: [f64; 3]| [p[0], p[1], -p[2]];
    let segments =
        upright.segments().iter().map(|s| Segment { tail: down(s.tail), ..*s }).collect();
    let plant = changed(upright, segments, down(upright.base()))?;
    let model = WaterModel::new(&plant, &WaterOptions::new().loss(grams_per_hour(15.0)))?;
    let rods = Rods::new(&plant, &RodOptions::default())?;
    let days = [0.0, 8.0, 16.0, 32.0, 64.0];
    let e = Elasticity::Relative { dry: 3e5, full: 5e7, steepness: 5.0, shift: 0.75 };
    let times = days.map(|day| 86_400.0 * day);
    let found = wilt(&model, &rods, &times, &WiltOptions::new().elasticity(e))?;
    let full: f64 = model.full().iter().sum();
    let base = plant.base();
    let rows = days.iter().zip(found.poses.iter().zip(&found.water)).map(|(day, (pose, water))| {
        let aside = pose.tails.iter().map(|t| (t[0] - base[0]).hypot(t[1] - base[1]));
        let values = vec![
            water.iter().sum::<f64>() / full,
            -100.0 * height(&plant, pose),
            100.0 * mean(aside),
        ];
        (format!("{day} days"), values)
    });
    let columns = ["water", "mean depth below the base, cm", "mean distance from the axis, cm"];
    Ok(Part {
        figure: "figure 4.8",
        title: format!(
            "{} upside down, as ivy that hangs: 15 g / (h m^2), kappa = 5; the thesis shows pictures only",
            subjects[0].name
        ),
        columns: columns.map(String::from).into(),
        rows: rows.collect(),
        plots: vec![sideways(
            "Figure 4.8: a plant that hangs, from the side, cm".into(),
            [0, 2, 4].map(|i| side(&format!("{} days", days[i]), &found.poses[i])).into(),
        )],
    })
}

/// Computes figure 4.9: the largest plant, with its main stem pinned at several places, and without
/// pins.
///
/// # Errors
/// The errors of the model and of the rods.
pub fn held(subjects: &[Subject]) -> Result<Part> {
    const PINS: usize = 6;
    let largest = subjects.iter().max_by_key(|s| s.plant.len()).ok_or("no plant")?;
    let plant = &largest.plant;
    let free: Vec<Segment> =
        plant.segments().iter().map(|s| Segment { pinned: false, ..*s }).collect();
    // The main stem: the path to the node farthest from the root along the plant.
    let reach = depths(plant);
    let tip = (0..plant.len()).max_by(|&a, &b| reach[a].total_cmp(&reach[b])).unwrap_or(0);
    let mut stem = vec![tip];
    while let Some(p) = plant.parent(stem[stem.len() - 1]) {
        stem.push(p);
    }
    let mut held = free.clone();
    (1..=PINS).for_each(|i| held[stem[(PINS - i) * (stem.len() - 1) / PINS]].pinned = true);
    let mut rows = Vec::new();
    let mut series = Vec::new();
    for (name, segments) in [("free", free), ("held", held)] {
        let plant = changed(plant, segments, plant.base())?;
        let loss = WaterOptions::new().loss(grams_per_hour(120.0));
        let model = WaterModel::new(&plant, &loss)?;
        let rods = Rods::new(&plant, &RodOptions::default())?;
        // Three days in 20 seconds, damped, so that frames are nearly at rest.
        let options = SwayOptions::new()
            .drought(72.0 * 3600.0)
            .seconds(20.0)
            .frames(3)
            .motion(MotionOptions::new().damping(4.0));
        let film = sway(&model, &rods, &options)?;
        let heights: Vec<f64> = film.poses.iter().map(|pose| height(&plant, pose)).collect();
        let on_stem = |pose: &Pose| mean(stem.iter().map(|&v| pose.tails[v][2]));
        rows.push((
            name.to_string(),
            vec![
                heights[1] / heights[0],
                heights[2] / heights[0],
                heights[3] / heights[0],
                100.0 * (on_stem(&film.poses[0]) - on_stem(&film.poses[3])),
                3.0 * film.steps as f64,
            ],
        ));
        series.push(side(&format!("{name}, 72 h"), &film.poses[3]));
        if name == "held" {
            series.insert(0, side("held, full", &film.poses[0]));
        }
    }
    let columns = [
        "mean height after 24 h",
        "48 h",
        "72 h, as parts of the first",
        "stem sunk by, cm",
        "steps of 1/60 s",
    ];
    Ok(Part {
        figure: "figure 4.9",
        title: format!(
            "{} ({} nodes) at 120 g / (h m^2), its main stem held at {PINS} places and not; the thesis: 1954 nodes, \
             2000 frames of its solver",
            largest.name,
            plant.len()
        ),
        columns: columns.map(String::from).into(),
        rows,
        plots: vec![sideways("Figure 4.9: a plant that is held, from the side, cm".into(), series)],
    })
}
