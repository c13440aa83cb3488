use super::boundary::boundary;
use super::status::cata_status;
use crate::base::release_memory;

/// Gives back the memory that products keep for the next one, at most 1 GiB, but for what is in
/// use.
#[unsafe(no_mangle)]
pub extern "C" fn cata_memory_release() -> cata_status {
    boundary(|| {
        release_memory();
        Ok(())
    })
}
