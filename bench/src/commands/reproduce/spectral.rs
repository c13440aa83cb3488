//! Chapter 1: eigenproducts.

use catamaran_bench::Result;
use catamaran_bench::curves::Plot;
use catamaran_bench::race::median;
use catamaran_bench::spectral::{
    Setting, Shape, Shapes, Table, approximation, eigenpowers, frequencies, ranks, stability,
    transfer,
};

use super::Report;

/// The columns of the record.
pub const HEADER: &str = "table,function,method,ours,thesis";

/// Theorem 1.1, figures 1.4, 1.6 and 1.10, tables 1.1 to 1.4.
pub fn run(report: &mut Report) -> Result<()> {
    report.say(
        "# Chapter 1, measured again\n\nOur errors in per cent, those of the thesis in brackets: the same protocol on \
         other shapes, so that the order of the methods can be compared, and not the values. `rings` stands for \
         AWFT.\n",
    );
    let shapes = Shapes::new();
    let report_table = |report: &mut Report, table: Table| {
        report.say(&table.markdown());
        report.lines.extend(table.lines());
    };
    let table = approximation(&shapes)?;
    report_table(report, table);
    for setting in [Setting::Isometric, Setting::People, Setting::Remeshed] {
        match transfer(&shapes, setting)? {
            Some(table) => report_table(report, table),
            None => report.say("Table 1.3 needs CATAMARAN_DATA.\n"),
        }
    }
    theory(report, &shapes.single(90)?)?;
    for pair in shapes.isometric(20)?.iter().take(1) {
        for k in [8, 14, 20] {
            report.plots.push(stability(pair, k)?);
        }
    }
    Ok(())
}

fn theory(report: &mut Report, shapes: &[Shape]) -> Result<()> {
    report.say("**Theorem 1.1**, equation 1.5: the largest relative error over the first 10 eigenfunctions\n");
    report.say("| shape | N = 2 | N = 3 |\n|---|---|---|");
    for shape in shapes {
        let errors = eigenpowers(shape, 10, 3)?;
        report.say(&format!("| {} | {:.1e} | {:.1e} |", shape.name, errors[0], errors[1]));
    }
    report.say("\n**Figure 1.4**: mean, median and largest distance of the first NK eigenvalues to a product's frequency, per cent\n");
    report.say("| shape | N = 1 | N = 2 | N = 3 |\n|---|---|---|---|");
    for (s, shape) in shapes.iter().enumerate() {
        let (distances, scatter) = frequencies(shape, 30, 3)?;
        let cells: Vec<_> = (distances.iter())
            .map(|d| {
                let mean = d.iter().sum::<f64>() / d.len() as f64;
                let most = d.iter().copied().fold(0.0, f64::max);
                let middle = median(d.clone());
                format!("{:.4}, {:.4}, {:.3}", 100.0 * mean, 100.0 * middle, 100.0 * most)
            })
            .collect();
        report.say(&format!("| {} | {} |", shape.name, cells.join(" | ")));
        if s == 0 {
            report.plots.push(scatter);
        }
    }
    report.say("\n**Figure 1.6**: products, those that ours* keeps, those that are kept by rank, and the numerical rank by a dense \
         decomposition\n");
    report.say(
        "| shape | N | K | products | ours* | by rank | rank |\n|---|---|---|---|---|---|---|",
    );
    for (order, ks) in [(2, &[10, 20, 30, 40][..]), (3, &[6, 10, 14]), (4, &[4, 7, 10])] {
        let mut series: [Vec<(f64, f64)>; 4] = Default::default();
        for shape in shapes.iter().take(2) {
            for &k in ks {
                let counts = ranks(shape, k, order)?;
                let [all, ours, by_rank, rank] = counts;
                let name = &shape.name;
                report.say(&format!(
                    "| {name} | {order} | {k} | {all} | {ours} | {by_rank} | {rank} |"
                ));
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
