//! Points found from few landmarks, by how the map is fitted and refined: ZoomOut in eigenproducts
//! beside others.

use catamaran::Par;
use catamaran::base::Progress;
use catamaran::spectral::functional_map::{icp, points_from_map, zoomout};
use catamaran::spectral::{Orthogonalization, ProductBasis, ProductBasisOptions};

use super::shapes::Pair;
use super::transfer::fit;
use crate::Result;

/// Eigenfunctions beside the constant, the order of their products, and the eigenfunctions that
/// ZoomOut ends with.
const K: usize = 30;
const ORDER: usize = 2;
const ZOOM: usize = 100;
/// Iterations of ICP, at most.
const ITERATIONS: usize = 20;

/// How maps are refined: not at all, by ICP, by ZoomOut in eigenfunctions and in products of the
/// first ones.
pub const REFINEMENTS: [&str; 4] = ["none", "icp", "zoomout", "products"];

/// The mean distances of the points found from the true ones, as a part of the root of the area of
/// the source, for each of
/// [`REFINEMENTS`]: of maps fitted without and with multiplications.
///
/// # Errors
/// Those of the library.
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

/// The mean distance of these points from the true ones, through space.
fn distance(pair: &Pair, points: &[u32]) -> f64 {
    let position = |v: u32| pair.source.mesh.vertices()[v as usize];
    let apart = |(&found, &truth): (&u32, &u32)| {
        let (p, q) = (position(found), position(truth));
        (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt()
    };
    points.iter().zip(&pair.truth).map(apart).sum::<f64>() / points.len().max(1) as f64
}
