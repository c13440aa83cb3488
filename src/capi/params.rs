use std::ffi::c_void;
use std::mem::{MaybeUninit, offset_of};
use std::ops::ControlFlow;

use super::backend::cata_backend;
use super::status::{CATA_ERR_ARGUMENT, CATA_ERR_UNSUPPORTED, Failure, cata_status};
use super::{boundary::boundary, pointer};
use crate::base::{Par, Pin, Progress};
use crate::{Accuracy, AtaOptions, SchemeChoice, Uplo};

/// Whatever is expected to be fastest within the accuracy asked for.
pub const CATA_SCHEME_AUTO: i32 = 0;
/// No fast products: blocks over the back end.
pub const CATA_SCHEME_CLASSICAL: i32 = 1;
/// AtA over Strassen's algorithm, 2 x 2 recursion down to the cache.
pub const CATA_SCHEME_ATA2: i32 = 2;
/// 2 x 2 split over Winograd's variant of Strassen's algorithm.
pub const CATA_SCHEME_WINOGRAD: i32 = 3;
/// RXTX (4 x 4 blocks) over Winograd's variant.
pub const CATA_SCHEME_RXTX: i32 = 4;
/// The sparse 4 x 4 scheme of Khoruzhii, Gelss and Pokutta over Winograd's variant.
pub const CATA_SCHEME_KGP4: i32 = 5;
/// Their 3 x 3 scheme over Winograd's variant.
pub const CATA_SCHEME_KGP3: i32 = 6;
/// Integer products modulo small primes: nothing is rounded but the columns, to about 2^-54 of their
/// norms (float: 2^-27), and the result.
pub const CATA_SCHEME_EXACT: i32 = 7;
/// `scheme`: as CATA_SCHEME_AUTO, but never CATA_SCHEME_EXACT.
pub const CATA_SCHEME_FLOAT: i32 = 8;

/// `error_factor`: the least error. With CATA_SCHEME_AUTO that is CATA_SCHEME_EXACT on every machine,
/// however slow it is there; other schemes are as with 1.
pub const CATA_ERROR_LEAST: f64 = -1.0;

/// A progress callback: `fraction` of the work done, in [0, 1]. Returns 0 to go on; anything else
/// asks to stop soon, and the call then returns CATA_ERR_CANCELLED.
///
/// It is called from any thread that works for the call, one call at a time: each begins after the
/// one before it has returned, and sees what that has written. No thread waits for it, so it may be
/// slow, and it may call this library. It must not leave by longjmp or a C++ exception.
pub type cata_progress = Option<extern "C" fn(fraction: f64, user: *mut c_void) -> i32>;

/// How a product is computed. Every field but the first is 0 (NULL) by default, so that
/// `cata_ata_params params = {.struct_size = sizeof params};` does what cata_ata_params_init does.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_ata_params {
    /// sizeof(cata_ata_params) as the caller was compiled with. Later versions add fields at the
    /// end; one that this library does not know must be 0.
    pub struct_size: usize,
    /// Threads, at most; 0: all cores of the affinity mask of the process. The result is the same,
    /// bit for bit, for every value.
    pub threads: usize,
    /// Smallest block side of the recursion, in elements, at most 2^31; 0: the library's
    /// choice.
    pub leaf: usize,
    /// Tasks that C is split into, whatever the number of threads, at most 65536; 0: the
    /// library's choice. Of no effect where the built-in kernels share C in their own way.
    pub tasks: usize,
    /// Error that fast products may cause, as a factor of the classical algorithm's in the maximum
    /// norm, expected: 1 for classical products only, INFINITY for no bound, CATA_ERROR_LEAST for the
    /// least error, 0 for the default, which is 4. Not below 1 otherwise, and not NaN.
    /// CATA_SCHEME_EXACT takes 15 moduli for 1 and CATA_ERROR_LEAST, 13 from 8 on, and 14 otherwise
    /// (float: 8, 6 and 7).
    pub error_factor: f64,
    /// What computes the small products; NULL: the built-in one. Borrowed during the call.
    pub backend: *const cata_backend,
    /// Told of progress; NULL: nobody.
    pub progress: cata_progress,
    /// Handed to `progress` as it is; may be NULL.
    pub progress_user: *mut c_void,
    /// CATA_SCHEME_*.
    pub scheme: i32,
    /// 1: the same bytes on every machine, which takes CATA_SCHEME_EXACT everywhere, slower than others
    /// on CPUs without AMX; the scheme must be that or CATA_SCHEME_AUTO. 0: not asked for.
    pub reproducible: i32,
    /// 1: thread i of the call stays on the i-th core of the affinity mask (modulo their number), which
    /// is that of the process, as taskset or the binding of mpirun sets it; the calling thread waits and
    /// keeps its mask. Calls at the same time share these threads. 0: the system moves threads.
    pub pin: i32,
}

