//! Sparse Cholesky factorizations, with errors when memory is refused, and solves.

mod border;
mod coarse;
mod dissection;
mod graph;
mod halves;
mod limits;
mod lower;
mod minimum;
mod numeric;
mod options;
mod parts;
mod pattern;
mod postorder;
#[cfg(any(feature = "mpi", test))]
mod shares;
mod solver;
mod structure;
mod supernode;
mod sweeps;

use faer::MatMut;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

use super::space::Inverse;
use crate::base::{Par, Progress, Result, reserved, room};
use dissection::dissected;
use graph::{Graph, Lists};
use minimum::minimum_degree;
use numeric::Pivots;
pub use options::{CholeskyOptions, Triangle};
use pattern::{Entries, Pattern};
use postorder::postordered;
#[cfg(feature = "mpi")]
pub(crate) use shares::{paired, separator, shared};
pub use solver::Cholesky;
use structure::Structure;
use supernode::{Block, Row};
use sweeps::Sweeps;

/// The order of elimination and the pattern of the factor. All matrices with the same pattern share
/// it.
///
/// The order is that of approximate minimum degree, for large matrices of the parts that nested
/// dissection finds and then of the rows between them (docs/decisions/0007), or one that is given.
/// The last rows may be a border: columns that are not eliminated.
#[derive(Debug)]
pub struct Symbolic {
    pattern: Pattern,
    entries: Entries,
    /// The row of the matrix for each row of the factor.
    order: Vec<usize>,
}

impl Symbolic {
    /// Analyses matrices with this pattern in the lower triangle; entries above the diagonal are
    /// ignored.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](crate::Error::OutOfMemory) when memory is refused, and
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub fn new(places: SymbolicSparseColMatRef<'_, usize>) -> Result<Self> {
        let graph = Graph::new(places)?;
        let stages = dissected(&graph)?;
        let groups = minimum_degree(&graph, stages.as_ref())?;
        Self::of(places, &graph, &groups)
    }

    /// Analyses as [`Symbolic::new`] does for factorizations that end before the last `border`
    /// rows. Entries in the columns of the border are ignored. [`Symbolic::complement`] is what
    /// these factorizations leave of it.
    ///
    /// # Errors
    /// Those of [`Symbolic::new`].
    pub fn bordered(places: SymbolicSparseColMatRef<'_, usize>, border: usize) -> Result<Self> {
        if border == 0 {
            return Self::new(places);
        }
        let graph = Graph::new(places)?;
        let (n, first) = (graph.n() as u32, (graph.n() - border) as u32);
        let mut stages = match dissected(&graph.first(first as usize)?)? {
            Some(stages) => stages,
            None => Lists { starts: vec![0, first], items: (0..first).collect() },
        };
        stages.items.extend(first..n);
        stages.starts.push(n);
        let all = minimum_degree(&graph, Some(&stages))?;
        // Vertices of very high degree may be in one group with those of the border.
        let mut groups = Lists { starts: vec![0], items: reserved(first as usize)? };
        for k in 0..all.len() {
            groups.items.extend(all.of(k).iter().filter(|&&v| v < first));
            let end = groups.items.len() as u32;
            if groups.starts.last() != Some(&end) {
                groups.starts.push(end);
            }
        }
        Self::of(places, &graph, &groups)
    }

    /// Analyses as [`Symbolic::new`] does, with a permutation of the rows as the order of
    /// elimination, up to the order of subtrees that do not depend on each other.
    fn in_order(places: SymbolicSparseColMatRef<'_, usize>, order: &[usize]) -> Result<Self> {
        let mut rows = reserved(order.len())?;
        rows.extend(postordered(places, order)?.into_iter().map(|row| row as u32));
        Self::of(places, &Graph::new(places)?, &Lists::singles(rows)?)
    }

    /// Analyses with groups of rows that are eliminated one after another. Rows in no group, which
    /// are the last ones, are the border.
    fn of(
        places: SymbolicSparseColMatRef<'_, usize>,
        graph: &Graph,
        groups: &Lists,
    ) -> Result<Self> {
        let mut structure = Structure::new(graph, groups)?;
        let border = structure.order.len() as u32..graph.n() as u32;
        room(&mut structure.order, border.len())?;
        structure.order.extend(border);
        let pattern = Pattern::new(&structure)?;
        let mut order = reserved(structure.order.len())?;
        order.extend(structure.order.iter().map(|&row| row as usize));
        Ok(Self { entries: Entries::new(places, &order)?, pattern, order })
    }

