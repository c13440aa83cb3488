use std::alloc::Layout;
use std::cell::Cell;
use std::sync::{Mutex, TryLockError};

use super::huge_pages::{HUGE_PAGE, ask_for_huge_pages};
use super::memory::check_allocation;
use super::plain::Plain;
use super::{Error, Real, Result};

/// An owned, zeroed, reusable block of `T`; a failed allocation is an error, not an abort.
///
/// Large blocks begin on a huge page, and the system is asked for such pages: without them, the
/// first access to fresh memory takes a visible part of the time of every call.
///
/// ```
/// use catamaran::base::Workspace;
///
/// let mut workspace = Workspace::<f64>::new(10)?;
/// assert_eq!(workspace.as_slice(), [0.0; 10]);
/// workspace.reserve(1000)?;
/// assert!(workspace.as_mut_slice().len() >= 1000);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct Workspace<T> {
    buffer: Vec<T>,
    /// Elements before the first huge page.
    skipped: usize,
}

impl<T: Real> Workspace<T> {
    /// Creates a workspace of `len` elements, all zero.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn new(len: usize) -> Result<Self> {
        let mut workspace = Self::empty();
        workspace.reserve(len)?;
        Ok(workspace)
    }

    const fn empty() -> Self {
        Self { buffer: Vec::new(), skipped: 0 }
    }

    /// Creates a workspace of these elements.
    pub(crate) fn from_vec(buffer: Vec<T>) -> Self {
        Self { buffer, skipped: 0 }
    }

    /// Grows the workspace to at least `len` elements; its contents are lost.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`]; the old block is freed in that case too.
    pub fn reserve(&mut self, len: usize) -> Result<()> {
        if self.buffer.len() - self.skipped >= len {
            return Ok(());
        }
        *self = Self::empty();
        let bytes = len.saturating_mul(size_of::<T>());
        check_allocation(bytes)?;
        let slack = if bytes < 2 * HUGE_PAGE { 0 } else { HUGE_PAGE / size_of::<T>() };
        self.buffer = zeroed(len.saturating_add(slack)).ok_or(Error::OutOfMemory { bytes })?;
        if slack > 0 {
            self.skipped = self.buffer.as_ptr().align_offset(HUGE_PAGE);
            ask_for_huge_pages(&mut self.buffer[self.skipped..]);
        }
        Ok(())
    }

    /// Returns all elements.
    pub fn as_slice(&self) -> &[T] {
        &self.buffer[self.skipped..]
    }

    /// Returns all elements for writing.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.buffer[self.skipped..]
    }
}

/// Returns an empty vector with room for `len` entries.
///
/// # Errors
/// [`Error::OutOfMemory`] when memory is refused.
pub fn reserved<T>(len: usize) -> Result<Vec<T>> {
    let mut values = Vec::new();
    let bytes = len.saturating_mul(size_of::<T>());
    check_allocation(bytes)?;
    values.try_reserve_exact(len).map_err(|_| Error::OutOfMemory { bytes })?;
    ask_for_huge_pages(values.spare_capacity_mut());
    Ok(values)
}

/// Makes room for `more` further items.
///
/// # Errors
/// [`Error::OutOfMemory`] when memory is refused.
pub fn room<T>(values: &mut Vec<T>, more: usize) -> Result<()> {
    if more <= values.capacity() - values.len() {
        return Ok(());
    }
    let bytes = values.len().saturating_add(more).saturating_mul(size_of::<T>());
    check_allocation(bytes)?;
    values.try_reserve(more).map_err(|_| Error::OutOfMemory { bytes })
}

/// Returns `len` copies of a value.
///
/// # Errors
/// [`Error::OutOfMemory`] when memory is refused.
pub fn repeated<T: Copy>(value: T, len: usize) -> Result<Vec<T>> {
    let mut values = reserved(len)?;
    values.resize(len, value);
    Ok(values)
}

/// Adds a value to a vector.
///
/// # Errors
/// [`Error::OutOfMemory`] when memory is refused.
pub fn push<T>(values: &mut Vec<T>, value: T) -> Result<()> {
    if values.len() == values.capacity() {
        let bytes = values.capacity().max(4).saturating_mul(2 * size_of::<T>());
        check_allocation(bytes)?;
        values.try_reserve(1).map_err(|_| Error::OutOfMemory { bytes })?;
    }
    values.push(value);
    Ok(())
}

