//! Decimation to as few vertices as a distance from the input allows.

use super::difference::{Measured, largest};
use super::options::{DecimateOptions, Method};
use super::result::Decimation;
use super::size::vertices_for_edge_length;
use super::solver::decimate;
use crate::mesh::{TriMesh, manifold};
use catamaran::base::{Error, Par, Result, positive};

/// Number of vertices of the first try.
const FIRST: usize = 500;

/// Number of vertices up to which results may have more vertices than the input, as meshes of few
/// large faces need.
const MORE: usize = 100_000;

/// The search ends when the least number that was found is at most this share above one that is too
/// small.
const CLOSE: f64 = 0.02;

/// Most that the number changes from one try to the next, as a factor.
const STEP: f64 = 8.0;

/// Part of the gap between a number that is too small and one that is large enough, in logarithms,
/// at both ends of which no try is made: a share of it is gained with each try.
const MARGIN: f64 = 0.2;

/// Decimates `mesh` to the fewest vertices, as far as the search finds them, for which no point of
/// either surface is farther from the other one than `error`, in units of length:
/// [`Difference::hausdorff_bound`](super::Difference::hausdorff_bound), which is measured for every
/// try, is at most `error`.
///
/// The distance does not fall with every vertex more. The search ends when it knows a number at
/// most 2 % (or 1) smaller that is not enough. The result is that of
/// [`decimate`](super::decimate()) with its number of vertices.
///
/// ```
/// use catamaran_geometry::{decimate::{DecimateOptions, decimate_within}, mesh::families};
///
/// let sphere = families::icosphere(4)?;
/// let found = decimate_within(&sphere, 0.05, &DecimateOptions::new().relaxation(4))?;
/// assert!(found.mesh.vertices().len() < 200);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when `error` is not positive and finite, or can't be reached. With
/// resampling, the search tries at most as many vertices as edges of the length `error` need, but
/// not more than 100,000, or as many as the input has when it is cut to a manifold, whichever is
/// more; without it, at most as many as the input has. Those of [`decimate`](super::decimate()).
pub fn decimate_within(
    mesh: &TriMesh,
    error: f64,
    options: &DecimateOptions<'_>,
) -> Result<Decimation> {
    options.progress.watch(|| search(mesh, error, options))
}

fn search(mesh: &TriMesh, error: f64, options: &DecimateOptions<'_>) -> Result<Decimation> {
    let input = Measured::new(mesh)?;
    positive("error", error)?;
    let most = most_vertices(mesh, error, options)?;
    let mut bracket = Bracket { error, most, low: None, high: None };
    let mut best = None;
    let mut done = 0.0;
    while let Some(n) = bracket.next() {
        // Each try takes half of what is left of the progress: the number of tries is unknown.
        let after = (1.0 + done) / 2.0;
        let part = options.progress.part(done..after);
        done = after;
        match decimate(mesh, n, &options.progress(part)) {
            Ok(found) => {
                let away = distance(&input, &found.mesh, error, options.par)?;
                if bracket.put(n, away) {
                    best = Some(found);
                }
            }
            // The topology needs more vertices.
            Err(Error::Argument { what: "n", .. }) if n < most => {
                bracket.put(n, f64::INFINITY);
            }
            Err(refused) => return Err(refused),
        }
    }
    best.ok_or_else(|| {
        let reached = bracket.low.map_or(f64::INFINITY, |low| low.1);
        let why = format!(
            "{error:e} can't be reached: with {most} vertices, as many as are tried, the distance \
             is {reached:.4e}"
        );
        Error::Argument { what: "error", why }
    })
}

/// Returns the largest number of vertices that is tried: that of the input, cut to a manifold, or,
/// if that is less and edges are split, as many as edges of the length `error` need, up to a bound.
fn most_vertices(mesh: &TriMesh, error: f64, options: &DecimateOptions<'_>) -> Result<usize> {
    let (part, _) = manifold(mesh)?;
    let there = part.mesh.vertices().len();
    if !options.resample || options.method == Method::Thesis {
        return Ok(there);
    }
    let fine = vertices_for_edge_length(mesh.area(), error).unwrap_or(MORE).min(MORE);
    Ok(there.max(fine))
}