    /// Returns about how many bytes a factor takes, with the pattern and the rows of right-hand
    /// sides it keeps.
    pub fn bytes(&self) -> usize {
        let targets = 2 * size_of::<u32>() * self.pattern.all_below();
        let rows = self.pattern.n * size_of::<Row>();
        self.pattern.values * size_of::<f64>() + targets + rows + self.entries.bytes()
    }

    /// Factorizes `A = L L^T` on the calling thread; returns `Ok(None)` when A is not positive
    /// definite.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](crate::Error::OutOfMemory) when memory is refused, and
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub fn positive(&self, a: SparseColMatRef<'_, usize, f64>) -> Result<Option<Factor>> {
        let (pattern, entries, memory) = (&self.pattern, &self.entries, Vec::new());
        let (par, progress) = (Par::Seq, Progress::none());
        let found = numeric::positive(pattern, entries, a.val(), memory, None, par, progress)?;
        let Ok(values) = found else { return Ok(None) };
        let sweeps = Sweeps::new(&self.pattern, |i| self.order[i], |i| i)?;
        let (subdiagonal, below_zero, is_singular) = (None, 0, false);
        Ok(Some(Factor { values, subdiagonal, below_zero, is_singular, sweeps }))
    }

    /// Factorizes `A = L B L^T` on the calling thread, where B has blocks of one or two rows and
    /// pivots are chosen inside supernodes.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](crate::Error::OutOfMemory) when memory is refused, and
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub fn indefinite(&self, a: SparseColMatRef<'_, usize, f64>) -> Result<Factor> {
        let (values, pivots) = numeric::indefinite(&self.pattern, &self.entries, a.val())?;
        let Pivots { subdiagonal, forward, inverse } = pivots;
        let sweeps = Sweeps::new(&self.pattern, |i| self.order[forward[i]], |i| inverse[i])?;
        let below_zero = sweeps.blocks(&values, &subdiagonal).map(Block::negative).sum();
        let is_singular = sweeps.blocks(&values, &subdiagonal).any(Block::is_singular);
        let subdiagonal = Some(subdiagonal);
        Ok(Factor { values, subdiagonal, below_zero, is_singular, sweeps })
    }

    /// Computes what a factorization adds to the block of the border: with that block zero, its
    /// Schur complement, `-A_bi A_ii^-1 A_ib` for the rows b of the border and i of the factor.
    /// Stored by columns, of which the entries from the diagonal down are computed.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](crate::Error::OutOfMemory) when memory is refused, and
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub fn complement(&self, factor: &Factor) -> Result<Vec<f64>> {
        border::complement(&self.pattern, &factor.values, factor.subdiagonal.as_deref())
    }
}

/// A factor of a symmetric matrix.
#[derive(Debug)]
pub struct Factor {
    values: Vec<f64>,
    /// For an indefinite matrix: the entries of B below its diagonal.
    subdiagonal: Option<Vec<f64>>,
    below_zero: usize,
    /// Whether a pivot is 0. Without rows below it, no value shows that.
    is_singular: bool,
    sweeps: Sweeps,
}

impl Factor {
    /// Solves with a factorization that ended before a border: `between` gets `-A_bi A_ii^-1 x_i`,
    /// eight columns at a time, of which those beyond the columns of X have no meaning, and puts
    /// the solution there; then X becomes `A_ii^-1 (x_i - A_ib x_b)`. The same for every `par`, bit
    /// for bit.
    ///
    /// # Errors
    /// Those of `between`, [`Error::OutOfMemory`](crate::Error::OutOfMemory) and
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub fn solve_around(
        &self,
        x: MatMut<'_, f64>,
        between: &mut dyn FnMut(usize, &mut [Row]) -> Result<()>,
        par: Par,
    ) -> Result<()> {
        self.sweeps.solve_around(&self.values, self.subdiagonal.as_deref(), x, between, par)
    }
}

impl Inverse for Factor {
    fn solve(&self, x: MatMut<'_, f64>, par: Par) -> Result<()> {
        self.sweeps.solve(&self.values, self.subdiagonal.as_deref(), x, par)
    }

    /// Returns the number of negative eigenvalues of B.
    fn below_zero(&self) -> usize {
        self.below_zero
    }

