//! Who races: a library's `syrk`, faer, or `catamaran::ata`. One thing is timed, and it is the same
//! for all: the lower triangle of C := A^T A, row-major, into memory that exists.

use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

use catamaran::base::Team;
use catamaran::blas::{Backend, BlasReal};
use catamaran::{AtaOptions, Par, Plan, SchemeChoice, ata};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef};

use crate::Result;
use crate::input::Shape;
use crate::library::{Rival, Syrk};

// The values of the CBLAS enumerations.
const ROW_MAJOR: i32 = 101;
const TRANS: i32 = 112;
const LOWER: i32 = 122;

/// A scalar that every contender can compute with.
pub trait Scalar: BlasReal {
    /// The rival's `syrk` of this precision.
    fn syrk(rival: &Rival) -> Syrk<Self>;
    /// The lower triangle of C := A^T A by faer.
    fn faer_syrk(a: MatRef<'_, Self>, c: MatMut<'_, Self>, par: faer::Par);
}

macro_rules! scalar {
    ($t:ident, $syrk:ident) => {
        impl Scalar for $t {
            fn syrk(rival: &Rival) -> Syrk<Self> {
                rival.$syrk
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
        }
    };
}
scalar!(f32, ssyrk);
scalar!(f64, dsyrk);

/// One way to compute A^T A.
#[derive(Clone)]
pub enum Contender {
    /// A library, called directly.
    Cblas(Arc<Rival>),
    /// faer's triangular product.
    Faer,
    /// Ours.
    Ours {
        /// Name of the scheme.
        scheme: &'static str,
        /// The scheme.
        choice: SchemeChoice,
        /// Name of the back end.
        backend_name: String,
        /// What computes the leaves.
        backend: Arc<dyn Backend>,
    },
}

impl fmt::Display for Contender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cblas(rival) => f.pad(&rival.name),
            Self::Faer => f.pad("faer"),
            Self::Ours { scheme, backend_name, .. } => {
                f.pad(&format!("cata:{scheme}/{backend_name}"))
            }
        }
    }
}

impl Contender {
    /// Whether it is not ours.
    pub fn is_rival(&self) -> bool {
        !matches!(self, Self::Ours { .. })
    }

    /// Computes A^T A `calls` times on `threads` threads; the time it took.
    ///
    /// # Errors
    /// Whatever `ata` refuses.
    pub fn run<T: Scalar>(
        &self,
        a: MatRef<'_, T>,
        mut c: MatMut<'_, T>,
        calls: usize,
        threads: usize,
        team: &Team,
    ) -> Result<Duration> {
        match self {
            Self::Cblas(rival) => {
                let syrk = T::syrk(rival);
                rival.set_threads(threads);
                let (n, k) = (i32::try_from(a.ncols())?, i32::try_from(a.nrows())?);
                let (lda, ldc) = (a.row_stride() as i32, c.row_stride() as i32);
                let start = Instant::now();
                for _ in 0..calls {
                    // SAFETY: both views are row-major with these leading dimensions.
                    unsafe {
                        syrk(
                            ROW_MAJOR,
                            LOWER,
                            TRANS,
                            n,
                            k,
                            T::ONE,
                            a.as_ptr(),
                            lda,
                            T::ZERO,
                            c.as_ptr_mut(),
                            ldc,
                        );
                    }
                }
                Ok(start.elapsed())
            }
            Self::Faer => {
                let par = if threads == 1 { faer::Par::Seq } else { faer::Par::rayon(threads) };
                Ok(team.run(|| {
                    let start = Instant::now();
                    for _ in 0..calls {
                        T::faer_syrk(a, c.as_mut(), par);
                    }
                    start.elapsed()
                }))
            }
            Self::Ours { .. } => {
                let options = self.options(threads);
                let time = team.run(|| {
                    let start = Instant::now();
                    for _ in 0..calls {
                        ata(T::ONE, a, T::ZERO, c.as_mut(), &options)?;
                    }
                    Ok::<_, catamaran::Error>(start.elapsed())
                });
                Ok(time?)
            }
        }
    }

    /// What `ata` will do, if this is ours.
    pub fn plan<T: Scalar>(&self, shape: Shape) -> Option<Plan> {
        matches!(self, Self::Ours { .. })
            .then(|| Plan::ata::<T>(shape.m, shape.n, &self.options(1)).ok())
            .flatten()
    }

    fn options(&self, threads: usize) -> AtaOptions<'static> {
        let mut options = AtaOptions { par: Par::Threads(threads), ..AtaOptions::default() };
        if let Self::Ours { choice, backend, .. } = self {
            options.scheme = *choice;
            options.backend = backend.clone();
        }
        options
    }
}
