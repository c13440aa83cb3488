//! Which calls are computed here, and by which plan.
//!
//! A plan costs as much as a small product, so each thread keeps the plans of its last shapes.

use std::any::TypeId;
use std::cell::RefCell;
use std::fs::File;
use std::io::Read;
use std::rc::Rc;
use std::sync::OnceLock;

use catamaran::{Accuracy, AtaOptions};

use crate::element::{Element, Planned};
use crate::entry::Why;
use crate::request::{Kind, Request, Shape};
use crate::settings::{Mode, Settings};

/// Sides of C from which products are worth a plan.
const LEAST_SIDE: i64 = 128;
/// Length of the sums from which products are worth a plan.
const LEAST_DEPTH: i64 = 32;
/// Products of real numbers that are worth a plan, both triangles of a symmetric result counted.
const LEAST_WORK: f64 = 4e6;

/// Returns whether a call with sides m, n, k is too small for a plan, or not valid. This is the
/// only check of small products.
#[inline(always)]
pub fn is_small(m: i64, n: i64, k: i64) -> bool {
    m < LEAST_SIDE || n < LEAST_SIDE || k < LEAST_DEPTH
}

/// Returns the plan for `request`, or why it is forwarded.
pub fn decide<T: Element>(request: &Request<T>, settings: &Settings) -> Decision {
    if settings.mode == Mode::Off {
        return Err(Why::Off);
    }
    if request.is_trivial() {
        return Err(Why::Trivial);
    }
    if !request.is_aligned() {
        return Err(Why::Arguments);
    }
    let [m, n, k] = request.sides();
    if settings.mode == Mode::Auto {
        let side = |side: usize| i64::try_from(side).unwrap_or(i64::MAX);
        if is_small(side(m), side(n), side(k)) || request.work() < LEAST_WORK {
            return Err(Why::Small);
        }
    }
    if request.overlaps() {
        return Err(Why::Overlap);
    }
    let shape = request.shape();
    remembered(Key { element: TypeId::of::<T>(), shape }, || {
        let plan = plan(request, settings).map_err(|_| Why::Memory)?;
        if settings.mode == Mode::Auto && plan.expected_ratio() > worthwhile::<T>(&plan, shape) {
            return Err(Why::Slower);
        }
        let scratch = T::scratch(&plan, settings.threads);
        if settings.memory.is_some_and(|most| scratch > most) {
            return Err(Why::Memory);
        }
        Ok(Rc::new(plan))
    })
}

/// Returns the plan for `request`, whatever it costs.
///
/// # Errors
/// As [`catamaran::Plan::ata`].
pub fn plan<T: Element>(request: &Request<T>, settings: &Settings) -> catamaran::Result<Planned> {
    let options = AtaOptions::new().memory(settings.memory);
    let options = match settings.mode {
        Mode::Auto | Mode::Off => options,
        Mode::Reproducible => options.reproducible(true),
        Mode::Max => options.accuracy(Accuracy::Max),
    };
    T::plan(&request.shape(), &options)
}

/// Returns the largest ratio of the time of a plan to that of our classical products for which the
/// plan is expected to be faster than the next library.
///
/// With vectors of 512 bits, classical products are as fast as those of OpenBLAS or faster on
/// processors of AMD; on other processors this holds for symmetric ones with less than `COLUMNS`
/// columns (figures 8.3 and 8.4 in bench/record, and preload/race.py). Shorter vectors have not
/// been measured yet: only plans that save multiplications are used there.
fn worthwhile<T: Element>(plan: &Planned, shape: Shape) -> f64 {
    /// With more columns OpenBLAS takes 1 to 5 % less time.
    const COLUMNS: usize = 2048;
    /// Our classical products win.
    const ALWAYS: f64 = f64::INFINITY;
    /// They lose, or have not been measured.
    const NEVER: f64 = 0.0;
    /// Fast levels have to make up for slower kernels.
    const FAST: f64 = 0.93;
    match (plan.isa(), shape.kind) {
        (Some("portable"), _) => NEVER,
        (Some("avx2"), _) if T::IS_COMPLEX => NEVER,
        (Some("avx2"), _) => FAST,
        _ if T::IS_COMPLEX => {
            if complex_wins::<T>(shape) {
                ALWAYS
            } else {
                NEVER
            }
        }
        (_, Kind::Symmetric) if shape.sides[0] < COLUMNS => ALWAYS,
        _ if is_amd() => ALWAYS,
        _ => FAST,
    }
}

/// Returns whether complex products of this shape were measured to be as fast as those of OpenBLAS,
/// or faster, with vectors of 512 bits.
///
/// The parts are first copied into real matrices. The copies cost less, relatively, for longer sums
/// and wider results, and more in single precision. They were measured by preload/race.py on one
/// core of Zen 5 only (docs/guide/blas.md): single precision takes 1.13 to 1.8 times as long.
fn complex_wins<T: Element>(shape: Shape) -> bool {
    /// Least sides from which double precision takes 0.99 of OpenBLAS' time or less.
    const GENERAL: usize = 512;
    const HERMITIAN: usize = 1024;
    let least = if shape.kind == Kind::Symmetric { HERMITIAN } else { GENERAL };
    is_amd() && T::PART == 8 && shape.sides.iter().all(|&side| side >= least)
}

