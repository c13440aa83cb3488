//! Slices of the spectrum, one after the other, so that only one has to fit into memory.

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatRef};
use sprs::CsMatView;

use super::Mass;
use super::certificate::{ROUNDINGS, apart, certify};
use super::eigenpairs::Eigenpairs;
use super::eigs::{check, one_window, without_iteration};
use super::lanczos::{WIDTH, basis_size};
use super::options::EigenOptions;
use super::problem::Problem;
use super::space::{Inverse, WholePencil};
use crate::base::{Error, Result};
use crate::dense::{subtract_product, transposed_product, zeros};

/// Least number of pairs that are computed at once.
const LEAST: usize = 32;

/// Vectors handed out last, to which the next ones are made orthogonal.
const GUARD: usize = 16;

/// Progress of the checks and of the analysis of the matrices, before the first run.
const PREPARED: f64 = 0.01;

/// Share of the remaining progress of a slice that the next run takes. The run may not be the last
/// one of the slice.
const RUN_SHARE: f64 = 0.8;

/// Largest number of shifts that are tried for a slice.
const ATTEMPTS: usize = 20;

/// Computes the k smallest eigenpairs as [`eigs`](super::eigs()) does, in slices of the spectrum.
/// Each slice goes to `sink` as soon as it is found, in ascending order, so that the computation
/// takes no more than `memory` bytes beside W, M and what `sink` keeps. If all pairs fit, there is
/// one slice.
///
/// A slice is a run with a shift of its own, and ends in a gap between eigenvalues: equal ones are
/// never in two slices (but k may end among them). The eigenvalues below each cut are counted by
/// the inertia of a factorization there (Sylvester), and the run goes on until none is missing, as
/// under [`EigenOptions::verify_count`]. Vectors of one slice are orthonormal to rounding, and
/// orthogonal to the last ones of the slice before. Vectors farther apart are orthogonal to about
/// the tolerance times the eigenvalue over the distance of their eigenvalues.
///
/// The result is the same, bit for bit, for every `options.par`. It depends on `memory`.
///
/// ```
/// use catamaran::{prelude::*, sparse::eigs_sliced};
/// # use catamaran::sparse::Mass;
///
/// // A ring of 100 nodes: eigenvalues 2 - 2 cos(2 pi j / 100), for j and -j.
/// # let mut ring = sprs::TriMat::new((100, 100));
/// # for (i, j) in (0..100).map(|i| (i, (i + 1) % 100)) {
/// #     for (i, j, x) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
/// #         ring.add_triplet(i, j, x);
/// #     }
/// # }
/// # let (ring, mass) = (ring.to_csr::<usize>(), Mass::identity(100));
/// let mut values = vec![];
/// let options = EigenOptions::new().k(9);
/// eigs_sliced(ring.view(), &mass, &options, 1 << 30, |pairs| {
///     values.extend(pairs.values);
///     Ok(())
/// })?;
/// assert_eq!(values.len(), 9);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`eigs`](super::eigs()), those of `sink`, and [`Error::Argument`]: of "memory", too little
/// for any slice, for a cluster of eigenvalues, or for k pairs around a shift, which are never
/// sliced; of "tolerance", too strict for vectors that are made orthogonal to those of the slice
/// before.
pub fn eigs_sliced(
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
    memory: usize,
    sink: impl FnMut(Eigenpairs) -> Result<()>,
) -> Result<()> {
    options.progress.watch(|| find(stiffness, mass, options, memory, sink))
}

fn find(
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
    memory: usize,
    mut sink: impl FnMut(Eigenpairs) -> Result<()>,
) -> Result<()> {
    check(stiffness, mass, options)?;
    let (n, k) = (stiffness.rows(), options.k);
    if k == 0 {
        return Ok(());
    }
    let pencil = WholePencil { stiffness, mass };
    if let Some(pairs) = without_iteration(&pencil, stiffness, mass, options)? {
        return sink(pairs);
    }
    let problem = Problem::whole(&pencil)?;
    options.progress.report(PREPARED)?;
    let vectors = memory.saturating_sub(problem.bytes()) / (n * size_of::<f64>());
    let largest = vectors.saturating_sub(vectors_beside()) / 3;
    if k <= largest {
        return sink(one_window(&problem, options)?);
    }
    let refuse = |why| Err(Error::Argument { what: "memory", why });
    if options.shift.is_some() {
        return refuse(format!("{memory} bytes are too little for {k} pairs around a shift"));
    }
    if largest < LEAST {
        let least = problem.bytes() + (3 * LEAST + vectors_beside()) * n * size_of::<f64>();
        return refuse(format!("must be at least {least} bytes, is {memory}"));
    }
    let mut slices = Slices::new(&problem, options, largest);
    while slices.handed < k {
        let slice = slices.next()?;
        sink(slice)?;
    }
    options.progress.report(1.0)
}

