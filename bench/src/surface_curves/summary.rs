//! Tables and plots of the runs.

use catamaran_geometry::curve::dataset::Sampling;

use super::runs::{Method, Run, SIZES};
use crate::curves::Plot;

/// The thesis' tables 6.1 and 6.2, per cent in order, l = 1, 3, 5. In the text, the columns of
/// table 6.2 are shifted by one; here they are as printed, one for each number of samples.
const THESIS: [[[f64; 7]; 3]; 2] = [
    [
        [33.54, 37.63, 43.15, 40.59, 45.88, 40.53, 41.90],
        [41.86, 45.16, 45.54, 42.79, 44.50, 41.78, 39.94],
        [42.83, 46.09, 46.62, 42.69, 45.34, 43.22, 39.71],
    ],
    [
        [60.69, 14.13, 34.34, 28.90, 34.20, 28.84, 22.57],
        [63.43, 24.88, 39.81, 36.60, 37.88, 41.35, 29.22],
        [63.11, 32.12, 41.72, 39.33, 39.61, 41.62, 30.82],
    ],
];

/// Bounds of H and R of the thesis for a curve that is near enough.
const NEAR: (f64, f64) = (0.25, 0.07);

/// The horizontal axis of the charts of distances, its upper end, and the number of points on it.
const DISTANCE: &str = "distance";
const FARTHEST: f64 = 0.5;
const POINTS: usize = 50;

const KINDS: [(Sampling, &str); 2] = [(Sampling::Even, "even"), (Sampling::Random, "random")];

/// Returns the percentage of runs.
fn share<'r>(runs: impl Iterator<Item = &'r Run>, is: impl Fn(&Run) -> bool) -> f64 {
    let (all, those) =
        runs.fold((0, 0), |(all, those), run| (all + 1, those + usize::from(is(run))));
    100.0 * f64::from(those as u32) / f64::from(all as u32)
}

fn is_near(run: &Run) -> bool {
    run.hausdorff <= NEAR.0 && run.root_mean <= NEAR.1
}

fn is_near_squared(run: &Run) -> bool {
    run.hausdorff <= NEAR.0 && run.root_mean_square <= NEAR.1
}

/// A line of the record: runs on one mesh, of one number and kind of samples, by one method.
pub struct Cell(String);

impl Cell {
    /// Its columns.
    pub const HEAD: &'static str = "mesh,vertices,samples,sampling,method,runs,closed,on_vertices,ordered,near,near_squared,mean_seconds,most_seconds";

    /// Returns a line of CSV.
    pub fn line(&self) -> String {
        self.0.clone()
    }
}

/// Returns all lines of the record.
pub fn cells(runs: &[Run]) -> Vec<Cell> {
    let mut meshes: Vec<&str> = runs.iter().map(|run| run.mesh).collect();
    meshes.dedup();
    let mut cells = Vec::new();
    for mesh in meshes {
        for count in SIZES {
            for (sampling, kind) in KINDS {
                for method in Method::ALL {
                    let own: Vec<&Run> = (runs.iter())
                        .filter(|r| r.mesh == mesh && r.samples == count)
                        .filter(|r| r.sampling == sampling && r.method == method)
                        .collect();
                    let Some(first) = own.first() else { continue };
                    let part = |is: fn(&Run) -> bool| share(own.iter().copied(), is);
                    let seconds = own.iter().map(|r| r.seconds);
                    cells.push(Cell(format!(
                        "{mesh},{},{count},{kind},{},{},{:.2},{:.2},{:.2},{:.2},{:.2},{:.5},{:.5}",
                        first.vertices,
                        method.name().replace(',', ""),
                        own.len(),
                        part(|r| r.closed),
                        part(|r| r.on_vertices),
                        part(|r| r.ordered),
                        part(is_near),
                        part(is_near_squared),
                        seconds.clone().sum::<f64>() / own.len() as f64,
                        seconds.fold(0.0, f64::max),
                    )));
                }
            }
        }
    }
    cells
}

