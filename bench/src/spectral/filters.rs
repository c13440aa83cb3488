//! Figures 1.14 and 1.15: filters of the coordinates in products, and in orthogonalized products.

use catamaran::Par;
use catamaran::faer::{Mat, MatRef, Scale};
use catamaran_geometry::spectral::coordinates;
use catamaran_geometry::spectral::{
    Eigenproducts, Orthogonalization, ProductBasis, ProductBasisOptions, TruncatedProducts,
    dirichlet_energies, relative_errors,
};

use super::prods::ROUNDING;
use super::shapes::Shape;
use super::table::mean;
use crate::Result;
use crate::curves::Plot;

/// The thesis' parameters for both figures.
const K: usize = 15;
const ORDER: usize = 3;
/// A tolerance that keeps the coefficients of products small: the best one for transfer in the
/// sweeps.
const TOLERANCE: f64 = 1e-2;
/// Shares of the functions, by ascending frequency, that a low-pass keeps.
const KEPT: [f64; 10] = [0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0];
/// Relative growth of one coefficient, by a share of itself or of the size of the shape.
const STEPS: [f64; 7] = [0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7];
/// Positions of the changed coefficients, as shares of the functions by ascending frequency.
const CHANGED: [f64; 5] = [0.01, 0.1, 0.25, 0.5, 0.9];

/// A name, and points (x, y), as in [`Plot`].
type Curve = (String, Vec<(f64, f64)>);

/// Coordinates as coefficients in a dictionary, with its functions in the order of their
/// frequencies.
struct Representation {
    functions: Mat<f64>,
    coefficients: Mat<f64>,
}

impl Representation {
    fn new(
        shape: &Shape,
        functions: MatRef<'_, f64>,
        coefficients: MatRef<'_, f64>,
    ) -> Result<Self> {
        let mass = shape.eigenbasis.basis().mass();
        let energies = dirichlet_energies(functions, shape.stiffness.view(), mass)?;
        let mut ascending: Vec<usize> = (0..energies.len()).collect();
        ascending.sort_by(|&a, &b| energies[a].total_cmp(&energies[b]));
        Ok(Self {
            functions: Mat::from_fn(functions.nrows(), energies.len(), |x, j| {
                functions[(x, ascending[j])]
            }),
            coefficients: Mat::from_fn(energies.len(), coefficients.ncols(), |i, j| {
                coefficients[(ascending[i], j)]
            }),
        })
    }

    /// Returns the functions with the first `count` coefficients.
    fn first(&self, count: usize) -> Mat<f64> {
        self.functions.subcols(0, count) * self.coefficients.subrows(0, count)
    }
}

/// Returns the coordinates of a shape in products of norm 1, up to rounding as in the published
/// code and up to [`TOLERANCE`], and in "ours*".
fn representations(shape: &Shape) -> Result<[Representation; 3]> {
    let par = Par::all();
    let few = shape.first(K)?;
    let options = ProductBasisOptions::new().orthogonalization(Orthogonalization::Reorthogonalized);
    let basis = ProductBasis::new(&few, ORDER, &options)?;
    let f = coordinates(&shape.mesh);
    let ours = basis.basis().analysis(f.as_ref(), par)?;
    let mut truncated = TruncatedProducts::new(&basis, ROUNDING)?;
    let exact = truncated.analysis(f.as_ref(), par)?;
    truncated.set_threshold(TOLERANCE)?;
    let stable = truncated.analysis(f.as_ref(), par)?;
    let products = Eigenproducts::new(K, ORDER)?;
    let constant = few.constant().ok_or("the constant is not among the eigenfunctions")?;
    let factors = Scale(1.0 / constant) * few.functions().subcols(1, K);
    let mut values = Mat::zeros(factors.nrows(), products.len());
    products.evaluate(factors.as_ref(), values.as_mut(), par)?;
    // Scaled to norm 1, as in the published code; the coefficients are scaled inversely.
    let norms: Vec<f64> = basis.r().col_iter().map(|column| column.norm_l2()).collect();
    let values = Mat::from_fn(values.nrows(), values.ncols(), |x, j| values[(x, j)] / norms[j]);
    let scaled = |a: Mat<f64>| Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * norms[i]);
    Ok([
        Representation::new(shape, values.as_ref(), scaled(exact).as_ref())?,
        Representation::new(shape, values.as_ref(), scaled(stable).as_ref())?,
        Representation::new(shape, basis.functions(), ours.as_ref())?,
    ])
}

