//! `W - sigma M` factorized by all ranks: each rank eliminates the rows of a domain, and every rank
//! eliminates the Schur complement of the interface between the domains.

use std::ops::Range;

use faer::prelude::ReborrowMut;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Mat, MatMut};
use sprs::{CsMat, CsMatView};

use super::call::Call;
use super::exchange::{Rows, gather_lists};
use super::moves::Moves;
use super::spread::gather_matrix;
use crate::base::{Par, Result, reserved, zeros};
use crate::sparse::{Factor, Inverse, Mass, Shifted, Shifts, Symbolic};

/// The shifts of a pencil whose rows, and whose elimination, are distributed. With A the matrix, i
/// the rows of this rank's domain and s those of the interface, a factorization is one of `A_ii` on
/// each rank, and of `S = A_ss - sum of A_si A_ii^-1 A_is` on all. Their inertias add up to that of
/// A (Haynsworth 1968).
///
/// Each rank's memory is a factor of its domain, and one of the interface: about `c sqrt(n P)` rows
/// for a surface of n vertices on P ranks.
pub(super) struct SpreadShifts<'c> {
    call: &'c Call<'c>,
    /// The rows of this rank's domain, which are its first ones, and then, as a border without
    /// entries of its own, the rows of the interface that touch them.
    inner: Block,
    inner_len: usize,
    symbolic: Symbolic,
    interface: Interface,
}

/// A square block of the pencil.
struct Block {
    stiffness: CsMat<f64>,
    mass: Mass,
}

impl Block {
    fn shifted(&self) -> Shifted<'_> {
        Shifted::new(self.stiffness.view(), &self.mass)
    }
}

/// The rows of the interface, in the order of the ranks that have them.
struct Numbers<'m> {
    moves: &'m Moves,
    /// The first one of each rank.
    starts: Vec<usize>,
}

impl<'m> Numbers<'m> {
    fn new(moves: &'m Moves) -> Self {
        let mut starts = vec![0];
        for (rank, inner) in moves.inner.iter().enumerate() {
            starts.push(starts[rank] + moves.rows.of(rank).len() - inner);
        }
        Self { moves, starts }
    }

    /// Returns the number in the interface of a row that is in it.
    fn of(&self, row: usize) -> Option<usize> {
        let rank = self.moves.rows.holder(row);
        let inside = row - self.moves.rows.of(rank).start;
        inside.checked_sub(self.moves.inner[rank]).map(|i| self.starts[rank] + i)
    }

    /// Returns the numbers of the rows that a rank has.
    fn of_rank(&self, rank: usize) -> Range<usize> {
        self.starts[rank]..self.starts[rank + 1]
    }

    /// Returns the number of rows in the interface.
    fn count(&self) -> usize {
        self.starts[self.starts.len() - 1]
    }
}

/// Returns some rows of a matrix with the columns that have a place, at these places, ascending,
/// and then `empty` rows without entries.
fn select(
    matrix: CsMatView<'_, f64>,
    rows: Range<usize>,
    empty: usize,
    columns: usize,
    place: impl Fn(usize) -> Option<usize>,
) -> Result<CsMat<f64>> {
    let count = rows.len() + empty;
    let (mut starts, mut places) = (reserved(count + 1)?, reserved(matrix.nnz())?);
    let mut entries = reserved(matrix.nnz())?;
    starts.push(0);
    let mut sorted: Vec<(usize, f64)> = Vec::new();
    for i in rows {
        sorted.clear();
        let row = matrix.outer_view(i).expect("a row of the matrix");
        sorted.extend(row.iter().filter_map(|(j, &x)| place(j).map(|place| (place, x))));
        sorted.sort_unstable_by_key(|&(place, _)| place);
        places.extend(sorted.iter().map(|&(place, _)| place));
        entries.extend(sorted.iter().map(|&(_, x)| x));
        starts.push(places.len());
    }
    starts.resize(count + 1, places.len());
    Ok(CsMat::new((count, columns), starts, places, entries))
}

