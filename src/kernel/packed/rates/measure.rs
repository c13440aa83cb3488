//! Measures rates: the steps of a kernel, on one core, on pieces like those of the schedule.

use std::time::Instant;

use faer::MatRef;

use super::Rates;
use crate::base::{Error, Result, Workspace};
use crate::kernel::packed::geometry::{Area, Geometry};
use crate::kernel::packed::isa::FloatIsa;
use crate::kernel::packed::kernel::Kernel;
use crate::kernel::packed::operand::sealed::Kernels;
use crate::kernel::packed::operands::Source;
use crate::kernel::packed::pack::Panels;
use crate::kernel::packed::target::{Destination, Part, Target};
use crate::kernel::packed::tile::{Row, Side};

/// Rows and columns of the matrix that fits no cache: 133 MB. Not a power of two, since its rows
/// would then compete for the same few sets of a cache.
const SIDE: usize = 4080;

/// Rows packed at a time; panels of all columns take 8 MB.
const DEPTH: usize = 256;

/// Most columns packed at a time, and most columns of an item: whole panels of every isa.
const ITEM: usize = 120;

/// Blocks that are summed while packed: enough to see what reading costs.
const SOURCES: usize = 2;

/// Timed windows of a measurement, of which the median is the result.
const WINDOWS: usize = 25;

/// Least seconds of a window, short enough that other programs interrupt few windows.
const WINDOW: f64 = 2e-3;

impl Rates {
    /// Measures the rates for f64 on the calling thread, in about half a second, with 142 MB of
    /// memory.
    ///
    /// ```no_run
    /// use catamaran::{AtaOptions, blas, kernel::packed::{FloatIsa, Rates}};
    ///
    /// let rates = Rates::measure(FloatIsa::best())?;
    /// assert!(rates.flops > 0.0);
    /// let options = AtaOptions::new().backend(blas::native_with(FloatIsa::best(), rates));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] when this machine refuses the isa, [`Error::OutOfMemory`].
    pub fn measure(isa: FloatIsa) -> Result<Self> {
        if let Some(why) = isa.refusal() {
            let why = format!("{}: {why}", isa.name());
            return Err(Error::Argument { what: "isa", why });
        }
        let mut matrix = Workspace::new(SIDE * SIDE)?;
        let mut panels = Workspace::new(DEPTH * SIDE)?;
        let mut bench = Bench::new(
            f64::kernel(isa),
            &mut matrix.as_mut_slice()[..SIDE * SIDE],
            &mut panels.as_mut_slice()[..DEPTH * SIDE],
        );
        let flops = bench.flops();
        let pack_bytes = bench.pack_bytes();
        Ok(Self {
            flops,
            read_bytes: bench.read_bytes(pack_bytes),
            pack_bytes,
            update_bytes: bench.update_bytes(),
        })
    }
}

/// A kernel and the memory it is measured on.
struct Bench<'a> {
    kernel: &'static dyn Kernel<f64>,
    geometry: Geometry,
    /// Columns packed at a time, and the side of an item: whole panels, at most [`ITEM`].
    item: usize,
    /// SIDE x SIDE, by rows.
    matrix: &'a mut [f64],
    /// DEPTH x SIDE.
    panels: &'a mut [f64],
}

impl<'a> Bench<'a> {
    fn new(kernel: &'static dyn Kernel<f64>, matrix: &'a mut [f64], panels: &'a mut [f64]) -> Self {
        assert_eq!((matrix.len(), panels.len()), (SIDE * SIDE, DEPTH * SIDE));
        // Writes every page: pages never written may all map to one page of zeros.
        for memory in [&mut *matrix, &mut *panels] {
            memory.iter_mut().enumerate().for_each(|(i, x)| *x = (i % 251) as f64 / 251.0);
        }
        let geometry = kernel.geometry();
        let item = ITEM / geometry.width * geometry.width;
        assert!(item > 0 && 2 * DEPTH * item + item * item <= panels.len());
        Self { kernel, geometry, item, matrix, panels }
    }

    /// Measures the flops per second of an item whose panels and sums lie in the second-level
    /// cache.
    fn flops(&mut self) -> f64 {
        let Self { kernel, geometry, item, .. } = *self;
        let Geometry { rows, width, .. } = geometry;
        let start = self.panels.as_mut_ptr();
        let (right, sums) =
            (start.wrapping_add(DEPTH * item), start.wrapping_add(2 * DEPTH * item));
        median_rate(|| {
            for corner in (0..item).step_by(rows) {
                let left = side(start, DEPTH, geometry).at_column(corner, width);
                let right = side(right, DEPTH, geometry);
                let row = Row {
                    sums: sums.wrapping_add(corner * item),
                    kept: true,
                    add: true,
                    ..row(DEPTH, [left, right], corner, 0..item / width, &[])
                };
                // SAFETY: whole panels of DEPTH rows, and tiles after them, for which `new` has
                // asserted that there is room.
                unsafe { kernel.multiply_row(&row) };
            }
            (2 * DEPTH * item * item) as f64
        })
    }

    /// Measures the bytes per second written into panels, from a source that lies in the
    /// second-level cache.
    fn pack_bytes(&mut self) -> f64 {
        let sources = [source(self.matrix, 0)];
        let columns = 0..self.item;
        median_rate(|| pack(self.kernel, &sources, self.panels, |_| columns.clone(), self.item))
    }

