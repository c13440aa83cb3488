//! The contents of a handle of a distributed matrix.

use catamaran::ranks::{MpiReal, Symmetric};

/// A distributed matrix of either precision.
pub enum Entries {
    F32(Symmetric<f32>),
    F64(Symmetric<f64>),
}

impl Entries {
    pub(super) fn n(&self) -> usize {
        match self {
            Self::F32(matrix) => matrix.n(),
            Self::F64(matrix) => matrix.n(),
        }
    }
}

/// A scalar of a distributed matrix in a handle.
pub(super) trait Held: MpiReal {
    fn hold(matrix: Symmetric<Self>) -> Entries;

    fn held(entries: &Entries) -> Option<&Symmetric<Self>>;
}

impl Held for f32 {
    fn hold(matrix: Symmetric<Self>) -> Entries {
        Entries::F32(matrix)
    }

    fn held(entries: &Entries) -> Option<&Symmetric<Self>> {
        match entries {
            Entries::F32(matrix) => Some(matrix),
            Entries::F64(_) => None,
        }
    }
}

impl Held for f64 {
    fn hold(matrix: Symmetric<Self>) -> Entries {
        Entries::F64(matrix)
    }

    fn held(entries: &Entries) -> Option<&Symmetric<Self>> {
        match entries {
            Entries::F64(matrix) => Some(matrix),
            Entries::F32(_) => None,
        }
    }
}
