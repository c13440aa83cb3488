//! Figures of the water, and of the resulting poses.

use catamaran::Par;
use catamaran_simulation::plant::{
    Bdf6, Conductivity, Elasticity, Plant, Pose, RelaxOptions, RodOptions, Rods, Start, WaterModel,
    WaterOptions, grams_per_hour,
};

use super::{Part, Subject};
use crate::Result;
use crate::curves::Plot;

/// Computes figure 4.3: relative water content by the distance from the nearest leaf.
///
/// # Errors
/// The errors of the model.
pub fn sections(subjects: &[Subject]) -> Result<Part> {
    let subject = &subjects[0];
    let full = subject.model.full();
    let distances = leaf_distances(&subject.plant);
    let furthest = distances.iter().copied().max().unwrap_or(0);
    let classes = [0, furthest / 8, furthest / 4, furthest / 2, furthest];
    let hours: Vec<f64> = (0..=24).map(|i| 2.0 * f64::from(i)).collect();
    let mut series: Vec<(String, Vec<(f64, f64)>)> =
        classes.iter().map(|d| (format!("{d} segments from a leaf"), vec![])).collect();
    for &hour in &hours {
        let water = subject.model.water_after(&full, 3600.0 * hour, Par::all())?;
        let relative = subject.model.relative(&water)?;
        for (class, (_, points)) in classes.iter().zip(&mut series) {
            let of: Vec<f64> =
                (0..full.len()).filter(|&v| distances[v] == *class).map(|v| relative[v]).collect();
            points.push((hour, of.iter().sum::<f64>() / of.len().max(1) as f64));
        }
    }
    let rows = series
        .iter()
        .map(|(name, points)| (name.clone(), [6, 12, 24].map(|i| points[i].1).to_vec()))
        .collect();
    Ok(Part {
        figure: "figure 4.3",
        title: format!(
            "relative water content of sections of {}: the farther from a leaf, the more",
            subject.name
        ),
        columns: ["12 h", "24 h", "48 h"].map(String::from).into(),
        rows,
        plots: vec![Plot {
            title: "Figure 4.3: relative water content by section".into(),
            across: "h".into(),
            logarithmic: false,
            scattered: false,
            series,
        }],
    })
}

/// Returns the number of segments to the nearest leaf, through the tree.
fn leaf_distances(plant: &Plant) -> Vec<usize> {
    let n = plant.len();
    let mut neighbours = vec![vec![]; n];
    for v in 0..n {
        if let Some(p) = plant.parent(v) {
            neighbours[v].push(p);
            neighbours[p].push(v);
        }
    }
    let mut distances = vec![usize::MAX; n];
    let mut waiting: std::collections::VecDeque<usize> =
        (0..n).filter(|&v| plant.segments()[v].leaf).collect();
    waiting.iter().for_each(|&v| distances[v] = 0);
    while let Some(v) = waiting.pop_front() {
        for &u in &neighbours[v] {
            if distances[u] == usize::MAX {
                distances[u] = distances[v] + 1;
                waiting.push_back(u);
            }
        }
    }
    distances
}

/// Computes figure 4.4: the relative mean squared error of BDF6 over time, for several steps,
/// averaged over the plants; with the start of Radau and with the constant start of the thesis.
///
/// # Errors
/// The errors of the model.
pub fn errors_over_time(subjects: &[Subject]) -> Result<Vec<Part>> {
    let divisions = [16, 64, 256];
    let mut parts = Vec::new();
    for (start, name) in
        [(Start::Radau, "Radau"), (Start::Constant, "the constant one of the thesis")]
    {
        let mut series = Vec::new();
        for division in divisions {
            let mut sums = [0.0; 17];
            for subject in subjects {
                let full = subject.model.full();
                let step = subject.half_time() / f64::from(division);
                let mut bdf = Bdf6::new(&subject.model, &full, step, start, Par::all())?;
                for (i, sum) in sums.iter_mut().enumerate().skip(1) {
                    (0..division / 4).for_each(|_| bdf.step());
                    let seconds = i as f64 * subject.half_time() / 4.0;
                    let exact = subject.model.water_after(&full, seconds, Par::all())?;
                    *sum += relative_mse(&bdf.water(), &exact) / subjects.len() as f64;
                }
            }
            let points = sums.iter().enumerate().skip(1).map(|(i, e)| (i as f64 / 4.0, *e));
            series.push((format!("half-time / {division}"), points.collect::<Vec<_>>()));
        }
        parts.push(Part {
            figure: "figure 4.4",
            title: format!(
                "relative mean squared error of BDF6, start: {name}; means of {} plants",
                subjects.len()
            ),
            columns: ["after 1 half-time", "2", "4"].map(String::from).into(),
            rows: series
                .iter()
                .map(|(name, points)| (name.clone(), [3, 7, 15].map(|i| points[i].1).to_vec()))
                .collect(),
            plots: vec![Plot {
                title: format!("Figure 4.4: error of BDF6 over time, start: {name}"),
                across: "half-times".into(),
                logarithmic: true,
                scattered: false,
                series,
            }],
        });
    }
    Ok(parts)
}

