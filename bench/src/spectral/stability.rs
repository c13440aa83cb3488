//! Figure 1.10: errors of O by equation 1.16, and by points, for functional maps with errors.

use catamaran::Par;
use catamaran::base::{Progress, Rng};
use catamaran_geometry::spectral::functional_map::{map_from_points, points_from_map, pull_back};
use catamaran_geometry::spectral::{
    Orthogonalization, ProductBasis, ProductBasisOptions, ProductMap, transform_of_all_products,
};

use super::noise::{noisy, relative};
use super::shapes::Pair;
use crate::Result;
use crate::curves::Plot;

const ORDER: usize = 2;
const NOISE: [f64; 7] = [0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3];

/// Returns the errors of a pair with `k` eigenfunctions over the noise on C: those of C, of O by
/// equation 1.16 and of O by points.
///
/// # Errors
/// The errors of the library.
pub fn stability(pair: &Pair, k: usize) -> Result<Plot> {
    let par = Par::all();
    let (source, target) = (pair.source.first(k)?, pair.target.first(k)?);
    let truth = map_from_points(&pair.truth, source.basis(), target.basis(), par)?;
    let options = ProductBasisOptions::default();
    let [from, to] = [&source, &target].map(|basis| ProductBasis::new(basis, ORDER, &options));
    let (from, to) = (from?, to?);
    let o_truth = map_from_points(&pair.truth, from.basis(), to.basis(), par)?;
    let mut series: [Vec<(f64, f64)>; 3] = Default::default();
    let mut rng = Rng::new(1);
    for noise in NOISE {
        let c = noisy(truth.as_ref(), noise, &mut rng);
        let extended = ProductMap::new(c.as_ref(), &source, &target, ORDER)?;
        let o = transform_of_all_products(&extended, &from, &to, par)?;
        let points =
            points_from_map(c.as_ref(), source.basis(), target.basis(), par, Progress::none())?;
        let by_points = map_from_points(&points, from.basis(), to.basis(), par)?;
        let errors = [
            relative(c.as_ref(), truth.as_ref()),
            relative(o.as_ref(), o_truth.as_ref()),
            relative(by_points.as_ref(), o_truth.as_ref()),
        ];
        for (points, error) in series.iter_mut().zip(errors) {
            points.push((noise, error));
        }
    }
    let names = ["C", "O by eq. 1.16", "O by points"];
    Ok(Plot {
        title: format!("Figure 1.10: relative error, K = {k}, N = {ORDER}"),
        across: "noise on C".into(),
        logarithmic: true,
        scattered: false,
        series: names.map(String::from).into_iter().zip(series).collect(),
    })
}

/// Numbers of eigenfunctions of the source besides the constant, for [`sizes`].
const KS: [usize; 6] = [5, 8, 11, 14, 17, 20];
const RATIOS: [f64; 3] = [0.5, 1.0, 2.0];
/// Number of eigenfunctions besides the constant that [`sizes`] needs.
pub const MOST: usize = 40;

/// Computes figure 1.10, right: the error of the images of Q under O by equation 1.16, from the
/// true functional map, over the number of eigenfunctions on the source, for several ratios of the
/// numbers on target and source.
///
/// # Errors
/// The errors of the library.
pub fn sizes(pair: &Pair) -> Result<Plot> {
    let par = Par::all();
    let options = ProductBasisOptions::new().orthogonalization(Orthogonalization::Reorthogonalized);
    let mut series = Vec::new();
    for ratio in RATIOS {
        let mut points = Vec::new();
        for k in KS {
            let l = (k as f64 * ratio).ceil() as usize;
            let (source, target) = (pair.source.first(k)?, pair.target.first(l)?);
            let c = map_from_points(&pair.truth, source.basis(), target.basis(), par)?;
            let from = ProductBasis::new(&source, ORDER, &options)?;
            let to = ProductBasis::new(&target, ORDER, &options)?;
            let extended = ProductMap::new(c.as_ref(), &source, &target, ORDER)?;
            let o = transform_of_all_products(&extended, &from, &to, par)?;
            let images = to.basis().synthesis(o.as_ref(), par)?;
            let truth = pull_back(&pair.truth, from.functions())?;
            points.push((k as f64, relative(images.as_ref(), truth.as_ref())));
        }
        series.push((format!("target / source {ratio}"), points));
    }
    Ok(Plot {
        title: format!("Figure 1.10, right: relative error of the images of Q, N = {ORDER}"),
        across: "K of the source".into(),
        logarithmic: true,
        scattered: false,
        series,
    })
}
