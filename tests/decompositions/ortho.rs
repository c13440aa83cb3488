//! Gram-Schmidt and Cholesky QR: orthonormality, reconstruction, rank, thresholds, awkward inputs.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use catamaran::base::Rng;
use catamaran::faer::{Mat, MatMut, MatRef};
use catamaran::ortho::{
    GramSchmidtOptions, Orthonormal, cholesky_qr, gram_schmidt, gram_schmidt_in_place,
    rank_revealing,
};
use catamaran::sparse::{CsMat, Mass};
use catamaran::{Error, Par};

fn random(n: usize, c: usize, seed: u64) -> Mat<f64> {
    let mut rng = Rng::new(seed);
    Mat::from_fn(n, c, |_, _| rng.uniform() - 0.5)
}

fn lumped(n: usize) -> Mass {
    Mass::Lumped((0..n).map(|i| 1.0 + 0.9 * (i as f64).sin()).collect())
}

/// A tridiagonal mass.
fn full(n: usize) -> Mass {
    let mut triplets = sprs::TriMat::new((n, n));
    for i in 0..n {
        triplets.add_triplet(i, i, 2.0 + (i as f64).cos());
        if i + 1 < n {
            triplets.add_triplet(i, i + 1, 0.3);
            triplets.add_triplet(i + 1, i, 0.3);
        }
    }
    let matrix: CsMat<f64> = triplets.to_csr();
    Mass::Full(matrix)
}

/// The largest entry of `|Q^T M Q - I|`.
fn defect(q: MatRef<'_, f64>, mass: &Mass) -> f64 {
    let mut weighted = Mat::zeros(q.nrows(), q.ncols());
    mass.multiply(q, weighted.as_mut(), Par::Seq).unwrap();
    let gram = q.transpose() * &weighted;
    let entries = (0..q.ncols()).flat_map(|j| (0..q.ncols()).map(move |i| (i, j)));
    entries.map(|p| (gram[p] - f64::from(p.0 == p.1)).abs()).fold(0.0, f64::max)
}

/// The M-lengths of the columns.
fn lengths(a: MatRef<'_, f64>, mass: &Mass) -> Vec<f64> {
    let mut weighted = Mat::zeros(a.nrows(), a.ncols());
    mass.multiply(a, weighted.as_mut(), Par::Seq).unwrap();
    (0..a.ncols()).map(|j| (a.col(j).transpose() * weighted.col(j)).sqrt()).collect()
}

/// Checks shapes, the triangle, and that Q R is A up to `slack` of each column for dropped columns,
/// up to rounding for the others.
fn check_factors(a: MatRef<'_, f64>, mass: &Mass, found: &Orthonormal, slack: f64) {
    check_factors_to(a, mass, found, 1e-13, slack);
}

/// [`check_factors`] up to `exact` of each column for those that are kept.
fn check_factors_to(a: MatRef<'_, f64>, mass: &Mass, found: &Orthonormal, exact: f64, slack: f64) {
    let Orthonormal { q, r, kept } = found;
    assert_eq!((q.nrows(), q.ncols()), (a.nrows(), kept.len()));
    assert_eq!((r.nrows(), r.ncols()), (kept.len(), a.ncols()));
    assert!(kept.is_sorted() && kept.windows(2).all(|w| w[0] < w[1]));
    for (i, &j) in kept.iter().enumerate() {
        assert!(r[(i, j)] > 0.0);
        assert!((i + 1..kept.len()).all(|l| r[(l, j)] == 0.0));
    }
    let gap = a - q * r;
    let (gaps, sizes) = (lengths(gap.as_ref(), mass), lengths(a, mass));
    for j in 0..a.ncols() {
        let allowed = if kept.contains(&j) { exact } else { slack };
        assert!(gaps[j] <= allowed * sizes[j], "column {j}: {:e} of {:e}", gaps[j], sizes[j]);
    }
}

