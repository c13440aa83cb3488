//! Dispatch to the widest SIMD registers that this process may use, at run time.

use pulp::Arch;

use super::isa::IsaLevel;

/// Calls `work`, an `#[inline(always)]` closure, compiled for the widest SIMD registers of
/// [`arch`]. Call this function once around a loop, not inside it.
///
/// The bound is `FnOnce` on purpose: where `pulp` itself takes the closure, its body is first
/// inlined into a function of its own, compiled for the narrowest registers.
#[inline(always)]
pub(crate) fn widest<R>(work: impl FnOnce() -> R) -> R {
    struct Work<F>(F);

    impl<R, F: FnOnce() -> R> pulp::WithSimd for Work<F> {
        type Output = R;

        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, _: S) -> R {
            (self.0)()
        }
    }
    arch().dispatch(Work(work))
}

/// Returns the widest SIMD registers of this CPU that the limit of this process permits.
#[inline]
pub fn arch() -> Arch {
    const ALL: IsaLevel =
        if cfg!(target_arch = "aarch64") { IsaLevel::Neon } else { IsaLevel::Avx512 };
    if ALL.permitted().is_ok() {
        return Arch::new();
    }
    #[cfg(target_arch = "x86_64")]
    if IsaLevel::Avx2.permitted().is_ok()
        && let Some(simd) = pulp::x86::V3::try_new()
    {
        return Arch::V3(simd);
    }
    Arch::Scalar
}

/// Returns whether the registers of [`arch`] multiply and add at once; elsewhere a fused operation
/// would be a call of a function.
pub fn has_fused() -> bool {
    #[cfg(target_arch = "x86_64")]
    return !matches!(arch(), Arch::Scalar);
    #[cfg(not(target_arch = "x86_64"))]
    cfg!(target_arch = "aarch64")
}

#[cfg(test)]
mod tests {
    #[test]
    #[cfg(target_arch = "x86_64")]
    fn registers_are_those_of_the_limit() {
        use pulp::Arch;
        use pulp::x86::{V3, V4};

        use super::arch;
        use crate::base::{IsaLevel, isa_limit};

        let limit = isa_limit().unwrap();
        let expected = match (V4::try_new(), V3::try_new()) {
            (Some(_), _) if limit >= IsaLevel::Avx512 => 64,
            (_, Some(_)) if limit >= IsaLevel::Avx2 => 32,
            _ => 0,
        };
        let found = match arch() {
            Arch::V4(_) => 64,
            Arch::V3(_) => 32,
            _ => 0,
        };
        assert_eq!(found, expected);
    }
}
