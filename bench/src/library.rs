//! Rival libraries: finds them, and calls their `syrk` and `gemm` directly.

use std::ffi::{CStr, c_char, c_int};
use std::path::{Path, PathBuf};

use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};

use crate::Result;

/// `cblas_?syrk` with 32-bit integers.
pub type Syrk<T> = unsafe extern "C" fn(
    order: c_int,
    uplo: c_int,
    trans: c_int,
    n: c_int,
    k: c_int,
    alpha: T,
    a: *const T,
    lda: c_int,
    beta: T,
    c: *mut T,
    ldc: c_int,
);

/// `cblas_?gemm` with 32-bit integers.
pub type Gemm<T> = unsafe extern "C" fn(
    order: c_int,
    trans_a: c_int,
    trans_b: c_int,
    m: c_int,
    n: c_int,
    k: c_int,
    alpha: T,
    a: *const T,
    lda: c_int,
    b: *const T,
    ldb: c_int,
    beta: T,
    c: *mut T,
    ldc: c_int,
);

/// `cblas_?gemm_batch_strided` with 32-bit integers: `count` products of one shape, whose operands
/// follow each other at fixed distances.
pub type GemmBatch<T> = unsafe extern "C" fn(
    order: c_int,
    trans_a: c_int,
    trans_b: c_int,
    m: c_int,
    n: c_int,
    k: c_int,
    alpha: T,
    a: *const T,
    lda: c_int,
    stride_a: c_int,
    b: *const T,
    ldb: c_int,
    stride_b: c_int,
    beta: T,
    c: *mut T,
    ldc: c_int,
    stride_c: c_int,
    count: c_int,
);

/// Resolves every symbol in the library before the process: the global symbols of MKL must not end
/// up inside another BLAS.
#[cfg(target_os = "linux")]
const RTLD_DEEPBIND: c_int = 8;
#[cfg(not(target_os = "linux"))]
const RTLD_DEEPBIND: c_int = 0;

#[derive(Clone, Copy)]
enum SetThreads {
    Int(unsafe extern "C" fn(c_int)),
    /// BLIS counts in `dim_t`.
    Dim(unsafe extern "C" fn(i64)),
}

/// A loaded CBLAS library.
pub struct Rival {
    /// `mkl`, `openblas`, `blis`, or the name that the user gave.
    pub name: String,
    /// Its file.
    pub path: PathBuf,
    /// The version that it reports.
    pub version: String,
    /// `cblas_dsyrk`.
    pub dsyrk: Syrk<f64>,
    /// `cblas_ssyrk`.
    pub ssyrk: Syrk<f32>,
    /// `cblas_dgemm`.
    pub dgemm: Gemm<f64>,
    /// `cblas_sgemm`.
    pub sgemm: Gemm<f32>,
    /// `cblas_dgemm_batch_strided`, which not every library has.
    pub dgemm_batch: Option<GemmBatch<f64>>,
    /// `cblas_sgemm_batch_strided`.
    pub sgemm_batch: Option<GemmBatch<f32>>,
    set_threads: SetThreads,
    _library: Library,
}

/// Returns the file of the library `name`: in `folder` as `scripts/rivals` fills it, otherwise that
/// of the system.
pub fn find(name: &str, folder: &Path) -> Option<PathBuf> {
    let system = Path::new("/usr/lib/x86_64-linux-gnu");
    match name {
        "mkl" => first_starting(&folder.join("lib"), "libmkl_rt.so")
            .or_else(|| first_starting(system, "libmkl_rt.so")),
        "openblas" => std::fs::read_dir(folder.join("lib"))
            .ok()?
            .flatten()
            .map(|e| e.path().join("site-packages/scipy_openblas32/lib/libscipy_openblas.so"))
            .find(|p| p.exists())
            .or_else(|| first_starting(&system.join("openblas-pthread"), "libopenblas.so")),
        "blis" => [folder.join("usr/lib/x86_64-linux-gnu"), system.into()]
            .iter()
            .find_map(|place| first_starting(&place.join("blis-openmp"), "libblis.so")),
        _ => None,
    }
}

fn first_starting(folder: &Path, prefix: &str) -> Option<PathBuf> {
    let mut found: Vec<_> = std::fs::read_dir(folder)
        .ok()?
        .flatten()
        .map(|e| e.path())
        .filter(|p| p.file_name().is_some_and(|f| f.to_string_lossy().starts_with(prefix)))
        .collect();
    found.sort();
    found.into_iter().next()
}