fn precise() -> GramSchmidtOptions<'static> {
    GramSchmidtOptions::reorthogonalized().par(Par::Seq)
}

#[test]
fn independent_columns_stay_for_every_shape_and_mass() {
    for (n, c) in
        [(0, 0), (5, 0), (1, 1), (2, 1), (7, 7), (31, 8), (127, 9), (300, 257), (701, 523)]
    {
        for mass in [Mass::identity(n), lumped(n), full(n)] {
            let a = random(n, c, 1);
            let found = gram_schmidt(a.as_ref(), &mass, &precise()).unwrap();
            assert_eq!(found.kept, (0..c).collect::<Vec<_>>(), "{n} x {c}");
            check_factors(a.as_ref(), &mass, &found, 1e-9);
            assert!(defect(found.q.as_ref(), &mass) < 1e-13, "{n} x {c}");
        }
    }
}

#[test]
fn more_columns_than_rows_have_the_rank_of_the_rows() {
    let (n, c) = (61, 700);
    let a = random(n, c, 2);
    let found = gram_schmidt(a.as_ref(), &lumped(n), &precise()).unwrap();
    assert_eq!(found.kept, (0..n).collect::<Vec<_>>());
    check_factors(a.as_ref(), &lumped(n), &found, 1e-9);
}

#[test]
fn a_single_pass_keeps_no_more_columns_than_there_are_rows() {
    // Products of a few functions: many nearly dependent columns, and more of them than rows.
    for n in [10, 30, 90] {
        let power = |i: usize, j: usize| (i as f64 / n as f64 - 0.5).powi(j as i32 % 40);
        let wave = |i: usize, j: usize| ((1 + j / 40) as f64 * i as f64 / n as f64).cos();
        let a = Mat::from_fn(n, 20 * n, |i, j| power(i, j) * wave(i, j));
        let options = GramSchmidtOptions::single_pass().threshold(1e-13);
        let found = gram_schmidt(a.as_ref(), &Mass::identity(n), &options).unwrap();
        assert!(found.kept.len() <= n, "{} of {n}", found.kept.len());
    }
}

#[test]
fn duplicates_zeros_and_sums_are_dropped() {
    let (n, mass) = (400, full(400));
    let mut a = random(n, 600, 3);
    for j in 0..600 {
        match j % 4 {
            1 => a.col_mut(j).fill(0.0),
            2 => a.copy_column(j - 2, j, -3.0),
            3 => {
                // The sum of two that stay, one of them far back.
                let back = j - 3 - (j - 3) / 8 * 4;
                let sum = Mat::from_fn(n, 1, |i, _| a[(i, j - 3)] + 7.0 * a[(i, back)]);
                a.col_mut(j).copy_from(sum.col(0));
            }
            _ => {}
        }
    }
    let found = gram_schmidt(a.as_ref(), &mass, &precise()).unwrap();
    assert_eq!(found.kept, (0..600).step_by(4).collect::<Vec<_>>());
    check_factors(a.as_ref(), &mass, &found, 1e-9);
    assert!(defect(found.q.as_ref(), &mass) < 1e-12);
}

/// A multiple of a column, in place of another.
trait CopyColumn {
    fn copy_column(&mut self, from: usize, to: usize, factor: f64);
}

impl CopyColumn for Mat<f64> {
    fn copy_column(&mut self, from: usize, to: usize, factor: f64) {
        for i in 0..self.nrows() {
            self[(i, to)] = factor * self[(i, from)];
        }
    }
}

#[test]
fn small_and_large_columns_are_treated_alike() {
    let (n, c) = (500, 90);
    let mut a = random(n, c, 4);
    for j in 0..c {
        let size = 10f64.powi(-((j * 5 % 15) as i32));
        a.col_mut(j).iter_mut().for_each(|x| *x *= size);
    }
    let found = gram_schmidt(a.as_ref(), &lumped(n), &precise()).unwrap();
    assert_eq!(found.kept.len(), c);
    check_factors(a.as_ref(), &lumped(n), &found, 1e-9);
    assert!(defect(found.q.as_ref(), &lumped(n)) < 1e-13);
}

