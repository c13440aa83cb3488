//! The native path through the public calls: every instruction set, scheme and layout.

use catamaran::base::Rng;
use catamaran::blas::{self, Backend, BlasReal, Native};
use std::sync::Arc;

use catamaran::faer::{Mat, MatMut, MatRef};
use catamaran::kernel::packed::{FloatIsa, Rates};
use catamaran::product::{ata_planned, atb_planned};
use catamaran::{AtaOptions, Par, Plan, SchemeChoice, Uplo, aat_into, ata_into, atb_into};

use crate::common::{bits, gaussian, integers, oracle};

const SCHEMES: [SchemeChoice; 4] =
    [SchemeChoice::Float, SchemeChoice::Classical, SchemeChoice::Winograd, SchemeChoice::Kgp4];

const UPLOS: [Uplo; 3] = [Uplo::Lower, Uplo::Upper, Uplo::Both];

/// Every instruction set that this machine has, with products that seem to cost so much that the
/// planner takes every fast level it may.
fn natives() -> impl Iterator<Item = Arc<dyn Backend>> {
    let usable = FloatIsa::ALL.into_iter().filter(|i| i.refusal().is_none());
    usable.map(|i| -> Arc<dyn Backend> {
        Arc::new(Native::new(i, Rates { flops: 1e8, ..Rates::of(i) }))
    })
}

/// Options for every instruction set and scheme, with blocks down to `leaf`, as many threads as
/// come next, and the triangles in turn.
fn all_options(leaf: usize) -> impl Iterator<Item = AtaOptions<'static>> {
    let pairs = natives().flat_map(|b| SCHEMES.into_iter().map(move |s| (b.clone(), s)));
    pairs.enumerate().map(move |(i, (backend, scheme))| {
        AtaOptions::new()
            .backend(backend)
            .scheme(scheme)
            .leaf(leaf)
            .uplo(UPLOS[i % UPLOS.len()])
            .par(Par::Threads(1 + i % 2))
    })
}

/// How C lies in the memory around it.
#[derive(Debug, Clone, Copy)]
enum Layout {
    Columns,
    Rows,
    /// Every second row and column, backwards.
    Spread,
}

const LAYOUTS: [Layout; 3] = [Layout::Columns, Layout::Rows, Layout::Spread];

impl Layout {
    /// Memory for an n x k matrix and some more.
    fn memory<T: BlasReal>(self, n: usize, k: usize) -> Mat<T> {
        let (rows, cols) = match self {
            Self::Columns => (n + 3, k + 2),
            Self::Rows => (k + 3, n + 2),
            Self::Spread => (2 * n + 2, 2 * k + 2),
        };
        Mat::from_fn(rows, cols, |_, _| T::from_f64(POISON))
    }

    /// The n x k matrix in it.
    fn of<T: BlasReal>(self, memory: &mut Mat<T>, n: usize, k: usize) -> MatMut<'_, T> {
        match self {
            Self::Columns => memory.as_mut().submatrix_mut(1, 1, n, k),
            Self::Rows => memory.as_mut().submatrix_mut(1, 1, k, n).transpose_mut(),
            Self::Spread => {
                let whole = memory.as_mut().submatrix_mut(1, 1, 2 * n, 2 * k);
                let whole = whole.reverse_rows_and_cols_mut();
                let (down, across) = (2 * whole.row_stride(), 2 * whole.col_stride());
                // SAFETY: every second row and column of a borrowed matrix of twice the extents.
                unsafe { MatMut::from_raw_parts_mut(whole.as_ptr_mut(), n, k, down, across) }
            }
        }
    }
}

/// What no product has.
const POISON: f64 = -7_654_321.0;

