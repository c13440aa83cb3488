//! `W - sigma M` factorized by all ranks: each rank eliminates the rows of a domain, and every rank
//! eliminates the Schur complement of the interface between the domains.

use std::ops::Range;

use faer::prelude::ReborrowMut;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Mat, MatMut, MatRef};
use sprs::{CsMat, CsMatView};

use super::call::Call;
use super::domains::Domains;
use super::exchange::{Rows, exchange};
use crate::base::{Par, Result};
use crate::dense::zeros;
use crate::sparse::{Factor, Inverse, Mass, Shifted, Shifts, Symbolic, multiply, select};

/// Columns of a coupling that are solved together.
const COLUMNS: usize = 64;

/// The shifts of a pencil whose rows, and whose elimination, are distributed. With A the matrix, i
/// the rows of this rank's domain and s those of the interface, a factorization is one of `A_ii` on
/// each rank, and of `S = A_ss - sum of A_si A_ii^-1 A_is` on all. Their inertias add up to that of
/// A (Haynsworth 1968).
///
/// Each rank's memory is a factor of its domain, and one of the interface: about `c sqrt(n P)` rows
/// for a surface of n vertices on P ranks.
pub(super) struct SpreadShifts<'c> {
    call: &'c Call<'c>,
    par: Par,
    /// For each rank, which of this rank's rows are in its domain.
    outgoing: Vec<Vec<usize>>,
    /// For each rank, which rows of this rank's domain it has.
    incoming: Vec<Range<usize>>,
    /// Rows of this rank that are in the interface, and their places there.
    own_interface: Vec<(usize, usize)>,
    inner: DiagonalBlock,
    symbolic: Symbolic,
    /// `A_si`, of the rows of the interface that touch this rank's domain.
    coupling: Coupling,
    interface: Interface,
}

/// A diagonal block of the pencil.
struct DiagonalBlock {
    stiffness: CsMat<f64>,
    mass: Mass,
}

impl DiagonalBlock {
    fn shifted(&self) -> Shifted<'_> {
        Shifted::new(self.stiffness.view(), &self.mass)
    }
}

/// An off-diagonal block of the pencil.
struct Coupling {
    stiffness: CsMat<f64>,
    mass: Option<CsMat<f64>>,
}

impl Coupling {
    /// Returns `W - sigma M` of this block.
    fn shifted(&self, sigma: f64) -> CsMat<f64> {
        match &self.mass {
            None => self.stiffness.clone(),
            Some(mass) => &self.stiffness + &mass.map(|m| -sigma * m),
        }
    }
}

impl<'c> SpreadShifts<'c> {
    /// Distributes the pencil, given with all rows, for factorizations by ranks that have `rows`.
    pub fn new(
        call: &'c Call<'c>,
        rows: &Rows,
        stiffness: CsMatView<'_, f64>,
        mass: &Mass,
        par: Par,
    ) -> Result<Self> {
        let mut matrices = vec![stiffness];
        if let Mass::Full(matrix) = mass {
            matrices.push(matrix.view());
        }
        let rank = call.world.rank();
        let Domains { inner, interface } = Domains::new(&matrices, rows.ranks());
        let own = rows.own();
        let held = |set: &[usize], span: Range<usize>| {
            set.partition_point(|&i| i < span.start)..set.partition_point(|&i| i < span.end)
        };
        let mine = |set: &[usize]| -> Vec<usize> {
            set[held(set, own.clone())].iter().map(|&i| i - own.start).collect()
        };
        let outgoing = inner.iter().map(|domain| mine(domain)).collect();
        let incoming = (0..rows.ranks()).map(|from| held(&inner[rank], rows.of(from))).collect();
        let places = held(&interface, own.clone());
        let own_interface = mine(&interface).into_iter().zip(places).collect();
        let place = Places::new(stiffness.rows(), &interface);
        let touching: Vec<_> =
            inner.iter().map(|domain| place.touched(&matrices, domain)).collect();
        let touched: Vec<usize> = touching[rank].iter().map(|&s| interface[s]).collect();
        let place_inner = Places::new(stiffness.rows(), &inner[rank]);
        let coupling = Coupling {
            stiffness: place_inner.select(stiffness, &touched),
            mass: match mass {
                Mass::Lumped(_) => None,
                Mass::Full(matrix) => Some(place_inner.select(matrix.view(), &touched)),
            },
        };
        let inner = place_inner.block(stiffness, mass, &inner[rank]);
        let symbolic = call.meet(Symbolic::new(inner.shifted().symbolic()))?;
        let interface = Interface::new(place.block(stiffness, mass, &interface), &touching, rank);
        let interface = call.meet(interface)?;
        Ok(Self {
            call,
            par,
            outgoing,
            incoming,
            own_interface,
            inner,
            symbolic,
            coupling,
            interface,
        })
    }