#[test]
fn the_threshold_is_what_is_left_relative_to_the_column() {
    // Column j is e_0 + 10^-j e_j: the rest after projection is 10^-j of it.
    let (n, c) = (40, 13);
    let a = Mat::from_fn(n, c, |i, j| match i {
        0 => 1.0,
        _ if i == j => 10f64.powi(-(j as i32)),
        _ => 0.0,
    });
    let mass = Mass::identity(n);
    for exponent in [1, 2, 5, 9, 11] {
        let threshold = 0.3 * 10f64.powi(-exponent);
        for reorthogonalize in [false, true] {
            let options = precise().threshold(threshold).reorthogonalize(reorthogonalize);
            let found = gram_schmidt(a.as_ref(), &mass, &options).unwrap();
            assert_eq!(found.kept, (0..=exponent as usize).collect::<Vec<_>>(), "{threshold:e}");
            check_factors(a.as_ref(), &mass, &found, 1.01 * threshold);
        }
    }
}

#[test]
fn nearly_dependent_columns_are_orthogonal_to_rounding() {
    // Two hundred columns near a space of twenty dimensions, at distances from 1 to 1e-8.
    let (n, c) = (900, 600);
    let mass = lumped(n);
    let (base, noise) = (random(n, 20, 5), random(n, c, 6));
    let mix = random(20, c, 7);
    let mut a = &base * &mix;
    for j in 0..c {
        let size = 10f64.powi(-((j % 9) as i32));
        (0..n).for_each(|i| a[(i, j)] += size * noise[(i, j)]);
    }
    let found = gram_schmidt(a.as_ref(), &mass, &precise()).unwrap();
    check_factors(a.as_ref(), &mass, &found, 1e-9);
    assert!(found.kept.len() > 590, "{}", found.kept.len());
    let defect = defect(found.q.as_ref(), &mass);
    assert!(defect < 1e-12, "{defect:e}");
}

#[test]
fn negative_overlaps_are_repaired_like_positive_ones() {
    // The thesis' reference code repairs only positive ones.
    let (n, mass) = (300, lumped(300));
    let base = random(n, 1, 8);
    let noise = random(n, 40, 9);
    for sign in [1.0, -1.0] {
        let a = Mat::from_fn(n, 40, |i, j| match j {
            0 => base[(i, 0)],
            _ => sign * base[(i, 0)] + 1e-7 * noise[(i, j)],
        });
        let found = gram_schmidt(a.as_ref(), &mass, &precise()).unwrap();
        assert_eq!(found.kept.len(), 40);
        assert!((1..40).all(|j| sign * found.r[(0, j)] > 0.0));
        assert!(defect(found.q.as_ref(), &mass) < 1e-13);
    }
}

#[test]
fn a_single_pass_is_orthogonal_as_far_as_its_threshold_allows() {
    let (n, c) = (800, 300);
    let a = random(n, c, 10);
    let options = GramSchmidtOptions::single_pass().par(Par::Seq);
    let found = gram_schmidt(a.as_ref(), &lumped(n), &options).unwrap();
    check_factors(a.as_ref(), &lumped(n), &found, 1e-2);
    assert!(defect(found.q.as_ref(), &lumped(n)) < 1e-9);
}

