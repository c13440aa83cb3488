//! Checks that exact sums have the same bytes for any blocks, order, threads, instruction set,
//! merge and removal, and those of integers of any size.

use faer::{Mat, MatMut, MatRef, mat};

use super::accumulator::Sums;
use super::grid::Capacity;
use super::pass::Pass;
use super::*;
use crate::base::{Error, Par, Result, Rng};
use crate::blas::BlasReal;
use crate::kernel::int8::Kernel;
use crate::kernel::int8::tests::{PORTABLE, kernels};
use crate::product::{AtaOptions, Uplo};

/// Rows with their weights, and bounds of both.
struct Rows<T> {
    x: Mat<T>,
    weights: Option<Vec<T>>,
}

impl<T: BlasReal> Rows<T> {
    /// Creates entries around `100 j` with columns of very different size; the sixth is constant.
    fn random(m: usize, n: usize, weighted: bool, seed: u64) -> Self {
        let mut rng = Rng::new(seed);
        let x = Mat::from_fn(m, n, |_, j| match j {
            5 => T::from_f64(0.1),
            _ => {
                T::from_f64((rng.normal() + 100.0 * j as f64) * f64::from(3 * j as i32 - 9).exp2())
            }
        });
        let weights = weighted.then(|| (0..m).map(|_| T::from_f64(rng.normal())).collect());
        Self { x, weights }
    }

    fn bounds(&self) -> RowBounds<T> {
        let options = AtaOptions::new().par(Par::Seq);
        let weights = self.weights.as_deref();
        RowBounds::of(&mut DenseRows(self.x.as_ref()), weights, 7, &options).unwrap()
    }

    fn pieces(&self, rows: &[usize]) -> (Vec<T>, Option<Vec<T>>) {
        let n = self.x.ncols();
        let x = rows.iter().flat_map(|&i| (0..n).map(move |j| self.x[(i, j)])).collect();
        (x, self.weights.as_ref().map(|w| rows.iter().map(|&i| w[i]).collect()))
    }

    /// Adds these rows, or subtracts them.
    fn add(
        &self,
        sum: &mut Accumulator<T>,
        rows: &[usize],
        subtract: bool,
        threads: usize,
        kernel: &'static dyn Kernel,
    ) -> Result<()> {
        let (mut x, weights) = self.pieces(rows);
        let options = AtaOptions::new().par(Par::Threads(threads));
        let mut pass = Pass::new(&options).unwrap();
        pass.engine.kernel = kernel;
        match &mut sum.sums {
            Sums::Exact(sums) => {
                sums.add(rows.len(), &mut x, weights.as_deref(), subtract, &mut pass)
            }
            _ => unreachable!("only exact ones are made here"),
        }
    }

    /// Returns the sums of all rows at once.
    fn whole(&self, bounds: &RowBounds<T>, centered: bool) -> Accumulator<T> {
        let mut sum = Accumulator::exact(bounds, centered).unwrap();
        let all: Vec<usize> = (0..self.x.nrows()).collect();
        self.add(&mut sum, &all, false, 1, &PORTABLE).unwrap();
        sum
    }
}

fn bytes<T: BlasReal>(sum: &Accumulator<T>) -> Vec<u8> {
    let mut bytes = Vec::new();
    sum.write(&mut bytes).unwrap();
    bytes
}

fn bits<T: BlasReal>(sum: Accumulator<T>) -> Vec<u64> {
    let n = sum.ncols();
    let c = sum.finish(1.0, Uplo::Lower).unwrap();
    let entry = |i: usize, j: usize| c.as_ref()[(i, j)].to_f64().to_bits();
    (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))).map(|(i, j)| entry(i, j)).collect()
}

fn shuffled(m: usize, seed: u64) -> Vec<usize> {
    let mut rng = Rng::new(seed);
    let mut order: Vec<usize> = (0..m).collect();
    for i in (1..m).rev() {
        order.swap(i, (rng.uniform() * (i + 1) as f64) as usize);
    }
    order
}