/// Returns the number of vectors that a run takes beside three for each pair: of its basis, its
/// blocks, the certificate, and the guard.
fn vectors_beside() -> usize {
    basis_size(0) + 7 * WIDTH + GUARD
}

/// The slices found so far.
struct Slices<'a> {
    problem: &'a Problem<'a>,
    options: &'a EigenOptions<'a>,
    /// Most pairs that a run may look for.
    largest: usize,
    /// Pairs handed out, which are all below the cut.
    handed: usize,
    cut: f64,
    /// Mean distance of eigenvalues in the last slice.
    spacing: f64,
    /// The last vectors handed out.
    guard: Mat<f64>,
    /// Progress that earlier runs have taken.
    reported: f64,
}

/// How a run ended.
enum End {
    /// With all eigenvalues up to this cut, `count` of them.
    Slice { cut: f64, count: usize },
    /// Before it reached the last cut.
    Short,
    /// With eigenvalues that are not apart.
    Cluster,
}

impl<'a> Slices<'a> {
    fn new(problem: &'a Problem<'a>, options: &'a EigenOptions<'a>, largest: usize) -> Self {
        Self {
            problem,
            options,
            largest,
            handed: 0,
            cut: f64::NEG_INFINITY,
            spacing: 0.0,
            guard: Mat::new(),
            reported: PREPARED,
        }
    }

    /// Returns how many pairs are computed beyond a slice, to find its end among them.
    fn margin(&self) -> usize {
        (self.largest / 6).max(8)
    }

    /// Computes the next slice.
    fn next(&mut self) -> Result<Eigenpairs> {
        let rest = self.options.k - self.handed;
        let usable = self.largest - self.margin();
        let aim = rest.div_ceil(rest.div_ceil(usable));
        if self.handed == 0 {
            return self.first(aim);
        }
        let mut width = 0.5 * aim as f64 * self.spacing;
        let (mut shrunk, mut clustered) = (false, false);
        for _ in 0..ATTEMPTS {
            let sigma = self.cut + width;
            let factor = match self.problem.any(sigma) {
                Ok(factor) => factor,
                // This shift is an eigenvalue; a slightly different one is not.
                Err(Error::Argument { what: "shift", .. }) => {
                    width *= 0.97;
                    continue;
                }
                Err(error) => return Err(error),
            };
            let left = factor.below_zero().saturating_sub(self.handed);
            if 2 * left + self.margin() > self.largest {
                (width, shrunk) = (width * (0.45 * aim as f64 / left as f64).min(0.8), true);
                continue;
            }
            if 8 * left < aim && !shrunk {
                width *= 2.0;
                continue;
            }
            let size = (2 * left).max(aim) + self.margin();
            let size = if clustered { self.largest } else { size.min(self.largest) };
            match self.run(sigma, factor, left, size)? {
                (pairs, End::Slice { cut, count }) => return self.take(pairs, cut, count),
                (_, End::Cluster) if clustered => break,
                (_, End::Cluster) => clustered = true,
                (_, End::Short) => (width, shrunk) = (0.6 * width, true),
            }
        }
        self.too_large()
    }

    /// Computes the first slice, from below.
    fn first(&mut self, aim: usize) -> Result<Eigenpairs> {
        let sigma = -self.problem.scale;
        for size in [aim + self.margin(), self.largest] {
            let factor = self.problem.positive(sigma)?;
            let (pairs, end) = self.run(sigma, factor, 0, size)?;
            if let End::Slice { cut, count } = end {
                return self.take(pairs, cut, count);
            }
        }
        self.too_large()
    }

    /// Computes the pairs nearest to sigma, below which `left` eigenvalues have not been handed
    /// out. Returns them and how the run ended.
    fn run(
        &mut self,
        sigma: f64,
        factor: Box<dyn Inverse + '_>,
        left: usize,
        size: usize,
    ) -> Result<(Eigenpairs, End)> {
        let expected = (self.handed + size - self.margin()).min(self.options.k);
        let end = 0.99 * expected as f64 / self.options.k as f64;
        let start = self.reported;
        self.reported += RUN_SHARE * (end - start).max(0.0);
        let options = EigenOptions {
            k: size,
            // Stricter, so that residuals stay small enough when the guard is projected out.
            tolerance: (0.25 * self.options.tolerance).max(1e-14),
            progress: self.options.progress.part(start..self.reported),
            ..self.options.clone()
        };
        let mut end = End::Short;
        let pairs = self.problem.nearest(sigma, factor, &options, |values| {
            end = self.end(sigma, left, values);
            match end {
                End::Slice { cut, count } => Ok(self.problem.below(cut)? == self.handed + count),
                _ => Ok(self.reached(sigma, left, values)),
            }
        })?;
        Ok((pairs, end))
    }

