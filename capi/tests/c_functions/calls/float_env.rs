//! The rounding mode in which a call is made.

use super::choices::Choices;

/// A rounding mode of the calling thread, which a call keeps.
#[derive(Debug, Clone, Copy)]
pub struct FloatEnv {
    mode: i32,
}

#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
mod libm {
    // To nearest, down, up and to zero, as in `fenv.h` of glibc.
    pub const MODES: [i32; 4] = [0, 0x400, 0x800, 0xc00];

    unsafe extern "C" {
        pub safe fn fesetround(mode: i32) -> i32;
        pub safe fn fegetround() -> i32;
    }
}

/// Elsewhere calls round to nearest.
#[cfg(not(all(target_arch = "x86_64", target_os = "linux")))]
mod libm {
    pub const MODES: [i32; 1] = [0];

    pub fn fesetround(mode: i32) -> i32 {
        mode
    }

    pub fn fegetround() -> i32 {
        0
    }
}

impl FloatEnv {
    /// Chooses the mode of a call, mostly to nearest.
    pub fn pick(choices: &mut Choices<'_>) -> Self {
        Self { mode: if choices.one_in(4) { choices.pick(&libm::MODES) } else { 0 } }
    }

    /// Makes a call in this mode.
    ///
    /// # Panics
    /// When it leaves another mode.
    pub fn call<R>(self, what: &str, work: impl FnOnce() -> R) -> R {
        libm::fesetround(self.mode);
        let result = std::hint::black_box(work)();
        let after = libm::fegetround();
        libm::fesetround(0);
        assert_eq!(after, self.mode, "{what}: the rounding mode was changed");
        result
    }
}
