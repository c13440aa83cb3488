//! Comparison of results with exact ones, in rational arithmetic.

use faer::{Mat, MatRef};
use num_bigint::BigInt;

use super::*;
use crate::base::{Error, Par, Rng};
use crate::rows::{About, ExtendedGram};

/// Entries of the tests are multiples of 2^-UNIT.
const UNIT: i32 = 160;

/// Returns `x 2^unit`, an integer.
fn integer(x: f64, unit: i32) -> BigInt {
    let bits = x.abs().to_bits();
    let (exponent, fraction) = ((bits >> 52) as i32, bits & ((1 << 52) - 1));
    let mantissa = if exponent > 0 { fraction | 1 << 52 } else { fraction };
    let shift = exponent.max(1) - 1075 + unit;
    let size = if shift >= 0 {
        BigInt::from(mantissa) << shift
    } else {
        assert!(mantissa == 0 || mantissa.trailing_zeros() as i32 >= -shift, "{x:e} is too fine");
        BigInt::from(mantissa >> (-shift).min(63))
    };
    if x < 0.0 { -size } else { size }
}

/// Returns `value 2^-unit`, approximately.
fn float(value: &BigInt, unit: i32) -> f64 {
    let shift = value.bits().saturating_sub(64) as i32;
    let size = i128::try_from(value >> shift).unwrap() as f64;
    let (half, rest) = ((shift - unit) / 2, (shift - unit) - (shift - unit) / 2);
    size * f64::from(half).exp2() * f64::from(rest).exp2()
}

/// Returns `numerator / denominator 2^-unit` in three parts.
fn parts(numerator: &BigInt, denominator: &BigInt, unit: i32) -> [f64; 3] {
    const MORE: i32 = 1200;
    let mut rest = (numerator << MORE) / denominator;
    std::array::from_fn(|_| {
        let part = float(&rest, unit + MORE);
        rest -= integer(part, unit + MORE);
        part
    })
}

fn ratio(numerator: &BigInt, denominator: &BigInt) -> f64 {
    parts(numerator, denominator, 0)[0]
}

/// Returns the Gram matrix of rows as integers times 2^-2 UNIT.
fn products(a: MatRef<'_, f64>) -> Vec<Vec<BigInt>> {
    let columns: Vec<Vec<_>> =
        (0..a.ncols()).map(|j| a.col(j).iter().map(|&x| integer(x, UNIT)).collect()).collect();
    let dot = |x: &[BigInt], y: &[BigInt]| x.iter().zip(y).map(|(x, y)| x * y).sum();
    columns.iter().map(|x| columns.iter().map(|y| dot(x, y)).collect()).collect()
}

fn gram_with(a: MatRef<'_, f64>, exact: bool) -> ExtendedGram {
    let (products, m) = (products(a), a.nrows());
    let about = About {
        exact,
        rows: m as u64,
        observations: m as u64,
        weight: m as f64,
        mean: vec![],
        vanished: vec![],
    };
    let one = BigInt::from(1);
    ExtendedGram::from_entries(a.ncols(), about, Par::Seq, |i, j| {
        parts(&products[i][j], &one, 2 * UNIT)
    })
    .unwrap()
}

fn gram(a: MatRef<'_, f64>) -> ExtendedGram {
    gram_with(a, true)
}

/// Returns the Gram matrix about the mean.
fn centered(a: MatRef<'_, f64>) -> ExtendedGram {
    let (products, m) = (products(a), BigInt::from(a.nrows()));
    let sum = |j: usize| a.col(j).iter().map(|&x| integer(x, UNIT)).sum::<BigInt>();
    let sums: Vec<_> = (0..a.ncols()).map(sum).collect();
    let mean = sums.iter().map(|sum| parts(sum, &m, UNIT)).map(|[a, b, _]| [a, b]).collect();
    let about = About {
        exact: true,
        rows: a.nrows() as u64,
        observations: a.nrows() as u64,
        weight: a.nrows() as f64,
        mean,
        vanished: vec![],
    };
    ExtendedGram::from_entries(a.ncols(), about, Par::Seq, |i, j| {
        parts(&(&products[i][j] * &m - &sums[i] * &sums[j]), &m, 2 * UNIT)
    })
    .unwrap()
}