/// Returns tables 6.1 and 6.2, with the thesis' numbers in brackets. What is above every other
/// number of its column, those in brackets included, is bold.
pub fn order_table(runs: &[Run]) -> String {
    let mut text = String::new();
    for (number, ((sampling, kind), thesis)) in KINDS.into_iter().zip(THESIS).enumerate() {
        text += &format!(
            "**Table 6.{}**: samples in the right order, {kind} sampling, per cent of all runs\n\n| method | {} |\n|---|{}\n",
            number + 1,
            SIZES.map(|k| k.to_string()).join(" | "),
            "---|".repeat(SIZES.len())
        );
        let ordered = |method: Method, count: usize| {
            let own = runs
                .iter()
                .filter(|r| r.method == method && r.sampling == sampling && r.samples == count);
            share(own, |r| r.ordered)
        };
        for (m, method) in Method::ALL.into_iter().enumerate() {
            let cell = |(k, &count): (usize, &usize)| {
                let ours = ordered(method, count);
                let others = Method::ALL.into_iter().filter(|&other| other != method);
                let others = others.map(|other| ordered(other, count));
                let is_best = others.chain(thesis.map(|row| row[k])).all(|other| ours > other);
                let shown = if is_best { format!("**{ours:.1}**") } else { format!("{ours:.1}") };
                match thesis.get(m) {
                    Some(row) => format!("{shown} ({})", row[k]),
                    None => shown,
                }
            };
            let row: Vec<String> = SIZES.iter().enumerate().map(cell).collect();
            text += &format!("| {} | {} |\n", method.name(), row.join(" | "));
        }
        text.push('\n');
    }
    text
}

/// Returns figures 6.10 and 6.11: failures by mesh and by number of samples, in per cent of runs.
pub fn failures(runs: &[Run]) -> String {
    let mut meshes: Vec<(&str, usize)> = runs.iter().map(|r| (r.mesh, r.vertices)).collect();
    meshes.dedup();
    let heads = Method::ALL.map(Method::name).join(" | ");
    let rule = "---|".repeat(Method::ALL.len());
    let mut text = format!(
        "**Figure 6.10**: runs without a closed curve, by mesh, per cent\n\n| mesh | vertices | {heads} | robust, without Steiner points |\n|---|---|{rule}---|\n"
    );
    let row = |wanted: &dyn Fn(&Run) -> bool| -> String {
        let of = |method| runs.iter().filter(move |r| r.method == method && wanted(r));
        let failed = Method::ALL.map(|method| format!("{:.2}", share(of(method), |r| !r.closed)));
        let cramped = share(of(Method::Robust), |r| !r.on_vertices);
        format!("{} | {cramped:.2}", failed.join(" | "))
    };
    for (mesh, vertices) in meshes {
        text += &format!("| {mesh} | {vertices} | {} |\n", row(&|r| r.mesh == mesh));
    }
    text += &format!(
        "\n**Figure 6.11**: the same by number of samples\n\n| samples | {heads} | robust, without Steiner points |\n|---|{rule}---|\n"
    );
    for count in SIZES {
        text += &format!("| {count} | {} |\n", row(&|r| r.samples == count));
    }
    text
}

/// Returns the goals, and the results.
pub fn bars(runs: &[Run]) -> String {
    let of = |method| runs.iter().filter(move |r: &&Run| r.method == method);
    let robust = || of(Method::Robust);
    let closed_meshes = || robust().filter(|r| r.closed_mesh);
    let ordered = |sampling| {
        share(robust().filter(|r| r.samples == 25 && r.sampling == sampling), |r| r.ordered)
    };
    let mut times: Vec<f64> = robust().map(|r| r.seconds).collect();
    times.sort_by(f64::total_cmp);
    let at = |part: f64| {
        times.get(((times.len() as f64 * part) as usize).min(times.len().saturating_sub(1)))
    };
    let seconds = |part| at(part).copied().unwrap_or_default();
    let faithful = || runs.iter().filter(|r| r.method != Method::Robust);
    format!(
        "| goal, robust mode, over all runs | goal | reached | faithful |\n|---|---|---|---|\n\
         | closed, on closed connected meshes | 100 % | {:.2} % | {:.1} % |\n\
         | closed on vertices of the mesh alone, all meshes | 97 % | {:.2} % | {:.1} % |\n\
         | right order, 25 samples, even | 80 % | {:.1} % | |\n\
         | right order, 25 samples, random | 50 % | {:.1} % | |\n\
         | H <= 0.25 and R <= 0.07, R as written | 95 % | {:.1} % | {:.1} % |\n\
         | H <= 0.25 and R <= 0.07, R with squares | 95 % | {:.1} % | {:.1} % |\n\
         | 95 % of runs within | 0.25 s | {:.3} s | |\n\
         | all runs within | 2 s | {:.2} s | |\n",
        share(closed_meshes(), |r| r.closed),
        share(faithful().filter(|r| r.closed_mesh), |r| r.closed),
        share(robust(), |r| r.on_vertices),
        share(faithful(), |r| r.closed),
        ordered(Sampling::Even),
        ordered(Sampling::Random),
        share(robust(), is_near),
        share(faithful(), is_near),
        share(robust(), is_near_squared),
        share(faithful(), is_near_squared),
        seconds(0.95),
        seconds(1.0),
    )
}