/// Computes the reason for figure 4.4: 16 steps to the half-time at several scales of the
/// conductance, and how many rates of the plant lie between its steps.
///
/// # Errors
/// The errors of the model.
pub fn errors_by_conductance(subjects: &[Subject]) -> Result<Part> {
    const STEPS: u32 = 16;
    let mut rows = Vec::new();
    for scale in [1e-10, 1e-9, 1e-8, 1e-7, 1e-6] {
        let (mut error, mut between) = (0.0, 0.0);
        for subject in subjects {
            let options = WaterOptions::new().conductivity(Conductivity::Pipe { scale });
            let model = WaterModel::new(&subject.plant, &options)?;
            let full = model.full();
            let step = subject.half_time() / f64::from(STEPS);
            let mut bdf = Bdf6::new(&model, &full, step, Start::Radau, Par::all())?;
            (0..STEPS).for_each(|_| bdf.step());
            let exact = model.water_after(&full, subject.half_time(), Par::all())?;
            error += relative_mse(&bdf.water(), &exact) / subjects.len() as f64;
            // The rates of leaves that lose water faster than the stem supplies it.
            let own = model.losses().into_iter().zip(model.exchanges()).zip(&full);
            let rates = own.map(|((loss, exchange), full)| loss + exchange / full);
            let live = rates.filter(|rate| (0.3..10.0).contains(&(rate * step))).count();
            between += live as f64 / full.len() as f64 / subjects.len() as f64;
        }
        rows.push((format!("chi = {scale:e}"), vec![error, 100.0 * between]));
    }
    Ok(Part {
        figure: "figure 4.4",
        title: format!(
            "errors of {STEPS} steps of BDF6 over the conductance chi, beside how many nodes exchange water at rates near one \
             over a step, which no multistep formula resolves (water_after has 1e-13)"
        ),
        columns: ["relative mean squared error", "nodes with a rate of 0.3 to 10 a step, %"]
            .map(String::from)
            .into(),
        rows,
        plots: vec![],
    })
}

fn relative_mse(water: &[f64], exact: &[f64]) -> f64 {
    let error: f64 = water.iter().zip(exact).map(|(a, b)| (a - b) * (a - b)).sum();
    error / exact.iter().map(|x| x * x).sum::<f64>()
}

/// Computes figure 4.6: the deviation of the total water from an exponential that is fitted to its
/// logarithm over 48 hours.
///
/// # Errors
/// The errors of the model.
pub fn total_water(subjects: &[Subject]) -> Result<Part> {
    let mut rows = Vec::new();
    let mut series = Vec::new();
    for subject in subjects {
        let full = subject.model.full();
        let whole: f64 = full.iter().sum();
        let mut points = Vec::new();
        for hour in (0..=48).step_by(2).map(f64::from) {
            let water = subject.model.water_after(&full, 3600.0 * hour, Par::all())?;
            points.push((hour, water.iter().sum::<f64>() / whole));
        }
        // The least squares line through the logarithms.
        let count = points.len() as f64;
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / count;
        let (x, y) = (mean(&|p| p.0), mean(&|p| p.1.ln()));
        let slope = mean(&|p| (p.0 - x) * (p.1.ln() - y)) / mean(&|p| (p.0 - x).powi(2));
        let rest = mean(&|p| (p.1.ln() - y - slope * (p.0 - x)).powi(2));
        let explained = 1.0 - rest / mean(&|p| (p.1.ln() - y).powi(2));
        rows.push((
            subject.name.clone(),
            vec![points[12].1, points[24].1, -1.0 / slope, explained],
        ));
        series.push((subject.name.clone(), points));
    }
    let columns = ["left after 24 h", "after 48 h", "time constant, h", "R^2 of an exponential"];
    Ok(Part {
        figure: "figure 4.6",
        title: "total water: exponential, as measured on two tomato plants".into(),
        columns: columns.map(String::from).into(),
        rows,
        plots: vec![Plot {
            title: "Figure 4.6: total water, as a part of the initial one".into(),
            across: "h".into(),
            logarithmic: true,
            scattered: false,
            series,
        }],
    })
}

/// Returns the pose of a plant with this water, from the current pose.
fn relax(
    rods: &mut Rods,
    pose: &mut Pose,
    model: &WaterModel,
    water: &[f64],
    e: Elasticity,
) -> Result<usize> {
    rods.set_state(&e.moduli(water, &model.full())?, water)?;
    Ok(rods.relax(pose, &RelaxOptions::default())?.iterations)
}

/// Returns the mean height of some nodes, in metres.
fn height(pose: &Pose, members: &[usize]) -> f64 {
    members.iter().map(|&v| pose.tails[v][2]).sum::<f64>() / members.len().max(1) as f64
}

