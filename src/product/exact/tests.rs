//! Checks that every kernel and division of the work gives the bytes of integers of any size.

use faer::{Mat, MatRef};

use super::blocking::Blocking;
use super::layout::{Batch, Extent, Need, Pair, Pieces};
use super::*;
use crate::base::{Arena, Par, Rng, Workspace};
use crate::kernel::int8::tests::{PORTABLE, kernels};
use crate::product::SchemeChoice;
use crate::product::plan::{Plan, Strategy};

/// Returns uniform entries whose columns are scaled by `2^(spread * (j % 7))`, with zeros and a
/// zero column.
fn random<T: IntegerOperand>(m: usize, n: usize, spread: i32, seed: u64) -> Mat<T> {
    let mut rng = Rng::new(seed);
    Mat::from_fn(m, n, |i, j| {
        let value = 2.0 * rng.uniform() - 1.0;
        let zero = j == 5 || (i + 3 * j) % 11 == 0;
        let scaled = if zero { 0.0 } else { value * f64::from(spread * (j as i32 % 7)).exp2() };
        T::from_f64(scaled)
    })
}

fn columns<T: IntegerOperand>(kernel: &dyn Kernel, a: MatRef<'_, T>, moduli: &Moduli) -> Columns {
    let mut memory = Workspace::<T>::new(columns::scratch_len::<T>(a.nrows(), a.ncols())).unwrap();
    Columns::new(kernel, a, moduli, Par::Seq, &mut Arena::new(memory.as_mut_slice()))
}

/// Returns `v 2^e`, rounded once.
fn scaled(v: i128, e: i32) -> f64 {
    v as f64 * f64::from(e / 2).exp2() * f64::from(e - e / 2).exp2()
}

/// Runs `layout` in dirty memory.
fn run<T: IntegerOperand>(
    kernel: &dyn Kernel,
    layout: &ExactLayout,
    a: MatRef<'_, T>,
    b: Option<MatRef<'_, T>>,
    threads: usize,
) -> Mat<T> {
    let extents = [a.nrows(), a.ncols(), b.unwrap_or(a).ncols()];
    let options = AtaOptions { par: Par::Threads(threads), ..AtaOptions::default() };
    let mut scratch = Workspace::new(scratch_len::<T>(extents, layout, threads)).unwrap();
    scratch.as_mut_slice().fill(T::from_f64(f64::NAN));
    let mut c = Mat::from_fn(extents[1], extents[2], |_, _| T::from_f64(f64::NAN));
    let scratch = scratch.as_mut_slice();
    execute(kernel, layout, T::ONE, a, b, T::ZERO, c.as_mut(), &options, scratch).unwrap();
    c
}

/// Returns divisions of the work that reach every branch: chunks of rows, groups of columns, both.
fn layouts(whole: &ExactLayout) -> Vec<ExactLayout> {
    let mut found = vec![whole.clone()];
    for (chunk, groups, [rows, cols, depth]) in [
        (whole.steps, 1, [1, 1, 1]),
        (1, 1, [2, 3, 16]),
        (2, 2, [1, 2, 2]),
        (whole.steps, 3, [2, 2, 3]),
    ] {
        let groups = groups.min(whole.left.max(whole.right)).max(1);
        let blocking = Blocking { rows, cols, depth };
        found.push(ExactLayout { chunk, groups, blocking, ..whole.clone() });
    }
    found
}

#[test]
fn slices_lie_in_the_order_of_the_products() {
    for (panels, steps, depth) in
        [(0..1, 0..1, 1), (2..5, 3..20, 16), (0..7, 5..42, 16), (1..4, 0..33, 10)]
    {
        let extent = Extent { panels: panels.clone(), pieces: Pieces::new(steps.clone(), depth) };
        let (mut next, mut first) = (0, steps.start);
        for piece in (0..extent.pieces.count).map(|i| extent.pieces.get(i)) {
            assert!(piece.start == first && (1..=depth).contains(&piece.len()), "{extent:?}");
            first = piece.end;
            for panel in panels.clone() {
                for step in piece.clone() {
                    assert_eq!(extent.pieces.around(step), piece, "{extent:?}, step {step}");
                    assert_eq!(extent.place(panel, step), next, "{extent:?}, ({panel}, {step})");
                    next += 1;
                }
            }
        }
        assert_eq!((next, first), (extent.len(), steps.end), "{extent:?}");
    }
}

