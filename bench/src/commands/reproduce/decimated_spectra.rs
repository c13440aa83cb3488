//! Chapter 5: spectra of decimated meshes (figure 5.11), and spectra by way of a decimation.

use std::time::Instant;

use catamaran::Par;
use catamaran::faer::Mat;
use catamaran::sparse::{EigenOptions, eigs, eigs_two_level};
use catamaran_bench::Result;
use catamaran_bench::decimate::{Input, Inputs, Rivals, Row, race};
use catamaran_bench::spectral::nearest_vertices;
use catamaran_geometry::decimate::{DecimateOptions, decimate};
use catamaran_geometry::mesh::{Laplacian, LaplacianOptions, TriMesh, families, laplacian};
use catamaran_geometry::spectral::Basis;
use catamaran_geometry::spectral::functional_map::map_from_points;

use super::decimate::{Curves, FIGURES, plot, record};
use super::{Arguments, Report};

pub use super::decimate::HEADER;

/// Real meshes of about 40,000 vertices.
const REAL: [&str; 3] =
    ["armadillo43k.obj.gz", "refined_elephant44k.off.gz", "nefertiti35k.obj.gz"];

/// Number of eigenpairs that are compared, without the zero.
const PAIRS: usize = 50;

/// Reproduces figure 5.11, and the error of spectra by way of a decimation.
pub fn run(report: &mut Report, arguments: &Arguments) -> Result<()> {
    let (inputs, rivals) = (Inputs::new()?, Rivals::find(&arguments.libraries));
    report.say("# Spectra and decimation, measured again\n");
    figure(report, &inputs, &rivals)?;
    two_levels(report, &inputs)
}

/// Reproduces figure 5.11: eigenvalues, and the functional map of nearest vertices, of decimations.
/// The thesis decimates the fertility model from 250,000 to 50,000 vertices, and compares with
/// Lescoat et al. (2020), whose code is in no registry.
fn figure(report: &mut Report, inputs: &Inputs, rivals: &Rivals) -> Result<()> {
    report.say(&format!(
        "**Figure 5.11**: the first {PAIRS} eigenpairs and those of decimations to an eighth of the \
         vertices. Differences of eigenvalues in per cent; at equal area: of the decimation scaled to \
         the area of the input. Of the functional map C of nearest vertices: the share of the squares \
         of its entries on the diagonal, |C^T C - I| / sqrt({PAIRS}), and how far it is from commuting \
         with the Laplacians (Lescoat et al. 2020), |C L - L' C| / |C L|.\n"
    ));
    let mut shapes = Vec::new();
    for file in REAL {
        shapes.extend(inputs.real(file)?);
    }
    if shapes.is_empty() {
        shapes.push(inputs.of("figure", families::figure(13, 0.5)?)?);
    }
    for input in &shapes {
        let n = input.mesh.vertices().len() / 8;
        let truth = Spectrum::of(&input.mesh)?;
        report.say(&format!(
            "{}, {} vertices, to {n}\n\n| contender | mean % | largest % | mean % at equal area | \
             largest % | diagonal | not orthogonal | not commuting |\n|---|---|---|---|---|---|---|---|",
            input.name,
            input.mesh.vertices().len()
        ));
        let mut values: Curves = vec![("input".into(), indexed(&truth.values))];
        let mut diagonals: Curves = Vec::new();
        for row in race(&FIGURES, rivals, inputs, input, n, 2, 1)? {
            compare(report, (input, n), &truth, &row, (&mut values, &mut diagonals))?;
        }
        report.say("");
        for (what, series) in [("eigenvalues", values), ("diagonal of |C|", diagonals)] {
            let title = format!("Figure 5.11: {what}, {}", input.name);
            report.plots.push(plot(&title, "index", false, series));
        }
    }
    Ok(())
}

/// Adds a row of the table, and its curves.
fn compare(
    report: &mut Report,
    case: (&Input, usize),
    truth: &Spectrum,
    row: &Row,
    (values, diagonals): (&mut Curves, &mut Curves),
) -> Result<()> {
    let (who, found) = (row.contender.name(), Spectrum::of(&row.made)?);
    let ratio = row.made.area() / case.0.mesh.area();
    let as_it_is = differences(&found.values, &truth.values, 1.0);
    let at_equal_area = differences(&found.values, &truth.values, ratio);
    let map = Map::between(truth, &found)?;
    let measures = [
        ("mean_percent", as_it_is[0]),
        ("largest_percent", as_it_is[1]),
        ("mean_percent_at_equal_area", at_equal_area[0]),
        ("largest_percent_at_equal_area", at_equal_area[1]),
        ("diagonal", map.diagonal),
        ("not_orthogonal", map.not_orthogonal),
        ("not_commuting", map.not_commuting),
    ];
    let cells: Vec<_> = measures.iter().map(|(_, value)| format!("{value:.3}")).collect();
    report.say(&format!("| {who} | {} |", cells.join(" | ")));
    record(report, "5.11", case, who, &measures);
    values.push((who.to_owned(), indexed(&found.values)));
    diagonals.push((who.to_owned(), indexed(&map.entries)));
    Ok(())
}

