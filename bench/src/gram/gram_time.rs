//! The cost of the extended Gram matrix: its time relative to that of the exact path with its
//! default accuracy.

use std::time::Instant;

use catamaran::faer::MatRef;

use super::ours;
use crate::Result;
use crate::input::{Distribution, Shape, matrix};
use crate::plant::Part;
use crate::race::median;

/// Returns the times of both for square matrices, in turns.
///
/// # Errors
/// The errors of our side.
pub fn gram_time(threads: usize, repeat: usize, quick: bool) -> Result<Part> {
    let sides: &[usize] = if quick { &[200, 400] } else { &[1000, 2000, 4096] };
    let mut part = Part {
        figure: "ratio",
        title: format!("extended Gram matrix, uniform n x n, {threads} threads"),
        columns: ["exact s", "extended s", "ratio"].map(String::from).into(),
        ..Part::default()
    };
    for &n in sides {
        let a = matrix::<f64>(Shape { m: n, n }, Distribution::Uniform, 1);
        let a = MatRef::from_row_major_slice(&a, n, n);
        let mut samples: Vec<[f64; 2]> = Vec::new();
        // The first call includes the creation of threads and buffers.
        for _ in 0..=repeat.max(1) {
            samples.push([
                seconds(|| ours::exact_gram(a, threads))?,
                seconds(|| ours::extended_gram(a, threads))?,
            ]);
        }
        let of = |who: usize| median(samples[1..].iter().map(|pair| pair[who]).collect());
        let ratio = median(samples[1..].iter().map(|[exact, extended]| extended / exact).collect());
        part.rows.push((format!("n = {n}"), vec![of(0), of(1), ratio]));
    }
    Ok(part)
}

fn seconds(call: impl FnOnce() -> Result<()>) -> Result<f64> {
    let start = Instant::now();
    call()?;
    Ok(start.elapsed().as_secs_f64())
}
