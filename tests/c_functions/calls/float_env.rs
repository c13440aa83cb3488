//! The rounding mode in which a call is made, and the exceptions that it raises.

/// A mode of the calling thread, which a call keeps.
#[derive(Debug, Clone, Copy)]
pub struct FloatEnv {
    mode: i32,
    /// Whether neither an invalid operation nor a division by zero may be raised.
    quiet: bool,
}

#[cfg(target_arch = "x86_64")]
mod libm {
    // `fenv.h` of glibc.
    pub const MODES: [i32; 4] = [0, 0x400, 0x800, 0xc00];
    pub const INVALID: i32 = 1;
    pub const DIVISION_BY_ZERO: i32 = 4;

    unsafe extern "C" {
        pub safe fn fesetround(mode: i32) -> i32;
        pub safe fn fegetround() -> i32;
        pub safe fn feclearexcept(exceptions: i32) -> i32;
        pub safe fn fetestexcept(exceptions: i32) -> i32;
    }
}

impl FloatEnv {
    /// Chooses the mode of a call, mostly to nearest.
    #[cfg(target_arch = "x86_64")]
    pub fn pick(choices: &mut super::choices::Choices<'_>, quiet: bool) -> Self {
        let mode = if choices.one_in(4) { choices.pick(&libm::MODES) } else { 0 };
        Self { mode, quiet }
    }

    #[cfg(not(target_arch = "x86_64"))]
    pub fn pick(_: &mut super::choices::Choices<'_>, quiet: bool) -> Self {
        Self { mode: 0, quiet }
    }

    /// Makes a call in this mode.
    ///
    /// # Panics
    /// When it leaves another mode, or raises an exception that it may not.
    #[cfg(target_arch = "x86_64")]
    pub fn call<R>(self, what: &str, work: impl FnOnce() -> R) -> R {
        use libm::{DIVISION_BY_ZERO, INVALID};
        libm::feclearexcept(INVALID | DIVISION_BY_ZERO);
        libm::fesetround(self.mode);
        let result = std::hint::black_box(work)();
        let after = libm::fegetround();
        let raised = libm::fetestexcept(INVALID | DIVISION_BY_ZERO);
        libm::fesetround(0);
        assert_eq!(after, self.mode, "{what}: the rounding mode was changed");
        assert!(raised == 0 || !self.quiet, "{what}: raised {raised}");
        result
    }

    #[cfg(not(target_arch = "x86_64"))]
    pub fn call<R>(self, _: &str, work: impl FnOnce() -> R) -> R {
        let _ = (self.mode, self.quiet);
        work()
    }
}
