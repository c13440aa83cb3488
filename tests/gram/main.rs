//! Least squares and principal components from rows: against certified values and invariants.

#[path = "../common/nist.rs"]
mod nist;
mod statistics;

use catamaran::base::Rng;
use catamaran::faer::{Mat, MatMut, MatRef};
use catamaran::rows::{Center, DenseRows, RowBlocks, RowOptions, ata_extended};
use catamaran::solve::{
    GramQr, LeastSquares, LeastSquaresOptions, PrincipalComponents, PrincipalComponentsOptions,
    RankDeficiency, SingularValues, correlation, lstsq, lstsq_rows, orthogonality, pca, pca_rows,
    singular_values, singular_values_rows, sum_of_pairs,
};
use catamaran::{AtaOptions, Error, Par};

use nist::NistSet;

/// Correct decimal digits: `-log10` of the relative error, at most 15.
fn digits(found: f64, right: f64) -> f64 {
    let error = if right == 0.0 { found.abs() } else { (found - right).abs() / right.abs() };
    if error == 0.0 { 15.0 } else { (-error.log10()).min(15.0) }
}

fn least_digits(found: impl Iterator<Item = f64>, right: &[f64]) -> f64 {
    found.zip(right).map(|(found, &right)| digits(found, right)).fold(15.0, f64::min)
}

fn column(values: &[f64]) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(values, values.len(), 1)
}

#[test]
fn coefficients_of_nist_have_at_least_thirteen_digits() {
    for set in NistSet::all().unwrap() {
        let options = LeastSquaresOptions::new();
        let found = lstsq(set.design.as_ref(), column(&set.response), None, &options).unwrap();
        let name = &set.name;
        assert_eq!(found.rank, set.design.ncols(), "{name}");
        let coefficients = || found.coefficients.col(0).iter().copied();
        let correct = least_digits(coefficients(), &set.rounded.coefficients);
        let certified = least_digits(coefficients(), &set.certified.coefficients);
        println!(
            "{name}: {correct:.1} digits, {certified:.1} of the certified values, promised {:.1}",
            found.digits
        );
        // The powers of x in Filip are rounded to f64, and its condition number is 10^15.
        assert!(certified >= if name == "filip" { 7.0 } else { 12.0 }, "{name}: {certified}");
        assert!(correct >= 13.0, "{name}: {correct}");
        assert!(correct >= found.digits.min(14.5), "{name}: {correct}, not {}", found.digits);
        let errors = found.standard_errors.col(0).iter().copied();
        let exact_fit = set.residual_deviation == 0.0;
        if exact_fit {
            continue;
        }
        let correct = least_digits(errors, &set.rounded.deviations);
        assert!(correct >= 12.0, "deviations of {name}: {correct}");
    }
}

#[test]
fn powers_in_two_parts_have_the_certified_digits_of_filip() {
    let sets = NistSet::all().unwrap();
    let set = sets.iter().find(|set| set.name == "filip").unwrap();
    let (m, n) = set.design.shape();
    // x^k and what rounding takes from it: the part before times x, in double-double.
    let mut rows = Mat::<f64>::zeros(m, 2 * n + 1);
    for i in 0..m {
        let x = set.design[(i, 1)];
        let (mut high, mut low) = (1.0, 0.0);
        for k in 0..n {
            (rows[(i, k)], rows[(i, n + k)]) = (high, low);
            let product = high * x;
            let rest = f64::mul_add(high, x, -product) + low * x;
            high = product + rest;
            low = rest - (high - product);
        }
        rows[(i, 2 * n)] = set.response[i];
    }
    let plain = RowOptions::<f64>::new();
    let gram = ata_extended(&mut DenseRows(rows.as_ref()), &plain, &AtaOptions::new()).unwrap();
    let gram = sum_of_pairs(&gram, n).unwrap();
    let found = LeastSquares::from_gram(&gram, 1, &LeastSquaresOptions::new()).unwrap();
    let coefficients = found.coefficients.col(0).iter().copied();
    let certified = least_digits(coefficients, &set.certified.coefficients);
    println!("filip: {certified:.1} of the certified digits");
    assert!(certified >= 12.0, "{certified}");
}

