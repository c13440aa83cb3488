//! Table 1.1: functions approximated in several bases.

use catamaran::Par;
use catamaran_geometry::spectral::{
    Basis, Orthogonalization, ProductBasis, ProductBasisOptions, TruncatedProducts, relative_errors,
};

use super::prods::{ROUNDING, tolerances};
use super::shapes::{Shape, Shapes};
use super::signals::signals;
use super::table::{Table, average, mean};
use crate::Result;

/// Number of eigenfunctions besides the constant, and the order of products.
const K: usize = 30;
const ORDER: usize = 2;
/// Number of products of at most that order, which is the number of eigenfunctions of the last
/// column.
const PRODUCTS: usize = 496;

const COLUMNS: [&str; 6] = ["K", "prods", "ours", "ours*", "NK", "binom"];

/// The thesis' errors in per cent; it has no ours* here.
const THESIS: [[f64; 5]; 9] = [
    [0.0, 0.0, 0.0, 0.0, 0.0],
    [75.8, 18.1, 13.7, 61.1, 0.0],
    [1.1, 0.0, 0.0, 0.4, 0.0],
    [14.1, 0.0, 0.0, 5.7, 0.1],
    [37.5, 33.8, 33.5, 37.2, 33.4],
    [15.2, 2.0, 1.7, 7.6, 0.8],
    [29.2, 12.5, 12.2, 23.6, 11.4],
    [66.8, 35.4, 33.8, 58.8, 28.9],
    [12.5, 5.9, 5.8, 10.5, 4.2],
];

/// Returns the table, averaged over the shapes.
///
/// # Errors
/// The errors of the library.
pub fn approximation(shapes: &Shapes) -> Result<Table> {
    let shapes = shapes.single(PRODUCTS - 1)?;
    let tables: Vec<_> = shapes.iter().map(|shape| errors(shape)).collect::<Result<_>>()?;
    let names: Vec<_> = shapes.iter().map(|shape| shape.name.as_str()).collect();
    let title = format!(
        "approximation, K = {K}, N = {ORDER}, on {}; prods up to rounding, as published",
        names.join(", ")
    );
    let thesis =
        THESIS.into_iter().map(|[k, prods, ours, nk, all]| vec![k, prods, ours, f64::NAN, nk, all]);
    Ok(Table::new(("1.1", title), &COLUMNS, average(&tables), thesis, ROUNDING))
}

fn errors(shape: &Shape) -> Result<Vec<Vec<f64>>> {
    let par = Par::all();
    let few = shape.first(K)?;
    let basis = |orthogonalization| {
        let options = ProductBasisOptions::new().orthogonalization(orthogonalization);
        ProductBasis::new(&few, ORDER, &options)
    };
    let (ours, ours_star) =
        (basis(Orthogonalization::SinglePass)?, basis(Orthogonalization::Reorthogonalized)?);
    let mut prods = TruncatedProducts::new(&ours_star, ROUNDING)?;
    let more = shape.first(ORDER * K)?;
    let mass = few.basis().mass();
    let mut rows = Vec::new();
    for f in signals(shape, K)? {
        let f = f.as_ref();
        let of = |basis: &Basis| -> Result<f64> {
            Ok(mean(&relative_errors(f, basis.approximation(f, par)?.as_ref(), mass)?))
        };
        let mut row = vec![
            of(few.basis())?,
            of(ours.basis())?,
            of(ours_star.basis())?,
            of(more.basis())?,
            of(shape.eigenbasis.basis())?,
        ];
        for tolerance in tolerances(ROUNDING) {
            prods.set_threshold(tolerance)?;
            let coefficients = prods.analysis(f, par)?;
            let g = prods.synthesis(coefficients.as_ref(), par)?;
            row.push(mean(&relative_errors(f, g.as_ref(), mass)?));
        }
        rows.push(row);
    }
    Ok(rows)
}
