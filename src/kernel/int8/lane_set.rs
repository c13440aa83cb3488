//! The kinds of vectors of a machine.

use super::lanes::{OnLanes, PortableLanes};
#[cfg(target_arch = "x86_64")]
use super::lanes_avx2::Avx2Lanes;
#[cfg(target_arch = "x86_64")]
use super::lanes_avx512::Avx512Lanes;

/// A kind of vectors that this CPU has.
#[derive(Clone, Copy)]
pub(crate) enum LaneSet {
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512Lanes),
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2Lanes),
    Portable,
}

impl LaneSet {
    /// Runs `work`, compiled for these vectors.
    #[inline]
    pub fn run<W: OnLanes>(self, work: W) -> W::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(lanes) => lanes.run(work),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(lanes) => lanes.run(work),
            Self::Portable => work.run(PortableLanes),
        }
    }
}
