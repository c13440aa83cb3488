//! A^T A of a sparse matrix that never becomes dense.
//!
//! Line j of the triangle is the sum over the rows i that have an entry in column j, each row
//! scaled by it: `c_j = sum w_i a_ij a_i`. A panel of sums for a block of lines takes the scattered
//! additions, row after row, and C is written once.

use std::ops::Range;

use faer::MatMut;
use faer::prelude::ReborrowMut;
use sprs::{CsMat, CsMatView};

use crate::base::{
    Disjoint, Error, Real, Result, Tracker, Workspace, finite_weights, reserved, tickets,
    triangle_len,
};
use crate::blas::BlasReal;
use crate::product::combine::mirror_lower;
use crate::product::{AtaOptions, Uplo};

/// Sums of a block of lines: 512 KiB, half of a second level cache.
const PANEL: usize = 1 << 16;

/// Blocks of lines for each thread, so that threads end at about the same time.
const BLOCKS_PER_THREAD: usize = 8;

/// Computes `C := alpha A^T W A + beta C` for a sparse A by rows (CSR), m x n, with m finite
/// weights W or none. Of the options, `uplo` (the triangle or triangles to compute), `par` and
/// `progress` have an effect.
///
/// Sums are in f64 and in the order of the rows, rounded once to T: the result is the same, bit for
/// bit, for every `options.par`. Entries that are not stored are zeros, and not multiplied: NaN and
/// infinities reach those entries of C only whose columns share a row with them. With `beta == 0` C
/// is not read, with `alpha == 0` A is not. The extra memory is at most 16 bytes for each entry and
/// 24 for each column of A, and for each thread n f64 or 512 KiB. [`sparse_is_faster`] says whether
/// the dense product would take longer.
///
/// ```
/// use catamaran::product::ata_sparse;
/// use catamaran::faer::{Mat, mat};
/// use catamaran::sparse::CsMat;
/// use catamaran::{AtaOptions, Uplo};
///
/// let a = CsMat::new((3, 2), vec![0, 1, 3, 3], vec![0, 0, 1], vec![2.0, 1.0, 3.0]);
/// let mut c = Mat::zeros(2, 2);
/// let options = AtaOptions::new().uplo(Uplo::Both);
/// ata_sparse(1.0, a.view(), None, 0.0, c.as_mut(), &options)?;
/// assert_eq!(c, mat![[5.0, 3.0], [3.0, 9.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when C is not n x n or there are not m weights, [`Error::NonFinite`] for a
/// weight, [`Error::Argument`] when A is by columns, [`Error::OutOfMemory`], [`Error::Cancelled`].
pub fn ata_sparse<S: Real, T: BlasReal>(
    alpha: T,
    a: CsMatView<'_, S>,
    weights: Option<&[f64]>,
    beta: T,
    mut c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let n = a.cols();
    Error::check_shape("C", (n, n), c.shape())?;
    if !a.is_csr() {
        return Err(Error::Argument { what: "A", why: "must be stored by rows (CSR)".into() });
    }
    finite_weights(a.rows(), weights)?;
    // NaN times an alpha of 0 is not added to C.
    let none = CsMat::zero((0, n));
    let (a, weights) = if alpha == T::ZERO { (none.view(), None) } else { (a, weights) };
    let lower = match options.uplo {
        Uplo::Upper => c.rb_mut().transpose_mut(),
        Uplo::Lower | Uplo::Both => c.rb_mut(),
    };
    options.on_cores(|| lower_triangle(alpha, a, weights, beta, lower, options))?;
    if options.uplo == Uplo::Both {
        mirror_lower(c);
    }
    Ok(())
}

/// Returns whether [`ata_sparse`] takes less time than the dense product of the same entries, by a
/// measured rule.
///
/// ```
/// use catamaran::product::{sparse_is_faster, sparse_multiplications};
/// use catamaran::sparse::CsMat;
///
/// let diagonal = CsMat::<f64>::eye(1000);
/// assert_eq!(sparse_multiplications(diagonal.view()), 1000);
/// assert!(sparse_is_faster(diagonal.view()));
/// ```
pub fn sparse_is_faster<S: Real>(a: CsMatView<'_, S>) -> bool {
    /// Multiplications of a dense product in the time of one of the sparse product, both f64, where
    /// the two take about as long: 12 to 34, for A from 500 x 4000 to 50000 x 100 on 1 and 2
    /// threads of an AMD EPYC with AVX-512.
    const DENSE_PER_SPARSE: f64 = 24.0;
    let (m, n) = (a.rows() as f64, a.cols() as f64);
    DENSE_PER_SPARSE * sparse_multiplications(a) as f64 <= m * n * (n + 1.0) / 2.0
}