/// More than any version will ever have: an uninitialised struct_size is caught, not followed.
const LARGEST_SIZE: usize = 4096;

/// Longer blocks than this don't occur, and the planner squares it.
const MOST_LEAF: usize = 1 << 31;

/// The planner makes a list of the tasks.
const MOST_TASKS: usize = 1 << 16;

/// Fills a parameter struct with the defaults.
///
/// `params`: one struct, not NULL; `struct_size` bytes are written.
/// `struct_size`: sizeof(cata_ata_params).
/// Returns CATA_OK, CATA_ERR_NULL, or CATA_ERR_ARGUMENT for a size that no version has.
///
/// Thread-safe.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_ata_params_init(
    params: *mut cata_ata_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: the promises are the same.
    unsafe { init(params, struct_size) }
}

/// A parameter struct of the ABI: `repr(C)`, struct_size first, and all fields may be 0.
pub(super) trait Versioned: Copy {
    /// Its name in the header.
    const NAME: &'static str;
    /// Size of its first published version, whose fields are always there.
    const FIRST_SIZE: usize;
}

impl Versioned for cata_ata_params {
    const NAME: &'static str = "cata_ata_params";
    const FIRST_SIZE: usize = offset_of!(Self, pin) + size_of::<i32>();
}

/// `cata_*_params_init`.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
pub(super) unsafe fn init<T: Versioned>(params: *mut T, struct_size: usize) -> cata_status {
    boundary(|| {
        check_struct_size::<T>("params", struct_size)?;
        let params = pointer::checked("params", params, 1)?.cast_mut();
        // SAFETY: not NULL, aligned, and struct_size writable bytes by the caller's promise; the
        // size itself comes first. All fields may be 0, also those that only the caller knows.
        unsafe {
            params.cast::<u8>().write_bytes(0, struct_size);
            params.cast::<usize>().write(struct_size);
        }
        Ok(())
    })
}

fn check_struct_size<T: Versioned>(what: &str, size: usize) -> Result<(), Failure> {
    if (T::FIRST_SIZE..=LARGEST_SIZE).contains(&size) {
        return Ok(());
    }
    let why = format!(
        "{what}.struct_size: must be sizeof({}), {} in this version, is {size}",
        T::NAME,
        size_of::<T>()
    );
    Err(Failure::new(CATA_ERR_ARGUMENT, why))
}