/// Returns figures 6.5 and 6.6 in numbers: the shares at every fifth point of their curves.
pub fn distance_tables(plots: &[Plot]) -> String {
    let mut text = String::new();
    for plot in plots.iter().filter(|plot| plot.across == DISTANCE) {
        let names: Vec<_> = plot.series.iter().map(|(name, _)| name.as_str()).collect();
        text += &format!(
            "**{}**\n\n| {DISTANCE} | {} |\n|---|{}\n",
            plot.title,
            names.join(" | "),
            "---|".repeat(names.len())
        );
        for i in (5..=POINTS).step_by(5) {
            let shares = plot.series.iter().map(|(_, points)| points[i].1);
            let cells: Vec<_> = shares.map(|share| format!("{share:.1}")).collect();
            text += &format!("| {:.2} | {} |\n", at(i), cells.join(" | "));
        }
        text.push('\n');
    }
    text
}

/// Returns the distance of a point of the curves of figures 6.5 and 6.6.
fn at(point: usize) -> f64 {
    FARTHEST * point as f64 / POINTS as f64
}

/// Returns figures 6.5, 6.6 and 6.9.
pub fn plots(runs: &[Run]) -> Vec<Plot> {
    let mut plots = Vec::new();
    type Metric = fn(&Run) -> f64;
    let metrics: [(&str, Metric); 2] = [
        ("Figure 6.5: share of runs, % over Hausdorff distance", |r| r.hausdorff),
        ("Figure 6.6: share of runs, % over RMSE (as written)", |r| r.root_mean),
    ];
    for (title, metric) in metrics {
        for (sampling, kind) in KINDS {
            for method in [Method::Faithful(5), Method::Robust] {
                let series = SIZES.map(|count| {
                    let own: Vec<f64> = (runs.iter())
                        .filter(|r| r.method == method && r.sampling == sampling)
                        .filter(|r| r.samples == count)
                        .map(metric)
                        .collect();
                    let point = |i: usize| {
                        let x = at(i);
                        let within = own.iter().filter(|&&value| value <= x).count();
                        (x, 100.0 * within as f64 / own.len().max(1) as f64)
                    };
                    (format!("{count} samples"), (0..=POINTS).map(point).collect())
                });
                plots.push(Plot {
                    title: format!("{title}, {kind}, {}", method.name()),
                    across: DISTANCE.into(),
                    logarithmic: false,
                    scattered: false,
                    series: series.to_vec(),
                });
            }
        }
    }
    let mean = |own: &[&Run]| own.iter().map(|r| r.seconds).sum::<f64>() / own.len().max(1) as f64;
    for method in [Method::Faithful(5), Method::Robust] {
        let series = SIZES.map(|count| {
            let mut sizes: Vec<usize> = runs.iter().map(|r| r.vertices).collect();
            sizes.sort_unstable();
            sizes.dedup();
            let point = |vertices: usize| {
                let own: Vec<&Run> = (runs.iter())
                    .filter(|r| r.method == method && r.samples == count && r.vertices == vertices)
                    .collect();
                ((vertices as f64).log10(), mean(&own))
            };
            (format!("{count} samples"), sizes.into_iter().map(point).collect())
        });
        plots.push(Plot {
            title: format!("Figure 6.9: mean time, s, {}", method.name()),
            across: "log10 of vertices".into(),
            logarithmic: true,
            scattered: false,
            series: series.to_vec(),
        });
    }
    plots
}