/// Returns whether the processor is one of AMD, according to Linux.
fn is_amd() -> bool {
    static AMD: OnceLock<bool> = OnceLock::new();
    *AMD.get_or_init(|| {
        // The vendor is in the second line.
        let mut start = [0; 256];
        let read = File::open("/proc/cpuinfo").and_then(|mut file| file.read(&mut start));
        read.is_ok_and(|length| start[..length].windows(12).any(|text| text == b"AuthenticAMD"))
    })
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Key {
    element: TypeId,
    shape: Shape,
}

/// The plan of a request, or why it is not computed here.
pub type Decision = Result<Rc<Planned>, Why>;

/// Returns the decision for `key`: that of the last time, or what `decide` returns.
fn remembered(key: Key, decide: impl FnOnce() -> Decision) -> Decision {
    /// Shapes that a thread remembers; a program that alternates between more of them plans anew.
    const SHAPES: usize = 16;
    thread_local! {
        static LAST: RefCell<Vec<(Key, Decision)>> = const { RefCell::new(Vec::new()) };
    }
    let known = LAST.try_with(|last| {
        let mut last = last.try_borrow_mut().ok()?;
        let found = last.iter().position(|(known, _)| *known == key)?;
        // Programs often repeat a shape.
        last.swap(0, found);
        Some(last[0].1.clone())
    });
    if let Ok(Some(decision)) = known {
        return decision;
    }
    let decision = decide();
    // A thread that ends has no memory of plans any more.
    let _ = LAST.try_with(|last| {
        if let Ok(mut last) = last.try_borrow_mut() {
            last.insert(0, (key, decision.clone()));
            last.truncate(SHAPES);
        }
    });
    decision
}

#[cfg(test)]
mod tests {
    use catamaran::Uplo;
    use catamaran::faer::{c32, c64};

    use super::*;
    use crate::request::{Side, Stored};

    const SETTINGS: Settings = Settings {
        mode: Mode::Auto,
        verbose: false,
        hints: true,
        threads: 2,
        memory: Some(64 << 20),
    };

    fn syrk(n: usize, k: usize, c: usize) -> Request<f64> {
        let stored = Stored {
            pointer: std::ptr::without_provenance(1 << 40),
            rows: k,
            cols: n,
            leading: k.max(1),
        };
        Request {
            alpha: 1.0,
            left: Side { stored, transposed: false, conjugated: false },
            right: None,
            beta: 0.0,
            c: std::ptr::without_provenance_mut(c),
            c_leading: n,
            triangle: Some(Uplo::Lower),
        }
    }

    fn why(request: Request<f64>, settings: Settings) -> Option<Why> {
        decide(&request, &settings).err()
    }

    #[test]
    fn calls_are_forwarded_for_the_reason_that_is_reported() {
        let off = Settings { mode: Mode::Off, ..SETTINGS };
        assert_eq!(why(syrk(500, 500, 1 << 30), off), Some(Why::Off));
        assert_eq!(why(syrk(500, 0, 1 << 30), SETTINGS), Some(Why::Trivial));
        assert_eq!(why(syrk(64, 64, 1 << 30), SETTINGS), Some(Why::Small));
        assert_eq!(why(syrk(130, 130, 1 << 30), SETTINGS), Some(Why::Small));
        assert_eq!(why(syrk(500, 500, 1 << 40), SETTINGS), Some(Why::Overlap));
        assert_eq!(why(syrk(500, 500, (1 << 30) + 1), SETTINGS), Some(Why::Arguments));
    }

    #[test]
    fn complex_products_are_taken_where_they_were_measured_to_be_faster() {
        let shape = |kind, side| Shape { kind, sides: [side; 3], conjugated: [true, false] };
        for (kind, side, wins) in [
            (Kind::General, 511, false),
            (Kind::General, 512, true),
            (Kind::Symmetric, 1023, false),
            (Kind::Symmetric, 1024, true),
        ] {
            assert_eq!(complex_wins::<c64>(shape(kind, side)), wins && is_amd());
            assert!(!complex_wins::<c32>(shape(kind, side)));
        }
    }

    #[test]
    fn no_product_is_too_small_for_the_other_modes() {
        for mode in [Mode::Reproducible, Mode::Max] {
            let settings = Settings { mode, ..SETTINGS };
            let plan = decide(&syrk(3, 5, 1 << 30), &settings).unwrap();
            assert!(plan.is_exact());
        }
    }

    #[test]
    fn plans_stay_within_the_memory_allowed_or_are_none() {
        let settings = Settings { mode: Mode::Reproducible, ..SETTINGS };
        for n in [2000, 6000] {
            let plan = decide(&syrk(n, n, 1 << 30), &settings).unwrap();
            assert!(f64::scratch(&plan, 2) <= 64 << 20);
        }
        let none = Settings { memory: Some(1 << 10), ..settings };
        assert_eq!(why(syrk(3000, 3000, 1 << 30), none), Some(Why::Memory));
    }

    #[test]
    fn a_decision_is_made_once_for_a_shape() {
        let shape = Shape { kind: Kind::General, sides: [1; 3], conjugated: [false; 2] };
        let key =
            |n| Key { element: TypeId::of::<f32>(), shape: Shape { sides: [n, 1, 1], ..shape } };
        let mut calls = 0;
        for n in [1, 1, 2, 1, 2] {
            let _ = remembered(key(n), || {
                calls += 1;
                Err(Why::Slower)
            });
        }
        assert_eq!(calls, 2);
    }
}
