//! Eigenproducts (thesis, definition 1.1): pointwise products of eigenfunctions, in a fixed order.

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use crate::spectral::dense;
use catamaran::base::{Error, Par, Result};
use catamaran::dense::for_row_blocks;

/// Largest number of factors: products of more factors are beyond the precision of f64.
const MAX_ORDER: usize = 255;

/// Number of rows that are evaluated at once: their products stay in the cache until they are
/// factors of longer products.
const BLOCK_ROWS: usize = 256;

/// The dictionary of all products of at most `order` of `k` functions, repetitions allowed.
///
/// A product is the sorted list of its factors, numbered from 1 to `k`: `[]` is the constant one,
/// `[2, 2]` the square of the second function. Shorter products come first; products of the same
/// length are in lexicographic order:
///
/// ```
/// use catamaran_geometry::spectral::Eigenproducts;
///
/// let products = Eigenproducts::new(2, 2)?;
/// let all: Vec<Vec<usize>> = (0..products.len()).filter_map(|i| products.factors(i)).collect();
/// assert_eq!(all, [vec![], vec![1], vec![2], vec![1, 1], vec![1, 2], vec![2, 2]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// Therefore the products of a lower order come first among those of a higher order. Their number
/// is `(k + order)! / (k! order!)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Eigenproducts {
    k: usize,
    /// Index of the first product of each number of factors, and the total number of products.
    starts: Vec<usize>,
}

impl Eigenproducts {
    /// Creates the dictionary of the products of at most `order` (0 to 255) of `k` functions.
    ///
    /// # Errors
    /// [`Error::Argument`] when the order is larger, or there are more products than a `u32` can
    /// number.
    pub fn new(k: usize, order: usize) -> Result<Self> {
        if order > MAX_ORDER {
            let why = format!("must be at most {MAX_ORDER}, is {order}");
            return Err(Error::Argument { what: "order", why });
        }
        let mut starts = vec![0];
        for degree in 0..=order {
            let end = binomial(k as u128 + degree as u128, degree as u128);
            let Some(end) = end.filter(|&end| end <= u128::from(u32::MAX)) else {
                let why = format!("{k} functions have more than 2^32 - 1 products of {degree}");
                return Err(Error::Argument { what: "order", why });
            };
            starts.push(end as usize);
        }
        Ok(Self { k, starts })
    }

    /// Returns the number of functions that are multiplied.
    pub fn k(&self) -> usize {
        self.k
    }

    /// Returns the largest number of factors.
    pub fn order(&self) -> usize {
        self.starts.len() - 2
    }