/// Computes figure 4.7: how far a plant sinks in two days, for several losses and steepnesses.
///
/// # Errors
/// The errors of the model and of the rods.
pub fn grid(subjects: &[Subject]) -> Result<Part> {
    let subject = &subjects[0];
    let all: Vec<usize> = (0..subject.plant.len()).collect();
    let steepnesses = [5.0, 10.0, 20.0];
    let mut rows = Vec::new();
    let mut iterations = 0;
    for loss in [30.0, 60.0, 120.0, 240.0] {
        let mut model = subject.model.clone();
        model.set_loss(grams_per_hour(loss))?;
        let mut cells = Vec::new();
        for steepness in steepnesses {
            let e = Elasticity::Relative { dry: 3e5, full: 5e7, steepness, shift: 0.75 };
            let mut rods = Rods::new(&subject.plant, &RodOptions::default())?;
            let mut pose = rods.rest_pose();
            let full = model.full();
            relax(&mut rods, &mut pose, &model, &full, e)?;
            let before = height(&pose, &all);
            for hour in [12.0, 24.0, 36.0, 48.0] {
                let water = model.water_after(&full, 3600.0 * hour, Par::all())?;
                iterations = iterations.max(relax(&mut rods, &mut pose, &model, &water, e)?);
            }
            cells.push(height(&pose, &all) / before);
        }
        rows.push((format!("delta = {loss} g / (h m^2)"), cells));
    }
    Ok(Part {
        figure: "figure 4.7",
        title: format!(
            "mean height of {} after 48 hours, as a part of that at first; at most {iterations} Newton iterations a pose",
            subject.name
        ),
        columns: steepnesses.map(|k| format!("kappa = {k}")).into(),
        rows,
        plots: vec![],
    })
}

/// Computes figure 4.10: a stem whose water flow is cut in the middle.
///
/// # Errors
/// The errors of the model and of the rods.
pub fn cut(subjects: &[Subject]) -> Result<Part> {
    let mut rows = Vec::new();
    for subject in subjects {
        let plant = &subject.plant;
        let beyond = above(plant, middle(plant));
        let side = |is: bool| (0..plant.len()).filter(|&v| beyond[v] == is).collect::<Vec<_>>();
        let (below, top) = (side(false), side(true));
        let mut model = subject.model.clone();
        model.set_loss(grams_per_hour(120.0))?;
        model.cut(middle(plant))?;
        // The lower part is watered.
        for &v in &below {
            model.set_loss_of(v, 0.0)?;
        }
        let full = model.full();
        let e = Elasticity::default();
        let mut rods = Rods::new(plant, &RodOptions::default())?;
        let mut pose = rods.rest_pose();
        relax(&mut rods, &mut pose, &model, &full, e)?;
        let before = [&below, &top].map(|side| height(&pose, side));
        let mut water = full.clone();
        for _ in 0..6 {
            water = model.water_after(&water, 12.0 * 3600.0, Par::all())?;
            relax(&mut rods, &mut pose, &model, &water, e)?;
        }
        let left = |side: &[usize]| {
            let sum = |values: &[f64]| side.iter().map(|&v| values[v]).sum::<f64>();
            sum(&water) / sum(&full)
        };
        let sunk = |side: &[usize], before: f64| before - height(&pose, side);
        rows.push((
            subject.name.clone(),
            vec![
                left(&below),
                left(&top),
                100.0 * sunk(&below, before[0]),
                100.0 * sunk(&top, before[1]),
            ],
        ));
    }
    Ok(Part {
        figure: "figure 4.10",
        title: "a stem that is cut for water in its middle, the lower part watered, after 72 hours at 120 g / (h m^2)"
            .into(),
        columns: ["water below", "water above", "below sunk by, cm", "above sunk by, cm"]
            .map(String::from)
            .into(),
        rows,
        plots: vec![],
    })
}

/// Returns the node whose subtree is half of the plant, or a little less.
fn middle(plant: &Plant) -> usize {
    let sizes = sizes(plant);
    let fits = |v: &usize| plant.parent(*v).is_some() && 2 * sizes[*v] <= plant.len();
    (0..plant.len()).filter(fits).max_by_key(|&v| (sizes[v], v)).unwrap_or(0)
}

fn sizes(plant: &Plant) -> Vec<usize> {
    let mut sizes = vec![0; plant.len()];
    for start in 0..plant.len() {
        let mut at = Some(start);
        while let Some(v) = at {
            sizes[v] += 1;
            at = plant.parent(v);
        }
    }
    sizes
}

/// Returns whether each node is in the subtree of this one.
fn above(plant: &Plant, node: usize) -> Vec<bool> {
    (0..plant.len())
        .map(|start| {
            let mut at = Some(start);
            while let Some(v) = at.filter(|&v| v != node) {
                at = plant.parent(v);
            }
            at.is_some()
        })
        .collect()
}
