//! The contenders: `syrk` or `gemm` of a library, faer, and `catamaran::ata_into` and
//! `catamaran::atb_into`. For all of them, the race times the same: the product, row-major, into
//! existing memory.

use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

use catamaran::base::ThreadPool;
use catamaran::blas::BlasReal;
use catamaran::{AtaOptions, Plan, SchemeChoice, ata_into, atb_into};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef};

use crate::Result;
use crate::input::Shape;
use crate::library::{Gemm, GemmBatch, Rival, Syrk};
use crate::product::Operation;

// The values of the CBLAS enumerations.
pub(crate) const ROW_MAJOR: i32 = 101;
pub(crate) const NO_TRANS: i32 = 111;
pub(crate) const TRANS: i32 = 112;
pub(crate) const LOWER: i32 = 122;

/// A scalar that every contender can compute with.
pub trait Scalar: BlasReal {
    /// Returns the rival's `syrk` of this precision.
    fn syrk(rival: &Rival) -> Syrk<Self>;
    /// Returns the rival's `gemm` of this precision.
    fn gemm(rival: &Rival) -> Gemm<Self>;
    /// Returns the rival's products of many small matrices of this precision.
    fn gemm_batch(rival: &Rival) -> Option<GemmBatch<Self>>;
    /// Computes the lower triangle of C := A^T A by faer.
    fn faer_syrk(a: MatRef<'_, Self>, c: MatMut<'_, Self>, par: faer::Par);
    /// Computes C := A^T B by faer.
    fn faer_gemm(a: MatRef<'_, Self>, b: MatRef<'_, Self>, c: MatMut<'_, Self>, par: faer::Par);
}

macro_rules! scalar {
    ($t:ident, $syrk:ident, $gemm:ident, $gemm_batch:ident) => {
        impl Scalar for $t {
            fn syrk(rival: &Rival) -> Syrk<Self> {
                rival.$syrk
            }

            fn gemm(rival: &Rival) -> Gemm<Self> {
                rival.$gemm
            }

            fn gemm_batch(rival: &Rival) -> Option<GemmBatch<Self>> {
                rival.$gemm_batch
            }

            fn faer_syrk(a: MatRef<'_, Self>, c: MatMut<'_, Self>, par: faer::Par) {
                triangular::matmul(
                    c,
                    BlockStructure::TriangularLower,
                    Accum::Replace,
                    a.transpose(),
                    BlockStructure::Rectangular,
                    a,
                    BlockStructure::Rectangular,
                    1.0,
                    par,
                );
            }

            fn faer_gemm(
                a: MatRef<'_, Self>,
                b: MatRef<'_, Self>,
                c: MatMut<'_, Self>,
                par: faer::Par,
            ) {
                matmul(c, Accum::Replace, a.transpose(), b, 1.0, par);
            }
        }
    };
}
scalar!(f32, ssyrk, sgemm, sgemm_batch);
scalar!(f64, dsyrk, dgemm, dgemm_batch);

/// One way to compute a product.
#[derive(Clone)]
pub enum Contender {
    /// A library, called directly.
    Cblas {
        /// The library.
        rival: Arc<Rival>,
        /// The routine; `None` for that of the product. `gemm` also computes A^T A, including its
        /// upper triangle.
        routine: Option<Operation>,
    },
    /// faer's products.
    Faer,
    /// This library.
    Ours {
        /// Its name in the race, after `cata:`.
        name: String,
        /// Its options; its threads are those of the race.
        options: Box<AtaOptions<'static>>,
    },
}

impl fmt::Display for Contender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cblas { rival, routine: None } => f.pad(&rival.name),
            Self::Cblas { rival, routine: Some(routine) } => {
                f.pad(&format!("{} {}", rival.name, routine.name()))
            }
            Self::Faer => f.pad("faer"),
            Self::Ours { name, .. } => f.pad(&format!("cata:{name}")),
        }
    }
}

impl Contender {
    /// Returns whether the contender is not this library.
    pub fn is_rival(&self) -> bool {
        !matches!(self, Self::Ours { .. })
    }

