use sprs::CsMat;

/// The matrix M of an inner product `<u, v> = u^T M v`: symmetric, positive definite.
#[derive(Debug, Clone, PartialEq)]
pub enum Mass {
    /// A diagonal: lumped masses, one for each row, all positive.
    Lumped(Vec<f64>),
    /// A full (consistent) matrix, both triangles stored.
    Full(CsMat<f64>),
}

impl Mass {
    /// Its number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Lumped(diagonal) => diagonal.len(),
            Self::Full(matrix) => matrix.rows(),
        }
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
