//! The floating-point environment of a thread: how results are rounded, and what becomes of
//! subnormal numbers.

use std::marker::PhantomData;

/// Sets the default floating-point environment of this thread until the guard is dropped: rounding
/// to nearest, subnormal numbers as they are, exceptions without traps.
///
/// All results of this library are those of the default environment. The interfaces to C and
/// Python set it for the length of a call. Rust code is compiled for the default environment, so
/// Rust functions do not look at it: a Rust library in a program that changes it (by `fesetround`,
/// or by a library that was linked with `-ffast-math`) holds this guard around its calls.
///
/// The guard costs a read of a register where the environment is the default one. The flags of
/// exceptions that have occurred stay set. On processors other than x86 and AArch64 the guard does
/// nothing.
///
/// ```
/// use catamaran::base::FloatEnv;
///
/// let _nearest = FloatEnv::nearest();
/// assert!(FloatEnv::is_default());
/// ```
#[derive(Debug)]
#[must_use = "the environment is restored when the guard is dropped"]
pub struct FloatEnv {
    /// The control register to restore; `None` where it was the default one.
    saved: Option<control::Register>,
    /// The environment belongs to a thread.
    _not_send: PhantomData<*const ()>,
}

impl FloatEnv {
    /// Sets the default environment and returns the guard that restores the present one.
    pub fn nearest() -> Self {
        let present = control::read();
        let saved = (!control::is_default(present)).then_some(present);
        if saved.is_some() {
            control::write(control::default(present));
        }
        Self { saved, _not_send: PhantomData }
    }

    /// Returns whether the environment of this thread is the default one.
    pub fn is_default() -> bool {
        control::is_default(control::read())
    }
}

impl Drop for FloatEnv {
    fn drop(&mut self) {
        if let Some(saved) = self.saved {
            control::write(control::restored(saved, control::read()));
        }
    }
}

/// MXCSR. The control word of the x87 unit is left alone: nothing here computes with that unit.
#[cfg(all(
    any(target_arch = "x86_64", all(target_arch = "x86", target_feature = "sse")),
    not(miri)
))]
mod control {
    use std::arch::asm;

    pub type Register = u32;

    /// The flags of exceptions that have occurred.
    const FLAGS: Register = 0x3f;
    /// All exceptions masked, rounding to nearest, neither flush-to-zero nor denormals-are-zero.
    const DEFAULT: Register = 0x1f80;

    pub fn read() -> Register {
        let mut register: Register = 0;
        // SAFETY: writes the four bytes of `register`, which lives on the stack.
        unsafe {
            asm!("stmxcsr [{}]", in(reg) &raw mut register, options(nostack, preserves_flags));
        }
        register
    }

    pub fn write(register: Register) {
        // SAFETY: reads four bytes that live on the stack. Every value written is one that was
        // read, with fields replaced by those of DEFAULT or of another value read, so no reserved
        // bit is set. The compiler assumes DEFAULT: `FloatEnv` writes it, or gives back what a
        // caller had that was not compiled under this assumption.
        unsafe {
            asm!("ldmxcsr [{}]", in(reg) &raw const register, options(nostack, preserves_flags));
        }
    }

    pub fn is_default(register: Register) -> bool {
        register & !FLAGS == DEFAULT
    }

    /// Returns the default environment with the flags of `present`.
    pub fn default(present: Register) -> Register {
        DEFAULT | (present & FLAGS)
    }

    /// Returns `saved` with the flags of `present`, which has those of `saved` too.
    pub fn restored(saved: Register, present: Register) -> Register {
        (saved & !FLAGS) | (present & FLAGS)
    }
}

/// FPCR, all zeros by default. The flags of exceptions are in another register (FPSR).
#[cfg(all(target_arch = "aarch64", not(miri)))]
mod control {
    use std::arch::asm;

    pub type Register = u64;

    pub fn read() -> Register {
        let register: Register;
        // SAFETY: every CPU of this architecture has the register, and no memory is accessed.
        unsafe {
            asm!("mrs {}, fpcr", out(reg) register, options(nomem, nostack, preserves_flags))
        };
        register
    }

