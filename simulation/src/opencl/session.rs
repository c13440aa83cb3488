//! An opened device: its context, its queue, and the programs built for it.

use std::collections::HashMap;
use std::ptr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use opencl3::command_queue::{CL_QUEUE_PROFILING_ENABLE, CommandQueue};
use opencl3::context::Context;
use opencl3::device::{CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT, Device as Handle};
use opencl3::error_codes::{
    CL_INVALID_BUFFER_SIZE, CL_MEM_OBJECT_ALLOCATION_FAILURE, CL_OUT_OF_HOST_MEMORY,
    CL_OUT_OF_RESOURCES, ClError,
};
use opencl3::event::Event;
use opencl3::kernel::{ExecuteKernel, Kernel};
use opencl3::memory::{Buffer, CL_MEM_READ_WRITE};
use opencl3::program::Program;
use opencl3::types::CL_BLOCKING;

use super::device::{DeviceInfo, chosen};
use catamaran::base::{Error, Result, reserved};

/// A device that is ready for work. Programs are built at their first use.
///
/// ```
/// use catamaran_simulation::opencl::{Device, find};
///
/// let Ok(device) = Device::open("") else { return Ok(()) };
/// assert_eq!(*device.info(), find("")?);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// Clones refer to the same device, with one queue and one set of programs.
#[derive(Clone)]
pub struct Device(Arc<Opened>);

struct Opened {
    info: DeviceInfo,
    handle: Handle,
    queue: CommandQueue,
    context: Context,
    programs: Mutex<HashMap<(&'static str, String), Arc<Program>>>,
    work: Mutex<Work>,
}

/// What the device has done.
#[derive(Default)]
struct Work {
    /// Whether kernels and transfers are timed.
    timed: bool,
    /// Kernels and transfers whose times are not summed yet.
    events: Vec<(Kind, Event)>,
    times: DeviceTimes,
    /// How often the host has waited for the queue.
    waits: u64,
}

#[derive(Clone, Copy)]
enum Kind {
    Kernel,
    Transfer,
}

impl Work {
    /// Sums the times of what has ended.
    fn sum(&mut self) {
        let times = &mut self.times;
        self.events.retain(|(kind, event)| {
            let (start, end) = (event.profiling_command_start(), event.profiling_command_end());
            // Of work that another thread has enqueued since, there are no times yet.
            let (Ok(start), Ok(end)) = (start, end) else { return true };
            let sum = match kind {
                Kind::Kernel => &mut times.kernels,
                Kind::Transfer => &mut times.transfers,
            };
            *sum += Duration::from_nanos(end.saturating_sub(start));
            false
        });
    }
}

/// The times of a device, by its own clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct DeviceTimes {
    /// Time in which kernels ran.
    pub kernels: Duration,
    /// Time in which memory was copied between host and device.
    pub transfers: Duration,
}

impl std::fmt::Debug for Device {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Device").field("info", &self.0.info).finish_non_exhaustive()
    }
}

/// A number for which all bit patterns are valid, of the same size on the host and on devices.
pub(super) trait Number: Copy {}
impl Number for f32 {}
impl Number for u8 {}
impl Number for u16 {}
impl Number for u32 {}
impl Number for u64 {}

impl Device {
    /// Opens the device that `selector` names, as in [`find`](super::find).
    ///
    /// # Errors
    /// As [`find`](super::find); [`Error::Backend`] when the device fails.
    pub fn open(selector: &str) -> Result<Self> {
        Self::open_with(selector, false)
    }

    /// Opens the device as [`Device::open`] does, and times its kernels and transfers
    /// ([`Device::times`]).
    ///
    /// # Errors
    /// As [`Device::open`].
    pub fn open_timed(selector: &str) -> Result<Self> {
        Self::open_with(selector, true)
    }

    fn open_with(selector: &str, timed: bool) -> Result<Self> {
        let (info, handle) = chosen(selector)?;
        let refused = |e: ClError| refusal(&info, "creating a context failed", e);
        let context = Context::from_device(&handle).map_err(refused)?;
        // SAFETY: the device belongs to the context.
        #[allow(deprecated)]
        let queue = unsafe {
            let properties = if timed { CL_QUEUE_PROFILING_ENABLE } else { 0 };
            CommandQueue::create(&context, handle.id(), properties)
        }
        .map_err(refused)?;
        let programs = Mutex::default();
        let work = Mutex::new(Work { timed, ..Work::default() });
        Ok(Self(Arc::new(Opened { info, handle, queue, context, programs, work })))
    }

    /// Returns the time of kernels and that of transfers since the device was opened or last asked,
    /// after all of them have ended; `None` unless it was opened by [`Device::open_timed`].
    ///
    /// ```
    /// use catamaran::base::Progress;
    /// use catamaran_simulation::opencl::{Device, evaluate_newton};
    /// use catamaran_simulation::texture::newton::{Grid, Newton, NewtonOptions, Points};
    ///
    /// let Ok(device) = Device::open_timed("") else { return Ok(()) };
    /// let newton = Newton::new(&NewtonOptions::new())?;
    /// let points = Points::Grid(Grid::plane(256, 256, [0.0, 0.0], 2.0));
    /// evaluate_newton(&device, &newton, points, Progress::none())?;
    /// let times = device.times()?.unwrap();
    /// assert!(!times.kernels.is_zero() && !times.transfers.is_zero());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Backend`] when the device fails.
    pub fn times(&self) -> Result<Option<DeviceTimes>> {
        self.finish("times")?;
        let mut work = self.work();
        Ok(work.timed.then(|| std::mem::take(&mut work.times)))
    }