/// Returns `C^-1 B` as numerators over a denominator, the determinant of C (Bareiss 1968).
fn solve(mut c: Vec<Vec<BigInt>>, b: &[Vec<BigInt>]) -> (Vec<Vec<BigInt>>, BigInt) {
    let n = c.len();
    for (row, b) in c.iter_mut().zip(b) {
        row.extend(b.iter().cloned());
    }
    let mut last = BigInt::from(1);
    for k in 0..n {
        assert_ne!(c[k][k], BigInt::ZERO, "a pivot of these matrices is not zero");
        for i in (0..n).filter(|&i| i != k) {
            for j in (0..c[i].len()).filter(|&j| j != k) {
                let value = &c[i][j] * &c[k][k] - &c[i][k] * &c[k][j];
                c[i][j] = value / &last;
            }
            c[i][k] = BigInt::ZERO;
        }
        last = c[k][k].clone();
        // Rows that were eliminated keep the new pivot on their diagonal.
        (0..k).for_each(|i| c[i][i] = last.clone());
    }
    (c.into_iter().map(|row| row[n..].to_vec()).collect(), last)
}

fn identity(n: usize) -> Vec<Vec<BigInt>> {
    (0..n).map(|i| (0..n).map(|j| BigInt::from(u8::from(i == j))).collect()).collect()
}

/// Returns the normal equations of the first columns of the products and the last one.
fn normal_equations(products: &[Vec<BigInt>]) -> (Vec<Vec<BigInt>>, Vec<Vec<BigInt>>) {
    let n = products.len() - 1;
    let c = products[..n].iter().map(|row| row[..n].to_vec()).collect();
    (c, products[..n].iter().map(|row| vec![row[n].clone()]).collect())
}

fn near(found: f64, exact: f64, bound: f64) {
    assert!((found - exact).abs() <= bound * exact.abs(), "{found:e} and not {exact:e}");
}

/// Returns powers 0 to 10 of 82 points in [-8.78, -3.13] and a noisy target: like Filip of NIST,
/// whose condition number is 1.8e15.
fn filip() -> Mat<f64> {
    let mut rng = Rng::new(3);
    let point = |i: usize| -8.78 + 5.65 * i as f64 / 81.0;
    let noise: Vec<_> = (0..82).map(|_| 3e-3 * rng.normal()).collect();
    Mat::from_fn(82, 12, |i, j| match j {
        11 => 0.8 + 0.1 * (3.0 * point(i)).sin() + noise[i],
        _ => point(i).powi(j as i32),
    })
}

fn random(m: usize, n: usize, seed: u64) -> Mat<f64> {
    let mut rng = Rng::new(seed);
    Mat::from_fn(m, n, |_, _| rng.normal())
}

#[test]
fn a_polynomial_of_degree_10_comes_out_to_15_digits_with_residual_and_errors() {
    let a = filip();
    let found = LeastSquares::from_gram(&gram(a.as_ref()), 1, &LeastSquaresOptions::new()).unwrap();
    let products = products(a.as_ref());
    let (c, b) = normal_equations(&products);
    let (x, determinant) = solve(c.clone(), &b);
    for j in 0..11 {
        near(found.coefficients[(j, 0)], ratio(&x[j][0], &determinant), f64::EPSILON);
    }
    // b^T b - x^T A^T b
    let fitted: BigInt = x.iter().zip(&b).map(|(x, b)| &x[0] * &b[0]).sum();
    let square = &products[11][11] * &determinant - fitted;
    let square = parts(&square, &determinant, 2 * UNIT)[0];
    near(found.residual_norms[0], square.sqrt(), 4.0 * f64::EPSILON);
    let total = float(&products[11][11], 2 * UNIT);
    near(found.r_squared[0], 1.0 - square / total, 4.0 * f64::EPSILON);
    assert_eq!((found.rank, found.degrees_of_freedom), (11, 71));
    let (inverse, determinant) = solve(c, &identity(11));
    for j in 0..11 {
        let variance = parts(&inverse[j][j], &determinant, -2 * UNIT)[0] * square / 71.0;
        near(found.standard_errors[(j, 0)], variance.sqrt(), 1e-11);
    }
    assert!((1e15..3e15).contains(&found.condition), "{:e}", found.condition);
    assert!(found.digits > 15.0, "{}", found.digits);
}