/// Calls `run(alpha, beta, C)` on every layout of C and checks all of the memory: `alpha product +
/// beta C` where `wanted`, and nothing else. With beta zero C holds NaN before.
fn check<T: BlasReal>(
    product: &Mat<f64>,
    wanted: impl Fn(usize, usize) -> bool,
    mut run: impl FnMut(T, T, MatMut<'_, T>),
) {
    let (n, k) = product.shape();
    // The lower triangle is what is read for both.
    let old = |i: usize, j: usize| ((3 * i.max(j) + 5 * i.min(j)) % 7) as f64 - 3.0;
    for (layout, (alpha, beta)) in LAYOUTS.into_iter().zip([(1.0, 0.0), (-2.0, 1.0), (1.0, -2.0)]) {
        let (mut got, mut expected) = (layout.memory::<T>(n, k), layout.memory::<T>(n, k));
        let (mut c, mut e) = (layout.of(&mut got, n, k), layout.of(&mut expected, n, k));
        for j in 0..k {
            for i in (0..n).filter(|&i| wanted(i, j)) {
                let (start, rest) =
                    if beta == 0.0 { (f64::NAN, 0.0) } else { (old(i, j), beta * old(i, j)) };
                c[(i, j)] = T::from_f64(start);
                e[(i, j)] = T::from_f64(alpha * product[(i, j)] + rest);
            }
        }
        run(T::from_f64(alpha), T::from_f64(beta), c);
        assert!(got == expected, "{layout:?}, alpha {alpha}, beta {beta}, {n} x {k}");
    }
}

fn wanted(uplo: Uplo) -> impl Fn(usize, usize) -> bool {
    move |i, j| match uplo {
        Uplo::Lower => i >= j,
        Uplo::Upper => i <= j,
        Uplo::Both => true,
    }
}

/// A^T A in dirty scratch of the very length asked for.
fn check_ata<T: BlasReal>(a: MatRef<'_, T>, product: &Mat<f64>, options: &AtaOptions<'_>) {
    let (m, n) = a.shape();
    let plan = Plan::ata::<T>(m, n, options).unwrap();
    let len = plan.scratch_len::<T>(options.par);
    check::<T>(product, wanted(options.uplo), |alpha, beta, c| {
        let mut scratch = vec![T::from_f64(f64::NAN); len];
        ata_planned(&plan, alpha, a, beta, c, options, Some(&mut scratch)).unwrap();
    });
}

/// A^T B in dirty scratch of the very length asked for.
fn check_atb<T: BlasReal>(
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    product: &Mat<f64>,
    options: &AtaOptions<'_>,
) {
    let plan = Plan::atb::<T>(a.nrows(), a.ncols(), b.ncols(), options).unwrap();
    let len = plan.scratch_len::<T>(options.par);
    check::<T>(
        product,
        |_, _| true,
        |alpha, beta, c| {
            let mut scratch = vec![T::from_f64(f64::NAN); len];
            atb_planned(&plan, alpha, a, b, beta, c, options, Some(&mut scratch)).unwrap();
        },
    );
}

/// A^T B by the definition.
fn product(a: &Mat<f64>, weights: Option<&[f64]>, b: &Mat<f64>) -> Mat<f64> {
    let zero = Mat::<f64>::zeros(a.ncols(), b.ncols());
    oracle(1.0, a.as_ref(), weights, b.as_ref(), 0.0, zero.as_ref())
}

/// The same values in a longer row-major matrix, of which they are a part.
fn by_rows<T: BlasReal>(a: &Mat<f64>) -> Mat<T> {
    let (m, n) = a.shape();
    let inside = |i, j| (1..=n).contains(&i) && (2..2 + m).contains(&j);
    Mat::from_fn(n + 3, m + 2, |i, j| {
        T::from_f64(if inside(i, j) { a[(j - 2, i - 1)] } else { f64::NAN })
    })
}

fn check_shape<T: BlasReal>([m, n, k]: [usize; 3], leaf: usize) {
    let (a, b) = (integers::<f64>(m, n, 1), integers::<f64>(m, k, 2));
    let (square, general) = (product(&a, None, &a), product(&a, None, &b));
    let rows = by_rows::<T>(&a);
    let rows = rows.as_ref().submatrix(1, 2, n, m).transpose();
    let (a, b) = (integers::<T>(m, n, 1), integers::<T>(m, k, 2));
    for options in all_options(leaf) {
        check_ata(a.as_ref(), &square, &options);
        check_ata(rows, &square, &options);
        check_atb(rows, b.as_ref(), &general, &options);
    }
}

#[test]
fn small_and_prime_sizes_are_exact() {
    for m in [0, 1, 2, 31, 101] {
        for (n, k) in [(0, 2), (1, 0), (1, 1), (2, 1), (29, 31), (53, 47)] {
            check_shape::<f64>([m, n, k], 8);
            check_shape::<f32>([m, n, k], 8);
        }
    }
}

#[test]
fn sizes_of_several_blocks_are_exact() {
    check_shape::<f64>([701, 257, 211], 32);
    check_shape::<f32>([503, 307, 130], 32);
    check_shape::<f64>([120, 600, 50], 100);
}

#[test]
fn a_square_of_many_panels_is_exact() {
    let a = integers::<f64>(509, 523, 3);
    let square = product(&a, None, &a);
    let single = integers::<f32>(509, 523, 3);
    for options in all_options(64) {
        check_ata(a.as_ref(), &square, &options);
        check_ata(single.as_ref(), &square, &options);
    }
}

#[test]
fn slabs_of_tall_matrices_are_exact() {
    /// Rows repeat, so that the definition is quick.
    const PERIOD: usize = 97;
    let m = 20_000;
    let weights: Vec<f64> = (0..PERIOD).map(|r| ((m - r).div_ceil(PERIOD)) as f64).collect();
    for (n, k) in [(3, 2), (40, 40), (200, 31)] {
        let (a, b) = (integers::<f64>(PERIOD, n, 4), integers::<f64>(PERIOD, k, 5));
        let square = product(&a, Some(&weights), &a);
        let general = product(&a, Some(&weights), &b);
        let (a, b) = (repeated::<f64>(m, &a), repeated::<f64>(m, &b));
        let single = repeated::<f32>(m, &a);
        for options in all_options(32).filter(|o| o.scheme != SchemeChoice::Winograd) {
            check_ata(a.as_ref(), &square, &options);
            check_ata(single.as_ref(), &square, &options);
            check_atb(a.as_ref(), b.as_ref(), &general, &options);
        }
    }
}

/// The rows of `a` over and over.
fn repeated<T: BlasReal>(m: usize, a: &Mat<f64>) -> Mat<T> {
    Mat::from_fn(m, a.ncols(), |i, j| T::from_f64(a[(i % a.nrows(), j)]))
}

#[test]
fn built_in_rates_give_the_same_integers() {
    let a = integers::<f64>(211, 97, 11);
    let square = product(&a, None, &a);
    for isa in FloatIsa::ALL {
        // A refused isa falls back to the portable one.
        let backend = blas::native_on(isa);
        let scheme = SchemeChoice::Float;
        let options = AtaOptions::new().backend(backend).scheme(scheme);
        check_ata(a.as_ref(), &square, &options);
    }
}

#[test]
fn a_a_transposed_is_that_of_the_transpose() {
    let a = integers::<f64>(130, 90, 6);
    let t = a.transpose().to_owned();
    let square = product(&t, None, &t);
    for options in all_options(16) {
        check::<f64>(&square, wanted(options.uplo), |alpha, beta, c| {
            aat_into(alpha, a.as_ref(), beta, c, &options).unwrap();
        });
    }
}

fn zeros<T: BlasReal>(n: usize, k: usize) -> Mat<T> {
    Mat::from_fn(n, k, |_, _| T::ZERO)
}

fn check_threads<T: BlasReal>(m: usize, n: usize, k: usize) {
    let (a, b) = (gaussian::<T>(m, n, 7), gaussian::<T>(m, k, 8));
    for options in all_options(64) {
        let results = |threads| {
            let options = options.clone().threads(threads);
            let (mut c, mut d) = (zeros::<T>(n, n), zeros::<T>(n, k));
            ata_into(T::ONE, a.as_ref(), T::ZERO, c.as_mut(), &options).unwrap();
            atb_into(T::ONE, a.as_ref(), b.as_ref(), T::ZERO, d.as_mut(), &options).unwrap();
            (bits(c.as_ref()), bits(d.as_ref()))
        };
        let alone = results(1);
        for threads in [2, 5] {
            assert!(results(threads) == alone, "{:?}, {threads} threads", options.scheme);
        }
    }
}

#[test]
fn results_are_bitwise_equal_for_any_number_of_threads() {
    check_threads::<f64>(600, 301, 257);
    check_threads::<f32>(400, 200, 333);
    check_threads::<f64>(20_000, 40, 7);
}

/// The lower triangle of A^T A in twice the precision (Ogita, Rump, Oishi 2005, algorithm 5.3).
fn accurate<T: BlasReal>(a: MatRef<'_, T>) -> Mat<f64> {
    let wide = Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)].to_f64());
    let column = |j: usize| wide.col(j).try_as_col_major().unwrap().as_slice();
    let dot = |x: &[f64], y: &[f64]| {
        let (mut sum, mut error) = (0.0, 0.0);
        for (&x, &y) in x.iter().zip(y) {
            let p = x * y;
            let next: f64 = sum + p;
            let part = next - sum;
            error += f64::mul_add(x, y, -p) + ((sum - (next - part)) + (p - part));
            sum = next;
        }
        sum + error
    };
    Mat::from_fn(a.ncols(), a.ncols(), |i, j| if i < j { 0.0 } else { dot(column(i), column(j)) })
}

