use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use super::Par;

/// Work on ranges of fixed size, so that the number of threads decides nothing but who does it.
impl Par {
    /// What `work` returns for `0..size`, `size..2 size`, ... below `n`, in this order.
    pub(crate) fn map_blocks<T: Send + Sync>(
        self,
        n: usize,
        size: usize,
        work: impl Fn(Range<usize>) -> T + Sync,
    ) -> Vec<T> {
        let blocks = n.div_ceil(size);
        let results: Vec<OnceLock<T>> = (0..blocks).map(|_| OnceLock::new()).collect();
        self.share(blocks, |block| {
            let range = block * size..n.min((block + 1) * size);
            results[block].get_or_init(|| work(range));
        });
        results.into_iter().filter_map(OnceLock::into_inner).collect()
    }

    /// `work(start, chunk)` for the chunks of `size` entries that `data` falls into.
    pub(crate) fn for_chunks<T: Send>(
        self,
        data: &mut [T],
        size: usize,
        work: impl Fn(usize, &mut [T]) + Sync,
    ) {
        let chunks: Vec<Mutex<&mut [T]>> = data.chunks_mut(size).map(Mutex::new).collect();
        self.share(chunks.len(), |i| {
            let mut chunk = chunks[i].lock().unwrap_or_else(PoisonError::into_inner);
            work(i * size, &mut chunk);
        });
    }

    /// `work(0), ..., work(n - 1)`, each by the first thread that is free.
    fn share(self, n: usize, work: impl Fn(usize) + Sync) {
        let next = AtomicUsize::new(0);
        Self::Threads(self.threads().min(n)).run_lanes(|_| {
            loop {
                let i = next.fetch_add(1, Ordering::Relaxed);
                if i >= n {
                    break;
                }
                work(i);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_come_back_in_order_and_cover_everything() {
        for n in [0, 1, 7, 8, 23] {
            for threads in 1..4 {
                let ranges = Par::Threads(threads).map_blocks(n, 4, |r| r);
                let all: Vec<usize> = ranges.into_iter().flatten().collect();
                assert_eq!(all, (0..n).collect::<Vec<_>>());
                let mut data = vec![0; n];
                Par::Threads(threads).for_chunks(&mut data, 4, |start, chunk| {
                    for (i, x) in chunk.iter_mut().enumerate() {
                        *x = start + i;
                    }
                });
                assert_eq!(data, all);
            }
        }
    }
}
