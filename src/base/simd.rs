//! The widest registers there are, found at run time.

/// Calls `work`, an `#[inline(always)]` closure, with the widest registers there are: the loops
/// inside use them. Called once around a loop, not inside.
///
/// The bound makes the closure one that is called once: where `pulp` itself takes it, its body is
/// inlined into a function of its own first, for the narrowest registers.
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
