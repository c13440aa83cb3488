//! Figure 1.10: errors of O by equation 1.16, and by points, when the functional map has errors.

use catamaran::Par;
use catamaran::base::{Progress, Rng};
use catamaran::faer::{Mat, MatRef};
use catamaran::spectral::functional_map::{map_from_points, points_from_map};
use catamaran::spectral::{
    ProductBasis, ProductBasisOptions, ProductMap, transform_of_all_products,
};

use super::shapes::Pair;
use crate::Result;
use crate::curves::Plot;

const ORDER: usize = 2;
const NOISE: [f64; 7] = [0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3];

/// The errors of a pair with `k` eigenfunctions over the noise on C: of C, of O by equation 1.16 and of O by points.
///
/// # Errors
/// Those of the library.
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
        let size = truth.norm_l2() / (truth.nrows() as f64 * truth.ncols() as f64).sqrt();
        let mut c = truth.clone();
        for j in 0..c.ncols() {
            for i in 0..c.nrows() {
                // Uniform, with this standard deviation.
                c[(i, j)] += noise * size * 12_f64.sqrt() * (rng.uniform() - 0.5);
            }
        }
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

fn relative(x: MatRef<'_, f64>, truth: MatRef<'_, f64>) -> f64 {
    let difference: Mat<f64> = x - truth;
    difference.norm_l2() / truth.norm_l2()
}
