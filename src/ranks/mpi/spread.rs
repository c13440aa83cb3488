//! Sparse matrices with distributed rows, and products with vectors that are distributed likewise.

use std::ops::Range;

use faer::{Mat, MatMut, MatRef};
use sprs::{CsMat, CsMatView};

use super::call::Call;
use super::exchange::{Rows, all_gather, exchange, exchange_numbers};
use super::rows::sum_symmetric;
use super::world::{Fact, fact};
use crate::base::{Error, Par, Result, reserved};
use crate::dense::zeros;
use crate::sparse::{InnerSpace, Mass, check_mirrored, multiply};

/// This rank's rows of an n x n matrix, with columns renumbered: first those of this rank's rows,
/// then those that other ranks have to send.
pub(super) struct SpreadMatrix {
    local: CsMat<f64>,
    /// For each rank, which of this rank's rows it needs.
    asked: Vec<Vec<usize>>,
    /// For each rank, how many rows come from it.
    needed: Vec<usize>,
}

impl SpreadMatrix {
    /// Creates the part of this rank from its rows of a matrix with n columns.
    pub fn new(call: &Call<'_>, rows: &Rows, matrix: CsMatView<'_, f64>) -> Result<Self> {
        let own = rows.own();
        let mut others: Vec<usize> =
            matrix.outer_iterator().flat_map(|row| row.indices().to_vec()).collect();
        others.retain(|j| !own.contains(j));
        others.sort_unstable();
        others.dedup();
        let wanted = |rank: usize| {
            let span = rows.of(rank);
            let [first, end] = [span.start, span.end].map(|i| others.partition_point(|&j| j < i));
            &others[first..end]
        };
        let needed: Vec<usize> = (0..rows.ranks()).map(|rank| wanted(rank).len()).collect();
        let lens = exchange_numbers(call, &needed)?;
        // Numbers of rows are exact as floating-point numbers.
        let outgoing = (0..rows.ranks()).map(|r| wanted(r).iter().map(|&j| j as f64).collect());
        let asked = exchange(call, outgoing.collect(), &lens)?;
        let asked =
            asked.into_iter().map(|rows| rows.iter().map(|&i| i as usize - own.start).collect());
        let (mut starts, mut columns) = (vec![0], reserved(matrix.nnz())?);
        let mut entries = reserved(matrix.nnz())?;
        let renumbered = |j: usize| match own.contains(&j) {
            true => j - own.start,
            false => own.len() + others.partition_point(|&other| other < j),
        };
        for row in matrix.outer_iterator() {
            let mut row: Vec<_> = row.iter().map(|(j, &x)| (renumbered(j), x)).collect();
            row.sort_unstable_by_key(|&(j, _)| j);
            columns.extend(row.iter().map(|&(j, _)| j));
            entries.extend(row.iter().map(|&(_, x)| x));
            starts.push(columns.len());
        }
        let shape = (own.len(), own.len() + others.len());
        let local = CsMat::new(shape, starts, columns, entries);
        Ok(Self { local, asked: asked.collect(), needed })
    }

    /// Returns this rank's rows, with columns as in [`SpreadMatrix::extended`].
    pub fn rows(&self) -> CsMatView<'_, f64> {
        self.local.view()
    }

    /// Computes this rank's rows of `Y := A X`.
    pub fn multiply(
        &self,
        call: &Call<'_>,
        x: MatRef<'_, f64>,
        y: MatMut<'_, f64>,
        par: Par,
    ) -> Result<()> {
        multiply(self.rows(), self.extended(call, x)?.as_ref(), y, par)
    }

    /// Returns X extended by the rows of other ranks that this rank's rows of A need: first this
    /// rank's rows of X, then those of the others.
    pub fn extended(&self, call: &Call<'_>, x: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let (own, columns) = x.shape();
        let of = |rows: &Vec<usize>| {
            (0..columns).flat_map(|j| rows.iter().map(move |&i| x[(i, j)])).collect()
        };
        let outgoing = self.asked.iter().map(of).collect();
        let lens: Vec<usize> = self.needed.iter().map(|rows| rows * columns).collect();
        let incoming = exchange(call, outgoing, &lens)?;
        let mut extended = zeros(self.local.cols(), columns)?;
        extended.as_mut().subrows_mut(0, own).copy_from(x);
        let mut first = own;
        for (entries, &rows) in incoming.iter().zip(&self.needed) {
            for (j, column) in entries.chunks_exact(rows.max(1)).enumerate() {
                for (i, &entry) in column.iter().enumerate() {
                    extended[(first + i, j)] = entry;
                }
            }
            first += rows;
        }
        Ok(extended)
    }
}