impl<'c> SpreadShifts<'c> {
    /// Analyses the pencil, of which this rank has these rows, for factorizations.
    pub fn new(
        call: &'c Call<'c>,
        moves: &Moves,
        stiffness: CsMatView<'_, f64>,
        mass: &Mass,
    ) -> Result<Self> {
        let rank = call.world.rank();
        let (own, inner_len) = (moves.rows.own(), moves.inner[rank]);
        let domain = own.start..own.start + inner_len;
        let numbers = Numbers::new(moves);
        let mut touching: Vec<usize> = Vec::new();
        let mut touch = |matrix: CsMatView<'_, f64>| {
            for i in 0..inner_len {
                let row = matrix.outer_view(i).expect("a row of this rank");
                let others = row.indices().iter().filter(|&&j| !domain.contains(&j));
                touching.extend(others.filter_map(|&j| numbers.of(j)));
            }
        };
        touch(stiffness);
        if let Mass::Full(matrix) = mass {
            touch(matrix.view());
        }
        touching.sort_unstable();
        touching.dedup();
        let place = |j: usize| match j.checked_sub(own.start) {
            Some(i) if i < inner_len => Some(i),
            _ => {
                let number = numbers.of(j)?;
                touching.binary_search(&number).ok().map(|border| inner_len + border)
            }
        };
        let border = touching.len();
        let bordered = |matrix| select(matrix, 0..inner_len, border, inner_len + border, place);
        let inner = (|| {
            let mass = match mass {
                Mass::Full(matrix) => Mass::Full(bordered(matrix.view())?),
                Mass::Lumped(masses) => {
                    let mut inner = reserved(inner_len + border)?;
                    inner.extend_from_slice(&masses[..inner_len]);
                    inner.resize(inner_len + border, 0.0);
                    Mass::Lumped(inner)
                }
            };
            let inner = Block { stiffness: bordered(stiffness)?, mass };
            let symbolic = Symbolic::bordered(inner.shifted().symbolic(), border)?;
            Ok((inner, symbolic))
        })();
        let (inner, symbolic) = call.meet(inner)?;
        let interface = Interface::new(call, &numbers, touching, stiffness, mass)?;
        Ok(Self { call, inner, inner_len, symbolic, interface })
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
        let below_zero = found[(2, 0)] as usize;
        let mut factor = SpreadFactor { shifts: self, inner, interface: None, below_zero, pivots };
        if found[(1, 0)] == 0.0 {
            let entries = self.symbolic.complement(&factor.inner);
            let entries = entries.and_then(|own| self.interface.entries(sigma, &own));
            let mut entries = self.call.meet(entries)?;
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
    block: Block,
    /// Those of its rows that this rank has, which are its last ones.
    own: Range<usize>,
    /// The rows that touch this rank's domain.
    touching: Vec<usize>,
    /// Whether this rank adds `A_ss` to the sum that is S.
    begins: bool,
    places: LowerPlaces,
    symbolic: Symbolic,
}

impl Interface {
    /// Creates the interface from this rank's rows of the pencil and those rows of the interface
    /// that touch its domain, ascending.
    fn new(
        call: &Call<'_>,
        numbers: &Numbers<'_>,
        touching: Vec<usize>,
        stiffness: CsMatView<'_, f64>,
        mass: &Mass,
    ) -> Result<Self> {
        let rank = call.world.rank();
        let (own, n) = (numbers.of_rank(rank), numbers.count());
        let rows = Rows::new(call, own.len())?;
        let gather = |matrix: CsMatView<'_, f64>| {
            let last = matrix.rows() - own.len()..matrix.rows();
            let part = call.meet(select(matrix, last, 0, n, |j| numbers.of(j)))?;
            gather_matrix(call, &rows, part.view())
        };
        let block = Block {
            stiffness: gather(stiffness)?,
            mass: match mass {
                Mass::Full(matrix) => Mass::Full(gather(matrix.view())?),
                Mass::Lumped(masses) => {
                    let own = &masses[masses.len() - own.len()..];
                    Mass::Lumped(gather_lists(call, own)?.0)
                }
            },
        };
        let as_numbers: Vec<f64> = touching.iter().map(|&s| s as f64).collect();
        let (all, spans) = gather_lists(call, &as_numbers)?;
        let of_rank =
            |span: Range<usize>| -> Vec<usize> { all[span].iter().map(|&s| s as usize).collect() };
        let touching_all: Vec<Vec<usize>> = spans.into_iter().map(of_rank).collect();
        let places = LowerPlaces::new(&block, &touching_all);
        let symbolic = call.meet(Symbolic::new(places.symbolic()))?;
        Ok(Self { block, own, touching, begins: rank == 0, places, symbolic })
    }

