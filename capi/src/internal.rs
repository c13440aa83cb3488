use std::ops::ControlFlow;

use super::boundary::boundary;
use super::status::cata_status;
use catamaran::base::{Latch, Pin, ThreadPool, tickets};

/// Panics, for the tests of this ABI only, inside the library, on the calling thread if `worker` is
/// 0 and else on a thread of its own, to show that no panic reaches the caller.
///
/// Returns CATA_ERR_PANIC. Not in libraries that are installed, nor in their header:
/// tests/c/internal.h.
#[unsafe(no_mangle)]
pub extern "C" fn cata_internal_panic(worker: i32) -> cata_status {
    boundary(|| {
        if worker == 0 {
            panic!("forced by cata_internal_panic");
        }
        on_a_worker(|| panic!("forced by cata_internal_panic, on a worker"));
        Ok(())
    })
}

/// Calls `work` on a thread that is not the caller's.
pub(super) fn on_a_worker(work: impl Fn() + Sync) {
    // Two tickets that wait for each other run on two threads.
    let both = Latch::new(2);
    let Ok(pool) = ThreadPool::new(2, Pin::No) else { return };
    pool.run(|| {
        tickets(&mut [(), ()], 2, |(), ticket| {
            both.count_down();
            both.wait();
            if ticket == 1 {
                work();
            }
            ControlFlow::Continue(())
        });
    });
}