/// Reads a struct of the caller's version: the fields that both know; the others of ours are 0, and
/// the others of the caller's must be.
///
/// # Safety
/// `params` points to as many readable bytes as its `struct_size` says.
pub(super) unsafe fn read<T: Versioned>(params: *const T) -> Result<T, Failure> {
    let params = pointer::checked("params", params, 1)?;
    let mut known = MaybeUninit::<T>::zeroed();
    // SAFETY: struct_size comes first in every version, and the bytes up to it are the caller's
    // promise; no more of them are touched. All fields may be 0.
    unsafe {
        let size = params.cast::<usize>().read();
        check_struct_size::<T>("params", size)?;
        let shared = size.min(size_of::<T>());
        let bytes = params.cast::<u8>();
        if std::slice::from_raw_parts(bytes.add(shared), size - shared).iter().any(|&b| b != 0) {
            let why = "params: a field that this version of the library does not know is set";
            return Err(Failure::new(CATA_ERR_UNSUPPORTED, why));
        }
        bytes.copy_to_nonoverlapping(known.as_mut_ptr().cast(), shared);
        Ok(known.assume_init())
    }
}

/// Writes a struct of the caller's version, but for its `struct_size`: the fields that both know,
/// and 0 into those that only the caller knows.
///
/// # Safety
/// `place` is NULL or points to as many writable bytes as its `struct_size` says.
#[cfg(any(feature = "mpi", test))]
pub(super) unsafe fn write<T: Versioned>(
    what: &str,
    place: *mut T,
    value: &T,
) -> Result<(), Failure> {
    let place = pointer::checked(what, place, 1)?.cast_mut();
    // SAFETY: as in `read`.
    unsafe {
        let size = place.cast::<usize>().read();
        check_struct_size::<T>(what, size)?;
        let (from, to) = ((&raw const *value).cast::<u8>(), place.cast::<u8>());
        to.write_bytes(0, size);
        from.copy_to_nonoverlapping(to, size.min(size_of::<T>()));
        place.cast::<usize>().write(size);
    }
    Ok(())
}

/// The address that a progress callback asked for.
struct User(*mut c_void);

// SAFETY: only handed to the callback, which the header tells to expect any thread; calls never
// overlap and are ordered, as `Progress` promises.
unsafe impl Sync for User {}

impl User {
    fn get(&self) -> *mut c_void {
        self.0
    }
}

/// Calls `work` with the options that `params` stands for.
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
    // SAFETY: the caller's promise.
    let params = unsafe { read(params) }?;
    at_most("params.leaf", params.leaf, MOST_LEAF)?;
    at_most("params.tasks", params.tasks, MOST_TASKS)?;
    let mut options = options
        .par(par(params.threads))
        .pin(if flag("params.pin", params.pin)? { Pin::Cores } else { Pin::No })
        .scheme(scheme(params.scheme)?)
        .accuracy(accuracy(params.error_factor))
        .reproducible(flag("params.reproducible", params.reproducible)?)
        .leaf((params.leaf > 0).then_some(params.leaf))
        .tasks((params.tasks > 0).then_some(params.tasks));
    // SAFETY: NULL or a live back end, as the header asks.
    if let Some(backend) = unsafe { params.backend.as_ref() } {
        options = options.backend(backend.get());
    }
    let watch = watcher(params.progress, params.progress_user);
    let progress = watch.as_ref().map_or(Progress::none(), Progress::from);
    work(&options.progress(progress))
}

/// A callback of the ABI as one of ours.
pub(super) fn watcher(
    progress: cata_progress,
    user: *mut c_void,
) -> Option<impl Fn(f64) -> ControlFlow<()> + Sync> {
    let (callback, user) = (progress?, User(user));
    Some(move |fraction| match callback(fraction, user.get()) {
        0 => ControlFlow::Continue(()),
        _ => ControlFlow::Break(()),
    })
}

/// Threads, of a field of that name: 0 stands for all.
pub(super) fn par(threads: usize) -> Par {
    if threads == 0 { Par::all() } else { Par::Threads(threads) }
}

fn at_most(what: &str, value: usize, most: usize) -> Result<(), Failure> {
    if value <= most {
        return Ok(());
    }
    Err(Failure::new(CATA_ERR_ARGUMENT, format!("{what}: must be at most {most}, is {value}")))
}

