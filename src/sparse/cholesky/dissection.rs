//! Nested dissection of large graphs (George 1973): vertices that separate parts of the graph come
//! after those parts. One hierarchy of coarser graphs serves all cuts (Karypis and Kumar, A fast
//! and high quality multilevel scheme for partitioning irregular graphs, 1998).

use super::coarse::Weighted;
use super::graph::{Graph, Lists, Looks, NONE};
use super::halves::halved;
use crate::base::{Result, Rng, push, repeated, reserved};

/// Vertices of the least graph that is dissected: smaller surfaces fill in as little without.
const LEAST: usize = 100_000;

/// Vertices of a part, at least.
const PART: usize = 10_000;

/// Most halvings on the way to a part.
const DEEPEST: u32 = 10;

/// Vertices of the coarsest graph for each part, at most.
const COARSEST: usize = 256;

/// Vertices of graphs that are read in their own order, for speed.
const LARGE: usize = 300_000;

/// Rounds in which vertices at the border of parts move.
const ROUNDS: usize = 4;

/// How much heavier than the mean a part may be, relative to it.
const SLACK: f64 = 0.2;

/// Returns the stages in which vertices should be eliminated: those of the parts of a graph, and
/// then those that separate them. `None` for graphs that are not large enough, and for those that
/// have no small separators.
pub(super) fn dissected(graph: &Graph) -> Result<Option<Lists>> {
    let n = graph.n();
    if n < LEAST {
        return Ok(None);
    }
    let depth = (n / PART).ilog2().min(DEEPEST);
    let weighted = Weighted::new(graph.clone())?;
    let Some(part) = parts(weighted, depth, SLACK)? else { return Ok(None) };
    let stages = separated(graph, &part, depth)?;
    let separators = n - stages.starts[1 << depth] as usize;
    Ok((separators <= n / 4).then_some(stages))
}

/// Returns the part of each vertex, of `2^depth`. Bits of its number, from the highest one, are the
/// halves that it is in. A half has at most `1 + slack` times half of the weight. `None` where
/// graphs do not become coarse enough, because too few of their vertices find a partner.
pub(super) fn parts(graph: Weighted, depth: u32, slack: f64) -> Result<Option<Vec<u32>>> {
    let mut rng = Rng::new(1);
    let mut levels = Vec::new();
    let mut coarsest = graph;
    while coarsest.graph.n() > COARSEST << depth {
        let n = coarsest.graph.n();
        let (coarser, into) = coarsest.coarser((n <= LARGE).then_some(&mut rng))?;
        if coarser.graph.n() * 10 > 9 * n {
            return Ok(None);
        }
        push(&mut levels, (std::mem::replace(&mut coarsest, coarser), into))?;
    }
    let n = coarsest.graph.n();
    let mut part = repeated(0u32, n)?;
    let mut place = repeated(NONE, n)?;
    for level in 0..depth {
        let members = Lists::sorted(&part, 1 << level)?;
        for k in 0..members.len() {
            let members = members.of(k);
            let half = halved(&coarsest.of(members, &mut place)?, slack, &mut rng)?;
            for (&v, is_second) in members.iter().zip(half) {
                part[v as usize] = 2 * k as u32 + u32::from(is_second);
            }
        }
    }
    refine(&coarsest, &mut part, depth, slack)?;
    while let Some((finer, into)) = levels.pop() {
        let mut finer_part = reserved(into.len())?;
        finer_part.extend(into.iter().map(|&c| part[c as usize]));
        part = finer_part;
        refine(&finer, &mut part, depth, slack)?;
    }
    Ok(Some(part))
}

/// Returns the weight of an edge between two parts: the number of halvings below the one that has
/// them in different halves, and one more.
fn height(part: u32, other: u32) -> u32 {
    u32::BITS - (part ^ other).leading_zeros()
}

