//! Block Lanczos with thick restart for `(W - sigma M)^-1 M`, in the inner product of M.

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{ColMut, Mat, MatRef, unzip, zip};

use super::options::EigenOptions;
use super::space::{Inverse, Pencil};
use crate::base::{Error, Par, Result, Rng, spend};
use crate::dense::{
    ROW_BLOCK, SymmetricEigen, copy, filled, for_row_blocks, multiply_in_place, subtract_product,
    symmetric_eigen, transposed_product, zeros,
};

/// Columns of a block: a fast width for solves; finds multiplicities up to this number at once.
pub(crate) const WIDTH: usize = 8;

/// Returns the number of vectors of the basis, without the last block.
pub(crate) fn basis_size(k: usize) -> usize {
    (2 * k + 9 * WIDTH).next_multiple_of(WIDTH)
}

/// What a few steps tell about the eigenvalues near a shift.
pub(crate) struct Nearby {
    /// Distance of sigma from the nearest one.
    pub clearance: f64,
    /// Distances of 16 or more from the shift, ascending.
    pub from_shift: Vec<f64>,
}

/// To which columns of the basis a new block is made orthogonal.
///
/// A block that is orthogonal to its neighbours is so to all others up to rounding, times the
/// factor by which it was shorter than the operator's values. That does not harm T (Simon 1984),
/// but grows from block to block, so that every second block is cleaned together with the one
/// before it (Grcar 1981): the basis is read half as often.
#[derive(Clone, Copy)]
enum Reach {
    /// To all.
    All,
    /// To those from this one on: the block lags.
    Near(usize),
    /// To all; and the block before it, which lags, to those before that.
    Both,
}

/// A Krylov space, of which each process has the rows given by the pencil: a basis V, `V^T M V =
/// I`, of which the first `len` columns satisfy `(W - sigma M)^-1 M V = V T + Q (B 0 .. 0 I)`, with
/// the block Q of the next `WIDTH` columns.
pub(crate) struct Krylov<'a> {
    pencil: &'a dyn Pencil,
    options: &'a EigenOptions<'a>,
    sigma: f64,
    /// Sigma minus the shift that the wanted eigenvalues are nearest to.
    offset: f64,
    scale: f64,
    /// Typical length of M phi.
    mass_norm: f64,
    /// V, then Q, then unused columns.
    basis: Mat<f64>,
    len: usize,
    /// T, and below it the coupling of Q to the columns from `coupled` on.
    projected: Mat<f64>,
    coupled: usize,
    /// M Q, then a work block.
    weighted: Mat<f64>,
    /// Whether Q was made orthogonal to its neighbours only.
    lagging: bool,
    /// Columns by which [`Krylov::probe`] has expanded V.
    probed: usize,
    /// A work block.
    work: Mat<f64>,
    rng: Rng,
    solves: usize,
    restarts: usize,
    /// Estimated residuals must be smaller than the tolerance by this factor.
    caution: f64,
    /// Eigenvalues of the first columns of the basis, the wanted ones first, once converged.
    found: Vec<f64>,
    reported: f64,
}

impl<'a> Krylov<'a> {
    /// Creates an empty space. The other functions take the factor of `W - sigma M`.
    pub fn new(
        pencil: &'a dyn Pencil,
        sigma: f64,
        scale: f64,
        mass_norm: f64,
        options: &'a EigenOptions<'a>,
    ) -> Result<Self> {
        let (n, size) = (pencil.inner().rows().len(), basis_size(options.k) + WIDTH);
        // The memory of the basis is cleared.
        spend(n as f64 * size as f64)?;
        Ok(Self {
            pencil,
            options,
            sigma,
            offset: options.shift.map_or(0.0, |shift| sigma - shift),
            scale,
            mass_norm,
            basis: zeros(n, size)?,
            len: 0,
            projected: zeros(size, size)?,
            coupled: 0,
            weighted: zeros(n, 2 * WIDTH)?,
            lagging: false,
            probed: 0,
            work: zeros(n, WIDTH)?,
            rng: Rng::new(options.seed),
            solves: 0,
            restarts: 0,
            caution: 0.5,
            found: vec![],
            reported: 0.02,
        })
    }

