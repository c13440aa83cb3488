//! The matrix O that transfers orthogonalized eigenproducts (thesis, section 1.3.3), computed from
//! the functional map.
//!
//! O is r_target x r_source: `T(Q_source) = Q_target O`. Both formulas need a functional map that
//! is exact or nearly so, and lose accuracy fast otherwise (figure 1.10). The method of section
//! 1.3.4 does not: it applies
//! [`map_from_points`](crate::spectral::functional_map::map_from_points) to the points of the
//! functional map.

use faer::Mat;

use super::dictionary::Eigenproducts;
use super::orthogonalized::ProductBasis;
use super::product_map::ProductMap;
use crate::spectral::dense;
use catamaran::base::{Error, Par, Result};
use catamaran::dense::{divide_by_upper, qr_least_squares, zeros};

/// Number of columns of C~ that are in memory at the same time.
const PANEL: usize = 256;

/// Computes O by equation 1.16, `O = R_target C~ R_source^T (R_source R_source^T)^-1`: the
/// least-squares solution of `O R_source = R_target C~`, which has a column for every product.
///
/// It is computed from a QR factorization of `R_source^T`, which, unlike the formula, does not
/// square its condition number.
///
/// ```
/// use catamaran_geometry::spectral::{Eigenbasis, ProductBasis, ProductBasisOptions, ProductMap};
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::{mesh::families, spectral::transform_of_all_products};
///
/// # let mesh = families::icosphere(2)?;
/// # let operator = laplacian(&mesh, &LaplacianOptions::new())?;
/// # let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(4))?;
/// # let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
/// # let options = ProductBasisOptions::new();
/// # let products = ProductBasis::new(&basis, 2, &options)?;
/// let map = ProductMap::new(Mat::identity(4, 4).as_ref(), &basis, &basis, 2)?;
/// let o = transform_of_all_products(&map, &products, &products, Par::Seq)?;
/// let r = products.len();
/// assert!((o - Mat::<f64>::identity(r, r)).norm_max() < 1e-8);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when the map belongs to other products than the bases,
/// [`Error::OutOfMemory`].
pub fn transform_of_all_products(
    map: &ProductMap,
    source: &ProductBasis,
    target: &ProductBasis,
    par: Par,
) -> Result<Mat<f64>> {
    check(map, source, target)?;
    let all: Vec<usize> = (0..map.source().len()).collect();
    let images = images(map, target, &all, par)?;
    // The transposed equation: R^T O^T = (R C~)^T.
    let solution = qr_least_squares(source.r().transpose(), images.transpose())?;
    Ok(solution.transpose().to_owned())
}

/// Computes O by equation 1.18: column by column, each from those before it, with the products that
/// were kept on the source.
///
/// The thesis writes `R[i, h]` where its equation 1.13 has `R[h, i]`, and refers to the products
/// that were kept.
///
/// ```
/// use catamaran_geometry::spectral::{Eigenbasis, ProductBasis, ProductBasisOptions, ProductMap};
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::{mesh::families, spectral::transform_by_columns};
///
/// # let mesh = families::icosphere(2)?;
/// # let operator = laplacian(&mesh, &LaplacianOptions::new())?;
/// # let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(4))?;
/// # let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
/// # let options = ProductBasisOptions::new();
/// # let products = ProductBasis::new(&basis, 2, &options)?;
/// let map = ProductMap::new(Mat::identity(4, 4).as_ref(), &basis, &basis, 2)?;
/// let o = transform_by_columns(&map, &products, &products, Par::Seq)?;
/// let r = products.len();
/// assert!((o - Mat::<f64>::identity(r, r)).norm_max() < 1e-8);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`transform_of_all_products`].
pub fn transform_by_columns(
    map: &ProductMap,
    source: &ProductBasis,
    target: &ProductBasis,
    par: Par,
) -> Result<Mat<f64>> {
    check(map, source, target)?;
    let mut o = images(map, target, source.kept(), par)?;
    // Column i: (R C~)[.., i] less R[h, i] times the columns h before it, divided by R[i, i].
    divide_by_upper(o.as_mut(), source.triangle().transpose(), par)?;
    Ok(o)
}

/// Computes `R_target C~[.., indices]`: the coefficients of the images of products.
fn images(
    map: &ProductMap,
    target: &ProductBasis,
    indices: &[usize],
    par: Par,
) -> Result<Mat<f64>> {
    let mut images = zeros(target.len(), indices.len())?;
    for (panel, indices) in indices.chunks(PANEL).enumerate() {
        let columns = map.columns(indices, par)?;
        let into = images.as_mut().subcols_mut(panel * PANEL, indices.len());
        dense::transposed_product_into(target.r().transpose(), columns.as_ref(), into, par)?;
    }
    Ok(images)
}

fn check(map: &ProductMap, source: &ProductBasis, target: &ProductBasis) -> Result<()> {
    if map.source() == source.products() && map.target() == target.products() {
        return Ok(());
    }
    let say = |p: &Eigenproducts| format!("{} functions to order {}", p.k(), p.order());
    let why = format!(
        "maps products of {} to products of {}, but the bases have {} and {}",
        say(map.source()),
        say(map.target()),
        say(source.products()),
        say(target.products())
    );
    Err(Error::Argument { what: "map", why })
}
