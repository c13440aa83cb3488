use super::double::{DoubleDouble, TripleSum};
use crate::base::{Error, Par, Result};
use crate::rows::{About, ExtendedGram};

/// Returns the Gram matrix of `[H + L, B]` (n + k columns) from that of `[H, L, B]`, where H and L
/// have n columns each: the rounded parts and the rests of columns in double-double.
///
/// Powers of x, products and differences of columns often have more digits than an f64. Rounding
/// them changes the problem: the least-squares solution for the powers of Filip (NIST) in f64 has
/// only eight digits of the certified one.
///
/// ```
/// use catamaran::rows::ExtendedGram;
/// use catamaran::faer::mat;
/// use catamaran::solve::sum_of_pairs;
///
/// // One row: h = 1, l = 2^-60, b = 3.
/// let l = 2f64.powi(-60);
/// let c = mat![[1.0, l, 3.0], [l, l * l, 3.0 * l], [3.0, 3.0 * l, 9.0]];
/// let gram = sum_of_pairs(&ExtendedGram::from_f64(c.as_ref(), 1, &[])?, 1)?;
/// assert_eq!(gram.entry(0, 0), [1.0, 2.0 * l, l * l]);
/// assert_eq!(gram.entry(1, 0), [3.0, 3.0 * l, 0.0]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when the matrix has fewer than `2 n` columns, [`Error::OutOfMemory`].
pub fn sum_of_pairs(gram: &ExtendedGram, n: usize) -> Result<ExtendedGram> {
    let columns = gram.n();
    if n > columns / 2 {
        let why = format!("the matrix has {columns} columns, too few for {n} pairs");
        return Err(Error::Argument { what: "n", why });
    }
    // The columns that make up column j.
    let sources = |j: usize| if j < n { vec![j, n + j] } else { vec![n + j] };
    let mean = |j: usize| {
        let double = |j: usize| {
            let [hi, lo] = gram.mean()[j];
            DoubleDouble::new(hi, lo)
        };
        let sum = sources(j).into_iter().map(double).reduce(|a, b| a + b).unwrap_or_default();
        [sum.hi, sum.lo]
    };
    let about = About {
        exact: gram.is_exact(),
        rows: gram.rows(),
        observations: gram.observations(),
        weight: gram.weight(),
        // The rests of columns, their second source, may vanish.
        vanished: (0..columns - n).filter(|&j| gram.vanished().contains(&sources(j)[0])).collect(),
        mean: (0..columns - n).take_while(|_| !gram.mean().is_empty()).map(mean).collect(),
    };
    ExtendedGram::from_entries(columns - n, about, Par::Seq, |i, j| {
        let mut sum = TripleSum::default();
        for p in sources(i) {
            for q in sources(j) {
                sum.add_parts(gram.entry(p, q));
            }
        }
        sum.parts()
    })
}
