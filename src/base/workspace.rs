use super::{Error, Real, Result};

/// An owned, zeroed, reusable block of `T`; a failed allocation is an error, not an abort.
#[derive(Debug, Default)]
pub struct Workspace<T> {
    buffer: Vec<T>,
}

impl<T: Real> Workspace<T> {
    /// A workspace of `len` elements.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn new(len: usize) -> Result<Self> {
        let mut workspace = Self { buffer: Vec::new() };
        workspace.reserve(len)?;
        Ok(workspace)
    }

    /// Grows to at least `len` elements; what it held is lost.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`]; the old block is then gone.
    pub fn reserve(&mut self, len: usize) -> Result<()> {
        if self.buffer.len() < len {
            self.buffer = Vec::new();
            let out_of_memory =
                |_| Error::OutOfMemory { bytes: len.saturating_mul(size_of::<T>()) };
            self.buffer.try_reserve_exact(len).map_err(out_of_memory)?;
            self.buffer.resize(len, T::ZERO);
        }
        Ok(())
    }

    /// All of it.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.buffer
    }
}

/// A bump allocator over a borrowed block: [`Arena::take`] hands out pieces until it is empty,
/// and a nested scope ([`Arena::nested`]) gives its pieces back when it ends.
#[derive(Debug)]
pub struct Arena<'a, T> {
    rest: &'a mut [T],
}

impl<'a, T: Real> Arena<'a, T> {
    /// An arena over `block`; its contents may be anything.
    pub fn new(block: &'a mut [T]) -> Self {
        Self { rest: block }
    }

    /// The next `len` elements, with whatever they hold.
    ///
    /// # Panics
    /// When fewer are left: the scratch query and the code disagree, which is a bug here.
    pub fn take(&mut self, len: usize) -> &'a mut [T] {
        let rest = std::mem::take(&mut self.rest);
        assert!(len <= rest.len(), "scratch query too small: {len} wanted, {} left", rest.len());
        let (piece, rest) = rest.split_at_mut(len);
        self.rest = rest;
        piece
    }

    /// An arena over what is left; dropping it gives everything back.
    pub fn nested(&mut self) -> Arena<'_, T> {
        Arena { rest: &mut *self.rest }
    }
}