fn any_blocks<T: BlasReal>() {
    for (m, n) in [(0, 3), (1, 1), (5, 2), (61, 7), (131, 37)] {
        for (weighted, centered) in [(false, false), (false, true), (true, false), (true, true)] {
            let rows = Rows::<T>::random(m, n, weighted, 1);
            let bounds = rows.bounds();
            let expected = bytes(&rows.whole(&bounds, centered));
            for (k, (name, kernel)) in kernels().into_iter().enumerate() {
                // An emulated instruction takes a microsecond.
                let heights = if name == "amx" { vec![50] } else { vec![1, 7, 64, 1000] };
                for (h, height) in heights.into_iter().enumerate() {
                    let mut sum = Accumulator::exact(&bounds, centered).unwrap();
                    let order = shuffled(m, (k + 10 * h) as u64);
                    for block in order.chunks(height) {
                        rows.add(&mut sum, block, false, 1 + h, kernel).unwrap();
                    }
                    assert!(bytes(&sum) == expected, "{name}, {m} x {n}, blocks of {height}");
                }
            }
        }
    }
}

#[test]
fn any_blocks_order_threads_and_instruction_set_give_the_same_bytes() {
    any_blocks::<f64>();
    any_blocks::<f32>();
}

fn added_and_removed<T: BlasReal>() {
    let (m, n) = (90, 11);
    for (weighted, centered) in [(false, false), (true, true)] {
        let rows = Rows::<T>::random(m, n, weighted, 2);
        let bounds = rows.bounds();
        let kept: Vec<usize> = (0..m).filter(|i| i % 3 != 0).collect();
        let mut expected = Accumulator::exact(&bounds, centered).unwrap();
        rows.add(&mut expected, &kept, false, 1, &PORTABLE).unwrap();
        let mut sum = rows.whole(&bounds, centered);
        let removed: Vec<usize> = (0..m).filter(|i| i % 3 == 0).rev().collect();
        for block in removed.chunks(7) {
            rows.add(&mut sum, block, true, 2, &PORTABLE).unwrap();
        }
        assert!(bytes(&sum) == bytes(&expected));
        // More rows than there are.
        let error = rows.add(&mut sum, &vec![0; m], true, 1, &PORTABLE).unwrap_err();
        assert!(matches!(error, Error::Argument { what: "block", .. }), "{error}");
        assert!(bytes(&sum) == bytes(&expected));
    }
}

#[test]
fn rows_that_are_removed_leave_the_bytes_of_rows_never_added() {
    added_and_removed::<f64>();
    added_and_removed::<f32>();
}

#[test]
fn floating_point_sums_remove_no_rows() {
    let mut sum = Accumulator::<f64>::new(2, false).unwrap();
    let error = sum.remove_block(mat![[1.0, 2.0]], None, &AtaOptions::new()).unwrap_err();
    assert!(error.to_string().contains("exact"), "{error}");
}

fn merged<T: BlasReal>(common: bool) {
    let (m, n) = (120, 9);
    for (weighted, centered) in [(false, false), (false, true), (true, false), (true, true)] {
        let rows = Rows::<T>::random(m, n, weighted, 3);
        let all = rows.bounds();
        let part = |k: usize| {
            let range: Vec<usize> = (k * 30..k * 30 + 30).collect();
            let (x, weights) = rows.pieces(&range);
            let own = Rows { x: Mat::from_fn(30, n, |i, j| x[i * n + j]), weights };
            let bounds = if common { all.clone() } else { own.bounds() };
            own.whole(&bounds, centered)
        };
        let merge = |mut a: Accumulator<T>, b: Accumulator<T>| {
            a.merge(b).unwrap();
            a
        };
        let trees = [
            merge(merge(merge(part(0), part(1)), part(2)), part(3)),
            merge(merge(part(3), part(1)), merge(part(2), part(0))),
            merge(part(2), merge(part(0), merge(part(3), part(1)))),
        ];
        let whole = rows.whole(&all, centered);
        let (w, rest) = (whole.weight(), whole.mean());
        let expected = bits(whole);
        let mut first = None;
        for tree in trees {
            assert_eq!(tree.rows(), m as u64);
            assert!((tree.weight() - w).abs() <= if common { 0.0 } else { 1e-6 * w.abs() });
            for (a, b) in tree.mean().iter().zip(&rest) {
                assert!((a - b).abs() <= 1e-6 * b.abs(), "{a} {b}");
            }
            let found = bits(tree);
            if common {
                assert!(found == expected, "{weighted} {centered}");
            }
            assert!(*first.get_or_insert(found.clone()) == found, "{weighted} {centered}");
        }
        // On their own grids the parts are rounded differently, but not worse.
        let found = first.unwrap();
        for i in 0..n {
            for j in 0..=i {
                let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
                let value = |values: &[u64], at: usize| f64::from_bits(values[at]);
                let scale = |i: usize| value(&expected, at(i, i)).abs().sqrt();
                let error = value(&found, at(i, j)) - value(&expected, at(i, j));
                let limit = 8.0 * m as f64 * T::UNIT_ROUNDOFF * scale(i) * scale(j);
                let weight = if weighted { 100.0 } else { 1.0 };
                let limit = if i == 5 || j == 5 { f64::INFINITY } else { weight * limit };
                assert!(error.abs() <= limit, "({i}, {j}): {error:e}, {limit:e}");
            }
        }
    }
}

