//! What most programs import.
//!
//! ```
//! use catamaran::prelude::*;
//!
//! let (a, b) = (Mat::<f64>::identity(3, 2), Mat::<f64>::full(3, 4, 2.0));
//! let mut c = Mat::zeros(2, 4);
//! atb(1.0, a.as_ref(), b.as_ref(), 0.0, c.as_mut(), &AtaOptions::new())?;
//! assert_eq!(c, Mat::full(2, 4, 2.0));
//! # Ok::<(), Error>(())
//! ```

pub use faer::{Mat, MatMut, MatRef};

pub use crate::base::{Error, Par, Progress, Result};
pub use crate::ortho::{GramSchmidtOptions, cholesky_qr, gram_schmidt};
pub use crate::product::{Accuracy, AtaOptions, Plan, SchemeChoice, Uplo, aat, aha, ahb, ata, atb};
pub use crate::sparse::{EigenOptions, Eigenpairs, eigs};