#[test]
fn an_intercept_is_the_coefficient_of_a_column_of_ones() {
    let a = random(37, 4, 4);
    let options = LeastSquaresOptions::new().intercept(true);
    let centered = centered(a.as_ref());
    let found = LeastSquares::from_gram(&centered, 1, &options).unwrap();
    let ones = Mat::from_fn(37, 5, |i, j| if j == 0 { 1.0 } else { a[(i, j - 1)] });
    let plain =
        LeastSquares::from_gram(&gram(ones.as_ref()), 1, &LeastSquaresOptions::new()).unwrap();
    near(found.intercepts[0], plain.coefficients[(0, 0)], f64::EPSILON);
    near(found.intercept_errors[0], plain.standard_errors[(0, 0)], 1e-14);
    for j in 0..3 {
        near(found.coefficients[(j, 0)], plain.coefficients[(j + 1, 0)], f64::EPSILON);
        near(found.standard_errors[(j, 0)], plain.standard_errors[(j + 1, 0)], 1e-14);
    }
    near(found.residual_norms[0], plain.residual_norms[0], 1e-15);
    assert_eq!(found.degrees_of_freedom, plain.degrees_of_freedom);
    let total = centered.entry(3, 3)[0];
    near(found.r_squared[0], 1.0 - found.residual_norms[0].powi(2) / total, 1e-14);
}

#[test]
fn a_ridge_is_that_of_rational_arithmetic() {
    let a = filip();
    let products = products(a.as_ref());
    let (plain, b) = normal_equations(&products);
    for ridge in [1e-20, 0.5, 1e12] {
        let options = LeastSquaresOptions::new().ridge(ridge);
        let found = LeastSquares::from_gram(&gram(a.as_ref()), 1, &options).unwrap();
        let mut c = plain.clone();
        (0..11).for_each(|j| c[j][j] += integer(ridge, 2 * UNIT));
        let (x, determinant) = solve(c.clone(), &b);
        for j in 0..11 {
            near(found.coefficients[(j, 0)], ratio(&x[j][0], &determinant), f64::EPSILON);
        }
        // |A x - b|^2 = b^T b - 2 x^T A^T b + x^T C x, over the square of the denominator.
        let mut square = &products[11][11] * &determinant * &determinant;
        for i in 0..11 {
            square -= &x[i][0] * &b[i][0] * &determinant * 2;
            square += (0..11).map(|j| &x[i][0] * &plain[i][j] * &x[j][0]).sum::<BigInt>();
        }
        let square = parts(&square, &(&determinant * &determinant), 2 * UNIT)[0];
        near(found.residual_norms[0], square.sqrt(), 4.0 * f64::EPSILON);
        let (inverse, determinant) = solve(c, &identity(11));
        for j in 0..11 {
            let row = &inverse[j];
            let sum: BigInt = (0..11)
                .flat_map(|k| (0..11).map(move |l| (k, l)))
                .map(|(k, l)| &row[k] * &plain[k][l] * &row[l])
                .sum();
            let variance = parts(&sum, &(&determinant * &determinant), -2 * UNIT)[0];
            let exact = (variance * square / 71.0).sqrt();
            near(found.standard_errors[(j, 0)], exact, 1e-9);
        }
    }
}

#[test]
fn an_exact_fit_has_no_residual() {
    // Like Wampler 1 of NIST: the sum of powers 0 to 5 of 0 to 20.
    let a = Mat::from_fn(21, 7, |i, j| match j {
        6 => (0..6).map(|k| (i as f64).powi(k)).sum(),
        _ => (i as f64).powi(j as i32),
    });
    let found = LeastSquares::from_gram(&gram(a.as_ref()), 1, &LeastSquaresOptions::new()).unwrap();
    assert_eq!(found.coefficients, Mat::<f64>::ones(6, 1));
    assert_eq!((found.residual_norms[0], found.r_squared[0]), (0.0, 1.0));
    assert_eq!(found.standard_errors, Mat::<f64>::zeros(6, 1));
}

#[test]
fn of_fewer_rows_than_columns_the_solution_of_least_norm_comes_out() {
    // x = A^T (A A^T)^-1 b
    for (m, n) in [(1, 3), (3, 5), (5, 7), (7, 31)] {
        let a = random(m, n + 1, (m + n) as u64);
        let options = LeastSquaresOptions::new();
        let found = LeastSquares::from_gram(&gram(a.as_ref()), 1, &options).unwrap();
        assert_eq!((found.rank, found.degrees_of_freedom), (m, 0));
        assert!(found.standard_errors[(0, 0)].is_nan());
        let rows = products(a.subcols(0, n).transpose());
        let b: Vec<_> = (0..m).map(|i| vec![integer(a[(i, n)], UNIT)]).collect();
        let (z, determinant) = solve(rows, &b);
        let scale = found.coefficients.norm_max();
        for j in 0..n {
            let x: BigInt = (0..m).map(|i| integer(a[(i, j)], UNIT) * &z[i][0]).sum();
            let exact = parts(&x, &determinant, 0)[0];
            assert!((found.coefficients[(j, 0)] - exact).abs() < 1e-15 * scale);
        }
        assert_eq!(found.residual_norms[0], 0.0);
    }
}

