//! Lists and selects devices.

use std::sync::{Mutex, PoisonError};

use opencl3::device::{CL_DEVICE_TYPE_ALL, CL_DEVICE_TYPE_CPU, CL_DEVICE_TYPE_GPU, Device};
use opencl3::error_codes::{
    CL_DEVICE_NOT_FOUND, CL_PLATFORM_NOT_FOUND_KHR, ClError, DLOPEN_FUNCTION_NOT_AVAILABLE,
    DLOPEN_RUNTIME_LOAD_FAILED,
};
use opencl3::platform::{Platform, get_platforms};

use catamaran::base::{Error, Result};

/// The kind of a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeviceKind {
    /// The processor of this machine.
    Cpu,
    /// A graphics card.
    Gpu,
    /// Anything else.
    Other,
}

/// A device, as it describes itself.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct DeviceInfo {
    /// Its index, from 0, in the order of the loader.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// The platform (driver) to which it belongs.
    pub platform: String,
    /// The version of OpenCL that it supports.
    pub version: String,
    /// The kind of the device.
    pub kind: DeviceKind,
    /// Number of compute units.
    pub compute_units: u32,
    /// Size of its memory, in bytes.
    pub memory: u64,
}

/// Returns all devices of all platforms; never empty.
///
/// ```
/// use catamaran_simulation::opencl::devices;
///
/// // The error says what is missing.
/// match devices() {
///     Ok(devices) => assert_eq!(devices[0].index, 0),
///     Err(error) => println!("{error}"),
/// }
/// ```
///
/// # Errors
/// [`Error::Backend`] says what is missing and how to install it, when there is no loader, no
/// driver or no device.
pub fn devices() -> Result<Vec<DeviceInfo>> {
    Ok(all()?.into_iter().map(|(info, _)| info).collect())
}

/// Returns the device that `selector` names: by its index, or a part of its name or of that of its
/// platform, in any case. Among several matches, and for an empty selector, returns the first GPU,
/// otherwise the first device.
///
/// ```
/// use catamaran_simulation::opencl::{devices, find};
///
/// let Ok(all) = devices() else { return Ok(()) };
/// assert_eq!(find("0")?, all[0]);
/// assert!(find("no such device").is_err());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`devices`], and [`Error::Argument`] with a list of the devices when none fits.
pub fn find(selector: &str) -> Result<DeviceInfo> {
    chosen(selector).map(|(info, _)| info)
}

/// Opens the device that [`find`] returns.
pub(super) fn chosen(selector: &str) -> Result<(DeviceInfo, Device)> {
    let mut all = all()?;
    let infos: Vec<&DeviceInfo> = all.iter().map(|(info, _)| info).collect();
    match choice(&infos, selector) {
        Some(i) => Ok(all.swap_remove(i)),
        None => Err(unmatched(&infos, selector)),
    }
}

/// Returns the error that no device fits, with a list of all.
fn unmatched(devices: &[&DeviceInfo], selector: &str) -> Error {
    let known = devices.iter().map(|info| format!("{}: {}", info.index, info.name));
    let known = known.collect::<Vec<_>>().join(", ");
    let why = format!("no device matches {selector:?}; the devices are {known}");
    Error::Argument { what: "device", why }
}

/// Returns the index of the selected device.
fn choice(devices: &[&DeviceInfo], selector: &str) -> Option<usize> {
    if let Ok(index) = selector.parse::<usize>() {
        return devices.iter().position(|device| device.index == index);
    }
    let wanted = selector.to_lowercase();
    let fits = |info: &DeviceInfo| {
        [&info.name, &info.platform].iter().any(|name| name.to_lowercase().contains(&wanted))
    };
    let gpu = devices.iter().position(|info| fits(info) && info.kind == DeviceKind::Gpu);
    gpu.or_else(|| devices.iter().position(|info| fits(info)))
}

/// Locked during queries of drivers: the first query starts them, and PoCL 3.1 has no devices for a
/// second thread that queries meanwhile.
static START: Mutex<()> = Mutex::new(());

