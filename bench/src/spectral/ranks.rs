//! Figure 1.6: the number of linearly independent eigenproducts, in comparison with a dense
//! singular value decomposition.

use catamaran::Par;
use catamaran::faer::{Mat, Scale};
use catamaran::sparse::Mass;
use catamaran_geometry::spectral::{
    Eigenproducts, Orthogonalization, ProductBasis, ProductBasisOptions,
};

use super::shapes::Shape;
use crate::Result;

/// Share of its norm at which "ours*" drops a product, and of the largest singular value of columns
/// of norm 1.
const THRESHOLD: f64 = 1e-9;

/// Returns numbers of products of at most `order` of `k` eigenfunctions: all, those of "ours*",
/// those that the rank-revealing method keeps, and the numerical rank.
///
/// # Errors
/// The errors of the library.
pub fn ranks(shape: &Shape, k: usize, order: usize) -> Result<[usize; 4]> {
    let basis = shape.first(k)?;
    let kept = |orthogonalization| {
        let options = ProductBasisOptions::new().orthogonalization(orthogonalization);
        ProductBasis::new(&basis, order, &options).map(|basis| basis.len())
    };
    let ours_star = kept(Orthogonalization::Reorthogonalized)?;
    let by_rank = kept(Orthogonalization::RankRevealing)?;
    let products = Eigenproducts::new(k, order)?;
    let constant = basis.constant().ok_or("the constant is not among the eigenfunctions")?;
    let factors = Scale(1.0 / constant) * basis.functions().subcols(1, k);
    let mut values = Mat::zeros(factors.nrows(), products.len());
    products.evaluate(factors.as_ref(), values.as_mut(), Par::all())?;
    let Mass::Lumped(mass) = basis.basis().mass() else { return Err("a full mass".into()) };
    for j in 0..values.ncols() {
        for i in 0..values.nrows() {
            values[(i, j)] *= mass[i].sqrt();
        }
        let norm = values.col(j).norm_l2();
        for i in 0..values.nrows() {
            values[(i, j)] /= norm;
        }
    }
    let singular = values.singular_values().map_err(|e| format!("singular values: {e:?}"))?;
    let largest = singular.first().copied().unwrap_or(0.0);
    let rank = singular.iter().filter(|s| **s > THRESHOLD * largest).count();
    Ok([products.len(), ours_star, by_rank, rank])
}