    /// Starts from null vectors that are 1 on these sets of rows, as many as are wanted, and random
    /// directions.
    pub fn lock(&mut self, factor: &dyn Inverse, sets: &[Vec<usize>]) -> Result<()> {
        let space = self.pencil.inner();
        let here = space.rows();
        for rows in sets.iter().take(self.options.k) {
            // Row numbers ascend.
            let own =
                rows.partition_point(|&i| i < here.start)..rows.partition_point(|&i| i < here.end);
            let own = || rows[own.clone()].iter().map(|&i| i - here.start);
            let mut column = self.basis.as_mut().col_mut(self.len);
            own().for_each(|i| column[i] = 1.0);
            let mut product = Mat::zeros(here.len(), 1);
            space.apply_mass(column.rb().as_mat(), product.as_mut(), self.options.par)?;
            let mut square = Mat::from_fn(1, 1, |_, _| own().map(|i| product[(i, 0)]).sum());
            space.sum(square.as_mut())?;
            let norm = square[(0, 0)].sqrt();
            own().for_each(|i| column[i] = 1.0 / norm);
            self.projected[(self.len, self.len)] = -1.0 / self.sigma;
            self.len += 1;
        }
        self.random_restart(factor)
    }

    /// Replaces Q by random directions to which the operator has been applied once, and which
    /// couple to nothing.
    fn random_restart(&mut self, factor: &dyn Inverse) -> Result<()> {
        let mut random = self.weighted.as_mut().subcols_mut(WIDTH, WIDTH);
        for column in random.rb_mut().col_iter_mut() {
            spend(4.0 * self.pencil.inner().dimension() as f64)?;
            randomize(column, self.pencil, &mut self.rng, self.mass_norm);
        }
        let (x, par) = (&mut self.work, self.options.par);
        self.pencil.inner().apply_mass(random.rb(), x.as_mut(), par)?;
        factor.solve(x.as_mut(), par)?;
        self.solves += WIDTH;
        self.orthonormalize(self.len, 0.0, None, Reach::All)?;
        self.coupled = self.len;
        self.append()
    }

    /// Puts the work block into the basis as Q.
    fn append(&mut self) -> Result<()> {
        let (x, par) = (self.work.as_ref(), self.options.par);
        copy(self.basis.as_mut().subcols_mut(self.len, WIDTH), x, par);
        let weighted = self.weighted.as_mut().subcols_mut(0, WIDTH);
        self.pencil.inner().apply_mass(x, weighted, par)
    }

    /// Adds Q to V, and finds the next Q; it `may_lag` behind in orthogonality where another
    /// expansion follows before anything else is asked of the space.
    fn expand(&mut self, factor: &dyn Inverse, may_lag: bool) -> Result<()> {
        let (len, coupled, par) = (self.len, self.coupled, self.options.par);
        let x = &mut self.work;
        let weighted = self.weighted.as_ref().subcols(0, WIDTH);
        copy(x.as_mut(), weighted, par);
        factor.solve(x.as_mut(), par)?;
        self.solves += WIDTH;
        let diagonal = inner_products(self.pencil, weighted, x.as_ref(), par)?;
        self.projected.as_mut().submatrix_mut(len, len, WIDTH, WIDTH).copy_from(&diagonal);
        // The components along Q and its neighbours.
        let near = self.basis.as_ref().subcols(coupled, len + WIDTH - coupled);
        let mut coefficients = Mat::zeros(near.ncols(), WIDTH);
        let (mut above, mut own) = coefficients.as_mut().split_at_row_mut(len - coupled);
        above.copy_from(
            self.projected.as_ref().submatrix(len, coupled, WIDTH, len - coupled).transpose(),
        );
        own.copy_from(&diagonal);
        let reference = coefficients.norm_l2();
        subtract_product(x.as_mut(), near, coefficients.as_ref(), par)?;
        let reach = match (self.lagging, may_lag && coupled > 0) {
            (true, _) => Reach::Both,
            (false, true) => Reach::Near(coupled),
            (false, false) => Reach::All,
        };
        let coupling = self.orthonormalize(len + WIDTH, reference, Some(len), reach)?;
        let mut own = self.projected.as_mut().submatrix_mut(len, len, WIDTH, WIDTH);
        for j in 0..WIDTH {
            for i in 0..j {
                let mean = 0.5 * (own[(i, j)] + own[(j, i)]);
                (own[(i, j)], own[(j, i)]) = (mean, mean);
            }
        }
        self.len += WIDTH;
        self.coupled = len;
        self.projected.as_mut().submatrix_mut(len + WIDTH, len, WIDTH, WIDTH).copy_from(&coupling);
        self.append()
    }

