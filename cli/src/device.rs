//! Where kernels run: `--device`.

use anyhow::Result;
#[cfg(feature = "opencl")]
use catamaran::opencl::DeviceInfo;

use crate::info::WIDTH;
#[cfg(feature = "opencl")]
use crate::info::first;
use crate::report::row;

/// Where the work is done.
#[derive(clap::Args)]
pub struct DeviceArgs {
    /// Where it is computed: `cpu` (without OpenCL), or an OpenCL device by its number or a part of
    /// its name, as `catamaran info` lists them; `opencl` is the first GPU, or else the first
    /// device.
    #[arg(long, value_name = "cpu|NAME", default_value = "cpu")]
    device: String,
}

/// An OpenCL device that is ready.
#[cfg(feature = "opencl")]
pub type Device = catamaran::opencl::Device;

/// There is none in this build.
#[cfg(not(feature = "opencl"))]
pub enum Device {}

impl DeviceArgs {
    /// The device; `None` for the processor without OpenCL.
    pub fn open(&self) -> Result<Option<Device>> {
        match self.device.as_str() {
            "cpu" => Ok(None),
            "opencl" => opened("").map(Some),
            name => opened(name).map(Some),
        }
    }
}

#[cfg(feature = "opencl")]
fn opened(name: &str) -> Result<Device> {
    Ok(Device::open(name)?)
}

#[cfg(not(feature = "opencl"))]
fn opened(name: &str) -> Result<Device> {
    anyhow::bail!("--device {name}: OpenCL is not in this build (--features opencl)")
}

/// What a device is called.
#[cfg(feature = "opencl")]
pub fn name(device: &Device) -> &str {
    &device.info().name
}

/// What a device is called.
#[cfg(not(feature = "opencl"))]
pub fn name(device: &Device) -> &str {
    match *device {}
}

/// Reports each device, or why there is none, for `catamaran info`.
#[cfg(feature = "opencl")]
pub fn report() -> Result<()> {
    let devices = match catamaran::opencl::devices() {
        Ok(devices) => devices,
        Err(e) => return none(&e.to_string()),
    };
    for (i, device) in devices.iter().enumerate() {
        let DeviceInfo { index, name, platform, compute_units: units, memory, .. } = device;
        let gib = *memory as f64 / f64::from(1 << 30);
        row!(
            "opencl",
            available = true,
            index = index,
            name = name,
            platform = platform,
            compute_units = units,
            bytes = memory;
            "{:WIDTH$}{index}: {name}, {platform}, {units} units, {gib:.1} GiB",
            first(i, "opencl")
        )?;
    }
    Ok(())
}

/// Reports that there is no device, for `catamaran info`.
#[cfg(not(feature = "opencl"))]
pub fn report() -> Result<()> {
    none("not in this build (--features opencl)")
}

fn none(why: &str) -> Result<()> {
    row!("opencl", available = false, reason = why; "{:WIDTH$}{why}", "opencl")
}
