//! What every rank reads for itself must be the same on all ranks.

use faer::MatMut;

use super::world::{Fact, Operation, World, fact, hash_fact};
use crate::base::{Result, zeros};
use crate::rows::RowBlocks;

/// Blocks of rows in a fingerprint, those of the first and of the last rows among them.
const BLOCKS: usize = 16;

/// Most entries of such a block, unless a row has more.
const ENTRIES: usize = 1 << 13;

/// Most entries of a row that is read: 512 MiB. Longer ones have no product that fits into any
/// machine (8 n^2 bytes), as the caller says when it plans; a single row of them may take all of a
/// node's memory, once for each rank.
const LONGEST: usize = 1 << 26;

/// Checks that all ranks have the same `rows`, of which each rank will take a part: for files that
/// every rank opens for itself, and that may be incomplete or old copies on some machines. Numbers
/// of rows and columns are compared, the numbers in `others` (at most six, such as the size of a
/// file in bytes, each with a name that fits into a sentence), and a fingerprint of 16 blocks of
/// rows, unless these have more than 2^26 columns.
///
/// ```no_run
/// use catamaran::faer::mat;
/// use catamaran::ranks::{World, agree_rows};
/// use catamaran::rows::DenseRows;
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// let a = mat![[1.0, 2.0], [3.0, 4.0]];
/// agree_rows(&world, &mut DenseRows(a.as_ref()), &[("the size of the file", 160)])?;
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Rank`](crate::Error::Rank) that names the first rank with something else than rank 0,
/// and both values, or another rank that failed; else those of the rows.
pub fn agree_rows(
    world: &World,
    rows: &mut (dyn RowBlocks<f64> + Send),
    others: &[(&'static str, usize)],
) -> Result<()> {
    let _guard = world.abort_on_panic();
    let shape = [("the number of rows", rows.nrows()), ("the number of columns", rows.ncols())];
    let facts: Vec<Fact> =
        shape.iter().chain(others).map(|&(what, number)| fact(what, number)).collect();
    world.begin(Operation::SameShape, &facts, Ok(()))?;
    let found = fingerprint(rows);
    let hash = found.as_ref().copied().unwrap_or_default();
    let facts = [hash_fact("the fingerprint of sampled rows", hash)];
    world.begin(Operation::SameRows, &facts, found.map(drop))
}

/// Checks that all ranks have the same numbers, at most eight, each with a name that fits into a
/// sentence.
///
/// # Errors
/// [`Error::Rank`](crate::Error::Rank), as [`agree_rows`].
#[doc(hidden)]
pub fn agree_numbers(world: &World, numbers: &[(&'static str, usize)]) -> Result<()> {
    let _guard = world.abort_on_panic();
    let facts: Vec<Fact> = numbers.iter().map(|&(what, number)| fact(what, number)).collect();
    world.begin(Operation::SameNumbers, &facts, Ok(()))
}

/// Returns a number that distinguishes rows of one shape: FNV-1a of the bits of sampled blocks.
/// Rows longer than [`LONGEST`] are not read.
fn fingerprint(rows: &mut (dyn RowBlocks<f64> + Send)) -> Result<u64> {
    let (m, n) = (rows.nrows(), rows.ncols());
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    if m == 0 || n == 0 || n > LONGEST {
        return Ok(hash);
    }
    let height = (ENTRIES / n).clamp(1, m);
    let mut entries = zeros::<f64>(height * n)?;
    for block in 0..BLOCKS {
        let first = (m - height) as u128 * block as u128 / (BLOCKS - 1) as u128;
        let out = MatMut::from_row_major_slice_mut(&mut entries, height, n);
        rows.read(first as usize, out)?;
        for x in &entries {
            // The bits of a NaN that was converted depend on the machine.
            let bits = if x.is_nan() { u64::MAX } else { x.to_bits() };
            for byte in bits.to_le_bytes() {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
    }
    Ok(hash)
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::rows::DenseRows;

    fn of(a: &Mat<f64>) -> u64 {
        fingerprint(&mut DenseRows(a.as_ref())).unwrap()
    }

    #[test]
    fn a_fingerprint_sees_every_entry_of_small_rows_and_the_ends_of_long_ones() {
        let small = Mat::from_fn(9, 4, |i, j| (i * 4 + j) as f64);
        for (i, j) in [(0, 0), (4, 2), (8, 3)] {
            let mut other = small.clone();
            other[(i, j)] += 0.5;
            assert_ne!(of(&other), of(&small), "{i}, {j}");
        }
        let long = Mat::from_fn(20_000, 100, |i, j| ((i * 31 + j) % 101) as f64);
        assert_eq!(of(&long), of(&long.clone()));
        for row in [0, 19_999] {
            let mut other = long.clone();
            other[(row, 99)] = f64::NAN;
            assert_ne!(of(&other), of(&long), "row {row}");
            // All that are not numbers are alike.
            let mut another = long.clone();
            another[(row, 99)] = -f64::NAN;
            assert_eq!(of(&other), of(&another));
        }
        assert_eq!(of(&Mat::zeros(0, 3)), of(&Mat::zeros(3, 0)));
    }

    /// Rows of so many columns that none can be read.
    struct Endless;

    impl RowBlocks<f64> for Endless {
        fn nrows(&self) -> usize {
            10
        }

        fn ncols(&self) -> usize {
            2_000_000_000
        }

        fn read(&mut self, _: usize, _: MatMut<'_, f64>) -> Result<()> {
            unreachable!("a row takes 15 GiB")
        }
    }

    #[test]
    fn rows_too_long_for_any_product_are_not_read() {
        assert!(fingerprint(&mut Endless).is_ok());
    }
}
