//! A heat map of a symmetric product.

use std::io::Write;

use anyhow::{Context, Result, bail};
use catamaran::base::Real;
use catamaran::faer::MatRef;
use catamaran::io::Output;
use colorous::{Color, Gradient, MAGMA, RED_BLUE};

/// Longest side of a picture; larger matrices are averaged down to it.
const LARGEST: usize = 1024;
/// Entries of small matrices become squares so that the side is at least about this.
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

    /// The two ends and the stops between, as a CSS gradient from low to high.
    pub fn css(self) -> String {
        let low = if self == Self::Diverging { -1.0 } else { 0.0 };
        let stops: Vec<String> = (0..=16)
            .map(|i| format!("#{:x}", self.color(low + (1.0 - low) * f64::from(i) / 16.0)))
            .collect();
        format!("linear-gradient(to right, {})", stops.join(", "))
    }
}

/// Writes a PNG of the n x n matrix C, of which `entry` gives the row and column that hold the
/// entry (i, j), and returns its colours. Entries are shown as `C_ij / sqrt(C_ii C_jj)`, which is a
/// correlation when A was centred, and zero where the diagonal is.
pub fn write<T: Real>(
    mut output: Output,
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
    let span = |cell: usize| cell * n / cells..(cell + 1) * n / cells;
    let mut means = Vec::with_capacity(cells * cells);
    for y in 0..cells {
        for x in 0..cells {
            let sum: f64 = span(y).map(|i| span(x).map(|j| value(i, j)).sum::<f64>()).sum();
            means.push(sum / (span(y).len() * span(x).len()) as f64);
        }
    }
    let negative = means.iter().any(|&v| v < -0.02);
    let scale = if negative { Scale::Diverging } else { Scale::Sequential };

    let zoom = (SMALLEST / cells).max(1);
    let side = cells * zoom;
    let mut pixels = Vec::with_capacity(side * side * 3);
    for y in 0..side {
        for x in 0..side {
            let color = scale.color(means[y / zoom * cells + x / zoom]);
            pixels.extend_from_slice(&[color.r, color.g, color.b]);
        }
    }
    let name = output.path().display().to_string();
    encode(&mut output, side as u32, &pixels)
        .with_context(|| format!("{name}: can't be written"))?;
    output.commit()?;
    Ok(scale)
}

fn encode(sink: &mut dyn Write, side: u32, rgb: &[u8]) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(sink, side, side);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()
}