#[test]
fn columns_that_depend_on_others_are_shared_or_refused_by_name() {
    let mut a = random(29, 6, 5);
    for i in 0..29 {
        a[(i, 1)] = 0.0;
        a[(i, 4)] = a[(i, 2)];
    }
    let options = LeastSquaresOptions::new();
    let found = LeastSquares::from_gram(&gram(a.as_ref()), 1, &options).unwrap();
    let reduced = Mat::from_fn(29, 4, |i, j| a[(i, [0, 2, 3, 5][j])]);
    let own = LeastSquares::from_gram(&gram(reduced.as_ref()), 1, &options).unwrap();
    assert_eq!(found.rank, 3);
    let x = |j: usize| found.coefficients[(j, 0)];
    let y = |j: usize| own.coefficients[(j, 0)];
    assert_eq!((x(1), x(2)), (0.0, x(4)));
    near(x(0), y(0), f64::EPSILON);
    near(2.0 * x(2), y(1), f64::EPSILON);
    let error = |j: usize| found.standard_errors[(j, 0)];
    near(2.0 * error(4), own.standard_errors[(1, 0)], 1e-14);
    assert_eq!(error(1), 0.0);
    near(found.residual_norms[0], own.residual_norms[0], f64::EPSILON);
    let refuse = options.rank_deficiency(RankDeficiency::Refuse);
    let refused = LeastSquares::from_gram(&gram(a.as_ref()), 1, &refuse).unwrap_err();
    assert!(refused.to_string().contains("columns 1, 4 depend on others"), "{refused}");
}

#[test]
fn what_is_no_problem_is_refused() {
    let a = random(7, 3, 6);
    let plain = gram(a.as_ref());
    let options = LeastSquaresOptions::new();
    let what = |targets, options| match LeastSquares::from_gram(&plain, targets, &options) {
        Err(Error::Argument { what, .. }) => what,
        other => panic!("{other:?}"),
    };
    assert_eq!(what(0, options), "targets");
    assert_eq!(what(4, options), "targets");
    assert_eq!(what(1, options.ridge(-1.0)), "ridge");
    assert_eq!(what(1, options.ridge(f64::NAN)), "ridge");
    assert_eq!(what(1, options.intercept(true)), "intercept");
    let none = Mat::zeros(2, 0);
    let refused = lstsq(none.as_ref(), none.as_ref(), None, &options).unwrap_err().to_string();
    assert_eq!(refused, "targets: must be at least 1, but the rows have no columns");
    // No columns at all.
    let found = LeastSquares::from_gram(&plain, 3, &options).unwrap();
    assert_eq!((found.rank, found.coefficients.nrows(), found.condition), (0, 0, 1.0));
    near(found.residual_norms[2], plain.entry(2, 2)[0].sqrt(), f64::EPSILON);
    let nan = mat_of(&[f64::NAN]);
    let nan = ExtendedGram::from_f64(nan.as_ref(), 1, &[]).unwrap();
    let refused = SingularValues::from_gram(&nan, Par::Seq).unwrap_err();
    assert_eq!(refused, Error::NonFinite { what: "gram", index: (0, 0) });
    let negative = mat_of(&[-1.0]);
    let negative = ExtendedGram::from_f64(negative.as_ref(), 1, &[]).unwrap();
    assert!(orthogonality(&negative).is_err());
    let uncentered = PrincipalComponents::from_gram(&plain, &PrincipalComponentsOptions::new());
    assert!(uncentered.is_err() && correlation(&plain).is_err());
}

/// Returns a matrix of one column.
fn mat_of(column: &[f64]) -> Mat<f64> {
    Mat::from_fn(column.len(), 1, |i, _| column[i])
}

