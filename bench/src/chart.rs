//! The picture of a race: speed over the yardstick, one panel per type and thread count.

use std::fmt::Write;

use crate::table::Row;

const WIDTH: f64 = 900.0;
const PANEL_HEIGHT: f64 = 230.0;
const TOP: f64 = 36.0;
const BOTTOM: f64 = 34.0;
/// Where the panels begin and end.
pub(crate) const LEFT: f64 = 60.0;
pub(crate) const END: f64 = WIDTH - 200.0;
/// Okabe and Ito's colours, told apart by colour-blind readers too.
pub(crate) const COLOURS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#f0e442"];

/// How the line of equal times is drawn.
pub(crate) const LINE_AT_1: &str = "stroke=\"black\" stroke-width=\"1.5\"";

/// A panel of a picture: from `high` down to `low`.
pub(crate) struct Panel {
    pub high: f64,
    pub low: f64,
}

impl Panel {
    /// Panel `p`, of so many times the usual height, under its title.
    pub fn new(out: &mut String, p: usize, times: f64, title: &str) -> Self {
        let height = PANEL_HEIGHT * times;
        let origin = p as f64 * height;
        let (high, low) = (origin + TOP, origin + height - BOTTOM);
        let y = high - 14.0;
        let _ = writeln!(out, "<text x=\"{LEFT}\" y=\"{y:.0}\" font-size=\"14\">{title}</text>");
        Self { high, low }
    }

    /// A line across at height `y`.
    pub fn line(&self, out: &mut String, y: f64, style: &str) {
        let _ = writeln!(out, "<path d=\"M{LEFT} {y:.1}H{END}\" {style}/>");
    }

    /// A light line across with its value.
    pub fn tick(&self, out: &mut String, y: f64, value: &str) {
        self.line(out, y, "stroke=\"#ddd\"");
        let (x, y) = (LEFT - 6.0, y + 4.0);
        let _ = writeln!(out, "<text x=\"{x:.0}\" y=\"{y:.1}\" text-anchor=\"end\">{value}</text>");
    }

    /// A value below the panel.
    pub fn below(&self, out: &mut String, x: f64, value: &str) {
        let y = self.low + 18.0;
        let _ =
            writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.0}\" text-anchor=\"middle\">{value}</text>");
    }

    /// Line `k` of the legend.
    pub fn legend(&self, out: &mut String, k: usize, colour: &str, text: &str) {
        let y = self.high + 8.0 + 18.0 * k as f64;
        let (dot, left) = (END + 16.0, END + 26.0);
        let _ = writeln!(
            out,
            "<circle cx=\"{dot:.0}\" cy=\"{y:.0}\" r=\"4\" fill=\"{colour}\"/>\
             <text x=\"{left:.0}\" y=\"{:.0}\">{text}</text>",
            y + 4.0
        );
    }
}

/// The beginning of a picture of so many panels, each of so many times the usual height.
pub(crate) fn open(panels: usize, times: f64) -> String {
    let height = PANEL_HEIGHT * times * panels as f64;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" \
         viewBox=\"0 0 {WIDTH} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    )
}

/// A point, and what is shown when it is pointed at.
pub(crate) fn point(out: &mut String, [x, y]: [f64; 2], colour: &str, text: &str) {
    let _ = writeln!(
        out,
        "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{colour}\"><title>{text}</title></circle>"
    );
}

/// `1 thread`, `2 threads`.
pub(crate) fn count_threads(threads: usize) -> String {
    format!("{threads} thread{}", if threads == 1 { "" } else { "s" })
}

/// The rows of races at `formula` as an SVG document; ratios are to `yardstick`.
pub fn svg(rows: &[Row], formula: &str, yardstick: &str) -> String {
    let panels = distinct(rows.iter().map(|r| (r.scalar, r.threads)));
    let contenders =
        distinct(rows.iter().map(|r| r.contender.as_str()).filter(|c| *c != yardstick));
    let shapes = distinct(rows.iter().map(|r| r.shape.to_string()));
    let ratios = rows.iter().map(|r| r.ratio).filter(|r| r.is_finite());
    let top = (ratios.fold(1.1, f64::max) * 10.0).ceil() / 10.0;
    let tick = if top > 2.0 { 0.5 } else { 0.2 };

    let mut out = open(panels.len(), 1.0);
    for (p, (scalar, threads)) in panels.iter().enumerate() {
        let title =
            format!("{formula}, {scalar}, {}: speed over {yardstick}", count_threads(*threads));
        let panel = Panel::new(&mut out, p, 1.0, &title);
        let y = |ratio: f64| panel.low - (panel.low - panel.high) * ratio / top;
        let step = (END - LEFT) / shapes.len() as f64;
        let x = |i: usize| LEFT + step * (i as f64 + 0.5);

        let mut ratio = 0.0;
        while ratio <= top + 1e-9 {
            panel.tick(&mut out, y(ratio), &format!("{ratio:.1}"));
            ratio += tick;
        }
        panel.line(&mut out, y(1.0), LINE_AT_1);
        for (i, shape) in shapes.iter().enumerate() {
            panel.below(&mut out, x(i), shape);
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
                let text = format!("{contender} {shape}: {:.3}", row.ratio);
                point(&mut out, [x, y], colour, &text);
            }
            let _ = writeln!(
                out,
                "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-opacity=\"0.5\" \
                 stroke-width=\"2\"/>"
            );
            panel.legend(&mut out, k, colour, contender);
        }
    }
    out.push_str("</svg>\n");
    out
}

/// The different items, in order of appearance.
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
        for text in ["A^T B, f64, 1 thread:", "f32, 2 threads:", "64x32", ">ours<", "64x32: 1.250"]
        {
            assert!(picture.contains(text), "{text}");
        }
        assert!(!picture.contains(">mkl<"), "the yardstick is the line at 1");
        assert!(!picture.contains("NaN"));
    }
}
