//! Finds nearest neighbours among points in many dimensions.
//!
//! The search is exhaustive, by matrix products: in the 20 to 200 dimensions of spectral
//! embeddings, a k-d tree visits most of its leaves, and its visits are far slower than a product.

use std::ops::Range;

use faer::{Mat, MatRef, RowRef};

use crate::spectral::dense;
use catamaran::base::{Error, Par, Progress, Result, Tracker};
use catamaran::dense::zeros;

/// Numbers of queries and candidates of one product, so that their scores stay in the cache.
const QUERIES: usize = 64;
const CANDIDATES: usize = 512;

/// Number of candidates of one query that may be nearest, after which they are compared exactly.
const OPEN: usize = 32;

/// Returns the row of `candidates` (m x d) that is nearest to each row of `queries` (n x d), in the
/// Euclidean norm; the first one of equally near rows.
///
/// The distances that decide are sums of squared differences from the first coordinate to the last,
/// so that the result is exactly that of a direct search, for every `par`. The search takes
/// `2 n m d` flops.
///
/// ```
/// use catamaran::{Par, base::Progress, faer::mat};
/// use catamaran_geometry::spectral::functional_map::nearest_rows;
///
/// let (queries, candidates) = (mat![[0.9, 0.1]], mat![[0.0, 0.0], [1.0, 0.0]]);
/// let found = nearest_rows(queries.as_ref(), candidates.as_ref(), Par::Seq, Progress::none())?;
/// assert_eq!(found, [1]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when dimensions differ, [`Error::NonFinite`], [`Error::Argument`] when there
/// are queries but no candidates, or 2^32 candidates or more; [`Error::OutOfMemory`],
/// [`Error::Cancelled`].
pub fn nearest_rows(
    queries: MatRef<'_, f64>,
    candidates: MatRef<'_, f64>,
    par: Par,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    let (n, d) = queries.shape();
    Error::check_shape("candidates", (candidates.nrows(), d), candidates.shape())?;
    dense::check_finite("queries", queries)?;
    dense::check_finite("candidates", candidates)?;
    if (candidates.nrows() == 0 && n > 0) || u32::try_from(candidates.nrows()).is_err() {
        let why = format!("must be 1 to 2^32 - 1 rows, are {}", candidates.nrows());
        return Err(Error::Argument { what: "candidates", why });
    }
    // One column for each point, so that the coordinates of a point are contiguous.
    let queries = transposed(queries)?;
    let candidates = transposed(candidates)?;
    let squares = |points: &Mat<f64>| -> Vec<f64> {
        (0..points.ncols()).map(|j| points.col(j).squared_norm_l2()).collect()
    };
    let norms = squares(&candidates);
    let search = Search {
        queries: queries.as_ref(),
        candidates: candidates.as_ref(),
        half_norms: norms.iter().map(|norm| 0.5 * norm).collect(),
        longest: norms.iter().copied().fold(0.0, f64::max),
        query_norms: squares(&queries),
    };
    let tracker = Tracker::new(progress, n as f64);
    let nearest = par.map_blocks(n, QUERIES, |block| {
        if tracker.state().is_break() {
            return vec![];
        }
        let nearest = search.run(block);
        // The remaining blocks check the state of the tracker.
        let _ = tracker.add(nearest.len() as f64);
        nearest
    });
    tracker.finish().map(|()| nearest.concat())
}

fn transposed(points: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let mut out = zeros(points.ncols(), points.nrows())?;
    out.copy_from(points.transpose());
    Ok(out)
}

struct Search<'a> {
    /// d x n.
    queries: MatRef<'a, f64>,
    /// d x m.
    candidates: MatRef<'a, f64>,
    half_norms: Vec<f64>,
    query_norms: Vec<f64>,
    /// Largest squared norm of a candidate.
    longest: f64,
}

/// The state of the search for one query.
struct Best {
    /// Least score so far, `|c|^2 / 2 - q . c`.
    score: f64,
    /// Largest difference that rounding may add to two scores.
    slack: f64,
    /// Candidates whose score was within the slack of the least score when they were found,
    /// ascending.
    open: Vec<u32>,
}

