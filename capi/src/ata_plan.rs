use std::ffi::c_char;

use super::ata_params::{cata_ata_params, with_options};
use super::boundary::boundary;
use super::outputs::write_text;
use super::pointer::slice_mut;
use super::status::cata_status;
use catamaran::blas::BlasReal;
use catamaran::{Plan, Uplo};

/// Describes how cata_ata_f64 computes A^T A for the same m, n and params: the recursion, its tasks
/// and scratch, and the expected seconds on one core.
///
/// `size`, `text`: so many elements, written: lines of text, cut to fit, with a NUL; 2048 is
/// enough.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_plan_f64(
    m: usize,
    n: usize,
    params: *const cata_ata_params,
    size: usize,
    text: *mut c_char,
) -> cata_status {
    // SAFETY: clause `passed on` (`plan`).
    unsafe { plan::<f64>(m, n, params, size, text) }
}

/// Describes cata_ata_f32 as cata_ata_plan_f64 does.
///
/// # Safety
/// The pointers are as described at `cata_ata_plan_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_plan_f32(
    m: usize,
    n: usize,
    params: *const cata_ata_params,
    size: usize,
    text: *mut c_char,
) -> cata_status {
    // SAFETY: clause `passed on` (`plan`).
    unsafe { plan::<f32>(m, n, params, size, text) }
}

/// Implements `cata_ata_plan_*`.
///
/// # Safety
/// The pointers are as the header describes them.
unsafe fn plan<T: BlasReal>(
    m: usize,
    n: usize,
    params: *const cata_ata_params,
    size: usize,
    text: *mut c_char,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`text`, `size` elements), clause `structs` (`params`).
        unsafe {
            let text = slice_mut("text", text, size)?;
            with_options(params, Uplo::Lower, |options| {
                write_text(text, &Plan::ata::<T>(m, n, options)?.to_string());
                Ok(())
            })
        }
    })
}