fn check_against_integers<T: IntegerOperand>(m: usize, n: usize, count: usize, spread: i32) {
    let a = random::<T>(m, n, spread, count as u64);
    let moduli = Moduli::of(count);
    let whole = ExactLayout::new([m, n, n], size_of::<T>(), count, true, true);
    let expected = run(&PORTABLE, &whole, a.as_ref(), None, 1);
    let of_a = columns(&PORTABLE, a.as_ref(), moduli);
    let integer = |i: usize, j: usize| {
        let e = of_a.exponents[j];
        let value = a[(i, j)].to_f64() * f64::from(e / 2).exp2() * f64::from(e - e / 2).exp2();
        value.round_ties_even() as i128
    };
    let integers = Mat::from_fn(m, n, integer);
    for j in 0..n {
        let norm = (0..m).map(|i| (integers[(i, j)] as f64).powi(2)).sum::<f64>().sqrt();
        assert!(norm <= moduli.largest_norm, "column {j}: {norm:e}");
        assert!(norm == 0.0 || norm > 0.24 * moduli.largest_norm, "column {j}: {norm:e}");
        for i in j..n {
            let sum: i128 = (0..m).map(|k| integers[(k, i)] * integers[(k, j)]).sum();
            let right = scaled(sum, -of_a.exponents[i] - of_a.exponents[j]);
            let got = expected[(i, j)].to_f64();
            let subnormal = if size_of::<T>() == 8 { 5e-324 } else { 1.5e-45 };
            let slack = 2.0 * T::UNIT_ROUNDOFF * right.abs() + subnormal;
            let close = got == right || (got - right).abs() <= slack;
            assert!(close, "({i}, {j}) of {m} x {n}: {got:e}, not {right:e}");
        }
    }
    for (name, kernel) in kernels() {
        assert_eq!(columns(kernel, a.as_ref(), moduli).exponents, of_a.exponents, "{name}");
        for (l, layout) in layouts(&whole).into_iter().enumerate() {
            // An emulated instruction takes a microsecond.
            if name == "amx" && l % 2 == 1 {
                continue;
            }
            let c = run(kernel, &layout, a.as_ref(), None, [1, 2, 16][l % 3]);
            for j in 0..n {
                for i in j..n {
                    let (got, right) = (c[(i, j)].to_f64(), expected[(i, j)].to_f64());
                    assert_eq!(got.to_bits(), right.to_bits(), "{name}, {layout:?} at ({i}, {j})");
                }
                assert!((0..j).all(|i| c[(i, j)].to_f64().is_nan()), "the upper triangle");
            }
        }
    }
}

#[test]
fn every_kernel_and_layout_gives_the_bytes_of_the_integers() {
    for (m, n) in [(1, 1), (64, 32), (65, 33), (130, 7), (200, 100)] {
        for count in [13, 14, 15] {
            check_against_integers::<f64>(m, n, count, 3);
        }
        for count in [6, 7, 8] {
            check_against_integers::<f32>(m, n, count, 2);
        }
    }
    check_against_integers::<f64>(70, 40, 14, 150);
    check_against_integers::<f64>(70, 40, 14, -165);
    check_against_integers::<f32>(70, 40, 7, -20);
}

/// Returns entries that are awkward to round: of very different sizes, next to powers of two and
/// to the middle between numbers, subnormal, zero, and not finite.
fn awkward<T: IntegerOperand>(m: usize, n: usize, rng: &mut Rng) -> Mat<T> {
    let (least, digits) = if size_of::<T>() == 8 { (-1074, 52) } else { (-149, 23) };
    let finite = rng.bits().is_multiple_of(2);
    Mat::from_fn(m, n, |_, j| {
        let power = |e: u64| f64::from(-(e as i32)).exp2();
        let value = match rng.bits() % 16 {
            0 => 0.0,
            1 => 1.0 + power(digits),
            2 => 3.0 * power(rng.bits() % 60),
            3 => power(rng.bits() % 60),
            4 => f64::from(least / 2).exp2() * f64::from(least - least / 2).exp2(),
            5 if !finite && j % 3 == 1 => f64::INFINITY,
            6 if !finite && j % 5 == 2 => f64::NAN,
            7 => rng.normal() * power(rng.bits() % 100),
            8.. => 1.0,
            _ => rng.normal(),
        };
        T::from_f64(rng.sign() * value)
    })
}

