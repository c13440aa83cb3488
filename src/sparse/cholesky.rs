//! faer's sparse Cholesky factorisations of `W - sigma M`, with memory that may be refused.

use std::ops::ControlFlow;
use std::sync::Mutex;

use faer::MatMut;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::SupernodalIntranodeLbltRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, IntranodeLbltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw,
    SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

use super::shifted::Shifted;
use crate::base::{Error, Par, Result, tickets, zeros};
use crate::dense::buffer;

/// Columns of the right-hand side that are solved for together, whatever the number of threads.
const COLUMNS: usize = 4;

/// The order of elimination (approximate minimum degree) and the places of the factor, the same for every shift.
#[derive(Debug)]
pub(crate) struct Symbolic(SymbolicCholesky<usize>);

impl Symbolic {
    /// For matrices with these places in the lower triangle; what is above is not looked at.
    pub fn new(places: SymbolicSparseColMatRef<'_, usize>) -> Result<Self> {
        let parameters = CholeskySymbolicParams {
            // Supernodes solve for blocks of right-hand sides, and allow for pivots.
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        factorize_symbolic_cholesky(places, faer::Side::Lower, SymmetricOrdering::Amd, parameters)
            .map(Self)
            .map_err(|_| Error::OutOfMemory { bytes: size_of_val(places.row_idx()) })
    }

    /// Entries of the factor.
    pub fn entries(&self) -> usize {
        self.0.len_val()
    }

    /// The values of L in `A = L L^T`, on the calling thread; `Ok(None)` when A is not positive definite.
    pub fn positive(&self, a: SparseColMatRef<'_, usize, f64>) -> Result<Option<Vec<f64>>> {
        let mut values = zeros(self.entries())?;
        let requirement =
            self.0.factorize_numeric_llt_scratch::<f64>(faer::Par::Seq, Default::default());
        let mut memory = buffer(requirement)?;
        let done = self.0.factorize_numeric_llt(
            &mut values,
            a,
            faer::Side::Lower,
            Default::default(),
            faer::Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        Ok(done.is_ok().then_some(values))
    }

    /// `x := (L L^T)^-1 x`, on the calling thread.
    pub fn solve_positive(&self, values: &[f64], x: &mut [f64]) -> Result<()> {
        let n = x.len();
        let mut memory = buffer(self.0.solve_in_place_scratch::<f64>(1, faer::Par::Seq))?;
        LltRef::new(&self.0, values).solve_in_place_with_conj(
            faer::Conj::No,
            MatMut::from_column_major_slice_mut(x, n, 1),
            faer::Par::Seq,
            MemStack::new(&mut memory),
        );
        Ok(())
    }
}

/// A factorisation of `W - sigma M`.
pub(crate) struct Factor<'s> {
    symbolic: &'s Symbolic,
    values: Vec<f64>,
    pivots: Option<Pivots>,
}

/// Of an indefinite factorisation: the part of B below its diagonal, and the order of rows inside supernodes.
struct Pivots {
    subdiagonal: Vec<f64>,
    forward: Vec<usize>,
    inverse: Vec<usize>,
}

impl<'s> Factor<'s> {
    /// `L L^T`, on the calling thread; `Ok(None)` when the matrix is not positive definite.
    pub fn positive(
        symbolic: &'s Symbolic,
        shifted: &Shifted<'_>,
        sigma: f64,
    ) -> Result<Option<Self>> {
        let entries = shifted.values(sigma);
        let values = symbolic.positive(shifted.matrix(&entries))?;
        Ok(values.map(|values| Self { symbolic, values, pivots: None }))
    }