#[test]
fn strides_and_threads_change_no_byte() {
    let (n, c) = (3001, 270);
    let a = random(n, c, 11);
    for mass in [lumped(n), full(n)] {
        let one = gram_schmidt(a.as_ref(), &mass, &precise()).unwrap();
        for threads in [2, 3] {
            let options = precise().threads(threads);
            let more = gram_schmidt(a.as_ref(), &mass, &options).unwrap();
            assert_eq!((&one.q, &one.r, &one.kept), (&more.q, &more.r, &more.kept));
        }
    }
    // By rows, in place, in every second place.
    let mass = lumped(n);
    let mut by_rows = vec![f64::NAN; 2 * n * c];
    let mut view = MatMut::from_row_major_slice_mut(&mut by_rows, n, 2 * c);
    for j in 0..c {
        view.as_mut().col_mut(2 * j).copy_from(a.col(j));
    }
    let (rows, cols) = (view.row_stride(), 2 * view.col_stride());
    let start = view.as_ptr_mut();
    // SAFETY: every second column of the matrix above, which is not used meanwhile.
    let strided = unsafe { MatMut::from_raw_parts_mut(start, n, c, rows, cols) };
    let factors = gram_schmidt_in_place(strided, &mass, &precise()).unwrap();
    let q = Mat::from_fn(n, c, |i, j| by_rows[2 * (i * c + j)]);
    assert!(by_rows.iter().skip(1).step_by(2).all(|x| x.is_nan()));
    let found = Orthonormal { q, r: factors.r, kept: factors.kept };
    check_factors(a.as_ref(), &mass, &found, 1e-9);
    assert!(defect(found.q.as_ref(), &mass) < 1e-13);
}

#[test]
fn cholesky_qr_agrees_and_refuses_dependent_columns() {
    for (n, c) in [(0, 0), (4, 0), (1, 1), (13, 13), (997, 100)] {
        for mass in [lumped(n), full(n)] {
            let a = random(n, c, 12);
            let mut q = a.clone();
            let r = cholesky_qr(q.as_mut(), &mass, Par::Threads(2)).unwrap();
            let found = Orthonormal { q, r, kept: (0..c).collect() };
            check_factors(a.as_ref(), &mass, &found, 0.0);
            assert!(defect(found.q.as_ref(), &mass) < 1e-13);
        }
    }
    // A condition of about 1e12, which one Cholesky factorization can't do.
    let (n, mass) = (500, lumped(500));
    let (base, noise) = (random(n, 1, 13), random(n, 10, 14));
    let a = Mat::from_fn(n, 10, |i, j| base[(i, 0)] + 1e-12 * noise[(i, j)]);
    let mut q = a.clone();
    cholesky_qr(q.as_mut(), &mass, Par::Seq).unwrap();
    assert!(defect(q.as_ref(), &mass) < 1e-13);
    let mut twice = random(n, 10, 15);
    twice.copy_column(2, 7, 1.0);
    let refused = cholesky_qr(twice.as_mut(), &mass, Par::Seq).unwrap_err();
    assert!(matches!(refused, Error::Argument { what: "A", .. }), "{refused}");
    let refused = cholesky_qr(random(3, 4, 1).as_mut(), &lumped(3), Par::Seq).unwrap_err();
    assert!(refused.to_string().contains("4 columns of 3 rows"));
}

