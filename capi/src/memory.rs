use super::boundary::boundary;
use super::status::cata_status;
use catamaran::base::{release_memory, release_threads};

/// Frees the memory that products keep for later ones, at most 1.25 GiB, except what is in use.
#[unsafe(no_mangle)]
pub extern "C" fn cata_memory_release() -> cata_status {
    boundary(|| {
        release_memory();
        Ok(())
    })
}

/// Ends the threads that the library keeps between calls, and waits until they have ended.
///
/// Later calls start new threads. A call that runs at the same time keeps its threads until it
/// returns.
#[unsafe(no_mangle)]
pub extern "C" fn cata_threads_release() -> cata_status {
    boundary(|| {
        release_threads();
        Ok(())
    })
}
