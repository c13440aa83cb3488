//! Chapter 1: eigenproducts.

use std::rc::Rc;

use catamaran_bench::Result;
use catamaran_bench::curves::Plot;
use catamaran_bench::race::median;
use catamaran_bench::spectral::thesis::{Data, SETS, measure};
use catamaran_bench::spectral::{
    Case, Frequencies, Known, METHODS, MOST, PRODUCTS, REFINEMENTS, SETTINGS, Shape, Shapes, Table,
    approximated, approximation, cardinality, colours, eigenpowers, filters, frequencies, heat,
    noise, ranks, refinement, sizes, stability, transfer, transferred,
};
use catamaran_geometry::spectral::coordinates;

use super::Report;

/// The columns of the record.
pub const HEADER: &str = "table,function,method,ours,thesis";

/// Reproduces theorem 1.1, figures 1.4 to 1.6, 1.10 to 1.17, 1.19 and 1.20, tables 1.1 to 1.6.
pub fn run(report: &mut Report, quick: bool) -> Result<()> {
    report.say(
        "# Chapter 1, measured again\n\nOur errors in per cent, those of the thesis in brackets: the same protocol on \
         other shapes, so that the order of the methods can be compared, and not the values. `rings` stands for \
         AWFT.\n",
    );
    let shapes = Shapes::new(quick);
    let report_table = |report: &mut Report, table: Table| {
        report.say(&table.markdown());
        report.lines.extend(table.lines());
    };
    let table = approximation(&shapes)?;
    report_table(report, table);
    for setting in SETTINGS {
        match transfer(&shapes, setting)? {
            Some(table) => report_table(report, table),
            None => report.say(&format!("{setting:?}: needs CATAMARAN_DATA.\n")),
        }
    }
    refinements(report, &shapes)?;
    theory(report, &shapes.single(90)?)?;
    maps(report, &shapes)?;
    cases(report, &shapes)
}

/// Reproduces tables 1.2 to 1.6 on the thesis' own shapes, at most this number of pairs each.
pub fn thesis(report: &mut Report, pairs: usize) -> Result<()> {
    // Before any other work, so that missing data are told at once.
    let data = Data::find()?;
    report.say(
        "# Tables 1.2 to 1.6 on the thesis' shapes\n\nErrors in per cent, those of the thesis in brackets: relative over \
         the surface, and in tables 1.5 and 1.6 means of `|f - g|` at landmarks, for functions divided by their largest \
         values. Meshes have area 1 and their centre at the origin; XYZ is the mean of three coordinates. `rings` stands \
         for AWFT. ZoomOut ends with 100 eigenfunctions; *pull-back* takes values at its points.\n",
    );
    for set in SETS {
        if let Some(table) = measure(&data, set, pairs)? {
            report.say(&table.markdown());
            report.lines.extend(table.lines());
        }
    }
    Ok(())
}

/// Reports ZoomOut in products, which section 1.5 of the thesis proposes.
fn refinements(report: &mut Report, shapes: &Shapes) -> Result<()> {
    report.say(
        "\n**ZoomOut in products** of 30 eigenfunctions (section 1.5), beside that in 100 eigenfunctions: mean distance of \
         the points found from seven landmarks to the true ones, per cent of the root of the area\n",
    );
    report.say(&format!("| pair | fit | {} |", REFINEMENTS.join(" | ")));
    report.say(&format!("|---|---|{}", "---|".repeat(REFINEMENTS.len())));
    let mut pairs = shapes.people(200)?;
    pairs.extend(shapes.remeshed(200)?.into_iter().take(6));
    for pair in &pairs {
        let name = format!("{} to {}", pair.source.name, pair.target.name);
        let fits = ["landmarks", "with operators"];
        for (fit, distances) in fits.into_iter().zip(refinement(pair)?) {
            let cells: Vec<_> = distances.iter().map(|d| format!("{:.2}", 100.0 * d)).collect();
            report.say(&format!("| {name} | {fit} | {} |", cells.join(" | ")));
            for (how, distance) in REFINEMENTS.iter().zip(distances) {
                report.lines.push(format!("refinement,{name},{how} {fit},{distance:.6},"));
            }
        }
    }
    Ok(())
}

