//! `W - sigma M` factorised by all ranks: each eliminates the rows of a domain, and what is left, the
//! Schur complement of the interface between the domains, all.

use std::ops::Range;

use faer::prelude::ReborrowMut;
use faer::{Mat, MatMut, MatRef};
use sprs::{CsMat, CsMatView, TriMat};

use super::call::Call;
use super::domains::Domains;
use super::exchange::{Rows, all_gather, exchange};
use crate::base::{Par, Result, reserved};
use crate::dense::zeros;
use crate::sparse::{Factor, Inverse, Mass, Shifted, Shifts, Symbolic, multiply};

/// Columns of a coupling that are solved for together.
const COLUMNS: usize = 64;

/// The shifts of a pencil whose rows are spread, with the elimination spread too. With A the matrix,
/// i the rows of this rank's domain and s those of the interface, a factorisation is one of `A_ii` on
/// each rank, and of `S = A_ss - sum of A_si A_ii^-1 A_is` on all. Their inertias add up to that of A
/// (Haynsworth 1968).
///
/// Each rank's memory is a factor of its domain, and one of the interface: about `c sqrt(n P)` rows
/// for a surface of n vertices on P ranks.
pub(super) struct SpreadShifts<'c> {
    call: &'c Call<'c>,
    par: Par,
    /// For each rank, which of the own rows are in its domain.
    outgoing: Vec<Vec<usize>>,
    /// For each rank, which rows of the own domain it has.
    incoming: Vec<Range<usize>>,
    /// Own rows that are in the interface, and their places there.
    own_interface: Vec<(usize, usize)>,
    inner: Block,
    symbolic: Symbolic,
    /// `A_si`, of the rows of the interface that touch the own domain.
    coupling: Coupling,
    /// These rows, of each rank's domain.
    touching: Vec<Vec<usize>>,
    rank: usize,
    interface: Block,
}

/// A diagonal block of the pencil.
struct Block {
    stiffness: CsMat<f64>,
    mass: Mass,
}

/// Another block of the pencil.
struct Coupling {
    stiffness: CsMat<f64>,
    mass: Option<CsMat<f64>>,
}

impl Coupling {
    /// `W - sigma M`.
    fn shifted(&self, sigma: f64) -> CsMat<f64> {
        match &self.mass {
            None => self.stiffness.clone(),
            Some(mass) => &self.stiffness + &mass.map(|m| -sigma * m),
        }
    }
}

impl<'c> SpreadShifts<'c> {
    /// Of the pencil with all rows, of which the ranks have `rows`.
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
        let inner = Block {
            stiffness: place_inner.select(stiffness, &inner[rank]),
            mass: place_inner.select_mass(mass, &inner[rank]),
        };
        let interface = Block {
            stiffness: place.select(stiffness, &interface),
            mass: place.select_mass(mass, &interface),
        };
        let shifted = Shifted::new(inner.stiffness.view(), &inner.mass);
        let symbolic = call.meet(Symbolic::new(shifted.symbolic()))?;
        Ok(Self {
            call,
            par,
            outgoing,
            incoming,
            own_interface,
            inner,
            symbolic,
            coupling,
            touching,
            rank,
            interface,
        })
    }

    /// The factorisation, with pivots or for a positive definite matrix; nothing if it is not that.
    fn factorise(&self, sigma: f64, pivots: bool) -> Result<Option<SpreadFactor<'_>>> {
        let inner = factorise(&self.symbolic, &self.inner, sigma, pivots);
        let inner = self.call.meet(inner)?;
        // Ranks that found theirs indefinite, or singular, and negative eigenvalues.
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
            let Some(interface) = self.interface(sigma, &factor)? else { return Ok(None) };
            factor.below_zero += interface.below_zero();
            factor.interface = Some(interface);
        }
        Ok(Some(factor))
    }

    /// S, factorised, the same on every rank.
    fn interface(&self, sigma: f64, factor: &SpreadFactor<'_>) -> Result<Option<Factor>> {
        let own = self.call.meet(factor.complement(self.par))?;
        let lens: Vec<usize> =
            self.touching.iter().map(|rows| rows.len() * (rows.len() + 1) / 2).collect();
        let complements = all_gather(self.call, &own, &lens)?;
        drop(own);
        let n = self.interface.stiffness.rows();
        let shifted = Shifted::new(self.interface.stiffness.view(), &self.interface.mass);
        let mut entries = TriMat::new((n, n));
        let mut put = |i: usize, j: usize, x: f64| {
            entries.add_triplet(i, j, x);
            if i != j {
                entries.add_triplet(j, i, x);
            }
        };
        let (symbolic, values) = (shifted.symbolic(), shifted.values(sigma));
        for j in 0..n {
            for (&i, &x) in
                symbolic.row_idx_of_col_raw(j).iter().zip(&values[symbolic.col_range(j)])
            {
                put(i, j, x);
            }
        }
        let mut rest = &complements[..];
        for rows in &self.touching {
            for (j, &column) in rows.iter().enumerate() {
                let (entries, others) = rest.split_at(rows.len() - j);
                rows[j..].iter().zip(entries).for_each(|(&row, x)| put(row, column, -x));
                rest = others;
            }
        }
        drop(complements);
        let complement = Block { stiffness: entries.to_csr(), mass: Mass::Lumped(vec![0.0; n]) };
        let shifted = Shifted::new(complement.stiffness.view(), &complement.mass);
        let symbolic = Symbolic::new(shifted.symbolic());
        let done =
            symbolic.and_then(|symbolic| factorise(&symbolic, &complement, 0.0, factor.pivots));
        self.call.meet(done)
    }
}

