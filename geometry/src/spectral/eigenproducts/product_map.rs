//! Extends a functional map to eigenproducts (thesis, section 1.3.3, equation 1.12; Nogneng et al.
//! 2018).

use std::ops::Range;

use faer::prelude::ReborrowMut;
use faer::{ColMut, Mat, MatRef};

use super::dictionary::Eigenproducts;
use crate::spectral::dense;
use crate::spectral::eigenbasis::Eigenbasis;
use catamaran::base::{Error, Par, Result};
use catamaran::dense::{for_row_blocks, zeros};

/// Number of columns that a thread computes at once.
const PANEL: usize = 16;

/// The map C~ of eigenproducts that a functional map C of eigenfunctions implies:
/// `T(phi_i phi_j) = T(phi_i) T(phi_j)`.
///
/// A column of C is a polynomial of degree 1 in the functions on the target, and a column of C~ the
/// product of such polynomials, whose coefficients the dictionary of [`Eigenproducts`] orders. The
/// map multiplies these polynomials; it stores neither the Kronecker product of C with itself nor
/// C~.
///
/// ```
/// use catamaran_geometry::spectral::{Eigenbasis, ProductMap};
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::mesh::families;
///
/// # let mesh = families::icosphere(2)?;
/// # let operator = laplacian(&mesh, &LaplacianOptions::new())?;
/// # let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(4))?;
/// # let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
/// // The identity on eigenfunctions is the identity on their products.
/// let map = ProductMap::new(Mat::identity(4, 4).as_ref(), &basis, &basis, 2)?;
/// let len = map.source().len();
/// let images = map.apply(Mat::identity(len, len).as_ref(), Par::Seq)?;
/// assert!((images - Mat::<f64>::identity(len, len)).norm_max() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ProductMap {
    source: Eigenproducts,
    target: Eigenproducts,
    /// The polynomials. Column i - 1 holds the coefficients of 1, psi_1, psi_2, ... in the image of
    /// phi_i.
    linear: Mat<f64>,
    /// The index of the product of target product p, which has less than the full order, and psi_h,
    /// at `p * k + h - 1`.
    times: Vec<u32>,
}

impl ProductMap {
    /// Creates the extension of `c` to products of at most `order` of the functions of
    /// [`ProductBasis`](super::ProductBasis).
    ///
    /// `c` maps coefficients of eigenfunctions on `source` to coefficients on `target`, the
    /// constant included. It has a row for each eigenfunction of the target and a column for each
    /// of the source. Like every pull-back, the extension maps the constant to the constant,
    /// whatever the first column of `c`.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NonFinite`], [`Error::Argument`] when the order is too large or a
    /// basis has no constant function.
    pub fn new(
        c: MatRef<'_, f64>,
        source: &Eigenbasis,
        target: &Eigenbasis,
        order: usize,
    ) -> Result<Self> {
        Error::check_shape("functional map", (target.len(), source.len()), c.shape())?;
        dense::check_finite("functional map", c)?;
        let scale = target.need_constant("target")? / source.need_constant("source")?;
        // Both sides are divided by their constants, as in `ProductBasis`.
        let linear = Mat::from_fn(c.nrows(), c.ncols() - 1, |h, i| c[(h, i + 1)] * scale);
        Self::from_polynomials(linear, order)
    }

    /// Creates the extension of `phi_i -> linear[0, i] + sum_h linear[h, i] psi_h`. Functions are
    /// numbered from 1, except in the columns of `linear`.
    pub(super) fn from_polynomials(linear: Mat<f64>, order: usize) -> Result<Self> {
        let source = Eigenproducts::new(linear.ncols(), order)?;
        let target = Eigenproducts::new(linear.nrows() - 1, order)?;
        let times = times_table(&target);
        Ok(Self { source, target, linear, times })
    }

    /// Returns the products on the source, one for each column of C~.
    pub fn source(&self) -> &Eigenproducts {
        &self.source
    }

    /// Returns the products on the target, one for each row of C~.
    pub fn target(&self) -> &Eigenproducts {
        &self.target
    }