#[test]
fn merges_in_any_tree_are_the_same_bytes() {
    merged::<f64>(true);
    merged::<f32>(true);
}

#[test]
fn merges_of_different_grids_in_any_tree_are_the_same_bytes() {
    merged::<f64>(false);
    merged::<f32>(false);
}

#[test]
fn grids_too_far_apart_are_not_merged_and_the_column_is_named() {
    let of = |x: f64| Rows { x: Mat::from_fn(3, 2, |_, j| [1.0, x][j]), weights: None };
    let sum = |x: f64| of(x).whole(&of(x).bounds(), false);
    let mut near = sum(1.0);
    near.merge(sum(2.0)).unwrap();
    let error = sum(1.0).merge(sum(1e30)).unwrap_err().to_string();
    assert!(error.contains("column 1"), "{error}");
}

/// Returns entries that are integers in units of 2^-20, as those integers.
fn dyadic(m: usize, n: usize, mean: i128, seed: u64) -> Vec<Vec<i128>> {
    let mut rng = Rng::new(seed);
    let mut deviation = || ((rng.uniform() - 0.5) * 2f64.powi(21)) as i128;
    (0..m).map(|_| (0..n).map(|j| (mean << 20) * (j as i128 + 1) + deviation()).collect()).collect()
}

#[test]
fn a_mean_that_is_1e8_deviations_away_costs_nothing() {
    let (m, n) = (90, 5);
    let integers = dyadic(m, n, 100_000_000, 4);
    let x = Mat::from_fn(m, n, |i, j| integers[i][j] as f64 * 2f64.powi(-20));
    let rows = Rows { x, weights: None };
    let c = rows.whole(&rows.bounds(), true).finish(1.0, Uplo::Both).unwrap();
    for i in 0..n {
        for j in 0..n {
            let sum = |f: &dyn Fn(&[i128]) -> i128| integers.iter().map(|row| f(row)).sum::<i128>();
            let products = sum(&|row| row[i] * row[j]);
            let numerator = m as i128 * products - sum(&|row| row[i]) * sum(&|row| row[j]);
            // Two roundings in the expected value, one in the result.
            let expected = numerator as f64 / m as f64 * 2f64.powi(-40);
            let error = (c.as_ref()[(i, j)] - expected).abs();
            assert!(error <= 2.0 * f64::EPSILON * expected.abs(), "({i}, {j}): {error:e}");
        }
    }
}

#[test]
fn weights_and_a_far_mean_cost_less_than_a_last_bit_of_the_entries() {
    let (m, n) = (64, 4);
    let integers = dyadic(m, n, 100_000_000, 5);
    let x = Mat::from_fn(m, n, |i, j| integers[i][j] as f64 * 2f64.powi(-20));
    let weights: Vec<i128> = (0..m).map(|i| (i % 5) as i128 + 1).collect();
    let rows = Rows { x, weights: Some(weights.iter().map(|&w| w as f64).collect()) };
    let c = rows.whole(&rows.bounds(), true).finish(1.0, Uplo::Both).unwrap();
    let total: i128 = weights.iter().sum();
    for i in 0..n {
        for j in 0..n {
            let sum = |f: &dyn Fn(&[i128]) -> i128| {
                integers.iter().zip(&weights).map(|(row, w)| w * f(row)).sum::<i128>()
            };
            let products = sum(&|row| row[i] * row[j]);
            let numerator = total * products - sum(&|row| row[i]) * sum(&|row| row[j]);
            let expected = numerator as f64 / total as f64 * 2f64.powi(-40);
            let error = (c.as_ref()[(i, j)] - expected).abs();
            // Entries of 4e8 have a last bit of 2^-24; deviations are about 1.
            assert!(error <= total as f64 * 2f64.powi(-24), "({i}, {j}): {error:e}");
        }
    }
}