#[test]
fn an_intercept_is_that_of_a_column_of_ones() {
    for set in NistSet::all().unwrap().into_iter().filter(|set| set.intercept) {
        let options = LeastSquaresOptions::new().intercept(true);
        let a = set.design.as_ref().subcols(1, set.design.ncols() - 1);
        let found = lstsq(a, column(&set.response), None, &options).unwrap();
        let all = found.intercepts.iter().chain(found.coefficients.col(0).iter()).copied();
        let correct = least_digits(all, &set.rounded.coefficients);
        assert!(correct >= 13.0, "{}: {correct}", set.name);
        let own = digits(found.r_squared[0], set.r_squared);
        assert!(own >= 9.0, "R^2 of {}: {own}", set.name);
    }
}

#[test]
fn weights_count_rows_several_times() {
    let mut rng = Rng::new(1);
    let a = Mat::<f64>::from_fn(23, 3, |_, _| rng.normal());
    let b = Mat::<f64>::from_fn(23, 2, |_, _| rng.normal());
    let weights: Vec<f64> = (0..23).map(|i| f64::from(i % 3)).collect();
    let repeated: Vec<usize> = (0..23).flat_map(|i| vec![i; i % 3]).collect();
    let rows = |m: &Mat<f64>| Mat::from_fn(repeated.len(), m.ncols(), |i, j| m[(repeated[i], j)]);
    for intercept in [false, true] {
        let options = LeastSquaresOptions::new().intercept(intercept);
        let weighted = lstsq(a.as_ref(), b.as_ref(), Some(&weights), &options).unwrap();
        let right = lstsq(rows(&a).as_ref(), rows(&b).as_ref(), None, &options).unwrap();
        assert_eq!(weighted.coefficients, right.coefficients);
        assert_eq!(weighted.residual_norms, right.residual_norms);
        assert_eq!(weighted.intercepts, right.intercepts);
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let mut rng = Rng::new(2);
    let a = Mat::<f64>::from_fn(301, 37, |_, _| rng.normal());
    let b = Mat::<f64>::from_fn(301, 1, |_, _| rng.normal());
    let solve = |threads| {
        let options = LeastSquaresOptions::new().intercept(true).threads(threads);
        let found = lstsq(a.as_ref(), b.as_ref(), None, &options).unwrap();
        (found.coefficients, found.intercepts, found.standard_errors)
    };
    let of_one = solve(1);
    assert_eq!(solve(2), of_one);
    assert_eq!(solve(5), of_one);
    let components = |threads| {
        let found = pca(a.as_ref(), &PrincipalComponentsOptions::new().threads(threads)).unwrap();
        (found.components, found.singular_values)
    };
    assert_eq!(components(3), components(1));
}

#[test]
fn small_singular_values_keep_their_digits() {
    // Columns of a Hadamard matrix times powers of two: the singular values are 4 2^e.
    let sign = |i: usize, j: usize| if (i & j).count_ones().is_multiple_of(2) { 1.0 } else { -1.0 };
    let exponents = [0, -10, -20, -30, -40, -49];
    let a = Mat::<f64>::from_fn(16, 6, |i, j| sign(i, j) * f64::from(exponents[j]).exp2());
    let found = singular_values(a.as_ref(), Par::Seq).unwrap();
    for (value, exponent) in found.values.iter().zip(exponents) {
        let right = 4.0 * f64::from(exponent).exp2();
        assert!((value / right - 1.0).abs() <= 4e-16, "{value:e}, not {right:e}");
    }
    // Mixed by an exact rotation by 45 degrees, which hides them from the columns.
    let mixed = Mat::<f64>::from_fn(16, 6, |i, j| {
        let other = j ^ 1;
        if j % 2 == 0 { a[(i, j)] + a[(i, other)] } else { a[(i, other)] - a[(i, j)] }
    });
    let found = singular_values(mixed.as_ref(), Par::Seq).unwrap();
    for (value, exponent) in found.values.iter().zip(exponents) {
        let right = 2f64.sqrt() * 4.0 * f64::from(exponent).exp2();
        assert!((value / right - 1.0).abs() <= 1e-14, "{value:e}, not {right:e}");
    }
}

#[test]
fn left_singular_vectors_are_orthonormal_and_give_the_matrix_back() {
    let mut rng = Rng::new(11);
    let a = Mat::<f64>::from_fn(40, 6, |_, j| rng.normal() * f64::from(j as i32 - 3).exp2());
    let found = singular_values(a.as_ref(), Par::Seq).unwrap();
    let u = found.left(a.as_ref(), Par::Threads(2)).unwrap();
    assert_eq!(u.shape(), (40, 6));
    assert_eq!(u, found.left(a.as_ref(), Par::Seq).unwrap());
    let scaled = Mat::from_fn(40, 6, |i, k| u[(i, k)] * found.values[k]);
    assert!((&scaled * found.v.transpose() - &a).norm_max() < 1e-13 * found.values[0]);
    assert!((u.transpose() * &u - Mat::<f64>::identity(6, 6)).norm_max() < 1e-13);
    // Of a matrix of rank 1 there is one vector.
    let equal = Mat::<f64>::from_fn(4, 2, |i, _| i as f64);
    let found = singular_values(equal.as_ref(), Par::Seq).unwrap();
    let u = found.left(equal.as_ref(), Par::Seq).unwrap();
    assert_eq!(u.shape(), (4, 1));
    assert!((u.col(0).norm_l2() - 1.0).abs() < 1e-14);
    let error = found.left(a.as_ref(), Par::Seq).unwrap_err();
    assert!(matches!(error, Error::Shape { what: "A", .. }), "{error}");
}

/// Rows that can only be read block by block, the second pass after the first.
struct Blocks<'a>(DenseRows<'a, f64>, usize);