    /// Makes the work block X orthonormal and orthogonal to the first `count` columns of the basis,
    /// as far as `reach` says, and returns B with `X before = X after B + (columns of the basis)`.
    /// Columns that are below rounding, for the length `reference`, are replaced by random
    /// directions, with zeros in B. Components along the block at `own` are added to T.
    fn orthonormalize(
        &mut self,
        count: usize,
        reference: f64,
        own: Option<usize>,
        mut reach: Reach,
    ) -> Result<Mat<f64>> {
        /// Length, relative to the reference, below which a column is only rounding.
        const ROUNDING: f64 = 1e-14;
        /// Length, relative to the reference, below which a block may not lag: the rounding of the
        /// operator, relative to the reference, is larger in a normalized column by its inverse.
        const LAGGING: f64 = 1e-3;
        /// Each pass normalizes columns that are shorter than the longest by up to this factor.
        const RANGE: f64 = 1e-8;
        /// A normalized column that projection makes shorter than this lay in the span of the
        /// others.
        const SHRUNK: f64 = 1e-3;
        const PASSES: usize = 12;
        let (pencil, par) = (self.pencil, self.options.par);
        let mut coupling = Mat::<f64>::identity(WIDTH, WIDTH);
        for pass in 0..PASSES {
            if pass > 0 && count > 0 {
                let overlap = self.project(count, if pass == 1 { reach } else { Reach::All })?;
                if let Some(own) = own {
                    // The block at `own` is the last one.
                    let of_own = overlap.as_ref().subrows(overlap.nrows() - WIDTH, WIDTH);
                    let found = of_own * &coupling;
                    let mut t = self.projected.as_mut().submatrix_mut(own, own, WIDTH, WIDTH);
                    t += &found;
                }
            }
            let x = &mut self.work;
            let mut mx = self.weighted.as_mut().subcols_mut(WIDTH, WIDTH);
            pencil.inner().apply_mass(x.as_ref(), mx.rb_mut(), par)?;
            let gram = inner_products(pencil, x.as_ref(), mx.rb(), par)?;
            let SymmetricEigen { values, vectors } =
                symmetric_eigen(gram.as_ref()).map_err(|error| failed(error, self.restarts))?;
            let longest = values[WIDTH - 1].max(0.0).sqrt();
            let lengths: Vec<f64> =
                values.iter().map(|v| v.max(0.0).sqrt().max(RANGE * longest)).collect();
            if pass == 0 && matches!(reach, Reach::Near(_)) && lengths[0] < LAGGING * reference {
                reach = Reach::All;
            }
            let turned = |i: usize| (0..WIDTH).map(move |j| (i, j));
            let mut next = vectors.transpose() * &coupling;
            for (i, length) in lengths.iter().enumerate() {
                turned(i).for_each(|p| next[p] *= length);
            }
            let unit = Mat::from_fn(WIDTH, WIDTH, |i, j| {
                vectors[(i, j)] / lengths[j].max(f64::MIN_POSITIVE)
            });
            multiply_in_place(x.as_mut(), unit.as_ref(), par)?;
            let mut replaced = false;
            for i in 0..WIDTH {
                let length = turned(i).map(|p| next[p] * next[p]).sum::<f64>().sqrt();
                if length <= ROUNDING * reference && (pass == 0 || lengths[i] < SHRUNK) {
                    turned(i).for_each(|p| next[p] = 0.0);
                    randomize(x.as_mut().col_mut(i), pencil, &mut self.rng, self.mass_norm);
                    replaced = true;
                }
            }
            coupling = next;
            let steady = lengths.iter().all(|length| (0.5..2.0).contains(length));
            if pass > 0 && steady && !replaced {
                self.lagging = pass == 1 && matches!(reach, Reach::Near(_));
                return Ok(coupling);
            }
        }
        Err(not_finite(self.restarts))
    }