/// Returns the multiplications of [`ata_sparse`] for one triangle: r (r + 1) / 2 for a row of r
/// entries.
///
/// ```
/// use catamaran::{product::sparse_multiplications, sparse::CsMat};
///
/// // Rows of one, two and no entries.
/// let a = CsMat::new((3, 2), vec![0, 1, 3, 3], vec![0, 0, 1], vec![2.0, 1.0, 3.0]);
/// assert_eq!(sparse_multiplications(a.view()), 1 + 3);
/// ```
pub fn sparse_multiplications<S: Real>(a: CsMatView<'_, S>) -> usize {
    a.outer_iterator().map(|row| triangle_len(row.nnz())).sum()
}

/// Computes [`ata_sparse`] in the lower triangle.
fn lower_triangle<S: Real, T: BlasReal>(
    alpha: T,
    a: CsMatView<'_, S>,
    weights: Option<&[f64]>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let n = a.cols();
    if n == 0 {
        return options.progress.report(1.0);
    }
    let threads = options.par.at_most(n).threads();
    let shares = if threads == 1 { 1 } else { threads * BLOCKS_PER_THREAD };
    let height = (PANEL / n).min(n.div_ceil(shares)).max(1);
    let by_columns = c.row_stride().unsigned_abs() <= c.col_stride().unsigned_abs();
    let blocks = Blocks::new(a, height, by_columns)?;
    let c = Disjoint::new(c);
    let mut panels = Vec::new();
    for _ in 0..threads {
        panels.push(Workspace::<f64>::new(height * n)?);
    }
    let tracker = Tracker::new(options.progress, blocks.work.iter().sum::<usize>() as f64);
    let (alpha, beta) = (alpha.to_f64(), beta.to_f64());
    tickets(&mut panels, blocks.work.len(), |panel, block| {
        let (lines, panel) = (blocks.lines(block), panel.as_mut_slice());
        panel.fill(0.0);
        if alpha != 0.0 {
            blocks.add(block, weights, panel);
        }
        for (j, sums) in lines.zip(panel.chunks(n)) {
            let range = if by_columns { j..n } else { 0..j + 1 };
            let (rows, cols) = match by_columns {
                true => (range.clone(), j..j + 1),
                false => (j..j + 1, range.clone()),
            };
            // SAFETY: line j of the triangle, which belongs to this ticket alone.
            let line = unsafe { c.block(rows, cols) };
            let line = if by_columns { line.col_mut(0) } else { line.row_mut(0).transpose_mut() };
            for (entry, &sum) in line.iter_mut().zip(&sums[range]) {
                let old = if beta == 0.0 { 0.0 } else { beta * entry.to_f64() };
                *entry = T::from_f64(alpha * sum + old);
            }
        }
        tracker.add(blocks.work[block] as f64)
    });
    tracker.finish()
}

/// Blocks of consecutive lines of the lower triangle of C, and the entries of A that they are made
/// of.
struct Blocks<'a, S> {
    a: CsMatView<'a, S>,
    /// Lines of a block.
    height: usize,
    /// Whether a line is the part of a column of C from the diagonal on, not of a row up to it.
    by_columns: bool,
    /// Where the entries of a block begin in `entries`, and the end of the last block.
    starts: Vec<usize>,
    /// A row of A with entries in the columns of the block, and the place of the first of them;
    /// ascending.
    entries: Vec<(usize, usize)>,
    /// Additions of each block, and sums in its panel.
    work: Vec<usize>,
}

impl<'a, S: Real> Blocks<'a, S> {
    fn new(a: CsMatView<'a, S>, height: usize, by_columns: bool) -> Result<Self> {
        let count = a.cols().div_ceil(height);
        let mut starts = reserved(count + 1)?;
        starts.resize(count + 1, 0);
        let mut blocks =
            Self { a, height, by_columns, starts, entries: Vec::new(), work: Vec::new() };
        let mut work = reserved(count)?;
        work.extend((0..count).map(|block| blocks.lines(block).len() * a.cols()));
        let mut starts = std::mem::take(&mut blocks.starts);
        blocks.for_each_entry(|block, _, part| {
            starts[block + 1] += 1;
            work[block] += part;
        });
        for block in 0..count {
            starts[block + 1] += starts[block];
        }
        let mut entries = reserved(starts[count])?;
        entries.resize(starts[count], (0, 0));
        let mut ends = reserved(count)?;
        ends.extend_from_slice(&starts[..count]);
        blocks.for_each_entry(|block, entry, _| {
            entries[ends[block]] = entry;
            ends[block] += 1;
        });
        Ok(Self { starts, entries, work, ..blocks })
    }