fn blocks(a: &Mat<f64>) -> Blocks<'_> {
    Blocks(DenseRows(a.as_ref()), 0)
}

impl RowBlocks<f64> for Blocks<'_> {
    fn nrows(&self) -> usize {
        self.0.0.nrows()
    }

    fn ncols(&self) -> usize {
        self.0.0.ncols()
    }

    fn read(&mut self, first: usize, out: MatMut<'_, f64>) -> catamaran::Result<()> {
        assert!(first == self.1 || first == 0, "row {first} after {}", self.1);
        self.1 = first + out.nrows();
        self.0.read(first, out)
    }
}

#[test]
fn results_of_rows_from_a_source_are_those_of_the_matrix() {
    let mut rng = Rng::new(12);
    let a = Mat::<f64>::from_fn(50, 4, |_, _| rng.normal());
    let b = Mat::<f64>::from_fn(50, 2, |_, _| rng.normal());
    let weights: Vec<f64> = (0..50).map(|i| f64::from(i % 3)).collect();
    let options = LeastSquaresOptions::new().intercept(true);
    let weights = Some(&weights[..]);
    let found = lstsq_rows(&mut blocks(&a), &mut blocks(&b), weights, &options).unwrap();
    let whole = lstsq(a.as_ref(), b.as_ref(), weights, &options).unwrap();
    assert_eq!((found.coefficients, found.intercepts), (whole.coefficients, whole.intercepts));
    let components = PrincipalComponentsOptions::new();
    let found = pca_rows(&mut blocks(&a), &components).unwrap();
    assert_eq!(found.components, pca(a.as_ref(), &components).unwrap().components);
    let found = singular_values_rows(&mut blocks(&a), Par::Seq).unwrap();
    assert_eq!(found.values, singular_values(a.as_ref(), Par::Seq).unwrap().values);
    let short = b.subrows(0, 49).to_owned();
    let error = lstsq_rows(&mut blocks(&a), &mut blocks(&short), None, &options).unwrap_err();
    assert!(matches!(error, Error::Shape { what: "B", .. }), "{error}");
}

#[test]
fn a_small_variance_is_not_lost_beside_a_large_one() {
    // scikit-learn #29534: a singular value of 1e-8 beside one of 1.
    let mut rng = Rng::new(3);
    let a = Mat::<f64>::from_fn(50, 2, |i, j| {
        let t = if i % 2 == 0 { 1.0 } else { -1.0 };
        let s = rng.sign() * 2f64.powi(-27);
        t + if j == 0 { s } else { -s }
    });
    let found = pca(a.as_ref(), &PrincipalComponentsOptions::new()).unwrap();
    let [large, small] = [found.singular_values[0], found.singular_values[1]];
    // Two columns of 50 rows of +-1, but for 1e-8: 10 = sqrt(2 * 50).
    assert!((large - 10.0).abs() < 1e-7, "{large}");
    assert!(small / large > 2f64.powi(-28) && small / large < 2f64.powi(-26), "{small:e}");
}