    /// Takes from the work block X its components along the first `count` columns of the basis, as
    /// far as `reach` says; returns those along the last of these columns, a block or more.
    fn project(&mut self, count: usize, reach: Reach) -> Result<Mat<f64>> {
        let (pencil, par) = (self.pencil, self.options.par);
        let (x, weighted) = (&mut self.work, &mut self.weighted);
        let weigh = |weighted: &mut Mat<f64>, x: &Mat<f64>| {
            let mx = weighted.as_mut().subcols_mut(WIDTH, WIDTH);
            pencil.inner().apply_mass(x.as_ref(), mx, par)
        };
        weigh(weighted, x)?;
        let mut first = 0;
        match reach {
            Reach::All => {}
            Reach::Near(from) => first = from,
            Reach::Both => {
                // Q and X side by side, so that V is read once for both.
                first = count - WIDTH;
                let (v, mut rest) = self.basis.as_mut().split_at_col_mut(first);
                copy(rest.rb_mut().subcols_mut(WIDTH, WIDTH), x.as_ref(), par);
                let mut both = rest.rb_mut().subcols_mut(0, 2 * WIDTH);
                let found = inner_products(pencil, v.rb(), weighted.as_ref(), par)?;
                subtract_product(both.rb_mut(), v.rb(), found.as_ref(), par)?;
                copy(x.as_mut(), both.rb().subcols(WIDTH, WIDTH), par);
                weigh(weighted, x)?;
            }
        }
        let basis = self.basis.as_ref().subcols(first, count - first);
        let mx = weighted.as_ref().subcols(WIDTH, WIDTH);
        let found = inner_products(pencil, basis, mx, par)?;
        subtract_product(x.as_mut(), basis, found.as_ref(), par)?;
        Ok(found)
    }

    /// Does the first two expansions of [`Krylov::converge`], which tell about how far the
    /// eigenvalues near sigma are from it and from the shift.
    pub fn probe(&mut self, factor: &dyn Inverse) -> Result<Nearby> {
        let first = self.len;
        self.expand(factor, true)?;
        self.expand(factor, false)?;
        self.probed = self.len - first;
        let values = self.ritz()?.values;
        let largest = values.iter().fold(0.0, |most: f64, theta| most.max(theta.abs()));
        let mut from_shift: Vec<f64> =
            values.iter().map(|theta| self.distance_to_shift(*theta)).collect();
        from_shift.sort_by(f64::total_cmp);
        Ok(Nearby { clearance: 1.0 / largest, from_shift })
    }