/// A way to make columns orthonormal.
type Method = fn(MatRef<'_, f64>, &Mass) -> Result<Orthonormal, Error>;

const METHODS: [Method; 4] = [
    |a, mass| {
        let mut q = a.to_owned();
        let r = cholesky_qr(q.as_mut(), mass, Par::Seq)?;
        Ok(Orthonormal { q, r, kept: (0..a.ncols()).collect() })
    },
    |a, mass| gram_schmidt(a, mass, &GramSchmidtOptions::single_pass()),
    |a, mass| gram_schmidt(a, mass, &precise()),
    |a, mass| rank_revealing(a, mass, &precise()),
];

#[test]
fn columns_may_have_any_length() {
    let n = 30;
    let scales = [1e160, 1.0, 1e-170, 1e-300, 1e300, 1e-100];
    for mass in [Mass::identity(n), lumped(n), full(n)] {
        let near = random(n, scales.len(), 17);
        let mut a = near.clone();
        for (j, scale) in scales.into_iter().enumerate() {
            a.col_mut(j).iter_mut().for_each(|x| *x *= scale);
        }
        for method in METHODS {
            let expected = method(near.as_ref(), &mass).unwrap();
            let found = method(a.as_ref(), &mass).unwrap();
            assert_eq!(found.kept, expected.kept);
            assert!(defect(found.q.as_ref(), &mass) < 1e-13);
            assert!((&found.q - &expected.q).norm_max() < 1e-12);
            for (j, scale) in scales.into_iter().enumerate() {
                for i in 0..=j {
                    let gap = (found.r[(i, j)] / scale - expected.r[(i, j)]).abs();
                    assert!(gap < 1e-12 * expected.r[(j, j)].max(1.0), "({i}, {j}): {gap:e}");
                }
            }
        }
    }
}

#[test]
fn a_column_far_smaller_than_the_others_is_dropped_only_if_it_depends_on_them() {
    let n = 30;
    let mut a = random(n, 5, 17);
    a.copy_column(0, 2, 1e-200);
    a.copy_column(1, 3, 1e200);
    a.col_mut(4).iter_mut().for_each(|x| *x *= 1e-310);
    for method in &METHODS[1..] {
        assert_eq!(method(a.as_ref(), &lumped(n)).unwrap().kept, [0, 1, 4]);
    }
}

#[test]
fn a_column_whose_length_overflows_is_named() {
    let n = 30;
    let mut a = random(n, 4, 17);
    a.col_mut(2).iter_mut().for_each(|x| *x = x.signum() * f64::MAX);
    for method in METHODS {
        let refused = method(a.as_ref(), &Mass::identity(n)).unwrap_err();
        assert_eq!(refused.to_string(), "A: column 2 is too long: its length overflows");
    }
}

#[test]
fn masses_that_make_squares_of_lengths_overflow_are_named() {
    let a = Mat::from_fn(3, 2, |i, j| 1e30 * ((i + 1) as f64).powi(j as i32));
    for method in METHODS {
        let refused = method(a.as_ref(), &Mass::Lumped(vec![1e300; 3])).unwrap_err();
        assert_eq!(refused.to_string(), "mass: so large that squares of lengths overflow");
    }
}

/// Columns of which a first pass takes far more for independent than there are: what later columns
/// were freed from must not be dropped with them.
#[test]
fn nearly_dependent_columns_lose_no_more_than_the_threshold() {
    let (n, c) = (200, 60);
    let gaussian = |i: usize, j: usize| {
        let x = i as f64 / n as f64 - j as f64 / c as f64;
        (-8.0 * x * x).exp()
    };
    let a = Mat::from_fn(n, c, gaussian);
    for mass in [Mass::identity(n), lumped(n), full(n)] {
        for threshold in [1e-12, 1e-9, 1e-6] {
            let options = precise().threshold(threshold);
            let found = gram_schmidt(a.as_ref(), &mass, &options).unwrap();
            assert!(defect(found.q.as_ref(), &mass) < 1e-13);
            check_factors(a.as_ref(), &mass, &found, threshold);
            let by_rank = rank_revealing(a.as_ref(), &mass, &options).unwrap();
            assert!(defect(by_rank.q.as_ref(), &mass) < 1e-13);
            let gap = (&by_rank.q * &by_rank.r - &a).norm_max();
            assert!(gap < 100.0 * threshold, "{gap:e} for {threshold:e}");
        }
    }
}

#[test]
fn dirty_inputs_are_refused_and_work_can_be_cancelled() {
    let (n, c) = (50, 600);
    let mut a = random(n, c, 16);
    let short = Mass::identity(n - 1);
    assert!(matches!(
        gram_schmidt(a.as_ref(), &short, &precise()).unwrap_err(),
        Error::Shape { what: "mass", .. }
    ));
    for threshold in [0.0, 1.0, -1.0, f64::NAN] {
        let options = precise().threshold(threshold);
        let refused = gram_schmidt(a.as_ref(), &lumped(n), &options).unwrap_err();
        assert!(matches!(refused, Error::Argument { what: "threshold", .. }));
    }
    let calls = AtomicUsize::new(0);
    let stop = |_: f64| match calls.fetch_add(1, Ordering::Relaxed) {
        1 => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let options = precise().progress(&stop);
    assert_eq!(gram_schmidt(a.as_ref(), &lumped(n), &options).unwrap_err(), Error::Cancelled);
    a[(3, 5)] = f64::INFINITY;
    assert_eq!(
        gram_schmidt(a.as_ref(), &lumped(n), &precise()).unwrap_err(),
        Error::NonFinite { what: "A", index: (3, 5) }
    );
}

/// Columns whose singular values, in the Euclidean inner product, fall to `least` by equal factors.
fn decaying(n: usize, c: usize, least: f64) -> Mat<f64> {
    let orthonormal = |n, seed| {
        let a = random(n, c, seed);
        gram_schmidt(a.as_ref(), &Mass::identity(n), &precise()).unwrap().q
    };
    let values = Mat::from_fn(c, c, |i, j| match i == j {
        true => least.powf(i as f64 / (c - 1) as f64),
        false => 0.0,
    });
    orthonormal(n, 11) * values * orthonormal(c, 12).transpose()
}

#[test]
fn the_rank_is_that_of_the_singular_values() {
    let (n, c) = (400, 120);
    let a = decaying(n, c, 1e-16);
    // Every column has something of its own.
    let all = gram_schmidt(a.as_ref(), &Mass::identity(n), &precise()).unwrap();
    for mass in [Mass::identity(n), lumped(n), full(n)] {
        let scaled = {
            // Singular values in the inner product of M are those of L^T A, M = L L^T.
            let mut gram = Mat::<f64>::zeros(n, n);
            mass.multiply(Mat::identity(n, n).as_ref(), gram.as_mut(), Par::Seq).unwrap();
            let l = gram.llt(faer::Side::Lower).unwrap().L().to_owned();
            let mut b = l.transpose() * &a;
            for column in b.col_iter_mut() {
                let length = column.norm_l2();
                column.iter_mut().for_each(|x| *x /= length);
            }
            b
        };
        let values = scaled.singular_values().unwrap();
        for threshold in [1e-2, 1e-6, 1e-9] {
            let rank = values.iter().filter(|v| **v > threshold * values[0]).count();
            assert!(rank < all.kept.len(), "{rank}, and Gram-Schmidt {}", all.kept.len());
            let options = precise().threshold(threshold);
            let found = rank_revealing(a.as_ref(), &mass, &options).unwrap();
            assert_eq!(found.kept.len(), rank);
            // What pivoting leaves is larger than the best by a moderate factor.
            let slack = 30.0 * threshold * values[0];
            check_factors_to(a.as_ref(), &mass, &found, 2.0 * threshold, slack);
            assert!(defect(found.q.as_ref(), &mass) < 1e-12);
            let threads = options.threads(3);
            let again = rank_revealing(a.as_ref(), &mass, &threads).unwrap();
            assert_eq!((again.q, again.r, again.kept), (found.q, found.r, found.kept));
        }
    }
}

#[test]
fn rank_revealing_keeps_what_is_independent_and_drops_what_is_nothing() {
    for (n, c) in [(0, 0), (5, 0), (1, 1), (7, 7), (127, 9), (300, 257)] {
        let (mass, a) = (lumped(n), random(n, c, 1));
        let plain = gram_schmidt(a.as_ref(), &mass, &precise()).unwrap();
        let found = rank_revealing(a.as_ref(), &mass, &precise()).unwrap();
        assert_eq!((found.kept.len(), found.q), (c, plain.q), "{n} x {c}");
    }
    let zeros = Mat::<f64>::zeros(9, 3);
    assert_eq!(rank_revealing(zeros.as_ref(), &lumped(9), &precise()).unwrap().kept, [0usize; 0]);
    let wrong = precise().threshold(2.0);
    let refused = rank_revealing(zeros.as_ref(), &lumped(9), &wrong).unwrap_err();
    assert!(refused.to_string().starts_with("threshold: "));
}