#[test]
fn sums_without_centring_are_rounded_once() {
    let (m, n) = (300, 6);
    let integers = dyadic(m, n, 3, 6);
    let x = Mat::from_fn(m, n, |i, j| integers[i][j] as f64 * 2f64.powi(-20));
    let rows = Rows { x, weights: None };
    let c = rows.whole(&rows.bounds(), false).finish(1.0, Uplo::Both).unwrap();
    for i in 0..n {
        for j in 0..n {
            let sum: i128 = integers.iter().map(|row| row[i] * row[j]).sum();
            assert_eq!(c.as_ref()[(i, j)], sum as f64 * 2f64.powi(-40), "({i}, {j})");
        }
    }
}

/// Checks the promised error for columns whose largest entry is far above the others.
fn spikes<T: BlasReal>() {
    let (m, n) = (500, 8);
    let mut rng = Rng::new(7);
    let x = Mat::from_fn(m, n, |i, j| {
        let spike = if i == j { f64::from(8 * j as i32).exp2() } else { 1.0 };
        T::from_f64(rng.normal() * spike)
    });
    let rows = Rows { x, weights: None };
    let c = rows.whole(&rows.bounds(), false).finish(1.0, Uplo::Lower).unwrap();
    let dot = |i: usize, j: usize| -> f64 {
        (0..m).map(|k| rows.x[(k, i)].to_f64() * rows.x[(k, j)].to_f64()).sum()
    };
    for i in 0..n {
        for j in 0..=i {
            let error = (c.as_ref()[(i, j)].to_f64() - dot(i, j)).abs();
            let norms = dot(i, i).sqrt() * dot(j, j).sqrt();
            let limit = 4.0 * m as f64 * T::UNIT_ROUNDOFF * norms;
            assert!(error <= limit, "({i}, {j}): {error:e}, {limit:e}");
        }
    }
}

#[test]
fn columns_with_spikes_keep_the_promise() {
    spikes::<f64>();
    spikes::<f32>();
}

#[test]
fn the_largest_integers_overflow_neither_residues_nor_sums() {
    // All entries at their bounds, more rows than the residues of one product hold.
    let (m, n) = ((1 << 14) + 7, 2);
    let x = Mat::from_fn(m, n, |_, j| if j == 0 { 1.0_f32 } else { -1.0 });
    let rows = Rows { x, weights: None };
    let c = rows.whole(&rows.bounds(), false).finish(1.0, Uplo::Lower).unwrap();
    assert_eq!((c.as_ref()[(0, 0)], c.as_ref()[(1, 0)]), (m as f32, -(m as f32)));
    let bounds = RowBounds::new(vec![-1.0; 2], vec![1.0; 2], 1 << 40).unwrap();
    let narrow = Accumulator::<f64>::exact(&bounds, false).unwrap();
    let Sums::Exact(sums) = &narrow.sums else { unreachable!() };
    let Capacity { slab, rows: room, .. } = sums.grid.capacity();
    assert!(slab >= 1 << 16 && room >= 1 << 40, "{slab} {room}");
}

