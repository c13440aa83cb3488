//! # Devices
//!
//! OpenCL devices, where the library has CATA_CAP_OPENCL.
//!
//! ```c
//! char name[256];
//! if (cata_device_name(0, sizeof name, name) == CATA_OK) {
//!     printf("%s\n", name);
//! }
//! ```

use std::ffi::c_char;

use super::boundary::boundary;
use super::pointer::{optional_output, slice_mut};
#[cfg(not(feature = "opencl"))]
use super::status::CATA_ERR_UNSUPPORTED;
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};

/// An OpenCL device of this machine, by its number.
///
/// - `index`: from 0.
/// - `count`: one element, written: how many devices there are. NULL where not wanted.
/// - `size`: elements of `name`; 0 where the name is not wanted.
/// - `name`: `size` elements, written: what the device is called, cut to fit, NUL-terminated. May
///   be NULL when `size` is 0; `index` is not looked at then.
///
/// Returns CATA_ERR_ARGUMENT for a device that is not there, CATA_ERR_BACKEND when there is none
/// at all (the message says what is missing).
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_device_name(
    index: usize,
    count: *mut usize,
    size: usize,
    name: *mut c_char,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let (count, name) =
            unsafe { (optional_output("count", count)?, slice_mut("name", name, size)?) };
        let names = names()?;
        if let [first @ .., last] = name {
            let Some(found) = names.get(index) else {
                let why = format!("index: {index}, where there are {} devices", names.len());
                return Err(Failure::new(CATA_ERR_ARGUMENT, why));
            };
            first.fill(0);
            // Bytes as they are, whatever the sign of a char is here.
            first.iter_mut().zip(found.bytes()).for_each(|(out, byte)| *out = byte as c_char);
            *last = 0;
        }
        if let Some(count) = count {
            *count = names.len();
        }
        Ok(())
    })
}

#[cfg(feature = "opencl")]
fn names() -> Result<Vec<String>, Failure> {
    Ok(crate::opencl::devices()?.into_iter().map(|device| device.name).collect())
}

#[cfg(not(feature = "opencl"))]
fn names() -> Result<Vec<String>, Failure> {
    Err(Failure::new(CATA_ERR_UNSUPPORTED, "built without the feature opencl"))
}