#[test]
fn the_factor_gives_the_matrix_back_to_100_bits_for_any_pivoting_and_threads() {
    for n in [0, 1, 2, 7, 64, 65, 131] {
        let mut a = random(n + 3, n, n as u64 + 1);
        for j in 0..n {
            let scale = f64::from(3 * (j % 7) as i32 - 9).exp2();
            (0..n + 3).for_each(|i| a[(i, j)] *= scale);
        }
        let gram = ExtendedGram::from_f64((a.transpose() * &a).as_ref(), 9, &[]).unwrap();
        for pivoting in [Pivoting::Scaled, Pivoting::Largest, Pivoting::Natural] {
            let factor = PivotedCholesky::from_gram(&gram, pivoting, Par::Seq).unwrap();
            let other = PivotedCholesky::from_gram(&gram, pivoting, Par::Threads(3)).unwrap();
            assert_eq!(factor.rank(), n);
            assert_eq!(factor.order(), other.order());
            assert_eq!(factor.lower.parts, other.lower.parts);
            if pivoting == Pivoting::Natural {
                assert!(factor.order().is_sorted());
            }
            for j in 0..n {
                for i in 0..=j {
                    let (p, q) = (factor.order()[i], factor.order()[j]);
                    let product = |k| factor.entry(k, i) * factor.entry(k, j);
                    let sum = (0..=i).fold(DoubleDouble::ZERO, |sum, k| sum + product(k));
                    let gap = sum - DoubleDouble::from(gram.entry(p, q)[0]);
                    let size = (gram.entry(p, p)[0] * gram.entry(q, q)[0]).sqrt();
                    assert!(gap.hi.abs() < 2f64.powi(-98) * size, "{n} {i} {j} {gap:?}");
                }
            }
        }
    }
}

#[test]
fn the_rank_is_that_of_the_columns_whatever_their_scales() {
    for (n, rank) in [(5, 0), (7, 3), (67, 66), (131, 70)] {
        let (left, right) = (random(n + 2, rank, 7), random(rank, n, 8));
        let integers =
            |m: &Mat<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| (100.0 * m[(i, j)]).round());
        let mut a = integers(&left) * integers(&right);
        for j in 0..n {
            let scale = f64::from(5 * (j % 9) as i32 - 20).exp2();
            (0..n + 2).for_each(|i| a[(i, j)] *= scale);
        }
        let exact = gram(a.as_ref());
        for pivoting in [Pivoting::Scaled, Pivoting::Largest] {
            let factor = PivotedCholesky::from_gram(&exact, pivoting, Par::Seq).unwrap();
            let found = (factor.rank(), factor.dependent().len());
            assert_eq!(found, (rank, n - rank), "{pivoting:?}");
        }
    }
}

#[test]
fn a_column_that_differs_by_2_to_the_minus_45_counts_only_where_entries_are_exact() {
    let mut a = random(31, 3, 9);
    (0..31).for_each(|i| a[(i, 2)] = a[(i, 0)] + f64::from(-45).exp2() * a[(i, 1)].round());
    let rank = |exact| {
        let gram = gram_with(a.as_ref(), exact);
        PivotedCholesky::from_gram(&gram, Pivoting::Scaled, Par::Seq).unwrap().rank()
    };
    assert_eq!((rank(true), rank(false)), (3, 2));
}

#[test]
fn condition_numbers_are_near_those_of_a_known_matrix() {
    // Orthogonal columns.
    let a = Mat::from_fn(5, 4, |i, j| if i == j { f64::from(10 * j as i32).exp2() } else { 0.0 });
    let gram = gram(a.as_ref());
    let factor = PivotedCholesky::from_gram(&gram, Pivoting::Scaled, Par::Seq).unwrap();
    assert_eq!(factor.scaled_condition().unwrap(), 1.0);
    near(factor.condition().unwrap(), f64::from(30).exp2(), 0.01);
}

/// Returns the Hilbert matrix in f64, whose condition number at n = 10 is 1.6e13.
fn hilbert(n: usize) -> Mat<f64> {
    Mat::from_fn(n, n, |i, j| 1.0 / (i + j + 1) as f64)
}

