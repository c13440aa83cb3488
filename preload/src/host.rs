//! The next library in line that has a symbol.
//!
//! `dlsym(RTLD_NEXT)` finds libraries that are linked or loaded globally. An extension of Python is
//! loaded locally, and its BLAS with it: then every loaded object is searched, in the order of
//! loading. No lock of this library is held meanwhile, because the loader has its own.

use std::ffi::{CStr, CString, c_int, c_void};
use std::ptr::{self, NonNull};
use std::sync::atomic::{AtomicPtr, AtomicU64, Ordering};

/// An address of code.
pub type Code = NonNull<c_void>;

/// Where the next library has a symbol, once that is known.
#[derive(Debug)]
pub struct Next {
    name: &'static CStr,
    /// Null as long as no library has it.
    found: AtomicPtr<c_void>,
    /// Number of objects that had ever been loaded when the last search found nothing.
    fruitless: AtomicU64,
}

impl Next {
    /// Creates the search for the symbol `name`, which this library has too.
    pub const fn new(name: &'static CStr) -> Self {
        Self { name, found: AtomicPtr::new(ptr::null_mut()), fruitless: AtomicU64::new(0) }
    }

    /// Returns the address, or `None` when no object has the symbol. An address that was found
    /// stays valid. A symbol that was not found is searched again after another object was loaded.
    pub fn get(&self) -> Option<Code> {
        let found = NonNull::new(self.found.load(Ordering::Acquire));
        if found.is_some() {
            return found;
        }
        let loaded = objects_loaded();
        if loaded == self.fruitless.load(Ordering::Relaxed) {
            return None;
        }
        let found = find(self.name);
        match found {
            Some(code) => self.found.store(code.as_ptr(), Ordering::Release),
            None => self.fruitless.store(loaded, Ordering::Relaxed),
        }
        found
    }
}

/// Returns the file that contains `code`, as the loader knows it.
pub fn file_of(code: Code) -> String {
    match object_of(code) {
        // SAFETY: the string is the loader's own, not NULL, and lives as long as the object, which
        // contains symbols that are in use.
        Some(info) if !info.dli_fname.is_null() => unsafe {
            CStr::from_ptr(info.dli_fname).to_string_lossy().into_owned()
        },
        _ => String::new(),
    }
}

fn object_of(code: Code) -> Option<libc::Dl_info> {
    let mut info = libc::Dl_info {
        dli_fname: ptr::null(),
        dli_fbase: ptr::null_mut(),
        dli_sname: ptr::null(),
        dli_saddr: ptr::null_mut(),
    };
    // SAFETY: any address may be asked for; the answer is written to `info`.
    (unsafe { libc::dladdr(code.as_ptr(), &raw mut info) } != 0).then_some(info)
}

/// Returns whether `code` is in this library.
fn is_ours(code: Code) -> bool {
    let here = NonNull::new(find as fn(&'static CStr) -> Option<Code> as *mut c_void);
    let base = |code| object_of(code).map(|info| info.dli_fbase);
    here.is_some_and(|here| base(here) == base(code))
}

fn find(name: &'static CStr) -> Option<Code> {
    // SAFETY: `name` is a `CStr`, which ends with a NUL; any name may be asked for.
    let next = NonNull::new(unsafe { libc::dlsym(libc::RTLD_NEXT, name.as_ptr()) });
    next.filter(|&code| !is_ours(code))
        .or_else(|| object_names().iter().find_map(|object| in_object(object, name)))
}

/// Returns the symbol in a loaded object, or in what that object was linked with.
fn in_object(object: &CStr, name: &CStr) -> Option<Code> {
    // SAFETY: both are a `CStr`, which ends with a NUL; with this flag nothing is loaded, so no
    // code runs.
    unsafe {
        let handle = libc::dlopen(object.as_ptr(), libc::RTLD_NOLOAD | libc::RTLD_LAZY);
        if handle.is_null() {
            return None;
        }
        let code = NonNull::new(libc::dlsym(handle, name.as_ptr())).filter(|&code| !is_ours(code));
        // The handle of the library whose symbol is used is kept, so that the library stays loaded.
        if code.is_none() {
            libc::dlclose(handle);
        }
        code
    }
}

/// Calls `visit` for each loaded object, as long as it returns `true`.
fn each_object(visit: &mut dyn FnMut(&libc::dl_phdr_info) -> bool) {
    unsafe extern "C" fn step(
        info: *mut libc::dl_phdr_info,
        _size: libc::size_t,
        data: *mut c_void,
    ) -> c_int {
        // SAFETY: `data` is what is passed below; the loader's record is valid during this call.
        let go_on =
            unsafe { (*data.cast::<&mut dyn FnMut(&libc::dl_phdr_info) -> bool>())(&*info) };
        c_int::from(!go_on)
    }
    let mut visit = visit;
    // SAFETY: `step` takes its data for what this is, which lives until the end of the call.
    unsafe { libc::dl_iterate_phdr(Some(step), (&raw mut visit).cast()) };
}

/// Returns the number of objects that have been loaded since the program began.
fn objects_loaded() -> u64 {
    let mut loaded = 0;
    each_object(&mut |info| {
        loaded = info.dlpi_adds;
        false
    });
    loaded
}

/// Returns the names of all loaded objects but the program, in the order of loading.
fn object_names() -> Vec<CString> {
    let mut names = Vec::new();
    each_object(&mut |info| {
        if !info.dlpi_name.is_null() {
            // SAFETY: the loader's own string, which lives during this call.
            let name = unsafe { CStr::from_ptr(info.dlpi_name) };
            if !name.is_empty() {
                names.push(name.to_owned());
            }
        }
        true
    });
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_symbol_of_a_loaded_library_is_found_and_one_of_none_is_not() {
        let known = Next::new(c"strlen");
        let code = known.get().unwrap();
        assert!(!is_ours(code));
        assert!(file_of(code).contains("libc"), "{}", file_of(code));
        assert_eq!(known.get(), Some(code));
        assert_eq!(Next::new(c"no_such_symbol_anywhere").get(), None);
    }

    #[test]
    fn objects_have_names_and_are_counted() {
        let names = object_names();
        assert!(names.iter().any(|name| name.to_string_lossy().contains("libc.so")), "{names:?}");
        assert!(objects_loaded() as usize >= names.len());
    }
}
