//! Gaussian elimination on a tree, from the leaves to the root: without fill-in and, because the
//! diagonal is stored as its excess over the couplings, without subtraction (Hines 1984; Grassmann,
//! Taksar and Heyman 1985 for the excess).
//!
//! For every node v with parent u, coupling `w_v >= 0` and excess `d_v >= 0` the matrix has `-w_v`
//! at (u, v) and (v, u), and on the diagonal `d_v` plus the couplings of all edges at v. Real and
//! complex excesses share this code.

use std::ops::{Add, Mul, Range};

use faer::c64;

use super::super::graph::{NONE, Plant};
use catamaran::base::{Par, Result, reserved};
use catamaran_geometry::mesh::Adjacency;

/// Number of nodes of a unit of work, and of the largest subtree that one thread eliminates alone.
/// It does not change results.
const BIN: usize = 8192;

impl Factor<f64> {
    /// Returns whether a pivot is 0, as for a part of the tree without any excess.
    pub fn is_singular(&self) -> bool {
        self.inverses.iter().any(|i| !i.is_finite())
    }
}

/// The arithmetic of elimination.
pub(crate) trait Number:
    Copy + Send + Sync + Add<Output = Self> + Mul<Output = Self> + Mul<f64, Output = Self>
{
    const ZERO: Self;
    /// Returns the reciprocal.
    fn reciprocal(self) -> Self;
    /// Returns the sum with a real number.
    fn plus(self, real: f64) -> Self;
}

impl Number for f64 {
    const ZERO: Self = 0.0;

    fn reciprocal(self) -> Self {
        1.0 / self
    }

    fn plus(self, real: f64) -> Self {
        self + real
    }
}

impl Number for c64 {
    const ZERO: Self = Self::new(0.0, 0.0);

    fn reciprocal(self) -> Self {
        let scale = 1.0 / (self.re * self.re + self.im * self.im);
        Self::new(self.re * scale, -self.im * scale)
    }

    fn plus(self, real: f64) -> Self {
        Self::new(self.re + real, self.im)
    }
}

/// The order of elimination, reversed: first the trunk, which consists of the nodes whose subtrees
/// have more than [`BIN`] nodes, then bins of whole subtrees. Positions and the arrays of the
/// functions below follow this order.
#[derive(Debug, Clone)]
pub(crate) struct Order {
    /// The node at each position.
    nodes: Vec<u32>,
    /// The position of each node.
    positions: Vec<u32>,
    /// The position of the parent, always a lower one, or [`NONE`].
    parents: Vec<u32>,
    /// Number of nodes of the trunk.
    trunk: usize,
    /// The start of each bin, and the end of the last one.
    bins: Vec<usize>,
    /// The children of the nodes of the trunk, last ones first.
    children: Adjacency,
}

impl Order {
    /// Computes the order of elimination of a plant.
    pub fn new(plant: &Plant) -> Self {
        Self::with_bins(plant, BIN)
    }

    fn with_bins(plant: &Plant, bin: usize) -> Self {
        let n = plant.len();
        let preorder = plant.preorder();
        let mut sizes = vec![1_u32; n];
        for &v in preorder.iter().rev() {
            if let Some(p) = plant.parent(v as usize) {
                sizes[p] += sizes[v as usize];
            }
        }
        let in_trunk = |v: &u32| sizes[*v as usize] as usize > bin;
        let mut nodes: Vec<u32> = preorder.iter().copied().filter(in_trunk).collect();
        let trunk = nodes.len();
        nodes.extend(preorder.iter().copied().filter(|v| !in_trunk(v)));
        let mut positions = vec![0; n];
        for (k, &v) in nodes.iter().enumerate() {
            positions[v as usize] = k as u32;
        }
        let position_of = |p: u32| if p == NONE { NONE } else { positions[p as usize] };
        let parents: Vec<u32> =
            nodes.iter().map(|&v| position_of(plant.parents()[v as usize])).collect();
        // Subtrees are contiguous in preorder; consecutive ones are joined into a bin as far as
        // they fit.
        let mut bins = vec![trunk];
        let (mut k, mut begin) = (trunk, trunk);
        while k < n {
            let size = sizes[nodes[k] as usize] as usize;
            if k + size - begin > bin {
                bins.push(k);
                begin = k;
            }
            k += size;
        }
        if n > trunk {
            bins.push(n);
        }
        // In the order in which a bin visits children, so that sums do not depend on where the
        // trunk ends.
        let of_trunk = || {
            let pairs = positions.iter().rev().map(|&k| (parents[k as usize], k));
            pairs.filter(|&(parent, _)| (parent as usize) < trunk)
        };
        let children = Adjacency::from_pairs(trunk, of_trunk);
        Self { nodes, positions, parents, trunk, bins, children }
    }