#[test]
fn the_product_of_all_singular_values_is_the_determinant() {
    for n in [1, 2, 5, 8, 10] {
        for scale in [0, 30] {
            let mut a = hilbert(n);
            for j in 0..n {
                let power = f64::from(scale * (j % 3) as i32).exp2();
                (0..n).for_each(|i| a[(i, j)] *= power);
            }
            let found = SingularValues::from_gram(&gram(a.as_ref()), Par::Seq).unwrap();
            let rows: Vec<Vec<_>> =
                (0..n).map(|i| (0..n).map(|j| integer(a[(i, j)], UNIT)).collect()).collect();
            let (_, determinant) = solve(rows, &identity(n));
            let exact = float(&determinant, n as i32 * UNIT).abs();
            assert_eq!(found.rank(), n);
            let product: f64 = found.values.iter().product();
            // The condition number of 10 columns is 1e13, its square 1e26; double-double has 106
            // bits.
            let bound = if n < 10 { 1e-13 } else { 1e-4 };
            near(product, exact, bound);
            let orthogonal = found.v.transpose() * &found.v - Mat::<f64>::identity(n, n);
            assert!(orthogonal.norm_max() < 1e-14);
        }
    }
}

#[test]
fn the_smallest_singular_value_of_two_near_columns_has_15_digits() {
    // [[1, 1], [0, d]]: the values have the product d and squares of the sum 2 + d^2.
    for exponent in [-10, -20, -40] {
        let d = f64::from(exponent).exp2();
        let a = Mat::from_fn(2, 2, |i, j| [[1.0, 1.0], [0.0, d]][i][j]);
        let found = SingularValues::from_gram(&gram(a.as_ref()), Par::Seq).unwrap();
        let largest = ((2.0 + d * d + (4.0 + d.powi(4)).sqrt()) / 2.0).sqrt();
        near(found.values[0], largest, 4.0 * f64::EPSILON);
        near(found.values[1], d / largest, 8.0 * f64::EPSILON);
    }
}

/// Returns the Gram matrix of columns times powers of two.
fn shifted(gram: &ExtendedGram, shifts: &[i32]) -> ExtendedGram {
    let (rows, mean) = (gram.rows(), gram.mean());
    let times = |x: f64, power: i32| double::scaled(x, power);
    let mean = mean.iter().zip(shifts).map(|(m, &s)| m.map(|m| times(m, s))).collect();
    let about = About {
        exact: true,
        rows,
        observations: gram.observations(),
        weight: gram.weight(),
        mean,
        vanished: vec![],
    };
    let entry = |i, j| gram.entry(i, j).map(|part| times(part, shifts[i] + shifts[j]));
    ExtendedGram::from_entries(gram.n(), about, Par::Seq, entry).unwrap()
}

/// Returns the exponents of columns of three sizes that are `shift` powers of two apart.
fn sizes(n: usize, shift: i32) -> Vec<i32> {
    (0..n).map(|j| shift * ((2 * j % 3) as i32 - 1)).collect()
}

#[test]
fn singular_values_of_columns_1e270_apart_are_those_of_columns_1e30_apart() {
    // Columns of other sizes then count for nothing but the space that they span.
    for n in [2, 3, 11, 40] {
        let gram = gram(random(n + 5, n, 17).as_ref());
        let values = |shift| {
            let gram = shifted(&gram, &sizes(n, shift));
            SingularValues::from_gram(&gram, Par::Seq).unwrap()
        };
        let mut order = sizes(n, 1);
        order.sort_unstable_by_key(|&size| -size);
        let base = values(100);
        assert_eq!(base.rank(), n);
        for shift in [200, 330, 440] {
            let found = values(shift);
            for k in 0..n {
                let power = double::scaled(1.0, order[k] * (shift - 100));
                near(found.values[k], base.values[k] * power, 1e-14);
            }
            let orthogonal = found.v.transpose() * &found.v - Mat::<f64>::identity(n, n);
            assert!(orthogonal.norm_max() < 1e-14);
        }
    }
}

#[test]
fn components_of_columns_1e270_apart_are_those_of_columns_1e30_apart() {
    let n = 7;
    let gram = centered(random(19, n, 18).as_ref());
    for standardize in [false, true] {
        let options = PrincipalComponentsOptions::new().standardize(standardize);
        let of = |shift| {
            let gram = shifted(&gram, &sizes(n, shift));
            PrincipalComponents::from_gram(&gram, &options).unwrap()
        };
        let (base, found) = (of(100), of(440));
        for k in 0..n {
            let size = if standardize { 0 } else { [1, 1, 0, 0, -1, -1, -1][k] };
            let power = double::scaled(1.0, size * 340);
            near(found.singular_values[k], base.singular_values[k] * power, 1e-14);
            near(found.explained_variance[k], base.explained_variance[k] * power * power, 1e-14);
        }
    }
}