impl Rival {
    /// Loads the library at `path`.
    ///
    /// # Errors
    /// When the library can't be loaded or lacks a symbol.
    pub fn load(name: &str, path: &Path) -> Result<Self> {
        // libmkl_rt finds its other libraries through the process, so it can't be bound deeply.
        let deep = if name == "mkl" { 0 } else { RTLD_DEEPBIND };
        // SAFETY: runs the library's initializers; the user named it as a BLAS to be trusted.
        let library = unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL | deep) }?;
        // SAFETY: the signatures of the CBLAS standard with 32-bit integers, and the documented
        // ones of each library's thread control; the library is stored beside the pointers.
        unsafe {
            let prefix = ["", "scipy_"]
                .into_iter()
                .find(|p| symbol::<Syrk<f64>>(&library, &format!("{p}cblas_dsyrk")).is_some())
                .ok_or_else(|| format!("{}: has no cblas_dsyrk", path.display()))?;
            let set_threads = ["MKL_Set_Num_Threads", &format!("{prefix}openblas_set_num_threads")]
                .iter()
                .find_map(|s| symbol(&library, s).map(SetThreads::Int))
                .or_else(|| symbol(&library, "bli_thread_set_num_threads").map(SetThreads::Dim))
                .ok_or_else(|| format!("{}: has no known thread control", path.display()))?;
            let missing = |s: &str| format!("{}: no {s}", path.display());
            let [dsyrk, ssyrk, dgemm, sgemm] =
                ["dsyrk", "ssyrk", "dgemm", "sgemm"].map(|s| format!("{prefix}cblas_{s}"));
            Ok(Self {
                name: name.into(),
                path: path.into(),
                version: version(&library, prefix),
                dsyrk: symbol(&library, &dsyrk).ok_or_else(|| missing(&dsyrk))?,
                ssyrk: symbol(&library, &ssyrk).ok_or_else(|| missing(&ssyrk))?,
                dgemm: symbol(&library, &dgemm).ok_or_else(|| missing(&dgemm))?,
                sgemm: symbol(&library, &sgemm).ok_or_else(|| missing(&sgemm))?,
                dgemm_batch: symbol(&library, &format!("{prefix}cblas_dgemm_batch_strided")),
                sgemm_batch: symbol(&library, &format!("{prefix}cblas_sgemm_batch_strided")),
                set_threads,
                _library: library,
            })
        }
    }

    /// Sets the threads of the library's next calls.
    pub fn set_threads(&self, threads: usize) {
        // SAFETY: the symbol has been found with this signature, and takes any positive count.
        unsafe {
            match self.set_threads {
                SetThreads::Int(set) => set(threads as c_int),
                SetThreads::Dim(set) => set(threads as i64),
            }
        }
    }
}

/// Returns the symbol `name` as a `T`.
///
/// # Safety
/// `T` must be the pointer type of that symbol.
unsafe fn symbol<T: Copy>(library: &Library, name: &str) -> Option<T> {
    // SAFETY: `T` is the pointer type of the symbol, by the contract; it is only copied.
    unsafe { library.get::<T>(name.as_bytes()) }.ok().map(|s| *s)
}

fn version(library: &Library, prefix: &str) -> String {
    type Write = unsafe extern "C" fn(*mut c_char, c_int);
    type Text = unsafe extern "C" fn() -> *const c_char;
    // SAFETY: the documented signatures; MKL writes at most the length it is told; the other two
    // return static C strings.
    unsafe {
        if let Some(write) = symbol::<Write>(library, "MKL_Get_Version_String") {
            let mut text = [0 as c_char; 256];
            write(text.as_mut_ptr(), text.len() as c_int - 1);
            return CStr::from_ptr(text.as_ptr()).to_string_lossy().trim().to_owned();
        }
        let openblas = format!("{prefix}openblas_get_config");
        [openblas.as_str(), "bli_info_get_version_str"]
            .iter()
            .find_map(|s| symbol::<Text>(library, s))
            .map(|text| CStr::from_ptr(text()).to_string_lossy().trim().to_owned())
            .unwrap_or_default()
    }
}
