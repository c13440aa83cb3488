//! Difference covers: few residues modulo P whose differences are all of them.
//!
//! When rank p holds the column blocks `p + D mod P`, every pair of blocks meets on some rank
//! exactly if D is a difference cover. About `sqrt(P)` blocks are the least possible; perfect
//! covers have `P = q^2 + q + 1` (the lines of a projective plane; Singer, 1938).

/// The largest modulus for which the shortest cover is searched for.
const SEARCHED: usize = 40;

/// Returns residues modulo `ranks >= 1`, ascending from 0, such that every residue is a difference
/// of two of them.
///
/// The cover is the shortest possible for up to 40 ranks. Beyond that it is a ruler of B. Wichmann
/// (1963), with at most `1.25 sqrt(ranks) + 4` residues.
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
    if ranks <= SEARCHED { shortest(ranks) } else { wichmann(ranks) }
}

/// Searches covers of k residues for the least k that has enough differences, then k + 1, ...
fn shortest(ranks: usize) -> Vec<usize> {
    match ranks {
        0 | 1 => return vec![0],
        // The difference 1 must be there, so that 0 and 1 are in some shift of any cover.
        2 | 3 => return vec![0, 1],
        _ => {}
    }
    for len in 3.. {
        let mut cover = vec![0, 1];
        let mut counts = vec![0_u32; ranks];
        counts[0] = 1;
        counts[1] = 1;
        counts[ranks - 1] += 1;
        if len * (len - 1) >= ranks - 1 && extend(&mut cover, &mut counts, len) {
            return cover;
        }
    }
    unreachable!("all residues are a cover")
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

/// Returns the shortest Wichmann ruler that measures every length up to half of `ranks`.
fn wichmann(ranks: usize) -> Vec<usize> {
    let half = ranks / 2;
    let marks = |r: usize, s: usize| 4 * r + s + 3;
    let length = |r: usize, s: usize| 4 * r * (r + s + 2) + 3 * (s + 1);
    let sides = 0..=half.isqrt();
    let (r, s) = sides
        .map(|r| (r, (0..).find(|&s| length(r, s) >= half).unwrap_or(0)))
        .min_by_key(|&(r, s)| marks(r, s))
        .unwrap_or((0, half));
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
        for ranks in (1..=300).chain([1000, 4095, 4096, 65_536]) {
            let cover = difference_cover(ranks);
            assert!(cover[0] == 0 && cover.is_sorted() && cover[cover.len() - 1] < ranks);
            assert!(covers(&cover, ranks), "{ranks}: {cover:?}");
        }
    }

    #[test]
    fn covers_are_as_short_as_said() {
        for (ranks, len) in
            [(1, 1), (2, 2), (3, 2), (4, 3), (7, 3), (8, 4), (13, 4), (21, 5), (31, 6)]
        {
            assert_eq!(difference_cover(ranks).len(), len, "{ranks}");
        }
        for ranks in (2..=5000).chain([65_536]) {
            let received = (difference_cover(ranks).len() - 1) as f64;
            let root = (ranks as f64).sqrt();
            assert!(received <= 1.25 * root + 3.0, "{ranks}: {received}");
            // The goal is 1.5 times the lower bound.
            assert!(received <= 1.5 * root, "{ranks}: {received} of {root}");
        }
    }
}
