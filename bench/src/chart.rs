//! The picture of a race: speed over the yardstick, one panel per type and thread count.

use std::fmt::Write;

use crate::table::Row;

const WIDTH: f64 = 900.0;
const PANEL_HEIGHT: f64 = 230.0;
const LEFT: f64 = 60.0;
const RIGHT: f64 = 200.0;
const TOP: f64 = 36.0;
const BOTTOM: f64 = 34.0;
/// Okabe and Ito's colours, told apart by colour-blind readers too.
const COLOURS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#f0e442"];

/// The rows of races at `formula` as an SVG document; ratios are to `yardstick`.
pub fn svg(rows: &[Row], formula: &str, yardstick: &str) -> String {
    let panels = distinct(rows.iter().map(|r| (r.scalar, r.threads)));
    let contenders =
        distinct(rows.iter().map(|r| r.contender.as_str()).filter(|c| *c != yardstick));
    let shapes = distinct(rows.iter().map(|r| r.shape.to_string()));
    let ratios = rows.iter().map(|r| r.ratio).filter(|r| r.is_finite());
    let top = (ratios.fold(1.1, f64::max) * 10.0).ceil() / 10.0;
    let tick = if top > 2.0 { 0.5 } else { 0.2 };

    let height = PANEL_HEIGHT * panels.len() as f64;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" \
         viewBox=\"0 0 {WIDTH} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    for (p, (scalar, threads)) in panels.iter().enumerate() {
        let origin = p as f64 * PANEL_HEIGHT;
        let (high, low) = (origin + TOP, origin + PANEL_HEIGHT - BOTTOM);
        let y = |ratio: f64| low - (low - high) * ratio / top;
        let step = (WIDTH - LEFT - RIGHT) / shapes.len() as f64;
        let x = |i: usize| LEFT + step * (i as f64 + 0.5);
        let end = WIDTH - RIGHT;

        let plural = if *threads == 1 { "" } else { "s" };
        let _ = writeln!(
            out,
            "<text x=\"{LEFT}\" y=\"{:.0}\" font-size=\"14\">{formula}, {scalar}, {threads} \
             thread{plural}: speed over {yardstick}</text>",
            high - 14.0
        );
        let mut ratio = 0.0;
        while ratio <= top + 1e-9 {
            let _ = writeln!(
                out,
                "<path d=\"M{LEFT} {y:.1}H{end}\" stroke=\"#ddd\"/>\
                 <text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{ratio:.1}</text>",
                LEFT - 6.0,
                y(ratio) + 4.0,
                y = y(ratio),
            );
            ratio += tick;
        }
        let _ = writeln!(
            out,
            "<path d=\"M{LEFT} {:.1}H{end}\" stroke=\"black\" stroke-width=\"1.5\"/>",
            y(1.0)
        );
        for (i, shape) in shapes.iter().enumerate() {
            let _ = writeln!(
                out,
                "<text x=\"{:.1}\" y=\"{:.0}\" text-anchor=\"middle\">{shape}</text>",
                x(i),
                low + 18.0
            );
        }
        for (k, contender) in contenders.iter().enumerate() {
            let colour = COLOURS[k % COLOURS.len()];
            let mut path = String::new();
            for (i, shape) in shapes.iter().enumerate() {
                let row = rows.iter().find(|r| {
                    (r.scalar, r.threads) == (*scalar, *threads)
                        && r.contender == *contender
                        && r.shape.to_string() == *shape
                        && r.ratio.is_finite()
                });
                let Some(row) = row else { continue };
                let (x, y) = (x(i), y(row.ratio));
                let _ = write!(path, "{}{x:.1} {y:.1}", if path.is_empty() { "M" } else { "L" });
                let _ = writeln!(
                    out,
                    "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{colour}\"><title>\
                     {contender} {shape}: {:.3}</title></circle>",
                    row.ratio
                );
            }
            let legend = high + 8.0 + 18.0 * k as f64;
            let _ = writeln!(
                out,
                "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-opacity=\"0.5\" \
                 stroke-width=\"2\"/>\n<circle cx=\"{:.0}\" cy=\"{legend:.0}\" r=\"4\" \
                 fill=\"{colour}\"/><text x=\"{:.0}\" y=\"{:.0}\">{contender}</text>",
                end + 16.0,
                end + 26.0,
                legend + 4.0
            );
        }
    }
    out.push_str("</svg>\n");
    out
}

/// The different items, in order of appearance.
fn distinct<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<T> {
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
        for text in ["A^T B, f64, 1 thread:", "f32, 2 threads:", "64x32", ">ours<", "64x32: 1.250"]
        {
            assert!(picture.contains(text), "{text}");
        }
        assert!(!picture.contains(">mkl<"), "the yardstick is the line at 1");
        assert!(!picture.contains("NaN"));
    }
}
