//! Difference covers: few residues modulo P whose differences are all of them.
//!
//! When rank p holds the column blocks `p + D mod P`, every pair of blocks meets on some rank
//! exactly if D is a difference cover. About `sqrt(P)` blocks are the least possible; perfect
//! covers have `P = q^2 + q + 1` ([`planes`](super::planes)).

use super::planes::{line, order_of_plane};

/// The lengths of the shortest covers, from that of modulus 1 on. Beyond them no search is made.
const SHORTEST: [u8; 40] = [
    1, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 6, 5, 6, 6, 6, 6, 6, 6, 6, 7, 7, 6, 7,
    7, 7, 7, 7, 7, 8, 7, 8,
];

/// Returns residues modulo `ranks >= 1`, ascending from 0, such that every residue is a difference
/// of two of them.
///
/// The cover is the shortest possible for up to 40 ranks, and for `q^2 + q + 1` ranks, q a power of
/// a prime up to 2^8. Otherwise it is a ruler of B. Wichmann (1963), with at most
/// `1.25 sqrt(ranks) + 4` residues.
///
/// ```
/// use catamaran::ranks::plan::difference_cover;
///
/// let cover = difference_cover(7);
/// for difference in 0..7 {
///     assert!(cover.iter().any(|i| cover.iter().any(|j| (7 + i - j) % 7 == difference)));
/// }
/// ```
pub fn difference_cover(ranks: usize) -> Vec<usize> {
    match (SHORTEST.get(ranks.saturating_sub(1)), order_of_plane(ranks)) {
        (Some(&len), _) => shortest(ranks, len.into()),
        (None, Some(order)) => line(order),
        (None, None) => wichmann(ranks),
    }
}

/// Returns the length of [`difference_cover`], without computing the cover.
pub(super) fn cover_len(ranks: usize) -> usize {
    match (SHORTEST.get(ranks.saturating_sub(1)), order_of_plane(ranks)) {
        (Some(&len), _) => len.into(),
        (None, Some(order)) => order + 1,
        (None, None) => {
            let (r, s) = sides(ranks / 2);
            marks(r, s)
        }
    }
}

/// Searches covers of `len` residues, which exist.
fn shortest(ranks: usize, len: usize) -> Vec<usize> {
    if ranks <= 1 {
        return vec![0];
    }
    // The difference 1 must be there, so that 0 and 1 are in some shift of any cover.
    let mut cover = vec![0, 1];
    let mut counts = vec![0_u32; ranks];
    for difference in [0, 1, ranks - 1] {
        counts[difference] += 1;
    }
    let found = extend(&mut cover, &mut counts, len);
    debug_assert!(found, "{len} of {ranks} residues");
    cover
}

/// Extends `cover` to `len` residues that cover everything, if that is possible; `counts` has the
/// number of times that each difference occurs.
fn extend(cover: &mut Vec<usize>, counts: &mut [u32], len: usize) -> bool {
    let ranks = counts.len();
    let missing = counts.iter().filter(|&&count| count == 0).count();
    let more = len - cover.len();
    if more == 0 {
        return missing == 0;
    }
    // Differences that further residues can still bring.
    if missing > 2 * (more * cover.len() + more * (more - 1) / 2) {
        return false;
    }
    for next in cover[cover.len() - 1] + 1..ranks {
        for &c in cover.iter() {
            counts[next - c] += 1;
            counts[ranks + c - next] += 1;
        }
        cover.push(next);
        if extend(cover, counts, len) {
            return true;
        }
        cover.pop();
        for &c in cover.iter() {
            counts[next - c] -= 1;
            counts[ranks + c - next] -= 1;
        }
    }
    false
}

/// Returns the number of marks of the Wichmann ruler with these parameters.
fn marks(r: usize, s: usize) -> usize {
    4 * r + s + 3
}

/// Returns the parameters r and s of the Wichmann ruler with the fewest marks that measures every
/// length up to `half`: `4 r (r + s + 2) + 3 (s + 1) >= half`.
fn sides(half: usize) -> (usize, usize) {
    let with = |r: usize| (r, half.saturating_sub(4 * r * (r + 2) + 3).div_ceil(4 * r + 3));
    // About 3 r + half / (4 r) marks, the fewest for r^2 = half / 12.
    let near = (half / 12).isqrt();
    let few = (near.saturating_sub(2)..=near + 2).map(with);
    few.min_by_key(|&(r, s)| marks(r, s)).unwrap_or((0, half))
}

/// Returns the shortest Wichmann ruler that measures every length up to half of `ranks`.
fn wichmann(ranks: usize) -> Vec<usize> {
    let (r, s) = sides(ranks / 2);
    let steps = [(1, r), (r + 1, 1), (2 * r + 1, r), (4 * r + 3, s), (2 * r + 2, r + 1), (1, r)];
    let mut cover = vec![0];
    for (step, times) in steps {
        for _ in 0..times {
            cover.push(cover[cover.len() - 1] + step);
        }
    }
    // A ruler longer than half of `ranks` may wrap around.
    for mark in &mut cover {
        *mark %= ranks;
    }
    cover.sort_unstable();
    cover.dedup();
    cover
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covers(cover: &[usize], ranks: usize) -> bool {
        let mut seen = vec![false; ranks];
        for &a in cover {
            for &b in cover {
                seen[(a + ranks - b) % ranks] = true;
            }
        }
        seen.iter().all(|&s| s)
    }

    #[test]
    fn every_difference_occurs() {
        for ranks in (1..=700).chain([1000, 1407, 4095, 4096, 65_536]) {
            let cover = difference_cover(ranks);
            assert_eq!(cover.len(), cover_len(ranks), "{ranks}");
            assert!(cover[0] == 0 && cover.is_sorted() && cover[cover.len() - 1] < ranks);
            assert!(covers(&cover, ranks), "{ranks}: {cover:?}");
        }
    }

    #[test]
    fn covers_are_as_short_as_said() {
        for (ranks, len) in
            [(1, 1), (2, 2), (3, 2), (4, 3), (7, 3), (8, 4), (13, 4), (21, 5), (31, 6), (73, 9)]
        {
            assert_eq!(difference_cover(ranks).len(), len, "{ranks}");
        }
        for ranks in (2..=5000).chain([65_536]) {
            let received = (cover_len(ranks) - 1) as f64;
            let root = (ranks as f64).sqrt();
            assert!(received <= 1.25 * root + 3.0, "{ranks}: {received}");
            // The goal is 1.5 times the lower bound.
            assert!(received <= 1.5 * root, "{ranks}: {received} of {root}");
        }
    }

    #[test]
    fn no_cover_of_few_ranks_is_shorter() {
        for ranks in 2..=28 {
            let len = cover_len(ranks);
            let mut counts = vec![0; ranks];
            for difference in [0, 1, ranks - 1] {
                counts[difference] += 1;
            }
            assert!(len == 2 || !extend(&mut vec![0, 1], &mut counts, len - 1), "{ranks}");
        }
    }

    #[test]
    fn no_other_ruler_of_this_form_has_fewer_marks() {
        let length = |r: usize, s: usize| 4 * r * (r + s + 2) + 3 * (s + 1);
        for half in (21..600).chain([2048, 32_768]) {
            let (r, s) = sides(half);
            assert!(length(r, s) >= half, "{half}");
            let all = (0..=half.isqrt()).map(|r| {
                let s = (0..).find(|&s| length(r, s) >= half).unwrap();
                marks(r, s)
            });
            assert_eq!(all.min(), Some(marks(r, s)), "{half}");
        }
    }
}