#[test]
fn bad_problems_are_refused_with_the_culprit() {
    let a = Mat::<f64>::from_fn(6, 3, |i, j| if j == 2 { i as f64 } else { (i * j) as f64 });
    let b = Mat::<f64>::from_fn(6, 1, |i, _| i as f64);
    let options = LeastSquaresOptions::new();
    let solve = |b: &Mat<f64>, weights: Option<&[f64]>, options: &LeastSquaresOptions| {
        lstsq(a.as_ref(), b.as_ref(), weights, options)
    };
    // The first column is zero, the others are equal.
    let found = solve(&b, None, &options).unwrap();
    assert_eq!(found.rank, 1);
    assert_eq!(found.coefficients, Mat::from_fn(3, 1, |i, _| if i == 0 { 0.0 } else { 0.5 }));
    let refuse = options.rank_deficiency(RankDeficiency::Refuse);
    assert!(matches!(solve(&b, None, &refuse).unwrap_err(), Error::Argument { what: "A", .. }));
    let short = Mat::zeros(5, 1);
    assert!(matches!(solve(&short, None, &options).unwrap_err(), Error::Shape { what: "B", .. }));
    let refused = solve(&b, Some(&[1.0; 5]), &options).unwrap_err();
    assert!(matches!(refused, Error::Shape { what: "weights", .. }));
    let refused = solve(&b, Some(&[1.0, 1.0, -1.0, 1.0, 1.0, 1.0]), &options).unwrap_err();
    assert!(matches!(refused, Error::Argument { what: "weights", .. }));
    let mut bad = b.clone();
    bad[(3, 0)] = f64::INFINITY;
    let refused = solve(&bad, None, &options).unwrap_err();
    assert_eq!(refused, Error::NonFinite { what: "B", index: (3, 0) });
    let nothing = Mat::<f64>::zeros(0, 3);
    let found = lstsq(nothing.as_ref(), Mat::zeros(0, 1).as_ref(), None, &options).unwrap();
    assert_eq!((found.rank, found.coefficients), (0, Mat::zeros(3, 1)));
    let options = options.intercept(true);
    let found = lstsq(nothing.as_ref(), Mat::zeros(0, 1).as_ref(), None, &options).unwrap();
    assert_eq!(
        (found.rank, found.coefficients, found.intercepts),
        (0, Mat::zeros(3, 1), vec![0.0])
    );
}

#[test]
fn columns_whose_squares_are_out_of_range_are_named_and_never_lost() {
    let mut rng = Rng::new(5);
    let near = Mat::<f64>::from_fn(40, 4, |_, j| if j == 2 { 0.0 } else { rng.uniform() - 0.5 });
    let as_they_are = RowOptions::<f64>::new();
    let by_mean = as_they_are.center(Center::Mean);
    let (solution, components) = (LeastSquaresOptions::new(), PrincipalComponentsOptions::new());
    for (scale, what, place) in [
        (1e-140, "A", 1),
        (1e-170, "A", 0),
        (1e-310, "A", 1),
        (1e160, "A", 0),
        (1e300, "B", 3),
        (1e-200, "B", 3),
    ] {
        let mut a = near.clone();
        a.col_mut(place).iter_mut().for_each(|x| *x *= scale);
        let expected = |what: &str, column: usize| {
            format!(
                "{what}: the squared length of column {column} is out of the range of f64: \
                 multiply the column by a power of ten"
            )
        };
        let rows = || DenseRows(a.as_ref());
        for options in [as_they_are, by_mean] {
            let gram = ata_extended(&mut rows(), &options, &AtaOptions::new()).unwrap();
            assert_eq!(gram.out_of_range(), [place]);
            let refused = LeastSquares::from_gram(&gram, 1, &solution).unwrap_err().to_string();
            assert_eq!(refused, expected(what, if what == "A" { place } else { 0 }));
            let refused = SingularValues::from_gram(&gram, Par::Seq).unwrap_err().to_string();
            assert_eq!(refused, expected("A", place));
            let refused = GramQr::from_gram(&gram, Par::Seq).unwrap_err().to_string();
            assert_eq!(refused, expected("A", place));
        }
        let gram = ata_extended(&mut rows(), &by_mean, &AtaOptions::new()).unwrap();
        let refused = PrincipalComponents::from_gram(&gram, &components).unwrap_err();
        assert_eq!(refused.to_string(), expected("A", place));
        assert_eq!(correlation(&gram).unwrap_err().to_string(), expected("A", place));
        let gram = ata_extended(&mut rows(), &as_they_are, &AtaOptions::new()).unwrap();
        assert_eq!(orthogonality(&gram).is_ok(), scale < 1.0);
    }
    // The rest of a column in two parts may be as small as it likes.
    let parts = Mat::from_fn(40, 3, |i, j| [near[(i, 0)], 1e-200 * near[(i, 1)], near[(i, 3)]][j]);
    let rows = &mut DenseRows(parts.as_ref());
    let gram = ata_extended(rows, &as_they_are, &AtaOptions::new()).unwrap();
    let gram = sum_of_pairs(&gram, 1).unwrap();
    assert!(gram.out_of_range().is_empty());
}