/// Returns a vector of `len` zeros.
///
/// # Errors
/// [`Error::OutOfMemory`] when memory is refused.
pub fn zeros<T: Plain>(len: usize) -> Result<Vec<T>> {
    let bytes = len.saturating_mul(size_of::<T>());
    check_allocation(bytes)?;
    let mut values = zeroed(len).ok_or(Error::OutOfMemory { bytes })?;
    ask_for_huge_pages(&mut values);
    Ok(values)
}

/// Returns `len` zeros in memory that the system provides when it is touched.
fn zeroed<T: Plain>(len: usize) -> Option<Vec<T>> {
    if len == 0 {
        return Some(Vec::new());
    }
    let layout = Layout::array::<T>(len).ok()?;
    // SAFETY: the layout is not empty. It is that of a vector of `len` elements, zero bits are a T,
    // and the global allocator is that of vectors.
    unsafe {
        let pointer = std::alloc::alloc_zeroed(layout).cast::<T>();
        (!pointer.is_null()).then(|| Vec::from_raw_parts(pointer, len, len))
    }
}

/// Memory for the duration of a call, with unspecified contents.
///
/// Fresh pages from the system cost as much as the arithmetic on them, so large blocks are kept for
/// later calls, as in other BLAS libraries, until [`release_memory`]. Each thread keeps a small one
/// for itself, since even the allocator takes a visible part of the time of a small product.
#[derive(Default)]
pub struct Scratch(Workspace<f64>);

/// Blocks that later calls may use, in the order in which they were returned. No call waits for the
/// lock: in a process that is forked while another thread holds it, the wait would never end.
static SPARE: Mutex<Vec<Workspace<f64>>> = Mutex::new(Vec::new());

thread_local! {
    /// The small block of this thread.
    static OWN: Cell<Workspace<f64>> = const { Cell::new(Workspace::empty()) };
}

/// Most bytes of the small block of a thread: enough for products of 100 x 100 x 100 by integers.
const SMALL: usize = 256 << 10;

/// Bytes of a block that is kept: the allocator handles smaller ones, larger ones are too much. The
/// exact path takes up to 1.25 GiB for A^T B of 8192 x 8192 in f64.
const KEPT: std::ops::RangeInclusive<usize> = 4 << 20..=5 << 28;

impl Scratch {
    /// Creates a block of at least `len` elements of T.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] when memory is refused.
    pub fn new<T: Real>(len: usize) -> Result<Self> {
        let mut scratch = Self::default();
        scratch.reserve::<T>(len)?;
        Ok(scratch)
    }

    /// Grows the block to at least `len` elements of T; its contents are lost.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] when memory is refused.
    pub fn reserve<T: Real>(&mut self, len: usize) -> Result<()> {
        let len = len.saturating_mul(size_of::<T>()).div_ceil(size_of::<f64>());
        if self.0.as_slice().len() < len {
            self.give_back();
            self.0 = if len <= SMALL / size_of::<f64>() {
                // A thread that ends has none any more.
                OWN.try_with(Cell::take).unwrap_or_default()
            } else {
                spare(|blocks| take(blocks, len)).unwrap_or_default()
            };
            self.0.reserve(len)?;
        }
        Ok(())
    }

    /// Makes scratch of the memory of a vector.
    #[cfg(feature = "mpi")]
    pub(crate) fn from_vec(values: Vec<f64>) -> Self {
        Self(Workspace::from_vec(values))
    }

    /// Returns all elements.
    #[cfg(feature = "mpi")]
    pub(crate) fn as_slice<T: Real>(&self) -> &[T] {
        let block = self.0.as_slice();
        let len = size_of_val(block) / size_of::<T>();
        // SAFETY: as for `as_mut_slice`.
        unsafe { std::slice::from_raw_parts(block.as_ptr().cast(), len) }
    }

    /// Returns all elements for writing.
    pub fn as_mut_slice<T: Real>(&mut self) -> &mut [T] {
        let block = self.0.as_mut_slice();
        let len = size_of_val(block) / size_of::<T>();
        // SAFETY: f32 and f64 (`Real` is sealed) take any bits and ask for no more alignment than
        // f64.
        unsafe { std::slice::from_raw_parts_mut(block.as_mut_ptr().cast(), len) }
    }

