//! Parameter structs: any version of them is read and written.

use std::mem::MaybeUninit;

use super::boundary::boundary;
use super::pointer;
use super::progress::Caller;
use super::regions::{self, Region};
use super::status::{CATA_ERR_UNSUPPORTED, Failure, cata_status};
#[cfg(feature = "chapters")]
use catamaran::base::{Par, Progress};

/// More than any version will ever have, to catch an uninitialized struct_size.
const LARGEST_SIZE: usize = 4096;

/// A parameter struct of the ABI: `repr(C)`, struct_size first, and all fields may be 0.
pub(super) trait Versioned: Copy {
    /// The name of the struct in the header.
    const NAME: &'static str;
    /// Size of the first published version, whose fields are always there.
    const FIRST_SIZE: usize;
}

/// Implements [`Versioned`] for a struct whose first version ended with the field `$last`.
macro_rules! versioned {
    ($name:ident, $last:ident: $kind:ty) => {
        impl $crate::params::Versioned for $name {
            const NAME: &'static str = stringify!($name);
            const FIRST_SIZE: usize = std::mem::offset_of!(Self, $last) + size_of::<$kind>();
        }
    };
}
pub(super) use versioned;

/// The parameters of a call, which begin with threads and a progress callback.
pub(super) trait Params: Versioned {
    /// Returns the callback, and what it gets.
    fn caller(&self) -> Caller;

    /// Returns the threads.
    #[cfg(feature = "chapters")]
    fn par(&self) -> Par;
}

/// Implements [`Params`] as [`versioned`] implements [`Versioned`].
macro_rules! params {
    ($name:ident, $last:ident: $kind:ty) => {
        $crate::params::versioned!($name, $last: $kind);

        impl $crate::params::Params for $name {
            fn caller(&self) -> $crate::progress::Caller {
                $crate::progress::Caller::new(self.progress, self.progress_user)
            }

            #[cfg(feature = "chapters")]
            fn par(&self) -> catamaran::Par {
                $crate::progress::par(self.threads)
            }
        }
    };
}
pub(super) use params;

/// Returns what `work` returns for the parameters of the caller, zeros for NULL. Every call of the
/// library in it asks their callback whether to stop.
///
/// # Safety
/// `params` is NULL or points to a struct as the header describes it.
#[cfg(feature = "chapters")]
pub(super) unsafe fn with_params<T: Params, R>(
    params: *const T,
    work: impl FnOnce(&T, Progress<'_>) -> Result<R, Failure>,
) -> Result<R, Failure> {
    // SAFETY: clause `structs` (`params`).
    let params = unsafe { read_or_zeros("params", params) }?;
    params.caller().watch(|progress| work(&params, progress))
}

/// Implements `cata_*_params_init`.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
pub(super) unsafe fn init<T: Versioned>(params: *mut T, struct_size: usize) -> cata_status {
    boundary(|| {
        check_struct_size::<T>("params", struct_size)?;
        let params = pointer::checked("params", params, 1)?.cast_mut();
        // SAFETY: `checked` has excluded NULL and checked the alignment, `check_struct_size` that
        // the size holds at least its own field; clause `structs` for so many writable bytes. All
        // fields may be 0, also those that only the caller knows.
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
    let right = format!("sizeof({}), {} in this version", T::NAME, size_of::<T>());
    Err(Failure::argument(&format!("{what}.struct_size"), right, size))
}

/// Reads a struct of the caller's version: the fields that both versions have. Fields that only the
/// library has become 0, and those that only the caller has must be 0.
///
/// # Safety
/// `params` points to as many readable bytes as its `struct_size` says.
pub(super) unsafe fn read<T: Versioned>(
    what: &'static str,
    params: *const T,
) -> Result<T, Failure> {
    // SAFETY: clause `passed on` (`read_noted`).
    unsafe { read_noted(what, params, false) }
}

/// Reads a struct as [`read`] does, and says whether the call writes it.
///
/// # Safety
/// As for [`read`].
unsafe fn read_noted<T: Versioned>(
    what: &'static str,
    params: *const T,
    written: bool,
) -> Result<T, Failure> {
    let params = pointer::checked(what, params, 1)?;
    let mut known = MaybeUninit::<T>::zeroed();
    // SAFETY: `checked` has excluded NULL and checked the alignment; clause `structs`:
    // `struct_size` comes first in every version, and no bytes beyond it are touched. All fields
    // may be 0.
    unsafe {
        let size = params.cast::<usize>().read();
        check_struct_size::<T>(what, size)?;
        regions::add(Region::bytes(what, params.addr(), size, written))?;
        let shared = size.min(size_of::<T>());
        let bytes = params.cast::<u8>();
        if std::slice::from_raw_parts(bytes.add(shared), size - shared).iter().any(|&b| b != 0) {
            let why =
                format!("{what}: a field that this version of the library does not know is set");
            return Err(Failure::new(CATA_ERR_UNSUPPORTED, why));
        }
        bytes.copy_to_nonoverlapping(known.as_mut_ptr().cast(), shared);
        Ok(known.assume_init())
    }
}

/// Returns a struct of the caller, or one of zeros for NULL.
///
/// # Safety
/// `params` is NULL or as for [`read`].
#[cfg(feature = "chapters")]
pub(super) unsafe fn read_or_zeros<T: Versioned>(
    what: &'static str,
    params: *const T,
) -> Result<T, Failure> {
    if params.is_null() {
        // SAFETY: all fields of such a struct may be 0.
        return Ok(unsafe { MaybeUninit::zeroed().assume_init() });
    }
    // SAFETY: clause `passed on` (`read`).
    unsafe { read(what, params) }
}

/// Returns a struct of results of the caller, whose fields the call writes, or one of zeros for
/// NULL.
///
/// # Safety
/// `results` is NULL or as for [`read`].
#[cfg(feature = "chapters")]
pub(super) unsafe fn results<T: Versioned>(
    what: &'static str,
    results: *mut T,
) -> Result<T, Failure> {
    if results.is_null() {
        // SAFETY: all fields of such a struct may be 0.
        return Ok(unsafe { MaybeUninit::zeroed().assume_init() });
    }
    // SAFETY: clause `passed on` (`read_noted`).
    unsafe { read_noted(what, results, true) }
}

/// Writes a struct of the caller's version, but for its `struct_size`: the fields that both
/// know, and 0 into those that only the caller knows.
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
    // SAFETY: the checks are those of `read`, clause `structs` for the writable bytes; no more of
    // them than both versions have are touched.
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

/// Returns the value of a field, or the default that 0 stands for.
#[cfg(feature = "chapters")]
pub(super) fn or_default<T: Default + PartialEq>(value: T, default: T) -> T {
    if value == T::default() { default } else { value }
}

/// Returns the value of a field or an argument that is 0 or 1.
pub(super) fn flag(what: &str, value: i32) -> Result<bool, Failure> {
    match value {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(Failure::argument(what, "0 or 1", value)),
    }
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::super::status::{CATA_ERR_ARGUMENT, CATA_OK};
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

    /// Returns as many words as the caller's version has; Miri and AddressSanitizer find reads and
    /// writes beyond them.
    fn of_version(words: &[usize]) -> Box<[usize]> {
        words.into()
    }

    fn read_words(words: &[usize]) -> Result<Second, Failure> {
        let words = of_version(words);
        // SAFETY: as many words as the first one says, or it is refused.
        unsafe { read("params", words.as_ptr().cast::<Second>()) }
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