    /// Factorizes, with pivots or for a positive definite matrix; `None` if it is not that.
    fn factorize(&self, sigma: f64, pivots: bool) -> Result<Option<SpreadFactor<'_>>> {
        let shifted = self.inner.shifted();
        let entries = shifted.values(sigma);
        let inner = factorize(&self.symbolic, shifted.matrix(&entries), pivots);
        let inner = self.call.meet(inner)?;
        drop(entries);
        // The ranks whose matrix is indefinite, or singular, and the negative eigenvalues.
        let mut found = Mat::<f64>::zeros(3, 1);
        match &inner {
            None => found[(0, 0)] = 1.0,
            Some(factor) => {
                found[(1, 0)] = f64::from(u8::from(!factor.is_finite()));
                found[(2, 0)] = factor.below_zero() as f64;
            }
        }
        self.call.sum(found.as_mut())?;
        let (Some(inner), 0.0) = (inner, found[(0, 0)]) else { return Ok(None) };
        let coupling = self.coupling.shifted(sigma);
        let transposed = coupling.transpose_view().to_csr();
        let mut factor = SpreadFactor {
            shifts: self,
            inner,
            coupling,
            transposed,
            interface: None,
            below_zero: found[(2, 0)] as usize,
            pivots,
        };
        if found[(1, 0)] == 0.0 {
            let mut entries = self.call.meet(factor.complement(sigma, self.par))?;
            self.call.world.sum(&mut entries);
            let Interface { symbolic, places, .. } = &self.interface;
            let interface = factorize(symbolic, places.matrix(&entries), pivots);
            let Some(interface) = self.call.meet(interface)? else { return Ok(None) };
            factor.below_zero += interface.below_zero();
            factor.interface = Some(interface);
        }
        Ok(Some(factor))
    }
}

/// Factorizes a symmetric matrix; `None` if it is not positive definite, and without pivots.
fn factorize(
    symbolic: &Symbolic,
    matrix: SparseColMatRef<'_, usize, f64>,
    pivots: bool,
) -> Result<Option<Factor>> {
    match pivots {
        true => symbolic.indefinite(matrix).map(Some),
        false => symbolic.positive(matrix),
    }
}

/// What all ranks know about the interface, and this rank about its own part of it.
struct Interface {
    block: DiagonalBlock,
    /// The rows that touch this rank's domain.
    touching: Vec<usize>,
    /// Whether this rank adds `A_ss` to the sum that is S.
    begins: bool,
    places: LowerPlaces,
    symbolic: Symbolic,
}

impl Interface {
    /// Creates the interface from its block of the pencil and the rows that touch each domain,
    /// ascending.
    fn new(block: DiagonalBlock, touching: &[Vec<usize>], rank: usize) -> Result<Self> {
        let n = block.stiffness.rows();
        let mut domains = vec![vec![]; n];
        for (domain, rows) in touching.iter().enumerate() {
            rows.iter().for_each(|&s| domains[s].push(domain));
        }
        let shifted = block.shifted();
        let mut places = LowerPlaces { starts: vec![0], rows: vec![] };
        for (j, domains) in domains.iter().enumerate() {
            let mut rows = shifted.symbolic().row_idx_of_col_raw(j).to_vec();
            for &domain in domains {
                let all = &touching[domain];
                rows.extend(&all[all.partition_point(|&s| s < j)..]);
            }
            rows.sort_unstable();
            rows.dedup();
            places.rows.extend(rows);
            places.starts.push(places.rows.len());
        }
        drop(shifted);
        let symbolic = Symbolic::new(places.symbolic())?;
        Ok(Self { block, touching: touching[rank].clone(), begins: rank == 0, places, symbolic })
    }
}

/// The pattern of a lower triangle by columns, ascending.
struct LowerPlaces {
    starts: Vec<usize>,
    rows: Vec<usize>,
}

impl LowerPlaces {
    fn symbolic(&self) -> SymbolicSparseColMatRef<'_, usize> {
        let n = self.starts.len() - 1;
        SymbolicSparseColMatRef::new_checked(n, n, &self.starts, None, &self.rows)
    }

    fn matrix<'b>(&'b self, entries: &'b [f64]) -> SparseColMatRef<'b, usize, f64> {
        SparseColMatRef::new(self.symbolic(), entries)
    }

    /// Adds numbers to the entries in these rows (ascending) of column j.
    fn add(&self, entries: &mut [f64], j: usize, numbers: impl Iterator<Item = (usize, f64)>) {
        let mut at = self.starts[j];
        for (row, number) in numbers {
            while self.rows[at] != row {
                at += 1;
            }
            entries[at] += number;
        }
    }
}