fn check_errors<T: BlasReal>(name: &str, a: &Mat<T>) {
    let n = a.ncols();
    let exact = accurate(a.as_ref());
    for backend in natives() {
        let error = |scheme| {
            let options =
                AtaOptions::new().scheme(scheme).leaf(64).backend(backend.clone()).par(Par::Seq);
            let plan = Plan::ata::<T>(a.nrows(), n, &options).unwrap();
            assert_eq!(plan.is_fast(), scheme != SchemeChoice::Classical);
            let mut c = zeros::<T>(n, n);
            ata_into(T::ONE, a.as_ref(), T::ZERO, c.as_mut(), &options).unwrap();
            let lower = (0..n).flat_map(|j| (j..n).map(move |i| (i, j)));
            lower.map(|at| (c[at].to_f64() - exact[at]).abs()).fold(0.0, f64::max)
        };
        let classical = error(SchemeChoice::Classical);
        for scheme in [SchemeChoice::Float, SchemeChoice::Winograd, SchemeChoice::Kgp4] {
            let ratio = error(scheme) / classical;
            assert!(ratio <= 4.0, "{name} {}, {scheme:?}: {ratio} times", T::NAME);
        }
    }
}

#[test]
fn fast_levels_cost_at_most_the_accuracy_promised() {
    let mut rng = Rng::new(9);
    let uniform = Mat::from_fn(500, 300, |_, _| rng.uniform());
    check_errors("uniform", &uniform);
    check_errors("uniform", &Mat::from_fn(500, 300, |i, j| uniform[(i, j)] as f32));
    check_errors("Gaussian", &gaussian::<f64>(500, 300, 10));
    check_errors("Gaussian", &gaussian::<f32>(500, 300, 10));
}