#[test]
fn coefficients_of_columns_1e270_apart_are_those_of_columns_of_one_size() {
    let (n, a) = (6, random(23, 7, 19));
    let of = |shift: i32| {
        let mut shifts = sizes(n, shift);
        shifts.push(-shift / 2);
        let gram = shifted(&gram(a.as_ref()), &shifts);
        (shifts, LeastSquares::from_gram(&gram, 1, &LeastSquaresOptions::new()).unwrap())
    };
    let (_, base) = of(0);
    for shift in [100, 330, 440] {
        let (shifts, found) = of(shift);
        assert_eq!(found.rank, n);
        for j in 0..n {
            let power = |x: f64| double::scaled(x, shifts[n] - shifts[j]);
            assert_eq!(found.coefficients[(j, 0)], power(base.coefficients[(j, 0)]));
            near(found.standard_errors[(j, 0)], power(base.standard_errors[(j, 0)]), 1e-14);
        }
        let norm = double::scaled(base.residual_norms[0], shifts[n]);
        assert_eq!(found.residual_norms[0], norm);
        assert_eq!((found.r_squared[0], found.digits), (base.r_squared[0], base.digits));
        assert!(found.condition > double::scaled(0.1, 2 * shift), "{:e}", found.condition);
    }
}

#[test]
fn singular_values_of_dependent_columns_are_zero() {
    let a = Mat::from_fn(5, 3, |i, j| ((i + 1) * (j + 1)) as f64);
    let found = SingularValues::from_gram(&gram(a.as_ref()), Par::Threads(2)).unwrap();
    assert_eq!((found.rank(), &found.values[1..]), (1, &[0.0, 0.0][..]));
    near(found.values[0], (55.0_f64 * 14.0).sqrt(), 1e-15);
    near(found.v[(2, 0)].abs(), 3.0 / 14_f64.sqrt(), 1e-15);
}

#[test]
fn whitened_scores_have_variance_1_and_no_correlation() {
    let (m, n) = (53, 5);
    let mut a = random(m, n, 11);
    for i in 0..m {
        a[(i, 1)] = 1e3 + 1e-6 * a[(i, 1)] + a[(i, 0)];
    }
    for standardize in [false, true] {
        let options = PrincipalComponentsOptions::new().standardize(standardize).whiten(true);
        let gram = centered(a.as_ref());
        let found = PrincipalComponents::from_gram(&gram, &options).unwrap();
        assert_eq!(found.components.nrows(), n);
        let total: f64 = found.explained_variance_ratio.iter().sum();
        near(total, 1.0, 1e-14);
        let scores = found.scores(a.as_ref()).unwrap();
        let covariance = scores.transpose() * &scores * faer::Scale(1.0 / (m - 1) as f64);
        // The data have 1e-6 of 1e3 in one direction: seven digits are left to scores.
        assert!((covariance - Mat::<f64>::identity(n, n)).norm_max() < 1e-6);
        let variance: f64 = found.explained_variance.iter().sum();
        let own: f64 = (0..n).map(|j| gram.entry(j, j)[0] / (m - 1) as f64).sum();
        near(variance, if standardize { n as f64 } else { own }, 1e-14);
        for k in 0..n {
            let row = found.components.row(k);
            let largest = row.iter().fold(0.0_f64, |a, &b| if b.abs() > a.abs() { b } else { a });
            assert!(largest > 0.0);
        }
    }
}

#[test]
fn components_are_cut_by_number_and_by_share() {
    // Variances 16, 4 and 1 times 8 / 7.
    let a = Mat::from_fn(8, 3, |i, j| {
        let sign = if i >> j & 1 == 0 { 1.0 } else { -1.0 };
        sign * [4.0, 2.0, 1.0][j] + 5.0
    });
    let gram = centered(a.as_ref());
    let count = |components| {
        let options = PrincipalComponentsOptions::new().components(components);
        PrincipalComponents::from_gram(&gram, &options).map(|found| found.components.nrows())
    };
    assert_eq!(count(Components::All), Ok(3));
    assert_eq!(count(Components::Count(2)), Ok(2));
    assert_eq!(count(Components::Share(0.7)), Ok(1));
    assert_eq!(count(Components::Share(0.9)), Ok(2));
    assert_eq!(count(Components::Share(1.0)), Ok(3));
    for wrong in [Components::Count(4), Components::Share(0.0), Components::Share(f64::NAN)] {
        assert!(matches!(count(wrong), Err(Error::Argument { what: "components", .. })));
    }
    let all = PrincipalComponents::from_gram(&gram, &PrincipalComponentsOptions::new()).unwrap();
    for (k, variance) in [16.0, 4.0, 1.0].into_iter().enumerate() {
        near(all.explained_variance[k], variance * 8.0 / 7.0, 1e-14);
        near(all.components[(k, k)], 1.0, 1e-14);
    }
}

