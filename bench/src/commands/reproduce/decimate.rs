//! Chapter 5: decimation.

use std::time::Instant;

use catamaran::Par;
use catamaran_bench::Result;
use catamaran_bench::curves::Plot;
use catamaran_bench::decimate::{Contender, Input, Inputs, Rivals, Row, race};
use catamaran_bench::race::median;
use catamaran_geometry::decimate::{
    DecimateOptions, Difference, decimate, edge_length_for, resample,
};
use catamaran_geometry::mesh::families;

use super::{Arguments, Report};

/// The columns of the record.
pub const HEADER: &str = "figure,mesh,input_vertices,n,contender,measure,value";

/// The contenders of figures 5.6 to 5.9. `qslim` replaces the modifier of Blender, which also
/// collapses by quadrics.
pub(super) const FIGURES: [Contender; 5] =
    [Contender::Ours, Contender::Thesis, Contender::Cgal, Contender::Qslim, Contender::Pyacvd];

/// Sizes of the results in these figures.
const SIZES: [usize; 5] = [500, 1000, 2000, 5000, 10_000];

/// Reproduces figures 5.6 to 5.10 and 5.12 to 5.16, and decimates every mesh to three sizes. Figure
/// 5.11 is `decimated-spectra`.
pub fn run(report: &mut Report, arguments: &Arguments) -> Result<()> {
    let (inputs, rivals) = (Inputs::new()?, Rivals::find(&arguments.libraries));
    report.say(
        "# Chapter 5, measured again\n\nThe longest side of every mesh is 1. Reading is not counted; two threads. \
         Distances of figure 5.9 are those of vertices from the surface of the other mesh, both ways; those of the tables \
         are of both surfaces.\n",
    );
    uniformity(report, &inputs, &rivals)?;
    time(report, &inputs, &rivals)?;
    resampling(report, &inputs)?;
    everything(report, &inputs)
}

pub(super) fn record(
    report: &mut Report,
    figure: &str,
    (input, n): (&Input, usize),
    who: &str,
    measures: &[(&str, f64)],
) {
    let vertices = input.mesh.vertices().len();
    for (measure, value) in measures {
        report
            .lines
            .push(format!("{figure},{},{vertices},{n},{who},{measure},{value:.6e}", input.name));
    }
}

/// Reproduces figures 5.6 to 5.9: uniformity and distances over the size of the result.
fn uniformity(report: &mut Report, inputs: &Inputs, rivals: &Rivals) -> Result<()> {
    let shapes = twenty_shapes(inputs)?;
    // Means over the shapes that a contender finished, at every size.
    let titles = [
        "Figure 5.7: mean area of the faces times their number",
        "Figure 5.7: standard deviation of the areas over their mean",
        "Figure 5.8: mean quality",
        "Figure 5.8: standard deviation of the quality",
        "Figure 5.9: Hausdorff distance",
        "Figure 5.9: Chamfer distance",
    ];
    let mut means: Vec<Curves> = vec![Vec::new(); titles.len()];
    let mut counts: Curves = Vec::new();
    report.say("**Figures 5.6 to 5.9**\n");
    for input in &shapes {
        for n in SIZES {
            report.say(&format!(
                "{}, {} vertices, to {n}\n\n{}",
                input.name,
                input.mesh.vertices().len(),
                Row::TITLES
            ));
            for row in race(&FIGURES, rivals, inputs, input, n, 2, 1)? {
                report.say(&row.markdown());
                let (who, q) = (row.contender.name(), &row.measures.quality);
                let d = Difference::between(&input.mesh, &row.made, Par::all())?;
                let total = q.mean_area * row.measures.faces as f64;
                let values = [
                    total,
                    q.area_variation,
                    q.mean_quality,
                    q.quality_deviation,
                    d.hausdorff,
                    d.chamfer,
                ];
                let names = [
                    "area",
                    "area_variation",
                    "quality",
                    "quality_deviation",
                    "hausdorff",
                    "chamfer",
                ];
                let measures: Vec<_> = names.into_iter().zip(values).collect();
                record(report, "5.7-5.9", (input, n), who, &measures);
                add(&mut counts, who, n as f64, 1.0);
                for (series, value) in means.iter_mut().zip(values) {
                    add(series, who, n as f64, value);
                }
            }
            report.say("");
        }
    }
    report.say(
        "**Figures 5.7 to 5.9**: means over the meshes that a contender finished; area is that of \
         all faces\n\n\
         | contender | n | meshes | area | CV | Q | deviation of Q | Hausdorff | Chamfer |\n\
         |---|---|---|---|---|---|---|---|---|",
    );
    // Sums become means. All series have the same contenders and sizes, in the same order.
    for (k, (who, points)) in counts.iter().enumerate() {
        for (i, &(n, count)) in points.iter().enumerate() {
            let cells = means.iter_mut().enumerate().map(|(measure, series)| {
                let value = &mut series[k].1[i].1;
                *value /= count;
                if measure < 4 { format!("{value:.3}") } else { format!("{value:.1e}") }
            });
            let cells: Vec<_> = cells.collect();
            report.say(&format!("| {who} | {n} | {count} | {} |", cells.join(" | ")));
        }
    }
    report.say("");
    for (k, (title, series)) in titles.into_iter().zip(means).enumerate() {
        let logarithmic = k >= 4;
        report.plots.push(plot(title, "vertices", logarithmic, series));
    }
    Ok(())
}

