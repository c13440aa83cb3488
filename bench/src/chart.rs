//! The picture of a race: speed over the reference contender, one chart for each type and thread
//! count.

use catamaran_charts::{Axis, Chart, Line, Rule, Series};

use crate::table::Row;

/// Returns `1 thread` or `2 threads`.
pub(crate) fn count_threads(threads: usize) -> String {
    format!("{threads} thread{}", if threads == 1 { "" } else { "s" })
}

/// Draws the rows of races at `formula` as an SVG document; ratios are to `yardstick`.
pub fn svg(rows: &[Row], formula: &str, yardstick: &str) -> String {
    let panels = distinct(rows.iter().map(|r| (r.scalar, r.threads)));
    let contenders =
        distinct(rows.iter().map(|r| r.contender.as_str()).filter(|c| *c != yardstick));
    let shapes = distinct(rows.iter().map(|r| r.shape.to_string()));
    let ratios = rows.iter().map(|r| r.ratio).filter(|r| r.is_finite());
    let top = 1.02 * ratios.fold(1.1, f64::max);
    let chart = |(scalar, threads)| {
        let series = contenders.iter().enumerate().map(|(k, contender)| {
            let row = |shape: &String| {
                rows.iter().find(|r| {
                    (r.scalar, r.threads) == (scalar, threads)
                        && r.contender == *contender
                        && r.shape.to_string() == *shape
                })
            };
            let ratio = |(i, shape)| Some((i as f64, row(shape)?.ratio));
            let points = shapes.iter().enumerate().filter_map(ratio).collect();
            let curve = Series::curve(*contender, Series::color(k), points);
            Series { line: Line::Thin, dots: true, ..curve }
        });
        Chart {
            title: format!("{formula}, {scalar}, {}", count_threads(threads)),
            x: Axis::names(shapes.clone()),
            y: Axis::linear(format!("speed over {yardstick}")).range(0.0, top),
            series: series.collect(),
            rules: vec![Rule { y: 1.0, color: [0; 3] }],
        }
    };
    catamaran_charts::svg(&panels.into_iter().map(chart).collect::<Vec<_>>())
}

/// Returns the different items, in order of appearance.
pub(crate) fn distinct<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<T> {
    let mut found = Vec::new();
    for item in items {
        if !found.contains(&item) {
            found.push(item);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Shape;

    #[test]
    fn every_panel_and_contender_is_drawn() {
        let row = |contender: &str, scalar, threads, ratio| Row {
            shape: Shape { m: 64, n: 32 },
            scalar,
            threads,
            contender: contender.into(),
            repetitions: 5,
            seconds: 1.0,
            best: 1.0,
            gflops: 1.0,
            ratio,
            best_ratio: ratio,
            error: 0.0,
            error_ratio: 1.0,
        };
        let rows = [
            row("mkl", "f64", 1, 1.0),
            row("ours", "f64", 1, 1.25),
            row("ours", "f32", 2, f64::NAN),
        ];
        let picture = svg(&rows, "A^T B", "mkl");
        for text in
            ["A^T B, f64, 1 thread", "A^T B, f32, 2 threads", "speed over mkl", "64x32", "ours"]
        {
            assert!(picture.contains(&format!("\n{text}\n")), "{text}");
        }
        assert!(!picture.contains("\nmkl\n"), "the yardstick is the line at 1");
        let dots = picture.matches("<circle").count();
        assert_eq!(dots, 1, "of ours; what has no number is left out");
        assert!(!picture.contains("NaN"));
    }
}