/// A mass matrix with distributed rows.
pub(super) struct SpreadMass<'c> {
    call: &'c Call<'c>,
    rows: &'c Rows,
    own: Own<'c>,
}

enum Own<'c> {
    Lumped(&'c [f64]),
    Full(SpreadMatrix),
}

impl<'c> SpreadMass<'c> {
    /// Creates the part of this rank from its masses, or from its rows of a matrix with n columns.
    /// [`check_mass_shape`] must have accepted them.
    pub fn new(call: &'c Call<'c>, rows: &'c Rows, mass: &'c Mass) -> Result<Self> {
        let own = match mass {
            Mass::Lumped(masses) => Own::Lumped(masses),
            Mass::Full(matrix) => Own::Full(SpreadMatrix::new(call, rows, matrix.view())?),
        };
        Ok(Self { call, rows, own })
    }

    /// Returns the matrix, if the mass is full.
    pub fn matrix(&self) -> Option<&SpreadMatrix> {
        match &self.own {
            Own::Lumped(_) => None,
            Own::Full(matrix) => Some(matrix),
        }
    }
}

impl InnerSpace for SpreadMass<'_> {
    fn dimension(&self) -> usize {
        self.rows.count()
    }

    fn rows(&self) -> Range<usize> {
        self.rows.own()
    }

    fn masses(&self) -> Option<&[f64]> {
        match &self.own {
            Own::Lumped(masses) => Some(masses),
            Own::Full(_) => None,
        }
    }

    fn apply_mass(&self, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>, par: Par) -> Result<()> {
        match &self.own {
            Own::Full(matrix) => matrix.multiply(self.call, x, y, par)?,
            Own::Lumped(masses) => {
                for j in 0..x.ncols() {
                    for (i, mass) in masses.iter().enumerate() {
                        y[(i, j)] = mass * x[(i, j)];
                    }
                }
            }
        }
        Ok(())
    }

    fn sum(&self, partial: MatMut<'_, f64>) -> Result<()> {
        self.call.sum(partial)
    }

    fn sum_symmetric(&self, partial: MatMut<'_, f64>) -> Result<()> {
        self.call.meet(Ok(()))?;
        sum_symmetric(self.call.world, partial.as_ref())?.spread(self.call, partial)
    }
}

/// Checks the shape of this rank's `rows` rows of an n x n matrix; errors name `what`.
pub(super) fn check_rows(
    what: &'static str,
    matrix: CsMatView<'_, f64>,
    rows: usize,
    n: usize,
) -> Result<()> {
    if !matrix.is_csr() {
        return Err(Error::Argument { what, why: "must be stored by rows".into() });
    }
    Error::check_shape(what, (rows, n), matrix.shape())
}

/// Checks that a mass has this rank's rows, and n rows in all.
pub(super) fn check_mass_shape(mass: &Mass, rows: &Rows) -> Result<()> {
    let (own, n) = (rows.own().len(), rows.count());
    match mass {
        Mass::Lumped(masses) => Error::check_shape("mass", (own, 1), (masses.len(), 1)),
        Mass::Full(matrix) => check_rows("mass", matrix.view(), own, n),
    }
}

/// Checks a distributed mass as [`Mass::check`] does; the rows that errors name are those of all
/// ranks.
pub(super) fn check_mass(call: &Call<'_>, rows: &Rows, mass: &Mass) -> Result<()> {
    call.meet(check_mass_shape(mass, rows))?;
    let matrix = match mass {
        Mass::Lumped(masses) => return check_lumped(rows, mass, masses),
        Mass::Full(matrix) => matrix,
    };
    let own = rows.own();
    for i in 0..own.len() {
        let at = matrix.get(i, own.start + i).copied().unwrap_or(0.0);
        // Those that are no numbers are found below.
        if at <= 0.0 {
            let why = format!("must be positive, but entry {} is {at:e}", own.start + i);
            return Err(Error::Argument { what: "mass", why });
        }
    }
    check_symmetric(call, rows, "mass", matrix.view())
}

/// Checks the matrices of a pencil as [`crate::sparse::eigs()`] does; the rows that errors name are
/// those of all ranks.
pub(super) fn check_pencil(
    call: &Call<'_>,
    rows: &Rows,
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
) -> Result<()> {
    check_symmetric(call, rows, "stiffness", stiffness)?;
    match mass {
        Mass::Lumped(masses) => check_lumped(rows, mass, masses),
        Mass::Full(_) => check_mass(call, rows, mass),
    }
}