/// Returns as many shapes as the thesis has, each with at least twice the vertices of the largest
/// result: real ones, and generated figures, a torus and terrains.
fn twenty_shapes(inputs: &Inputs) -> Result<Vec<Input>> {
    const SHAPES: usize = 20;
    const REAL: [&str; 9] = [
        "armadillo43k.obj.gz",
        "nefertiti35k.obj.gz",
        "refined_elephant44k.off.gz",
        "lionstatue32k.obj.gz",
        "mountain26k.obj.gz",
        "counter42k.stl.gz",
        "cycloidal_nonmanifold.ply.gz",
        "mni152_t1_head131k.ply.xz",
        "mni152_wm317k.ply.xz",
    ];
    let mut shapes = vec![inputs.of("torus", families::torus(300, 100, 1.0, 0.4)?)?];
    for file in REAL {
        shapes.extend(inputs.real(file)?);
    }
    for seed in 1..=3 {
        let terrain = families::terrain(200, 200, seed)?;
        shapes.push(inputs.of(&format!("terrain-{seed}"), terrain)?);
    }
    // Figures in poses replace missing shapes.
    for pose in 0..SHAPES.saturating_sub(shapes.len()) {
        let figure = families::figure(13, 0.1 * pose as f64)?;
        shapes.push(inputs.of(&format!("figure-{pose}"), figure)?);
    }
    Ok(shapes)
}

/// Names, and points (x, y).
pub(super) type Curves = Vec<(String, Vec<(f64, f64)>)>;

/// Adds `y` to the value of the curve `name` at `x`.
fn add(series: &mut Curves, name: &str, x: f64, y: f64) {
    let curve = match series.iter().position(|(known, _)| known == name) {
        Some(k) => &mut series[k].1,
        None => {
            series.push((name.to_owned(), Vec::new()));
            &mut series.last_mut().expect("just pushed").1
        }
    };
    match curve.iter_mut().find(|point| point.0 == x) {
        Some(point) => point.1 += y,
        None => curve.push((x, y)),
    }
}

pub(super) fn plot(title: &str, across: &str, logarithmic: bool, series: Curves) -> Plot {
    Plot { title: title.into(), across: across.into(), logarithmic, scattered: false, series }
}

/// Number of repetitions of timings in this process.
const REPETITIONS: usize = 3;

/// Reproduces figures 5.10, 5.12 and 5.13: seconds over the size of the input.
fn time(report: &mut Report, inputs: &Inputs, rivals: &Rivals) -> Result<()> {
    let mut terrains = Vec::new();
    for side in [100, 178, 316, 562, 1000] {
        terrains.push(inputs.of(&format!("terrain{side}"), families::terrain(side, side, 1)?)?);
    }
    terrains.extend(inputs.real("srtm_n44w072_1p44M.ply.xz")?);

    time_of_sizes(report, &terrains)?;
    time_of_contenders(report, inputs, rivals, &terrains)?;
    time_of_white_matter(report, inputs, rivals)
}