    /// Expands and restarts until the estimated residuals of the wanted pairs are small enough; the
    /// first columns of the basis are their vectors then.
    pub fn converge(&mut self, factor: &dyn Inverse) -> Result<()> {
        let k = self.options.k;
        if self.len >= k && self.found.is_empty() && self.options.shift.is_none() {
            // Null vectors are all that is wanted.
            self.found = vec![0.0; k];
            return Ok(());
        }
        let size = basis_size(k);
        let mut is_expanded = self.probed > 0;
        let first = self.len - std::mem::take(&mut self.probed);
        let mut next = (k + k / 2 + 2 * WIDTH).max(first + 2 * WIDTH).min(size);
        loop {
            if !std::mem::take(&mut is_expanded) {
                // Whether the next round expands, too.
                let after = self.len + WIDTH;
                self.expand(factor, after < next && after + WIDTH <= size)?;
            }
            let full = self.len + WIDTH > size;
            if self.len < next && !full {
                self.report(0)?;
                continue;
            }
            next = self.len + (k / 6).max(2 * WIDTH);
            let ritz = self.ritz()?;
            // Most pairs that a restart keeps.
            let most = (k + (self.len - k) / 2).min(self.len - 2 * WIDTH);
            let room = if full { most } else { usize::MAX };
            let (mut order, wanted) = self.ranked(&ritz, room);
            let residuals = self.estimates(&ritz, &order[..wanted.min(most)])?;
            let bound = self.options.tolerance * self.caution;
            let good = residuals.iter().filter(|r| **r <= bound).count();
            self.report(good.min(k))?;
            if good == wanted {
                order.truncate(wanted);
                let from_shift = |i: usize| self.distance_to_shift(ritz.values[i]);
                order.sort_by(|&a, &b| from_shift(a).total_cmp(&from_shift(b)));
                self.restart(&ritz, &order)?;
                self.found = self.eigenvalues(&ritz, &order[..k]);
                return Ok(());
            }
            if full {
                if self.restarts == self.options.max_restarts {
                    let residual = residuals.into_iter().fold(0.0, f64::max);
                    return Err(Error::NotConverged { iterations: self.restarts, residual });
                }
                self.restart(&ritz, &order[..most])?;
                self.restarts += 1;
            }
        }
    }

    /// Computes the eigenpairs of T.
    fn ritz(&self) -> Result<SymmetricEigen> {
        let t = self.projected.as_ref().submatrix(0, 0, self.len, self.len);
        symmetric_eigen(t).map_err(|error| failed(error, self.restarts))
    }

    /// Returns the distance from the shift of the eigenvalue for a Ritz value.
    fn distance_to_shift(&self, theta: f64) -> f64 {
        (self.offset + 1.0 / theta).abs()
    }

    /// Returns the Ritz values in the order of their distances from sigma, and how many of them
    /// must converge: k, or, where sigma is beside the shift, all that are no farther from sigma
    /// than an eigenvalue may be that is as near to the shift as the k nearest. If there is no
    /// `room` for these, those that are among the k nearest to the shift, and those between sigma
    /// and the shift. Ritz values that need not converge come after those that must.
    ///
    /// The second set is complete as the first one is. Lanczos finds the inverse distances `theta`
    /// of either sign from the largest one on, so what is needed is that the set has, of each sign,
    /// the first ones. Let sigma be below the shift, by o. An eigenvalue x above the shift (below,
    /// if x is negative) has `1 / theta = x + o`. Those within f of the shift have `-f + o <= 1 /
    /// theta <= f + o`. If `f >= o`, these are the first ones of either sign. If `f < o`, none is
    /// negative, and of the positive ones those with `1 / theta < o - f` come first, which lie
    /// between sigma and the shift. Above the shift it is the same with other signs. The first set
    /// has as many more on the other side of sigma as lie within `2 o` beyond f, which for a
    /// cluster of eigenvalues may be any number.
    fn ranked(&self, ritz: &SymmetricEigen, room: usize) -> (Vec<usize>, usize) {
        /// Rounding of the distances, relative to them.
        const ROUNDING: f64 = 1e-9;
        let k = self.options.k;
        let mut order: Vec<usize> = (0..self.len).collect();
        order.sort_by(|&a, &b| ritz.values[b].abs().total_cmp(&ritz.values[a].abs()));
        if self.offset == 0.0 {
            return (order, k);
        }
        let mut from_shift: Vec<f64> =
            ritz.values.iter().map(|theta| self.distance_to_shift(*theta)).collect();
        from_shift.sort_by(f64::total_cmp);
        let (farthest, offset) = (from_shift[k - 1], self.offset.abs());
        let margin = ROUNDING * (farthest + offset);
        let reach = farthest + offset + margin;
        // Of those as far from the shift as the farthest, which may be more than the basis has room
        // for, some are enough.
        let nearer = from_shift.iter().filter(|distance| **distance < farthest - margin).count();
        let first = |must: &dyn Fn(f64) -> bool| {
            let mut missing = k - nearer;
            let (mut wanted, others): (Vec<usize>, Vec<usize>) = order.iter().partition(|&&i| {
                let theta = ritz.values[i];
                let is_farthest = (self.distance_to_shift(theta) - farthest).abs() <= margin;
                let is_wanted = must(theta) && (!is_farthest || missing > 0);
                missing -= usize::from(is_farthest && is_wanted);
                is_wanted
            });
            let count = wanted.len().max(k);
            wanted.extend(others);
            (wanted, count)
        };
        let found = first(&|theta| 1.0 / theta.abs() <= reach);
        if found.1 <= room {
            return found;
        }
        first(&|theta| {
            let is_between = self.offset / theta < 0.0 && 1.0 / theta.abs() <= offset;
            is_between || self.distance_to_shift(theta) <= farthest + margin
        })
    }

