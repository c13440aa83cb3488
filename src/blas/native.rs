use crate::kernel::packed::{self, Isa, Operand, Shape, is_small};

/// The kernels of this crate, for one instruction set: one product at a time, on the calling thread.
///
/// [`ata`](mod@crate::ata) does not call them through [`Kernels`](super::Kernels), but uses all they can: threads that
/// share packed operands, and additions fused into packing and writing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Native {
    isa: Isa,
    rates: packed::Rates,
}

impl Native {
    /// For `isa`, or the portable one where this machine refuses that, with rates as measured.
    pub fn new(isa: Isa, rates: packed::Rates) -> Self {
        let usable = isa.refusal().is_none();
        Self { isa: if usable { isa } else { Isa::Portable }, rates }
    }

    /// The instruction set.
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// Their speed, as assumed.
    pub fn rates(&self) -> packed::Rates {
        self.rates
    }

    /// Whether a product is over before it could be planned: at most about 30 microseconds.
    #[inline]
    pub(crate) fn is_small<T: Operand>(&self, m: usize, n: usize, k: usize, same: bool) -> bool {
        is_small(Shape { depth: m, rows: n, cols: k, same })
    }
}
