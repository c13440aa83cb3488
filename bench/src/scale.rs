//! Predictions of the plans for A^T A on up to 65,536 ranks: seconds, and words that a rank sends
//! or receives.

use catamaran::ranks::plan::{Cost, Machine, Mode, lower_bound, predict};
use catamaran_charts::{Axis, Chart, Series};

use crate::chart::distinct;
use crate::input::Shape;

/// Largest number of ranks, a power of two.
const MOST: usize = 1 << 16;

/// A mode at one shape and number of ranks.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Shape of A.
    pub shape: Shape,
    /// Number of ranks.
    pub ranks: usize,
    /// The cost of the mode.
    pub cost: Cost,
    /// Words that some rank must send or receive in any mode.
    pub least_words: f64,
    /// Seconds of an even share of the products alone.
    pub least_seconds: f64,
}

/// Returns all modes at these shapes, on 1, 2, 4, ... 65,536 ranks of `machine`.
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
    /// Returns the values under [`CSV_HEADER`].
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

/// A name, and the values to draw.
type Curve = (&'static str, fn(&Row) -> f64);

/// Draws the rows as an SVG document: two charts for each shape, all axes logarithmic.
pub fn svg(rows: &[Row], machine: &Machine) -> String {
    let shapes = distinct(rows.iter().map(|row| row.shape));
    let charts = shapes.iter().flat_map(|shape| {
        let own: Vec<&Row> = rows.iter().filter(|row| row.shape == *shape).collect();
        let Machine { latency, seconds_per_word, flops } = machine;
        let title = format!(
            "A {shape}: predicted seconds; ranks of {:.0} GFLOP/s, {:.1} GB/s (f64), {:.1} us",
            flops * 1e-9,
            8e-9 / seconds_per_word,
            latency * 1e6
        );
        let least: Curve = ("even share of the flops", |row| row.least_seconds);
        let seconds = chart(title, "seconds", &own, |row| row.cost.seconds, least);
        let title = format!("A {shape}: words that a rank sends, or receives if they are more");
        let least: Curve = ("lower bound", |row| row.least_words);
        [seconds, chart(title, "words", &own, |row| row.cost.words, least)]
    });
    catamaran_charts::svg(&charts.collect::<Vec<_>>())
}

/// Draws one curve for each mode, and a grey one for the least possible.
fn chart(
    title: String,
    unit: &str,
    rows: &[&Row],
    value: fn(&Row) -> f64,
    (least_name, least): Curve,
) -> Chart {
    let of_mode = |mode: Mode, value: fn(&Row) -> f64| {
        let own = rows.iter().filter(move |row| row.cost.mode == mode);
        own.map(|row| (row.ranks as f64, value(row))).collect()
    };
    let curve = |name, color, points| Series { dots: true, ..Series::curve(name, color, points) };
    let modes = Mode::NAMES.iter().enumerate();
    let modes =
        modes.map(|(k, (name, mode))| curve(*name, Series::color(k), of_mode(*mode, value)));
    let least = curve(least_name, [0x99; 3], of_mode(Mode::Rows, least));
    Chart {
        title,
        x: Axis::log2("ranks"),
        y: Axis::log10(unit),
        series: std::iter::once(least).chain(modes).collect(),
        rules: vec![],
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
        for text in ["A 2000: predicted", "\ngrid\n", "\nlower bound\n", "\n65536\n"] {
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