/// Returns the product by its integers, in dirty memory.
fn run_small<T: IntegerOperand>(
    kernel: &dyn Kernel,
    moduli: usize,
    symmetric: bool,
    (a, b): (MatRef<'_, T>, Option<MatRef<'_, T>>),
    [alpha, beta]: [T; 2],
    mut c: Mat<T>,
) -> Mat<T> {
    let extents = [a.nrows(), a.ncols(), b.unwrap_or(a).ncols()];
    let len = small::scratch_len::<T>(extents, b.is_none());
    let mut scratch = Workspace::new(len).unwrap();
    let scratch = scratch.as_mut_slice();
    scratch.fill(T::from_f64(f64::NAN));
    let options = AtaOptions::default();
    let (c_mut, scratch) = (c.as_mut(), &mut scratch[..len]);
    small::execute(kernel, moduli, symmetric, alpha, a, b, beta, c_mut, &options, scratch).unwrap();
    c
}

fn check_small<T: IntegerOperand>(moduli: usize, rng: &mut Rng) {
    for (m, n, k) in [(1, 1, 1), (3, 2, 5), (64, 4, 3), (65, 17, 33), (800, 9, 2), (5, 40, 40)] {
        let (a, b) = (awkward::<T>(m, n, rng), awkward::<T>(k, m, rng));
        let square = awkward::<T>(m, n, rng);
        let of_a = (a.as_ref(), None);
        let of_both = (a.as_ref(), Some(b.transpose()));
        // Neither columns nor rows with adjacent entries.
        let triangle = (a.as_ref(), Some(square.as_ref().reverse_rows()));
        for (operands, symmetric) in [(of_a, true), (of_both, false), (triangle, true)] {
            let cols = operands.1.unwrap_or(operands.0).ncols();
            let factors = [[1.0, 0.0], [-0.75, 1.5]][m % 2].map(T::from_f64);
            let before = Mat::from_fn(n, cols, |_, _| T::from_f64(rng.normal()));
            let small = kernels().into_iter().map(|(name, kernel)| {
                (name, run_small(kernel, moduli, symmetric, operands, factors, before.clone()))
            });
            let small: Vec<_> = small.collect();
            let same = operands.1.is_none();
            let layout = ExactLayout::new([m, n, cols], size_of::<T>(), moduli, symmetric, same);
            let extents = [m, n, cols];
            let mut scratch = Workspace::new(scratch_len::<T>(extents, &layout, 1)).unwrap();
            for (name, kernel) in kernels() {
                let (options, mut c) = (AtaOptions::default().threads(1), before.clone());
                let ([alpha, beta], (a, b)) = (factors, operands);
                let scratch = scratch.as_mut_slice();
                execute(kernel, &layout, alpha, a, b, beta, c.as_mut(), &options, scratch).unwrap();
                for (by, small) in &small {
                    for (j, i) in (0..cols).flat_map(|j| (0..n).map(move |i| (j, i))) {
                        let [found, right] = [small, &c].map(|c| c[(i, j)].to_f64());
                        assert_eq!(
                            found.to_bits(),
                            right.to_bits(),
                            "{by}, {name}, {} {m} {n} {cols} ({i}, {j}): {found:e}, {right:e}",
                            T::NAME
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn small_products_have_the_bytes_that_residues_give_on_every_kernel() {
    let mut rng = Rng::new(53);
    for _ in 0..6 {
        for moduli in [13, 14, 15] {
            check_small::<f64>(moduli, &mut rng);
        }
        for moduli in [6, 7, 8] {
            check_small::<f32>(moduli, &mut rng);
        }
    }
}

/// Checks that A^T A by integers and by residues are the same bytes.
fn check_same(a: MatRef<'_, f64>, moduli: usize, what: &str) {
    let (m, n) = a.shape();
    let layout = ExactLayout::new([m, n, n], 8, moduli, true, true);
    let expected = run(&PORTABLE, &layout, a, None, 1);
    for (name, kernel) in kernels() {
        let c = run_small(kernel, moduli, true, (a, None), [1.0, 0.0], Mat::zeros(n, n));
        for (j, i) in (0..n).flat_map(|j| (j..n).map(move |i| (j, i))) {
            let [found, right] = [&c, &expected].map(|c| c[(i, j)]);
            let same = found.to_bits() == right.to_bits();
            assert!(same, "{name}, {what}, {m} rows, ({i}, {j}): {found:e}, {right:e}");
        }
    }
}

#[test]
fn columns_with_norms_next_to_a_step_of_their_powers_have_the_bytes_that_residues_give() {
    // With so few moduli entries have bits below the unit, so that another power would show.
    const MODULI: usize = 13;
    let distances = || (2..13).flat_map(|e| [1.0, -1.0].map(|sign| sign * 10_f64.powi(-e)));
    for m in [3, 64, 200] {
        let mut rng = Rng::new(m as u64);
        let mut a = Mat::from_fn(m, distances().count(), |_, _| rng.normal());
        let limit = columns::limit(Moduli::of(MODULI), m);
        for (j, distance) in distances().enumerate() {
            let norm = (0..m).map(|i| a[(i, j)] * a[(i, j)]).sum::<f64>().sqrt();
            for i in 0..m {
                a[(i, j)] *= limit / norm * (1.0 + distance);
            }
        }
        check_same(a.as_ref(), MODULI, "next to a step");
    }
}

#[test]
fn small_products_of_the_largest_and_least_entries_have_the_bytes_that_residues_give() {
    for spread in [150, -165] {
        check_same(random::<f64>(70, 20, spread, 3).as_ref(), 14, "extreme sizes");
    }
}

#[test]
fn small_products_stay_within_the_memory_of_their_plan() {
    for (m, n) in [(10, 10), (20_000, 3), (100_000, 1), (300, 40)] {
        for memory in [0, 1 << 16, 1 << 20] {
            let options = AtaOptions::new().scheme(SchemeChoice::Exact).memory(memory);
            let plan = Plan::ata::<f64>(m, n, &options).unwrap();
            let Strategy::Exact(exact) = &plan.strategy else { panic!("not exact") };
            let bytes = 8 * small::scratch_len::<f64>([m, n, n], true);
            assert!(!exact.small || bytes <= memory, "{m} x {n} takes {bytes} of {memory}");
        }
    }
}

#[test]
fn an_entry_next_to_the_middle_between_two_numbers_is_rounded_once_by_every_kernel() {
    // 1 + 2^-53 + 9 2^-110, and other distances from the middle between 1 and the next number.
    let power = |e: i32| f64::from(e).exp2();
    for distance in 1..40 {
        for sign in [1.0, -1.0] {
            let a =
                Mat::from_fn(3, 1, |i, _| [1.0, power(-27), f64::from(distance) * power(-55)][i]);
            let b = Mat::from_fn(3, 1, |i, _| [1.0, power(-26), sign * power(-55)][i]);
            let expected = if sign > 0.0 { 1.0 + f64::EPSILON } else { 1.0 };
            let layout = ExactLayout::new([3, 1, 1], 8, 15, false, false);
            for (name, kernel) in kernels() {
                let c = run(kernel, &layout, a.as_ref(), Some(b.as_ref()), 1);
                assert_eq!(c[(0, 0)], expected, "{name}, {distance} {sign}");
            }
            let operands = (a.as_ref(), Some(b.as_ref()));
            for (name, kernel) in kernels() {
                let c = run_small(kernel, 15, false, operands, [1.0, 0.0], Mat::zeros(1, 1));
                assert_eq!(c[(0, 0)], expected, "{name}, {distance} {sign}");
            }
        }
    }
}

#[test]
fn general_products_are_the_same_bytes_for_every_kernel_and_layout() {
    let (m, n, k) = (150, 70, 110);
    let (a, b) = (random::<f64>(m, n, 4, 1), random::<f64>(m, k, -3, 2));
    for symmetric in [false, true] {
        let b = if symmetric { random::<f64>(m, n, -3, 2) } else { b.clone() };
        let k = b.ncols();
        let whole = ExactLayout::new([m, n, k], 8, 14, symmetric, false);
        let expected = run(&PORTABLE, &whole, a.as_ref(), Some(b.as_ref()), 1);
        for (name, kernel) in kernels() {
            for layout in layouts(&whole) {
                let c = run(kernel, &layout, a.as_ref(), Some(b.as_ref()), 2);
                for j in 0..k {
                    for i in if symmetric { j } else { 0 }..n {
                        assert_eq!(c[(i, j)], expected[(i, j)], "{name}, {layout:?} at ({i}, {j})");
                    }
                }
            }
        }
        let right = a.transpose() * &b;
        for j in 0..k {
            for i in if symmetric { j } else { 0 }..n {
                let scale: f64 = (0..m).map(|r| (a[(r, i)] * b[(r, j)]).abs()).sum();
                assert!((expected[(i, j)] - right[(i, j)]).abs() <= 1e-14 * scale, "({i}, {j})");
            }
        }
    }
}

#[test]
fn only_amx_is_expected_to_beat_a_classical_product_and_only_a_wide_one() {
    // The time of the fastest back end that the planner knows.
    let classical = |m: f64, n: f64| m * n * n / 106e9 * (1.0 + 180.0 / n);
    for isa in IntegerIsa::ALL {
        let square = [100, 200, 300, 1024, 4096, 16_384].map(|n| (n, n));
        for (m, n) in square.into_iter().chain([(20_000, 200), (20_000, 1024)]) {
            let exact = estimate(isa, [m, n, n], 14, true, 1.0);
            let wins = isa == IntegerIsa::Amx && n >= 1024;
            let classical = 0.98 * classical(m as f64, n as f64);
            assert_eq!(exact < classical, wins, "{}, {m} x {n}", isa.name());
        }
    }
}

/// Shapes from small to beyond any memory.
const SHAPES: [[usize; 3]; 14] = [
    [0, 5, 5],
    [3, 0, 0],
    [1, 1, 1],
    [4096, 4096, 4096],
    [8192, 8192, 8192],
    [1_000_000, 100, 100],
    [30_000, 2500, 2500],
    [300_000, 500, 500],
    [200, 30_000, 30_000],
    [5000, 20_000, 20_000],
    [200_000, 20_000, 20_000],
    [16_384, 16_384, 16_384],
    [100_000, 3, 90_000],
    [4096, 12_000, 50],
];

/// Returns the batches of all rounds, in order.
fn all_batches(layout: &ExactLayout) -> impl Iterator<Item = Batch> {
    layout.pairs().flat_map(|pair| layout.batches(pair))
}

fn all_layouts() -> impl Iterator<Item = ([usize; 3], usize, ExactLayout)> {
    SHAPES.into_iter().flat_map(|shape| {
        [(8, 13), (8, 15), (4, 6), (4, 8)].into_iter().flat_map(move |(bytes, moduli)| {
            let [_, n, k] = shape;
            let square = n == k;
            let kinds = [(true, true), (true, false), (false, false)];
            kinds.into_iter().filter(move |&(symmetric, _)| square || !symmetric).map(
                move |(symmetric, same)| {
                    (shape, bytes, ExactLayout::new(shape, bytes, moduli, symmetric, same))
                },
            )
        })
    })
}

#[test]
fn memory_is_that_of_the_operands_and_256_mib() {
    for (shape @ [m, n, k], bytes, layout) in all_layouts() {
        let operands = bytes * m * if layout.same { n } else { n + k };
        let used = match bytes {
            8 => 8 * scratch_len::<f64>(shape, &layout, 8),
            _ => 4 * scratch_len::<f32>(shape, &layout, 8),
        };
        assert!(used <= operands + (256 << 20), "{shape:?}, {layout:?}: {used} for {operands}");
    }
}

#[test]
fn memory_is_what_it_was_limited_to() {
    const LIMIT: usize = 64 << 20;
    for shape in [[2048, 2048, 2048], [5000, 6000, 6000], [300, 20_000, 20_000], [100_000, 64, 64]]
    {
        for symmetric in [true, false] {
            let layout = ExactLayout::within(Some(LIMIT), shape, 8, 14, symmetric, symmetric);
            let used = 8 * scratch_len::<f64>(shape, &layout, 2);
            assert!(used <= LIMIT, "{shape:?}, {layout:?}: {used}");
            assert_ne!(layout, ExactLayout::new(shape, 8, 14, symmetric, symmetric));
        }
    }
}

#[test]
fn many_threads_get_several_blocks_each() {
    for (shape, _, layout) in all_layouts() {
        let cost = |layout: &ExactLayout| {
            all_batches(layout).flat_map(|b| b.units).map(|u| layout.cost(&u)).sum::<usize>()
        };
        assert_eq!(layout.for_threads(1), layout);
        for threads in [2, 16, 100] {
            let cut = layout.for_threads(threads);
            assert_eq!(cost(&cut), cost(&layout), "{shape:?}, {threads} threads");
            let batches: Vec<_> = all_batches(&cut).collect();
            let units: usize = batches.iter().map(|batch| batch.units.len()).sum();
            let enough = cut.moduli * units >= 3 * threads * batches.len();
            let least = cut.blocking.rows <= 8 && cut.blocking.cols <= 8;
            assert!(enough || least, "{shape:?}, {threads} threads: {cut:?}");
        }
    }
}

#[test]
fn rounds_cover_c_once_and_load_little() {
    for (shape, _, layout) in all_layouts() {
        let pairs: Vec<Pair> = layout.pairs().collect();
        let cost: usize = all_batches(&layout).flat_map(|b| b.units).map(|u| layout.cost(&u)).sum();
        let (left, right) = (layout.left, layout.right);
        let all = if layout.symmetric { left * (left + 1) / 2 } else { left * right };
        assert_eq!(cost, all, "{shape:?}, {layout:?}");
        let (mut held, mut loads): ([Option<Need>; 2], usize) = ([None; 2], 0);
        for pair in &pairs {
            let [a, b] = layout.needs(*pair);
            for need in [a, b] {
                if !held.contains(&Some(need)) {
                    loads += 1;
                    let other = if need == a { b } else { a };
                    held[usize::from(held[0] == Some(other))] = Some(need);
                }
            }
        }
        // A round needs one group that the round before it did not have.
        let most = if layout.groups == 1 { 2 } else { pairs.len() + 1 };
        assert!(loads <= most, "{layout:?}: {loads} loads, {} rounds", pairs.len());
    }
    let single = ExactLayout::new([64, 32, 32], 8, 14, true, true).pairs();
    assert_eq!(single.collect::<Vec<_>>(), [Pair { left: 0, right: 0 }]);
}

#[test]
fn operands_are_converted_again_where_memory_is_short() {
    let conversions = |memory, same| {
        ExactLayout::within(memory, [4096, 4096, 4096], 8, 14, same, same).conversions()
    };
    assert_eq!(conversions(None, true), 1.0);
    for same in [true, false] {
        let (little, less) =
            (conversions(Some(256 << 20), same), conversions(Some(64 << 20), same));
        assert!(1.0 < little && little < less, "{little}, {less}");
    }
}

#[test]
fn every_pair_of_panels_has_a_place_of_its_own_in_its_batch() {
    let shapes = [([300, 200, 200], true), ([300, 200, 90], false), ([5000, 300, 300], true)];
    for (shape, symmetric) in shapes {
        for layout in layouts(&ExactLayout::new(shape, 8, 14, symmetric, symmetric)) {
            for pair in layout.pairs() {
                let batches = layout.batches(pair);
                assert!(!layout.accumulates() || batches.len() == 1, "{layout:?}");
                for batch in batches {
                    let mut taken = vec![false; batch.places];
                    for unit in &batch.units {
                        for j in unit.cols.clone() {
                            for i in layout.rows_of(unit, j) {
                                let place = &mut taken[unit.place(i, j)];
                                assert!(!std::mem::replace(place, true), "{layout:?}: ({i}, {j})");
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Computes the rounds in the order that loads least, one after another from a list, in time that
/// grows with the square of their number; and how often a group is loaded in all.
fn rounds_from_a_list(layout: &ExactLayout) -> (Vec<Pair>, usize) {
    let wanted = |left: usize| 0..if layout.symmetric { left + 1 } else { layout.groups };
    let mut open: Vec<Pair> = (0..layout.groups)
        .flat_map(|left| wanted(left).map(move |right| Pair { left, right }))
        .collect();
    let (mut order, mut held, mut loaded) = (Vec::new(), Vec::<Need>::new(), 0);
    while !open.is_empty() {
        let loads = |p: &Pair| layout.needs(*p).iter().filter(|n| !held.contains(n)).count();
        let next = (0..open.len()).min_by_key(|&i| loads(&open[i])).unwrap();
        let pair = open.remove(next);
        let needs = layout.needs(pair);
        loaded += loads(&pair).min(if needs[0] == needs[1] { 1 } else { 2 });
        if needs[0] != needs[1] {
            held.clear();
        }
        held.extend(needs);
        order.push(pair);
    }
    (order, loaded)
}

#[test]
fn rounds_and_conversions_are_those_of_the_search_in_a_list() {
    for (symmetric, same) in [(true, true), (true, false), (false, false)] {
        for groups in 1..=24 {
            let whole = ExactLayout::new([64, 960, 960], 8, 14, symmetric, same);
            let layout = ExactLayout { groups, ..whole };
            let (order, loaded) = rounds_from_a_list(&layout);
            assert!(layout.pairs().eq(order), "{symmetric}, {same}, {groups}");
            let all = if same { groups } else { 2 * groups };
            let conversions = if groups == 1 { 1.0 } else { loaded as f64 / all as f64 };
            assert_eq!(layout.conversions(), conversions, "{symmetric}, {same}, {groups}");
        }
    }
}

#[test]
fn as_few_groups_as_fit_are_found() {
    for (n, k, same) in [(5000, 5000, true), (3000, 7000, false), (100, 9000, false)] {
        for memory in (10..30).map(|log| 1 << log) {
            let layout = ExactLayout::within(Some(memory), [1000, n, k], 8, 14, same, same);
            let residues = |groups: usize| ExactLayout { groups, ..layout.clone() }.stores();
            let bytes = |groups| residues(groups).iter().sum::<usize>();
            let most = layout.left.max(layout.right);
            let first = (1..most).find(|&groups| bytes(groups) <= memory / 2).unwrap_or(most);
            assert_eq!(layout.groups, first, "{n}, {k}, {memory}");
        }
    }
}

#[test]
fn no_batch_is_larger_than_the_largest() {
    let limited = SHAPES.into_iter().filter(|s| s[1] < 10_000 && s[2] < 10_000).flat_map(|shape| {
        [1 << 20, 16 << 20, 64 << 20].into_iter().flat_map(move |memory| {
            let kinds = [(true, true), (true, false), (false, false)];
            kinds.into_iter().filter(move |kind| !kind.0 || shape[1] == shape[2]).map(
                move |(symmetric, same)| {
                    ExactLayout::within(Some(memory), shape, 8, 14, symmetric, same)
                },
            )
        })
    });
    let small = |layout: &ExactLayout| layout.left.max(layout.right) < 300;
    for layout in limited.chain(all_layouts().map(|(_, _, layout)| layout).filter(small)) {
        for layout in layouts(&layout).into_iter().filter(|layout| layout.groups < 30) {
            let (units, places) = layout.largest_batch();
            let (mut rounds, mut largest) = (0, (0, 0));
            for batch in layout.pairs().flat_map(|pair| layout.batches(pair)) {
                assert!(batch.units.len() <= units && batch.places <= places, "{layout:?}");
                rounds += 1;
                largest = (largest.0.max(batch.units.len()), largest.1.max(batch.places));
            }
            // The bound is what is needed where a round is a batch.
            if rounds == 1 {
                assert_eq!((units, places), largest, "{layout:?}");
            }
        }
    }
}