impl Shifts for SpreadShifts<'_> {
    fn bytes(&self) -> usize {
        let places = self.interface.places.rows.len() * (size_of::<usize>() + size_of::<f64>());
        self.symbolic.bytes() + self.interface.symbolic.bytes() + places
    }

    fn positive(&self, sigma: f64) -> Result<Option<Box<dyn Inverse + '_>>> {
        let factor = self.factorize(sigma, false)?;
        Ok(factor.map(|factor| Box::new(factor) as Box<dyn Inverse>))
    }

    fn indefinite(&self, sigma: f64) -> Result<Box<dyn Inverse + '_>> {
        let factor = self.factorize(sigma, true)?;
        Ok(Box::new(factor.expect("pivots allow for any matrix")))
    }
}

/// The part of a factorization that a rank holds.
struct SpreadFactor<'s> {
    shifts: &'s SpreadShifts<'s>,
    inner: Factor,
    /// `A_si` and `A_is`.
    coupling: CsMat<f64>,
    transposed: CsMat<f64>,
    /// `None` if the matrix of a domain is singular.
    interface: Option<Factor>,
    below_zero: usize,
    pivots: bool,
}

impl SpreadFactor<'_> {
    /// Returns what this rank adds to the entries of S.
    fn complement(&self, sigma: f64, par: Par) -> Result<Vec<f64>> {
        let Interface { block, touching, begins, places, .. } = &self.shifts.interface;
        let mut entries = crate::base::zeros(places.rows.len())?;
        if *begins {
            let shifted = block.shifted();
            let (symbolic, values) = (shifted.symbolic(), shifted.values(sigma));
            for j in 0..shifted.len() {
                let rows = symbolic.row_idx_of_col_raw(j).iter().copied();
                let values = values[symbolic.col_range(j)].iter().copied();
                places.add(&mut entries, j, rows.zip(values));
            }
        }
        let (len, width) = (self.inner_len(), COLUMNS.min(touching.len()));
        let (mut solved, mut product) = (zeros(len, width)?, zeros(touching.len(), width)?);
        for (chunk, columns) in touching.chunks(COLUMNS).enumerate() {
            let first = chunk * COLUMNS;
            let mut solved = solved.as_mut().subcols_mut(0, columns.len());
            solved.fill(0.0);
            for j in 0..columns.len() {
                let column = self.coupling.outer_view(first + j).expect("a row of the coupling");
                column.iter().for_each(|(i, &x)| solved[(i, j)] = x);
            }
            self.inner.solve(solved.rb_mut(), par)?;
            let mut product = product.as_mut().subcols_mut(0, columns.len());
            multiply(self.coupling.view(), solved.as_ref(), product.rb_mut(), par)?;
            for (j, &column) in columns.iter().enumerate() {
                let below = (first + j..touching.len()).map(|t| (touching[t], -product[(t, j)]));
                places.add(&mut entries, column, below);
            }
        }
        Ok(entries)
    }

    /// Returns the rows of X in this rank's domain, from the ranks that have them.
    fn collect(&self, x: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let shifts = self.shifts;
        let of = |rows: &Vec<usize>| {
            x.col_iter().flat_map(|x| rows.iter().map(move |&i| x[i])).collect()
        };
        let outgoing = shifts.outgoing.iter().map(of).collect();
        let lens: Vec<usize> = shifts.incoming.iter().map(|span| span.len() * x.ncols()).collect();
        let mut inner = shifts.call.meet(zeros(self.inner_len(), x.ncols()))?;
        for (span, entries) in shifts.incoming.iter().zip(exchange(shifts.call, outgoing, &lens)?) {
            for (j, column) in entries.chunks_exact(span.len().max(1)).enumerate() {
                let inner = inner.as_mut().col_mut(j).subrows_mut(span.start, span.len());
                inner.iter_mut().zip(column).for_each(|(to, &from)| *to = from);
            }
        }
        Ok(inner)
    }

    /// Undoes [`SpreadFactor::collect`].
    fn hand_back(&self, inner: MatRef<'_, f64>, mut x: MatMut<'_, f64>) -> Result<()> {
        let shifts = self.shifts;
        let of = |span: &Range<usize>| {
            let rows = inner.subrows(span.start, span.len());
            rows.col_iter().flat_map(|column| column.iter().copied().collect::<Vec<_>>()).collect()
        };
        let outgoing = shifts.incoming.iter().map(of).collect();
        let lens: Vec<usize> = shifts.outgoing.iter().map(|rows| rows.len() * x.ncols()).collect();
        for (rows, entries) in shifts.outgoing.iter().zip(exchange(shifts.call, outgoing, &lens)?) {
            for (j, column) in entries.chunks_exact(rows.len().max(1)).enumerate() {
                rows.iter().zip(column).for_each(|(&i, &entry)| x[(i, j)] = entry);
            }
        }
        Ok(())
    }

    /// Returns the number of rows of this rank's domain.
    fn inner_len(&self) -> usize {
        self.transposed.rows()
    }
}