    /// `L B L^T`, B of blocks of one or two rows, pivoted inside supernodes, on the calling thread.
    pub fn indefinite(symbolic: &'s Symbolic, shifted: &Shifted<'_>, sigma: f64) -> Result<Self> {
        let n = shifted.len();
        let (mut values, entries) = (zeros(symbolic.entries())?, shifted.values(sigma));
        let mut pivots =
            Pivots { subdiagonal: vec![0.0; n], forward: vec![0; n], inverse: vec![0; n] };
        let requirement = symbolic
            .0
            .factorize_numeric_intranode_lblt_scratch::<f64>(faer::Par::Seq, Default::default());
        let mut memory = buffer(requirement)?;
        symbolic.0.factorize_numeric_intranode_lblt(
            &mut values,
            &mut pivots.subdiagonal,
            &mut pivots.forward,
            &mut pivots.inverse,
            shifted.matrix(&entries),
            faer::Side::Lower,
            faer::Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        Ok(Self { symbolic, values, pivots: Some(pivots) })
    }

    /// `X := (W - sigma M)^-1 X`, in blocks of columns of a fixed width: the same for every `par`, bit for bit.
    pub fn solve(&self, x: MatMut<'_, f64>, par: Par) -> Result<()> {
        let requirement = self.symbolic.0.solve_in_place_scratch::<f64>(COLUMNS, faer::Par::Seq);
        let mut blocks = Vec::new();
        let mut rest = x;
        while rest.ncols() > 0 {
            let width = COLUMNS.min(rest.ncols());
            let (head, tail) = rest.split_at_col_mut(width);
            blocks.push(Mutex::new(Some(head)));
            rest = tail;
        }
        let workers = par.at_most(blocks.len()).threads();
        let mut memory = (0..workers).map(|_| buffer(requirement)).collect::<Result<Vec<_>>>()?;
        tickets(&mut memory, blocks.len(), |memory, i| {
            let block = blocks[i].lock().expect("one block, one lock").take();
            self.solve_block(block.expect("each block is handed out once"), memory);
            ControlFlow::Continue(())
        });
        Ok(())
    }

    fn solve_block(&self, x: MatMut<'_, f64>, memory: &mut MemBuffer) {
        let stack = MemStack::new(memory);
        match &self.pivots {
            None => LltRef::new(&self.symbolic.0, &self.values).solve_in_place_with_conj(
                faer::Conj::No,
                x,
                faer::Par::Seq,
                stack,
            ),
            Some(Pivots { subdiagonal, forward, inverse }) => {
                let order = PermRef::new_checked(forward, inverse, forward.len());
                IntranodeLbltRef::new(&self.symbolic.0, &self.values, subdiagonal, order)
                    .solve_in_place_with_conj(faer::Conj::No, x, faer::Par::Seq, stack);
            }
        }
    }

    /// Eigenvalues of `W phi = lambda M phi` below the shift, by Sylvester's law of inertia: negative eigenvalues of B.
    pub fn below_shift(&self) -> usize {
        let (Some(Pivots { subdiagonal, forward, inverse }), SymbolicCholeskyRaw::Supernodal(raw)) =
            (&self.pivots, self.symbolic.0.raw())
        else {
            return 0;
        };
        let order = PermRef::new_checked(forward, inverse, forward.len());
        let factor = SupernodalIntranodeLbltRef::new(raw, &self.values, subdiagonal, order);
        let mut below = 0;
        for s in 0..raw.n_supernodes() {
            let node = factor.supernode(s);
            let block = node.val();
            let mut i = 0;
            while i < block.ncols() {
                let (d, coupling) = (block[(i, i)], subdiagonal[node.start() + i]);
                if coupling == 0.0 {
                    below += usize::from(d < 0.0);
                    i += 1;
                } else {
                    let next = block[(i + 1, i + 1)];
                    let determinant = d * next - coupling * coupling;
                    below += match determinant < 0.0 {
                        true => 1,
                        false => 2 * usize::from(d < 0.0),
                    };
                    i += 2;
                }
            }
        }
        below
    }

    /// Whether it is `L L^T`: no eigenvalue lies below the shift.
    pub fn is_positive(&self) -> bool {
        self.pivots.is_none()
    }

    /// Whether all of it is finite: a shift that is an eigenvalue leaves a zero for a pivot.
    pub fn is_finite(&self) -> bool {
        self.values.iter().all(|x| x.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;
    use sprs::{CsMat, TriMat};

    use super::*;
    use crate::base::Rng;
    use crate::sparse::Mass;

    /// The Laplacian of a path, whose eigenvalues are `2 - 2 cos(pi i / n)`.
    fn path(n: usize) -> CsMat<f64> {
        let mut entries = TriMat::new((n, n));
        for i in 1..n {
            for (a, b, x) in [(i, i, 1.0), (i - 1, i - 1, 1.0), (i, i - 1, -1.0), (i - 1, i, -1.0)]
            {
                entries.add_triplet(a, b, x);
            }
        }
        entries.to_csr()
    }

    #[test]
    fn inertia_counts_the_eigenvalues_below_a_shift() {
        for n in [2, 3, 17, 200] {
            let (w, mass) = (path(n), Mass::identity(n));
            let shifted = Shifted::new(w.view(), &mass);
            let symbolic = Symbolic::new(shifted.symbolic()).unwrap();
            let value = |i: usize| 2.0 - 2.0 * (std::f64::consts::PI * i as f64 / n as f64).cos();
            for i in (0..n).step_by(1 + n / 9) {
                let shift = if i == 0 { -0.1 } else { 0.5 * (value(i - 1) + value(i)) };
                let factor = Factor::indefinite(&symbolic, &shifted, shift).unwrap();
                assert_eq!(factor.below_shift(), i, "n = {n}");
            }
            assert!(Factor::positive(&symbolic, &shifted, 0.5 * value(1)).unwrap().is_none());
        }
    }

    #[test]
    fn both_factorisations_solve_for_any_number_of_columns_and_threads() {
        let n = 150;
        let (w, mass) = (path(n), Mass::Lumped((1..=n).map(|i| 1.0 / i as f64).collect()));
        let shifted = Shifted::new(w.view(), &mass);
        let symbolic = Symbolic::new(shifted.symbolic()).unwrap();
        let mut rng = Rng::new(2);
        for (sigma, positive) in [(-0.5, true), (0.7, false)] {
            let factor = match positive {
                true => Factor::positive(&symbolic, &shifted, sigma).unwrap().unwrap(),
                false => Factor::indefinite(&symbolic, &shifted, sigma).unwrap(),
            };
            assert_eq!(factor.is_positive(), positive);
            for columns in [0, 1, 3, 4, 5, 9] {
                let x = Mat::from_fn(n, columns, |_, _| rng.uniform());
                let entry = |i: usize, j: usize| w.get(i, j).copied().unwrap_or(0.0);
                let mut solved = Mat::from_fn(n, columns, |i, c| {
                    let wx: f64 = (0..n).map(|j| entry(i, j) * x[(j, c)]).sum();
                    wx - sigma * mass.diagonal(i) * x[(i, c)]
                });
                let mut again = solved.clone();
                factor.solve(solved.as_mut(), Par::Seq).unwrap();
                factor.solve(again.as_mut(), Par::Threads(3)).unwrap();
                assert_eq!(solved, again);
                assert!(
                    (0..n).all(
                        |i| (0..columns).all(|c| { (solved[(i, c)] - x[(i, c)]).abs() < 1e-9 })
                    )
                );
            }
        }
    }
}
