//! Functions that distinguish the points of a shape, many for each vertex (rows), for
//! correspondences and as test signals.
//!
//! From eigenpairs of the Laplacian: heat and wave kernel signatures and related ones, which are
//! invariant under isometries. From the mesh: [`shot()`], which is invariant under rigid motions,
//! and [`geodesic_rings`], intrinsic and local, which replaces the anisotropic windowed Fourier
//! transform of the thesis.

mod cells;
mod rings;
mod shot;
mod signatures;
#[cfg(test)]
mod tests;

pub use rings::{RingOptions, geodesic_rings};
pub use shot::{SHOT_BINS, ShotOptions, shot};
pub use signatures::{
    WaveScales, global_point_signature, heat_kernel, heat_kernel_signature, heat_times, heat_trace,
    wave_kernel_signature, wave_scales,
};

use std::ops::ControlFlow;
use std::ops::Range;

use faer::Mat;

use catamaran::base::{Error, Par, Progress, Result, Tracker};

/// Returns an n x columns matrix from blocks of rows, each of which a thread writes by `rows` in
/// row-major order.
fn by_rows(
    n: usize,
    columns: usize,
    block: usize,
    par: Par,
    progress: Progress<'_>,
    rows: impl Fn(Range<usize>, &mut [f64]) -> Result<()> + Sync,
) -> Result<Mat<f64>> {
    let tracker = Tracker::new(progress, n as f64);
    let blocks = par.map_blocks(n, block, |range| {
        if tracker.state().is_break() {
            return Err(Error::Cancelled);
        }
        let size = range.len();
        let mut values = vec![0.0; size * columns];
        rows(range, &mut values)?;
        match tracker.add(size as f64) {
            ControlFlow::Continue(()) => Ok(values),
            ControlFlow::Break(()) => Err(Error::Cancelled),
        }
    });
    let mut result = catamaran::dense::zeros(n, columns)?;
    let mut start = 0;
    for values in blocks {
        let values = values?;
        let size = block.min(n - start);
        for j in 0..columns {
            for i in 0..size {
                result[(start + i, j)] = values[i * columns + j];
            }
        }
        start += size;
    }
    Ok(result)
}