    fn give_back(&mut self) {
        let own = std::mem::take(&mut self.0);
        let bytes = size_of_val(own.buffer.as_slice());
        if (1..=SMALL).contains(&bytes) {
            let _ = OWN.try_with(|kept| kept.set(own));
        } else if KEPT.contains(&bytes) {
            let dropped = spare(|blocks| {
                blocks.push(own);
                surplus(blocks)
            });
            // Outside of the lock, because freeing large blocks takes time.
            drop(dropped);
        }
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        self.give_back();
    }
}

/// Takes the smallest block of at least `len` elements, or else the largest one, which then grows:
/// there are never more blocks than were in use at the same time.
fn take(blocks: &mut Vec<Workspace<f64>>, len: usize) -> Option<Workspace<f64>> {
    let len_of = |i: &usize| blocks[*i].as_slice().len();
    let fitting = (0..blocks.len()).filter(|i| len_of(i) >= len).min_by_key(len_of);
    fitting.or_else(|| (0..blocks.len()).max_by_key(len_of)).map(|i| blocks.remove(i))
}

/// Removes the oldest blocks, so that the others have no more bytes than [`KEPT`] allows.
fn surplus(blocks: &mut Vec<Workspace<f64>>) -> Vec<Workspace<f64>> {
    let mut bytes = 0;
    let fit = |block: &&Workspace<f64>| {
        bytes += size_of_val(block.buffer.as_slice());
        bytes <= *KEPT.end()
    };
    let staying = blocks.iter().rev().take_while(fit).count();
    blocks.drain(..blocks.len() - staying).collect()
}

fn spare<R>(work: impl FnOnce(&mut Vec<Workspace<f64>>) -> R) -> R {
    match SPARE.try_lock() {
        Ok(mut spare) => work(&mut spare),
        Err(TryLockError::Poisoned(spare)) => work(&mut spare.into_inner()),
        Err(TryLockError::WouldBlock) => work(&mut Vec::new()),
    }
}

/// Frees the memory that products keep for later products: at most 1.25 GiB, and at most 256 KiB
/// for each thread. Of the latter only that of the calling thread is freed; the others end with
/// their threads.
///
/// ```
/// use catamaran::{AtaOptions, ata_into, base::release_memory, faer::Mat};
///
/// let (a, mut c) = (Mat::<f64>::ones(300, 300), Mat::zeros(300, 300));
/// ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &AtaOptions::new())?;
/// release_memory(); // as after the last of many products
/// assert_eq!(c[(1, 0)], 300.0);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn release_memory() {
    drop(spare(std::mem::take));
    let _ = OWN.try_with(Cell::take);
}

/// A bump allocator over a borrowed block: [`Arena::take`] hands out pieces until it is empty,
/// and a nested scope ([`Arena::nested`]) gives its pieces back when it ends.
///
/// ```
/// use catamaran::base::Arena;
///
/// let mut block = [0.0_f64; 10];
/// let mut arena = Arena::new(&mut block);
/// let first = arena.take(4);
/// arena.nested().take(6).fill(1.0); // these six return to `arena`
/// let second = arena.take(6);
/// assert_eq!((first.len(), second[5]), (4, 1.0));
/// ```
#[derive(Debug)]
pub struct Arena<'a, T> {
    rest: &'a mut [T],
}

impl<'a, T: Real> Arena<'a, T> {
    /// Creates an arena over `block`, which may have any contents.
    pub fn new(block: &'a mut [T]) -> Self {
        Self { rest: block }
    }

    /// Takes the next `len` elements, whose contents are unspecified.
    ///
    /// # Panics
    /// When fewer are left: the scratch query and the code disagree, which is a bug in this crate.
    pub fn take(&mut self, len: usize) -> &'a mut [T] {
        let rest = std::mem::take(&mut self.rest);
        assert!(len <= rest.len(), "scratch query too small: {len} wanted, {} left", rest.len());
        let (piece, rest) = rest.split_at_mut(len);
        self.rest = rest;
        piece
    }

    /// Takes the next `len` elements of another type, starting on a cache line of their own.
    ///
    /// # Panics
    /// As [`Arena::take`]; this needs [`Arena::len_of`] elements.
    pub(crate) fn take_as<U: Plain>(&mut self, len: usize) -> &'a mut [U] {
        let piece = self.take(Self::len_of::<U>(len));
        let skipped = piece.as_ptr().cast::<u8>().align_offset(CACHE_LINE);
        // SAFETY: `len_of` counts the bytes of `len` elements and of the padding before the next
        // cache line, which suits the alignment of U; any bits are a U, and a T when the borrow
        // ends.
        unsafe {
            let start = piece.as_mut_ptr().cast::<u8>().add(skipped);
            std::slice::from_raw_parts_mut(start.cast(), len)
        }
    }

    /// Returns the number of elements that [`Arena::take_as`] takes.
    pub(crate) fn len_of<U: Plain>(len: usize) -> usize {
        const { assert!(align_of::<U>() <= CACHE_LINE) };
        (len.saturating_mul(size_of::<U>()).saturating_add(CACHE_LINE)).div_ceil(size_of::<T>())
    }

    /// Creates an arena over the rest. When it is dropped, its pieces return to this arena.
    pub fn nested(&mut self) -> Arena<'_, T> {
        Arena { rest: &mut *self.rest }
    }
}

