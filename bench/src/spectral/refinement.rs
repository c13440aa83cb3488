//! Points found from few landmarks, for several fits and refinements of the map: ZoomOut in
//! eigenproducts beside others.

use catamaran::Par;
use catamaran::base::Progress;
use catamaran_geometry::spectral::functional_map::{icp, points_from_map, zoomout};
use catamaran_geometry::spectral::{Orthogonalization, ProductBasis, ProductBasisOptions};

use super::shapes::Pair;
use super::transfer::fit;
use crate::Result;

/// Number of eigenfunctions besides the constant, the order of their products, and the number of
/// eigenfunctions at the end of ZoomOut.
const K: usize = 30;
const ORDER: usize = 2;
const ZOOM: usize = 100;
/// Largest number of iterations of ICP.
const ITERATIONS: usize = 20;

/// The refinements of maps: none, ICP, ZoomOut in eigenfunctions, and ZoomOut in products of the
/// first ones.
pub const REFINEMENTS: [&str; 4] = ["none", "icp", "zoomout", "products"];

/// Returns the mean distances of the found points from the true ones, relative to the square root
/// of the area of the source, for each of [`REFINEMENTS`], for maps fitted without and with
/// multiplications.
/// [`REFINEMENTS`]: of maps fitted without and with multiplications.
///
/// # Errors
/// The errors of the library.
pub fn refinement(pair: &Pair) -> Result<[[f64; REFINEMENTS.len()]; 2]> {
    let (par, progress) = (Par::all(), Progress::none());
    let (source, target) = (pair.source.first(K)?, pair.target.first(K)?);
    let (more, more_target) = (pair.source.first(ZOOM - 1)?, pair.target.first(ZOOM - 1)?);
    let options = ProductBasisOptions::new().orthogonalization(Orthogonalization::Reorthogonalized);
    let from = ProductBasis::new(&source, ORDER, &options)?;
    let to = ProductBasis::new(&target, ORDER, &options)?;
    let mut distances = [[0.0; REFINEMENTS.len()]; 2];
    for (row, has_operators) in distances.iter_mut().zip([false, true]) {
        let c = fit(pair, &source, &target, has_operators)?;
        let c = c.as_ref();
        let (few, others) = (source.basis(), target.basis());
        let found = [
            points_from_map(c, few, others, par, progress)?,
            icp(c, few, others, ITERATIONS, par, progress)?.points,
            zoomout(c, more.basis(), more_target.basis(), 1, par, progress)?.points,
            zoomout(c, from.basis(), to.basis(), K + 1, par, progress)?.points,
        ];
        *row = found.map(|points| distance(pair, &points));
    }
    Ok(distances)
}

/// Returns the mean distance of these points from the true ones, in space.
fn distance(pair: &Pair, points: &[u32]) -> f64 {
    let position = |v: u32| pair.source.mesh.vertices()[v as usize];
    let apart = |(&found, &truth): (&u32, &u32)| {
        let (p, q) = (position(found), position(truth));
        (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt()
    };
    points.iter().zip(&pair.truth).map(apart).sum::<f64>() / points.len().max(1) as f64
}