    /// Returns whether no pair is missing on the left, except because too few were computed.
    fn reached(&self, sigma: f64, left: usize, values: &[f64]) -> bool {
        let radius = values.iter().map(|v| (v - sigma).abs()).fold(0.0, f64::max);
        radius < sigma - self.cut || self.between(sigma, values) >= left
    }

    /// Returns the number of values from the cut to sigma.
    fn between(&self, sigma: f64, values: &[f64]) -> usize {
        values.iter().filter(|v| (self.cut..sigma).contains(v)).count()
    }

    /// Returns where a slice with these values of a run can end, judging by the values alone.
    fn end(&self, sigma: f64, left: usize, values: &[f64]) -> End {
        if self.between(sigma, values) != left {
            return End::Short;
        }
        let mut above: Vec<f64> = values.iter().copied().filter(|v| *v > self.cut).collect();
        above.sort_by(f64::total_cmp);
        let len = above.len();
        let widest = |from: usize| {
            let gap = |i: &usize| above[*i] - above[*i - 1];
            let gaps =
                (from.max(1)..len).filter(|&i| apart(above[i - 1], above[i], self.problem.scale));
            gaps.max_by(|i, j| gap(i).total_cmp(&gap(j)))
        };
        let rest = self.options.k - self.handed;
        let late = len.saturating_sub(self.margin());
        match widest(rest).or_else(|| widest(late)).or_else(|| widest(1)) {
            Some(count) => End::Slice { cut: 0.5 * (above[count - 1] + above[count]), count },
            None => End::Cluster,
        }
    }

    /// Selects the wanted pairs of a run, and makes them orthogonal to those handed out last.
    fn take(&mut self, pairs: Eigenpairs, cut: f64, count: usize) -> Result<Eigenpairs> {
        let Problem { pencil, scale, .. } = *self.problem;
        let skip = pairs.values.partition_point(|v| *v <= self.cut);
        let wanted = count.min(self.options.k - self.handed);
        let values = pairs.values[skip..skip + wanted].to_vec();
        let n = pairs.vectors.nrows();
        let mut vectors = zeros(n, wanted)?;
        vectors.copy_from(pairs.vectors.subcols(skip, wanted));
        let solves = pairs.solves;
        drop(pairs.vectors);
        self.leave_guard(&mut vectors)?;
        let (roundings, vectors_found) = (4.0 * ROUNDINGS, vectors.as_ref());
        let found = certify(pencil, &values, vectors_found, scale, roundings, self.options)?;
        if found.excess > 1.0 {
            let (tolerance, largest) = (self.options.tolerance, found.largest);
            let why = format!(
                "{tolerance:e} is too strict: a slice has residuals of {largest:e} once it is \
                 orthogonal to the one before"
            );
            return Err(Error::Argument { what: "tolerance", why });
        }
        let first = if self.handed == 0 { values[0] } else { self.cut };
        self.spacing = (cut - first) / count as f64;
        let kept = GUARD.min(wanted);
        self.guard = zeros(n, kept)?;
        self.guard.copy_from(vectors.subcols(wanted - kept, kept));
        (self.handed, self.cut) = (self.handed + wanted, cut);
        Ok(Eigenpairs { values, vectors, residuals: found.residuals, solves })
    }

    /// Removes the projection onto the guard from vectors, a few at a time.
    fn leave_guard(&self, vectors: &mut Mat<f64>) -> Result<()> {
        let par = self.options.par;
        let guard: MatRef<'_, f64> = self.guard.as_ref();
        if guard.ncols() == 0 {
            return Ok(());
        }
        let mut weighted = zeros(vectors.nrows(), WIDTH)?;
        for first in (0..vectors.ncols()).step_by(WIDTH) {
            let width = WIDTH.min(vectors.ncols() - first);
            let mut x = vectors.as_mut().subcols_mut(first, width);
            let mut mx = weighted.as_mut().subcols_mut(0, width);
            self.problem.pencil.inner().apply_mass(x.rb(), mx.rb_mut(), par)?;
            let overlap = transposed_product(guard, mx.rb(), par)?;
            subtract_product(x.rb_mut(), guard, overlap.as_ref(), par)?;
        }
        Ok(())
    }

    fn too_large(&self) -> Result<Eigenpairs> {
        let (largest, handed) = (self.largest, self.handed);
        let why = format!(
            "too little for a cluster of eigenvalues after the first {handed}: a slice has at most \
             {largest} pairs"
        );
        Err(Error::Argument { what: "memory", why })
    }
}