    /// Returns the number of products, at least 1.
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.starts[self.starts.len() - 1]
    }

    /// Returns the number of products of at most `order` factors.
    pub(super) fn len_up_to(&self, order: usize) -> usize {
        self.starts[order.min(self.order()) + 1]
    }

    /// Returns the number of factors of the product `index`, which must exist.
    fn degree(&self, index: usize) -> usize {
        self.starts.partition_point(|&start| start <= index) - 1
    }

    /// Returns the factors of the product `index`, from 1, ascending; `None` when there is no such
    /// product.
    pub fn factors(&self, index: usize) -> Option<Vec<usize>> {
        if index >= self.len() {
            return None;
        }
        let degree = self.degree(index);
        let mut before = index - self.starts[degree];
        let mut factors = Vec::with_capacity(degree);
        let mut least = 1;
        for place in 0..degree {
            let open = degree - place;
            // The largest factor whose first product is not after `index`.
            let (mut low, mut high) = (least, self.k);
            while low < high {
                let middle = low + (high - low).div_ceil(2);
                if self.skipped(least, middle, open) <= before {
                    low = middle;
                } else {
                    high = middle - 1;
                }
            }
            before -= self.skipped(least, low, open);
            factors.push(low);
            least = low;
        }
        Some(factors)
    }

    /// Returns the index of the product of these factors (1 to k, in any order); `None` when there
    /// is no such product.
    pub fn index(&self, factors: &[usize]) -> Option<usize> {
        let degree = factors.len();
        let known = degree <= self.order() && factors.iter().all(|i| (1..=self.k).contains(i));
        if !known {
            return None;
        }
        let mut sorted = factors.to_vec();
        sorted.sort_unstable();
        let mut index = self.starts[degree];
        let mut least = 1;
        for (place, &factor) in sorted.iter().enumerate() {
            index += self.skipped(least, factor, degree - place);
            least = factor;
        }
        Some(index)
    }

    /// Returns how many sorted lists of `len` factors, all at least `least`, begin with a factor
    /// below `first`.
    fn skipped(&self, least: usize, first: usize, len: usize) -> usize {
        // The number of lists of `len` factors from `v` on is (k - v + len) over len. Those that
        // begin before `first` are the difference.
        let from = |v: usize| {
            binomial((self.k - v + len) as u128, len as u128).expect("as many as all, or fewer")
        };
        (from(least) - from(first)) as usize
    }

    /// Returns for each product except the first the index of the product without its last factor,
    /// and that factor.
    pub(super) fn steps(&self) -> Vec<(usize, usize)> {
        let mut steps: Vec<(usize, usize)> = Vec::with_capacity(self.len() - 1);
        for degree in 1..=self.order() {
            for parent in self.starts[degree - 1]..self.starts[degree] {
                let least = if parent == 0 { 1 } else { steps[parent - 1].1 };
                steps.extend((least..=self.k).map(|factor| (parent, factor)));
            }
        }
        steps
    }

    /// Computes all products of the given functions, pointwise.
    ///
    /// `functions` is n x k, a function in each column; `out` is n x [`Eigenproducts::len`] and is
    /// overwritten. Fastest for matrices by columns (unit row stride). The result is the same, bit
    /// for bit, for every `par`.
    ///
    /// ```
    /// use catamaran::{Par, faer::{Mat, mat}};
    /// use catamaran_geometry::spectral::Eigenproducts;
    ///
    /// let products = Eigenproducts::new(2, 2)?;
    /// // The products 1, f, g, f f, f g and g g of functions f and g on two vertices.
    /// let mut values = Mat::zeros(2, products.len());
    /// products.evaluate(mat![[2.0, 3.0], [1.0, 5.0]].as_ref(), values.as_mut(), Par::Seq)?;
    /// assert_eq!(values, mat![[1.0, 2.0, 3.0, 4.0, 6.0, 9.0], [1.0, 1.0, 5.0, 1.0, 5.0, 25.0]]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] when a matrix has another shape, [`Error::NonFinite`] for the functions.
    pub fn evaluate(
        &self,
        functions: MatRef<'_, f64>,
        out: MatMut<'_, f64>,
        par: Par,
    ) -> Result<()> {
        let n = functions.nrows();
        Error::check_shape("functions", (n, self.k), functions.shape())?;
        Error::check_shape("out", (n, self.len()), out.shape())?;
        dense::check_finite("functions", functions)?;
        let steps = self.steps();
        for_row_blocks(out, BLOCK_ROWS, par, |first, mut out| {
            let factors = functions.subrows(first, out.nrows());
            out.rb_mut().col_mut(0).fill(1.0);
            for (before, &(parent, factor)) in steps.iter().enumerate() {
                let (done, open) = out.rb_mut().split_at_col_mut(before + 1);
                multiply(done.rb().col(parent), factors.col(factor - 1), open.col_mut(0));
            }
        });
        Ok(())
    }
}

/// Computes `out := a b`, pointwise.
fn multiply(a: faer::ColRef<'_, f64>, b: faer::ColRef<'_, f64>, mut out: faer::ColMut<'_, f64>) {
    let contiguous =
        (a.try_as_col_major().map(|a| a.as_slice()), b.try_as_col_major().map(|b| b.as_slice()));
    if let (Some(a), Some(b)) = contiguous
        && let Some(out) = out.rb_mut().try_as_col_major_mut()
    {
        for ((out, a), b) in out.as_slice_mut().iter_mut().zip(a).zip(b) {
            *out = a * b;
        }
        return;
    }
    for i in 0..out.nrows() {
        out[i] = a[i] * b[i];
    }
}