    /// Calls `visit(block, (row, place), additions)` for every row and every block with columns of
    /// its entries.
    fn for_each_entry(&self, mut visit: impl FnMut(usize, (usize, usize), usize)) {
        let columns = self.a.indices();
        for row in 0..self.a.rows() {
            let places = self.a.indptr().outer_inds_sz(row);
            let mut place = places.start;
            while place < places.end {
                let block = columns[place] / self.height;
                let (first, mut additions) = (place, 0);
                while place < places.end && columns[place] / self.height == block {
                    additions += self.part(&places, place).len();
                    place += 1;
                }
                visit(block, (row, first), additions);
            }
        }
    }

    fn lines(&self, block: usize) -> Range<usize> {
        block * self.height..self.a.cols().min((block + 1) * self.height)
    }

    /// Returns the entries of a row of A, at these places, that belong to a line. The row has its
    /// entry of the line's column at `place`: columns ascend within a row.
    fn part(&self, places: &Range<usize>, place: usize) -> Range<usize> {
        if self.by_columns { place..places.end } else { places.start..place + 1 }
    }

    /// Adds the lines of a block to the sums in `panel`, which has a row of n for each.
    fn add(&self, block: usize, weights: Option<&[f64]>, panel: &mut [f64]) {
        let (n, lines) = (self.a.cols(), self.lines(block));
        let (columns, values) = (self.a.indices(), self.a.data());
        for &(row, first) in &self.entries[self.starts[block]..self.starts[block + 1]] {
            let places = self.a.indptr().outer_inds_sz(row);
            let weight = weights.map_or(1.0, |w| w[row]);
            for place in first..places.end {
                if columns[place] >= lines.end {
                    break;
                }
                let factor = weight * values[place].to_f64();
                let sums = &mut panel[(columns[place] - lines.start) * n..][..n];
                let part = self.part(&places, place);
                for (&column, value) in columns[part.clone()].iter().zip(&values[part]) {
                    sums[column] += factor * value.to_f64();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use faer::{Mat, MatRef};
    use sprs::{CsMat, TriMat};

    use super::*;
    use crate::base::{Par, Pin, Rng};

    /// Returns a random matrix; the triplets of some entries come in two parts, and some rows and
    /// columns are empty.
    fn random(m: usize, n: usize, share: f64, seed: u64) -> CsMat<f64> {
        let mut rng = Rng::new(seed);
        let mut entries = TriMat::new((m, n));
        for i in 0..m {
            for j in 0..n {
                let value = 2.0 * rng.uniform() - 1.0;
                if rng.uniform() < share && i % 7 != 3 && j % 5 != 2 {
                    entries.add_triplet(i, j, value);
                    if i % 3 == 0 {
                        entries.add_triplet(i, j, 0.25);
                    }
                }
            }
        }
        entries.to_csr()
    }

    /// Returns the same product in dense f64, the sums in another order.
    fn oracle(a: &CsMat<f64>, weights: Option<&[f64]>) -> Mat<f64> {
        let n = a.cols();
        let dense = a.to_dense();
        Mat::from_fn(n, n, |j, k| {
            (0..a.rows())
                .rev()
                .map(|i| weights.map_or(1.0, |w| w[i]) * dense[[i, j]] * dense[[i, k]])
                .sum()
        })
    }

    fn wanted(uplo: Uplo, i: usize, j: usize) -> bool {
        match uplo {
            Uplo::Lower => i >= j,
            Uplo::Upper => i <= j,
            Uplo::Both => true,
        }
    }

    #[test]
    fn the_product_is_that_of_the_dense_matrix_in_every_triangle_and_layout() {
        for (m, n, share) in [(40, 33, 0.2), (9, 50, 0.05), (0, 6, 1.0), (5, 1, 1.0), (3, 0, 1.0)] {
            let a = random(m, n, share, 7);
            let weights: Vec<f64> = (0..m).map(|i| i as f64 - 4.0).collect();
            for weights in [None, Some(&weights[..])] {
                let expected = oracle(&a, weights);
                for uplo in [Uplo::Lower, Uplo::Upper, Uplo::Both] {
                    for transposed in [false, true] {
                        let old = Mat::from_fn(n, n, |i, j| (i.max(j) * n + i.min(j)) as f64);
                        let mut c = old.clone();
                        let view = if transposed { c.as_mut().transpose_mut() } else { c.as_mut() };
                        let options = AtaOptions::new().uplo(uplo).threads(2);
                        ata_sparse(0.5, a.view(), weights, -2.0, view, &options).unwrap();
                        let c: MatRef<'_, f64> =
                            if transposed { c.transpose() } else { c.as_ref() };
                        for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
                            let new = 0.5 * expected[(i, j)] - 2.0 * old[(i, j)];
                            let value = if wanted(uplo, i, j) { new } else { old[(i, j)] };
                            assert!((c[(i, j)] - value).abs() <= 1e-11 * (1.0 + value.abs()));
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn bits_do_not_depend_on_threads_or_their_cores() {
        let a = random(300, 211, 0.1, 3);
        let product = |par, pin| {
            let mut c = Mat::<f64>::zeros(211, 211);
            let options = AtaOptions::new().uplo(Uplo::Both).par(par).pin(pin);
            ata_sparse(1.0, a.view(), None, 0.0, c.as_mut(), &options).unwrap();
            c
        };
        let one = product(Par::Seq, Pin::No);
        for (threads, pin) in [(2, Pin::No), (3, Pin::Cores), (4, Pin::No), (5, Pin::Cores)] {
            assert!(product(Par::Threads(threads), pin) == one, "{threads} threads, {pin:?}");
        }
    }

    #[test]
    fn single_precision_is_rounded_once() {
        let a = random(60, 20, 0.5, 5);
        let single = a.map(|&x| x as f32);
        let expected = oracle(&single.map(|&x| f64::from(x)), None);
        let mut c = Mat::<f32>::zeros(20, 20);
        ata_sparse(1.0, single.view(), None, 0.0, c.as_mut(), &AtaOptions::new()).unwrap();
        for (i, j) in (0..20).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let exact = expected[(i, j)];
            assert!((f64::from(c[(i, j)]) - exact).abs() <= 6e-8 * exact.abs() + 1e-13);
        }
    }

    #[test]
    fn factors_of_zero_read_nothing() {
        let mut a = random(6, 5, 1.0, 1);
        a.data_mut().fill(f64::NAN);
        let mut c = Mat::from_fn(5, 5, |_, _| 3.0);
        ata_sparse(0.0, a.view(), None, 2.0, c.as_mut(), &AtaOptions::new()).unwrap();
        assert_eq!(c[(4, 0)], 6.0);
        c.fill(f64::NAN);
        let a = random(6, 5, 1.0, 1);
        ata_sparse(1.0, a.view(), None, 0.0, c.as_mut(), &AtaOptions::new()).unwrap();
        assert!(c[(4, 0)].is_finite() && c[(0, 4)].is_nan());
    }

    #[test]
    fn rows_of_a_larger_matrix_are_a_matrix() {
        let a = random(50, 12, 0.4, 9);
        let mut c = Mat::zeros(12, 12);
        let part = a.slice_outer(20..41);
        ata_sparse(1.0, part, None, 0.0, c.as_mut(), &AtaOptions::new()).unwrap();
        let expected = oracle(&part.to_owned(), None);
        for (i, j) in (0..12).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            assert!((c[(i, j)] - expected[(i, j)]).abs() < 1e-12);
        }
    }

    #[test]
    fn what_does_not_fit_is_an_error() {
        let a = random(4, 3, 1.0, 2);
        let options = AtaOptions::new();
        let mut c = Mat::zeros(3, 3);
        let mut run = |a: CsMatView<'_, f64>, weights: &[f64]| {
            ata_sparse(1.0, a, Some(weights), 0.0, c.as_mut(), &options).unwrap_err()
        };
        assert!(matches!(run(a.view(), &[1.0; 3]), Error::Shape { what: "weights", .. }));
        let weights = [1.0, 1.0, f64::INFINITY, 1.0];
        assert!(matches!(run(a.view(), &weights), Error::NonFinite { what: "weights", .. }));
        assert!(matches!(run(a.to_csc().view(), &[1.0; 4]), Error::Argument { what: "A", .. }));
        let mut small = Mat::zeros(3, 2);
        let short = ata_sparse(1.0, a.view(), None, 0.0, small.as_mut(), &options).unwrap_err();
        assert!(matches!(short, Error::Shape { what: "C", .. }));
        let stop = |_: f64| ControlFlow::Break(());
        let options = options.progress(&stop);
        let stopped = ata_sparse(1.0, a.view(), None, 0.0, c.as_mut(), &options).unwrap_err();
        assert_eq!(stopped, Error::Cancelled);
    }

    #[test]
    fn few_entries_make_the_sparse_product_the_faster_one() {
        assert!(sparse_is_faster(random(200, 200, 0.01, 1).view()));
        assert!(!sparse_is_faster(random(200, 200, 0.9, 1).view()));
        // Three rows of two entries, and one that is empty.
        let mut a = TriMat::<f64>::new((4, 9));
        (0..3).for_each(|i| (0..2).for_each(|j| a.add_triplet(i, i + j, 1.0)));
        assert_eq!(sparse_multiplications(a.to_csr().view()), 9);
    }
}
