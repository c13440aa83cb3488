//! Streams of rows: sums against oracles, stops and merges, the file of an accumulator, sources
//! that fail.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use catamaran::base::{Rng, block_rows};
use catamaran::blas::BlasReal;
use catamaran::faer::{Mat, MatMut, MatRef};
use catamaran::rows::{
    Accumulator, Center, DenseRows, RowBlocks, RowBounds, RowOptions, StreamPlan, ata_rows,
    scalar_of, stream,
};
use catamaran::{AtaOptions, Error, Par, Result, SchemeChoice, Uplo};

use crate::common::{bits, gaussian, integers, oracle};

/// Adds the rows of `a` to `accumulator`, nothing between the blocks.
fn add<T: BlasReal>(
    accumulator: &mut Accumulator<T>,
    a: MatRef<'_, T>,
    weights: Option<&[T]>,
    block_rows: usize,
) -> Result<()> {
    let options = AtaOptions::default();
    stream(&mut DenseRows(a), weights, block_rows, accumulator, &options, &mut |_| Ok(()))
}

/// The accumulator of all rows of `a`.
fn accumulated<T: BlasReal>(
    a: MatRef<'_, T>,
    weights: Option<&[T]>,
    centered: bool,
    block_rows: usize,
) -> Accumulator<T> {
    let mut accumulator = Accumulator::new(a.ncols(), centered).unwrap();
    add(&mut accumulator, a, weights, block_rows).unwrap();
    accumulator
}

/// The exact sums of all rows of `a`.
fn exactly<T: BlasReal>(
    a: MatRef<'_, T>,
    weights: Option<&[T]>,
    centered: bool,
    block_rows: usize,
) -> Accumulator<T> {
    let options = AtaOptions::new().reproducible(true).threads(2);
    let mut sum = Accumulator::new(a.ncols(), centered).unwrap();
    stream(&mut DenseRows(a), weights, block_rows, &mut sum, &options, &mut |_| Ok(())).unwrap();
    assert!(sum.is_exact());
    sum
}

fn bytes<T: BlasReal>(accumulator: &Accumulator<T>) -> Vec<u8> {
    let mut bytes = Vec::new();
    accumulator.write(&mut bytes).unwrap();
    bytes
}

fn copy<T: BlasReal>(accumulator: &Accumulator<T>) -> Accumulator<T> {
    Accumulator::read(&mut &bytes(accumulator)[..]).unwrap()
}

/// Both triangles of the result.
fn both<T: BlasReal>(accumulator: Accumulator<T>) -> Mat<T> {
    let c = accumulator.finish(1.0, Uplo::Both).unwrap();
    Mat::from_fn(c.rows().len(), c.rows().end, |i, j| c.as_ref()[(i, j)])
}

/// The weighted scatter about the mean, by two passes in f64 over exact entries.
fn scatter<T: BlasReal>(a: MatRef<'_, T>, weights: Option<&[T]>) -> Mat<f64> {
    let weight = |i: usize| weights.map_or(1.0, |w| w[i].to_f64());
    let total: f64 = (0..a.nrows()).map(weight).sum();
    let mean: Vec<f64> = (0..a.ncols())
        .map(|j| (0..a.nrows()).map(|i| weight(i) * a[(i, j)].to_f64()).sum::<f64>() / total)
        .collect();
    let x = Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)].to_f64() - mean[j]);
    let weights: Vec<f64> = (0..a.nrows()).map(weight).collect();
    let zero = Mat::zeros(a.ncols(), a.ncols());
    oracle(1.0, x.as_ref(), Some(&weights), x.as_ref(), 0.0, zero.as_ref())
}

fn largest_difference<T: BlasReal>(c: MatRef<'_, T>, expected: MatRef<'_, f64>) -> f64 {
    let difference =
        Mat::from_fn(c.nrows(), c.ncols(), |i, j| c[(i, j)].to_f64() - expected[(i, j)]);
    difference.norm_max()
}

