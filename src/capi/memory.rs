use super::boundary::boundary;
use super::status::cata_status;
use crate::base::release_memory;

/// Frees the memory that products keep for later ones, at most 1.25 GiB, except what is in use.
#[unsafe(no_mangle)]
pub extern "C" fn cata_memory_release() -> cata_status {
    boundary(|| {
        release_memory();
        Ok(())
    })
}