pub(super) fn flag(what: &str, value: i32) -> Result<bool, Failure> {
    match value {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(Failure::new(CATA_ERR_ARGUMENT, format!("{what}: must be 0 or 1, is {value}"))),
    }
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
        other => {
            let why = format!("params.scheme: must be a CATA_SCHEME_* value, is {other}");
            return Err(Failure::new(CATA_ERR_ARGUMENT, why));
        }
    })
}

/// The planner refuses what is out of range.
fn accuracy(error_factor: f64) -> Accuracy {
    if error_factor == 0.0 {
        Accuracy::Default
    } else if error_factor == CATA_ERROR_LEAST {
        Accuracy::Max
    } else if error_factor == 1.0 {
        Accuracy::Classical
    } else if error_factor == f64::INFINITY {
        Accuracy::Fast
    } else {
        Accuracy::Bounded(error_factor)
    }
}

#[cfg(test)]
mod tests {
    use super::super::status::CATA_OK;
    use super::*;

    /// A struct in its second version; the first one ended with `threads`.
    #[repr(C)]
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Second {
        struct_size: usize,
        threads: usize,
        added: f64,
    }

    impl Versioned for Second {
        const NAME: &'static str = "second";
        const FIRST_SIZE: usize = offset_of!(Self, added);
    }

    /// As many words as the caller's version has; what is read or written beyond is found by Miri
    /// and AddressSanitizer.
    fn of_version(words: &[usize]) -> Box<[usize]> {
        words.into()
    }

    fn read_words(words: &[usize]) -> Result<Second, Failure> {
        let words = of_version(words);
        // SAFETY: as many words as the first one says, or it is refused.
        unsafe { read(words.as_ptr().cast::<Second>()) }
    }

    #[test]
    fn an_older_struct_has_zeros_for_later_fields() {
        let second = Second { struct_size: 16, threads: 3, added: 0.0 };
        assert_eq!(read_words(&[16, 3]).unwrap(), second);
    }

    #[test]
    fn a_newer_struct_is_read_unless_an_unknown_field_is_set() {
        let added = 2.5_f64.to_bits() as usize;
        let second = Second { struct_size: 40, threads: 3, added: 2.5 };
        assert_eq!(read_words(&[40, 3, added, 0, 0]).unwrap(), second);
        assert_eq!(read_words(&[40, 3, added, 0, 1]).unwrap_err().status, CATA_ERR_UNSUPPORTED);
    }

    #[test]
    fn sizes_that_no_version_has_are_refused() {
        for size in [0, 8, 15, LARGEST_SIZE + 1, usize::MAX] {
            let failure = read_words(&[size]).unwrap_err();
            assert_eq!(failure.status, CATA_ERR_ARGUMENT);
            assert!(failure.message.contains("params.struct_size"), "{}", failure.message);
        }
    }

    #[test]
    fn results_are_written_as_far_as_the_caller_knows_them() {
        let value = Second { struct_size: 0, threads: 7, added: 2.5 };
        let added = 2.5_f64.to_bits() as usize;
        let cases: [(&[usize], &[usize]); 3] = [
            (&[16, 1], &[16, 7]),
            (&[24, 1, 1], &[24, 7, added]),
            (&[40, 1, 1, 1, 1], &[40, 7, added, 0, 0]),
        ];
        for (before, after) in cases {
            let mut words = of_version(before);
            // SAFETY: as many words as the first one says.
            unsafe { write("second", words.as_mut_ptr().cast::<Second>(), &value) }.unwrap();
            assert_eq!(*words, *after);
        }
    }

    #[test]
    fn defaults_fill_the_version_of_the_caller() {
        for (words, size) in [(2, 16), (3, 24), (5, 40)] {
            let mut place = of_version(&vec![9; words]);
            // SAFETY: `size` bytes.
            assert_eq!(unsafe { init(place.as_mut_ptr().cast::<Second>(), size) }, CATA_OK);
            assert_eq!((place[0], place[1..].iter().sum::<usize>()), (size, 0));
        }
    }
}
