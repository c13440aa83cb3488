//! The picture of a grid: a point for each shape, one panel for each type and thread count.

use catamaran_charts::{Axis, Chart, Line, Rule, Series};

use crate::chart::{count_threads, distinct};
use crate::grid::{BEHIND, Row, summarize};
use crate::input::Shape;

/// Upper bounds of m / n, and the names of the classes.
const CLASSES: [(f64, &str); 6] = [
    (0.75, "m/n < 3/4"),
    (1.5, "m/n < 3/2"),
    (10.0, "m/n < 10"),
    (100.0, "m/n < 100"),
    (1000.0, "m/n < 1000"),
    (f64::INFINITY, "m/n >= 1000"),
];

fn class(Shape { m, n }: Shape) -> usize {
    let ratio = m as f64 / n as f64;
    CLASSES.iter().position(|(end, _)| ratio < *end).unwrap_or(CLASSES.len() - 1)
}

/// Draws the rows as an SVG document: time ratios over n, both axes logarithmic.
pub fn svg(rows: &[Row]) -> String {
    let panels = distinct(rows.iter().map(|r| (r.scalar, r.threads)));
    let ratios = || rows.iter().map(|r| r.ratio);
    let (bottom, top) = (0.95 * ratios().fold(0.85, f64::min), 1.05 * ratios().fold(1.2, f64::max));
    let chart = |(scalar, threads)| {
        let of_panel = || rows.iter().filter(move |r| (r.scalar, r.threads) == (scalar, threads));
        let summary = summarize(of_panel()).map_or(String::new(), |s| s.to_string());
        let series = CLASSES.iter().enumerate().map(|(k, (_, name))| {
            let own = of_panel().filter(|row| class(row.shape) == k);
            let points = own.map(|row| (row.shape.n as f64, row.ratio)).collect();
            let curve = Series::curve(*name, Series::color(k), points);
            Series { line: Line::None, dots: true, ..curve }
        });
        Chart {
            title: format!("A^T A, {scalar}, {}; {summary}", count_threads(threads)),
            x: Axis::log2("n"),
            y: Axis::log10("our time / the best rival's").range(bottom, top),
            series: series.collect(),
            rules: vec![Rule { y: 1.0, color: [0; 3] }, Rule { y: BEHIND, color: [0xd5, 0x5e, 0] }],
        }
    };
    catamaran_charts::svg(&panels.into_iter().map(chart).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::tests::example;

    #[test]
    fn every_shape_is_a_point_of_its_panel() {
        let shapes = [(4, 64), (64, 64), (64_000, 64), (1024, 1024)];
        let rows = [(0, 1, 0.9), (1, 1, 1.5), (2, 1, 1.0), (3, 2, 0.5)];
        let rows = rows.map(|(i, threads, ratio)| {
            let (m, n) = shapes[i];
            example(Shape { m, n }, threads, ratio)
        });
        let picture = svg(&rows);
        // And those of the legends.
        let points = picture.matches("<circle").count() - 2 * CLASSES.len();
        assert_eq!(points, rows.len());
        for text in ["f64, 1 thread;", "2 threads;", "m/n &lt; 3/4", "\n1024\n"] {
            assert!(picture.contains(text), "{text}");
        }
        assert!(picture.contains("1 of 3 shapes"));
        assert!(!picture.contains("NaN") && !picture.contains("inf"));
        // A single shape has no extent.
        assert!(!svg(&rows[..1]).contains("NaN"));
    }

    #[test]
    fn classes_cover_all_ratios() {
        for (m, n, expected) in
            [(1, 16, 0), (16, 16, 1), (32, 16, 2), (160, 16, 3), (160_000, 16, 5)]
        {
            assert_eq!(class(Shape { m, n }), expected, "{m}x{n}");
        }
    }
}