    fn is_positive(&self) -> bool {
        self.subdiagonal.is_none()
    }

    fn is_finite(&self) -> bool {
        !self.is_singular && self.values.iter().all(|x| x.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;
    use sprs::{CsMat, TriMat};

    use super::*;
    use crate::base::Rng;
    use crate::sparse::Mass;
    use crate::sparse::path::path;
    use crate::sparse::shifted::Shifted;

    #[test]
    fn inertia_counts_the_eigenvalues_below_a_shift() {
        for n in [2, 3, 17, 200] {
            let (w, mass) = (path(n), Mass::identity(n));
            let shifted = Shifted::new(w.view(), &mass);
            let symbolic = Symbolic::new(shifted.symbolic()).unwrap();
            let value = |i: usize| 2.0 - 2.0 * (std::f64::consts::PI * i as f64 / n as f64).cos();
            for i in (0..n).step_by(1 + n / 9) {
                let shift = if i == 0 { -0.1 } else { 0.5 * (value(i - 1) + value(i)) };
                let factor = symbolic.indefinite(shifted.matrix(&shifted.values(shift))).unwrap();
                assert_eq!(factor.below_zero(), i, "n = {n}");
            }
            assert!(
                symbolic
                    .positive(shifted.matrix(&shifted.values(0.5 * value(1))))
                    .unwrap()
                    .is_none()
            );
        }
    }

    #[test]
    fn a_shift_that_is_an_eigenvalue_leaves_no_finite_factor() {
        for n in [4, 5, 200] {
            let mut entries = TriMat::new((n, n));
            (0..n).for_each(|i| entries.add_triplet(i, i, i as f64));
            let (w, mass): (CsMat<f64>, Mass) = (entries.to_csr(), Mass::identity(n));
            let shifted = Shifted::new(w.view(), &mass);
            let symbolic = Symbolic::new(shifted.symbolic()).unwrap();
            let factor =
                |shift| symbolic.indefinite(shifted.matrix(&shifted.values(shift))).unwrap();
            assert!(!factor(3.0).is_finite(), "n = {n}");
            let beside = factor(2.5);
            assert!(beside.is_finite() && beside.below_zero() == 3, "n = {n}");
        }
    }

    /// Returns symmetric matrices (n x n) with their names, some of them with eigenvalues on both
    /// sides of zero.
    fn matrices() -> Vec<(&'static str, CsMat<f64>)> {
        let of = |n: usize, entry: &dyn Fn(usize, usize) -> f64| {
            let mut entries = TriMat::new((n, n));
            for i in 0..n {
                for j in (0..n).filter(|&j| i == j || entry(i, j) != 0.0) {
                    entries.add_triplet(i, j, entry(i, j));
                }
            }
            entries.to_csr()
        };
        let side = 31;
        let near =
            move |i: usize, j: usize| (i / side).abs_diff(j / side) + (i % side).abs_diff(j % side);
        vec![
            ("no rows", of(0, &|_, _| 0.0)),
            ("one row", of(1, &|_, _| 3.0)),
            ("diagonal", of(7, &|i, j| if i == j { 1.0 + i as f64 } else { 0.0 })),
            ("path", of(150, &|i, j| [2.1, -1.0, 0.0][i.abs_diff(j).min(2)])),
            ("full", of(43, &|i, j| if i == j { 50.0 } else { ((i * j) % 5) as f64 - 2.0 })),
            ("grid", of(side * side, &|i, j| [4.5, -1.0, 0.0][near(i, j).min(2)])),
            // Its diagonal is zero: only blocks of two rows can be pivots.
            ("pairs", of(12, &|i, j| if i / 2 == j / 2 && i != j { 2.0 } else { 0.0 })),
            ("grid, indefinite", of(side * side, &|i, j| [1.3, -1.0, 0.0][near(i, j).min(2)])),
        ]
    }

    #[test]
    fn both_factorizations_solve_for_any_number_of_columns_threads_and_strides() {
        let mut rng = Rng::new(2);
        for (name, a) in matrices() {
            let n = a.rows();
            let (w, mass) = (a.view(), Mass::identity(n));
            let shifted = Shifted::new(w, &mass);
            let symbolic = Symbolic::new(shifted.symbolic()).unwrap();
            let entries = shifted.values(0.0);
            let positive = symbolic.positive(shifted.matrix(&entries)).unwrap();
            assert_eq!(positive.is_none(), ["pairs", "grid, indefinite"].contains(&name), "{name}");
            let indefinite = symbolic.indefinite(shifted.matrix(&entries)).unwrap();
            for mut factor in positive.into_iter().chain([indefinite]) {
                for columns in [0, 1, 3, 8, 9, 17] {
                    let x = Mat::from_fn(n, columns, |_, _| rng.uniform());
                    let mut right = Mat::zeros(n, columns);
                    crate::sparse::multiply(w, x.as_ref(), right.as_mut(), Par::Seq).unwrap();
                    let solve = |factor: &Factor, par| {
                        let mut solved = right.clone();
                        factor.solve(solved.as_mut(), par).unwrap();
                        solved
                    };
                    let solved = solve(&factor, Par::Seq);
                    assert!((&solved - &x).norm_max() < 1e-10, "{name}, {columns} columns");
                    assert_eq!(solved, solve(&factor, Par::Threads(3)), "{name}");
                    let mut by_rows = right.transpose().to_owned();
                    factor.solve(by_rows.as_mut().transpose_mut(), Par::Threads(2)).unwrap();
                    assert_eq!(solved, by_rows.transpose(), "{name}");
                    factor.sweeps.fused ^= true;
                    assert!((solve(&factor, Par::Seq) - &x).norm_max() < 1e-10, "{name}");
                    factor.sweeps.fused ^= true;
                }
            }
        }
    }

    #[test]
    fn a_border_gets_its_schur_complement_and_gives_the_rest_its_solution() {
        let mut rng = Rng::new(3);
        let mut checked = 0;
        for (name, a) in matrices() {
            let n = a.rows();
            for border in [1, n / 5, n / 2].into_iter().filter(|border| *border < n) {
                let inner = n - border;
                let mut entries = TriMat::new((n, n));
                for (&x, (i, j)) in a.iter().filter(|(_, (i, _))| *i < inner) {
                    entries.add_triplet(i, j, x);
                }
                let w: CsMat<f64> = entries.to_csr();
                let mass = Mass::Lumped((0..n).map(|i| f64::from(i < inner)).collect());
                let shifted = Shifted::new(w.view(), &mass);
                let symbolic = Symbolic::bordered(shifted.symbolic(), border).unwrap();
                let values = shifted.values(0.0);
                let positive = symbolic.positive(shifted.matrix(&values)).unwrap();
                let indefinite = symbolic.indefinite(shifted.matrix(&values)).unwrap();
                // Cut in two, the pairs leave a row of zeros.
                let factors = positive.into_iter().chain([indefinite]);
                for factor in factors.filter(Factor::is_finite) {
                    let complement = symbolic.complement(&factor).unwrap();
                    let schur = |t: usize, u: usize| {
                        let added = complement[t.max(u) + t.min(u) * border];
                        added + a.get(inner + t, inner + u).copied().unwrap_or(0.0)
                    };
                    let columns = 11;
                    let x = Mat::from_fn(n, columns, |_, _| rng.uniform());
                    let mut right = Mat::zeros(n, columns);
                    crate::sparse::multiply(a.view(), x.as_ref(), right.as_mut(), Par::Seq)
                        .unwrap();
                    let mut solved = right.clone();
                    let mut first = 0;
                    let mut between = |width: usize, rows: &mut [Row]| -> Result<()> {
                        assert_eq!(rows.len(), border, "{name}");
                        for (t, row) in rows.iter_mut().enumerate() {
                            for (j, value) in row[..width].iter_mut().enumerate() {
                                let j = first + j;
                                let product: f64 =
                                    (0..border).map(|u| schur(t, u) * x[(inner + u, j)]).sum();
                                let found = right[(inner + t, j)] + *value;
                                assert!((found - product).abs() < 1e-8, "{name}, {border}");
                                *value = x[(inner + t, j)];
                            }
                        }
                        first += width;
                        Ok(())
                    };
                    let rows = solved.as_mut().subrows_mut(0, inner);
                    factor.solve_around(rows, &mut between, Par::Threads(2)).unwrap();
                    let change = &solved - &x;
                    let largest = change.subrows(0, inner).norm_max();
                    assert!(largest < 1e-8, "{name}, {border}: {largest:e}");
                    checked += 1;
                }
            }
        }
        assert!(checked > 25, "{checked}");
    }
}
