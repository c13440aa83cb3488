//! Memory that several threads write, each its own part.

use std::marker::PhantomData;
use std::ops::Range;

/// The part of `0..total` that belongs to one of `count` lanes.
pub(super) fn split(total: usize, count: usize, lane: usize) -> Range<usize> {
    total * lane / count..total * (lane + 1) / count
}

/// A slice whose elements are reached from several threads.
pub(super) struct Shared<'a, T> {
    start: *mut T,
    len: usize,
    _borrow: PhantomData<&'a mut [T]>,
}

// SAFETY: `get` is unsafe and asks its callers for disjointness, which is all that sharing needs.
unsafe impl<T: Send> Sync for Shared<'_, T> {}

impl<'a, T> Shared<'a, T> {
    pub fn new(slice: &'a mut [T]) -> Self {
        Self { start: slice.as_mut_ptr(), len: slice.len(), _borrow: PhantomData }
    }

    /// Element `i`.
    ///
    /// # Safety
    /// No other reference to it is alive, but for those of [`Shared::read`] while nobody writes.
    #[allow(clippy::mut_from_ref)]
    pub unsafe fn get(&self, i: usize) -> &mut T {
        assert!(i < self.len, "element {i} of {}", self.len);
        // SAFETY: inside the slice; the caller sees to the rest.
        unsafe { &mut *self.start.add(i) }
    }

    /// Element `i`, to read.
    ///
    /// # Safety
    /// Nobody writes it meanwhile.
    pub unsafe fn read(&self, i: usize) -> &T {
        assert!(i < self.len, "element {i} of {}", self.len);
        // SAFETY: inside the slice; the caller sees to the rest.
        unsafe { &*self.start.add(i) }
    }
}