    fn work(&self) -> std::sync::MutexGuard<'_, Work> {
        self.0.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps the event of a kernel or of a transfer if the device is timed.
    fn keep(&self, kind: Kind, event: Event) {
        let mut work = self.work();
        if work.timed {
            work.events.push((kind, event));
        }
    }

    /// Notes that the host has waited.
    fn waited(&self) {
        let mut work = self.work();
        work.waits += 1;
        work.sum();
    }

    /// Waits for the end of all work. `what` names it, for errors.
    pub(super) fn finish(&self, what: &str) -> Result<()> {
        self.0.queue.finish().map_err(|e| self.failed(what, e))?;
        self.waited();
        Ok(())
    }

    /// Returns how often the host has waited for the device.
    #[cfg(test)]
    pub(super) fn waits(&self) -> u64 {
        self.work().waits
    }

    /// Returns the description of the device.
    pub fn info(&self) -> &DeviceInfo {
        &self.0.info
    }

    /// Returns how many 32-bit numbers the device processes at once: 16, 8, 4, or 1 for a device
    /// that has many threads instead.
    pub(super) fn lanes(&self) -> usize {
        match self.0.handle.native_vector_width_float() {
            Ok(16..) => 16,
            Ok(8..) => 8,
            Ok(4..) => 4,
            _ => 1,
        }
    }

    /// Returns the kernel `name` of a program, which is built at its first use. `source` is the
    /// text of the program, and `options` are for its compiler.
    pub(super) fn kernel(&self, source: &'static str, options: &str, name: &str) -> Result<Kernel> {
        let program = self.program(source, options)?;
        Kernel::create(&program, name).map_err(|e| self.failed(name, e))
    }

    fn program(&self, source: &'static str, options: &str) -> Result<Arc<Program>> {
        let mut options = format!("-cl-std=CL1.2 {options}");
        let rounding = self.0.handle.single_fp_config().unwrap_or(0);
        if rounding & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT != 0 {
            options += " -cl-fp32-correctly-rounded-divide-sqrt";
        }
        let mut programs = self.0.programs.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(program) = programs.get(&(source, options.clone())) {
            return Ok(program.clone());
        }
        let built = Program::create_and_build_from_source(&self.0.context, source, &options);
        let program = Arc::new(built.map_err(|log| Error::Backend {
            name: self.0.info.name.clone(),
            why: format!("a kernel could not be compiled: {log}"),
            cause: None,
        })?);
        programs.insert((source, options), program.clone());
        Ok(program)
    }

    /// Allocates memory for `len` numbers, at least for one.
    pub(super) fn buffer<T: Number>(&self, len: usize) -> Result<Buffer<T>> {
        let len = len.max(1);
        let bytes = len.saturating_mul(size_of::<T>());
        // NVIDIA's driver accepts a buffer of any size, and fails when it is used.
        if bytes as u64 > self.info().memory {
            return Err(Error::OutOfMemory { bytes });
        }
        // SAFETY: the memory belongs to the device, and no pointer of the host refers to it.
        unsafe { Buffer::create(&self.0.context, CL_MEM_READ_WRITE, len, ptr::null_mut()) }.map_err(
            |e| match e.0 {
                CL_MEM_OBJECT_ALLOCATION_FAILURE
                | CL_OUT_OF_HOST_MEMORY
                | CL_OUT_OF_RESOURCES
                | CL_INVALID_BUFFER_SIZE => Error::OutOfMemory { bytes },
                _ => self.failed("memory", e),
            },
        )
    }

    /// Copies `values` to the beginning of `buffer`, which must be large enough, and waits for the
    /// end of the copy.
    pub(super) fn write<T: Number>(&self, buffer: &mut Buffer<T>, values: &[T]) -> Result<()> {
        if values.is_empty() {
            return Ok(());
        }
        // SAFETY: OpenCL refuses to write beyond the buffer, and the call blocks until `values`
        // have been read.
        let sent =
            unsafe { self.0.queue.enqueue_write_buffer(buffer, CL_BLOCKING, 0, values, &[]) };
        self.keep(Kind::Transfer, sent.map_err(|e| self.failed("sending", e))?);
        self.waited();
        Ok(())
    }

    /// Copies the beginning of `buffer`, which must be large enough, to `values`, after all earlier
    /// work.
    pub(super) fn read<T: Number>(&self, buffer: &Buffer<T>, values: &mut [T]) -> Result<()> {
        self.read_from(buffer, 0, values)
    }

