use super::boundary::boundary;
use super::status::cata_status;
use crate::base::release_memory;

/// Gives back the memory that products keep for the next one: the scratch of the last large call,
/// at most 1 GiB.
///
/// Scratch in use is not touched.
#[unsafe(no_mangle)]
pub extern "C" fn cata_memory_release() -> cata_status {
    boundary(|| {
        release_memory();
        Ok(())
    })
}