impl Search<'_> {
    /// Returns the nearest candidates of these queries.
    fn run(&self, block: Range<usize>) -> Vec<u32> {
        let d = self.queries.nrows();
        let queries = self.queries.subcols(block.start, block.len());
        // Twice the error bound of a computed score, `(d + 2) u (|c|^2 + |q| |c|)`, plus one more
        // for the exact distance.
        let unit = 4.0 * (d as f64 + 2.0) * f64::EPSILON;
        let mut best: Vec<Best> = block
            .map(|j| {
                let size = self.query_norms[j] + 2.0 * self.longest;
                Best { score: f64::INFINITY, slack: unit * size, open: Vec::new() }
            })
            .collect();
        let mut scores = Mat::<f64>::zeros(CANDIDATES.min(self.candidates.ncols()), best.len());
        for start in (0..self.candidates.ncols()).step_by(CANDIDATES) {
            let count = CANDIDATES.min(self.candidates.ncols() - start);
            let mut scores = scores.as_mut().subrows_mut(0, count);
            faer::linalg::matmul::matmul(
                scores.as_mut(),
                faer::Accum::Replace,
                self.candidates.subcols(start, count).transpose(),
                queries,
                -1.0,
                faer::Par::Seq,
            );
            let half_norms = &self.half_norms[start..start + count];
            for (j, best) in best.iter_mut().enumerate() {
                let query = queries.col(j).transpose();
                for (i, half_norm) in half_norms.iter().enumerate() {
                    let score = scores[(i, j)] + half_norm;
                    if score <= best.score + best.slack {
                        best.score = best.score.min(score);
                        best.open.push((start + i) as u32);
                        if best.open.len() > OPEN {
                            let winner = self.nearest_of(query, &best.open);
                            best.open.clear();
                            best.open.push(winner);
                        }
                    }
                }
            }
        }
        let winner =
            |(j, best): (usize, &Best)| self.nearest_of(queries.col(j).transpose(), &best.open);
        best.iter().enumerate().map(winner).collect()
    }

    /// Returns the nearest of these candidates, by the definition.
    fn nearest_of(&self, query: RowRef<'_, f64>, open: &[u32]) -> u32 {
        let mut nearest = (f64::INFINITY, 0);
        for &candidate in open {
            let point = self.candidates.col(candidate as usize);
            let distance: f64 = (0..query.ncols())
                .map(|i| {
                    let difference = query[i] - point[i];
                    difference * difference
                })
                .sum();
            if distance < nearest.0 {
                nearest = (distance, candidate);
            }
        }
        nearest.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    use catamaran::base::Rng;

    fn by_definition(queries: &Mat<f64>, candidates: &Mat<f64>) -> Vec<u32> {
        (0..queries.nrows())
            .map(|i| {
                let distance = |j: usize| -> f64 {
                    (0..queries.ncols())
                        .map(|l| (queries[(i, l)] - candidates[(j, l)]).powi(2))
                        .sum()
                };
                let mut best = 0;
                for j in 0..candidates.nrows() {
                    if distance(j) < distance(best) {
                        best = j;
                    }
                }
                best as u32
            })
            .collect()
    }

    #[test]
    fn the_search_is_exact_for_any_number_of_threads() {
        for (n, m, d) in [(0, 0, 3), (0, 4, 3), (1, 1, 1), (7, 5, 2), (131, 1031, 13), (65, 513, 0)]
        {
            let mut rng = Rng::new(5);
            let queries = Mat::from_fn(n, d, |_, _| rng.normal());
            let candidates = Mat::from_fn(m, d, |_, _| rng.normal());
            let expected = by_definition(&queries, &candidates);
            for par in [Par::Seq, Par::Threads(2), Par::Threads(3)] {
                let found =
                    nearest_rows(queries.as_ref(), candidates.as_ref(), par, Progress::none())
                        .unwrap();
                assert_eq!(found, expected, "{n} {m} {d}");
            }
        }
    }

    #[test]
    fn of_equals_the_first_is_taken() {
        let mut rng = Rng::new(9);
        let candidates = Mat::from_fn(700, 5, |i, j| ((i % 50) * 7 + j) as f64 / 3.0);
        let queries = Mat::from_fn(50, 5, |i, j| candidates[(i, j)] + 1e-9 * rng.normal());
        let found = nearest_rows(queries.as_ref(), candidates.as_ref(), Par::Seq, Progress::none())
            .unwrap();
        assert_eq!(found, (0..50).collect::<Vec<u32>>());
        let same = Mat::from_fn(700, 3, |_, j| j as f64 * 0.1);
        let found =
            nearest_rows(same.as_ref(), same.as_ref(), Par::Threads(2), Progress::none()).unwrap();
        assert!(found.iter().all(|&i| i == 0));
    }

    #[test]
    fn neighbours_closer_than_the_rounding_of_products_are_told_apart() {
        // Far from the origin, products lose the difference of the distances; the definition does
        // not.
        let candidates =
            Mat::from_fn(40, 2, |i, j| if j == 0 { 1e8 + i as f64 * 1e-7 } else { 0.0 });
        let found =
            nearest_rows(candidates.as_ref(), candidates.as_ref(), Par::Seq, Progress::none())
                .unwrap();
        assert_eq!(found, by_definition(&candidates, &candidates));
    }

    #[test]
    fn dirty_input_is_refused_by_name_and_work_can_be_cancelled() {
        let points = Mat::<f64>::zeros(3, 2);
        let call = |q: &Mat<f64>, c: &Mat<f64>| {
            nearest_rows(q.as_ref(), c.as_ref(), Par::Seq, Progress::none())
        };
        let nan = Mat::from_fn(3, 2, |i, _| if i == 1 { f64::NAN } else { 0.0 });
        assert_eq!(call(&nan, &points), Err(Error::NonFinite { what: "queries", index: (1, 0) }));
        assert_eq!(
            call(&points, &nan),
            Err(Error::NonFinite { what: "candidates", index: (1, 0) })
        );
        assert!(matches!(call(&points, &Mat::zeros(3, 1)), Err(Error::Shape { .. })));
        let none = call(&points, &Mat::zeros(0, 2));
        assert!(matches!(none, Err(Error::Argument { what: "candidates", .. })));
        let cancel = |_: f64| ControlFlow::Break(());
        let stopped = nearest_rows(points.as_ref(), points.as_ref(), Par::Seq, (&cancel).into());
        assert_eq!(stopped, Err(Error::Cancelled));
    }
}
