//! Gram matrices in extended precision, against integers of any size.

use catamaran::base::Rng;
use catamaran::blas::BlasReal;
use catamaran::faer::{Mat, MatRef};
use catamaran::rows::{Accumulator, DenseRows, ExtendedGram, RowBounds, stream};
use catamaran::{AtaOptions, Error, Par, Uplo};
use num_bigint::BigInt;

/// Numbers count units of `2^-UNIT`, their products those of `2^(-2 UNIT)`.
const UNIT: i32 = 1200;

/// An f64 as an integer, exactly.
fn integer(x: f64, unit: i32) -> BigInt {
    let bits = x.to_bits();
    let exponent = ((bits >> 52) & 0x7ff) as i32;
    let mantissa = bits & ((1 << 52) - 1);
    let (mantissa, exponent) =
        if exponent == 0 { (mantissa, -1074) } else { (mantissa | 1 << 52, exponent - 1075) };
    let size = BigInt::from(mantissa) << (exponent + unit);
    if x < 0.0 { -size } else { size }
}

fn sum(parts: [f64; 3]) -> BigInt {
    parts.iter().map(|&part| integer(part, 2 * UNIT)).sum()
}

/// `log2 |x|`.
fn log2(x: &BigInt) -> f64 {
    let down = (x.bits() as i64 - 60).max(0);
    let short: f64 = (x >> down).to_string().parse().unwrap();
    short.abs().log2() + down as f64
}

/// `w C`, in units of `2^(-3 UNIT)`, and w in those of `2^-UNIT`, exactly. With centring w is the
/// sum of the weights, and `w C` is `w sum of w_r x_i x_j - sum of w_r x_i sum of w_r x_j`.
fn oracle(
    a: &[Vec<f64>],
    weights: Option<&[f64]>,
    (i, j): (usize, usize),
    centered: bool,
) -> (BigInt, BigInt) {
    let weight = |row: usize| integer(weights.map_or(1.0, |w| w[row]), UNIT);
    let x = |row: usize, j: usize| integer(a[row][j], UNIT);
    let rows = 0..a.len();
    let c: BigInt = rows.clone().map(|r| weight(r) * x(r, i) * x(r, j)).sum();
    if !centered {
        return (c, integer(1.0, UNIT));
    }
    let total: BigInt = rows.clone().map(weight).sum();
    let column = |j: usize| rows.clone().map(|r| weight(r) * x(r, j)).sum::<BigInt>();
    ((c * &total - column(i) * column(j)) >> UNIT, total)
}

fn extended<T: BlasReal>(
    a: &[Vec<f64>],
    weights: Option<&[f64]>,
    centered: bool,
    block_rows: usize,
    par: Par,
) -> catamaran::Result<ExtendedGram> {
    let (m, n) = (a.len(), a.first().map_or(0, Vec::len));
    let matrix = Mat::<T>::from_fn(m, n, |i, j| T::from_f64(a[i][j]));
    let weights: Option<Vec<T>> = weights.map(|w| w.iter().map(|&w| T::from_f64(w)).collect());
    let options = AtaOptions::new().par(par);
    let mut rows = DenseRows(matrix.as_ref());
    let bounds = RowBounds::<T>::of(&mut rows, weights.as_deref(), block_rows, &options)?;
    let mut sum = Accumulator::extended(&bounds, centered)?;
    let nothing = &mut |_: &Accumulator<T>| Ok(());
    stream(&mut rows, weights.as_deref(), block_rows, &mut sum, &options, nothing)?;
    sum.finish_extended(par)
}

/// Rows whose columns are of very different sizes, with entries of all sizes below.
fn rows(m: usize, n: usize, spread: i32, seed: u64) -> Vec<Vec<f64>> {
    let mut rng = Rng::new(seed);
    let mut entry = |j: usize| {
        let scale = f64::from(40 * (j as i32 % 5) - 80 - (rng.bits() % 30) as i32 * spread).exp2();
        let zero = j == 3 || rng.bits().is_multiple_of(13);
        if zero { 0.0 } else { rng.normal() * scale }
    };
    (0..m).map(|_| (0..n).map(&mut entry).collect()).collect()
}