/// Computes figure 1.14, the smoothing filter: the relative error of the coordinates over the share
/// of the coefficients that is kept; and figure 1.15, in two ways. In the first, one coefficient
/// grows by a share of itself, and the plot shows the relative change of the coordinates, the
/// largest over several coefficients. In the second, one coefficient grows by the same amount in
/// every dictionary, and the plot shows the remaining thickness, the least over several
/// coefficients.
///
/// # Errors
/// The errors of the library.
pub fn filters(shape: &Shape) -> Result<[Plot; 3]> {
    let mass = shape.eigenbasis.basis().mass();
    let f = coordinates(&shape.mesh);
    let truncated = format!("prods {TOLERANCE:.0e}");
    let names = ["prods", &truncated, "ours*"];
    let mut series: [Vec<Curve>; 3] = Default::default();
    for (name, found) in names.into_iter().zip(representations(shape)?) {
        let len = found.coefficients.nrows();
        let count = |part: f64| ((part * len as f64).round() as usize).clamp(1, len);
        let low = |part: f64| -> Result<(f64, f64)> {
            let g = found.first(count(part));
            Ok((part, mean(&relative_errors(f.as_ref(), g.as_ref(), mass)?)))
        };
        let whole = found.first(len);
        let size = f.norm_l2() / (f.nrows() as f64).sqrt();
        let changed = |function: usize, amounts: [f64; 3]| {
            Mat::from_fn(whole.nrows(), 3, |x, j| {
                whole[(x, j)] + amounts[j] * found.functions[(x, function)]
            })
        };
        let grown = |step: f64| -> Result<(f64, f64)> {
            let mut most: f64 = 0.0;
            for function in CHANGED.map(|part| count(part) - 1) {
                let amounts = [0, 1, 2].map(|j| step * found.coefficients[(function, j)]);
                let g = changed(function, amounts);
                most = most.max(mean(&relative_errors(whole.as_ref(), g.as_ref(), mass)?));
            }
            Ok((step, most))
        };
        let thickness = |step: f64| -> Result<(f64, f64)> {
            let mut least = f64::INFINITY;
            for function in CHANGED.map(|part| count(part) - 1) {
                let g = changed(function, [step * size; 3]);
                least = least.min(flatness(g.as_ref())? / flatness(whole.as_ref())?);
            }
            Ok((step, least))
        };
        let [lows, growths, thicknesses] = &mut series;
        lows.push((name.into(), KEPT.into_iter().map(low).collect::<Result<_>>()?));
        growths.push((name.into(), STEPS.into_iter().map(grown).collect::<Result<_>>()?));
        thicknesses.push((name.into(), STEPS.into_iter().map(thickness).collect::<Result<_>>()?));
    }
    let plot = |figure: &str, what: &str, across: &str, logarithmic, series| Plot {
        title: format!("Figure {figure}, {}: {what}, N = {ORDER}, K = {K}", shape.name),
        across: across.into(),
        logarithmic,
        scattered: false,
        series,
    };
    let [lows, growths, thicknesses] = series;
    Ok([
        plot("1.14", "error of the coordinates after a low-pass", "share kept", true, lows),
        plot("1.15", "change by one coefficient", "growth, a part of itself", true, growths),
        plot("1.15 again", "thickness left", "growth, same amount", false, thicknesses),
    ])
}

/// Returns the ratio of the least extent of a cloud of points to the greatest, along its principal
/// axes.
fn flatness(points: MatRef<'_, f64>) -> Result<f64> {
    let means: Vec<f64> = points.col_iter().map(|c| c.sum() / points.nrows() as f64).collect();
    let centred = Mat::from_fn(points.nrows(), 3, |i, j| points[(i, j)] - means[j]);
    let values =
        (centred.transpose() * &centred).singular_values().map_err(|e| format!("{e:?}"))?;
    Ok((values[2] / values[0]).sqrt())
}