#[test]
fn a_row_beyond_its_bounds_is_refused_and_changes_nothing() {
    let bounds = RowBounds::new(vec![-1.0, 0.0], vec![1.0, 4.0], 10).unwrap();
    let mut sum = Accumulator::<f64>::exact(&bounds, true).unwrap();
    let options = AtaOptions::new();
    sum.add_block(mat![[0.5, 2.0]], None, &options).unwrap();
    let before = bytes(&sum);
    let error = sum.add_block(mat![[0.5, 1.0], [0.0, 4.5]], None, &options).unwrap_err();
    assert_eq!(error.to_string(), "rows: 4.5 in column 1 is beyond its bounds 0..=4");
    let error = sum.add_block(mat![[0.5, 1.0]], Some(&[1.0]), &options).unwrap_err();
    assert!(matches!(error, Error::Argument { what: "weights", .. }), "{error}");
    assert!(bytes(&sum) == before);
    let mut sum = Accumulator::<f64>::exact(&bounds.with_weights(2.0).unwrap(), true).unwrap();
    sum.add_block(mat![[0.5, 1.0]], Some(&[-2.0]), &options).unwrap();
    let error = sum.add_block(mat![[0.5, 1.0]], Some(&[2.5]), &options).unwrap_err();
    assert_eq!(error.to_string(), "weights: 2.5 is beyond the bound 2");
}

#[test]
fn a_block_of_several_pieces_is_added_whole_or_not_at_all() {
    let (m, n, height) = (23, 3, 5);
    let bounds = RowBounds::new(vec![0.0; n], vec![4.0; n], 50).unwrap();
    let options = AtaOptions::new().threads(2);
    for mut sum in [
        Accumulator::<f64>::exact(&bounds, true).unwrap(),
        Accumulator::extended(&bounds, true).unwrap(),
    ] {
        let mut rows = Mat::from_fn(m, n, |i, j| ((i + j) % 4) as f64);
        sum.change_block(rows.as_ref(), None, false, height, &options).unwrap();
        let before = bytes(&sum);
        rows[(22, 1)] = 4.5;
        let error = sum.change_block(rows.as_ref(), None, false, height, &options).unwrap_err();
        assert_eq!(error.to_string(), "rows: 4.5 in column 1 is beyond its bounds 0..=4");
        rows[(22, 1)] = f64::NAN;
        let error = sum.change_block(rows.as_ref(), None, true, height, &options).unwrap_err();
        assert!(matches!(error, Error::NonFinite { index: (22, 1), .. }), "{error}");
        assert!(bytes(&sum) == before);
    }
}

#[test]
fn rows_that_are_not_finite_are_named_by_their_number_in_the_source() {
    let (m, n, height) = (23, 3, 5);
    let bounds = RowBounds::new(vec![0.0; n], vec![4.0; n], 50).unwrap();
    let options = AtaOptions::new().threads(2);
    for mut sum in [
        Accumulator::<f64>::exact(&bounds, true).unwrap(),
        Accumulator::extended(&bounds, true).unwrap(),
    ] {
        let mut rows = Mat::from_fn(m, n, |i, j| ((i + j) % 4) as f64);
        sum.add_rows(&mut DenseRows(rows.as_ref()), None, &options).unwrap();
        rows[(17, 1)] = f64::NAN;
        let mut source = DenseRows(rows.as_ref());
        let error = sum.change_rows(&mut source, None, true, height, &options).unwrap_err();
        assert_eq!(error, Error::NonFinite { what: "rows", index: (17, 1) });
    }
}

#[test]
fn means_are_finite_where_sums_overflow() {
    let (large, options) = (1.5 * 2f64.powi(1023), AtaOptions::new());
    let rows = mat![[large, -large, 1.0], [large, -large, 3.0]];
    let bounds = RowBounds::<f64>::of(&mut DenseRows(rows.as_ref()), None, 64, &options).unwrap();
    for mut sum in [
        Accumulator::new(3, true).unwrap(),
        Accumulator::exact(&bounds, true).unwrap(),
        Accumulator::extended(&bounds, true).unwrap(),
    ] {
        sum.add_block(rows.as_ref(), None, &options).unwrap();
        assert_eq!(sum.mean(), [large, -large, 2.0]);
        let c = sum.finish(1.0, Uplo::Both).unwrap();
        assert_eq!(c.as_ref(), mat![[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 2.0]]);
    }
    let mut sum = Accumulator::<f64>::new(3, true).unwrap();
    sum.add_block(rows.as_ref(), Some(&[3.0, 1.0]), &options).unwrap();
    assert_eq!(sum.mean(), [large, -large, 1.5]);
    // What is not finite stays so.
    let rows = mat![[large, 1.0, f64::NAN], [f64::INFINITY, 2.0, 1.0]];
    let mut sum = Accumulator::<f64>::new(3, true).unwrap();
    sum.add_block(rows.as_ref(), None, &options).unwrap();
    assert!(!sum.mean()[0].is_finite() && sum.mean()[1] == 1.5 && sum.mean()[2].is_nan());
}