    /// Returns what this rank adds to the entries of S, given its [`Symbolic::complement`].
    fn entries(&self, sigma: f64, complement: &[f64]) -> Result<Vec<f64>> {
        let Self { block, touching, places, .. } = self;
        let mut entries = zeros(places.rows.len())?;
        if self.begins {
            let shifted = block.shifted();
            let (symbolic, values) = (shifted.symbolic(), shifted.values(sigma));
            for j in 0..shifted.len() {
                let rows = symbolic.row_idx_of_col_raw(j).iter().copied();
                let values = values[symbolic.col_range(j)].iter().copied();
                places.add(&mut entries, j, rows.zip(values));
            }
        }
        for (t, column) in complement.chunks_exact(touching.len().max(1)).enumerate() {
            let below = (t..touching.len()).map(|u| (touching[u], column[u]));
            places.add(&mut entries, touching[t], below);
        }
        Ok(entries)
    }
}

/// The pattern of a lower triangle by columns, ascending.
struct LowerPlaces {
    starts: Vec<usize>,
    rows: Vec<usize>,
}

impl LowerPlaces {
    /// Finds the places of S from the block of the interface and the rows of it that touch each
    /// domain, ascending.
    fn new(block: &Block, touching: &[Vec<usize>]) -> Self {
        let n = block.stiffness.rows();
        let mut domains = vec![vec![]; n];
        for (domain, rows) in touching.iter().enumerate() {
            rows.iter().for_each(|&s| domains[s].push(domain));
        }
        let shifted = block.shifted();
        let mut places = Self { starts: vec![0], rows: vec![] };
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
        places
    }

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
    /// `None` if the matrix of a domain is singular.
    interface: Option<Factor>,
    below_zero: usize,
    pivots: bool,
}

impl Inverse for SpreadFactor<'_> {
    /// Computes, with `b` for X: `x_s = S^-1 (b_s - sum of A_si A_ii^-1 b_i)`,
    /// `x_i = A_ii^-1 (b_i - A_is x_s)`, in one sweep down the factor of the domain, one sum over
    /// the ranks, and one sweep up.
    fn solve(&self, x: MatMut<'_, f64>, par: Par) -> Result<()> {
        /// Columns that are solved for together, as rows of eight numbers.
        const WIDTH: usize = 8;
        let SpreadShifts { call, inner_len, interface, .. } = self.shifts;
        let Interface { own, touching, .. } = interface;
        let factor = self.interface.as_ref().expect("nobody solves with a singular matrix");
        let (inner, mut last) = x.split_at_row_mut(*inner_len);
        let mut first = 0;
        let mut between = |width: usize, border: &mut [[f64; WIDTH]]| -> Result<()> {
            let right = zeros::<f64>(interface.block.stiffness.rows() * WIDTH);
            let mut right = call.meet(right)?;
            let (rows, _) = right.as_chunks_mut::<WIDTH>();
            for j in 0..width {
                own.clone().enumerate().for_each(|(i, s)| rows[s][j] = last[(i, first + j)]);
                border.iter().zip(touching).for_each(|(row, &s)| rows[s][j] += row[j]);
            }
            call.world.sum(&mut right);
            let n = right.len() / WIDTH;
            let mut solved = MatMut::from_row_major_slice_mut(&mut right, n, WIDTH);
            factor.solve(solved.rb_mut(), par)?;
            let (rows, _) = right.as_chunks::<WIDTH>();
            border.iter_mut().zip(touching).for_each(|(row, &s)| *row = rows[s]);
            for j in 0..width {
                own.clone().enumerate().for_each(|(i, s)| last[(i, first + j)] = rows[s][j]);
            }
            first += width;
            Ok(())
        };
        self.inner.solve_around(inner, &mut between, par)
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