/// Reproduces figure 5.12: seconds for results of several sizes.
fn time_of_sizes(report: &mut Report, terrains: &[Input]) -> Result<()> {
    report.say("**Figure 5.12**: seconds over vertices of the input\n\n| n | vertices: seconds | exponent |\n|---|---|---|");
    let mut series = Vec::new();
    for n in [500, 1000, 5000, 10_000, 25_000] {
        let mut points = Vec::new();
        for input in terrains.iter().filter(|input| input.mesh.vertices().len() >= 2 * n) {
            let seconds =
                timed(|| decimate(&input.mesh, n, &DecimateOptions::default()).map(|_| ()))?;
            record(report, "5.12", (input, n), "ours", &[("seconds", seconds)]);
            points.push((input.mesh.vertices().len() as f64, seconds));
        }
        let cells: Vec<_> = points.iter().map(|(v, s)| format!("{v}: {s:.3}")).collect();
        report.say(&format!("| {n} | {} | {:.2} |", cells.join(", "), exponent(&points)));
        series.push((format!("n = {n}"), points));
    }
    report.plots.push(plot(
        "Figure 5.12: seconds over the size of the input",
        "vertices",
        true,
        series,
    ));
    Ok(())
}

/// Reproduces figure 5.13: seconds of all contenders.
fn time_of_contenders(
    report: &mut Report,
    inputs: &Inputs,
    rivals: &Rivals,
    terrains: &[Input],
) -> Result<()> {
    report.say(
        "\n**Figure 5.13**: seconds to 10000 vertices. Beyond half a million vertices without those that take minutes \
         there: pymeshlab, igl-decimate, qslim and CGAL.\n",
    );
    let mut series = Vec::new();
    for input in terrains.iter().filter(|input| input.mesh.vertices().len() > 20_000) {
        report.say(&format!("{} vertices\n\n{}", input.mesh.vertices().len(), Row::TITLES));
        let many = input.mesh.vertices().len() > 500_000;
        let contenders: Vec<_> = Contender::ALL
            .into_iter()
            .filter(|c| {
                !many
                    || !matches!(
                        c,
                        Contender::Pymeshlab
                            | Contender::IglDecimate
                            | Contender::Qslim
                            | Contender::Cgal
                    )
            })
            .collect();
        for row in race(&contenders, rivals, inputs, input, 10_000, 2, 1)? {
            report.say(&row.markdown());
            let who = row.contender.name();
            record(report, "5.13", (input, 10_000), who, &[("seconds", row.seconds)]);
            add(&mut series, who, input.mesh.vertices().len() as f64, row.seconds);
        }
        report.say("");
    }
    report.plots.push(plot("Figure 5.13: seconds to 10000 vertices", "vertices", true, series));
    Ok(())
}

/// Reproduces figure 5.10: seconds of the method of this crate and of that of the thesis.
fn time_of_white_matter(report: &mut Report, inputs: &Inputs, rivals: &Rivals) -> Result<()> {
    let Some(input) = inputs.real("mni152_wm1p24M.ply.xz")? else { return Ok(()) };
    report.say(&format!("**Figure 5.10**: white matter to 50000 vertices\n\n{}", Row::TITLES));
    for row in race(&[Contender::Ours, Contender::Thesis], rivals, inputs, &input, 50_000, 2, 1)? {
        report.say(&row.markdown());
        let who = row.contender.name();
        record(report, "5.10", (&input, 50_000), who, &[("seconds", row.seconds)]);
    }
    report.say("");
    Ok(())
}

/// Returns the median time of the call, in seconds.
fn timed(mut call: impl FnMut() -> catamaran::Result<()>) -> Result<f64> {
    let mut seconds = Vec::new();
    for _ in 0..REPETITIONS {
        let start = Instant::now();
        call()?;
        seconds.push(start.elapsed().as_secs_f64());
    }
    Ok(median(seconds))
}

/// Returns the slope of the line through the logarithms, by least squares.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let logarithms: Vec<_> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logarithms.len() as f64;
    let (mx, my) =
        logarithms.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / count, b + y / count));
    let (above, below) = (logarithms.iter())
        .fold((0.0, 0.0), |(a, b), (x, y)| (a + (x - mx) * (y - my), b + (x - mx).powi(2)));
    above / below
}