impl Inverse for SpreadFactor<'_> {
    /// Computes, with `b` for X: `x_s = S^-1 (b_s - sum of A_si A_ii^-1 b_i)`, `x_i = A_ii^-1 (b_i
    /// - A_is x_s)`.
    fn solve(&self, mut x: MatMut<'_, f64>, par: Par) -> Result<()> {
        let SpreadShifts { call, own_interface, interface, .. } = self.shifts;
        let (touching, width) = (&interface.touching, x.ncols());
        let mut inner = self.collect(x.as_ref())?;
        let own = (|| {
            let mut solved = inner.clone();
            self.inner.solve(solved.as_mut(), par)?;
            let mut product = zeros(touching.len(), width)?;
            multiply(self.coupling.view(), solved.as_ref(), product.as_mut(), par)?;
            let mut right = zeros(interface.block.stiffness.rows(), width)?;
            for j in 0..width {
                own_interface.iter().for_each(|&(i, s)| right[(s, j)] = x[(i, j)]);
                touching.iter().enumerate().for_each(|(t, &s)| right[(s, j)] -= product[(t, j)]);
            }
            Ok(right)
        })();
        let mut between = call.meet(own)?;
        call.sum(between.as_mut())?;
        let done = (|| {
            let factor = self.interface.as_ref().expect("nobody solves with a singular matrix");
            factor.solve(between.as_mut(), par)?;
            let near = Mat::from_fn(touching.len(), width, |t, j| between[(touching[t], j)]);
            let mut product = zeros(self.inner_len(), width)?;
            multiply(self.transposed.view(), near.as_ref(), product.as_mut(), par)?;
            inner -= product;
            self.inner.solve(inner.as_mut(), par)
        })();
        call.meet(done)?;
        for j in 0..width {
            own_interface.iter().for_each(|&(i, s)| x[(i, j)] = between[(s, j)]);
        }
        self.hand_back(inner.as_ref(), x)
    }

    fn below_zero(&self) -> usize {
        self.below_zero
    }

    fn is_positive(&self) -> bool {
        !self.pivots
    }

    fn is_finite(&self) -> bool {
        self.interface.as_ref().is_some_and(Inverse::is_finite)
    }
}

/// The places of rows in an ascending list of some of them.
struct Places {
    place: Vec<Option<usize>>,
    len: usize,
}

impl Places {
    /// Creates the places of these of n rows.
    fn new(n: usize, rows: &[usize]) -> Self {
        let mut place = vec![None; n];
        rows.iter().enumerate().for_each(|(p, &i)| place[i] = Some(p));
        Self { place, len: rows.len() }
    }

    /// Returns the places in which these rows of the matrices have entries, ascending.
    fn touched(&self, matrices: &[CsMatView<'_, f64>], rows: &[usize]) -> Vec<usize> {
        let of_row = |&i: &usize| {
            let rows = matrices.iter().filter_map(move |matrix| matrix.outer_view(i));
            rows.flat_map(|row| row.indices().to_vec()).filter_map(|j| self.place[j])
        };
        let mut places: Vec<usize> = rows.iter().flat_map(of_row).collect();
        places.sort_unstable();
        places.dedup();
        places
    }

    /// Returns these rows of a matrix, with the columns that have places.
    fn select(&self, matrix: CsMatView<'_, f64>, rows: &[usize]) -> CsMat<f64> {
        select(matrix, rows, &self.place, self.len)
    }

    /// Returns the block of these rows, which are those that have places.
    fn block(&self, stiffness: CsMatView<'_, f64>, mass: &Mass, rows: &[usize]) -> DiagonalBlock {
        let mass = match mass {
            Mass::Lumped(masses) => Mass::Lumped(rows.iter().map(|&i| masses[i]).collect()),
            Mass::Full(matrix) => Mass::Full(self.select(matrix.view(), rows)),
        };
        DiagonalBlock { stiffness: self.select(stiffness, rows), mass }
    }
}
