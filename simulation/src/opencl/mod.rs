//! OpenCL (feature `opencl`): device choice, programs, and the kernels of
//! [`texture`](crate::texture).
//!
//! The loader (`libOpenCL.so.1`) is opened at run time: a program that was built with this feature
//! starts on a machine without a loader, and the first call returns an error that says what is
//! missing. Each kernel does the arithmetic of its counterpart in [`texture`](crate::texture),
//! operation by operation and without contraction, so that on devices whose division and square
//! root are rounded correctly both give the same bits.

mod device;
mod newton;
mod session;
mod slime;

pub use device::{DeviceInfo, DeviceKind, devices, find};
pub use newton::{evaluate_newton, evaluate_newton_in_groups};
pub use session::{Device, DeviceTimes};
pub use slime::SlimeOnDevice;