/// The largest `log2 |C_ij - exact| / (|a_i| |a_j|)`; minus infinity where all entries are exact.
fn check(gram: &ExtendedGram, a: &[Vec<f64>], weights: Option<&[f64]>, centered: bool) -> f64 {
    let mut worst = f64::NEG_INFINITY;
    let n = gram.n();
    let norms: Vec<f64> = (0..n)
        .map(|j| {
            let weight = |r: usize| weights.map_or(1.0, |w| w[r].abs());
            let squares = (0..a.len()).map(|r| weight(r) * (a[r][j] * 1e10).powi(2));
            (squares.sum::<f64>() / 1e20).log2() / 2.0
        })
        .collect();
    for i in 0..n {
        for j in 0..=i {
            let (exact, w) = oracle(a, weights, (i, j), centered);
            let parts = gram.entry(i, j);
            for p in 0..2 {
                assert_eq!(parts[p] + parts[p + 1], parts[p], "parts of ({i}, {j}) overlap");
            }
            let error = sum(parts) * &w - &exact;
            if error != BigInt::ZERO {
                let absolute = log2(&error) - log2(&w) - f64::from(2 * UNIT);
                worst = worst.max(absolute - norms[i] - norms[j]);
            }
        }
    }
    worst
}

#[test]
fn integers_give_exact_integers() {
    for (m, n) in [(0, 3), (1, 1), (3, 5), (131, 7)] {
        let a: Vec<Vec<f64>> = (0..m)
            .map(|i| (0..n).map(|j| ((i * i * 7919 + j * 104_729) % 1_048_573) as f64).collect())
            .collect();
        for centered in [false, true] {
            let gram = extended::<f64>(&a, None, centered, 64, Par::Threads(2)).unwrap();
            assert!(gram.is_exact());
            assert_eq!(gram.rows(), m as u64);
            // About the mean C is a fraction, which 159 bits round.
            let bound = if centered { -156.0 } else { f64::NEG_INFINITY };
            let error = check(&gram, &a, None, centered);
            assert!(error <= bound, "{m} x {n}, {centered}: {error}");
        }
    }
}

#[test]
fn entries_of_one_size_are_not_rounded() {
    let a = rows(97, 6, 0, 1);
    for centered in [false, true] {
        let gram = extended::<f64>(&a, None, centered, 40, Par::Seq).unwrap();
        assert!(check(&gram, &a, None, centered) <= -80.0);
        let single: Vec<Vec<f64>> =
            a.iter().map(|row| row.iter().map(|&x| f64::from(x as f32)).collect()).collect();
        let gram = extended::<f32>(&single, None, centered, 40, Par::Seq).unwrap();
        assert!(gram.is_exact());
        assert!(check(&gram, &single, None, centered) <= -120.0);
    }
}

#[test]
fn entries_of_all_sizes_are_rounded_to_eighty_bits_of_their_columns() {
    let a = rows(61, 7, 3, 2);
    for centered in [false, true] {
        let gram = extended::<f64>(&a, None, centered, 64, Par::Seq).unwrap();
        assert!(!gram.is_exact());
        let error = check(&gram, &a, None, centered);
        assert!(error <= -76.0 && error > -100.0, "{centered}: {error}");
    }
}

#[test]
fn weights_are_not_rounded_either() {
    let mut rng = Rng::new(3);
    let a = rows(53, 5, 0, 3);
    let weights: Vec<f64> = (0..53).map(|_| rng.uniform() + 0.5).collect();
    let negative: Vec<f64> = weights.iter().map(|&w| w - 0.75).collect();
    for weights in [&weights, &negative] {
        for centered in [false, true] {
            let gram = extended::<f64>(&a, Some(weights), centered, 32, Par::Seq).unwrap();
            let error = check(&gram, &a, Some(weights), centered);
            // Those of a product in f64 would be near -53.
            assert!(error <= -74.0, "{error}");
        }
    }
}

#[test]
fn the_mean_is_that_of_the_definition_in_two_parts() {
    let a = vec![vec![1.0, 1e9], vec![2.0, 1e9 + 1.0], vec![4.0, 1e9 + 5.0]];
    let gram = extended::<f64>(&a, None, true, 2, Par::Seq).unwrap();
    for (j, sum) in [7.0, 3e9 + 6.0].into_iter().enumerate() {
        let [high, low] = gram.mean()[j];
        assert_eq!(high, sum / 3.0);
        let rest = high.mul_add(-3.0, sum) / 3.0;
        assert!((low - rest).abs() <= rest.abs() * 1e-10, "{low:e}, not {rest:e}");
    }
    assert_eq!(gram.weight(), 3.0);
}