    /// Measures the bytes per second read: from the time to pack sums of sources that lie in no
    /// cache, less the time of writing at `pack_bytes`.
    fn read_bytes(&mut self, pack_bytes: f64) -> f64 {
        let item = self.item;
        let mut block = 0;
        let packed = median_rate(|| {
            let sources: [_; SOURCES] = std::array::from_fn(|i| source(self.matrix, block + i));
            block += SOURCES;
            pack(self.kernel, &sources, self.panels, |i| i * item..(i + 1) * item, item)
        });
        // Seconds per byte of the panels.
        let (all, writing) = (1.0 / packed, 1.0 / pack_bytes);
        // Reading takes at least a quarter of the time, whatever the noise.
        (SOURCES as f64 / (all - writing).max(all / 4.0)).round()
    }

    /// Measures the bytes per second read and written when the tiles of one item after another are
    /// added to the matrix.
    fn update_bytes(&mut self) -> f64 {
        let Self { kernel, geometry, item, .. } = *self;
        let Geometry { rows, width, .. } = geometry;
        let sums = self.panels.as_mut_ptr();
        let sides = [side(sums, 0, geometry); 2];
        let matrix = faer::MatMut::from_row_major_slice_mut(self.matrix, SIDE, SIDE);
        let targets = [Destination::new(matrix, Part::All).block(0..SIDE, 0..SIDE, 1.0, 1.0)];
        let items = SIDE / item;
        let mut number = 0;
        median_rate(|| {
            let (first_row, first_col) = (number / items % items * item, number % items * item);
            number += 1;
            let panels = first_col / width..(first_col + item) / width;
            for corner in (first_row..first_row + item).step_by(rows) {
                let row = Row { sums, ..row(0, sides, corner, panels.clone(), &targets) };
                // SAFETY: without steps no side is read, one tile is used; the matrix is borrowed.
                unsafe { kernel.multiply_row(&row) };
            }
            (2 * item * item * size_of::<f64>()) as f64
        })
    }
}

/// Returns a side of packed panels of `steps` rows.
fn side(start: *const f64, steps: usize, geometry: Geometry) -> Side<f64> {
    Side { start, row_stride: geometry.width as isize, panel_stride: steps * geometry.width }
}

/// Returns a row of tiles that prefetches no right side.
fn row<'r>(
    steps: usize,
    [left, right]: [Side<f64>; 2],
    corner: usize,
    panels: std::ops::Range<usize>,
    targets: &'r [Target<f64>],
) -> Row<'r, f64> {
    Row {
        steps,
        left,
        right,
        next_left: left.start,
        next_right: right.start,
        next_lines: 0,
        panels,
        wanted: 0..SIDE,
        sums: std::ptr::null_mut(),
        kept: false,
        add: false,
        targets,
        corner,
    }
}

/// Returns a block of DEPTH rows; the number of the block wraps around.
fn source(matrix: &[f64], block: usize) -> Source<'_, f64> {
    let matrix = MatRef::from_row_major_slice(matrix, SIDE, SIDE);
    let first = block % (SIDE / DEPTH) * DEPTH;
    Source { coefficient: 1.0, matrix: matrix.subrows(first, DEPTH), scale: None }
}

/// Fills the panels, `item` columns at a time: the i-th time with the columns `columns(i)` of the
/// sum of the sources. Returns the number of bytes written.
fn pack(
    kernel: &dyn Kernel<f64>,
    sources: &[Source<'_, f64>],
    panels: &mut [f64],
    columns: impl Fn(usize) -> std::ops::Range<usize>,
    item: usize,
) -> f64 {
    let stride = DEPTH * kernel.geometry().width;
    let pieces = panels.chunks_exact_mut(DEPTH * item);
    let bytes = pieces.len() * DEPTH * item * size_of::<f64>();
    for (i, piece) in pieces.enumerate() {
        let area = Area { rows: 0..DEPTH, cols: columns(i) };
        assert_eq!(area.cols.len(), item);
        // SAFETY: the piece holds whole panels of as many columns.
        unsafe { kernel.pack(sources, &area, Panels::new(piece.as_mut_ptr(), stride)) };
    }
    bytes as f64
}

/// Returns the median rate of `work` over [`WINDOWS`] windows, in units per second; `work` returns
/// how many units it did.
fn median_rate(mut work: impl FnMut() -> f64) -> f64 {
    // The first call is not typical.
    work();
    let mut rates = [0.0; WINDOWS];
    for rate in &mut rates {
        let (start, mut done) = (Instant::now(), 0.0);
        loop {
            done += work();
            let seconds = start.elapsed().as_secs_f64();
            if seconds > WINDOW {
                *rate = done / seconds;
                break;
            }
        }
    }
    rates.sort_by(f64::total_cmp);
    rates[WINDOWS / 2].round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measured_rates_are_rates_and_refused_instances_are_named() {
        for isa in FloatIsa::ALL {
            match (isa.refusal(), Rates::measure(isa)) {
                (None, Ok(rates)) => {
                    let text = rates.to_text(isa);
                    assert_eq!(Rates::parse(&text, isa), Ok(rates), "positive and finite");
                }
                (Some(why), Err(e)) => {
                    assert_eq!(e.to_string(), format!("isa: {}: {why}", isa.name()));
                }
                (refusal, measured) => panic!("{isa:?}: {refusal:?}, {measured:?}"),
            }
        }
    }
}
