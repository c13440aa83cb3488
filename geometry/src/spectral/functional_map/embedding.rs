//! Samples of two meshes in the space of their eigenfunctions, between which maps are refined.

use faer::{Mat, Scale};

use super::nearest::nearest_rows;
use crate::mesh::TriMesh;
use crate::mesh::vector::distance;
use crate::spectral::dense;
use crate::spectral::eigenbasis::Eigenbasis;
use catamaran::base::{Error, Par, Progress, Result};

/// Returns `count` vertices, each the farthest in space from those before it; all vertices if there
/// are no more.
pub(super) fn far_vertices(mesh: &TriMesh, count: usize) -> Vec<u32> {
    let points = mesh.vertices();
    let mut far = vec![f64::INFINITY; points.len()];
    let mut found = Vec::new();
    let mut next = 0;
    while found.len() < count.min(points.len()) {
        found.push(next as u32);
        for (far, &point) in far.iter_mut().zip(points) {
            *far = far.min(distance(point, points[next]));
        }
        let farthest = (0..far.len()).max_by(|&x, &y| far[x].total_cmp(&far[y]).then(y.cmp(&x)));
        next = farthest.unwrap_or(0);
    }
    found
}

/// The values of the first eigenfunctions of two meshes, as if these had area 1, at samples.
pub(super) struct Embedding {
    /// Samples x functions.
    source: Mat<f64>,
    target: Mat<f64>,
    /// For each number k of functions, from 1, the matrix (k x samples) that takes values at
    /// samples of the target to coefficients of its first k functions, by least squares.
    inverses: Vec<Mat<f64>>,
}

impl Embedding {
    /// Creates an embedding in the first `len` functions.
    ///
    /// # Errors
    /// [`Error::Argument`] when the samples of the target do not determine coefficients.
    pub fn new(
        (source, from): (&Eigenbasis, &[u32]),
        (target, to): (&Eigenbasis, &[u32]),
        len: usize,
    ) -> Result<Self> {
        let values = |basis: &Eigenbasis, samples: &[u32]| -> Result<Mat<f64>> {
            let root = basis.basis().area()?.sqrt();
            let functions = basis.functions();
            Ok(Mat::from_fn(samples.len(), len, |i, j| root * functions[(samples[i] as usize, j)]))
        };
        let (source, target) = (values(source, from)?, values(target, to)?);
        let gram = dense::transposed_product(target.as_ref(), target.as_ref(), Par::Seq)?;
        let inverse = |k: usize| -> Result<Mat<f64>> {
            let few = gram.as_ref().submatrix(0, 0, k, k).to_owned();
            let factor = dense::cholesky(few)?.map_err(|column| Error::Argument {
                what: "target",
                why: format!("its samples do not tell eigenfunction {column} from those before it"),
            })?;
            let mut inverse = target.as_ref().subcols(0, k).transpose().to_owned();
            dense::solve_cholesky(factor.as_ref(), inverse.as_mut());
            Ok(inverse)
        };
        let inverses = (1..=len).map(inverse).collect::<Result<_>>()?;
        Ok(Self { source, target, inverses })
    }

    /// Refines a square map between the first functions by ZoomOut on the samples, with `step` more
    /// functions at a time until it has `len`. Returns the map and for each sample of the target
    /// one of the source.
    pub fn zoom(&self, mut c: Mat<f64>, len: usize, step: usize) -> Result<(Mat<f64>, Vec<u32>)> {
        loop {
            let points = self.points(&c)?;
            let last = c.nrows() >= len;
            let k = if last { c.nrows() } else { (c.nrows() + step).min(len) };
            let pulled = Mat::from_fn(points.len(), k, |y, j| self.source[(points[y] as usize, j)]);
            c = dense::product(self.inverses[k - 1].as_ref(), pulled.as_ref(), Par::Seq)?;
            if last {
                return Ok((c, points));
            }
        }
    }

    fn points(&self, c: &Mat<f64>) -> Result<Vec<u32>> {
        let source = self.source.as_ref().subcols(0, c.ncols());
        let images = dense::product(source, c.transpose(), Par::Seq)?;
        let target = self.target.as_ref().subcols(0, c.nrows());
        nearest_rows(target, images.as_ref(), Par::Seq, Progress::none())
    }
}

/// Returns a functional map between bases of meshes as if these had area 1.
pub(super) fn of_unit_areas(c: &Mat<f64>, ratio: f64) -> Mat<f64> {
    Scale(1.0 / ratio.sqrt()) * c
}