    /// Returns the number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Returns the position of the parent of the node at position k.
    pub fn parent(&self, k: usize) -> Option<usize> {
        Some(self.parents[k]).filter(|&p| p != NONE).map(|p| p as usize)
    }

    /// Returns the position of a node.
    pub fn position(&self, node: usize) -> usize {
        self.positions[node] as usize
    }

    /// Returns the values at positions in the order of nodes.
    pub fn by_nodes<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.positions.iter().map(|&k| values[k as usize]).collect()
    }

    /// Returns the values of nodes in the order of positions.
    pub fn by_positions<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.nodes.iter().map(|&v| values[v as usize]).collect()
    }

    fn bin(&self, i: usize) -> Range<usize> {
        self.bins[i]..self.bins[i + 1]
    }

    /// Returns the parts of an array: the part of the trunk, and those of the bins.
    pub fn split<'a, T>(&self, array: &'a mut [T]) -> (&'a mut [T], Vec<&'a mut [T]>) {
        let (trunk, mut rest) = array.split_at_mut(self.trunk);
        let mut parts = Vec::with_capacity(self.bins.len());
        for ends in self.bins.windows(2) {
            let (part, tail) = rest.split_at_mut(ends[1] - ends[0]);
            parts.push(part);
            rest = tail;
        }
        (trunk, parts)
    }

    /// Calls `work(positions, item)` for every bin and its item.
    pub fn for_bins<W: Send>(
        &self,
        par: Par,
        items: impl Iterator<Item = W>,
        work: impl Fn(Range<usize>, W) + Sync,
    ) {
        let par = if self.bins.len() <= 2 { Par::Seq } else { par };
        par.for_each(items, |i, item| work(self.bin(i), item));
    }
}

/// A factorized matrix, and memory for further matrices of the same tree.
#[derive(Debug, Clone)]
pub(crate) struct Factor<T> {
    /// `w / (d + w)` of every position.
    fractions: Vec<T>,
    /// `1 / (d + w)`.
    inverses: Vec<T>,
    /// The excesses during their summation.
    excess: Vec<T>,
}

impl<T: Number> Factor<T> {
    /// Allocates memory for `order.len()` nodes.
    pub fn new(order: &Order) -> Result<Self> {
        let n = order.len();
        Ok(Self { fractions: filled(n)?, inverses: filled(n)?, excess: filled(n)? })
    }

    /// Factorizes the matrix with couplings `scale * w`, whose excesses `fill(positions, excesses)`
    /// writes.
    pub fn refactor(
        &mut self,
        order: &Order,
        fill: impl Fn(Range<usize>, &mut [T]) + Sync,
        couplings: &[f64],
        scale: f64,
        par: Par,
    ) {
        let Self { fractions, inverses, excess } = self;
        let eliminate = |d: T, w: f64| {
            let w = w * scale;
            let inverse = d.plus(w).reciprocal();
            (inverse * w, inverse)
        };
        let [d, f, i] = [&mut *excess, fractions, inverses].map(|a| order.split(a).1.into_iter());
        order.for_bins(par, d.zip(f.zip(i)), |range, (d, (fractions, inverses))| {
            fill(range.clone(), d);
            let parents = &order.parents[range.clone()];
            let couplings = &couplings[range.clone()];
            for k in (0..d.len()).rev() {
                let (fraction, inverse) = eliminate(d[k], couplings[k]);
                (fractions[k], inverses[k]) = (fraction, inverse);
                let up = d[k] * fraction;
                // A parent in the trunk, or none, is outside of the bin.
                match d.get_mut((parents[k] as usize).wrapping_sub(range.start)) {
                    Some(parent) => *parent = *parent + up,
                    None => d[k] = up,
                }
            }
        });
        fill(0..order.trunk, &mut excess[..order.trunk]);
        for k in (0..order.trunk).rev() {
            let mut d = excess[k];
            for &c in order.children.row(k) {
                d = d + excess[c as usize];
            }
            (fractions[k], inverses[k]) = eliminate(d, couplings[k]);
            excess[k] = d * fractions[k];
        }
    }