#[test]
fn any_cut_and_any_merge_give_the_same_bytes() {
    let a = rows(90, 6, 2, 4);
    let whole = extended::<f64>(&a, None, true, 90, Par::Seq).unwrap();
    let same = |other: &ExtendedGram| {
        (0..6).all(|i| (0..6).all(|j| whole.entry(i, j) == other.entry(i, j)))
            && whole.mean() == other.mean()
    };
    for (block_rows, par) in [(1, Par::Seq), (7, Par::Threads(2)), (64, Par::Threads(3))] {
        assert!(same(&extended::<f64>(&a, None, true, block_rows, par).unwrap()));
    }
    let options = AtaOptions::new();
    let all = Mat::<f64>::from_fn(90, 6, |i, j| a[i][j]);
    let bounds = RowBounds::of(&mut DenseRows(all.as_ref()), None, 8, &options).unwrap();
    let part = |rows: std::ops::Range<usize>| {
        let mut sum = Accumulator::<f64>::extended(&bounds, true).unwrap();
        sum.add_block(all.subrows(rows.start, rows.len()), None, &options).unwrap();
        // As a file, too.
        let mut bytes = Vec::new();
        sum.write(&mut bytes).unwrap();
        Accumulator::<f64>::read(&mut &bytes[..]).unwrap()
    };
    let mut sum = part(50..90);
    sum.merge(part(0..50)).unwrap();
    assert!(sum.is_extended() && sum.is_exact());
    sum.add_block(all.subrows(0, 9), None, &options).unwrap();
    sum.remove_block(all.subrows(0, 9), None, &options).unwrap();
    // Its value in f64 is the first of the parts.
    let mut bytes = Vec::new();
    sum.write(&mut bytes).unwrap();
    let rounded = Accumulator::<f64>::read(&mut &bytes[..]).unwrap().finish(1.0, Uplo::Lower);
    let rounded = rounded.unwrap();
    let merged = sum.finish_extended(Par::Seq).unwrap();
    assert!(same(&merged));
    for i in 0..6 {
        for j in 0..=i {
            assert_eq!(rounded.as_ref()[(i, j)], merged.entry(i, j)[0]);
        }
    }
}

#[test]
fn sums_on_other_bounds_merge_exactly() {
    let options = AtaOptions::new();
    let of = |bound: f64, rows: &[f64]| {
        let bounds = RowBounds::new(vec![-bound], vec![bound], 100).unwrap();
        let mut sum = Accumulator::<f64>::extended(&bounds, false).unwrap();
        let rows = MatRef::from_column_major_slice(rows, rows.len(), 1);
        sum.add_block(rows, None, &options).unwrap();
        sum
    };
    let mut sum = of(1024.0, &[1000.0, 3.0]);
    sum.merge(of(1.0, &[2f64.powi(-60), 0.5])).unwrap();
    let gram = sum.finish_extended(Par::Seq).unwrap();
    assert_eq!(gram.entry(0, 0), [1_000_009.25, 2f64.powi(-120), 0.0]);
    assert!(gram.is_exact());
}

#[test]
fn what_can_not_be_had_is_refused() {
    let mut a = rows(5, 3, 0, 5);
    a[2][1] = f64::NAN;
    let refused = extended::<f64>(&a, None, false, 2, Par::Seq).unwrap_err();
    assert_eq!(refused, Error::NonFinite { what: "rows", index: (0, 1) });
    let refused = Accumulator::<f64>::new(2, false).unwrap().finish_extended(Par::Seq).unwrap_err();
    assert!(matches!(refused, Error::Argument { what: "accumulator", .. }), "{refused}");
    let bounds = RowBounds::new(vec![0.0; 2], vec![1.0; 2], 5).unwrap();
    let mut sum = Accumulator::<f64>::extended(&bounds, false).unwrap();
    let refused = sum.merge(Accumulator::exact(&bounds, false).unwrap()).unwrap_err();
    assert!(matches!(refused, Error::Argument { what: "accumulator", .. }), "{refused}");
    let weights = [1.0, -1.0, 0.0, 1.0, -1.0];
    let refused = extended::<f64>(&rows(5, 3, 0, 6), Some(&weights), true, 2, Par::Seq);
    assert!(matches!(refused.unwrap_err(), Error::Argument { what: "weights", .. }));
}
