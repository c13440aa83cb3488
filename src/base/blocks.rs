use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

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
        let next = AtomicUsize::new(0);
        Self::Threads(self.threads().min(blocks)).run_lanes(|_| {
            loop {
                let block = next.fetch_add(1, Ordering::Relaxed);
                if block >= blocks {
                    break;
                }
                let range = block * size..n.min((block + 1) * size);
                results[block].get_or_init(|| work(range));
            }
        });
        results.into_iter().filter_map(OnceLock::into_inner).collect()
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
            }
        }
    }
}