#[test]
fn correlations_of_near_columns_are_not_lost() {
    let mut a = random(41, 3, 12);
    for i in 0..41 {
        a[(i, 1)] = 2.0 * a[(i, 0)];
        a[(i, 2)] = 7.0;
    }
    let found = correlation(&centered(a.as_ref())).unwrap();
    assert_eq!((found[(0, 0)], found[(1, 0)], found[(0, 1)]), (1.0, 1.0, 1.0));
    assert!(found[(2, 2)].is_nan() && found[(2, 0)].is_nan());
}

#[test]
fn columns_become_orthonormal_to_rounding_at_condition_1e14() {
    let columns = |m: usize, n: usize, condition: f64| {
        // Mostly the same direction, and a little of others.
        let mut a = random(m, n, n as u64);
        for j in 1..n {
            for i in 0..m {
                a[(i, j)] = a[(i, 0)] * j as f64 + a[(i, j)] / condition;
            }
        }
        a
    };
    let powers = filip();
    let powers = powers.subcols(0, 11).to_owned();
    for (a, least) in [
        (columns(67, 5, 1e3), 1e3),
        (columns(67, 13, 1e10), 1e10),
        (columns(97, 31, 1e12), 1e14),
        (powers, 1e9),
    ] {
        let gram = gram(a.as_ref());
        let factor = PivotedCholesky::from_gram(&gram, Pivoting::Scaled, Par::Seq).unwrap();
        assert!(factor.scaled_condition().unwrap() > least);
        let qr = GramQr::from_gram(&gram, Par::Seq).unwrap();
        let mut q = a.clone();
        qr.apply(q.as_mut(), Par::Seq).unwrap();
        let found = orthogonality(&self::gram(q.as_ref())).unwrap();
        let n = a.ncols() as f64;
        assert!(found.frobenius < 1e-15 * n.sqrt(), "{least:e}: {found:?}");
        assert!(found.max <= found.frobenius);
        let back = &q * qr.r() - &a;
        for j in 0..a.ncols() {
            assert!(back.col(j).norm_l2() < 1e-15 * n.sqrt() * a.col(j).norm_l2());
        }
        let two = GramQr::from_gram(&gram, Par::Threads(3)).unwrap();
        let mut p = a.clone();
        two.apply(p.as_mut(), Par::Threads(2)).unwrap();
        assert_eq!((p, two.r()), (q, qr.r()));
    }
}

#[test]
fn dependent_columns_have_no_qr() {
    let a = Mat::from_fn(5, 3, |i, j| ((i + 1) * (j + 1)) as f64);
    let refused = GramQr::from_gram(&gram(a.as_ref()), Par::Seq).unwrap_err();
    assert!(refused.to_string().contains("before: columns 1, 2"), "{refused}");
    // The last column depends on 66 others by large coefficients, which hide the dependence.
    let (left, right) = (random(69, 66, 7), random(66, 67, 8));
    let integers =
        |m: &Mat<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| (100.0 * m[(i, j)]).round());
    let a = integers(&left) * integers(&right);
    for exact in [true, false] {
        let refused = GramQr::from_gram(&gram_with(a.as_ref(), exact), Par::Seq).unwrap_err();
        assert!(matches!(refused, Error::Argument { what: "A", .. }));
    }
}

#[test]
fn least_squares_do_not_depend_on_threads() {
    let a = random(150, 73, 13);
    let mut wide = Mat::zeros(150, 80);
    // Seven columns depend on others.
    for i in 0..150 {
        for j in 0..80 {
            wide[(i, j)] = a[(i, j % 73)];
        }
    }
    let gram = gram(wide.as_ref());
    let solve = |par| {
        let options = LeastSquaresOptions::new().par(par);
        LeastSquares::from_gram(&gram, 3, &options).unwrap()
    };
    let (one, three) = (solve(Par::Seq), solve(Par::Threads(3)));
    assert_eq!(one.coefficients, three.coefficients);
    assert_eq!(one.coefficients_low, three.coefficients_low);
    assert_eq!(one.standard_errors, three.standard_errors);
}
