//! Plans take as many steps for large matrices as for small ones.

use super::Plan;
use crate::base::steps::steps_of;
use crate::base::{Error, Par};
use crate::blas::BlasReal;
use crate::product::{AtaOptions, ComplexPlan, SchemeChoice};
use crate::ranks::plan::Chunks;
use crate::rows::StreamPlan;

/// Steps that a plan and its scratch may take; that of a complex product has four plans, each with
/// the products of a thousand triangles between which Strassen's algorithm is applied twice.
const MOST: usize = 300_000;

/// Shapes m, n, k, up to those of which no memory holds C.
const SHAPES: [[usize; 3]; 9] = [
    [0, 0, 0],
    [20_000, 20_000, 20_000],
    [1_000_000, 1_000_000, 1_000_000],
    [999_999, 999_999, 1],
    [1, 1_000_000, 1_000_000],
    [1_000_000, 1, 1_000_000],
    [1_000_000, 1000, 1000],
    [1_000_000_000_000, 1, 1],
    [1, 1_000_000_000_000, 1],
];

const SCHEMES: [SchemeChoice; 9] = [
    SchemeChoice::Auto,
    SchemeChoice::Float,
    SchemeChoice::Exact,
    SchemeChoice::Classical,
    SchemeChoice::Winograd,
    SchemeChoice::Ata2,
    SchemeChoice::Rxtx,
    SchemeChoice::Kgp4,
    SchemeChoice::Kgp3,
];

/// Every scheme without a limit of memory and with one, and more limits where they matter.
fn options() -> Vec<AtaOptions<'static>> {
    use crate::product::Accuracy::{Default, Fast, Max};
    let plain = || AtaOptions::new();
    let limits = [0, 1 << 20, 1 << 30, usize::MAX].into_iter().flat_map(|memory| {
        [SchemeChoice::Auto, SchemeChoice::Exact].map(|s| plain().scheme(s).memory(memory))
    });
    let schemes = SCHEMES.into_iter().flat_map(|scheme| {
        let deep = plain().scheme(scheme).accuracy(Fast).leaf(1);
        let flat = plain().scheme(scheme).accuracy(Max).leaf(40);
        [plain().scheme(scheme).accuracy(Default).memory(64 << 20), deep, flat]
    });
    schemes.chain(limits).collect()
}

/// Plans everything that the library multiplies, and returns the most steps of a plan.
fn most_steps<T: BlasReal>([m, n, k]: [usize; 3], options: &AtaOptions<'_>) -> usize {
    let real = |plan: Result<Plan, Error>| {
        for threads in [1, 2, 64] {
            plan.iter().for_each(|plan| {
                plan.scratch_len::<T>(Par::Threads(threads));
            });
        }
    };
    let complex = |plan: Result<ComplexPlan, Error>| {
        plan.iter().for_each(|plan| {
            plan.scratch_len::<T>(Par::Threads(4));
        });
    };
    let kinds: [&dyn Fn(); 6] = [
        &|| real(Plan::ata::<T>(m, n, options)),
        &|| real(Plan::ata::<T>(n, m, options)),
        &|| real(Plan::atb::<T>(m, n, k, options)),
        &|| real(Plan::atb_triangle::<T>(m, n, options)),
        &|| complex(ComplexPlan::aha::<T>(m, n, options)),
        &|| complex(ComplexPlan::ahb::<T>(m, n, k, options)),
    ];
    kinds.iter().map(steps_of).max().unwrap_or(0)
}

#[test]
fn steps_of_plans_do_not_grow_with_the_sides() {
    for shape in SHAPES {
        for options in options() {
            let steps = most_steps::<f64>(shape, &options);
            assert!(steps <= MOST, "{steps} steps for {shape:?}, {options:?}");
        }
        let options = AtaOptions::new().memory(1 << 20);
        let steps = most_steps::<f32>(shape, &options);
        assert!(steps <= MOST, "{steps} steps for {shape:?}, f32");
    }
}

#[test]
fn steps_of_streams_grow_with_the_reads_only() {
    for [m, n, _] in SHAPES {
        for memory in [1 << 20, 20 << 30, 1 << 40] {
            for (weighted, exact) in [(false, false), (true, false), (false, true)] {
                let options = AtaOptions::new().reproducible(exact).threads(2);
                let mut plan = None;
                let steps = steps_of(|| {
                    plan = Some(StreamPlan::new::<f64>(m, n, weighted, None, memory, &options));
                });
                let reads = plan.and_then(Result::ok).map_or(0, |plan| plan.reads());
                assert!(reads <= 4096);
                // Blocks of several heights are planned before one is taken.
                assert!(steps <= MOST * (4 + reads), "{steps}, {reads} reads of {m} x {n}");
            }
        }
    }
}

#[test]
fn small_products_are_exact_only_when_asked() {
    let sides = [1, 2, 3, 8, 31, 32, 100, 300, 1000, 10_000, 100_000];
    let mut some = false;
    for (m, n) in sides.into_iter().flat_map(|m| sides.map(|n| (m, n))) {
        let plans = |scheme| {
            let options = &AtaOptions::new().scheme(scheme);
            [Plan::ata::<f64>(m, n, options), Plan::atb::<f64>(m, n, 8, options)]
                .map(|plan| plan.unwrap().to_string().contains("products of integers"))
        };
        some |= plans(SchemeChoice::Exact).contains(&true);
        assert_eq!(plans(SchemeChoice::Auto), [false; 2], "{m} x {n}");
    }
    assert!(some);
}

#[test]
fn steps_of_ranks_do_not_grow_with_the_rows() {
    for [m, n, _] in SHAPES {
        for ranks in [1, 16, 4096] {
            let steps = steps_of(|| drop(Chunks::new(m, n.min(1_000_000), ranks)));
            assert!(steps <= 20, "{steps} steps for {m} x {n} on {ranks} ranks");
        }
    }
}

#[test]
fn a_stream_that_would_read_a_too_often_is_refused() {
    let (m, n) = (10_000, 400_000);
    let refusal = |memory| {
        let plan = StreamPlan::new::<f64>(m, n, false, None, memory, &AtaOptions::new());
        plan.unwrap_err().to_string()
    };
    // The least memory, in steps of ten rows of C, that holds two blocks, scratch and a row of C.
    let refusals = (1..64).map(|step| refusal(2 * 1024 * n * 8 + (step << 25)));
    let text = refusals.into_iter().find(|text| !text.contains("a row of C need")).unwrap();
    assert!(text.contains("more than 4096 times"), "{text}");
}
