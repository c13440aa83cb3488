//! Finds outliers: samples to which a tour makes a long detour.

use super::proximity::Proximity;

/// Least length of the detour to an outlier, relative to the median distance of successive samples.
/// In bench/record/amd-epyc-2c-2026-11-28/curve-outliers.md, 2 drops 3.3 % of random samples of a
/// curve without outliers (3: 0.4 %), and 4 finds up to 18 % fewer outliers than 3.
const DETOUR: f64 = 3.0;

/// Largest number of successive samples that are outliers; three can be a curve.
const RUN: usize = 2;

/// Returns the outliers of a tour through at least four samples, those with the longest detours
/// first. Neighbours of an outlier stay, since leaving it out shortens the ways to them.
///
/// The detour to a run of samples is what the tour is shorter by if it goes past the run, apart
/// from the way between samples of the run. At the ends of an open curve, where there is no way
/// back and gaps are often long, half the way counts.
pub(super) fn outliers(proximity: &Proximity, tour: &[u32], open: bool) -> Vec<u32> {
    let n = tour.len();
    let distance = |i: usize, j: usize| proximity.distance(tour[i % n], tour[j % n]);
    let mut gaps: Vec<f64> = (0..n - usize::from(open)).map(|i| distance(i, i + 1)).collect();
    gaps.sort_unstable_by(f64::total_cmp);
    let limit = DETOUR * gaps[gaps.len() / 2];

    let mut runs: Vec<(f64, usize, usize)> = Vec::new();
    for len in 1..=RUN {
        let starts = if open { 0..n + 1 - len } else { 0..n };
        for first in starts {
            let (before, last) = (first + n - 1, first + len - 1);
            let (at_start, at_end) = (open && first == 0, open && last == n - 1);
            let detour = match (at_start, at_end) {
                (true, _) => distance(last, last + 1) / 2.0,
                (_, true) => distance(before, first) / 2.0,
                _ => {
                    distance(before, first) + distance(last, last + 1) - distance(before, last + 1)
                }
            };
            if detour > limit {
                runs.push((detour, first, len));
            }
        }
    }
    runs.sort_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));

    let mut is_out = vec![false; n];
    let mut found = Vec::new();
    for (_, first, len) in runs {
        if (first + n - 1..=first + n + len).any(|i| is_out[i % n]) {
            continue;
        }
        for i in first..first + len {
            is_out[i % n] = true;
            found.push(tour[i % n]);
        }
    }
    found
}