/// Reproduces figures 5.5 and 5.14 to 5.16: meshes of large faces, with and without resampling.
fn resampling(report: &mut Report, inputs: &Inputs) -> Result<()> {
    let mut shapes = vec![inputs.of("slivers", families::slivers(60, 60, 0.05)?)?];
    for file in ["adis16480_slivers.stl.gz", "counter42k.stl.gz", "blade.off.gz"] {
        shapes.extend(inputs.real(file)?);
    }
    report.say(
        "**Figures 5.14 to 5.16**: resampling\n\n| mesh | n | vertices after resampling | its s | Q without | Q with | \
         CV without | CV with |\n|---|---|---|---|---|---|---|---|",
    );
    let mut series = Vec::new();
    for input in &shapes {
        for n in [500, 1000, 2000, 5000, 10_000, 25_000] {
            let longest = edge_length_for(input.mesh.area(), n)?;
            let finer = resample(&input.mesh, longest)?.mesh.vertices().len();
            let seconds = timed(|| resample(&input.mesh, longest).map(|_| ()))?;
            add(&mut series, &input.name, n as f64, seconds);
            record(
                report,
                "5.14",
                (input, n),
                "ours",
                &[("seconds", seconds), ("vertices", finer as f64)],
            );
            let quality = |resample: bool| {
                let options = DecimateOptions::new().resample(resample);
                decimate(&input.mesh, n, &options)
                    .map(|made| catamaran_geometry::decimate::Quality::of(&made.mesh))
            };
            let [without, with] = [quality(false), quality(true)];
            let cell =
                |found: &catamaran::Result<catamaran_geometry::decimate::Quality>,
                 of: fn(&catamaran_geometry::decimate::Quality) -> f64| {
                    found.as_ref().map_or_else(|_| "refused".into(), |q| format!("{:.3}", of(q)))
                };
            report.say(&format!(
                "| {} | {n} | {finer} | {seconds:.3} | {} | {} | {} | {} |",
                input.name,
                cell(&without, |q| q.mean_quality),
                cell(&with, |q| q.mean_quality),
                cell(&without, |q| q.area_variation),
                cell(&with, |q| q.area_variation)
            ));
            for (who, found) in [("without", &without), ("with", &with)] {
                if let Ok(q) = found {
                    let measures =
                        [("quality", q.mean_quality), ("area_variation", q.area_variation)];
                    record(report, "5.16", (input, n), who, &measures);
                }
            }
        }
    }
    report.say("");
    report.plots.push(plot(
        "Figure 5.14: seconds of resampling",
        "vertices of the result",
        true,
        series,
    ));
    Ok(())
}

/// Decimates every mesh to three sizes, and reports whether the result has exactly n vertices and
/// is a manifold, or why not.
fn everything(report: &mut Report, inputs: &Inputs) -> Result<()> {
    report.say("**Every mesh** at n = 100, 1000 and 10000\n\n| mesh | n | result |\n|---|---|---|");
    for file in inputs.names() {
        let Some(input) = inputs.real(&file)? else { continue };
        for n in [100, 1000, 10_000] {
            let found = match decimate(&input.mesh, n, &DecimateOptions::default()) {
                Ok(made) => {
                    let quality = catamaran_geometry::decimate::Quality::of(&made.mesh);
                    record(
                        report,
                        "all",
                        (&input, n),
                        "ours",
                        &[("vertices", made.mesh.vertices().len() as f64)],
                    );
                    let topology = match made.after {
                        Some(after) if after == made.before => format!("{after}, as before"),
                        Some(after) => format!("{after}; before: {}", made.before),
                        None => "not a manifold".into(),
                    };
                    format!(
                        "{} vertices, Q {:.3}, CV {:.3}, {} non-manifold edges, {topology}",
                        made.mesh.vertices().len(),
                        quality.mean_quality,
                        quality.area_variation,
                        quality.non_manifold_edges
                    )
                }
                Err(error) => format!("refused: {error}"),
            };
            report.say(&format!("| {} | {n} | {found} |", input.name));
        }
    }
    Ok(())
}