    /// Solves the equations into `x`, into which `fill(positions, values)` writes the right-hand
    /// side.
    pub fn solve(
        &self,
        order: &Order,
        fill: impl Fn(Range<usize>, &mut [T]) + Sync,
        x: &mut [T],
        par: Par,
    ) {
        order.for_bins(par, order.split(x).1.into_iter(), |range, b| {
            fill(range.clone(), b);
            self.up(order, range, b);
        });
        fill(0..order.trunk, &mut x[..order.trunk]);
        self.trunk(order, x);
        let (trunk, parts) = order.split(x);
        let trunk = &*trunk;
        order.for_bins(par, parts.into_iter(), |range, b| self.down(order, range, trunk, b));
    }

    /// Eliminates towards the root within a bin.
    fn up(&self, order: &Order, range: Range<usize>, b: &mut [T]) {
        let parents = &order.parents[range.clone()];
        let fractions = &self.fractions[range.clone()];
        for k in (0..fractions.len()).rev() {
            let up = b[k] * fractions[k];
            if let Some(parent) = b.get_mut((parents[k] as usize).wrapping_sub(range.start)) {
                *parent = *parent + up;
            }
        }
    }

    /// Eliminates towards the root and substitutes back in the trunk, after all bins.
    fn trunk(&self, order: &Order, b: &mut [T]) {
        for k in (0..order.trunk).rev() {
            let mut sum = b[k];
            for &c in order.children.row(k) {
                sum = sum + b[c as usize] * self.fractions[c as usize];
            }
            b[k] = sum;
        }
        for k in 0..order.trunk {
            let x = b[k] * self.inverses[k];
            b[k] = match order.parent(k) {
                Some(p) => x + b[p] * self.fractions[k],
                None => x,
            };
        }
    }

    /// Substitutes back towards the leaves within a bin.
    fn down(&self, order: &Order, range: Range<usize>, trunk: &[T], b: &mut [T]) {
        let parents = &order.parents[range.clone()];
        let (fractions, inverses) = (&self.fractions[range.clone()], &self.inverses[range.clone()]);
        for k in 0..fractions.len() {
            let x = b[k] * inverses[k];
            let p = parents[k] as usize;
            let above = match b.get(p.wrapping_sub(range.start)) {
                Some(&above) => above,
                None if p < trunk.len() => trunk[p],
                None => {
                    b[k] = x;
                    continue;
                }
            };
            b[k] = x + above * fractions[k];
        }
    }
}

fn filled<T: Number>(n: usize) -> Result<Vec<T>> {
    let mut values = reserved(n)?;
    values.resize(n, T::ZERO);
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::families::{GrowthOptions, grow};
    use catamaran::base::Rng;

    /// Returns the product of the matrix with x, node by node.
    fn product(order: &Order, excess: &[f64], couplings: &[f64], x: &[f64]) -> Vec<f64> {
        let mut b: Vec<f64> = (0..x.len()).map(|k| excess[k] * x[k]).collect();
        for k in 0..x.len() {
            if let Some(p) = order.parent(k) {
                let flow = couplings[k] * (x[k] - x[p]);
                b[k] += flow;
                b[p] -= flow;
            }
        }
        b
    }

    #[test]
    fn what_is_solved_is_what_was_multiplied_and_bins_and_threads_change_no_bit() {
        for n in [1, 2, 3, 17, 400] {
            let plant = grow(&GrowthOptions { nodes: n, ..GrowthOptions::default() }).unwrap();
            let mut rng = Rng::new(n as u64);
            let mut by_nodes = || (0..n).map(|_| rng.uniform() + 0.1).collect::<Vec<f64>>();
            let (d, w, b) = (by_nodes(), by_nodes(), by_nodes());
            let mut first: Option<Vec<f64>> = None;
            for (bin, par) in
                [(n, Par::Seq), (7, Par::Seq), (7, Par::Threads(3)), (1, Par::Threads(2))]
            {
                let order = Order::with_bins(&plant, bin);
                let [d, mut w, right] = [&d, &w, &b].map(|a| order.by_positions(a));
                w[order.position(plant.root())] = 0.0;
                let mut factor = Factor::new(&order).unwrap();
                factor.refactor(&order, |r, out| out.copy_from_slice(&d[r]), &w, 1.0, par);
                let mut x = vec![f64::NAN; n];
                factor.solve(&order, |r, out| out.copy_from_slice(&right[r]), &mut x, par);
                for (a, b) in product(&order, &d, &w, &x).iter().zip(&right) {
                    assert!((a - b).abs() < 1e-13 * n as f64, "{n} {bin}: {a} {b}");
                }
                let x = order.by_nodes(&x);
                assert_eq!(*first.get_or_insert(x.clone()), x, "{n} {bin}");
            }
        }
    }
}
