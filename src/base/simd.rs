//! Dispatch to the widest SIMD registers of this CPU at run time.

/// Calls `work`, an `#[inline(always)]` closure, compiled for the widest SIMD registers of this
/// CPU. Call this function once around a loop, not inside it.
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
    pulp::Arch::new().dispatch(Work(work))
}
