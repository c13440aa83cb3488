use faer::Mat;
use faer::dyn_stack::MemStack;
use faer::sparse::linalg::cholesky::{
    LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Par, Side};
use sprs::CsMat;

use crate::base::{Error, Result, zeros};
use crate::dense::buffer;

/// faer's sparse Cholesky factorisations of matrices with the same places, on the calling thread.
#[derive(Debug)]
pub(super) struct Cholesky {
    symbolic: SymbolicCholesky<usize>,
}

/// One of the factorisations.
#[derive(Debug)]
pub(super) struct Factor(Vec<f64>);

impl Cholesky {
    /// The order of elimination for matrices with the places of this one, which has both triangles.
    pub fn new(pattern: &CsMat<f64>) -> Result<Self> {
        let (starts, columns) = (pattern.indptr(), pattern.indices());
        let places = places(pattern, starts.raw_storage());
        let ordering = SymmetricOrdering::Amd;
        let symbolic =
            factorize_symbolic_cholesky(places, Side::Lower, ordering, Default::default())
                .map_err(|_| Error::OutOfMemory { bytes: size_of_val(columns) })?;
        Ok(Self { symbolic })
    }

    /// Factorises a matrix with those places; `None` when it is not positive definite to working precision.
    pub fn factor(&self, matrix: &CsMat<f64>) -> Result<Option<Factor>> {
        let mut factor = zeros(self.symbolic.len_val())?;
        let scratch =
            self.symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = buffer(scratch)?;
        let starts = matrix.indptr();
        let done = self.symbolic.factorize_numeric_llt(
            &mut factor,
            SparseColMatRef::new(places(matrix, starts.raw_storage()), matrix.data()),
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        let definite = done.is_ok() && factor.iter().all(|x| x.is_finite());
        Ok(definite.then_some(Factor(factor)))
    }

    /// The solution for one right-hand side.
    pub fn solve(&self, factor: &Factor, right: &[f64]) -> Result<Vec<f64>> {
        let mut memory = buffer(self.symbolic.solve_in_place_scratch::<f64>(1, Par::Seq))?;
        let mut x = Mat::from_fn(right.len(), 1, |i, _| right[i]);
        LltRef::new(&self.symbolic, &factor.0).solve_in_place_with_conj(
            Conj::No,
            x.as_mut(),
            Par::Seq,
            MemStack::new(&mut memory),
        );
        Ok((0..right.len()).map(|i| x[(i, 0)]).collect())
    }
}

/// The places of a symmetric matrix; by rows or by columns is the same.
fn places<'a>(matrix: &'a CsMat<f64>, starts: &'a [usize]) -> SymbolicSparseColMatRef<'a, usize> {
    let n = matrix.rows();
    SymbolicSparseColMatRef::new_checked(n, n, starts, None, matrix.indices())
}