    /// Returns the eigenvalues of the pencil for these Ritz values.
    fn eigenvalues(&self, ritz: &SymmetricEigen, order: &[usize]) -> Vec<f64> {
        order.iter().map(|&i| self.sigma + 1.0 / ritz.values[i]).collect()
    }

    /// Estimates residuals, as [`super::Eigenpairs::residuals`] defines them, without forming the
    /// vectors: `(W - lambda M) phi = -(W - sigma M) Q B s / theta`.
    fn estimates(&mut self, ritz: &SymmetricEigen, order: &[usize]) -> Result<Vec<f64>> {
        let par = self.options.par;
        let w = &mut self.work;
        let last = self.basis.as_ref().subcols(self.len, WIDTH);
        self.pencil.apply_stiffness(last, w.as_mut(), par)?;
        for j in 0..WIDTH {
            for i in 0..w.nrows() {
                w[(i, j)] -= self.sigma * self.weighted[(i, j)];
            }
        }
        let gram = inner_products(self.pencil, w.as_ref(), w.as_ref(), par)?;
        let coupling = self.coupling();
        let last = ritz.vectors.as_ref().subrows(self.coupled, self.len - self.coupled);
        let estimate = |(&i, lambda): (&usize, f64)| {
            let e = coupling * last.col(i);
            let square = e.transpose() * &gram * &e;
            let length = lambda.abs().max(self.scale) * self.mass_norm;
            square.max(0.0).sqrt() / (ritz.values[i].abs() * length)
        };
        Ok(order.iter().zip(self.eigenvalues(ritz, order)).map(estimate).collect())
    }