/// Moves vertices at the borders of parts to other parts where the edges between parts, each times
/// its [`height`], then weigh less, or as much while the parts become more even.
fn refine(graph: &Weighted, part: &mut [u32], depth: u32, slack: f64) -> Result<()> {
    let n = graph.graph.n();
    let mut weights = repeated(0u64, 1 << depth)?;
    for v in 0..n {
        weights[part[v] as usize] += u64::from(graph.vertices[v]);
    }
    let most = ((1.0 + slack) * graph.total() as f64) as u64 >> depth;
    let mut near: Vec<(u32, u32)> = Vec::new();
    let mut looks = Looks::default();
    for _ in 0..ROUNDS {
        let mut moves = 0;
        for v in 0..n {
            let own = part[v];
            looks.add(graph.graph.degree(v))?;
            if graph.graph.of(v).iter().all(|&other| part[other as usize] == own) {
                continue;
            }
            near.clear();
            for (other, weight) in graph.edges(v) {
                match near.iter_mut().find(|(k, _)| *k == part[other]) {
                    Some((_, sum)) => *sum += weight,
                    None => push(&mut near, (part[other], weight))?,
                }
            }
            let cost = |k: u32| near.iter().map(|&(other, w)| height(k, other) * w).sum::<u32>();
            let weight = u64::from(graph.vertices[v]);
            let mut best = (cost(own), weights[own as usize], own);
            for &(k, _) in near.iter().filter(|(k, _)| *k != own) {
                let after = weights[k as usize] + weight;
                if after <= most || after < weights[own as usize] {
                    best = best.min((cost(k), after, k));
                }
            }
            if best.2 != own {
                weights[own as usize] -= weight;
                weights[best.2 as usize] += weight;
                part[v] = best.2;
                moves += 1;
            }
        }
        if moves * 1000 < n {
            break;
        }
    }
    Ok(())
}

/// Returns the stages of elimination: one for each part, and one for each halving, from the last to
/// the first, of the fewest vertices without which no edges are between the halves.
fn separated(graph: &Graph, part: &[u32], depth: u32) -> Result<Lists> {
    let mut cut: Vec<[u32; 2]> = Vec::new();
    let mut looks = Looks::default();
    for v in 0..part.len() {
        for &other in graph.of(v) {
            if part[v] < part[other as usize] {
                push(&mut cut, [v as u32, other])?;
            }
        }
        looks.add(graph.degree(v))?;
    }
    let mut stage = reserved(part.len())?;
    stage.extend_from_slice(part);
    let parts = 1u32 << depth;
    for (stage, halving) in stage.iter_mut().zip(separator(&cut, part)?) {
        if halving != NONE {
            *stage = parts + halving;
        }
    }
    Lists::sorted(&stage, (parts + depth) as usize)
}

/// Returns for each vertex the halving that it separates, counted from the last one, or [`NONE`]:
/// for each halving the fewest vertices without which none of the edges is between its halves.
/// `cut` are the edges between parts, from the part of the lower number.
pub(super) fn separator(cut: &[[u32; 2]], part: &[u32]) -> Result<Vec<u32>> {
    let below = |&[v, other]: &[u32; 2]| height(part[v as usize], part[other as usize]) - 1;
    let mut by_halving: Vec<u32> = reserved(cut.len())?;
    by_halving.extend(cut.iter().map(below));
    let halvings = by_halving.iter().max().map_or(0, |&last| last + 1);
    let lists = Lists::sorted(&by_halving, halvings as usize)?;
    let mut found = repeated(NONE, part.len())?;
    let mut place = repeated(NONE, part.len())?;
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for halving in (0..halvings).rev() {
        edges.clear();
        for &edge in lists.of(halving as usize) {
            let ends = cut[edge as usize];
            if ends.iter().all(|&v| found[v as usize] == NONE) {
                push(&mut edges, ends)?;
            }
        }
        for v in cover(&edges, &mut place)? {
            found[v as usize] = halving;
        }
    }
    Ok(found)
}

/// Returns the fewest vertices that have an end of each edge (by König's theorem from a matching as
/// large as possible); the first ends and the second ones are disjoint. `place` has [`NONE`] for
/// all vertices, and has it again afterwards.
fn cover(edges: &[[u32; 2]], place: &mut [u32]) -> Result<Vec<u32>> {
    let mut ends: [Vec<u32>; 2] = Default::default();
    let mut from = reserved(edges.len())?;
    for edge in edges {
        for (v, ends) in edge.iter().zip(&mut ends) {
            let place = &mut place[*v as usize];
            if *place == NONE {
                *place = ends.len() as u32;
                push(ends, *v)?;
            }
        }
        from.push(place[edge[0] as usize]);
    }
    let [first, second] = &ends;
    let lists = Lists::sorted(&from, first.len())?;
    let to = |edge: u32| place[edges[edge as usize][1] as usize];
    let (mut mate, mut partner) = (repeated(NONE, first.len())?, repeated(NONE, second.len())?);
    for (v, mate) in mate.iter_mut().enumerate() {
        let free = lists.of(v).iter().map(|&edge| to(edge)).find(|&o| partner[o as usize] == NONE);
        if let Some(other) = free {
            *mate = other;
            partner[other as usize] = v as u32;
        }
    }
    // The second ends that a search has reached; those of a search in vain stay.
    let mut reached = repeated(false, second.len())?;
    let mut in_vain = repeated(false, first.len())?;
    let mut searched: Vec<u32> = Vec::new();
    let mut looks = Looks::default();
    let mut came: Vec<u32> = repeated(NONE, second.len())?;
    let mut found: Vec<u32> = Vec::new();
    for start in 0..first.len() {
        if mate[start] != NONE {
            continue;
        }
        searched.clear();
        found.clear();
        push(&mut searched, start as u32)?;
        let (mut next, mut end) = (0, NONE);
        'search: while next < searched.len() {
            let v = searched[next];
            next += 1;
            for other in lists.of(v as usize).iter().map(|&edge| to(edge)) {
                if std::mem::replace(&mut reached[other as usize], true) {
                    continue;
                }
                came[other as usize] = v;
                push(&mut found, other)?;
                match partner[other as usize] {
                    NONE => {
                        end = other;
                        break 'search;
                    }
                    partner => push(&mut searched, partner)?,
                }
            }
        }
        looks.add(found.len())?;
        if end == NONE {
            searched.iter().for_each(|&v| in_vain[v as usize] = true);
            continue;
        }
        found.iter().for_each(|&other| reached[other as usize] = false);
        while end != NONE {
            let v = came[end as usize];
            partner[end as usize] = v;
            end = std::mem::replace(&mut mate[v as usize], end);
        }
    }
    let mut covering = Vec::new();
    for (v, &end) in first.iter().enumerate() {
        if !in_vain[v] {
            push(&mut covering, end)?;
        }
    }
    for (v, &end) in second.iter().enumerate() {
        if reached[v] {
            push(&mut covering, end)?;
        }
    }
    ends.iter().flatten().for_each(|&v| place[v as usize] = NONE);
    Ok(covering)
}

