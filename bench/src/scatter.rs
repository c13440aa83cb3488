//! The picture of a grid: a point per shape, one panel per type and thread count.

use crate::chart::{COLOURS, END, LEFT, LINE_AT_1, Panel, count_threads, distinct, open, point};
use crate::grid::{BEHIND, Row, summarise};
use crate::input::Shape;

/// Heights of a panel, in those of a race.
const HEIGHT: f64 = 1.5;
/// Pixels between two ticks, at least.
const SPACE: f64 = 16.0;
const TICKS: [f64; 21] = [
    0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9, 1.1, 1.2, 1.3, 1.5, 2.0, 3.0, 5.0, 10.0,
    20.0, 50.0, 100.0,
];
/// What m / n is below, and how that is called.
const CLASSES: [(f64, &str); 6] = [
    (0.75, "m/n &lt; 3/4"),
    (1.5, "m/n &lt; 3/2"),
    (10.0, "m/n &lt; 10"),
    (100.0, "m/n &lt; 100"),
    (1000.0, "m/n &lt; 1000"),
    (f64::INFINITY, "m/n &gt;= 1000"),
];

fn class(Shape { m, n }: Shape) -> usize {
    let ratio = m as f64 / n as f64;
    CLASSES.iter().position(|(end, _)| ratio < *end).unwrap_or(CLASSES.len() - 1)
}

/// The rows as an SVG document: time ratios over n, both axes logarithmic.
pub fn svg(rows: &[Row]) -> String {
    let panels = distinct(rows.iter().map(|r| (r.scalar, r.threads)));
    let sides = || rows.iter().map(|r| r.shape.n as f64);
    let (least, most) = (sides().fold(f64::INFINITY, f64::min), sides().fold(1.0, f64::max));
    let ratios = || rows.iter().map(|r| r.ratio);
    let (bottom, top) = (0.95 * ratios().fold(0.85, f64::min), 1.05 * ratios().fold(1.2, f64::max));

    let mut out = open(panels.len(), HEIGHT);
    for (p, (scalar, threads)) in panels.iter().enumerate() {
        let of_panel = || rows.iter().filter(|r| (r.scalar, r.threads) == (*scalar, *threads));
        let summary = summarise(of_panel()).map_or(String::new(), |s| s.to_string());
        let threads = count_threads(*threads);
        let title = format!("A^T A, {scalar}, {threads}: our time / the best rival's; {summary}");
        let panel = Panel::new(&mut out, p, HEIGHT, &title);
        let share = |value: f64, from: f64, to: f64| (value / from).ln() / (to / from).ln();
        let y = |ratio: f64| panel.low - (panel.low - panel.high) * share(ratio, bottom, top);
        // Half a doubling of space at both ends.
        let margin = std::f64::consts::SQRT_2;
        let x = |n: f64| LEFT + (END - LEFT) * share(n, least / margin, most * margin);

        for ratio in ticks(bottom, top, y) {
            panel.tick(&mut out, y(ratio), &format!("{ratio}"));
        }
        panel.line(&mut out, y(1.0), LINE_AT_1);
        panel.line(&mut out, y(BEHIND), "stroke=\"#d55e00\" stroke-dasharray=\"6 3\"");
        let powers = (0..).map(|k| (1u64 << k) as f64).take_while(|n| *n <= most);
        for n in powers.filter(|n| *n >= least) {
            panel.below(&mut out, x(n), &format!("{n}"));
        }
        for row in of_panel() {
            let text = format!("{}: {:.3} of {}", row.shape, row.ratio, row.rival);
            let place = [x(row.shape.n as f64), y(row.ratio)];
            point(&mut out, place, COLOURS[class(row.shape)], &text);
        }
        for (k, (_, text)) in CLASSES.iter().enumerate() {
            panel.legend(&mut out, k, COLOURS[k], text);
        }
    }
    out.push_str("</svg>\n");
    out
}

/// Ticks between two ratios, from 1 outwards, as many as `y`, the place of a ratio, has space for.
fn ticks(bottom: f64, top: f64, y: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut found = vec![1.0];
    let (below, above): (Vec<f64>, Vec<f64>) = TICKS.iter().partition(|t| **t < 1.0);
    for side in [below.into_iter().rev().collect(), above] {
        let mut last = y(1.0);
        for tick in side {
            if (bottom..=top).contains(&tick) && (y(tick) - last).abs() >= SPACE {
                last = y(tick);
                found.push(tick);
            }
        }
    }
    found
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
        let points = picture.matches("<title>").count();
        assert_eq!(points, rows.len());
        for text in ["f64, 1 thread:", "2 threads:", "4x64: 0.900 of openblas gemm", ">1024<"] {
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

    #[test]
    fn ticks_keep_their_distance() {
        assert_eq!(ticks(0.8, 1.25, |r| 1000.0 * r), [1.0, 0.9, 0.8, 1.1, 1.2]);
        assert_eq!(ticks(0.8, 1.25, |r| 100.0 * r), [1.0, 0.8, 1.2]);
    }
}