    /// Returns B: the coupling of Q to the columns of V from `coupled` on.
    fn coupling(&self) -> MatRef<'_, f64> {
        let (len, coupled) = (self.len, self.coupled);
        self.projected.as_ref().submatrix(len, coupled, WIDTH, len - coupled)
    }

    /// Keeps these Ritz vectors, and Q, and discards the rest of the basis.
    fn restart(&mut self, ritz: &SymmetricEigen, order: &[usize]) -> Result<()> {
        let (len, keep) = (self.len, order.len());
        let turn = filled(len, keep, |i, j| ritz.vectors[(i, order[j])])?;
        let coupling = self.coupling() * turn.as_ref().subrows(self.coupled, len - self.coupled);
        let basis = self.basis.as_mut().subcols_mut(0, len);
        multiply_in_place(basis, turn.as_ref(), self.options.par)?;
        let (mut kept, rest) = self.basis.as_mut().split_at_col_mut(len);
        kept.rb_mut().subcols_mut(keep, WIDTH).copy_from(rest.subcols(0, WIDTH));
        self.projected.fill(0.0);
        order.iter().enumerate().for_each(|(j, &i)| self.projected[(j, j)] = ritz.values[i]);
        self.projected.as_mut().submatrix_mut(keep, 0, WIDTH, keep).copy_from(&coupling);
        (self.len, self.coupled) = (keep, 0);
        Ok(())
    }

    /// Applies the operator once to the vectors that [`Krylov::converge`] found (Ericsson and Ruhe
    /// 1980). This removes rounding errors in entries of little mass, which are large in W.
    pub fn purify(&mut self, factor: &dyn Inverse) -> Result<()> {
        let par = self.options.par;
        for first in (0..self.found.len()).step_by(WIDTH) {
            let width = WIDTH.min(self.found.len() - first);
            let mut x = self.work.as_mut().subcols_mut(0, width);
            let vectors = self.basis.as_mut().subcols_mut(first, width);
            self.pencil.inner().apply_mass(vectors.rb(), x.rb_mut(), par)?;
            factor.solve(x.rb_mut(), par)?;
            let (x, found, sigma) = (x.rb(), &self.found[first..], self.sigma);
            for_row_blocks(vectors, ROW_BLOCK, par, |first, block| {
                let x = x.subrows(first, block.nrows());
                for (j, column) in block.col_iter_mut().enumerate() {
                    let back = found[j] - sigma;
                    zip!(column, x.col(j)).for_each(|unzip!(v, x)| *v = back * x);
                }
            });
            self.solves += width;
        }
        Ok(())
    }

    /// Asks for residuals that are smaller by this factor, after [`Krylov::converge`].
    pub fn tighten(&mut self, factor: f64) {
        self.caution *= factor;
    }

    /// Continues from the pairs that [`Krylov::converge`] found and from random directions, to find
    /// pairs that have no component in these pairs or in any earlier direction.
    pub fn add_directions(&mut self, factor: &dyn Inverse) -> Result<()> {
        self.projected.as_mut().subrows_mut(self.len, WIDTH).fill(0.0);
        self.random_restart(factor)
    }

    /// Returns the eigenvalues that [`Krylov::converge`] found, the nearest to the shift first.
    pub fn values(&self) -> &[f64] {
        &self.found
    }

    /// Returns the eigenvectors that [`Krylov::converge`] found.
    pub fn vectors(&self) -> MatRef<'_, f64> {
        self.basis.as_ref().subcols(0, self.found.len())
    }

    /// Returns the number of vectors that the operator was applied to.
    pub fn solves(&self) -> usize {
        self.solves
    }

    /// Returns the number of restarts.
    pub fn restarts(&self) -> usize {
        self.restarts
    }

    /// Reports progress, with this many pairs converged.
    fn report(&mut self, good: usize) -> Result<()> {
        let (k, size) = (self.options.k as f64, basis_size(self.options.k) as f64);
        let filled = if self.restarts == 0 { 0.4 * self.len as f64 / size } else { 0.4 };
        self.reported = self.reported.max(0.02 + filled + 0.5 * good as f64 / k);
        self.options.progress.report(self.reported)
    }
}

/// Computes `X^T Y`, over the rows of all processes.
fn inner_products(
    pencil: &dyn Pencil,
    x: MatRef<'_, f64>,
    y: MatRef<'_, f64>,
    par: Par,
) -> Result<Mat<f64>> {
    let mut products = transposed_product(x, y, par)?;
    pencil.inner().sum(products.as_mut())?;
    Ok(products)
}

/// Fills a column with a random direction, of length about 1 in the inner product.
fn randomize(mut column: ColMut<'_, f64>, pencil: &dyn Pencil, rng: &mut Rng, mass_norm: f64) {
    let (n, here) = (pencil.inner().dimension(), pencil.inner().rows());
    let size = 12f64.sqrt() / ((n as f64).sqrt() * mass_norm);
    // Every process draws all entries, so that they do not depend on the distribution of rows.
    for i in 0..n {
        let entry = (rng.uniform() - 0.5) * size;
        if here.contains(&i) {
            column[i - here.start] = entry;
        }
    }
}

/// Returns the error of a small eigenproblem: a request to stop, too little memory, or numbers that
/// have overflowed.
fn failed(error: Error, iterations: usize) -> Error {
    match error {
        Error::Cancelled | Error::OutOfMemory { .. } => error,
        _ => not_finite(iterations),
    }
}

/// Returns the error for numbers that have overflowed.
fn not_finite(iterations: usize) -> Error {
    Error::NotConverged { iterations, residual: f64::INFINITY }
}
