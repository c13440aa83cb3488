//! Where kernels run: `--device`.

use anyhow::Result;

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

/// The lines of `catamaran info`: each device, or why there is none.
pub fn described() -> Vec<String> {
    #[cfg(feature = "opencl")]
    return match catamaran::opencl::devices() {
        Ok(devices) => devices
            .iter()
            .map(|d| {
                let gib = d.memory as f64 / f64::from(1 << 30);
                let units = d.compute_units;
                format!("{}: {}, {}, {units} units, {gib:.1} GiB", d.index, d.name, d.platform)
            })
            .collect(),
        Err(e) => vec![e.to_string()],
    };
    #[cfg(not(feature = "opencl"))]
    vec!["not in this build (--features opencl)".into()]
}