#[test]
fn blocks_without_rows_are_refused_before_a_row_is_read() {
    let (rows, options) = (Mat::<f64>::zeros(3, 2), AtaOptions::new());
    let mut rows = DenseRows(rows.as_ref());
    let bounds = RowBounds::<f64>::of(&mut rows, None, 0, &options).unwrap_err();
    let mut sum = Accumulator::<f64>::new(2, false).unwrap();
    let streamed = stream(&mut rows, None, 0, &mut sum, &options, &mut |_| Ok(())).unwrap_err();
    assert_eq!(bounds, streamed);
    assert_eq!(bounds.to_string(), "block rows: must be at least 1");
}

#[test]
fn sums_of_another_kind_leave_the_accumulator_as_it_was() {
    let bounds = RowBounds::new(vec![0.0], vec![4.0], 50).unwrap();
    let (rows, options) = (mat![[1.0], [2.0]], AtaOptions::new());
    let mut sum = Accumulator::<f64>::new(1, false).unwrap();
    sum.set_labels(vec![("file".into(), "a.npy".into())]);
    stream(&mut DenseRows(rows.as_ref()), None, 1, &mut sum, &options, &mut |_| Ok(())).unwrap();
    let before = bytes(&sum);
    for other in [Accumulator::exact(&bounds, false), Accumulator::extended(&bounds, false)] {
        let mut other = other.unwrap();
        other.add_block(rows.as_ref(), None, &options).unwrap();
        let error = sum.merge(other).unwrap_err().to_string();
        assert!(error.starts_with("accumulator: sums: floating-point and e"), "{error}");
        assert!(bytes(&sum) == before);
    }
}

#[test]
fn a_block_may_have_any_strides() {
    let rows = Mat::from_fn(5, 3, |i, j| (2 * i + j) as f64);
    let stored = Mat::from_fn(7, 5, |j, i| if j < 3 { rows[(4 - i, j)] } else { f64::NAN });
    let view = stored.as_ref().subrows(0, 3).transpose().reverse_rows();
    let of = |rows: MatRef<'_, f64>| {
        let mut sum = Accumulator::<f64>::new(3, true).unwrap();
        sum.add_block(rows, None, &AtaOptions::new()).unwrap();
        bytes(&sum)
    };
    assert!(of(view) == of(rows.as_ref()));
    let mut sum = Accumulator::<f64>::new(2, false).unwrap();
    let error = sum.add_block(view, None, &AtaOptions::new()).unwrap_err();
    assert!(matches!(error, Error::Shape { what: "block", .. }), "{error}");
}