fn every_shape_and_block<T: BlasReal>() {
    for (m, n) in [(0, 0), (0, 3), (1, 0), (5, 0), (1, 1), (2, 3), (61, 7), (127, 31), (300, 65)] {
        let a = integers::<T>(m, n, 1);
        let wide = integers::<T>(m, 1, 2);
        let weights: Vec<T> = (0..m).map(|i| wide[(i, 0)]).collect();
        let wide: Vec<f64> = weights.iter().map(|w| w.to_f64()).collect();
        for block_rows in [1, 7, 64, 1000] {
            for weighted in [false, true] {
                let w = weighted.then_some(&weights[..]);
                let w_wide = weighted.then_some(&wide[..]);
                // With beta 0 no C is read.
                let av = a.as_ref();
                let expected = oracle(2.0, av, w_wide, av, 0.0, av);
                for uplo in [Uplo::Lower, Uplo::Upper, Uplo::Both] {
                    let sum = accumulated(a.as_ref(), w, false, block_rows);
                    assert_eq!((sum.rows(), sum.expected_rows()), (m as u64, m as u64));
                    let c = sum.finish(2.0, uplo).unwrap();
                    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                        let given = match uplo {
                            Uplo::Lower => i >= j,
                            Uplo::Upper => i <= j,
                            Uplo::Both => true,
                        };
                        let wanted = if given { expected[(i, j)] } else { 0.0 };
                        let found = c.as_ref()[(i, j)].to_f64();
                        assert_eq!(found, wanted, "{m} x {n}, {block_rows} rows, {uplo:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn sums_are_exact_for_every_shape_block_and_triangle() {
    every_shape_and_block::<f64>();
    every_shape_and_block::<f32>();
}

#[test]
fn scatter_survives_a_mean_that_is_huge_and_drifts() {
    let (m, n) = (3001, 13);
    let noise = gaussian::<f64>(m, n, 3);
    let weights: Vec<f64> = gaussian::<f64>(m, 1, 4).col(0).iter().map(|w: &f64| w + 0.5).collect();
    // The last one drifts by 30 deviations from the first block to the last.
    for (offset, drift) in [(0.0, 0.0), (1e8, 0.0), (-1e6, 0.01)] {
        let a = Mat::from_fn(m, n, |i, j| noise[(i, j)] + offset + drift * i as f64);
        for w in [None, Some(&weights[..])] {
            let expected = scatter(a.as_ref(), w);
            let scale = expected.norm_max();
            let c = both(accumulated(a.as_ref(), w, true, 100));
            let error = largest_difference(c.as_ref(), expected.as_ref()) / scale;
            // The oracle itself has the rounding of its mean: u offset.
            assert!(error < 1e-12 + 1e-16 * f64::abs(offset), "{offset} {drift}: {error:e}");
        }
        let narrow = Mat::from_fn(m, n, |i, j| a[(i, j)] as f32);
        let expected = scatter(narrow.as_ref(), None);
        let c = both(accumulated(narrow.as_ref(), None, true, 100));
        let error = largest_difference(c.as_ref(), expected.as_ref()) / expected.norm_max();
        assert!(error < 3e-6, "f32, {offset} {drift}: {error:e}");
    }
}

#[test]
fn means_are_those_of_the_rows() {
    let a = integers::<f64>(40, 3, 5);
    let sum = accumulated(a.as_ref(), None, true, 7);
    for (j, mean) in sum.mean().into_iter().enumerate() {
        let expected = a.col(j).iter().sum::<f64>() / 40.0;
        assert!((mean - expected).abs() < 1e-14, "{mean} {expected}");
    }
    assert!(accumulated(a.as_ref(), None, false, 7).mean().is_empty());
}

#[test]
fn first_block_without_weight_still_gives_a_shift() {
    let (m, n) = (50, 4);
    let a = Mat::from_fn(m, n, |i, j| 1e6 + (i * j % 7) as f64);
    let weights: Vec<f64> = (0..m).map(|i| if i < 10 { 0.0 } else { 1.0 }).collect();
    let c = both(accumulated(a.as_ref(), Some(&weights), true, 10));
    let expected = scatter(a.as_ref(), Some(&weights));
    assert!(largest_difference(c.as_ref(), expected.as_ref()) < 1e-9);
}

#[test]
fn weights_that_sum_to_zero_have_no_mean() {
    let a = integers::<f64>(4, 2, 6);
    let weights = [1.0, -1.0, 2.0, -2.0];
    let sum = accumulated(a.as_ref(), Some(&weights), true, 3);
    let error = sum.finish(1.0, Uplo::Lower).map(drop).unwrap_err();
    assert!(matches!(error, Error::Argument { what: "weights", .. }), "{error}");
    let sum = accumulated(a.as_ref(), Some(&weights), false, 3);
    let entry = |r: usize, i: usize, j: usize| weights[r] * a[(r, i)] * a[(r, j)];
    let expected = Mat::from_fn(2, 2, |i, j| (0..4).map(|r| entry(r, i, j)).sum::<f64>());
    assert!(largest_difference(both(sum).as_ref(), expected.as_ref()) < 1e-9);
}

#[test]
fn bits_do_not_depend_on_threads_or_on_the_speed_of_the_source() {
    let (m, n) = (5003, 40);
    let a = gaussian::<f64>(m, n, 7);
    let weights: Vec<f64> = gaussian::<f64>(m, 1, 8).col(0).iter().copied().collect();
    let run = |par, centered, slow| {
        let mut source = Source { slow, ..Source::new(a.as_ref()) };
        let mut sum = Accumulator::new(n, centered).unwrap();
        let options = AtaOptions::new().par(par);
        stream(&mut source, Some(&weights), 700, &mut sum, &options, &mut |_| Ok(())).unwrap();
        bytes(&sum)
    };
    for centered in [false, true] {
        let expected = run(Par::Seq, centered, false);
        for threads in [1, 2, 5] {
            assert!(run(Par::Threads(threads), centered, false) == expected, "{threads} threads");
        }
        assert!(run(Par::Threads(2), centered, true) == expected, "slow source");
    }
}

#[test]
fn stop_after_any_block_and_resume_gives_the_same_bytes() {
    let (m, n, height) = (641, 9, 64);
    let a = gaussian::<f64>(m, n, 9);
    let weights: Vec<f64> = gaussian::<f64>(m, 1, 10).col(0).iter().copied().collect();
    let labels = vec![("scheme".to_owned(), "auto".to_owned())];
    for (w, centered) in [(None, false), (None, true), (Some(&weights[..]), true)] {
        let options = AtaOptions::default();
        let mut kept = Vec::new();
        let mut sum = Accumulator::new(n, centered).unwrap();
        sum.set_labels(labels.clone());
        let mut rows = DenseRows(a.as_ref());
        let mut keep = |sum: &Accumulator<f64>| {
            kept.push(bytes(sum));
            Ok(())
        };
        stream(&mut rows, w, height, &mut sum, &options, &mut keep).unwrap();
        assert_eq!(kept.len(), m.div_ceil(height));
        let expected = bytes(&sum);
        for start in kept {
            let mut sum = Accumulator::read(&mut &start[..]).unwrap();
            assert_eq!(sum.labels(), labels);
            add(&mut sum, a.as_ref(), w, height).unwrap();
            assert!(bytes(&sum) == expected, "from {}", sum.rows());
        }
    }
}

#[test]
fn resuming_with_other_rows_blocks_or_options_says_which() {
    let a = integers::<f64>(100, 5, 11);
    let begun = || {
        let mut sum = Accumulator::new(5, false).unwrap();
        let mut source = Source { fails_at: Some(64), ..Source::new(a.as_ref()) };
        let options = AtaOptions::default();
        stream(&mut source, None, 32, &mut sum, &options, &mut |_| Ok(())).unwrap_err();
        assert_eq!((sum.rows(), sum.expected_rows()), (64, 100));
        sum
    };
    let refusal = |a: MatRef<'_, f64>, block_rows| {
        add(&mut begun(), a, None, block_rows).unwrap_err().to_string()
    };
    let longer = integers::<f64>(101, 5, 11);
    assert!(refusal(longer.as_ref(), 32).contains("rows was 100, and is 101 now"));
    assert!(refusal(a.as_ref(), 16).contains("rows of a block was 32, and is 16 now"));
    assert!(refusal(a.as_ref().subcols(0, 4), 32).contains("columns was 5, and is 4 now"));
    assert!(refusal(a.as_ref(), 0).contains("at least 1"));

    let labels = |scheme: &str| {
        vec![("file".to_owned(), "a".to_owned()), ("scheme".to_owned(), scheme.to_owned())]
    };
    let mut sum = begun();
    sum.set_labels(labels("auto"));
    assert_eq!(sum.check_labels(&labels("auto")), Ok(()));
    let message = sum.check_labels(&labels("exact")).unwrap_err().to_string();
    assert_eq!(message, "accumulator: scheme was auto, and is exact now");
    let message = sum.check_labels(&labels("auto")[..1]).unwrap_err().to_string();
    assert_eq!(message, "accumulator: scheme was auto, and is nothing now");
}

#[test]
fn merged_parts_are_the_whole_in_any_grouping() {
    let (m, n) = (1000, 11);
    let noise = gaussian::<f64>(m, n, 12);
    // Every part has a shift far from those of the others.
    let a = Mat::from_fn(m, n, |i, j| noise[(i, j)] + 1e4 + 10.0 * (i / 250) as f64);
    let weights: Vec<f64> = (0..m).map(|i| 1.0 + (i % 3) as f64).collect();
    for (weighted, centered) in [(false, false), (false, true), (true, true)] {
        let w = weighted.then_some(&weights[..]);
        // One of the parts is small, one has no rows.
        let bounds = [0, 250, 253, 253, 750, 1000];
        let part = |k: usize| {
            let rows = bounds[k]..bounds[k + 1];
            let w = w.map(|w| &w[rows.clone()]);
            accumulated(a.as_ref().subrows(rows.start, rows.len()), w, centered, 64)
        };
        let expected = if centered {
            scatter(a.as_ref(), w)
        } else {
            oracle(1.0, a.as_ref(), w, a.as_ref(), 0.0, Mat::<f64>::zeros(n, n).as_ref())
        };
        let fold = |order: &[usize]| {
            let mut sum = part(order[0]);
            order[1..].iter().for_each(|&k| sum.merge(part(k)).unwrap());
            sum
        };
        let mut pairs = fold(&[0, 1]);
        let mut others = fold(&[2, 3]);
        others.merge(part(4)).unwrap();
        pairs.merge(others).unwrap();
        for sum in [fold(&[0, 1, 2, 3, 4]), fold(&[4, 2, 3, 1, 0]), fold(&[2, 1, 0, 4, 3]), pairs] {
            assert_eq!((sum.rows(), sum.expected_rows()), (m as u64, m as u64));
            let c = both(copy(&sum));
            let error = largest_difference(c.as_ref(), expected.as_ref()) / expected.norm_max();
            assert!(error < 1e-13, "{weighted} {centered}: {error:e}");
        }
    }
}

#[test]
fn merging_an_empty_accumulator_changes_nothing() {
    let a = gaussian::<f64>(30, 4, 13);
    for centered in [false, true] {
        let expected = both(accumulated(a.as_ref(), None, centered, 8));
        let empty = || Accumulator::<f64>::new(4, centered).unwrap();
        let mut left = empty();
        left.merge(accumulated(a.as_ref(), None, centered, 8)).unwrap();
        let mut right = accumulated(a.as_ref(), None, centered, 8);
        right.merge(empty()).unwrap();
        let mut none = empty();
        none.merge(empty()).unwrap();
        assert_eq!(bits(both(left).as_ref()), bits(expected.as_ref()));
        assert_eq!(bits(both(right).as_ref()), bits(expected.as_ref()));
        assert_eq!(both(none), Mat::<f64>::zeros(4, 4));
    }
    // Rows of weight zero give a shift, but no weight.
    let mut sum = Accumulator::<f64>::new(4, true).unwrap();
    sum.merge(accumulated(a.as_ref(), Some(&[0.0; 30]), true, 8)).unwrap();
    assert_eq!((sum.rows(), sum.weight()), (30, 0.0));
}

#[test]
fn accumulators_that_do_not_fit_are_not_merged() {
    let refusal =
        |mut a: Accumulator<f64>, b: Accumulator<f64>| a.merge(b).unwrap_err().to_string();
    let new = |n, centered| Accumulator::new(n, centered).unwrap();
    assert!(refusal(new(3, true), new(4, true)).contains("columns: 3 and 4"));
    assert!(refusal(new(3, true), new(3, false)).contains("centring: centred and not centred"));
    let strip = Accumulator::of_strip(3, 1..3, true).unwrap();
    assert!(refusal(new(3, true), strip).contains("rows of C: 0..3 and 1..3"));
    let error = Accumulator::<f64>::of_strip(3, 2..4, true).unwrap_err();
    assert!(matches!(error, Error::Argument { what: "strip", .. }));
}

fn file_survives<T: BlasReal>() {
    let a = gaussian::<T>(70, 6, 14);
    let weights: Vec<T> = (0..70).map(|i| T::from_f64(f64::from(i) - 20.0)).collect();
    for (exact, centered) in [(false, false), (false, true), (true, false), (true, true)] {
        let mut sum = match exact {
            false => accumulated(a.as_ref(), None, centered, 32),
            true => exactly(a.as_ref(), Some(&weights), centered, 32),
        };
        sum.set_labels(vec![("name".into(), "value ü".into()), ("empty".into(), String::new())]);
        let whole = bytes(&sum);
        assert_eq!(scalar_of(&mut &whole[..]).unwrap(), T::NAME);
        let again = Accumulator::<T>::read(&mut &whole[..]).unwrap();
        assert_eq!(again.labels(), sum.labels());
        assert!(bytes(&again) == whole);
        let refused = |bytes: &[u8]| match Accumulator::<T>::read(&mut &bytes[..]) {
            Ok(_) => panic!("accepted"),
            Err(e) => e.to_string(),
        };
        for length in 0..whole.len() {
            assert!(refused(&whole[..length]).contains("truncated"), "{length} bytes");
        }
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 1 << (at % 8);
            refused(&damaged);
        }
        assert!(refused(&[&whole[..], b"x"].concat()).contains("after its end"));
        let mut later = whole.clone();
        later[8] = 1;
        assert!(refused(&later).contains("version 1, but 2 is supported"));
        assert!(refused(b"something else").contains("not an accumulator"));
    }
}

#[test]
fn damaged_files_of_accumulators_are_refused() {
    file_survives::<f64>();
    file_survives::<f32>();
    let narrow = bytes(&Accumulator::<f32>::new(2, false).unwrap());
    let error = Accumulator::<f64>::read(&mut &narrow[..]).unwrap_err().to_string();
    assert_eq!(error, "an accumulator of f32, not of f64");
}

#[test]
fn a_short_file_of_a_huge_accumulator_is_an_error_and_not_an_abort() {
    for columns in [1_u64 << 40, 1 << 61, u64::MAX] {
        for flags in [0, 1, 2, 4, 7, 31] {
            let mut file = b"CATAACC\0\x02\0\0\0\x08\0\0\0".to_vec();
            let numbers = [columns, 0, columns, 5, 5, 5];
            let mut head: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
            head.extend([flags, 0, 0, 0, 0]);
            file.extend((head.len() as u32).to_le_bytes());
            file.extend(head);
            let mut check = crc32fast::Hasher::new();
            check.update(&file);
            file.extend(check.finalize().to_le_bytes());
            file.extend([0; 16]);
            let error = Accumulator::<f64>::read(&mut &file[..]).map(drop).unwrap_err();
            let kinds = [std::io::ErrorKind::InvalidData, std::io::ErrorKind::OutOfMemory];
            assert!(kinds.contains(&error.kind()), "{columns}, {flags}: {error}");
        }
    }
}

/// Returns the file of `sum` with other numbers in its head: rows are number 3, expected rows 4.
fn with_numbers(sum: &Accumulator<f64>, numbers: &[(usize, u64)]) -> Vec<u8> {
    let mut file = bytes(sum);
    for (which, number) in numbers {
        file[20 + 8 * which..][..8].copy_from_slice(&number.to_le_bytes());
    }
    let end = 20 + u32::from_le_bytes(file[16..20].try_into().unwrap()) as usize;
    let check = crc32fast::hash(&file[..end]);
    file[end..][..4].copy_from_slice(&check.to_le_bytes());
    file
}

/// Returns the file of `sum` with another last entry of C.
fn with_last_entry(sum: &Accumulator<f64>, entry: i128) -> Vec<u8> {
    let mut file = bytes(sum);
    let (begin, end) =
        (24 + u32::from_le_bytes(file[16..20].try_into().unwrap()) as usize, file.len() - 4);
    file[end - 16..end].copy_from_slice(&entry.to_le_bytes());
    let check = crc32fast::hash(&file[begin..end]);
    file[end..].copy_from_slice(&check.to_le_bytes());
    file
}

#[test]
fn accumulators_with_numbers_that_no_sum_has_are_refused() {
    let a = gaussian::<f64>(20, 3, 77);
    let float = accumulated(a.as_ref(), None, false, 8);
    let exact = exactly(a.as_ref(), None, false, 8);
    let read = |file: &[u8]| Accumulator::<f64>::read(&mut &file[..]);
    let refused = |file: &[u8]| read(file).map(drop).unwrap_err().to_string();
    for sum in [&float, &exact] {
        for which in 3..6 {
            let said = refused(&with_numbers(sum, &[(which, u64::MAX)]));
            assert!(said.contains("its numbers of rows"), "{said}");
        }
        // The largest number of rows, with which additions must not overflow.
        let most = 1 << 62;
        let mut sum = read(&with_numbers(sum, &[(3, most), (4, most)])).unwrap();
        for other in [&float, &exact].map(|sum| read(&with_numbers(sum, &[(3, most), (4, most)]))) {
            // An error where the kinds differ.
            let _ = sum.merge(other.unwrap());
            assert!(sum.rows() >= most && sum.expected_rows() >= most);
        }
        let options = AtaOptions::new();
        let _ = sum.add_block(Mat::full(1, 3, 0.5), None, &options);
        // Rows that are there already are no rows of a shorter matrix.
        let mut longer = read(&with_numbers(&float, &[(3, 21)])).unwrap();
        let rows = &mut DenseRows(a.as_ref());
        let error = stream(rows, None, 8, &mut longer, &options, &mut |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("21 rows are summed already, of 20"), "{error}");
    }
    for entry in [i128::MAX, i128::MIN] {
        let said = refused(&with_last_entry(&exact, entry));
        assert!(said.contains("sums that its rows can't have"), "{said}");
    }
    let none = read(&with_numbers(&exact, &[(3, 0)])).map(drop).unwrap_err().to_string();
    assert!(none.contains("sums that its rows can't have"), "{none}");
}

#[test]
fn exact_sums_are_the_same_bits_for_any_blocks_threads_stops_and_strips() {
    let (m, n) = (341, 23);
    let noise = gaussian::<f64>(m, n, 31);
    let a = Mat::from_fn(m, n, |i, j| noise[(i, j)] + 1e6 * j as f64);
    let weights: Vec<f64> =
        gaussian::<f64>(m, 1, 32).col(0).iter().map(|w: &f64| w + 3.0).collect();
    for (w, centered) in [(None, false), (None, true), (Some(&weights[..]), true)] {
        let expected = both(exactly(a.as_ref(), w, centered, m));
        for height in [1, 7, 64, 1000] {
            let found = both(exactly(a.as_ref(), w, centered, height));
            assert_eq!(bits(found.as_ref()), bits(expected.as_ref()), "blocks of {height}");
        }
        // Killed after every block, gone on with in other blocks.
        let options = AtaOptions::new().reproducible(true);
        let mut kept = Vec::new();
        let mut keep = |sum: &Accumulator<f64>| {
            kept.push(bytes(sum));
            Ok(())
        };
        let mut sum = Accumulator::new(n, centered).unwrap();
        stream(&mut DenseRows(a.as_ref()), w, 50, &mut sum, &options, &mut keep).unwrap();
        assert_eq!(kept.len(), 7);
        for start in kept {
            let mut sum = Accumulator::read(&mut &start[..]).unwrap();
            add(&mut sum, a.as_ref(), w, 33).unwrap();
            assert_eq!(bits(both(sum).as_ref()), bits(expected.as_ref()));
        }
        // The same by `ata_rows`.
        let center = if centered { Center::Mean } else { Center::No };
        let rows = RowOptions::new().weights(w).center(center);
        let both = AtaOptions::new().reproducible(true).uplo(Uplo::Both);
        let mut c = Mat::from_fn(n, n, |_, _| f64::NAN);
        ata_rows(1.0, &mut DenseRows(a.as_ref()), &rows, 0.0, c.as_mut(), &both).unwrap();
        assert_eq!(bits(c.as_ref()), bits(expected.as_ref()));
        for strip in [0..10, 10..22, 22..23, 4..4] {
            let mut sum = Accumulator::of_strip(n, strip.clone(), centered).unwrap();
            stream(&mut DenseRows(a.as_ref()), w, 99, &mut sum, &options, &mut |_| Ok(())).unwrap();
            let c = sum.finish(1.0, Uplo::Lower).unwrap();
            for (i, row) in strip.enumerate() {
                for j in 0..=row {
                    assert_eq!(c.as_ref()[(i, j)].to_bits(), expected[(row, j)].to_bits());
                }
            }
        }
    }
}

#[test]
fn rows_about_a_given_centre_are_exact_in_any_order() {
    let (m, n) = (200, 6);
    let a = integers::<f64>(m, n, 33);
    let reversed = Mat::from_fn(m, n, |i, j| a[(m - 1 - i, j)]);
    let center: Vec<f64> = (0..n).map(|j| 0.5 * j as f64).collect();
    let run = |a: MatRef<'_, f64>| {
        let rows = RowOptions::new().center(Center::Given(&center));
        let options = AtaOptions::new().reproducible(true).uplo(Uplo::Both);
        let mut c = Mat::from_fn(n, n, |i, j| (i + j) as f64);
        ata_rows(2.0, &mut DenseRows(a), &rows, 3.0, c.as_mut(), &options).unwrap();
        c
    };
    let shifted = Mat::from_fn(m, n, |i, j| a[(i, j)] - center[j]);
    let start = Mat::from_fn(n, n, |i, j| (i + j) as f64);
    let expected = oracle(2.0, shifted.as_ref(), None, shifted.as_ref(), 3.0, start.as_ref());
    assert_eq!(run(a.as_ref()), expected);
    assert_eq!(run(reversed.as_ref()), expected);
}

#[test]
fn floating_point_sums_are_not_gone_on_with_exactly_nor_merged_with_exact_ones() {
    let a = integers::<f64>(10, 3, 34);
    let options = AtaOptions::new().reproducible(true);
    let mut sum = Accumulator::new(3, false).unwrap();
    sum.add_block(Mat::full(1, 3, 1.0), None, &AtaOptions::new()).unwrap();
    sum = Accumulator::read(&mut &bytes(&sum)[..]).unwrap();
    let error = sum.merge(exactly(a.as_ref(), None, false, 4)).unwrap_err().to_string();
    assert!(error.contains("floating-point and exact"), "{error}");
    let mut source = Source { fails_at: Some(8), ..Source::new(a.as_ref()) };
    let mut sum = Accumulator::new(3, false).unwrap();
    let result = stream(&mut source, None, 4, &mut sum, &AtaOptions::new(), &mut |_| Ok(()));
    assert_eq!(result.unwrap_err().to_string(), "a.h5: vanished");
    assert_eq!(sum.rows(), 8);
    let mut rows = DenseRows(a.as_ref());
    let error = stream(&mut rows, None, 4, &mut sum, &options, &mut |_| Ok(())).unwrap_err();
    assert!(matches!(error, Error::Argument { what: "accumulator", .. }), "{error}");
}

#[test]
fn declared_bounds_spare_the_first_pass() {
    let a = integers::<f64>(50, 4, 35);
    let bounds = RowBounds::new(vec![-100.0; 4], vec![100.0; 4], 50).unwrap();
    let options = AtaOptions::new().reproducible(true).par(Par::Seq);
    let mut sum = Accumulator::exact(&bounds, false).unwrap();
    let mut source = Source::new(a.as_ref());
    let read = source.read.clone();
    stream(&mut source, None, 10, &mut sum, &options, &mut |_| Ok(())).unwrap();
    assert_eq!(read.load(Ordering::SeqCst), 5);
    let zero = Mat::zeros(4, 4);
    assert_eq!(both(sum), oracle(1.0, a.as_ref(), None, a.as_ref(), 0.0, zero.as_ref()));
    // A row that breaks them ends the stream.
    let narrow = RowBounds::new(vec![-0.5; 4], vec![0.5; 4], 50).unwrap();
    let mut sum = Accumulator::exact(&narrow, false).unwrap();
    let mut rows = DenseRows(a.as_ref());
    let error = stream(&mut rows, None, 10, &mut sum, &options, &mut |_| Ok(())).unwrap_err();
    assert!(matches!(error, Error::Argument { what: "rows", .. }), "{error}");
}

#[test]
fn error_of_the_source_ends_the_stream_and_what_was_kept_goes_on() {
    let (m, n, height) = (300, 8, 32);
    let a = gaussian::<f64>(m, n, 15);
    let expected = bytes(&accumulated(a.as_ref(), None, true, height));
    for fails_at in [0, 32, 100, 299] {
        for par in [Par::Seq, Par::Threads(2)] {
            let mut source = Source { fails_at: Some(fails_at), ..Source::new(a.as_ref()) };
            let options = AtaOptions::new().par(par);
            let mut sum = Accumulator::new(n, true).unwrap();
            let mut kept = bytes(&sum);
            let mut keep = |sum: &Accumulator<f64>| {
                kept = bytes(sum);
                Ok(())
            };
            let error = stream(&mut source, None, height, &mut sum, &options, &mut keep);
            assert_eq!(error.unwrap_err().to_string(), "a.h5: vanished");
            let mut again = Accumulator::read(&mut &kept[..]).unwrap();
            assert_eq!(again.rows() as usize, fails_at / height * height);
            add(&mut again, a.as_ref(), None, height).unwrap();
            assert!(bytes(&again) == expected);
        }
    }
}

#[test]
fn error_after_a_block_ends_the_stream() {
    let a = integers::<f64>(100, 3, 16);
    let mut sum = Accumulator::new(3, false).unwrap();
    let mut blocks = 0;
    let mut stop = |_: &Accumulator<f64>| {
        blocks += 1;
        if blocks == 2 { Err(Error::Cancelled) } else { Ok(()) }
    };
    let options = AtaOptions::default();
    let result = stream(&mut DenseRows(a.as_ref()), None, 10, &mut sum, &options, &mut stop);
    assert_eq!((result, sum.rows(), blocks), (Err(Error::Cancelled), 20, 2));
}

#[test]
fn progress_rises_to_one_and_cancels() {
    let a = gaussian::<f64>(2000, 60, 17);
    let last = std::sync::Mutex::new(0.0);
    let told = |fraction: f64| {
        let mut last = last.lock().unwrap();
        *last = f64::max(*last, fraction);
        ControlFlow::Continue(())
    };
    let mut sum = Accumulator::<f64>::new(60, true).unwrap();
    let options = AtaOptions::new().progress(&told);
    stream(&mut DenseRows(a.as_ref()), None, 300, &mut sum, &options, &mut |_| Ok(())).unwrap();
    assert_eq!(*last.lock().unwrap(), 1.0);

    let cancel = |fraction: f64| {
        if fraction > 0.4 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let options = AtaOptions::new().progress(&cancel);
    let mut sum = Accumulator::<f64>::new(60, true).unwrap();
    let result = stream(&mut DenseRows(a.as_ref()), None, 300, &mut sum, &options, &mut |_| Ok(()));
    assert_eq!(result, Err(Error::Cancelled));
    assert!(sum.rows() < 2000);
}

#[test]
fn next_block_is_read_while_the_last_is_at_work_and_no_third() {
    let a = integers::<f64>(50, 4, 18);
    let source = Source::new(a.as_ref());
    let read = source.read.clone();
    let wait = |blocks: usize| {
        let start = Instant::now();
        while read.load(Ordering::SeqCst) < blocks && start.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(1));
        }
        // Time for a reader that goes too far.
        std::thread::sleep(Duration::from_millis(20));
        read.load(Ordering::SeqCst)
    };
    let mut blocks = 0;
    let mut sum = Accumulator::new(4, false).unwrap();
    let options = AtaOptions::new().threads(1);
    let mut source = source;
    let mut check = |_: &Accumulator<f64>| {
        blocks += 1;
        assert_eq!(wait((blocks + 1).min(5)), (blocks + 1).min(5));
        Ok(())
    };
    stream(&mut source, None, 10, &mut sum, &options, &mut check).unwrap();
    assert_eq!(blocks, 5);
}

#[test]
fn strips_are_the_rows_of_the_whole() {
    let (m, n) = (200, 37);
    let a = integers::<f64>(m, n, 19);
    let weights: Vec<f64> = integers::<f64>(m, 1, 20).col(0).iter().map(|w| w + 5.0).collect();
    for (w, centered) in [(None, false), (Some(&weights[..]), false), (Some(&weights[..]), true)] {
        let whole = both(accumulated(a.as_ref(), w, centered, 64));
        for strip in [0..37, 0..10, 10..36, 36..37, 5..5] {
            let mut sum = Accumulator::of_strip(n, strip.clone(), centered).unwrap();
            add(&mut sum, a.as_ref(), w, 64).unwrap();
            let c = copy(&sum).finish(1.0, Uplo::Both).unwrap();
            assert_eq!((c.rows(), c.as_ref().shape()), (strip.clone(), (strip.len(), strip.end)));
            for (i, row) in strip.enumerate() {
                for j in 0..=row {
                    let error = (c.as_ref()[(i, j)] - whole[(row, j)]).abs();
                    // A mean is no integer.
                    assert!(error <= if centered { 1e-11 } else { 0.0 }, "{row} {j}: {error:e}");
                }
            }
        }
    }
}

#[test]
fn strips_of_the_exact_path_have_the_bits_of_the_whole() {
    let (m, n) = (300, 50);
    let a = gaussian::<f64>(m, n, 21);
    let options = AtaOptions::new().scheme(SchemeChoice::Exact);
    let run = |strip: std::ops::Range<usize>| {
        let mut sum = Accumulator::<f64>::of_strip(n, strip, true).unwrap();
        stream(&mut DenseRows(a.as_ref()), None, 100, &mut sum, &options, &mut |_| Ok(())).unwrap();
        sum.finish(0.5, Uplo::Lower).unwrap()
    };
    let whole = run(0..n);
    for strip in [0..20, 20..49, 49..50] {
        let c = run(strip.clone());
        for (i, row) in strip.enumerate() {
            for j in 0..=row {
                let (found, expected) = (c.as_ref()[(i, j)], whole.as_ref()[(row, j)]);
                assert_eq!(found.to_bits(), expected.to_bits(), "{row} {j}");
            }
        }
    }
}

#[test]
fn plan_cuts_c_only_when_memory_asks_for_it_and_stays_within() {
    let options = AtaOptions::default();
    let (m, n) = (1_000_000, 20_000);
    let plan = |memory| StreamPlan::new::<f64>(m, n, false, None, memory, &options);
    let c = 8 * n * n;
    let whole = plan(usize::MAX).unwrap();
    assert_eq!((whole.reads(), whole.strips().first()), (1, Some(&(0..n))));
    assert!(whole.product().is_some() && whole.bytes() >= c);
    assert!(whole.to_string().contains("read once"), "{whole}");
    let mut reads = 1;
    for memory in [whole.bytes() - 1, c, c / 2, c / 3] {
        let plan = plan(memory).unwrap();
        assert!(plan.bytes() <= memory && plan.block_rows() == whole.block_rows());
        assert!(plan.reads() >= reads.max(2), "{memory}: {}", plan.reads());
        reads = plan.reads();
        assert!(plan.to_string().contains(&format!("read {reads} times")), "{plan}");
        let mut next = 0;
        for strip in plan.strips() {
            assert!(strip.start == next && strip.end > next);
            next = strip.end;
        }
        assert_eq!(next, n);
    }
    let error = plan(1 << 20).unwrap_err();
    assert!(matches!(error, Error::Argument { what: "memory", .. }), "{error}");
    for (m, n) in [(0, 0), (0, 5), (5, 0), (1, 1)] {
        let plan = StreamPlan::new::<f32>(m, n, true, Some(7), 1 << 30, &options).unwrap();
        assert_eq!(plan.reads(), 1, "{m} x {n}");
    }
}

#[test]
fn blocks_are_about_64_mib_of_whole_groups_of_rows() {
    for n in [0, 1, 100, 8192, 100_000] {
        for weighted in [false, true] {
            let rows = block_rows::<f64>(n, weighted);
            assert!(rows.is_multiple_of(64) && rows >= 640, "{n}: {rows}");
            let blocks = if weighted { 3 } else { 2 };
            let least = 3 * 1024 * 8 * n.max(1);
            assert!(blocks * 8 * rows * n <= (128 << 20).max(least), "{n}: {rows}");
        }
    }
}

/// A matrix that counts its reads, and may be slow or vanish.
struct Source<'a> {
    a: MatRef<'a, f64>,
    read: std::sync::Arc<AtomicUsize>,
    slow: bool,
    fails_at: Option<usize>,
    rng: Rng,
}

