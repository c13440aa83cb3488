//! A^T A on up to 65,536 ranks as the plans predict it: seconds, and words that a rank sends or
//! receives.

use std::fmt::Write;

use catamaran::ata::distributed::{Cost, Machine, Mode, lower_bound, predict};

use crate::chart::{COLOURS, END, LEFT, Panel, distinct, open, point};
use crate::input::Shape;

/// Ranks: powers of two up to here.
const MOST: usize = 1 << 16;
/// Heights of a panel, in those of a race.
const HEIGHT: f64 = 1.4;

/// A mode at one shape and number of ranks.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Shape of A.
    pub shape: Shape,
    /// Ranks.
    pub ranks: usize,
    /// What the mode costs.
    pub cost: Cost,
    /// Words that some rank must send or receive in any mode.
    pub least_words: f64,
    /// Seconds of nothing but an even share of the products.
    pub least_seconds: f64,
}

/// All modes at these shapes, on 1, 2, 4, ... 65,536 ranks of `machine`.
pub fn rows(shapes: &[Shape], machine: &Machine) -> Vec<Row> {
    let ranks = || (0..=MOST.ilog2()).map(|k| 1_usize << k);
    let of_shape = |&shape: &Shape| {
        let Shape { m, n } = shape;
        let work = m as f64 * n as f64 * (n as f64 + 1.0);
        ranks().flat_map(move |ranks| {
            Mode::NAMES.map(|(_, mode)| Row {
                shape,
                ranks,
                cost: predict(mode, ranks, m, n, machine),
                least_words: lower_bound(ranks, m, n).words,
                least_seconds: work / (ranks as f64 * machine.flops),
            })
        })
    };
    shapes.iter().flat_map(of_shape).collect()
}

/// The column names of the table.
pub const CSV_HEADER: &str = "m,n,ranks,mode,words,least_words,messages,products,memory_words,\
seconds,least_seconds";

impl Row {
    /// The values under [`CSV_HEADER`].
    pub fn csv(&self) -> String {
        let Self { shape, ranks, cost, least_words, least_seconds } = self;
        let Cost { mode, words, messages, products, memory, seconds } = cost;
        format!(
            "{},{},{ranks},{mode},{words:.0},{least_words:.0},{messages},{products:.0},\
             {memory:.0},{seconds:.4e},{least_seconds:.4e}",
            shape.m, shape.n
        )
    }
}

/// A name, and what is drawn.
type Curve = (&'static str, fn(&Row) -> f64);

/// The rows as an SVG document: two panels for each shape, all axes logarithmic.
pub fn svg(rows: &[Row], machine: &Machine) -> String {
    let shapes = distinct(rows.iter().map(|row| row.shape));
    let mut out = open(2 * shapes.len(), HEIGHT);
    for (s, shape) in shapes.iter().enumerate() {
        let own: Vec<&Row> = rows.iter().filter(|row| row.shape == *shape).collect();
        let Machine { latency, seconds_per_word, flops } = machine;
        let title = format!(
            "A {shape}: predicted seconds; ranks of {:.0} GFLOP/s, {:.1} GB/s (f64), {:.1} us",
            flops * 1e-9,
            8e-9 / seconds_per_word,
            latency * 1e6
        );
        let least: Curve = ("even share of the flops", |row| row.least_seconds);
        panel(&mut out, 2 * s, &title, &own, |row| row.cost.seconds, least);
        let title = format!("A {shape}: words that a rank sends, or receives if they are more");
        let least: Curve = ("lower bound", |row| row.least_words);
        panel(&mut out, 2 * s + 1, &title, &own, |row| row.cost.words, least);
    }
    out.push_str("</svg>\n");
    out
}

/// One line for each mode, a grey one for the least possible; what is 0 is left out.
fn panel(
    out: &mut String,
    p: usize,
    title: &str,
    rows: &[&Row],
    value: fn(&Row) -> f64,
    (least_name, least): Curve,
) {
    let panel = Panel::new(out, p, HEIGHT, title);
    let all = || rows.iter().flat_map(|row| [value(row), least(row)]).filter(|v| *v > 0.0);
    let bottom = all().fold(f64::INFINITY, f64::min).log10().floor();
    let top = all().fold(0.0, f64::max).log10().ceil().max(bottom + 1.0);
    let y = |value: f64| {
        panel.low - (panel.low - panel.high) * (value.log10() - bottom) / (top - bottom)
    };
    let steps = f64::from(MOST.ilog2()) + 1.0;
    let x = |ranks: usize| LEFT + (END - LEFT) * (f64::from(ranks.ilog2()) + 0.5) / steps;

    for decade in bottom as i32..=top as i32 {
        panel.tick(out, y(10_f64.powi(decade)), &format!("1e{decade}"));
    }
    for ranks in distinct(rows.iter().map(|row| row.ranks)).into_iter().step_by(2) {
        panel.below(out, x(ranks), &ranks.to_string());
    }
    let mut line = |k: usize, colour: &str, name: &str, places: &[(usize, f64)]| {
        let mut path = String::new();
        for &(ranks, value) in places.iter().filter(|(_, value)| *value > 0.0) {
            let (x, y) = (x(ranks), y(value));
            let _ = write!(path, "{}{x:.1} {y:.1}", if path.is_empty() { "M" } else { "L" });
            point(out, [x, y], colour, &format!("{name}, {ranks} ranks: {value:.3e}"));
        }
        let _ = writeln!(
            out,
            "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>"
        );
        panel.legend(out, k, colour, name);
    };
    let first = rows.iter().filter(|row| row.cost.mode == Mode::Rows);
    let places: Vec<_> = first.map(|row| (row.ranks, least(row))).collect();
    line(Mode::NAMES.len(), "#999999", least_name, &places);
    for (k, (name, mode)) in Mode::NAMES.iter().enumerate() {
        let own = rows.iter().filter(|row| row.cost.mode == *mode);
        let places: Vec<_> = own.map(|row| (row.ranks, value(row))).collect();
        line(k, COLOURS[k], name, &places);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mode_is_drawn_at_every_number_of_ranks() {
        let shapes = [Shape { m: 2000, n: 2000 }, Shape { m: 100_000, n: 10 }];
        let machine = Machine::default();
        let rows = rows(&shapes, &machine);
        assert_eq!(rows.len(), 2 * Mode::NAMES.len() * 17);
        let columns = CSV_HEADER.split(',').count();
        assert!(rows.iter().all(|row| row.csv().split(',').count() == columns));
        let picture = svg(&rows, &machine);
        for text in
            ["A 2000: predicted", ">grid<", ">lower bound<", "tree, 65536 ranks:", ">65536<"]
        {
            assert!(picture.contains(text), "{text}");
        }
        assert!(!picture.contains("NaN") && !picture.contains("inf"));
    }

    #[test]
    fn no_mode_is_faster_than_its_flops() {
        let shapes = [Shape { m: 3000, n: 2000 }];
        for row in rows(&shapes, &Machine::default()) {
            assert!(row.cost.seconds >= 0.999 * row.least_seconds, "{row:?}");
        }
    }
}