    /// Computes these columns of C~: the images of the products with these indices.
    ///
    /// ```
    /// use catamaran_geometry::spectral::{Eigenbasis, ProductMap};
    /// use catamaran_geometry::prelude::*;
    /// use catamaran_geometry::mesh::families;
    ///
    /// # let mesh = families::icosphere(2)?;
    /// # let operator = laplacian(&mesh, &LaplacianOptions::new())?;
    /// # let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(4))?;
    /// # let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
    /// let map = ProductMap::new(Mat::identity(4, 4).as_ref(), &basis, &basis, 2)?;
    /// let image = map.columns(&[5], Par::Seq)?;
    /// assert_eq!((image.nrows(), image[(5, 0)]), (map.target().len(), 1.0));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] names the first index that is not that of a column;
    /// [`Error::OutOfMemory`].
    pub fn columns(&self, indices: &[usize], par: Par) -> Result<Mat<f64>> {
        if let Some(index) = indices.iter().find(|&&index| index >= self.source.len()) {
            let why = format!("{index} is not one of the {} products", self.source.len());
            return Err(Error::Argument { what: "indices", why });
        }
        let mut out = zeros(self.target.len(), indices.len())?;
        for_row_blocks(out.as_mut().transpose_mut(), PANEL, par, |first, mut images| {
            let (mut polynomial, mut product) = (self.buffer(), self.buffer());
            for j in 0..images.nrows() {
                let index = indices[first + j];
                polynomial.fill(0.0);
                polynomial[0] = 1.0;
                let factors = self.source.factors(index).unwrap_or_default();
                for (degree, factor) in factors.into_iter().enumerate() {
                    product.fill(0.0);
                    self.add_times(&polynomial, degree, factor, &mut product);
                    std::mem::swap(&mut polynomial, &mut product);
                }
                copy(&polynomial, images.rb_mut().row_mut(j).transpose_mut());
            }
        });
        Ok(out)
    }

    /// Computes `C~ X`: the images of functions with these coefficients of products, L x c.
    ///
    /// The cost of a column is about `N k` times its length, not its square.
    ///
    /// # Errors
    /// [`Error::Shape`] when there are not L rows, [`Error::NonFinite`], [`Error::OutOfMemory`].
    pub fn apply(&self, x: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
        Error::check_shape("coefficients", (self.source.len(), x.ncols()), x.shape())?;
        dense::check_finite("coefficients", x)?;
        let mut out = zeros(self.target.len(), x.ncols())?;
        let steps = self.source.steps();
        let children = children(&steps);
        for_row_blocks(out.as_mut().transpose_mut(), 1, par, |j, mut image| {
            // The image of a product and of all products that it is a factor of, at each depth of
            // the walk.
            let mut images: Vec<Vec<f64>> = (0..=self.source.order())
                .map(|depth| vec![0.0; self.target.len_up_to(self.source.order() - depth)])
                .collect();
            if image.nrows() == 0 {
                return;
            }
            let walk = Walk { map: self, x: x.col(j), steps: &steps, children: &children };
            walk.visit(0, 0, &mut images);
            copy(&images[0], image.rb_mut().row_mut(0).transpose_mut());
        });
        Ok(out)
    }

    fn buffer(&self) -> Vec<f64> {
        vec![0.0; self.target.len()]
    }

    /// Computes `product += polynomial T(phi_factor)`, for a polynomial of at most `degree` (less
    /// than the order).
    fn add_times(&self, polynomial: &[f64], degree: usize, factor: usize, product: &mut [f64]) {
        let k = self.target.k();
        let linear = self.linear.col(factor - 1);
        for (p, &coefficient) in polynomial[..self.target.len_up_to(degree)].iter().enumerate() {
            if coefficient != 0.0 {
                product[p] += linear[0] * coefficient;
                for (h, &index) in self.times[p * k..(p + 1) * k].iter().enumerate() {
                    product[index as usize] += linear[h + 1] * coefficient;
                }
            }
        }
    }
}

/// A traversal of the source's dictionary as a tree, in which the children of a product have one
/// more factor at the end.
struct Walk<'a> {
    map: &'a ProductMap,
    x: faer::ColRef<'a, f64>,
    steps: &'a [(usize, usize)],
    children: &'a [Range<usize>],
}

impl Walk<'_> {
    /// Puts the image of `x[product] + sum over children (factor * (image of the child))` into
    /// `images[0]`: Horner's rule for polynomials in several variables.
    fn visit(&self, product: usize, depth: usize, images: &mut [Vec<f64>]) {
        images[0].fill(0.0);
        images[0][0] = self.x[product];
        // The parts of degree 1 and up come from children; products of the last level have no
        // children.
        let open = self.map.source.order() - depth;
        for child in self.children[product].clone() {
            self.visit(child, depth + 1, &mut images[1..]);
            let (image, deeper) = images.split_at_mut(1);
            self.map.add_times(&deeper[0], open - 1, self.steps[child - 1].1, &mut image[0]);
        }
    }
}

/// Returns the children of every product.
fn children(steps: &[(usize, usize)]) -> Vec<Range<usize>> {
    let mut children = vec![0..0; steps.len() + 1];
    for (before, &(parent, _)) in steps.iter().enumerate() {
        let child = before + 1;
        let range = &mut children[parent];
        if range.end == 0 {
            range.start = child;
        }
        range.end = child + 1;
    }
    children
}

/// Returns the index of each product of less than the full order times each function.
fn times_table(products: &Eigenproducts) -> Vec<u32> {
    let parents = if products.order() == 0 { 0 } else { products.len_up_to(products.order() - 1) };
    let mut times = Vec::with_capacity(parents * products.k());
    for parent in 0..parents {
        let mut factors = products.factors(parent).unwrap_or_default();
        for factor in 1..=products.k() {
            factors.push(factor);
            let index = products.index(&factors).unwrap_or_default();
            factors.pop();
            times.push(index as u32);
        }
    }
    times
}