/// Checks the lumped masses of this rank; the row that an error names is that of all ranks.
fn check_lumped(rows: &Rows, mass: &Mass, masses: &[f64]) -> Result<()> {
    let first = rows.own().start;
    match mass.check(masses.len()) {
        Err(Error::NonFinite { what, index: (i, j) }) => {
            Err(Error::NonFinite { what, index: (first + i, j) })
        }
        Err(Error::Argument { what, .. }) => {
            let i = masses.iter().position(|mass| *mass <= 0.0).unwrap_or(0);
            let why = format!("must be positive, but entry {} is {:e}", first + i, masses[i]);
            Err(Error::Argument { what, why })
        }
        other => other,
    }
}

/// Checks that a matrix with distributed rows is finite and symmetric, each entry on the rank that
/// has its mirror image; errors name `what` and the entry, its row first.
fn check_symmetric(
    call: &Call<'_>,
    rows: &Rows,
    what: &'static str,
    matrix: CsMatView<'_, f64>,
) -> Result<()> {
    let own = rows.own();
    let mut diagonal = vec![0.0; own.len()];
    for (i, row) in (own.start..).zip(matrix.outer_iterator()) {
        for (j, &x) in row.iter() {
            if !x.is_finite() {
                return Err(Error::NonFinite { what, index: (i, j) });
            }
            if i == j {
                diagonal[i - own.start] = x.abs();
            }
        }
    }
    let check = |(i, j): (usize, usize), x: f64, at_i: f64| {
        let row = matrix.outer_view(j - own.start);
        let mirrored = row.and_then(|row| row.get(i).copied()).unwrap_or(0.0);
        check_mirrored(what, (i, j), [x, mirrored], [at_i, diagonal[j - own.start]])
    };
    let mut outgoing = vec![Vec::new(); rows.ranks()];
    for (i, row) in (own.start..).zip(matrix.outer_iterator()) {
        for (j, &x) in row.iter().filter(|&(j, _)| j != i) {
            let at_i = diagonal[i - own.start];
            match own.contains(&j) {
                true => check((i, j), x, at_i)?,
                false => outgoing[rows.holder(j)].extend([i as f64, j as f64, x, at_i]),
            }
        }
    }
    let counts: Vec<usize> = outgoing.iter().map(Vec::len).collect();
    let lens = exchange_numbers(call, &counts)?;
    for images in exchange(call, outgoing, &lens)? {
        let (images, _) = images.as_chunks::<4>();
        for &[i, j, x, at_i] in images {
            check((i as usize, j as usize), x, at_i)?;
        }
    }
    Ok(())
}

/// Returns the whole matrix on every rank, from the rows of all ranks.
pub(super) fn gather_matrix(
    call: &Call<'_>,
    rows: &Rows,
    matrix: CsMatView<'_, f64>,
) -> Result<CsMat<f64>> {
    let lens: Vec<usize> = (0..rows.ranks()).map(|rank| rows.of(rank).len()).collect();
    let counts: Vec<f64> = matrix.outer_iterator().map(|row| row.nnz() as f64).collect();
    let counts = all_gather(call, &counts, &lens)?;
    let mut starts = vec![0];
    counts.into_iter().for_each(|count| starts.push(starts[starts.len() - 1] + count as usize));
    let lens: Vec<usize> = (0..rows.ranks())
        .map(|rank| starts[rows.of(rank).end] - starts[rows.of(rank).start])
        .collect();
    let (mut columns, mut entries) = (Vec::new(), Vec::new());
    for row in matrix.outer_iterator() {
        columns.extend(row.indices().iter().map(|&j| j as f64));
        entries.extend_from_slice(row.data());
    }
    let columns = all_gather(call, &columns, &lens)?;
    let columns = columns.into_iter().map(|j| j as usize).collect();
    let entries = all_gather(call, &entries, &lens)?;
    Ok(CsMat::new((rows.count(), matrix.cols()), starts, columns, entries))
}

/// Returns the whole mass on every rank.
pub(super) fn gather_mass(call: &Call<'_>, rows: &Rows, mass: &Mass) -> Result<Mass> {
    let lens: Vec<usize> = (0..rows.ranks()).map(|rank| rows.of(rank).len()).collect();
    Ok(match mass {
        Mass::Lumped(masses) => Mass::Lumped(all_gather(call, masses, &lens)?),
        Mass::Full(matrix) => Mass::Full(gather_matrix(call, rows, matrix.view())?),
    })
}

/// Returns the fact that all ranks have the same kind of mass.
pub(super) fn mass_fact(mass: &Mass) -> Fact {
    fact("the kind of mass (0 lumped, 1 full)", usize::from(matches!(mass, Mass::Full(_))))
}
