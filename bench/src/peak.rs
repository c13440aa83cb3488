//! Measures the speed limit of one core: multiply-adds in f64 on registers only.

use std::hint::black_box;
use std::time::{Duration, Instant};

#[cfg(target_arch = "x86_64")]
use catamaran::base::cpu_features;

/// A measured limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// GFLOP/s of one core, in its best window.
    pub gflops: f64,
    /// The instructions used.
    pub instructions: &'static str,
}

/// Number of windows of about a millisecond: other programs disturbed the best one least.
const WINDOWS: usize = 50;
const PASSES: usize = 100_000;

/// Measures for some 50 ms on the calling thread.
pub fn measure() -> Peak {
    of_windows(|window| {
        let seconds = (0..WINDOWS).map(|_| window());
        seconds.fold(f64::INFINITY, f64::min)
    })
}

/// Measures for as long as `duration` on the calling thread, all windows: the share of a core that
/// others use, too, so that the speeds of threads that measure at the same time can be added.
pub fn sustained(duration: Duration) -> Peak {
    of_windows(|window| {
        let start = Instant::now();
        let mut windows = 0;
        while windows == 0 || start.elapsed() < duration {
            window();
            windows += 1;
        }
        start.elapsed().as_secs_f64() / f64::from(windows)
    })
}

/// Returns the speed from the seconds of a window. `seconds` calls its argument, which runs one
/// window.
fn of_windows(seconds: impl Fn(&dyn Fn() -> f64) -> f64) -> Peak {
    let peak = |instructions, flops: usize, run: &dyn Fn() -> f64| {
        let window = || {
            let start = Instant::now();
            black_box(run());
            start.elapsed().as_secs_f64()
        };
        Peak { gflops: (PASSES * flops) as f64 / seconds(&window) / 1e9, instructions }
    };
    #[cfg(target_arch = "x86_64")]
    {
        // Within the limit of this process, as the kernels.
        let found = cpu_features();
        let has = |name| found.contains(&name);
        if has("avx512f") {
            // SAFETY: the CPU has the instructions that `cpu_features` names.
            return peak("avx512f", x86::FLOPS_AVX512, &|| unsafe { x86::avx512(PASSES) });
        }
        if has("avx2") && has("fma") {
            // SAFETY: the CPU has the instructions that `cpu_features` names.
            return peak("avx2", x86::FLOPS_AVX2, &|| unsafe { x86::avx2(PASSES) });
        }
    }
    peak("portable", FLOPS_PORTABLE, &|| portable(PASSES))
}

/// Returns the factor and the term of all chains: x := x / 2 + 1 stays near 2, far from denormal
/// numbers. They are hidden from the compiler, which would compute the result itself.
fn factor_and_term() -> (f64, f64) {
    black_box((0.5, 1.0))
}

const CHAINS_PORTABLE: usize = 16;
const FLOPS_PORTABLE: usize = CHAINS_PORTABLE * 2;

/// Computes a multiplication and an addition, for CPUs without fused ones.
fn portable(passes: usize) -> f64 {
    let (factor, term) = factor_and_term();
    let mut chains = [0.0; CHAINS_PORTABLE];
    for _ in 0..passes {
        for x in &mut chains {
            *x = *x * factor + term;
        }
    }
    black_box(chains).into_iter().sum()
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::{
        _mm256_cvtsd_f64, _mm256_fmadd_pd, _mm256_set1_pd, _mm512_cvtsd_f64, _mm512_fmadd_pd,
        _mm512_set1_pd,
    };

    use std::hint::black_box;

    use super::factor_and_term;

    // Independent chains: enough for two units of latency 5, and few enough for the registers.
    const CHAINS_AVX512: usize = 16;
    const CHAINS_AVX2: usize = 12;
    pub const FLOPS_AVX512: usize = CHAINS_AVX512 * 8 * 2;
    pub const FLOPS_AVX2: usize = CHAINS_AVX2 * 4 * 2;

    #[target_feature(enable = "avx512f")]
    pub fn avx512(passes: usize) -> f64 {
        let (factor, term) = factor_and_term();
        let (factor, term) = (_mm512_set1_pd(factor), _mm512_set1_pd(term));
        let mut chains = [term; CHAINS_AVX512];
        for _ in 0..passes {
            for x in &mut chains {
                *x = _mm512_fmadd_pd(*x, factor, term);
            }
        }
        black_box(chains).into_iter().map(|x| _mm512_cvtsd_f64(x)).sum()
    }

    #[target_feature(enable = "avx2,fma")]
    pub fn avx2(passes: usize) -> f64 {
        let (factor, term) = factor_and_term();
        let (factor, term) = (_mm256_set1_pd(factor), _mm256_set1_pd(term));
        let mut chains = [term; CHAINS_AVX2];
        for _ in 0..passes {
            for x in &mut chains {
                *x = _mm256_fmadd_pd(*x, factor, term);
            }
        }
        black_box(chains).into_iter().map(|x| _mm256_cvtsd_f64(x)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_is_positive_and_finite() {
        for peak in [measure(), sustained(Duration::ZERO), sustained(Duration::from_millis(5))] {
            assert!(peak.gflops > 0.0 && peak.gflops.is_finite(), "{peak:?}");
        }
    }

    #[test]
    fn every_chain_converges() {
        assert_eq!(portable(100), 2.0 * CHAINS_PORTABLE as f64);
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f") {
                // SAFETY: the CPU has the instructions.
                assert_eq!(unsafe { x86::avx512(100) }, 2.0 * 16.0);
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: the CPU has the instructions.
                assert_eq!(unsafe { x86::avx2(100) }, 2.0 * 12.0);
            }
        }
    }
}
