//! What most programs import.
//!
//! ```
//! use catamaran::prelude::*;
//!
//! let (a, b) = (Mat::<f64>::identity(3, 2), Mat::<f64>::full(3, 4, 2.0));
//! assert_eq!(atb(&a, &b)?, Mat::full(2, 4, 2.0));
//! # Ok::<(), Error>(())
//! ```

pub use faer::{Mat, MatMut, MatRef};

pub use crate::base::{Error, Par, Progress, Result};
pub use crate::ortho::{GramSchmidtOptions, cholesky_qr, gram_schmidt};
pub use crate::product::{
    Accuracy, AtaOptions, Plan, SchemeChoice, Uplo, aat, aat_into, aha, aha_into, ahb, ahb_into,
    ata, ata_into, atb, atb_into,
};
pub use crate::sparse::{EigenOptions, Eigenpairs, eigs};