fn copy(from: &[f64], mut to: ColMut<'_, f64>) {
    for (i, &x) in from.iter().enumerate() {
        to[i] = x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran::base::Rng;

    /// Computes C~ by its definition: the explicit Kronecker power of the homogenized map, with the
    /// rows and columns of the same product summed, and one representative column of each.
    fn by_kronecker(linear: &Mat<f64>, order: usize) -> Mat<f64> {
        let (rows, columns) = (linear.nrows(), linear.ncols() + 1);
        let full = Mat::from_fn(rows, columns, |h, i| match i {
            0 => f64::from(u8::from(h == 0)),
            _ => linear[(h, i - 1)],
        });
        let mut power = Mat::<f64>::ones(1, 1);
        for _ in 0..order {
            let old = power;
            power = Mat::from_fn(old.nrows() * rows, old.ncols() * columns, |i, j| {
                old[(i / rows, j / columns)] * full[(i % rows, j % columns)]
            });
        }
        let digits = |mut index: usize, base: usize| -> Vec<usize> {
            let mut digits = Vec::new();
            for _ in 0..order {
                digits.push(index % base);
                index /= base;
            }
            digits.retain(|&digit| digit > 0);
            digits.sort_unstable();
            digits
        };
        let source = Eigenproducts::new(columns - 1, order).unwrap();
        let target = Eigenproducts::new(rows - 1, order).unwrap();
        let mut out = Mat::zeros(target.len(), source.len());
        for j in 0..source.len() {
            let column = (0..power.ncols())
                .find(|&column| digits(column, columns) == source.factors(j).unwrap())
                .unwrap();
            for row in 0..power.nrows() {
                out[(target.index(&digits(row, rows)).unwrap(), j)] += power[(row, column)];
            }
        }
        out
    }

    fn all(map: &ProductMap) -> Vec<usize> {
        (0..map.source().len()).collect()
    }

    #[test]
    fn the_extension_is_the_kronecker_power_of_the_map() {
        for (k_source, k_target, order) in [
            (0, 0, 2),
            (1, 1, 3),
            (2, 2, 2),
            (3, 2, 2),
            (2, 3, 3),
            (1, 3, 4),
            (3, 3, 1),
            (2, 2, 0),
            (0, 2, 2),
            (2, 0, 2),
        ] {
            let mut rng = Rng::new(3);
            // The entries are small integers, so that every order of summation gives the same
            // result.
            let linear =
                Mat::from_fn(k_target + 1, k_source, |_, _| (rng.uniform() * 7.0).floor() - 3.0);
            let expected = by_kronecker(&linear, order);
            let map = ProductMap::from_polynomials(linear, order).unwrap();
            for par in [Par::Seq, Par::Threads(3)] {
                assert_eq!(map.columns(&all(&map), par).unwrap(), expected);
                let x = Mat::from_fn(map.source().len(), 5, |i, j| (i * 3 + j) as f64 - 4.0);
                assert_eq!(map.apply(x.as_ref(), par).unwrap(), &expected * &x);
            }
        }
    }

    #[test]
    fn the_extension_commutes_with_products_of_functions() {
        let mut rng = Rng::new(1);
        let psi = Mat::from_fn(20, 4, |_, _| rng.normal());
        let linear = Mat::from_fn(5, 3, |_, _| rng.normal());
        let map = ProductMap::from_polynomials(linear.clone(), 3).unwrap();
        // The images of the three functions on the source, at 20 points of the target.
        let images = Mat::from_fn(20, 3, |p, i| {
            linear[(0, i)] + (0..4).map(|h| linear[(h + 1, i)] * psi[(p, h)]).sum::<f64>()
        });
        let mut expected = Mat::zeros(20, map.source().len());
        map.source().evaluate(images.as_ref(), expected.as_mut(), Par::Seq).unwrap();
        let mut products = Mat::zeros(20, map.target().len());
        map.target().evaluate(psi.as_ref(), products.as_mut(), Par::Seq).unwrap();
        let found = &products * map.columns(&all(&map), Par::Seq).unwrap();
        assert!((found - &expected).norm_max() < 1e-11 * expected.norm_max());
    }

    #[test]
    fn columns_outside_of_the_map_are_refused() {
        let map = ProductMap::from_polynomials(Mat::zeros(3, 2), 2).unwrap();
        let outside = map.columns(&[2, 6], Par::Seq);
        assert!(matches!(outside, Err(Error::Argument { what: "indices", .. })));
        assert_eq!(map.columns(&[], Par::Seq).unwrap().shape(), (6, 0));
        let short = Mat::zeros(5, 1);
        assert!(matches!(map.apply(short.as_ref(), Par::Seq), Err(Error::Shape { .. })));
    }
}