/// Returns the points (1, first), (2, second) ...
fn indexed(values: &[f64]) -> Vec<(f64, f64)> {
    values.iter().enumerate().map(|(i, v)| (i as f64 + 1.0, *v)).collect()
}

/// Returns the mean and the largest difference of values, times `scale`, from the true ones, in per
/// cent.
fn differences(values: &[f64], right: &[f64], scale: f64) -> [f64; 2] {
    let each = values.iter().zip(right).map(|(x, y)| 100.0 * (scale * x / y - 1.0).abs());
    let count = values.len() as f64;
    each.fold([0.0, 0.0f64], |[sum, largest], d| [sum + d / count, largest.max(d)])
}

/// The first eigenpairs of a mesh, without the zero.
struct Spectrum {
    mesh: TriMesh,
    values: Vec<f64>,
    functions: Basis,
}

impl Spectrum {
    fn of(mesh: &TriMesh) -> Result<Self> {
        let mesh = mesh.without_unreferenced().mesh;
        let Laplacian { stiffness, mass, .. } = laplacian(&mesh, &LaplacianOptions::default())?;
        let pairs = eigs(stiffness.view(), &mass, &EigenOptions::new().k(PAIRS + 1))?;
        let functions = pairs.vectors.subcols(1, PAIRS).to_owned();
        let functions = Basis::orthonormal(functions, mass)?;
        Ok(Self { mesh, values: pairs.values[1..].to_vec(), functions })
    }
}

/// The functional map from functions on a mesh to those on its decimation, by nearest vertices.
struct Map {
    diagonal: f64,
    not_orthogonal: f64,
    not_commuting: f64,
    /// Magnitudes on the diagonal.
    entries: Vec<f64>,
}

impl Map {
    fn between(input: &Spectrum, small: &Spectrum) -> Result<Self> {
        let nearest = nearest_vertices(&input.mesh, &small.mesh)?;
        let c = map_from_points(&nearest, &input.functions, &small.functions, Par::all())?;
        let squares = |m: &Mat<f64>| m.squared_norm_l2();
        let excess = c.transpose() * &c - Mat::<f64>::identity(PAIRS, PAIRS);
        let (from, to) = (&input.values, &small.values);
        let after = Mat::from_fn(PAIRS, PAIRS, |i, j| c[(i, j)] * from[j]);
        let before = Mat::from_fn(PAIRS, PAIRS, |i, j| to[i] * c[(i, j)]);
        let entries: Vec<f64> = (0..PAIRS).map(|i| c[(i, i)].abs()).collect();
        Ok(Self {
            diagonal: entries.iter().map(|x| x * x).sum::<f64>() / squares(&c),
            not_orthogonal: (squares(&excess) / PAIRS as f64).sqrt(),
            not_commuting: (squares(&(&after - &before)) / squares(&after)).sqrt(),
            entries,
        })
    }
}

/// Reports spectra by way of a decimation, beside the full spectra and those of the decimation's
/// own Laplacian.
fn two_levels(report: &mut Report, inputs: &Inputs) -> Result<()> {
    report.say(&format!(
        "**Spectra by way of a decimation** (`spectrum --via-decimation n`): errors of the first \
         {PAIRS} eigenvalues in per cent, beside those of the Laplacian of the decimation itself, and \
         seconds, decimation included. The bar is a mean of 1 %.\n\n\
         | mesh | vertices | n | mean % | largest % | own Laplacian: mean % | seconds | full: seconds |\n\
         |---|---|---|---|---|---|---|---|"
    ));
    let mut cases = vec![(inputs.of("terrain1000", families::terrain(1000, 1000, 1)?)?, 10_000)];
    for file in REAL {
        cases.extend(inputs.real(file)?.map(|input| (input, 5000)));
    }
    cases.extend(inputs.real("srtm_n44w072_1p44M.ply.xz")?.map(|input| (input, 10_000)));
    let options = EigenOptions::new().k(PAIRS + 1);
    for (input, n) in &cases {
        let operator = laplacian(&input.mesh, &LaplacianOptions::default())?;
        let (w, m) = (operator.stiffness.view(), &operator.mass);
        let start = Instant::now();
        let full = eigs(w, m, &options)?;
        let full_seconds = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let small = decimate(&input.mesh, *n, &DecimateOptions::default())?;
        let weights = small.weights(&input.mesh, Par::all())?;
        let found = eigs_two_level(w, m, weights.view(), &options)?;
        let seconds = start.elapsed().as_secs_f64();
        let own = Spectrum::of(&small.mesh)?;
        let [mean, largest] = differences(&found.values[1..], &full.values[1..], 1.0);
        let [own_mean, _] = differences(&own.values, &full.values[1..], 1.0);
        report.say(&format!(
            "| {} | {} | {n} | {mean:.3} | {largest:.3} | {own_mean:.3} | {seconds:.1} | {full_seconds:.1} |",
            input.name,
            input.mesh.vertices().len()
        ));
        let measures = [
            ("mean_percent", mean),
            ("largest_percent", largest),
            ("own_mean_percent", own_mean),
            ("seconds", seconds),
            ("full_seconds", full_seconds),
        ];
        record(report, "via-decimation", (input, *n), "ours", &measures);
    }
    report.say("");
    Ok(())
}
