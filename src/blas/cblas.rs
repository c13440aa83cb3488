use std::ffi::{CStr, c_char, c_int};
use std::mem::ManuallyDrop;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use faer::prelude::Reborrow;
use faer::{MatMut, MatRef};
use libloading::Library;

use super::backend::{Backend, Rates, ThreadGuard};
use super::kernels::Kernels;
use super::native::Native;
use super::triangle::gemmt_by_gemm;
use crate::base::{Error, Real, Result};
use crate::kernel::packed;

// The values of the CBLAS enumerations (BLAST forum standard, annex C.1).
const ROW_MAJOR: c_int = 101;
const COL_MAJOR: c_int = 102;
const NO_TRANS: c_int = 111;
const TRANS: c_int = 112;
const LOWER: c_int = 122;

type Gemm<T> = unsafe extern "C" fn(
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
type Syrk<T> = unsafe extern "C" fn(
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
type Dot =
    unsafe extern "C" fn(n: c_int, x: *const f64, inc_x: c_int, y: *const f64, inc_y: c_int) -> f64;

/// How a library is limited to one thread.
#[derive(Clone, Copy)]
enum Threading {
    /// MKL: a count per calling thread, returns the previous one (0 = none set).
    MklLocal(unsafe extern "C" fn(c_int) -> c_int),
    /// OpenBLAS: one count for the process.
    Openblas { get: unsafe extern "C" fn() -> c_int, set: unsafe extern "C" fn(c_int) },
    /// BLIS: one count for the process, as a 64-bit `dim_t`.
    Blis { get: unsafe extern "C" fn() -> i64, set: unsafe extern "C" fn(i64) },
    /// No known control.
    Unknown,
}

/// A library with the CBLAS interface and 32-bit integers.
pub(super) struct Cblas {
    name: String,
    description: String,
    dgemm: Gemm<f64>,
    sgemm: Gemm<f32>,
    dsyrk: Syrk<f64>,
    ssyrk: Syrk<f32>,
    threading: Threading,
    /// Calls that hold a process-wide count at one, and the count to restore after the last.
    holders: Arc<Mutex<(usize, i64)>>,
}

impl Cblas {
    pub(super) fn load(path: &Path) -> Result<Self> {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let refuse = |why: String| Error::Backend { name: name.clone(), why, cause: None };
        // SAFETY: runs the library's initializers; the caller named it as a BLAS to be trusted.
        let library = unsafe { Library::new(path) }.map_err(|e| {
            // The loader's own message is in the source.
            let said = std::error::Error::source(&e).map(ToString::to_string);
            let why = said.unwrap_or_else(|| e.to_string());
            Error::Backend { name: name.clone(), why, cause: Some(e.into()) }
        })?;
        // Never unloaded: the library may have threads of its own, and guards outlive the back end.
        let library = ManuallyDrop::new(library);
        let prefix = ["", "scipy_"]
            .into_iter()
            .find(|p| {
                // SAFETY: the symbol is only looked for, not called.
                unsafe { symbol::<Gemm<f64>>(&library, &format!("{p}cblas_dgemm")) }.is_some()
            })
            .ok_or_else(|| refuse("no symbol cblas_dgemm: not a CBLAS library".into()))?;
        let missing = |what: &str| refuse(format!("no symbol {prefix}{what}"));
        // SAFETY: these are the signatures of the CBLAS standard with 32-bit integers; the
        // pointers live no longer than `library`, which is stored beside them.
        let (ddot, dgemm, sgemm, dsyrk, ssyrk) = unsafe {
            (
                symbol(&library, &format!("{prefix}cblas_ddot")).ok_or(missing("cblas_ddot"))?,
                symbol(&library, &format!("{prefix}cblas_dgemm")).ok_or(missing("cblas_dgemm"))?,
                symbol(&library, &format!("{prefix}cblas_sgemm")).ok_or(missing("cblas_sgemm"))?,
                symbol(&library, &format!("{prefix}cblas_dsyrk")).ok_or(missing("cblas_dsyrk"))?,
                symbol(&library, &format!("{prefix}cblas_ssyrk")).ok_or(missing("cblas_ssyrk"))?,
            )
        };
        let threading = threading(&library, prefix);
        let description = description(&library, prefix);
        if !has_32_bit_integers(ddot) || description.contains("USE64BITINT") {
            return Err(refuse("its integers have 64 bits (ILP64), not 32 (LP64)".into()));
        }
        Ok(Self {
            name,
            description,
            dgemm,
            sgemm,
            dsyrk,
            ssyrk,
            threading,
            holders: Arc::default(),
        })
    }
}

/// Returns whether a library takes 32-bit integers: asks for a scalar product of length 2, which as
/// a 64-bit integer is a negative length. That is legal too, and gives zero (reference BLAS,
/// `ddot`).
fn has_32_bit_integers(ddot: Dot) -> bool {
    type WideDot = unsafe extern "C" fn(i64, *const f64, i64, *const f64, i64) -> f64;
    if size_of::<usize>() != 8 {
        return true;
    }
    let (x, y) = ([2.0, 3.0], [5.0, 7.0]);
    // SAFETY: on 64-bit targets an int and a 64-bit integer are passed in the same place, of which
    // an int is the lower half. Of the arrays two elements are read, or none.
    let product = unsafe {
        let ddot = std::mem::transmute::<Dot, WideDot>(ddot);
        ddot(2 - (1_i64 << 32), x.as_ptr(), 1, y.as_ptr(), 1)
    };
    product == 31.0
}

/// Returns the symbol `name` as a `T`.
///
/// # Safety
/// `T` must be the pointer type of that symbol.
unsafe fn symbol<T: Copy>(library: &Library, name: &str) -> Option<T> {
    // SAFETY: `T` is the pointer type of the symbol, by the contract, which each caller takes from
    // the library's documentation. The library is never unloaded (`load`), so that the copy of the
    // pointer stays valid.
    unsafe { library.get::<T>(name) }.ok().map(|s| *s)
}

fn threading(library: &Library, prefix: &str) -> Threading {
    // SAFETY: the documented signatures of MKL (mkl_service.h), OpenBLAS (cblas.h) and BLIS.
    unsafe {
        if let Some(set) = symbol(library, "MKL_Set_Num_Threads_Local") {
            return Threading::MklLocal(set);
        }
        if let (Some(get), Some(set)) = (
            symbol(library, &format!("{prefix}openblas_get_num_threads")),
            symbol(library, &format!("{prefix}openblas_set_num_threads")),
        ) {
            return Threading::Openblas { get, set };
        }
        if let (Some(get), Some(set)) = (
            symbol(library, "bli_thread_get_num_threads"),
            symbol(library, "bli_thread_set_num_threads"),
        ) {
            return Threading::Blis { get, set };
        }
    }
    Threading::Unknown
}

fn description(library: &Library, prefix: &str) -> String {
    type MklVersion = unsafe extern "C" fn(*mut c_char, c_int);
    type Version = unsafe extern "C" fn() -> *const c_char;
    // SAFETY: the documented signatures; MKL writes at most the length it is told, with a final
    // NUL; OpenBLAS and BLIS return a static C string.
    unsafe {
        if let Some(version) = symbol::<MklVersion>(library, "MKL_Get_Version_String") {
            let mut text = [0 as c_char; 256];
            version(text.as_mut_ptr(), text.len() as c_int - 1);
            return CStr::from_ptr(text.as_ptr()).to_string_lossy().trim().to_owned();
        }
        if let Some(config) = symbol::<Version>(library, &format!("{prefix}openblas_get_config")) {
            return CStr::from_ptr(config()).to_string_lossy().trim().to_owned();
        }
        if let Some(version) = symbol::<Version>(library, "bli_info_get_version_str") {
            return format!("BLIS {}", CStr::from_ptr(version()).to_string_lossy().trim());
        }
    }
    String::new()
}

#[cfg(feature = "openblas")]
impl Cblas {
    pub(super) fn linked_openblas() -> Self {
        use openblas_src as _; // links libopenblas

        unsafe extern "C" {
            fn openblas_get_num_threads() -> c_int;
            fn openblas_set_num_threads(n: c_int);
            fn openblas_get_config() -> *const c_char;
        }
        // SAFETY: the two declarations of each function differ only in that `cblas_sys` types the
        // enumerations, which are passed as 32-bit integers; OpenBLAS returns a static C string.
        unsafe {
            use std::mem::transmute;
            Self {
                name: "openblas".into(),
                description: CStr::from_ptr(openblas_get_config()).to_string_lossy().into_owned(),
                dgemm: transmute::<*const (), Gemm<f64>>(cblas_sys::cblas_dgemm as *const ()),
                sgemm: transmute::<*const (), Gemm<f32>>(cblas_sys::cblas_sgemm as *const ()),
                dsyrk: transmute::<*const (), Syrk<f64>>(cblas_sys::cblas_dsyrk as *const ()),
                ssyrk: transmute::<*const (), Syrk<f32>>(cblas_sys::cblas_ssyrk as *const ()),
                threading: Threading::Openblas {
                    get: openblas_get_num_threads,
                    set: openblas_set_num_threads,
                },
                holders: Arc::default(),
            }
        }
    }
}

/// The storage order of a view in the terms of CBLAS.
#[derive(Clone, Copy)]
struct CblasOrder {
    /// Rows are contiguous (else columns are).
    row_major: bool,
    leading: c_int,
}

/// Returns the CBLAS layout of an r x c view with these strides, if it has one. An extent of at
/// most one makes its stride irrelevant.
fn layout(rows: usize, cols: usize, row_stride: isize, col_stride: isize) -> Option<CblasOrder> {
    let leading = |stride: isize, lines: usize, length: usize| {
        let stride = if lines <= 1 { length.max(1) } else { usize::try_from(stride).ok()? };
        (stride >= length.max(1)).then(|| c_int::try_from(stride).ok()).flatten()
    };
    if c_int::try_from(rows).is_err() || c_int::try_from(cols).is_err() {
        return None;
    }
    if (col_stride == 1 || cols <= 1)
        && let Some(leading) = leading(row_stride, rows, cols)
    {
        return Some(CblasOrder { row_major: true, leading });
    }
    if (row_stride == 1 || rows <= 1)
        && let Some(leading) = leading(col_stride, cols, rows)
    {
        return Some(CblasOrder { row_major: false, leading });
    }
    None
}

fn layout_of<T>(view: MatRef<'_, T>) -> Option<CblasOrder> {
    layout(view.nrows(), view.ncols(), view.row_stride(), view.col_stride())
}

impl Cblas {
    fn gemm_with<T: Real>(
        &self,
        function: Gemm<T>,
        alpha: T,
        a: MatRef<'_, T>,
        b: MatRef<'_, T>,
        beta: T,
        c: MatMut<'_, T>,
    ) where
        Native: Kernels<T>,
    {
        assert_eq!((a.nrows(), a.ncols()), (b.nrows(), c.nrows()));
        assert_eq!(b.ncols(), c.ncols());
        if c.nrows() == 0 || c.ncols() == 0 {
            return;
        }
        let (Some(la), Some(lb), Some(lc)) = (layout_of(a), layout_of(b), layout_of(c.rb())) else {
            return fallback().gemm(alpha, a, b, beta, c);
        };
        let trans = |transposed: bool| if transposed { TRANS } else { NO_TRANS };
        // SAFETY: the views are valid for their shapes; `layout` derived order and leading
        // dimension from their strides and checked that every extent fits a C int; `c` is borrowed
        // mutably, so it overlaps neither input. In the order of C, an operand stored the other
        // way is its own transpose, hence A^T needs "trans" exactly when A has C's order.
        unsafe {
            function(
                if lc.row_major { ROW_MAJOR } else { COL_MAJOR },
                trans(la.row_major == lc.row_major),
                trans(lb.row_major != lc.row_major),
                c.nrows() as c_int,
                c.ncols() as c_int,
                a.nrows() as c_int,
                alpha,
                a.as_ptr(),
                la.leading,
                b.as_ptr(),
                lb.leading,
                beta,
                c.as_ptr_mut(),
                lc.leading,
            );
        }
    }

    fn syrk_with<T: Real>(
        &self,
        function: Syrk<T>,
        alpha: T,
        a: MatRef<'_, T>,
        beta: T,
        c: MatMut<'_, T>,
    ) where
        Native: Kernels<T>,
    {
        assert_eq!((a.ncols(), a.ncols()), (c.nrows(), c.ncols()));
        if c.nrows() == 0 {
            return;
        }
        let (Some(la), Some(lc)) = (layout_of(a), layout_of(c.rb())) else {
            return fallback().syrk(alpha, a, beta, c);
        };
        // SAFETY: the views are valid for their shapes; `layout_of` derived order and leading
        // dimension from their strides and checked that every extent fits a C int; A has as many
        // columns as C has rows and columns, as asserted; `c` is borrowed mutably, so it overlaps
        // `a` nowhere.
        unsafe {
            function(
                if lc.row_major { ROW_MAJOR } else { COL_MAJOR },
                LOWER,
                if la.row_major == lc.row_major { TRANS } else { NO_TRANS },
                c.nrows() as c_int,
                a.nrows() as c_int,
                alpha,
                a.as_ptr(),
                la.leading,
                beta,
                c.as_ptr_mut(),
                lc.leading,
            );
        }
    }
}

macro_rules! kernels {
    ($t:ident, $gemm:ident, $syrk:ident) => {
        impl Kernels<$t> for Cblas {
            fn gemm(
                &self,
                alpha: $t,
                a: MatRef<'_, $t>,
                b: MatRef<'_, $t>,
                beta: $t,
                c: MatMut<'_, $t>,
            ) {
                self.gemm_with(self.$gemm, alpha, a, b, beta, c);
            }

            fn syrk(&self, alpha: $t, a: MatRef<'_, $t>, beta: $t, c: MatMut<'_, $t>) {
                self.syrk_with(self.$syrk, alpha, a, beta, c);
            }

            fn gemmt(
                &self,
                alpha: $t,
                a: MatRef<'_, $t>,
                b: MatRef<'_, $t>,
                beta: $t,
                c: MatMut<'_, $t>,
            ) {
                gemmt_by_gemm(self, alpha, a, b, beta, c);
            }
        }
    };
}
kernels!(f32, sgemm, ssyrk);
kernels!(f64, dgemm, dsyrk);

impl Backend for Cblas {
    fn name(&self) -> &str {
        &self.name
    }

    fn description(&self) -> &str {
        &self.description
    }

    fn rates(&self) -> Rates {
        // MKL 2026 on one core of a Sapphire Rapids guest.
        Rates {
            gemm_flops: 101e9,
            gemm_half_side: 24.0,
            syrk_flops: 106e9,
            syrk_half_side: 180.0,
            add_bytes: 16e9,
        }
    }

    fn single_threaded(&self) -> ThreadGuard {
        ThreadGuard(match self.threading {
            Threading::MklLocal(set) => {
                // SAFETY: `set` was found with this signature when the library was loaded, and
                // takes any count.
                let before = unsafe { set(1) };
                Some(Box::new(move || {
                    // SAFETY: as above; `before` is a count that `set` returned.
                    unsafe { set(before) };
                }))
            }
            Threading::Openblas { get, set } => {
                // SAFETY: `get` was found with this signature when the library was loaded.
                let get = move || i64::from(unsafe { get() });
                // SAFETY: so was `set`; `hold` passes 1 or a count that `get` returned, a C int.
                Some(hold(&self.holders, get, move |n| unsafe { set(n as c_int) }))
            }
            Threading::Blis { get, set } => {
                // SAFETY: `get` was found with this signature when the library was loaded.
                let get = move || unsafe { get() };
                // SAFETY: so was `set`; `hold` passes 1 or a count that `get` returned.
                Some(hold(&self.holders, get, move |n| unsafe { set(n) }))
            }
            Threading::Unknown => None,
        })
    }
}

/// Sets a process-wide count to one for its first holder, and returns a closure that restores the
/// count after the last holder.
fn hold(
    holders: &Arc<Mutex<(usize, i64)>>,
    get: impl Fn() -> i64,
    set: impl Fn(i64) + 'static,
) -> Box<dyn FnOnce()> {
    let lock = |holders: &Mutex<(usize, i64)>, change: &dyn Fn(&mut (usize, i64))| {
        change(&mut holders.lock().unwrap_or_else(PoisonError::into_inner));
    };
    lock(holders, &|(count, before)| {
        if *count == 0 {
            *before = get();
            set(1);
        }
        *count += 1;
    });
    let holders = Arc::clone(holders);
    Box::new(move || {
        lock(&holders, &|(count, before)| {
            *count -= 1;
            if *count == 0 {
                set(*before);
            }
        });
    })
}

/// Returns the back end for operands that CBLAS can't express.
fn fallback() -> Native {
    let best = packed::FloatIsa::best();
    Native::new(best, packed::Rates::of(best))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Defines a scalar product for integers of one width that rejects what BLAS calls illegal.
    macro_rules! ddot {
        ($name:ident, $integer:ty) => {
            extern "C" fn $name(
                n: $integer,
                x: *const f64,
                inc_x: $integer,
                y: *const f64,
                inc_y: $integer,
            ) -> f64 {
                assert_eq!((inc_x, inc_y), (1, 1));
                // SAFETY: `has_32_bit_integers` passes two arrays of two numbers and n = 2, or a
                // negative one, for which none is read.
                (0..n.max(0) as usize).map(|i| unsafe { *x.add(i) * *y.add(i) }).sum()
            }
        };
    }
    ddot!(narrow, c_int);
    ddot!(wide, i64);

    #[test]
    fn the_width_of_integers_is_found_by_a_call_that_is_legal_in_both() {
        assert!(has_32_bit_integers(narrow));
        // SAFETY: on 64-bit targets both are called alike.
        #[cfg(target_pointer_width = "64")]
        assert!(!has_32_bit_integers(unsafe {
            std::mem::transmute::<*const (), Dot>(wide as *const ())
        }));
    }
}