#[cfg(test)]
mod tests {
    use super::super::graph::tests::{graphs, grid, of_edges};
    use super::*;

    /// Returns the stage of each vertex.
    fn stage_of(stages: &Lists) -> Vec<u32> {
        let mut of = vec![NONE; stages.items.len()];
        for k in 0..stages.len() {
            stages.of(k).iter().for_each(|&v| of[v as usize] = k as u32);
        }
        of
    }

    #[test]
    fn no_edge_joins_two_parts() {
        for (name, graph) in graphs().into_iter().chain([("large grid", grid(90, 110))]) {
            for depth in 1..4 {
                let weighted = Weighted::new(graph.clone()).unwrap();
                let Some(part) = parts(weighted, depth, SLACK).unwrap() else { continue };
                let stages = separated(&graph, &part, depth).unwrap();
                let stage = stage_of(&stages);
                for v in 0..graph.n() {
                    for &other in graph.of(v) {
                        let both = [stage[v], stage[other as usize]];
                        let inside = both.iter().all(|&k| k < 1 << depth);
                        assert!(!inside || both[0] == both[1], "{name}, depth {depth}");
                    }
                }
            }
        }
    }

    #[test]
    fn parts_of_a_surface_are_alike_and_their_separators_small() {
        let (a, b) = (330, 310);
        let graph = grid(a, b);
        let stages = dissected(&graph).unwrap().expect("a large graph");
        // Three halvings: lines across a, and twice across halves and quarters.
        assert_eq!(stages.len(), 8 + 3);
        let sizes: Vec<_> = (0..8).map(|k| stages.of(k).len()).collect();
        assert!(sizes.iter().all(|size| (6_500..22_500).contains(size)), "{sizes:?}");
        let separators: usize = (8..11).map(|k| stages.of(k).len()).sum();
        assert!(separators < 2 * (a + b + a), "{separators}");
        assert!(stages.of(10).len() < 350, "{}", stages.of(10).len());
    }

    #[test]
    fn graphs_without_small_separators_are_not_dissected() {
        // Small ones; and stars, in which few vertices find a partner.
        assert!(dissected(&grid(100, 100)).unwrap().is_none());
        let stars = of_edges(LEAST, (0..LEAST).map(|v| (v, v - v % 1000)));
        assert!(dissected(&stars).unwrap().is_none());
    }

    #[test]
    fn covers_are_the_smallest() {
        let mut rng = Rng::new(8);
        for count in 1..60 {
            // Six vertices on each side.
            let mut end = |first: u32| first + (rng.bits() % 6) as u32;
            let edges: Vec<_> = (0..count % 20).map(|_| [end(0), end(6)]).collect();
            let mut place = vec![NONE; 12];
            let found = cover(&edges, &mut place).unwrap();
            assert!(place.iter().all(|&place| place == NONE));
            let covers = |set: u32| edges.iter().all(|[v, o]| set & (1 << v | 1 << o) != 0);
            let set = found.iter().fold(0u32, |set, v| set | 1 << v);
            assert!(covers(set), "{edges:?}");
            let least = (0..1u32 << 12).filter(|&set| covers(set)).map(u32::count_ones).min();
            assert_eq!(least, Some(found.len() as u32), "{edges:?}");
        }
    }
}
