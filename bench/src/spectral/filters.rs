//! Figures 1.14 and 1.15: filters of the coordinates in products, and in orthogonalised products.

use catamaran::Par;
use catamaran::faer::{Mat, MatRef, Scale};
use catamaran::spectral::test_functions::coordinates;
use catamaran::spectral::{
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
/// Parts of the functions, by ascending frequency, that a low-pass keeps.
const KEPT: [f64; 10] = [0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0];
/// Parts of the size of the shape by which one coefficient grows.
const STEPS: [f64; 7] = [0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7];
/// Where coefficients are changed: at these parts of the functions by ascending frequency.
const CHANGED: [f64; 5] = [0.01, 0.1, 0.25, 0.5, 0.9];

/// Coordinates as coefficients in a dictionary, its functions in ascending order of their frequencies.
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

    /// The functions with the first so many coefficients.
    fn first(&self, count: usize) -> Mat<f64> {
        self.functions.subcols(0, count) * self.coefficients.subrows(0, count)
    }
}

/// The coordinates of a shape in products of unit norm and in "ours*".
fn representations(shape: &Shape) -> Result<[Representation; 2]> {
    let par = Par::all();
    let few = shape.first(K)?;
    let options = ProductBasisOptions::new().orthogonalization(Orthogonalization::Reorthogonalized);
    let basis = ProductBasis::new(&few, ORDER, &options)?;
    let f = coordinates(&shape.mesh);
    let ours = basis.basis().analysis(f.as_ref(), par)?;
    let prods = TruncatedProducts::new(&basis, ROUNDING)?.analysis(f.as_ref(), par)?;
    let products = Eigenproducts::new(K, ORDER)?;
    let constant = few.constant().ok_or("a shape without constants")?;
    let factors = Scale(1.0 / constant) * few.functions().subcols(1, K);
    let mut values = Mat::zeros(factors.nrows(), products.len());
    products.evaluate(factors.as_ref(), values.as_mut(), par)?;
    // Of norm 1, as in the published code; the coefficients take what the functions lose.
    let norms: Vec<f64> = basis.r().col_iter().map(|column| column.norm_l2()).collect();
    let values = Mat::from_fn(values.nrows(), values.ncols(), |x, j| values[(x, j)] / norms[j]);
    let prods = Mat::from_fn(prods.nrows(), prods.ncols(), |i, j| prods[(i, j)] * norms[i]);
    Ok([
        Representation::new(shape, values.as_ref(), prods.as_ref())?,
        Representation::new(shape, basis.functions(), ours.as_ref())?,
    ])
}

/// Figure 1.14, the smoothing filter: the relative error of the coordinates over the part of the coefficients that is kept;
/// and figure 1.15: the relative change of the coordinates when one coefficient grows, over its growth, the mean and the
/// largest of several coefficients.
///
/// # Errors
/// Those of the library.
pub fn filters(shape: &Shape) -> Result<[Plot; 2]> {
    let mass = shape.eigenbasis.basis().mass();
    let f = coordinates(&shape.mesh);
    let names = ["prods", "ours*"];
    let mut low: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    let mut thickness: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    for (name, found) in names.into_iter().zip(representations(shape)?) {
        let len = found.coefficients.nrows();
        let count = |part: f64| ((part * len as f64).round() as usize).clamp(1, len);
        let point = |&part: &f64| -> Result<(f64, f64)> {
            let g = found.first(count(part));
            Ok((part, mean(&relative_errors(f.as_ref(), g.as_ref(), mass)?)))
        };
        low.push((name.into(), KEPT.iter().map(point).collect::<Result<_>>()?));

        // One coefficient grows by a part of itself in the norm of all, as that of the figure does by a part of itself.
        let whole = found.first(len);
        let least = |step: f64| -> Result<(f64, f64)> {
            let mut flattest = f64::INFINITY;
            for part in CHANGED {
                let i = count(part) - 1;
                let size = found.coefficients.norm_l2();
                let g = Mat::from_fn(whole.nrows(), 3, |x, j| {
                    whole[(x, j)] + step * size * found.functions[(x, i)]
                });
                flattest = flattest.min(flatness(g.as_ref())? / flatness(whole.as_ref())?);
            }
            Ok((step, flattest))
        };
        thickness.push((name.into(), STEPS.into_iter().map(least).collect::<Result<_>>()?));
    }
    let title = |figure: &str, what: &str| {
        format!("Figure {figure}, {}: {what}, N = {ORDER}, K = {K}", shape.name)
    };
    Ok([
        Plot {
            title: title("1.14", "error of the coordinates after a low-pass"),
            across: "share of coefficients kept".into(),
            logarithmic: true,
            scattered: false,
            series: low,
        },
        Plot {
            title: title(
                "1.15",
                "thickness that is left when one coefficient grows, the least of five",
            ),
            across: "growth, in the norm of all".into(),
            logarithmic: false,
            scattered: false,
            series: thickness,
        },
    ])
}

/// The least extent of a cloud of points by the greatest, along its principal axes.
fn flatness(points: MatRef<'_, f64>) -> Result<f64> {
    let means: Vec<f64> = points.col_iter().map(|c| c.sum() / points.nrows() as f64).collect();
    let centred = Mat::from_fn(points.nrows(), 3, |i, j| points[(i, j)] - means[j]);
    let values =
        (centred.transpose() * &centred).singular_values().map_err(|e| format!("{e:?}"))?;
    Ok((values[2] / values[0]).sqrt())
}