    pub fn write(register: Register) {
        // SAFETY: the value is 0 or one that was read. The compiler assumes 0: `FloatEnv` writes
        // it, or gives back what a caller had that was not compiled under this assumption.
        unsafe { asm!("msr fpcr, {}", in(reg) register, options(nostack, preserves_flags)) };
    }

    pub fn is_default(register: Register) -> bool {
        register == 0
    }

    pub fn default(_present: Register) -> Register {
        0
    }

    pub fn restored(saved: Register, _present: Register) -> Register {
        saved
    }
}

/// Other processors, and Miri: the environment is taken to be the default one.
#[cfg(any(
    miri,
    not(any(
        target_arch = "x86_64",
        all(target_arch = "x86", target_feature = "sse"),
        target_arch = "aarch64"
    ))
))]
mod control {
    pub type Register = ();

    pub fn read() -> Register {}

    pub fn write((): Register) {}

    pub fn is_default((): Register) -> bool {
        true
    }

    pub fn default((): Register) -> Register {}

    pub fn restored((): Register, (): Register) -> Register {}
}

#[cfg(all(test, target_arch = "x86_64", not(miri)))]
mod tests {
    use std::hint::black_box;

    use super::*;

    const UPWARD: u32 = 0x5f80;
    const FLUSH_TO_ZERO_AND_DENORMALS_ARE_ZERO: u32 = 0x9fc0;
    /// The flag of a division by zero, and of an inexact result.
    const DIVISION: u32 = 0x04;
    const INEXACT: u32 = 0x20;

    /// Calls `work` in the environment `register`, and returns what it leaves of the register.
    fn under(register: u32, work: impl FnOnce()) -> u32 {
        let before = control::read();
        control::write(register);
        black_box(work)();
        let after = control::read();
        control::write(before);
        after
    }

    fn third() -> f64 {
        black_box(1.0) / black_box(3.0)
    }

    #[test]
    fn the_guard_rounds_to_nearest_and_gives_the_mode_of_the_caller_back() {
        let nearest = third();
        let mut found = [0.0; 3];
        let after = under(UPWARD, || {
            found[0] = third();
            {
                let _nearest = FloatEnv::nearest();
                assert!(FloatEnv::is_default());
                found[1] = third();
            }
            assert!(!FloatEnv::is_default());
            found[2] = third();
        });
        assert_eq!(found, [nearest.next_up(), nearest, nearest.next_up()]);
        assert_eq!(after & !0x3f, UPWARD);
    }

    #[test]
    fn subnormal_numbers_stay_under_the_guard() {
        let half = || black_box(f64::MIN_POSITIVE) / black_box(2.0);
        let mut found = [1.0; 2];
        let after = under(FLUSH_TO_ZERO_AND_DENORMALS_ARE_ZERO, || {
            found[0] = half();
            let _nearest = FloatEnv::nearest();
            found[1] = half();
        });
        assert_eq!(found, [0.0, f64::MIN_POSITIVE / 2.0]);
        assert_eq!(after & !0x3f, FLUSH_TO_ZERO_AND_DENORMALS_ARE_ZERO);
    }

    #[test]
    fn exceptions_of_the_caller_and_of_the_work_stay_noted_and_do_not_trap() {
        // The exception of an invalid operation traps.
        let traps = (UPWARD & !0x80) | DIVISION;
        let after = under(traps, || {
            let _nearest = FloatEnv::nearest();
            assert!((black_box(0.0_f64) / black_box(0.0)).is_nan());
            black_box(third());
        });
        assert_eq!(after & !0x3f, UPWARD & !0x80);
        assert_eq!(after & (DIVISION | INEXACT | 1), DIVISION | INEXACT | 1);
    }

    #[test]
    fn guards_nest() {
        let after = under(UPWARD, || {
            let outer = FloatEnv::nearest();
            drop(FloatEnv::nearest());
            assert!(FloatEnv::is_default());
            drop(outer);
            assert!(!FloatEnv::is_default());
        });
        assert_eq!(after & !0x3f, UPWARD);
    }
}