impl<'a> Source<'a> {
    fn new(a: MatRef<'a, f64>) -> Self {
        Self { a, read: Default::default(), slow: false, fails_at: None, rng: Rng::new(22) }
    }
}

impl RowBlocks<f64> for Source<'_> {
    fn nrows(&self) -> usize {
        self.a.nrows()
    }

    fn ncols(&self) -> usize {
        self.a.ncols()
    }

    fn read(&mut self, first: usize, out: MatMut<'_, f64>) -> Result<()> {
        if self.slow {
            std::thread::sleep(Duration::from_micros((self.rng.uniform() * 3000.0) as u64));
        }
        if self.fails_at.is_some_and(|row| (first..first + out.nrows()).contains(&row)) {
            return Err(Error::file("a.h5", "vanished"));
        }
        DenseRows(self.a).read(first, out)?;
        self.read.fetch_add(1, Ordering::SeqCst);
        Ok(())
    }
}

#[test]
fn alpha_zero_reads_no_rows() {
    let a = Mat::from_fn(10, 4, |i, j| if i == j { f64::INFINITY } else { f64::NAN });
    for center in [Center::No, Center::Mean] {
        for options in [AtaOptions::new(), AtaOptions::new().reproducible(true)] {
            let mut c = Mat::from_fn(4, 4, |i, j| (i + j) as f64);
            let row_options = RowOptions::new().center(center);
            let options = options.uplo(Uplo::Both);
            ata_rows(0.0, &mut DenseRows(a.as_ref()), &row_options, -1.0, c.as_mut(), &options)
                .unwrap();
            assert_eq!(c, Mat::from_fn(4, 4, |i, j| -((i + j) as f64)));
        }
    }
}
