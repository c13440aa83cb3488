//! The race of many small A^T A at once: matrices of one shape, row-major, one after the other.

use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

use catamaran::AtaOptions;
use catamaran::base::ThreadPool;
use catamaran::product::ata_batched_into;
use faer::{MatMut, MatRef};

use crate::Result;
use crate::contender::{LOWER, NO_TRANS, ROW_MAJOR, Scalar, TRANS};
use crate::input::Shape;
use crate::library::Rival;
use crate::product::Product;
use crate::race::{Outcome, PAUSE, Rules, SAMPLE_SECONDS, calls_within};
use crate::reference::Reference;

/// One way to compute all of them.
#[derive(Clone)]
pub enum Contender {
    /// `gemm_batch_strided` of a library, which also computes the upper triangles.
    GemmBatch(Arc<Rival>),
    /// A call of a library's `syrk` for each.
    Loop(Arc<Rival>),
    /// `catamaran::ata_batched_into`.
    Ours,
}

impl fmt::Display for Contender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::GemmBatch(rival) => write!(f, "{} gemm_batch", rival.name),
            Self::Loop(rival) => write!(f, "{} syrk", rival.name),
            Self::Ours => f.write_str("cata:batched"),
        }
    }
}

impl Contender {
    /// Computes the products of all matrices of A into C `calls` times; returns the time.
    ///
    /// # Errors
    /// Those of `ata_batched_into`, and numbers beyond the library's 32 bits.
    fn run<T: Scalar>(
        &self,
        shape: Shape,
        a: &[T],
        c: &mut [T],
        calls: usize,
        threads: usize,
        team: &ThreadPool,
    ) -> Result<Duration> {
        let Shape { m, n } = shape;
        let count = a.len() / (m * n);
        let [rows, cols, matrices] = [m, n, count].map(i32::try_from);
        let (rows, cols, matrices) = (rows?, cols?, matrices?);
        let [a_len, c_len] = [i32::try_from(m * n)?, i32::try_from(n * n)?];
        let start;
        match self {
            Self::GemmBatch(rival) => {
                rival.set_threads(threads);
                let gemm = T::gemm_batch(rival)
                    .ok_or_else(|| format!("{}: no gemm_batch_strided", rival.name))?;
                start = Instant::now();
                for _ in 0..calls {
                    let (a, c) = (a.as_ptr(), c.as_mut_ptr());
                    // SAFETY: `count` row-major matrices of m x n at a distance of m n scalars
                    // follow each other in A, and of n x n in C; C overlaps no A.
                    unsafe {
                        gemm(
                            ROW_MAJOR,
                            TRANS,
                            NO_TRANS,
                            cols,
                            cols,
                            rows,
                            T::ONE,
                            a,
                            cols,
                            a_len,
                            a,
                            cols,
                            a_len,
                            T::ZERO,
                            c,
                            cols,
                            c_len,
                            matrices,
                        );
                    }
                }
            }
            Self::Loop(rival) => {
                rival.set_threads(threads);
                let syrk = T::syrk(rival);
                start = Instant::now();
                for _ in 0..calls {
                    for (a, c) in a.chunks(m * n).zip(c.chunks_mut(n * n)) {
                        let (a, c) = (a.as_ptr(), c.as_mut_ptr());
                        // SAFETY: A is row-major m x n, C row-major n x n.
                        unsafe {
                            syrk(
                                ROW_MAJOR,
                                LOWER,
                                TRANS,
                                cols,
                                rows,
                                T::ONE,
                                a,
                                cols,
                                T::ZERO,
                                c,
                                cols,
                            );
                        }
                    }
                }
            }
            Self::Ours => {
                let options = AtaOptions::new().threads(threads);
                start = Instant::now();
                // A caller of the rivals has pointers; the views that ours takes are counted.
                team.run(|| -> catamaran::Result<()> {
                    for _ in 0..calls {
                        let left: Vec<_> = a
                            .chunks(m * n)
                            .map(|a| MatRef::from_row_major_slice(a, m, n))
                            .collect();
                        let mut products: Vec<_> = c
                            .chunks_mut(n * n)
                            .map(|c| MatMut::from_row_major_slice_mut(c, n, n))
                            .collect();
                        ata_batched_into(T::ONE, &left, T::ZERO, &mut products, &options)?;
                    }
                    Ok(())
                })?;
            }
        }
        Ok(start.elapsed())
    }
}

/// Runs the race; each outcome has the seconds of one product. The first, the middle and the last
/// product of each sample are checked. Near the deadline, it returns fewer repetitions, or none.
///
/// # Errors
/// A wrong result ends the race.
pub fn race<T: Scalar>(
    contenders: &[Contender],
    shape: Shape,
    a: &[T],
    threads: usize,
    team: &ThreadPool,
    rules: &Rules,
) -> Result<Vec<Outcome>> {
    let Shape { m, n } = shape;
    let count = a.len() / (m * n);
    let references = [0, count / 2, count - 1].map(|i| {
        let product = Product::syrk(shape, &a[i * m * n..(i + 1) * m * n]);
        (i, Reference::new(&product, n * n, 1))
    });
    let mut c = vec![T::ONE; count * n * n];
    let mut outcomes: Vec<_> = contenders
        .iter()
        .map(|contender| Outcome {
            contender: contender.to_string(),
            is_rival: !matches!(contender, Contender::Ours),
            seconds: vec![],
            error: 0.0,
        })
        .collect();
    let mut calls = vec![];
    for contender in contenders {
        // The first call includes the creation of threads and buffers.
        contender.run(shape, a, &mut c, 1, threads, team)?;
        let one = contender.run(shape, a, &mut c, 1, threads, team)?.as_secs_f64();
        calls.push(calls_within(SAMPLE_SECONDS, one));
    }
    for round in 0..rules.repeat {
        if rules.time_is_up() {
            break;
        }
        for turn in 0..contenders.len() {
            let i = (round + turn) % contenders.len();
            for (at, reference) in &references {
                reference.poison(&mut c[at * n * n..(at + 1) * n * n]);
            }
            std::thread::sleep(PAUSE);
            let time = contenders[i].run(shape, a, &mut c, calls[i], threads, team)?;
            outcomes[i].seconds.push(time.as_secs_f64() / (calls[i] * count) as f64);
            for (at, reference) in &references {
                let error = reference
                    .check(&c[at * n * n..(at + 1) * n * n])
                    .map_err(|e| format!("{}, {shape}, matrix {at}: {e}", contenders[i]))?;
                outcomes[i].error = outcomes[i].error.max(error);
            }
        }
    }
    Ok(outcomes)
}
