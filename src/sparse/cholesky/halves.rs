//! Halves of a graph with few edges between them (Fiduccia and Mattheyses, A linear-time heuristic
//! for improving network partitions, 1982).

use std::collections::BinaryHeap;

use super::coarse::Weighted;
use super::graph::{Looks, NONE};
use crate::base::{Result, Rng, push, repeated, reserved};

/// Vertices of graphs that are not made coarser.
const SMALL: usize = 200;

/// Vertices of graphs of which halves are searched for only once.
const LARGE: usize = 4000;

/// Searches for halves of a graph that is not large, of which the best is taken.
const CYCLES: usize = 4;

/// Halves of the coarsest graph that are tried.
const TRIES: usize = 8;

/// Passes over the vertices at the border of halves.
const PASSES: u32 = 8;

/// Moves that don't improve the halves before a pass ends.
const IN_VAIN: usize = 100;

/// Two halves of a graph.
struct Halves {
    /// For each vertex, whether it is in the second half.
    is_second: Vec<bool>,
    /// Weight of the edges between them.
    cut: u64,
}

/// Returns for each vertex whether it is in the second half. A half has at most `1 + slack` times
/// half of the weight.
pub(super) fn halved(graph: &Weighted, slack: f64, rng: &mut Rng) -> Result<Vec<bool>> {
    Ok(best(graph, slack, rng)?.is_second)
}

/// Returns the best halves of some searches.
fn best(graph: &Weighted, slack: f64, rng: &mut Rng) -> Result<Halves> {
    let mut best = through_coarser(graph, slack, rng)?;
    if graph.graph.n() <= LARGE {
        for _ in 1..CYCLES {
            let other = through_coarser(graph, slack, rng)?;
            if other.cut < best.cut {
                best = other;
            }
        }
    }
    Ok(best)
}

/// Finds halves of a coarser graph, and improves them as those of this one.
fn through_coarser(graph: &Weighted, slack: f64, rng: &mut Rng) -> Result<Halves> {
    let n = graph.graph.n();
    if n > SMALL {
        let (coarser, into) = graph.coarser(Some(rng))?;
        if coarser.graph.n() * 10 < 9 * n {
            let first_small = n > LARGE && coarser.graph.n() <= LARGE;
            let find = if first_small { best } else { through_coarser };
            let found = find(&coarser, slack, rng)?.is_second;
            let mut is_second = reserved(n)?;
            is_second.extend(into.iter().map(|&c| found[c as usize]));
            return improved(graph, slack, is_second);
        }
    }
    grown(graph, slack)
}

/// Returns the best of the halves that are the nearest vertices to some vertex.
fn grown(graph: &Weighted, slack: f64) -> Result<Halves> {
    let (n, total) = (graph.graph.n(), graph.total());
    let mut best = Halves { is_second: repeated(false, n)?, cut: u64::MAX };
    for k in 0..TRIES.min(n) {
        // Far from the others: the last one on a way from anywhere.
        let seed = by_distance(graph, k * n / TRIES.min(n))?[n - 1] as usize;
        let mut is_second = repeated(false, n)?;
        let mut weight = 0;
        for v in by_distance(graph, seed)? {
            if 2 * weight >= total {
                break;
            }
            is_second[v as usize] = true;
            weight += u64::from(graph.vertices[v as usize]);
        }
        let found = improved(graph, slack, is_second)?;
        if found.cut < best.cut {
            best = found;
        }
    }
    Ok(best)
}

/// Returns all vertices by their distance from one; those that no edges lead to follow.
fn by_distance(graph: &Weighted, from: usize) -> Result<Vec<u32>> {
    let n = graph.graph.n();
    let mut is_found = repeated(false, n)?;
    let mut found: Vec<u32> = reserved(n)?;
    let (mut next, mut looks) = (0, Looks::default());
    for start in std::iter::once(from).chain(0..n) {
        if std::mem::replace(&mut is_found[start], true) {
            continue;
        }
        found.push(start as u32);
        while next < found.len() {
            let neighbours = graph.graph.of(found[next] as usize);
            for &other in neighbours {
                if !std::mem::replace(&mut is_found[other as usize], true) {
                    found.push(other);
                }
            }
            looks.add(neighbours.len())?;
            next += 1;
        }
    }
    Ok(found)
}

/// Moves vertices between halves while that leaves fewer edges between them.
fn improved(graph: &Weighted, slack: f64, is_second: Vec<bool>) -> Result<Halves> {
    let mut border = Border::new(graph, slack, is_second)?;
    for pass in 0..PASSES {
        let before = border.cut;
        border.pass(pass)?;
        if border.cut == before {
            break;
        }
    }
    let cut = u64::try_from(border.cut).unwrap_or(0);
    Ok(Halves { is_second: border.is_second, cut })
}

/// The vertices at the border of two halves.
struct Border<'g> {
    graph: &'g Weighted,
    is_second: Vec<bool>,
    /// Weights of both halves, and the most of one.
    weights: [u64; 2],
    most: u64,
    /// How much smaller the cut is when each vertex moves.
    gains: Vec<i64>,
    /// The last pass in which it has moved.
    moved: Vec<u32>,
    cut: i64,
    by_gain: BinaryHeap<(i64, u32)>,
}

