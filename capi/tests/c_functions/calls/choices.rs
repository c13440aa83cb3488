//! Bytes as choices: those of a fuzzer, or of a seed.

use catamaran::base::Rng;

/// Choices, and zeros after the last byte; a zero is always the plain choice.
pub struct Choices<'a> {
    bytes: &'a [u8],
}

impl<'a> Choices<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.bytes.split_first() else { return 0 };
        self.bytes = rest;
        first
    }

    /// Returns a number below `count`, which is at most 256.
    pub fn below(&mut self, count: usize) -> usize {
        self.byte() as usize % count
    }

    pub fn pick<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }

    /// Returns whether a choice is made that is made once in so many times.
    pub fn one_in(&mut self, count: usize) -> bool {
        self.below(count) == count - 1
    }

    /// Returns a side of a matrix: 0 to 70.
    pub fn side(&mut self) -> usize {
        self.below(71)
    }

    /// Returns random numbers for the entries of matrices.
    pub fn rng(&mut self) -> Rng {
        let seed = u64::from(self.byte()) << 8 | u64::from(self.byte());
        Rng::new(seed)
    }
}
