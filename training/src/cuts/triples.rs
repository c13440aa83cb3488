//! Triples of parts, to measure associativity.

use catamaran::base::Rng;

use super::draw::below;
use super::pairs::canonical;
use super::regions::{Surface, union};
use super::{Cuts, Triple};

/// Number of attempts per triple.
const ATTEMPTS: usize = 200;

/// Adds up to `count` triples of parts of pairs. Both orders of the unions consist of unambiguous
/// pairs.
pub(super) fn find(surface: &Surface<'_>, count: usize, cuts: &mut Cuts, rng: &mut Rng) {
    if cuts.pairs.is_empty() {
        return;
    }
    for _ in 0..ATTEMPTS * count {
        if cuts.triples.len() == count {
            break;
        }
        let pick = |rng: &mut Rng| cuts.pairs[below(cuts.pairs.len(), rng)];
        let [one, other] = [pick(rng), pick(rng)];
        // Both pairs contain the middle part.
        let Some(&middle) = one.parts.iter().find(|part| other.parts.contains(part)) else {
            continue;
        };
        let end = |pair: [usize; 2]| if pair[0] == middle { pair[1] } else { pair[0] };
        let parts = [end(one.parts), middle, end(other.parts)];
        if parts[0] == parts[2] {
            continue;
        }
        let [a, _, c] = parts.map(|part| &cuts.masks[&part]);
        let unions = [one.union, other.union];
        let [ab, bc] = unions.map(|union| &cuts.masks[&union]);
        let whole = union(ab, c);
        // Neither order mirrors a part, so that both give the same union.
        let clear = [(ab, c), (a, bc)]
            .iter()
            .all(|(p, q)| canonical(surface, p, q).is_some_and(|[p, q]| union(&p, &q) == whole));
        let found = Triple { parts, unions, whole: super::id(&whole) };
        if clear && !cuts.triples.contains(&found) {
            cuts.keep(whole);
            cuts.triples.push(found);
        }
    }
}