/// The factor of a block of `W - sigma M`; nothing if it is not positive definite, and without pivots.
fn factorise(
    symbolic: &Symbolic,
    block: &Block,
    sigma: f64,
    pivots: bool,
) -> Result<Option<Factor>> {
    let shifted = Shifted::new(block.stiffness.view(), &block.mass);
    let values = shifted.values(sigma);
    match pivots {
        true => symbolic.indefinite(shifted.matrix(&values)).map(Some),
        false => symbolic.positive(shifted.matrix(&values)),
    }
}

impl Shifts for SpreadShifts<'_> {
    fn bytes(&self) -> usize {
        let interface: usize = self.touching.iter().map(|rows| rows.len() * rows.len()).sum();
        self.symbolic.bytes() + interface * size_of::<f64>()
    }

    fn positive(&self, sigma: f64) -> Result<Option<Box<dyn Inverse + '_>>> {
        let factor = self.factorise(sigma, false)?;
        Ok(factor.map(|factor| Box::new(factor) as Box<dyn Inverse>))
    }

    fn indefinite(&self, sigma: f64) -> Result<Box<dyn Inverse + '_>> {
        let factor = self.factorise(sigma, true)?;
        Ok(Box::new(factor.expect("pivots allow for any matrix")))
    }
}

/// What each rank has of a factorisation.
struct SpreadFactor<'s> {
    shifts: &'s SpreadShifts<'s>,
    inner: Factor,
    /// `A_si` and `A_is`.
    coupling: CsMat<f64>,
    transposed: CsMat<f64>,
    /// Nothing if a domain's matrix is singular.
    interface: Option<Factor>,
    below_zero: usize,
    pivots: bool,
}

impl SpreadFactor<'_> {
    /// The lower triangle of `A_si A_ii^-1 A_is` by columns.
    fn complement(&self, par: Par) -> Result<Vec<f64>> {
        let (touching, len) = self.coupling.shape();
        let mut triangle = reserved(touching * (touching + 1) / 2)?;
        let mut solved = zeros(len, COLUMNS.min(touching))?;
        let mut product = zeros(touching, COLUMNS.min(touching))?;
        for first in (0..touching).step_by(COLUMNS) {
            let width = COLUMNS.min(touching - first);
            let mut solved = solved.as_mut().subcols_mut(0, width);
            solved.fill(0.0);
            for j in 0..width {
                let column = self.coupling.outer_view(first + j).expect("a row of the coupling");
                column.iter().for_each(|(i, &x)| solved[(i, j)] = x);
            }
            self.inner.solve(solved.rb_mut(), par)?;
            let mut product = product.as_mut().subcols_mut(0, width);
            multiply(self.coupling.view(), solved.as_ref(), product.rb_mut(), par)?;
            for j in 0..width {
                triangle.extend(
                    product.as_ref().col(j).subrows(first + j, touching - first - j).iter(),
                );
            }
        }
        Ok(triangle)
    }

    /// The rows of X in the own domain, of those that all ranks have.
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

    /// The inverse of [`SpreadFactor::collect`].
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

    /// Rows of the own domain.
    fn inner_len(&self) -> usize {
        self.transposed.rows()
    }
}

impl Inverse for SpreadFactor<'_> {
    /// With `b` for X: `x_s = S^-1 (b_s - sum of A_si A_ii^-1 b_i)`, `x_i = A_ii^-1 (b_i - A_is x_s)`.
    fn solve(&self, mut x: MatMut<'_, f64>, par: Par) -> Result<()> {
        let SpreadShifts { call, touching, own_interface, rank, interface, .. } = self.shifts;
        let (touching, width) = (&touching[*rank], x.ncols());
        let mut inner = self.collect(x.as_ref())?;
        let own = (|| {
            let mut solved = inner.clone();
            self.inner.solve(solved.as_mut(), par)?;
            let mut product = zeros(touching.len(), width)?;
            multiply(self.coupling.view(), solved.as_ref(), product.as_mut(), par)?;
            let mut right = zeros(interface.stiffness.rows(), width)?;
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

/// The places of some rows in an ascending list of them.
struct Places {
    place: Vec<Option<usize>>,
    len: usize,
}

impl Places {
    /// Of n rows.
    fn new(n: usize, rows: &[usize]) -> Self {
        let mut place = vec![None; n];
        rows.iter().enumerate().for_each(|(p, &i)| place[i] = Some(p));
        Self { place, len: rows.len() }
    }

    /// The places that these rows of the matrices have entries in, ascending.
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

    /// These rows of a matrix, with the columns that have places.
    fn select(&self, matrix: CsMatView<'_, f64>, rows: &[usize]) -> CsMat<f64> {
        let (mut starts, mut columns, mut entries) = (vec![0], vec![], vec![]);
        for &i in rows {
            let row = matrix.outer_view(i).expect("a row of the matrix");
            for (j, &x) in row.iter() {
                if let Some(place) = self.place[j] {
                    columns.push(place);
                    entries.push(x);
                }
            }
            starts.push(columns.len());
        }
        CsMat::new((rows.len(), self.len), starts, columns, entries)
    }

    /// The mass of these rows, which are those that have places.
    fn select_mass(&self, mass: &Mass, rows: &[usize]) -> Mass {
        match mass {
            Mass::Lumped(masses) => Mass::Lumped(rows.iter().map(|&i| masses[i]).collect()),
            Mass::Full(matrix) => Mass::Full(self.select(matrix.view(), rows)),
        }
    }
}
