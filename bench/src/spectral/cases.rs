//! Figures 1.13, 1.16, 1.17, 1.19 and 1.20 as numbers: the error of each method on one shape or
//! pair.

use catamaran::Par;
use catamaran::faer::{Mat, MatRef};
use catamaran_geometry::spectral::coordinates;
use catamaran_geometry::spectral::functional_map::{map_from_points, pull_back};
use catamaran_geometry::spectral::{
    Eigenbasis, Orthogonalization, ProductBasis, ProductBasisOptions, Transfer, TruncatedProducts,
    relative_errors,
};

use super::functions::heat_kernels;
use super::prods::ROUNDING;
use super::shapes::{Pair, Shape};
use super::table::mean;
use super::transfer::{Bases, fitted, mean_distance, of_size_1};
use crate::Result;

/// The methods of a case.
pub const METHODS: [&str; 5] = ["K", "prods", "ours", "ours*", "NK"];

/// A figure, and the errors of [`METHODS`].
#[derive(Debug, Clone)]
pub struct Case {
    /// Number of the figure.
    pub figure: &'static str,
    /// The function, the shape and the parameters.
    pub what: String,
    /// The errors.
    pub errors: [f64; METHODS.len()],
}

/// Computes figures 1.16 and 1.17: `f` on a shape, approximated by products of at most `order` of
/// `k` eigenfunctions; "prods" with rounding as its only loss.
///
/// # Errors
/// The errors of the library.
pub fn approximated(
    figure: &'static str,
    (shape, name): (&Shape, &str),
    f: MatRef<'_, f64>,
    (k, order): (usize, usize),
) -> Result<Case> {
    let par = Par::all();
    let few = shape.first(k)?;
    let mass = few.basis().mass();
    let error = |g: Mat<f64>| -> Result<f64> { Ok(mean(&relative_errors(f, g.as_ref(), mass)?)) };
    let basis = |orthogonalization| {
        let options = ProductBasisOptions::new().orthogonalization(orthogonalization);
        ProductBasis::new(&few, order, &options)
    };
    let ours = error(basis(Orthogonalization::SinglePass)?.basis().approximation(f, par)?)?;
    let star = basis(Orthogonalization::Reorthogonalized)?;
    let prods = TruncatedProducts::new(&star, ROUNDING)?;
    let coefficients = prods.analysis(f, par)?;
    let errors = [
        error(few.basis().approximation(f, par)?)?,
        error(prods.synthesis(coefficients.as_ref(), par)?)?,
        ours,
        error(star.basis().approximation(f, par)?)?,
        error(shape.first(order * k)?.basis().approximation(f, par)?)?,
    ];
    let what = format!("{name} of {}, N = {order}, K = {k}", shape.name);
    Ok(Case { figure, what, errors })
}

/// The origin of a functional map, and the measure of errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known {
    /// The true points, as in figure 1.13; relative error over the surface.
    Points,
    /// A fit to descriptors and landmarks; relative error over the surface.
    Landmarks,
    /// A fit as above; mean absolute error at a tenth of the vertices, of functions divided by
    /// their largest values.
    Sparse,
}

/// Computes figures 1.13, 1.19 and 1.20: `f` transferred by products of at most `order` of this
/// number of eigenfunctions.
///
/// # Errors
/// The errors of the library.
pub fn transferred(
    figure: &'static str,
    (pair, name): (&Pair, &str),
    f: MatRef<'_, f64>,
    (order, [k, l]): (usize, [usize; 2]),
    known: Known,
) -> Result<Case> {
    let par = Par::all();
    let f = match known {
        Known::Sparse => of_size_1(f),
        Known::Points | Known::Landmarks => f.to_owned(),
    };
    let f = f.as_ref();
    let bases = Bases::new(pair, order, [k, l])?;
    let (source, target) = bases.eigenbases();
    let (more, more_target) = (pair.source.first(order * k)?, pair.target.first(order * l)?);
    let map = |source: &Eigenbasis, target: &Eigenbasis| match known {
        Known::Points => Ok(map_from_points(&pair.truth, source.basis(), target.basis(), par)?),
        Known::Landmarks | Known::Sparse => fitted(pair, source, target),
    };
    let c_more = map(&more, &more_target)?;
    let truth = pull_back(&pair.truth, f)?;
    let samples = pair.samples(pair.truth.len() / 10);
    let error = |g: Mat<f64>| -> Result<f64> {
        Ok(match known {
            Known::Sparse => mean_distance(truth.as_ref(), g.as_ref(), &samples),
            _ => mean(&relative_errors(truth.as_ref(), g.as_ref(), target.basis().mass())?),
        })
    };
    let [eigen, prods, ours, star] = bases.by(map(source, target)?.as_ref())?.all(f)?;
    let eigen_more = Transfer::new(more.basis(), more_target.basis(), c_more)?.apply(f, par)?;
    let errors = [error(eigen)?, error(prods)?, error(ours)?, error(star)?, error(eigen_more)?];
    let (from, to) = (&pair.source.name, &pair.target.name);
    let what = format!("{name}, {from} to {to}, N = {order}, K = {k} and {l}");
    Ok(Case { figure, what, errors })
}

/// Returns three channels of colour, in [0, 1]: stripes along the axes, this number over the size
/// of the shape.
pub fn colours(shape: &Shape, stripes: f64) -> Mat<f64> {
    let points = coordinates(&shape.mesh);
    let range = |j: usize| {
        points
            .col(j)
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)))
    };
    let ranges = [0, 1, 2].map(range);
    let longest = ranges.map(|(low, high)| high - low).into_iter().fold(0.0, f64::max);
    Mat::from_fn(points.nrows(), 3, |i, j| {
        let place = (points[(i, j)] - ranges[j].0) / longest;
        0.5 + 0.5 * (std::f64::consts::TAU * stripes * place).sin()
    })
}

/// Returns a heat kernel of 200 eigenfunctions.
///
/// # Errors
/// The errors of the library.
pub fn heat(shape: &Shape) -> Result<Mat<f64>> {
    let many = shape.first(super::signals::MANY)?;
    Ok(heat_kernels(many.values(), many.functions(), 1e-3, 4, 5)?)
}
