use std::collections::HashSet;

use super::problem::Op;
use crate::base::steps::step;
use crate::product::schemes::SchemeId;

/// How blocks are divided: at each node by the first scheme whose blocks are not too small.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Recursion {
    /// For products of which the lower triangle is wanted, in order of preference.
    pub symmetric: Vec<SchemeId>,
    /// For general products, in order of preference.
    pub general: Vec<SchemeId>,
    /// Where the recursion ends.
    pub base: Base,
    /// Most levels of schemes with additions.
    pub fast_levels: usize,
}

/// When a block is left to the back end: when the next level's blocks would have a side shorter
/// than this (>= 1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Base {
    /// For general products.
    pub general: usize,
    /// For products of which the lower triangle is wanted: back ends need longer sides to be fast
    /// at those.
    pub symmetric: usize,
}

impl Base {
    /// Creates a base with the same side for general and symmetric products.
    pub fn side(side: usize) -> Self {
        Self { general: side, symmetric: side }
    }
}

impl Recursion {
    /// Creates a recursion without levels.
    pub fn none() -> Self {
        Self { symmetric: vec![], general: vec![], base: Base::side(1), fast_levels: 0 }
    }

    /// Returns the scheme for a node with A m x n and B m x k, or `None` for the back end.
    pub fn choose(
        &self,
        symmetric: bool,
        m: usize,
        n: usize,
        k: usize,
        fast_levels: usize,
    ) -> Option<SchemeId> {
        let Base { general, symmetric: of_triangles } = self.base;
        let side = if symmetric { of_triangles } else { general }.max(1);
        let list = if symmetric { &self.symmetric } else { &self.general };
        list.iter().copied().find(|id| {
            let s = id.scheme();
            (fast_levels > 0 || !s.is_fast())
                // Parts of split rows must be long; not splitting them is always allowed.
                && (s.inner == 1 || m / s.inner >= side)
                && n / s.left >= side
                && k / s.right >= side
        })
    }

    /// Returns the recursion with a base so long that at most about a thousand triangles are left
    /// of a triangle of side `n`, because they are all listed in the plan of fused products.
    pub fn of_few_triangles(mut self, n: usize) -> Self {
        const MOST: usize = 1024;
        self.base.symmetric = self.base.symmetric.max(n / MOST);
        self
    }

    /// Returns whether a node of this shape leads to a scheme with additions.
    pub fn is_fast(&self, op: Op, m: usize, n: usize, k: usize) -> bool {
        self.fast_levels > 0 && self.leads_to_fast(op, [m, n, k], &mut HashSet::new())
    }

    /// Returns [`Recursion::is_fast`]; `slow` has nodes that are known not to be.
    fn leads_to_fast(
        &self,
        op: Op,
        shape: [usize; 3],
        slow: &mut HashSet<(Op, [usize; 3])>,
    ) -> bool {
        let [m, n, k] = shape;
        let Some(id) = self.choose(op.symmetric(), m, n, k, self.fast_levels) else {
            return false;
        };
        let s = id.scheme();
        if s.is_fast() {
            return true;
        }
        step();
        if !slow.insert((op, shape)) {
            return false;
        }
        let below = [m.div_ceil(s.inner), n.div_ceil(s.left), k.div_ceil(s.right)];
        s.products.iter().any(|p| self.leads_to_fast(op.of_product(p.kind), below, slow))
    }
}
