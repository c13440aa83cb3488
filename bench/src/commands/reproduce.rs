//! `reproduce`: tables and figures of the thesis, measured again.

mod curves;

use std::time::Instant;

use catamaran_bench::curves::{Plot, svg};
use catamaran_bench::spectral::{
    Setting, Shape, Shapes, approximation, eigenpowers, frequencies, ranks, stability, transfer,
};
use catamaran_bench::{Result, host, record};
use clap::ValueEnum;

#[derive(clap::Args)]
pub struct Arguments {
    /// What is reproduced.
    what: What,
    /// Writes WHAT.md, WHAT.csv, WHAT.svg and host.txt under bench/record.
    #[arg(long)]
    record: bool,
    /// Chapter 6: curves on each mesh; 50 by default.
    #[arg(long, value_name = "N")]
    curves: Option<usize>,
    /// Chapter 6: only these meshes.
    #[arg(long, value_delimiter = ',')]
    meshes: Vec<String>,
}

#[derive(Clone, Copy, ValueEnum)]
enum What {
    /// Chapter 1: eigenproducts.
    Spectral,
    /// Chapter 6: curves on surfaces.
    Curves,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let host = host::describe(&[]);
    let start = Instant::now();
    let mut report = Report::default();
    let (name, head) = match arguments.what {
        What::Spectral => ("spectral", "table,function,method,ours,thesis"),
        What::Curves => ("curves", curves::HEAD),
    };
    match arguments.what {
        What::Spectral => spectral(&mut report)?,
        What::Curves => curves::curves(&mut report, arguments)?,
    }
    println!("\n{:.0} s", start.elapsed().as_secs_f64());
    if arguments.record {
        let names = ["md", "csv", "svg"].map(|ending| format!("{name}.{ending}"));
        let files = [
            (names[0].as_str(), report.text),
            (names[1].as_str(), record::csv(head, &report.lines)),
            (names[2].as_str(), svg(&report.plots)),
            ("host.txt", host),
        ];
        println!("recorded in {}", record::write(&files)?.display());
    }
    Ok(())
}

/// What is found, as it is found.
#[derive(Default)]
struct Report {
    text: String,
    lines: Vec<String>,
    plots: Vec<Plot>,
}

impl Report {
    fn say(&mut self, text: &str) {
        println!("{text}");
        self.text += text;
        self.text.push('\n');
    }
}

fn spectral(report: &mut Report) -> Result<()> {
    report.say(
        "# Chapter 1, measured again\n\nOur errors in per cent, those of the thesis in brackets: the same protocol on \
         other shapes, so that the order of the methods can be compared, and not the values. `rings` stands for \
         AWFT.\n",
    );
    let shapes = Shapes::new();
    let report_table = |report: &mut Report, table: catamaran_bench::spectral::Table| {
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
    report.say("\n**Figure 1.4**: mean and largest distance of the first NK eigenvalues to a product's frequency, per cent\n");
    report.say("| shape | N = 1 | N = 2 | N = 3 |\n|---|---|---|---|");
    for (s, shape) in shapes.iter().enumerate() {
        let (distances, scatter) = frequencies(shape, 30, 3)?;
        let cells: Vec<_> = (distances.iter())
            .map(|d| {
                let mean = d.iter().sum::<f64>() / d.len() as f64;
                let most = d.iter().copied().fold(0.0, f64::max);
                format!("{:.4}, {:.3}", 100.0 * mean, 100.0 * most)
            })
            .collect();
        report.say(&format!("| {} | {} |", shape.name, cells.join(" | ")));
        if s == 0 {
            report.plots.push(scatter);
        }
    }
    report.say("\n**Figure 1.6**: products, those that ours* keeps, and the numerical rank by a dense decomposition\n");
    report.say("| shape | N | K | products | ours* | rank |\n|---|---|---|---|---|---|");
    for (order, ks) in [(2, &[10, 20, 30, 40][..]), (3, &[6, 10, 14]), (4, &[4, 7, 10])] {
        let mut series: [Vec<(f64, f64)>; 3] = Default::default();
        for shape in shapes.iter().take(2) {
            for &k in ks {
                let counts = ranks(shape, k, order)?;
                let [all, ours, rank] = counts;
                report
                    .say(&format!("| {} | {order} | {k} | {all} | {ours} | {rank} |", shape.name));
                for (points, count) in series.iter_mut().zip(counts) {
                    points.push((k as f64, count as f64));
                }
            }
        }
        let names = ["products", "ours*", "rank"];
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