    /// Computes the product of A and B `calls` times on `threads` threads; returns the time. For
    /// A^T A, B is A.
    ///
    /// # Errors
    /// The errors of `ata` and `atb`.
    pub fn run<T: Scalar>(
        &self,
        operation: Operation,
        [a, b]: [MatRef<'_, T>; 2],
        mut c: MatMut<'_, T>,
        calls: usize,
        threads: usize,
        team: &ThreadPool,
    ) -> Result<Duration> {
        match self {
            Self::Cblas { rival, routine } => {
                rival.set_threads(threads);
                let mut call = cblas_call(rival, routine.unwrap_or(operation), [a, b], c)?;
                let start = Instant::now();
                for _ in 0..calls {
                    call();
                }
                Ok(start.elapsed())
            }
            Self::Faer => {
                let par = if threads == 1 { faer::Par::Seq } else { faer::Par::rayon(threads) };
                Ok(team.run(|| {
                    let start = Instant::now();
                    for _ in 0..calls {
                        match operation {
                            Operation::Syrk => T::faer_syrk(a, c.as_mut(), par),
                            Operation::Gemm => T::faer_gemm(a, b, c.as_mut(), par),
                        }
                    }
                    start.elapsed()
                }))
            }
            Self::Ours { options, .. } => {
                let options = (**options).clone().threads(threads);
                let time = team.run(|| {
                    let start = Instant::now();
                    for _ in 0..calls {
                        match operation {
                            Operation::Syrk => ata_into(T::ONE, a, T::ZERO, c.as_mut(), &options)?,
                            Operation::Gemm => {
                                atb_into(T::ONE, a, b, T::ZERO, c.as_mut(), &options)?
                            }
                        }
                    }
                    Ok::<_, catamaran::Error>(start.elapsed())
                });
                Ok(time?)
            }
        }
    }

    /// Returns the plan of `ata` or `atb`; `None` for other contenders.
    pub fn plan<T: Scalar>(&self, operation: Operation, Shape { m, n }: Shape) -> Option<Plan> {
        let Self::Ours { options, .. } = self else { return None };
        match operation {
            Operation::Syrk => Plan::ata::<T>(m, n, options),
            Operation::Gemm => Plan::atb::<T>(m, n, n, options),
        }
        .ok()
    }
}

/// Returns the call of a library that computes the product into C.
///
/// # Errors
/// When a side does not fit its 32-bit integers.
fn cblas_call<T: Scalar>(
    rival: &Rival,
    routine: Operation,
    [a, b]: [MatRef<'_, T>; 2],
    c: MatMut<'_, T>,
) -> Result<impl FnMut()> {
    let (syrk, gemm) = (T::syrk(rival), T::gemm(rival));
    let (m, n, k) =
        (i32::try_from(a.nrows())?, i32::try_from(a.ncols())?, i32::try_from(b.ncols())?);
    let (lda, ldb, ldc) = (a.row_stride() as i32, b.row_stride() as i32, c.row_stride() as i32);
    Ok(move || {
        let (one, zero) = (T::ONE, T::ZERO);
        let (a, b, c) = (a.as_ptr(), b.as_ptr(), c.as_ptr_mut());
        // SAFETY: all views are row-major with these leading dimensions and shapes.
        unsafe {
            match routine {
                Operation::Syrk => syrk(ROW_MAJOR, LOWER, TRANS, n, m, one, a, lda, zero, c, ldc),
                Operation::Gemm => {
                    gemm(ROW_MAJOR, TRANS, NO_TRANS, n, k, m, one, a, lda, b, ldb, zero, c, ldc)
                }
            }
        }
    })
}
/// Returns the scheme of this name.
///
/// # Errors
/// When there is no such scheme; the error lists all schemes.
pub fn scheme_named(name: &str) -> std::result::Result<SchemeChoice, String> {
    let known = SchemeChoice::NAMES;
    let found = known.iter().find(|(known, _)| *known == name);
    found.map(|&(_, scheme)| scheme).ok_or_else(|| {
        format!("{name}: no such scheme, must be one of {}", known.map(|(name, _)| name).join(", "))
    })
}