/// Reproduces figures 1.10 to 1.12, 1.14 and 1.15.
fn maps(report: &mut Report, shapes: &Shapes) -> Result<()> {
    let mut plots = Vec::new();
    for pair in shapes.isometric(MOST)?.iter().take(1) {
        for k in [8, 14, 20] {
            plots.push(stability(pair, k)?);
        }
        plots.push(sizes(pair)?);
    }
    let mut pairs = shapes.remeshed(PRODUCTS)?;
    pairs.truncate(PAIRS);
    plots.push(cardinality(&pairs)?);
    plots.push(noise(&pairs)?);
    let shape = shapes.single(90)?.pop().ok_or("no shape")?;
    plots.extend(filters(&shape)?);
    report.say("\n**Figures 1.10 to 1.12, 1.14 and 1.15**, in numbers");
    for plot in plots {
        let names: Vec<_> = plot.series.iter().map(|(name, _)| name.as_str()).collect();
        report.say(&format!("\n{}\n\n| {} | {} |", plot.title, plot.across, names.join(" | ")));
        report.say(&format!("|{}", "---|".repeat(names.len() + 1)));
        let rows = plot.series.first().map_or(0, |(_, points)| points.len());
        for i in 0..rows {
            let x = plot.series[0].1[i].0;
            let cells: Vec<_> =
                plot.series.iter().map(|(_, points)| format!("{:.3}", points[i].1)).collect();
            report.say(&format!("| {x} | {} |", cells.join(" | ")));
            for (name, points) in &plot.series {
                let title = plot.title.split([':', ',']).next().unwrap_or_default();
                report.lines.push(format!("{title},{x},{name},{:.6},", points[i].1));
            }
        }
        report.plots.push(plot);
    }
    Ok(())
}

/// Number of pairs over which figures 1.11 and 1.12 are averaged.
const PAIRS: usize = 6;

/// Reproduces figures 1.13, 1.16, 1.17, 1.19 and 1.20, as errors.
fn cases(report: &mut Report, shapes: &Shapes) -> Result<()> {
    let mut found = Vec::new();
    for shape in shapes.single(120)?.iter().take(2) {
        found.push(approximated(
            "1.16",
            (shape, "colours"),
            colours(shape, 4.0).as_ref(),
            (60, 2),
        )?);
    }
    for (shape, parameters) in shapes.detailed(100)?.iter().zip([(50, 2), (18, 3)]) {
        let points = coordinates(&shape.mesh);
        found.push(approximated("1.17", (shape, "coordinates"), points.as_ref(), parameters)?);
    }
    for pair in shapes.brains(72)?.iter().take(2) {
        let points = coordinates(&pair.source.mesh);
        let parameters = (3, [20, 24]);
        let what = (pair, "coordinates");
        found.push(transferred("1.13", what, points.as_ref(), parameters, Known::Points)?);
    }
    for pair in shapes.remeshed(200)?.iter().skip(3).take(2) {
        let colours = colours(&pair.source, 3.0);
        let parameters = (2, [30, 40]);
        let what = (pair, "colours");
        found.push(transferred("1.19", what, colours.as_ref(), parameters, Known::Landmarks)?);
    }
    for pair in shapes.distant(200)?.iter().take(3) {
        let heat = heat(&pair.source)?;
        let parameters = (2, [30, 40]);
        let what = (pair, "heat kernels");
        found.push(transferred("1.20", what, heat.as_ref(), parameters, Known::Sparse)?);
    }
    report.say("\n**Figures 1.13, 1.16, 1.17, 1.19 and 1.20**: errors in per cent; the thesis has pictures only\n");
    report.say(&format!("| figure | what | {} |", METHODS.join(" | ")));
    report.say(&format!("|---|---|{}", "---|".repeat(METHODS.len())));
    for Case { figure, what, errors } in found {
        let cells: Vec<_> = errors.iter().map(|error| format!("{:.1}", 100.0 * error)).collect();
        report.say(&format!("| {figure} | {what} | {} |", cells.join(" | ")));
        for (method, error) in METHODS.iter().zip(errors) {
            let what = what.replace(',', ";");
            report.lines.push(format!("figure {figure},{what},{method},{error:.4},"));
        }
    }
    Ok(())
}

/// Reproduces theorem 1.1 and figures 1.4 and 1.6.
fn theory(report: &mut Report, shapes: &[Rc<Shape>]) -> Result<()> {
    powers(report, shapes)?;
    distances(report, shapes)?;
    independent_products(report, shapes)
}

/// Reproduces theorem 1.1.
fn powers(report: &mut Report, shapes: &[Rc<Shape>]) -> Result<()> {
    report.say("**Theorem 1.1**, equation 1.5: the largest relative error over the first 10 eigenfunctions\n");
    report.say("| shape | N = 2 | N = 3 |\n|---|---|---|");
    for shape in shapes {
        let errors = eigenpowers(shape, 10, 3)?;
        report.say(&format!("| {} | {:.1e} | {:.1e} |", shape.name, errors[0], errors[1]));
    }
    Ok(())
}

/// Largest order N of the products of figure 1.4.
const ORDERS: usize = 3;
/// Number of eigenvalues that are listed for figure 1.4.
const FARTHEST: usize = 5;

