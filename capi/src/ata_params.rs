use std::ffi::c_void;

use super::backend::cata_backend;
use super::params::{Params, flag, init, params, read};
use super::progress::{cata_progress, par};
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use catamaran::base::Pin;
use catamaran::{Accuracy, AtaOptions, SchemeChoice, Uplo};

/// `scheme`: the fastest within the requested accuracy.
pub const CATA_SCHEME_AUTO: i32 = 0;
/// `scheme`: no fast products, blocks over the back end.
pub const CATA_SCHEME_CLASSICAL: i32 = 1;
/// `scheme`: AtA over Strassen's, 2 x 2, down to the cache.
pub const CATA_SCHEME_ATA2: i32 = 2;
/// `scheme`: 2 x 2 over Winograd's variant of Strassen's.
pub const CATA_SCHEME_WINOGRAD: i32 = 3;
/// `scheme`: RXTX (4 x 4 blocks) over Winograd's variant.
pub const CATA_SCHEME_RXTX: i32 = 4;
/// `scheme`: 4 x 4 of Khoruzhii, Gelss and Pokutta.
pub const CATA_SCHEME_KGP4: i32 = 5;
/// `scheme`: 3 x 3 of Khoruzhii, Gelss and Pokutta.
pub const CATA_SCHEME_KGP3: i32 = 6;
/// `scheme`: integer products modulo small coprime numbers: nothing is rounded but the columns, to
/// about 2^-54 of their norms (float: 2^-27), and the result.
pub const CATA_SCHEME_EXACT: i32 = 7;
/// `scheme`: as CATA_SCHEME_AUTO, but never CATA_SCHEME_EXACT.
pub const CATA_SCHEME_FLOAT: i32 = 8;

/// `error_factor`: the least error. With CATA_SCHEME_AUTO that is CATA_SCHEME_EXACT on every
/// machine, however slow it is there; other schemes are as with 1.
pub const CATA_ERROR_LEAST: f64 = -1.0;

/// How a product is computed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_ata_params {
    /// sizeof(cata_ata_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// Smallest block side of the recursion, in elements, at most 2^31; 0: the library's
    /// choice.
    pub leaf: usize,
    /// Tasks that C is split into, whatever the number of threads, at most 65536; 0: the
    /// library's choice. Of no effect where the built-in kernels share C in their own way.
    pub tasks: usize,
    /// Error that fast products may cause, as a factor of the classical algorithm's in the
    /// maximum norm, expected: 1 for classical products only, INFINITY for no bound,
    /// CATA_ERROR_LEAST for the least error, 0 for the default, which is 4. Not below 1
    /// otherwise, and not NaN. CATA_SCHEME_EXACT takes 15 moduli for 1 and CATA_ERROR_LEAST, 13
    /// from 8 on, and otherwise 14 for A^T A and 15 for A^T B (float: 8, 6, 7 and 8).
    pub error_factor: f64,
    /// Back end of the small products; NULL: the built-in one. Borrowed during the call.
    pub backend: *const cata_backend,
    /// CATA_SCHEME_*.
    pub scheme: i32,
    /// 1: the same bytes on every machine, which takes CATA_SCHEME_EXACT everywhere, slower than
    /// others on CPUs without AMX; the scheme must be that or CATA_SCHEME_AUTO. 0: not asked
    /// for.
    pub reproducible: i32,
    /// 1: thread i of the call stays on the i-th core of the affinity mask (modulo their
    /// number), which is that of the process, as taskset or the binding of mpirun sets it; the
    /// calling thread waits and keeps its mask. Calls at the same time share these threads. 0:
    /// the system moves threads.
    pub pin: i32,
}

/// Longer blocks do not occur, and the planner squares this number.
const MOST_LEAF: usize = 1 << 31;

/// The planner makes a list of the tasks, which must fit into memory.
const MOST_TASKS: usize = 1 << 16;

params!(cata_ata_params, pin: i32);

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_params_init(
    params: *mut cata_ata_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Calls `work` with the options of `params`.
///
/// # Safety
/// `params` is NULL or points to a struct as the header describes it.
pub(super) unsafe fn with_options(
    params: *const cata_ata_params,
    uplo: Uplo,
    work: impl FnOnce(&AtaOptions<'_>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let options = AtaOptions::new().uplo(uplo);
    if params.is_null() {
        return work(&options);
    }
    // SAFETY: clause `passed on` (`read`).
    let params = unsafe { read("params", params) }?;
    at_most("params.leaf", params.leaf, MOST_LEAF)?;
    at_most("params.tasks", params.tasks, MOST_TASKS)?;
    let mut options = options
        .par(par(params.threads))
        .pin(if flag("params.pin", params.pin)? { Pin::Cores } else { Pin::No })
        .scheme(scheme(params.scheme)?)
        .accuracy(accuracy(params.error_factor)?)
        .reproducible(check_reproducible(&params)?)
        .leaf((params.leaf > 0).then_some(params.leaf))
        .tasks((params.tasks > 0).then_some(params.tasks));
    // SAFETY: clause `handles` (`params.backend`); NULL gives the default.
    if let Some(backend) = unsafe { params.backend.as_ref() } {
        options = options.backend(backend.get());
    }
    params.caller().watch(|progress| work(&options.progress(progress)))
}

/// Refuses schemes that differ between machines where the same bytes are asked for, also for
/// products that need no plan.
fn check_reproducible(params: &cata_ata_params) -> Result<bool, Failure> {
    let reproducible = flag("params.reproducible", params.reproducible)?;
    if reproducible && !matches!(params.scheme, CATA_SCHEME_AUTO | CATA_SCHEME_EXACT) {
        let why = "params.reproducible: the scheme must be CATA_SCHEME_EXACT or CATA_SCHEME_AUTO";
        return Err(Failure::new(CATA_ERR_ARGUMENT, why));
    }
    Ok(reproducible)
}

fn at_most(what: &str, value: usize, most: usize) -> Result<(), Failure> {
    if value <= most {
        return Ok(());
    }
    Err(Failure::argument(what, format!("at most {most}"), value))
}

fn scheme(scheme: i32) -> Result<SchemeChoice, Failure> {
    Ok(match scheme {
        CATA_SCHEME_AUTO => SchemeChoice::Auto,
        CATA_SCHEME_CLASSICAL => SchemeChoice::Classical,
        CATA_SCHEME_ATA2 => SchemeChoice::Ata2,
        CATA_SCHEME_WINOGRAD => SchemeChoice::Winograd,
        CATA_SCHEME_RXTX => SchemeChoice::Rxtx,
        CATA_SCHEME_KGP4 => SchemeChoice::Kgp4,
        CATA_SCHEME_KGP3 => SchemeChoice::Kgp3,
        CATA_SCHEME_EXACT => SchemeChoice::Exact,
        CATA_SCHEME_FLOAT => SchemeChoice::Float,
        other => return Err(Failure::argument("params.scheme", "a CATA_SCHEME_* value", other)),
    })
}

/// Returns the accuracy for an error factor.
fn accuracy(error_factor: f64) -> Result<Accuracy, Failure> {
    Ok(if error_factor == 0.0 {
        Accuracy::Default
    } else if error_factor == CATA_ERROR_LEAST {
        Accuracy::Max
    } else if error_factor == 1.0 {
        Accuracy::Classical
    } else if error_factor == f64::INFINITY {
        Accuracy::Fast
    } else if error_factor > 1.0 {
        Accuracy::Bounded(error_factor)
    } else {
        let any = "at least 1, 0 or CATA_ERROR_LEAST (-1)";
        return Err(Failure::argument("params.error_factor", any, error_factor));
    })
}