impl<'g> Border<'g> {
    fn new(graph: &'g Weighted, slack: f64, is_second: Vec<bool>) -> Result<Self> {
        let n = graph.graph.n();
        let heaviest = graph.vertices.iter().copied().max().unwrap_or(0);
        let total = graph.total();
        let mut weights = [0; 2];
        let mut gains = repeated(0, n)?;
        let (mut cut, mut looks) = (0, Looks::default());
        for v in 0..n {
            weights[usize::from(is_second[v])] += u64::from(graph.vertices[v]);
            for (other, weight) in graph.edges(v) {
                let weight = i64::from(weight);
                if is_second[other] == is_second[v] {
                    gains[v] -= weight;
                } else {
                    gains[v] += weight;
                    cut += weight;
                }
            }
            looks.add(graph.graph.degree(v))?;
        }
        Ok(Self {
            graph,
            is_second,
            weights,
            most: ((0.5 * (1.0 + slack) * total as f64) as u64)
                .max(total / 2 + u64::from(heaviest)),
            gains,
            moved: repeated(NONE, n)?,
            cut: cut / 2,
            by_gain: BinaryHeap::from(reserved(n)?),
        })
    }

    /// Moves vertices, each at most once and that with the largest gain first, and then takes
    /// back the moves made after the cut was smallest.
    fn pass(&mut self, pass: u32) -> Result<()> {
        self.by_gain.clear();
        let mut looks = Looks::default();
        for v in 0..self.graph.graph.n() {
            let neighbours = self.graph.graph.of(v);
            let is_second = self.is_second[v];
            if neighbours.iter().any(|&other| self.is_second[other as usize] != is_second) {
                self.by_gain.push((self.gains[v], v as u32));
            }
            looks.add(neighbours.len())?;
        }
        let mut best = self.cut;
        let mut in_vain: Vec<u32> = Vec::new();
        while let Some((gain, v)) = self.by_gain.pop() {
            let v = v as usize;
            if self.moved[v] == pass || self.gains[v] != gain {
                continue;
            }
            let from = usize::from(self.is_second[v]);
            let after = self.weights[1 - from] + u64::from(self.graph.vertices[v]);
            if after > self.most && after > self.weights[from] {
                continue;
            }
            self.moved[v] = pass;
            self.go(v);
            for (other, _) in self.graph.edges(v).filter(|(other, _)| self.moved[*other] != pass) {
                self.by_gain.push((self.gains[other], other as u32));
            }
            push(&mut in_vain, v as u32)?;
            if self.cut < best {
                best = self.cut;
                in_vain.clear();
            } else if in_vain.len() > IN_VAIN {
                break;
            }
            looks.add(self.graph.graph.degree(v))?;
        }
        in_vain.iter().rev().for_each(|&v| self.go(v as usize));
        Ok(())
    }

    /// Moves a vertex to the other half.
    fn go(&mut self, v: usize) {
        let weight = u64::from(self.graph.vertices[v]);
        let from = usize::from(self.is_second[v]);
        self.weights[from] -= weight;
        self.weights[1 - from] += weight;
        self.is_second[v] = from == 0;
        self.cut -= self.gains[v];
        self.gains[v] = -self.gains[v];
        for (other, weight) in self.graph.edges(v) {
            let change = 2 * i64::from(weight);
            let is_together = self.is_second[other] == self.is_second[v];
            self.gains[other] += if is_together { -change } else { change };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::graph::tests::{graphs, grid, of_edges};
    use super::*;

    /// Returns the number of edges between halves, and the vertices of the second one.
    fn cut(graph: &Weighted, is_second: &[bool]) -> (usize, usize) {
        let n = graph.graph.n();
        let across = |v: usize| graph.edges(v).filter(move |e| is_second[e.0] != is_second[v]);
        let edges: usize = (0..n).map(|v| across(v).count()).sum();
        (edges / 2, is_second.iter().filter(|&&is_second| is_second).count())
    }

    #[test]
    fn halves_of_known_graphs_have_few_edges_between_them() {
        // Two full graphs of 30 vertices and one edge between them; a grid that is cut across.
        let full = (0..1800).map(|k| (k / 900, k % 900 / 30, k % 30));
        let pair = full.map(|(part, i, j)| (30 * part + i, 30 * part + j)).chain([(3, 47)]);
        for (graph, most) in [(of_edges(60, pair), 1), (grid(20, 60), 44), (grid(300, 40), 90)] {
            let n = graph.n();
            let graph = Weighted::new(graph).unwrap();
            let half = halved(&graph, 0.2, &mut Rng::new(3)).unwrap();
            let (edges, second) = cut(&graph, &half);
            assert!(edges <= most, "{edges} edges of {most}");
            assert!(10 * second >= 4 * n - 10 && 10 * second <= 6 * n + 10, "{second} of {n}");
        }
    }

    #[test]
    fn the_cut_is_that_of_the_halves() {
        for (name, graph) in graphs() {
            let graph = Weighted::new(graph).unwrap();
            let found = best(&graph, 0.2, &mut Rng::new(3)).unwrap();
            assert_eq!(found.is_second.len(), graph.graph.n(), "{name}");
            if graph.graph.n() > 1 {
                let (edges, second) = cut(&graph, &found.is_second);
                assert_eq!(found.cut, edges as u64, "{name}");
                assert!(second > 0 && second < graph.graph.n(), "{name}");
            }
        }
    }
}
