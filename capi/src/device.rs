//! # Devices
//!
//! OpenCL devices, where the library has CATA_CAP_OPENCL. `device` of parameters is a number,
//! or a part of a name; "" is the first GPU, or else the first device.
//!
//! ```c
//! char name[256];
//! size_t count = 0;
//! cata_device_count(&count);
//! for (size_t i = 0; i < count && cata_device_name(i, sizeof name, name) == CATA_OK; i++) {
//!     printf("%s\n", name);
//! }
//! ```

use std::ffi::c_char;

use super::boundary::{boundary, utf8};
use super::outputs::write_text;
use super::pointer::{output, slice_mut};
use super::status::{Failure, cata_status};
#[cfg(feature = "opencl")]
pub(super) use catamaran_simulation::opencl::Device;

/// The type of devices in a build without OpenCL, which has none.
#[cfg(not(feature = "opencl"))]
pub(super) enum Device {}

/// A kind of devices: the processor of this machine.
pub const CATA_DEVICE_CPU: i32 = 0;
/// A kind of devices: a graphics card.
pub const CATA_DEVICE_GPU: i32 = 1;
/// A kind of devices: anything else.
pub const CATA_DEVICE_OTHER: i32 = 2;

/// Gets the number of devices, at least 1. CATA_ERR_BACKEND: the message says what is missing.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_device_count(count: *mut usize) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`count`, one value).
        let count = unsafe { output("count", count) }?;
        *count = all()?.len();
        Ok(())
    })
}

/// Gets the name of the device `index` (from 0): `size` elements of `name`, cut to fit, and NUL.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_device_name(
    index: usize,
    size: usize,
    name: *mut c_char,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`name`, `size` elements).
        let name = unsafe { slice_mut("name", name, size) }?;
        let (found, _) = numbered(index)?;
        write_text(name, &found);
        Ok(())
    })
}

/// Gets the kind of the device `index` (from 0): one of CATA_DEVICE_*.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_device_kind(index: usize, kind: *mut i32) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`kind`, one value).
        let kind = unsafe { output("kind", kind) }?;
        *kind = numbered(index)?.1;
        Ok(())
    })
}

/// Returns the device that a field of parameters names, or `None` for NULL.
///
/// # Safety
/// `selector` is NULL or NUL-terminated.
pub(super) unsafe fn chosen(selector: *const c_char) -> Result<Option<Device>, Failure> {
    if selector.is_null() {
        return Ok(None);
    }
    // SAFETY: clause `texts` (`params.device`).
    open(&unsafe { utf8("params.device", selector) }?).map(Some)
}

/// Returns the name and the kind of a device.
fn numbered(index: usize) -> Result<(String, i32), Failure> {
    let mut all = all()?;
    if index < all.len() {
        return Ok(all.swap_remove(index));
    }
    Err(Failure::beyond("index", all.len(), "devices", index))
}

#[cfg(feature = "opencl")]
fn all() -> Result<Vec<(String, i32)>, Failure> {
    use catamaran_simulation::opencl::DeviceKind;
    let kind = |kind| match kind {
        DeviceKind::Cpu => CATA_DEVICE_CPU,
        DeviceKind::Gpu => CATA_DEVICE_GPU,
        DeviceKind::Other => CATA_DEVICE_OTHER,
    };
    Ok(catamaran_simulation::opencl::devices()?
        .into_iter()
        .map(|d| (d.name, kind(d.kind)))
        .collect())
}

#[cfg(feature = "opencl")]
fn open(selector: &str) -> Result<Device, Failure> {
    Ok(Device::open(selector)?)
}

#[cfg(not(feature = "opencl"))]
fn all() -> Result<Vec<(String, i32)>, Failure> {
    Err(Failure::absent("opencl"))
}

#[cfg(not(feature = "opencl"))]
fn open(_selector: &str) -> Result<Device, Failure> {
    let mut failure = Failure::absent("opencl");
    failure.message.insert_str(0, "params.device: ");
    Err(failure)
}
