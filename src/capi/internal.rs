use super::boundary::boundary;
use super::status::cata_status;
use crate::Par;

/// For the tests of this ABI only: panics inside the library, on the calling thread if `worker` is
/// 0 and else on a thread of its own, to show that no panic reaches the caller.
///
/// Returns CATA_ERR_PANIC. Thread-safe.
#[unsafe(no_mangle)]
pub extern "C" fn cata_internal_panic(worker: i32) -> cata_status {
    boundary(|| {
        if worker == 0 {
            panic!("forced by cata_internal_panic");
        }
        let lane = |lane: usize| {
            if lane > 0 {
                panic!("forced by cata_internal_panic, on a worker");
            }
        };
        Par::Threads(2).run_lanes(lane);
        Ok(())
    })
}
