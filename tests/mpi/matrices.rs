//! Matrices of small integers, whose products are exact in any order, and what they should give.

use catamaran::faer::prelude::Reborrow;
use catamaran::faer::{Mat, MatRef};
use catamaran::ranks::{MpiReal, Symmetric, World};
use catamaran::{AtaOptions, Error, Par, Real, Uplo};

/// Rows and columns that every mode runs through.
pub const SHAPES: [(usize, usize); 8] =
    [(0, 3), (5, 0), (1, 1), (3, 7), (64, 16), (127, 31), (40, 130), (257, 64)];

/// Entry (i, j) of a matrix: -3 to 3.
pub fn entry<T: Real>(i: usize, j: usize) -> T {
    T::from_f64(((i * 31 + j * 17 + i * j) % 7) as f64 - 3.0)
}

/// Rows and columns of the matrix.
pub fn part<T: Real>(rows: std::ops::Range<usize>, cols: std::ops::Range<usize>) -> Mat<T> {
    Mat::from_fn(rows.len(), cols.len(), |i, j| entry(rows.start + i, cols.start + j))
}

/// The entry (i, j) of `alpha A^T A`.
pub fn expected(alpha: f64, m: usize, i: usize, j: usize) -> f64 {
    alpha * (0..m).map(|k| entry::<f64>(k, i) * entry::<f64>(k, j)).sum::<f64>()
}

/// The `rank`-th of `ranks` uneven parts of `0..len`, some of them empty.
pub fn uneven(len: usize, ranks: usize, rank: usize) -> std::ops::Range<usize> {
    let bound = |r: usize| match r {
        0 => 0,
        r if r == ranks => len,
        // Square: the first ranks have little.
        r => len * r * r / (ranks * ranks),
    };
    bound(rank)..bound(rank + 1)
}

/// Prints an error after the rank that got it.
pub fn tell(world: &World, error: Error) {
    println!("{}: {error}", world.rank());
}

/// One thread per rank, native kernels.
pub fn options() -> AtaOptions<'static> {
    AtaOptions::new().par(Par::Seq)
}

/// Checks a distributed result: on each rank, and gathered on the last one.
pub fn check<T: MpiReal>(world: &World, c: &Symmetric<T>, alpha: f64, m: usize) {
    c.for_each_segment(|i, first, entries| {
        for (j, value) in (first..).zip(entries) {
            assert_eq!(value.to_f64(), expected(alpha, m, i, j), "entry ({i}, {j}), m = {m}");
        }
    });
    let n = c.n();
    let root = world.size() - 1;
    for uplo in [Uplo::Lower, Uplo::Upper, Uplo::Both] {
        let mut whole = Mat::<T>::from_fn(n, n, |_, _| T::from_f64(-77.0));
        let destination = (world.rank() == root).then(|| whole.as_mut());
        c.gather(world, root, destination, uplo).unwrap();
        if world.rank() == root {
            check_whole(whole.rb(), alpha, m, uplo);
        }
    }
}

/// Checks C; the triangle that was not asked for holds -77 still.
pub fn check_whole<T: Real>(c: MatRef<'_, T>, alpha: f64, m: usize, uplo: Uplo) {
    for j in 0..c.ncols() {
        for i in 0..c.nrows() {
            let wanted = match uplo {
                Uplo::Lower => i >= j,
                Uplo::Upper => i <= j,
                Uplo::Both => true,
            };
            let value = if wanted { expected(alpha, m, i, j) } else { -77.0 };
            assert_eq!(c[(i, j)].to_f64(), value, "entry ({i}, {j}), m = {m}");
        }
    }
}