const CACHE_LINE: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arena_gives_pieces_of_other_types_cache_lines_of_their_own() {
        let sizes = [1, 3, 16];
        let len = sizes.iter().map(|&n| Arena::<f32>::len_of::<[i32; 3]>(n)).sum();
        let mut memory = Workspace::<f32>::new(len).unwrap();
        let mut arena = Arena::new(memory.as_mut_slice());
        let pieces = sizes.map(|n| arena.take_as::<[i32; 3]>(n));
        for (i, piece) in pieces.into_iter().enumerate() {
            assert_eq!((piece.len(), piece.as_ptr().align_offset(CACHE_LINE)), (sizes[i], 0));
            piece.fill([i as i32; 3]);
        }
        assert!(arena.rest.is_empty());
    }

    /// Returns the number of pages of `memory` that have been touched.
    #[cfg(target_os = "linux")]
    fn touched(memory: &[f64]) -> usize {
        // SAFETY: `sysconf` takes no pointer, and any name is allowed.
        let page = unsafe { libc::sysconf(libc::_SC_PAGESIZE) } as usize;
        let mut pages = vec![0_u8; size_of_val(memory).div_ceil(page)];
        // SAFETY: mapped memory from a page's beginning on, and a byte for each of its pages.
        let status = unsafe {
            libc::mincore(
                memory.as_ptr().cast_mut().cast(),
                size_of_val(memory),
                pages.as_mut_ptr(),
            )
        };
        assert_eq!(status, 0);
        pages.iter().filter(|&page| page & 1 == 1).count()
    }

    #[cfg(all(target_os = "linux", not(miri)))]
    #[test]
    fn pages_of_a_large_workspace_are_left_for_its_user_to_touch_first() {
        let mut memory = Workspace::<f64>::new(8 << 20).unwrap();
        let memory = memory.as_mut_slice();
        assert_eq!(touched(memory), 0);
        memory[memory.len() / 2] = 1.0;
        let touched = touched(memory);
        assert!((1..=HUGE_PAGE >> 12).contains(&touched), "{touched}");
    }

    #[test]
    fn the_smallest_block_that_fits_is_taken_or_the_largest_and_the_oldest_go_first() {
        let block = |len: usize| Workspace::<f64>::new(len).unwrap();
        let lens = |blocks: &[Workspace<f64>]| -> Vec<usize> {
            blocks.iter().map(|block| block.as_slice().len()).collect()
        };
        let mut blocks = [300, 100, 200].map(block).into();
        assert_eq!(take(&mut blocks, 150).map(|block| block.as_slice().len()), Some(200));
        assert_eq!(lens(&blocks), [300, 100]);
        assert_eq!(take(&mut blocks, 301).map(|block| block.as_slice().len()), Some(300));
        assert_eq!(take(&mut blocks, 1).map(|block| block.as_slice().len()), Some(100));
        assert!(take(&mut blocks, 1).is_none());
        blocks.extend([300, 100].map(block));
        assert!(surplus(&mut blocks).is_empty());
        // The test does not touch these pages.
        let large = KEPT.end() / size_of::<f64>() / 2;
        blocks.push(block(large));
        blocks.push(block(large - 1000));
        assert_eq!(lens(&surplus(&mut blocks)).len(), 3);
        assert_eq!(blocks.len(), 1);
    }

    #[test]
    fn scratch_serves_both_scalars() {
        let mut scratch = Scratch::new::<f32>(7).unwrap();
        assert!(scratch.as_mut_slice::<f32>().len() >= 7);
        scratch.as_mut_slice::<f32>().fill(1.0);
        scratch.reserve::<f64>(100).unwrap();
        assert!(scratch.as_mut_slice::<f64>().len() >= 100);
    }
}