fn all() -> Result<Vec<(DeviceInfo, Device)>> {
    let _one_at_a_time = START.lock().unwrap_or_else(PoisonError::into_inner);
    let mut found = Vec::new();
    for platform in get_platforms().map_err(missing)? {
        let ids = match platform.get_devices(CL_DEVICE_TYPE_ALL) {
            Err(ClError(CL_DEVICE_NOT_FOUND)) => continue,
            ids => ids.map_err(missing)?,
        };
        for id in ids {
            let device = Device::new(id);
            let info = describe(&platform, &device, found.len()).map_err(missing)?;
            found.push((info, device));
        }
    }
    if found.is_empty() { Err(missing(ClError(CL_DEVICE_NOT_FOUND))) } else { Ok(found) }
}

fn describe(
    platform: &Platform,
    device: &Device,
    index: usize,
) -> std::result::Result<DeviceInfo, ClError> {
    let kind = device.dev_type()?;
    Ok(DeviceInfo {
        index,
        name: device.name()?.trim().to_owned(),
        platform: platform.name()?.trim().to_owned(),
        version: device.version()?.trim().to_owned(),
        kind: if kind & CL_DEVICE_TYPE_GPU != 0 {
            DeviceKind::Gpu
        } else if kind & CL_DEVICE_TYPE_CPU != 0 {
            DeviceKind::Cpu
        } else {
            DeviceKind::Other
        },
        compute_units: device.max_compute_units()?,
        memory: device.global_mem_size()?,
    })
}

/// Returns an error that explains to the user of the machine what is missing.
fn missing(error: ClError) -> Error {
    let why = match error.0 {
        DLOPEN_RUNTIME_LOAD_FAILED | DLOPEN_FUNCTION_NOT_AVAILABLE => {
            "the OpenCL loader libOpenCL.so.1 is not installed (Debian: apt install \
             ocl-icd-libopencl1 pocl-opencl-icd; for a GPU, its maker's driver instead of \
             pocl-opencl-icd)"
                .into()
        }
        CL_PLATFORM_NOT_FOUND_KHR | CL_DEVICE_NOT_FOUND => {
            "the OpenCL loader is installed, but no driver with a device (Debian: apt install \
             pocl-opencl-icd for the processor; for a GPU, its maker's driver)"
                .into()
        }
        _ => error.to_string(),
    };
    Error::Backend { name: "OpenCL".into(), why, cause: Some(error.into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device(index: usize, name: &str, platform: &str, kind: DeviceKind) -> DeviceInfo {
        let (name, platform) = (name.to_owned(), platform.to_owned());
        let version = "OpenCL 1.2".to_owned();
        DeviceInfo { index, name, platform, version, kind, compute_units: 1, memory: 1 }
    }

    #[test]
    fn a_device_is_found_by_number_or_by_part_of_a_name() {
        let cpu = device(0, "pthread-Xeon", "Portable Computing Language", DeviceKind::Cpu);
        let gpu = device(1, "RTX 4090", "NVIDIA CUDA", DeviceKind::Gpu);
        let both = [&cpu, &gpu];
        assert_eq!(choice(&both, ""), Some(1), "a GPU comes first");
        assert_eq!(choice(&both, "0"), Some(0));
        assert_eq!(choice(&both, "xeon"), Some(0));
        assert_eq!(choice(&both, "nvidia"), Some(1));
        assert_eq!(choice(&both, "radeon"), None);
        assert_eq!(choice(&both, "2"), None);
        assert_eq!(choice(&both[..1], ""), Some(0));
        assert_eq!(choice(&[], ""), None);
        // The number of a device must not read as a count of devices.
        let says =
            r#"device: no device matches "zzz"; the devices are 0: pthread-Xeon, 1: RTX 4090"#;
        assert_eq!(unmatched(&both, "zzz").to_string(), says);
    }

    #[test]
    fn what_is_missing_comes_with_the_way_to_get_it() {
        for code in [DLOPEN_RUNTIME_LOAD_FAILED, CL_PLATFORM_NOT_FOUND_KHR, CL_DEVICE_NOT_FOUND] {
            let error = missing(ClError(code)).to_string();
            assert!(error.contains("apt install") && error.contains("pocl"), "{error}");
        }
        assert!(missing(ClError(-5)).to_string().contains("RESOURCES"));
    }
}