#[test]
fn entries_that_are_not_finite_reach_what_they_should_in_any_order() {
    let (m, n) = (70, 9);
    let mut rows = Rows::<f64>::random(m, n, true, 8);
    let x = &mut rows.x;
    x[(3, 2)] = f64::NAN;
    x[(64, 4)] = f64::INFINITY;
    x[(5, 4)] = f64::NEG_INFINITY;
    x[(5, 7)] = f64::INFINITY;
    x[(5, 6)] = 0.0;
    let weights = rows.weights.clone().unwrap();
    let bounds = rows.bounds();
    let run = |height: usize, split: bool| {
        let mut parts = [0, 1].map(|_| Accumulator::exact(&bounds, false).unwrap());
        for (k, block) in shuffled(m, height as u64).chunks(height).enumerate() {
            let part = &mut parts[if split { k % 2 } else { 0 }];
            rows.add(part, block, false, 2, &PORTABLE).unwrap();
        }
        let [mut sum, other] = parts;
        sum.merge(other).unwrap();
        let again = Accumulator::<f64>::read(&mut &bytes(&sum)[..]).unwrap();
        assert!(bytes(&again) == bytes(&sum));
        sum
    };
    let expected = bytes(&run(m, false));
    for (height, split) in [(1, false), (1, true), (13, true)] {
        let sum = run(height, split);
        let mut other = Accumulator::<f64>::read(&mut &expected[..]).unwrap();
        other.expected_rows = sum.expected_rows;
        assert!(bytes(&sum) == bytes(&other), "{height}");
    }
    let c = run(m, false).finish(1.0, Uplo::Lower).unwrap();
    for i in 0..n {
        for j in 0..=i {
            let terms = (0..m).map(|k| rows.x[(k, i)] * (weights[k] * rows.x[(k, j)]));
            let (found, right) = (c.as_ref()[(i, j)], terms.sum::<f64>());
            let same = found == right || found.is_nan() && right.is_nan();
            assert!(same || right.is_finite() && found.is_finite(), "({i}, {j}): {found} {right}");
        }
    }
    let mut sum = run(m, false);
    let before = bytes(&sum);
    let error = rows.add(&mut sum, &[3], true, 1, &PORTABLE).unwrap_err();
    assert!(matches!(error, Error::NonFinite { what: "rows", .. }), "{error}");
    assert!(bytes(&sum) == before);
    let centered = rows.whole(&bounds, true).finish(1.0, Uplo::Lower).unwrap();
    assert!(centered.as_ref()[(4, 0)].is_nan() && centered.as_ref()[(1, 0)].is_finite());
}

#[test]
fn bounds_of_parts_join_to_those_of_the_whole() {
    let rows = Rows::<f64>::random(50, 4, true, 9);
    let part = |range: std::ops::Range<usize>| {
        let (x, weights) = rows.pieces(&range.clone().collect::<Vec<_>>());
        Rows { x: Mat::from_fn(range.len(), 4, |i, j| x[i * 4 + j]), weights }.bounds()
    };
    for cut in [0, 1, 20, 50] {
        let mut joined = part(cut..50);
        joined.join(&part(0..cut)).unwrap();
        assert_eq!(joined, rows.bounds());
    }
    let refused = RowBounds::new(vec![1.0], vec![0.0], 1).unwrap_err().to_string();
    assert!(refused.contains("column 0"), "{refused}");
    assert!(part(0..5).join(&RowBounds::new(vec![0.0; 4], vec![1.0; 4], 1).unwrap()).is_err());
}

#[test]
fn weights_of_both_signs_that_sum_to_zero_have_no_mean() {
    let rows = Rows { x: Mat::from_fn(2, 1, |i, _| i as f64), weights: Some(vec![0.1, -0.1]) };
    let sum = rows.whole(&rows.bounds(), true);
    let error = sum.finish(1.0, Uplo::Lower).map(drop).unwrap_err();
    assert!(matches!(error, Error::Argument { what: "weights", .. }), "{error}");
}

/// Any number of rows without columns, which nobody reads.
struct Hollow(usize);

impl RowBlocks<f64> for Hollow {
    fn nrows(&self) -> usize {
        self.0
    }

    fn ncols(&self) -> usize {
        0
    }

    fn read(&mut self, _: usize, _: MatMut<'_, f64>) -> Result<()> {
        panic!("there is nothing to read");
    }
}

#[test]
fn rows_without_columns_take_no_time_however_many_they_are() {
    const ROWS: usize = 1 << 55;
    let mut rows = Hollow(ROWS);
    let (options, mean) = (AtaOptions::new(), RowOptions::<f64>::new().center(Center::Mean));
    let bounds = RowBounds::<f64>::of(&mut rows, None, 64, &options).unwrap();
    for mut sum in [
        Accumulator::new(0, false).unwrap(),
        Accumulator::new(0, true).unwrap(),
        Accumulator::exact(&bounds, true).unwrap(),
        Accumulator::extended(&bounds, false).unwrap(),
    ] {
        stream(&mut rows, None, 64, &mut sum, &options, &mut |_| Ok(())).unwrap();
        assert_eq!(sum.rows(), ROWS as u64);
    }
    assert_eq!(ata_extended(&mut rows, &mean, &options).unwrap().n(), 0);
    let none = Mat::<f64>::new();
    let checked = verify_rows(1.0, &mut rows, &mean, none.as_ref(), Uplo::Lower, 2, 0).unwrap();
    assert!(checked.passed);
}