/// Returns an upper bound of the distance; where vertices are farther than `error`, their distance.
fn distance(input: &Measured<'_>, found: &TriMesh, error: f64, par: Par) -> Result<f64> {
    let found = input.beside(found)?;
    let squares = input.squares(&found, par);
    let at_vertices = largest(&squares);
    if at_vertices > error {
        return Ok(at_vertices);
    }
    input.bound(&found, &squares, par)
}

/// The results of the tries so far that bound the number of vertices.
struct Bracket {
    error: f64,
    /// The largest number that is tried.
    most: usize,
    /// The largest number known to be too small, and its distance.
    low: Option<(usize, f64)>,
    /// The least number known to be large enough, and its distance.
    high: Option<(usize, f64)>,
}

impl Bracket {
    /// Adds a result; returns whether it is the best one so far.
    fn put(&mut self, n: usize, away: f64) -> bool {
        let reached = away <= self.error;
        *if reached { &mut self.high } else { &mut self.low } = Some((n, away));
        reached
    }

    /// Returns the number to try next; `None` when the search is at its end.
    fn next(&self) -> Option<usize> {
        match (self.low, self.high) {
            (None, None) => Some(FIRST.min(self.most)),
            (Some((low, away)), None) => {
                let wanted = low as f64 * (away / self.error).clamp(1.2, STEP);
                (low < self.most).then(|| (wanted.ceil() as usize).min(self.most))
            }
            (None, Some((high, away))) => {
                // The distance of smooth surfaces is inversely proportional to the number.
                let wanted = high as f64 * (away / self.error).clamp(1.0 / STEP, 0.95);
                (high > 1).then(|| (wanted as usize).clamp(1, high - 1))
            }
            (Some((low, far)), Some((high, near))) => {
                let close = ((CLOSE * high as f64) as usize).max(1);
                (high - low > close).then(|| self.between((low, far), (high, near)))
            }
        }
    }

    /// Returns the number between two at which a power of the number would be the wanted distance.
    fn between(&self, (low, far): (usize, f64), (high, near): (usize, f64)) -> usize {
        let share = (far / self.error).ln() / (far / near).ln();
        let share = if share.is_finite() { share.clamp(MARGIN, 1.0 - MARGIN) } else { 0.5 };
        let wanted = low as f64 * (high as f64 / low as f64).powf(share);
        (wanted.round() as usize).clamp(low + 1, high - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the numbers that are tried for a distance that is a function of the number.
    fn tries(error: f64, most: usize, away: impl Fn(usize) -> f64) -> (Vec<usize>, Option<usize>) {
        let mut bracket = Bracket { error, most, low: None, high: None };
        let mut tries = Vec::new();
        while let Some(n) = bracket.next() {
            tries.push(n);
            assert!(n >= 1 && n <= most && tries.len() < 40, "{tries:?}");
            bracket.put(n, away(n));
        }
        (tries, bracket.high.map(|high| high.0))
    }

    #[test]
    fn an_input_that_is_cut_may_keep_all_the_vertices_of_the_cut() {
        // Pages that share an edge are cut from each other.
        let book = crate::mesh::families::pages(100).unwrap();
        let found = decimate_within(&book, 1.0, &DecimateOptions::new()).unwrap();
        assert_eq!(found.mesh.vertices().len(), 300);
    }

    #[test]
    fn the_least_number_is_found_within_two_per_cent_in_few_tries() {
        for needed in [1, 2, 5, 77, 499, 500, 501, 4321, 70_000, 100_000] {
            for power in [0.5, 1.0, 2.0] {
                let away = |n: usize| (needed as f64 / n as f64).powf(power);
                let (tries, found) = tries(1.0, 100_000, away);
                let found = found.unwrap();
                assert!(found >= needed, "{found} for {needed}");
                let above = (found - needed) as f64;
                assert!(above <= (0.02 * found as f64).max(1.0), "{found} for {needed}");
                assert!(tries.len() <= 16, "{tries:?} for {needed}");
            }
        }
        let (_, none) = tries(1.0, 1000, |_| 2.0);
        assert_eq!(none, None);
        // The topology needs 60 vertices, with which the distance is small enough.
        let (_, found) = tries(1.0, 1000, |n| if n < 60 { f64::INFINITY } else { 0.1 });
        assert!((60..=61).contains(&found.unwrap()));
    }
}
