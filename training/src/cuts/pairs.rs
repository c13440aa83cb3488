//! Pairs of parts whose union is unambiguous.

use catamaran::Result;
use catamaran::base::Rng;

use super::draw::below;
use super::regions::{Mask, Surface, overlap, union};
use super::{Cuts, OVERLAP, Pair};

/// Unions are ambiguous when their areas differ by less than this share.
const DOUBT: f64 = 0.02;

/// Number of attempts per pair.
const ATTEMPTS: usize = 30;

/// Smallest number of interior vertices of a part, so that it still has a spectrum when 30 % of the
/// vertices are removed.
const INSIDE: usize = 60;

/// Smallest share of the union that each part must add.
const LEAST_GAIN: f64 = 0.05;

/// Adds up to `count` pairs of a region of `first` and a region of `second`, each as it is or
/// mirrored.
pub(super) fn of_regions(
    surface: &Surface<'_>,
    [first, second]: [&[Mask]; 2],
    count: usize,
    cuts: &mut Cuts,
    rng: &mut Rng,
) {
    let wanted = cuts.pairs.len() + count;
    for _ in 0..ATTEMPTS * count {
        if cuts.pairs.len() == wanted || first.is_empty() || second.is_empty() {
            break;
        }
        let (a, b) = (below(first.len(), rng), below(second.len(), rng));
        add(surface, &first[a], &second[b], cuts);
    }
}

/// Adds up to `count` pairs that split a region: the complete shape first, then the regions in
/// turn.
pub(super) fn by_splitting(
    surface: &Surface<'_>,
    regions: &[Mask],
    count: usize,
    cuts: &mut Cuts,
    rng: &mut Rng,
) -> Result<()> {
    let complete = vec![true; surface.len()];
    let of_complete = count.div_ceil(4);
    let mut found = 0;
    for attempt in 0..ATTEMPTS * count {
        if found == count {
            break;
        }
        let region = match regions {
            [] => &complete,
            _ if found < of_complete => &complete,
            _ => &regions[attempt % regions.len()],
        };
        let [a, b] = split(surface, region, rng)?;
        found += usize::from(add(surface, &a, &b, cuts));
    }
    Ok(())
}

/// Splits a region in two parts: each contains the vertices that are nearer to one of two vertices,
/// and a band beyond the middle.
fn split(surface: &Surface<'_>, region: &[bool], rng: &mut Rng) -> Result<[Mask; 2]> {
    let inside: Vec<usize> = (0..surface.len()).filter(|&v| region[v]).collect();
    let pick = |rng: &mut Rng| inside[below(inside.len(), rng)] as u32;
    let (first, second) = (pick(rng), pick(rng));
    let (to_first, to_second) = (surface.distances(first)?, surface.distances(second)?);
    let band = (0.1 + 0.4 * rng.uniform()) * to_first[second as usize];
    let part = |near: &[f64], far: &[f64]| {
        let raw: Mask = (0..surface.len()).map(|v| region[v] && near[v] < far[v] + band).collect();
        // Smooths only the edges in the interior of the region.
        let smooth = surface.smoothed(&raw);
        let kept: Mask = (0..surface.len()).map(|v| region[v] && (smooth[v] || raw[v])).collect();
        surface.largest_piece(&kept)
    };
    Ok([part(&to_first, &to_second), part(&to_second, &to_first)])
}

/// Adds the pair, or the mirror image to which its spectra may belong as well and that has the
/// least union, on the left. Returns whether it was added: it must be a valid, unambiguous and new
/// pair.
fn add(surface: &Surface<'_>, a: &[bool], b: &[bool], cuts: &mut Cuts) -> bool {
    let Some([a, b]) = canonical(surface, a, b) else { return false };
    let all = union(&a, &b);
    let mut parts = [super::id(&a), super::id(&b)];
    parts.sort_unstable();
    if cuts.pairs.iter().any(|pair| pair.parts == parts) {
        return false;
    }
    cuts.keep(a);
    cuts.keep(b);
    let union = cuts.keep(all);
    cuts.pairs.push(Pair { parts, union });
    true
}

/// Returns why two parts with this union are not a valid pair; `None` if they are.
pub(crate) fn no_pair(
    surface: &Surface<'_>,
    parts: [&[bool]; 2],
    whole: &[bool],
) -> Option<&'static str> {
    let area = surface.area(whole);
    if parts.iter().any(|part| surface.inside(part) < INSIDE) {
        return Some("one has too few interior vertices");
    }
    if overlap(parts[0], parts[1]) < OVERLAP {
        return Some("they have too few common vertices");
    }
    let adds_too_little = |part: &[bool]| area - surface.area(part) < LEAST_GAIN * area;
    parts.into_iter().any(adds_too_little).then_some("one adds too little to the union")
}

/// Returns the two parts, mirrored if necessary; `None` when they overlap too little, one adds too
/// little, or the least union is ambiguous.
pub(crate) fn canonical(surface: &Surface<'_>, a: &[bool], b: &[bool]) -> Option<[Mask; 2]> {
    let other = surface.mirrored(b);
    let unions = [union(a, b), union(a, &other)];
    let areas = [0, 1].map(|i| surface.area(&unions[i]));
    // Both give the same class when one of the parts is its own mirror image, or the unions are
    // mirror images of each other.
    let same = unions[0] == unions[1] || surface.mirrored(&unions[0]) == unions[1];
    if !same && (areas[0] - areas[1]).abs() < DOUBT * areas[0].max(areas[1]) {
        return None;
    }
    let (b, whole) = match areas[0] <= areas[1] {
        true => (b.to_vec(), &unions[0]),
        false => (other, &unions[1]),
    };
    if no_pair(surface, [a, &b], whole).is_some() {
        return None;
    }
    match surface.leaning(whole) >= 0.0 {
        true => Some([a.to_vec(), b]),
        false => Some([surface.mirrored(a), surface.mirrored(&b)]),
    }
}
