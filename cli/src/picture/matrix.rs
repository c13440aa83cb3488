//! Heat maps of symmetric matrices.

use std::ops::Range;

use anyhow::{Result, bail};
use catamaran::base::Real;
use catamaran::faer::MatRef;
use catamaran::io::Output;
use colorous::{Color, Gradient, MAGMA, RED_BLUE};

use super::image::Image;

/// Longest side of a picture, in pixels; larger matrices are averaged down to it.
const LARGEST: usize = 1024;
/// Least side of a picture, about, in pixels: entries of small matrices become squares.
const SMALLEST: usize = 512;

/// The colours of a heat map, and the values they stand for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// From -1 (blue) over 0 (white) to 1 (red).
    Diverging,
    /// From 0 (black) to 1 (light), for products without negative entries.
    Sequential,
}

impl Scale {
    fn color(self, value: f64) -> Color {
        let (gradient, t): (Gradient, f64) = match self {
            Self::Diverging => (RED_BLUE, (1.0 - value) / 2.0),
            Self::Sequential => (MAGMA, value),
        };
        if t.is_nan() {
            return Color { r: 128, g: 128, b: 128 };
        }
        gradient.eval_continuous(t.clamp(0.0, 1.0))
    }

    /// Returns the scale as a CSS gradient from low to high.
    pub fn css(self) -> String {
        let low = if self == Self::Diverging { -1.0 } else { 0.0 };
        let stops: Vec<String> = (0..=16)
            .map(|i| format!("#{:x}", self.color(low + (1.0 - low) * f64::from(i) / 16.0)))
            .collect();
        format!("linear-gradient(to right, {})", stops.join(", "))
    }
}

/// Writes a picture of the n x n matrix C, and returns its colours. `entry` returns the row and
/// column that hold the entry (i, j). Entries are shown as `C_ij / sqrt(C_ii C_jj)`, which is a
/// correlation when A was centred, and as zero where the diagonal is zero.
pub fn write<T: Real>(
    output: Output,
    c: MatRef<'_, T>,
    entry: impl Fn(usize, usize) -> (usize, usize),
) -> Result<Scale> {
    let n = c.nrows();
    if n == 0 {
        bail!("{}: a matrix without columns has no picture", output.path().display());
    }
    let weights: Vec<f64> = (0..n)
        .map(|i| c[(i, i)].to_f64())
        .map(|d| if d > 0.0 { 1.0 / d.sqrt() } else { d * 0.0 })
        .collect();
    let value = |i: usize, j: usize| c[entry(i, j)].to_f64() * weights[i] * weights[j];

    let cells = n.min(LARGEST);
    let mut means = Vec::with_capacity(cells * cells);
    for y in 0..cells {
        for x in 0..cells {
            let (rows, cols) = (span(y, cells, n), span(x, cells, n));
            let sum: f64 =
                rows.clone().map(|i| cols.clone().map(|j| value(i, j)).sum::<f64>()).sum();
            means.push(sum / (rows.len() * cols.len()) as f64);
        }
    }
    let negative = means.iter().any(|&v| v < -0.02);
    let scale = if negative { Scale::Diverging } else { Scale::Sequential };
    draw(output, &means, cells, scale)?;
    Ok(scale)
}

/// Writes a picture of n x n levels, which are shown from 0 to 1, and returns the colours. A cell
/// of a larger matrix shows the highest of its levels.
pub fn levels(output: Output, n: usize, level: impl Fn(usize, usize) -> f64) -> Result<Scale> {
    let cells = n.min(SMALLEST);
    let mut highest = Vec::with_capacity(cells * cells);
    for y in 0..cells {
        for x in 0..cells {
            let (rows, cols) = (span(y, cells, n), span(x, cells, n));
            let all = rows.flat_map(|i| cols.clone().map(move |j| (i, j)));
            highest.push(all.map(|(i, j)| level(i, j)).fold(0.0, f64::max));
        }
    }
    draw(output, &highest, cells, Scale::Sequential)?;
    Ok(Scale::Sequential)
}

/// Returns the rows or columns, of n, that a cell shows.
fn span(cell: usize, cells: usize, n: usize) -> Range<usize> {
    cell * n / cells..(cell + 1) * n / cells
}

/// Writes a picture of `cells` x `cells` values.
fn draw(output: Output, values: &[f64], cells: usize, scale: Scale) -> Result<()> {
    let color = |x: usize, y: usize| scale.color(values[y * cells + x]).into_array();
    Image::from_fn(cells, cells, color).write_zoomed(output, (SMALLEST / cells).max(1))
}