/// Returns the binomial coefficient n over m; `None` beyond 128 bits.
fn binomial(n: u128, m: u128) -> Option<u128> {
    let m = m.min(n - m);
    let mut result = 1u128;
    for i in 0..m {
        // The division is exact: the product of i + 1 consecutive numbers is divisible by (i + 1)!.
        result = result.checked_mul(n - i)? / (i + 1);
    }
    Some(result)
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use catamaran::base::Rng;

    /// Returns the dictionary by its definition: all lists without the unsorted ones.
    fn by_definition(k: usize, order: usize) -> Vec<Vec<usize>> {
        let mut all = vec![vec![]];
        let mut last: Vec<Vec<usize>> = vec![vec![]];
        for _ in 0..order {
            last = last
                .iter()
                .flat_map(|list| {
                    (1..=k).map(move |i| list.iter().copied().chain([i]).collect::<Vec<_>>())
                })
                .collect();
            all.extend(last.iter().filter(|list| list.is_sorted()).cloned());
        }
        all
    }

    #[test]
    fn the_dictionary_is_in_order_and_indices_go_both_ways() {
        for (k, order) in
            [(0, 0), (0, 3), (1, 0), (1, 1), (1, 7), (2, 2), (3, 4), (5, 3), (7, 2), (13, 1)]
        {
            let products = Eigenproducts::new(k, order).unwrap();
            let expected = by_definition(k, order);
            assert_eq!(products.len(), expected.len(), "k {k}, order {order}");
            for (i, factors) in expected.iter().enumerate() {
                assert_eq!(products.factors(i).as_ref(), Some(factors));
                assert_eq!(products.index(factors), Some(i));
                let reversed: Vec<usize> = factors.iter().rev().copied().collect();
                assert_eq!(products.index(&reversed), Some(i));
            }
            assert_eq!(products.factors(expected.len()), None);
            assert_eq!(products.index(&vec![1; order + 1]), None);
            assert_eq!(products.index(&[k + 1]), None);
            assert_eq!(products.index(&[0]), None);
        }
    }

    #[test]
    fn the_count_is_the_binomial_of_the_thesis() {
        for (k, order, count) in [(30, 2, 496), (29, 3, 4960), (20, 4, 10626), (100, 2, 5151)] {
            assert_eq!(Eigenproducts::new(k, order).unwrap().len(), count);
        }
    }

    #[test]
    fn too_many_products_are_refused() {
        for (k, order) in [(2, 256), (100_000, 2), (usize::MAX, 255), (usize::MAX, 1), (200, 200)] {
            let error = Eigenproducts::new(k, order).unwrap_err();
            assert!(matches!(error, Error::Argument { what: "order", .. }), "{error}");
        }
    }

    #[test]
    fn products_are_products_whatever_the_strides_and_threads() {
        for (n, k, order) in [(0, 3, 2), (1, 1, 3), (600, 3, 3), (257, 4, 2), (5, 0, 2), (5, 2, 0)]
        {
            let mut rng = Rng::new(7);
            let f = Mat::from_fn(n, k, |_, _| (rng.uniform() * 9.0).floor() - 4.0);
            let products = Eigenproducts::new(k, order).unwrap();
            let expected = Mat::from_fn(n, products.len(), |i, j| {
                products.factors(j).unwrap().iter().map(|&a| f[(i, a - 1)]).product::<f64>()
            });
            let mut out = Mat::from_fn(n, products.len(), |_, _| f64::NAN);
            for par in [Par::Seq, Par::Threads(2), Par::Threads(3)] {
                products.evaluate(f.as_ref(), out.as_mut(), par).unwrap();
                assert_eq!(out, expected);
            }
            let mut rows = Mat::from_fn(products.len(), n, |_, _| f64::NAN);
            products.evaluate(f.as_ref(), rows.as_mut().transpose_mut(), Par::Seq).unwrap();
            assert_eq!(rows.transpose(), expected);
        }
    }

    #[test]
    fn dirty_input_is_refused_by_name() {
        let products = Eigenproducts::new(2, 2).unwrap();
        let mut f = Mat::<f64>::ones(3, 2);
        let mut out = Mat::zeros(3, 6);
        f[(2, 1)] = f64::NAN;
        assert_eq!(
            products.evaluate(f.as_ref(), out.as_mut(), Par::Seq),
            Err(Error::NonFinite { what: "functions", index: (2, 1) })
        );
        let short = out.as_mut().subcols_mut(0, 5);
        let error = products.evaluate(Mat::ones(3, 2).as_ref(), short, Par::Seq).unwrap_err();
        assert!(matches!(error, Error::Shape { what: "out", .. }));
        let error = products.evaluate(Mat::ones(3, 3).as_ref(), out.as_mut(), Par::Seq);
        assert!(matches!(error, Err(Error::Shape { what: "functions", .. })));
    }
}
