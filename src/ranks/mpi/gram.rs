//! Least squares with distributed rows, from a Gram matrix in extended precision.

use ::mpi::collective::Root;
use ::mpi::topology::Communicator;
use faer::{Mat, MatRef};

use super::call::Call;
use super::stream::{joined_bounds, merge_accumulators};
use super::world::{Operation, World, fact, flag, number_fact};
use crate::base::{Error, Progress, Result, block_rows};
use crate::dense::zeros;
use crate::product::AtaOptions;
use crate::rows::{Accumulator, DenseRows, RowBounds, stream};
use crate::solve::{
    JoinedRows, LeastSquares, LeastSquaresOptions, Spread, check_weights, named_by_matrix,
};

/// Computes [`solve::lstsq`](crate::solve::lstsq()) of A (m x n) and B (m x k) of which every rank
/// has some rows, in any order and number, possibly none, and the weights of these rows, if there
/// are any. Every rank gets the whole solution: the same bits for any number of ranks and any
/// distribution of the rows.
///
/// Rank 0 solves. Standard errors are computed if any rank requests them. `progress` reports the
/// sums of this rank's rows, which are computed after the bounds of all rows are known.
///
/// ```no_run
/// use catamaran::base::Progress;
/// use catamaran::faer::mat;
/// use catamaran::solve::LeastSquaresOptions;
/// use catamaran::ranks::{World, lstsq};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// // Every rank has two points of the line 2 t + 1.
/// let t = world.rank() as f64;
/// let (a, b) = (mat![[t], [t + 0.5]], mat![[2.0 * t + 1.0], [2.0 * t + 2.0]]);
/// let options = LeastSquaresOptions::new().intercept(true);
/// let found = lstsq(&world, a.as_ref(), b.as_ref(), None, &options, Progress::none())?;
/// assert_eq!((found.coefficients[(0, 0)], found.intercepts[0]), (2.0, 1.0));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Rank`] when n, k or the options other than threads differ, only some ranks have
/// weights, or another rank failed or cancelled; else as [`solve::lstsq`](crate::solve::lstsq()),
/// rows of A and B counted from the first own one.
pub fn lstsq(
    world: &World,
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    weights: Option<&[f64]>,
    options: &LeastSquaresOptions,
    progress: Progress<'_>,
) -> Result<LeastSquares> {
    let facts = [
        fact("the number of columns", a.ncols()),
        fact("the number of targets", b.ncols()),
        flag("the presence of weights", weights.is_some()),
        number_fact("the ridge", options.ridge),
        flag("the intercept", options.intercept),
        fact("the option for dependent columns", options.rank_deficiency as usize),
    ];
    Call::run(world, Operation::LeastSquares, &facts, |call| {
        let errors = world.gather_numbers(usize::from(options.standard_errors)).contains(&1);
        let options = options.standard_errors(errors);
        let sums_options = AtaOptions::new().par(options.par);
        let height = block_rows::<f64>(a.ncols() + b.ncols(), weights.is_some());
        let (mut a_rows, mut b_rows) = (DenseRows(a), DenseRows(b));
        let prepared = JoinedRows::<f64>::new(&mut a_rows, &mut b_rows).and_then(|mut rows| {
            if let Some(weights) = weights {
                Error::check_shape("weights", (a.nrows(), 1), (weights.len(), 1))?;
            }
            check_weights(weights)?;
            let bounds = RowBounds::of_finite(&mut rows, weights, height, &sums_options)
                .map_err(|error| named_by_matrix(error, a.ncols()))?;
            Ok((rows, bounds))
        });
        let (mut rows, bounds) = call.meet(prepared)?;
        let bounds = joined_bounds(world, &bounds)?;
        let sum = Accumulator::extended(&bounds, options.intercept).and_then(|mut sum| {
            let sums_options = sums_options.progress(progress);
            stream(&mut rows, weights, height, &mut sum, &sums_options, &mut |_| Ok(()))?;
            Ok(sum)
        });
        let sum = merge_accumulators(world, call.meet(sum)?)?;
        let found = sum
            .map(|sum| {
                LeastSquares::from_gram(&sum.finish_extended(options.par)?, b.ncols(), &options)
            })
            .transpose();
        let own = call.meet(found)?;
        let place = own.map_or_else(|| blank(a.ncols(), b.ncols(), &options), Ok);
        let mut found = call.meet(place)?;
        broadcast(world, &mut found);
        Ok(found)
    })
}

/// Returns a solution of n columns and k targets to be overwritten.
fn blank(n: usize, k: usize, options: &LeastSquaresOptions) -> Result<LeastSquares> {
    let errors = options.standard_errors;
    Ok(LeastSquares {
        coefficients: zeros(n, k)?,
        coefficients_low: zeros(n, k)?,
        intercepts: vec![0.0; k],
        residual_norms: vec![0.0; k],
        r_squared: vec![0.0; k],
        f_statistics: vec![0.0; k],
        standard_errors: if errors { zeros(n, k)? } else { Mat::new() },
        intercept_errors: vec![0.0; if errors && options.intercept { k } else { 0 }],
        rank: 0,
        dependent: Vec::new(),
        condition: 0.0,
        observations: 0,
        degrees_of_freedom: 0,
        digits: 0.0,
        spread: errors.then(|| Spread::blank(n, options.intercept)).transpose()?,
    })
}

/// Overwrites the solution with that of rank 0, of the same shape.
fn broadcast(world: &World, found: &mut LeastSquares) {
    let root = world.communicator().process_at_rank(0);
    let n = found.coefficients.nrows();
    let rows = found.spread.as_ref().map_or(0, |spread| spread.root.nrows() as u64);
    let mut counts = vec![found.rank as u64, rows, found.observations, found.degrees_of_freedom];
    counts.extend(found.dependent.iter().map(|&column| column as u64));
    counts.resize(4 + n, 0);
    root.broadcast_into(&mut counts[..]);
    (found.rank, found.observations, found.degrees_of_freedom) =
        (counts[0] as usize, counts[2], counts[3]);
    let dependent = &counts[4..][..n - found.rank];
    found.dependent = dependent.iter().map(|&column| column as usize).collect();
    let mut scalars = [found.condition, found.digits];
    root.broadcast_into(&mut scalars[..]);
    [found.condition, found.digits] = scalars;
    let vectors = [
        &mut found.intercepts,
        &mut found.residual_norms,
        &mut found.r_squared,
        &mut found.f_statistics,
        &mut found.intercept_errors,
    ];
    vectors.into_iter().for_each(|values| root.broadcast_into(&mut values[..]));
    let matrices =
        [&mut found.coefficients, &mut found.coefficients_low, &mut found.standard_errors];
    for matrix in matrices {
        for j in 0..matrix.ncols() {
            root.broadcast_into(matrix.col_as_slice_mut(j));
        }
    }
    if let Some(spread) = &mut found.spread {
        let rows = counts[1] as usize;
        spread.root.truncate(rows, n);
        spread.constant.truncate(rows);
        for j in 0..n {
            root.broadcast_into(spread.root.col_as_slice_mut(j));
        }
        root.broadcast_into(&mut spread.constant[..]);
        root.broadcast_into(&mut spread.mean[..]);
        let mut weight = [spread.weight];
        root.broadcast_into(&mut weight[..]);
        [spread.weight] = weight;
    }
}
