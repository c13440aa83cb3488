use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::base::Par;

/// Calls `work(i, item)` for every item, on the threads of `par`.
pub(super) fn for_each<T: Send>(
    par: Par,
    items: impl Iterator<Item = T>,
    work: impl Fn(usize, T) + Sync,
) {
    if par.threads() == 1 {
        items.enumerate().for_each(|(i, item)| work(i, item));
        return;
    }
    let items: Vec<_> = items.map(|item| Mutex::new(Some(item))).collect();
    let next = AtomicUsize::new(0);
    Par::Threads(par.threads().min(items.len())).run_lanes(|_| {
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(i) else { return };
            if let Some(item) = item.lock().ok().and_then(|mut item| item.take()) {
                work(i, item);
            }
        }
    });
}