    /// Copies from number `first` of `buffer` on, as [`Device::read`] does.
    pub(super) fn read_from<T: Number>(
        &self,
        buffer: &Buffer<T>,
        first: usize,
        values: &mut [T],
    ) -> Result<()> {
        if values.is_empty() {
            return Ok(());
        }
        // SAFETY: the call blocks until `values` have been written, and all bit patterns are valid
        // for a `Number`.
        let got = unsafe {
            let queue = &self.0.queue;
            queue.enqueue_read_buffer(buffer, CL_BLOCKING, first * size_of::<T>(), values, &[])
        };
        self.keep(Kind::Transfer, got.map_err(|e| self.failed("receiving", e))?);
        self.waited();
        Ok(())
    }

    /// Allocates memory that holds these numbers.
    pub(super) fn filled<T: Number>(&self, values: &[T]) -> Result<Buffer<T>> {
        let mut buffer = self.buffer(values.len())?;
        self.write(&mut buffer, values)?;
        Ok(buffer)
    }

    /// Returns the first `len` numbers of `buffer`, after all earlier work.
    pub(super) fn values<T: Number + Default>(
        &self,
        buffer: &Buffer<T>,
        len: usize,
    ) -> Result<Vec<T>> {
        let mut values = reserved(len)?;
        values.resize(len, T::default());
        self.read(buffer, &mut values)?;
        Ok(values)
    }

    pub(super) fn failed(&self, what: &str, error: ClError) -> Error {
        refusal(&self.0.info, what, error)
    }
}

/// Launches kernels on a device.
#[derive(Debug, Clone)]
pub(super) struct Launcher {
    pub device: Device,
    /// Number of work-items of a work-group; `None` leaves the choice to the driver.
    pub group: Option<usize>,
    /// Name of the work, for errors.
    pub what: &'static str,
}

impl Launcher {
    /// Appends a call with all its arguments to the queue of the device.
    ///
    /// # Safety
    /// The arguments are those that the kernel declares, and `items` work-items stay within its
    /// buffers, which live until the device has finished.
    pub(super) unsafe fn enqueue(&self, mut call: ExecuteKernel<'_>, items: usize) -> Result<()> {
        if items == 0 {
            return Ok(());
        }
        match self.group {
            Some(group) => {
                call.set_global_work_size(items.next_multiple_of(group)).set_local_work_size(group)
            }
            None => call.set_global_work_size(items),
        };
        // SAFETY: the contract: the arguments are those that the kernel declares, and work-items
        // from `items` on, up to a multiple of the group, do nothing in its code.
        let queued = unsafe { call.enqueue_nd_range(&self.device.0.queue) };
        let event = queued.map_err(|e| self.device.failed(self.what, e))?;
        self.device.keep(Kind::Kernel, event);
        Ok(())
    }
}

fn refusal(info: &DeviceInfo, what: &str, error: ClError) -> Error {
    let why = format!("{what}: {error}");
    Error::Backend { name: info.name.clone(), why, cause: Some(error.into()) }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Returns the device of tests, or `None`, with a message, where there may be none:
    /// `scripts/test` sets CATAMARAN_REQUIRE_OPENCL.
    pub(crate) fn device() -> Option<Device> {
        match Device::open(&std::env::var("CATAMARAN_OPENCL_DEVICE").unwrap_or_default()) {
            Ok(device) => Some(device),
            Err(e) if std::env::var_os("CATAMARAN_REQUIRE_OPENCL").is_some() => {
                panic!("CATAMARAN_REQUIRE_OPENCL is set, and {e}")
            }
            Err(e) => {
                println!("skipped: OpenCL: {e}");
                None
            }
        }
    }

    #[test]
    fn a_program_that_does_not_compile_comes_back_with_its_log() {
        let Some(device) = device() else { return };
        let source = "__kernel void f(__global float *x) { x[0] = no_such_name; }";
        let error = device.kernel(source, "", "f").unwrap_err().to_string();
        assert!(error.contains("no_such_name"), "{error}");
    }

    #[test]
    fn programs_are_built_once_for_their_options() {
        let Some(device) = device() else { return };
        let source = "__kernel void f(__global float *x) { x[get_global_id(0)] += STEP; }";
        let one = device.program(source, "-DSTEP=1.0f").unwrap();
        assert!(Arc::ptr_eq(&one, &device.program(source, "-DSTEP=1.0f").unwrap()));
        assert!(!Arc::ptr_eq(&one, &device.program(source, "-DSTEP=2.0f").unwrap()));
        assert!(device.kernel(source, "-DSTEP=1.0f", "g").is_err(), "there is no such kernel");
    }

    #[test]
    fn numbers_come_back_from_a_device() {
        let Some(device) = device() else { return };
        let sent: Vec<u32> = (0..257).collect();
        let mut buffer = device.buffer(sent.len()).unwrap();
        device.write(&mut buffer, &sent).unwrap();
        let mut got = vec![0; 257];
        device.read(&buffer, &mut got).unwrap();
        assert_eq!(got, sent);
        for len in [usize::MAX / 8, 1 << 45] {
            let refused = device.buffer::<f32>(len).map(drop).unwrap_err();
            assert!(matches!(refused, Error::OutOfMemory { bytes } if bytes == 4 * len));
        }
    }
}