/// A with column `j` times `2^power(j)`.
fn graded(a: &Mat<f64>, power: impl Fn(usize) -> i32) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * 2_f64.powi(power(j)))
}

#[test]
fn scaled_columns_do_not_spoil_each_other() {
    let power = |j: usize| (j as i32 * 37) % 181 - 90;
    let (a, b) = (integers::<f64>(65, 47, 40), integers::<f64>(65, 33, 41));
    let (ga, gb) = (graded(&a, power), graded(&b, power));
    let expected = |x: &Mat<f64>, y: &Mat<f64>| {
        let whole = product(x, None, y);
        Mat::from_fn(x.ncols(), y.ncols(), |i, j| whole[(i, j)] * 2_f64.powi(power(i) + power(j)))
    };
    for backend in natives() {
        for scheme in [SchemeChoice::Winograd, SchemeChoice::Kgp4] {
            let options =
                AtaOptions::new().backend(backend.clone()).scheme(scheme).leaf(6).uplo(Uplo::Both);
            let run = |options: &AtaOptions<'_>| {
                let (mut c, mut d) = (zeros::<f64>(47, 47), zeros::<f64>(47, 33));
                ata_into(1.0, ga.as_ref(), 0.0, c.as_mut(), options).unwrap();
                atb_into(1.0, ga.as_ref(), gb.as_ref(), 0.0, d.as_mut(), options).unwrap();
                (c, d)
            };
            let (c, d) = run(&options);
            assert!(c == expected(&a, &a) && d == expected(&a, &b), "{scheme:?}");
        }
    }
}