/// Reproduces figure 1.4.
fn distances(report: &mut Report, shapes: &[Rc<Shape>]) -> Result<()> {
    report.say("\n**Figure 1.4**: mean, median and largest distance of the first NK eigenvalues to a product's frequency, per cent\n");
    report.say("| shape | N = 1 | N = 2 | N = 3 |\n|---|---|---|---|");
    let mut farthest = Vec::new();
    let mut all = Vec::new();
    for shape in shapes {
        let (found, scatter) = frequencies(shape, 30, ORDERS)?;
        let cells: Vec<_> = found.iter().map(cell_of_distances).collect();
        report.say(&format!("| {} | {} |", shape.name, cells.join(" | ")));
        for (order, found) in (1..).zip(&found).skip(1) {
            let product = Product { shape: &shape.name, order, found };
            report.lines.extend(product.lines());
            farthest.push(product.row());
        }
        if all.is_empty() {
            report.plots.push(scatter);
        }
        all.push(found);
    }
    report.say(&format!(
        "\nThe mean distance and that of frequencies scattered by chance, per cent; the {FARTHEST} eigenvalues that are \
         farthest, their share of the mean, and each as number: distance (by chance)\n"
    ));
    report.say("| shape | N | mean | by chance | share | farthest |\n|---|---|---|---|---|---|");
    farthest.iter().for_each(|row| report.say(row));
    report.plots.extend((2..=ORDERS).map(|order| plot_of_distances(&all, order)));
    Ok(())
}

/// Returns the mean, median and largest distance in per cent.
fn cell_of_distances(found: &Frequencies) -> String {
    let most = found.distances.iter().copied().fold(0.0, f64::max);
    let middle = median(found.distances.clone());
    format!("{:.4}, {:.4}, {:.3}", 100.0 * found.means()[0], 100.0 * middle, 100.0 * most)
}

/// The frequencies of the products of order N of a shape.
struct Product<'a> {
    shape: &'a str,
    order: usize,
    found: &'a Frequencies,
}

impl Product<'_> {
    /// Returns the lines of the record for the farthest eigenvalues.
    fn lines(&self) -> Vec<String> {
        let Self { shape, order, found } = self;
        let line = |&i: &usize| {
            let distance = found.distances[i - 1];
            format!("figure 1.4 {shape},eigenvalue {i},N = {order},{distance:.6},")
        };
        found.farthest(FARTHEST).iter().map(line).collect()
    }

    /// Returns the row of the table of the farthest eigenvalues.
    fn row(&self) -> String {
        let Self { shape, order, found } = self;
        let numbers = found.farthest(FARTHEST);
        let cell = |&i: &usize| {
            let (distance, expected) = (found.distances[i - 1], found.expected[i - 1]);
            format!("{i}: {:.2} ({:.2})", 100.0 * distance, 100.0 * expected)
        };
        let cells: Vec<_> = numbers.iter().map(cell).collect();
        let [mean, expected] = found.means();
        format!(
            "| {shape} | {order} | {:.4} | {:.4} | {:.0} % | {} |",
            100.0 * mean,
            100.0 * expected,
            100.0 * found.share(&numbers),
            cells.join("; ")
        )
    }
}

/// Returns the plot of the distances of each eigenvalue, averaged over all shapes.
fn plot_of_distances(all: &[Vec<Frequencies>], order: usize) -> Plot {
    let mean = |i: usize| {
        all.iter().map(|found| found[order - 1].distances[i]).sum::<f64>() / all.len() as f64
    };
    let count = all.first().map_or(0, |found| found[order - 1].distances.len());
    Plot {
        title: format!("Figure 1.4: relative distance to the nearest frequency, N = {order}"),
        across: "eigenvalue".into(),
        logarithmic: false,
        scattered: false,
        series: vec![(
            format!("mean of {} shapes", all.len()),
            (0..count).map(|i| ((i + 1) as f64, mean(i))).collect(),
        )],
    }
}

/// Orders N and numbers K of eigenfunctions of figure 1.6.
const INDEPENDENT: [(usize, &[usize]); 3] =
    [(2, &[10, 20, 30, 40]), (3, &[6, 10, 14]), (4, &[4, 7, 10])];

/// Reproduces figure 1.6.
fn independent_products(report: &mut Report, shapes: &[Rc<Shape>]) -> Result<()> {
    report.say("\n**Figure 1.6**: products, those that ours* keeps, those that are kept by rank, and the numerical rank by a dense \
         decomposition\n");
    report.say(
        "| shape | N | K | products | ours* | by rank | rank |\n|---|---|---|---|---|---|---|",
    );
    for (order, ks) in INDEPENDENT {
        let mut series: [Vec<(f64, f64)>; 4] = Default::default();
        for shape in shapes.iter().take(2) {
            for &k in ks {
                let counts = ranks(shape, k, order)?;
                let cells = counts.map(|count| count.to_string()).join(" | ");
                report.say(&format!("| {} | {order} | {k} | {cells} |", shape.name));
                for (points, count) in series.iter_mut().zip(counts) {
                    points.push((k as f64, count as f64));
                }
            }
        }
        let names = ["products", "ours*", "by rank", "rank"];
        report.plots.push(Plot {
            title: format!("Figure 1.6: independent products of order {order}"),
            across: "K".into(),
            logarithmic: false,
            scattered: true,
            series: names.map(String::from).into_iter().zip(series).collect(),
        });
    }
    Ok(())
}
