//! Figures 1.11 and 1.12: the matrix O from points, in comparison with functional maps of the same
//! number of eigenfunctions, and transfer by a map with noise.

use catamaran::Par;
use catamaran::base::{Progress, Rng};
use catamaran::faer::{Mat, MatRef};
use catamaran_geometry::spectral::coordinates;
use catamaran_geometry::spectral::functional_map::{map_from_points, points_from_map, pull_back};
use catamaran_geometry::spectral::relative_errors;

use super::shapes::Pair;
use super::table::mean;
use super::transfer::{Bases, fitted};
use crate::Result;
use crate::curves::Plot;

const ORDER: usize = 3;
/// Numbers of eigenfunctions besides the constant, for figure 1.11; the last one has the most
/// products.
const KS: [usize; 5] = [4, 6, 8, 10, 12];
/// Largest number of products of figure 1.11, which is also the number of eigenfunctions that it
/// needs.
pub const PRODUCTS: usize = 455;
/// Noise on C, relative to its root mean square, and number of eigenfunctions, for figure 1.12.
const NOISE: [f64; 7] = [0.0, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0];
const K: usize = 12;

/// Returns `c` with uniform noise on every entry, whose standard deviation is relative to the root
/// mean square of `c`.
pub fn noisy(c: MatRef<'_, f64>, noise: f64, rng: &mut Rng) -> Mat<f64> {
    let size = c.norm_l2() / (c.nrows() as f64 * c.ncols() as f64).sqrt();
    let mut out = c.to_owned();
    for j in 0..c.ncols() {
        for i in 0..c.nrows() {
            out[(i, j)] += noise * size * 12_f64.sqrt() * (rng.uniform() - 0.5);
        }
    }
    out
}

/// Returns `|x - truth| / |truth|` in the Frobenius norm.
pub fn relative(x: MatRef<'_, f64>, truth: MatRef<'_, f64>) -> f64 {
    let difference: Mat<f64> = x - truth;
    difference.norm_l2() / truth.norm_l2()
}

/// Computes figure 1.11: errors over K of the fitted C, of O ("ours") and O* ("ours*") by the
/// points of C, and of a functional map C* between as many eigenfunctions as O* has products, by
/// the same points. They are averaged over the pairs, which have [`PRODUCTS`] eigenfunctions.
///
/// # Errors
/// The errors of the library.
pub fn cardinality(pairs: &[Pair]) -> Result<Plot> {
    let par = Par::all();
    let mut series: [Vec<(f64, f64)>; 4] = Default::default();
    for k in KS {
        let mut sums = [0.0; 4];
        for pair in pairs {
            let bases = Bases::new(pair, ORDER, [k, k])?;
            let (source, target) = bases.eigenbases();
            let c = fitted(pair, source, target)?;
            let points =
                points_from_map(c.as_ref(), source.basis(), target.basis(), par, Progress::none())?;
            let truth = map_from_points(&pair.truth, source.basis(), target.basis(), par)?;
            let mut errors = vec![relative(c.as_ref(), truth.as_ref())];
            let [ours, star] = bases.products();
            let len = star[0].len().max(star[1].len());
            let many = (pair.source.first(len - 1)?, pair.target.first(len - 1)?);
            for (from, to) in [
                (ours[0].basis(), ours[1].basis()),
                (star[0].basis(), star[1].basis()),
                (many.0.basis(), many.1.basis()),
            ] {
                let found = map_from_points(&points, from, to, par)?;
                let truth = map_from_points(&pair.truth, from, to, par)?;
                errors.push(relative(found.as_ref(), truth.as_ref()));
            }
            sums.iter_mut().zip(errors).for_each(|(sum, error)| *sum += error);
        }
        for (points, sum) in series.iter_mut().zip(sums) {
            points.push((k as f64, sum / pairs.len() as f64));
        }
    }
    let names = ["C", "O", "O*", "C* of as many"];
    Ok(Plot {
        title: format!("Figure 1.11: relative error of maps, N = {ORDER}, {} pairs", pairs.len()),
        across: "K".into(),
        logarithmic: false,
        scattered: false,
        series: names.map(String::from).into_iter().zip(series).collect(),
    })
}

/// Computes figure 1.12: the error of transferred coordinates over the noise on the true C,
/// averaged over the pairs.
///
/// # Errors
/// The errors of the library.
pub fn noise(pairs: &[Pair]) -> Result<Plot> {
    let par = Par::all();
    let mut sums = [[0.0; NOISE.len()]; 4];
    for pair in pairs {
        let bases = Bases::new(pair, ORDER, [K, K])?;
        let (source, target) = bases.eigenbases();
        let truth = map_from_points(&pair.truth, source.basis(), target.basis(), par)?;
        let f = coordinates(&pair.source.mesh);
        let moved = pull_back(&pair.truth, f.as_ref())?;
        let mut rng = Rng::new(1);
        for (n, noise) in NOISE.into_iter().enumerate() {
            let c = noisy(truth.as_ref(), noise, &mut rng);
            let images = bases.by(c.as_ref())?.all(f.as_ref())?;
            for (sums, image) in sums.iter_mut().zip(images) {
                let mass = target.basis().mass();
                sums[n] += mean(&relative_errors(moved.as_ref(), image.as_ref(), mass)?);
            }
        }
    }
    let names = ["K", "prods", "ours", "ours*"];
    let points = |sums: [f64; NOISE.len()]| {
        NOISE.into_iter().zip(sums).map(|(noise, sum)| (noise, sum / pairs.len() as f64)).collect()
    };
    Ok(Plot {
        title: format!(
            "Figure 1.12: error of transferred coordinates, N = {ORDER}, K = {K}, {} pairs",
            pairs.len()
        ),
        across: "noise on C".into(),
        logarithmic: false,
        scattered: false,
        series: names.map(String::from).into_iter().zip(sums.map(points)).collect(),
    })
}
