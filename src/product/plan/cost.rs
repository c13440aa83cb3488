//! Estimated costs of products, in seconds on one core, which decide between strategies. A wrong
//! estimate costs time, never correctness.

use std::collections::HashMap;

use super::fused::FusedProduct;
use super::problem::Op;
use super::recursion::Recursion;
use super::scratch::Traffic;
use crate::base::steps::step;
use crate::blas::Rates;
use crate::kernel::packed::{self, Blocking, Geometry, Shape};

/// The cost model of a recursion over a back end.
pub(super) struct RecursionCost {
    rates: Rates,
    scalar_bytes: f64,
    known: HashMap<(Op, [usize; 3], usize), f64>,
}

impl RecursionCost {
    /// Creates the model for scalars T at these rates.
    pub fn new<T>(rates: Rates) -> Self {
        Self { rates, scalar_bytes: size_of::<T>() as f64, known: HashMap::new() }
    }

    /// Returns the seconds of a product left to the back end.
    fn leaf(&self, op: Op, shape: [usize; 3]) -> f64 {
        let [m, n, k] = shape.map(|side| side.max(1) as f64);
        let Rates { gemm_flops, gemm_half_side, syrk_flops, syrk_half_side, .. } = self.rates;
        let seconds = match op {
            Op::Gemm => {
                2.0 * m * n * k / gemm_flops * (1.0 + gemm_half_side / n + gemm_half_side / k)
            }
            Op::Syrk | Op::Gemmt => m * n * n / syrk_flops * (1.0 + syrk_half_side / n),
        };
        // The rates are those of f64.
        seconds * self.scalar_bytes / 8.0
    }

    /// Estimates the seconds of `op` with A m x n and B m x k, where `shape` is m, n and k.
    pub fn seconds(&mut self, recursion: &Recursion, op: Op, shape: [usize; 3]) -> f64 {
        self.known.clear();
        self.node(recursion, op, shape, recursion.fast_levels)
    }

    fn node(&mut self, recursion: &Recursion, op: Op, shape: [usize; 3], levels: usize) -> f64 {
        let [m, n, k] = shape;
        let Some(id) = recursion.choose(op.symmetric(), m, n, k, levels) else {
            return self.leaf(op, shape);
        };
        step();
        if let Some(&known) = self.known.get(&(op, shape, levels)) {
            return known;
        }
        let scheme = id.scheme();
        let below = levels - usize::from(scheme.is_fast());
        let child = [m.div_ceil(scheme.inner), n.div_ceil(scheme.left), k.div_ceil(scheme.right)];
        let [cm, cn, ck] = child.map(|x| x as f64);
        let mut total = 0.0;
        for product in &scheme.products {
            total += self.node(recursion, op.of_product(product.kind), child, below);
        }
        let traffic = Traffic::of(scheme, op);
        let moved = traffic.p * cm * cn + traffic.q * cm * ck + traffic.m * cn * ck;
        total += moved * self.scalar_bytes / self.rates.add_bytes;
        self.known.insert((op, shape, levels), total);
        total
    }
}

/// The cost model of fused products.
pub(super) struct FusedCost {
    pub rates: packed::Rates,
    pub geometry: Geometry,
    pub scalar_bytes: usize,
    /// Scalars that packed operands may take.
    pub budget: usize,
    /// Whether only the lower triangle of C is computed.
    pub symmetric: bool,
}

impl FusedCost {
    /// Estimates the seconds of a product.
    pub fn product(&self, product: &FusedProduct) -> f64 {
        /// Share of the time for additions to C that products do not hide.
        const SEEN: f64 = 0.5;
        let Shape { depth, rows, cols, same } = product.shape;
        let blocking =
            Blocking::new(self.geometry, self.scalar_bytes, product.shape, self.budget, 1);
        let work = product.work(self.symmetric);
        let area = |b: &super::fused::SignedBlock| b.rows.len() as f64 * b.cols.len() as f64;
        let read: f64 = product.left.iter().chain(&product.right).map(area).sum();
        let packed = (rows + if same { 0 } else { cols }) as f64 * depth as f64;
        let entries = work / depth.max(1) as f64;
        let updates = product.outputs.len() * blocking.chunks(product.shape);
        let updated = 2.0 * updates as f64 * entries;
        // The rate of products is that of f64.
        self.scalar_bytes as f64
            * (work / 4.0 / self.rates.flops
                + read / self.rates.read_bytes
                + packed / self.rates.pack_bytes
                + SEEN * updated / self.rates.update_bytes)
    }
}
