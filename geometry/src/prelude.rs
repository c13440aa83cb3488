//! What most programs import, with [`catamaran::prelude`].

pub use catamaran::prelude::*;

pub use crate::curve::{CurveOptions, CurveSolver};
pub use crate::decimate::{DecimateOptions, Decimator};
pub use crate::mesh::{Laplacian, LaplacianOptions, TriMesh, laplacian};
#[cfg(feature = "unions")]
pub use crate::unions::SpectralUnion;
