//! Graphs with weights, and coarser ones in which neighbours are one vertex.

use super::graph::{Graph, Looks, NONE};
use crate::base::{Result, Rng, push, repeated, reserved};

/// A graph with weights of vertices and edges.
#[derive(Debug)]
pub(super) struct Weighted {
    pub graph: Graph,
    /// The weight of the edge to each neighbour; empty if all are 1.
    edges: Vec<u32>,
    pub vertices: Vec<u32>,
}

impl Weighted {
    /// Gives each vertex and each edge the weight 1.
    pub fn new(graph: Graph) -> Result<Self> {
        let vertices = repeated(1, graph.n())?;
        Ok(Self { graph, edges: Vec::new(), vertices })
    }

    /// Reads the first n vertices, their edges and the weights of both from rows of a matrix, n x n
    /// or wider; entries on the diagonal and beyond column n are ignored.
    #[cfg(any(feature = "mpi", test))]
    pub fn of_rows(rows: sprs::CsMatView<'_, f64>, vertices: &[f64]) -> Result<Self> {
        let n = rows.rows();
        let mut found = Self::with_room(n)?;
        found.vertices.extend(vertices.iter().map(|&weight| weight as u32));
        found.graph.neighbours = reserved(rows.nnz())?;
        found.edges = reserved(rows.nnz())?;
        for (v, row) in rows.outer_iterator().enumerate() {
            for (other, &weight) in row.iter().filter(|&(other, _)| other < n && other != v) {
                found.graph.neighbours.push(other as u32);
                found.edges.push(weight as u32);
            }
            found.graph.starts.push(found.edges.len());
        }
        Ok(found)
    }

    /// Returns a graph without vertices, to which `n` can be added.
    fn with_room(n: usize) -> Result<Self> {
        let mut starts = reserved(n + 1)?;
        starts.push(0);
        let graph = Graph { starts, neighbours: Vec::new() };
        Ok(Self { graph, edges: Vec::new(), vertices: reserved(n)? })
    }

    /// Returns the sum of the weights of the vertices.
    pub fn total(&self) -> u64 {
        self.vertices.iter().map(|&weight| u64::from(weight)).sum()
    }

    /// Returns the neighbours of a vertex with the weights of the edges.
    pub fn edges(&self, v: usize) -> impl Iterator<Item = (usize, u32)> {
        let range = self.graph.starts[v]..self.graph.starts[v + 1];
        let weight = |k: usize| if self.edges.is_empty() { 1 } else { self.edges[k] };
        range.map(move |k| (self.graph.neighbours[k] as usize, weight(k)))
    }

    /// Returns a graph in which pairs of neighbours are one vertex, and the vertex that each one
    /// becomes, as [`Weighted::paired`] chooses them.
    pub fn coarser(&self, rng: Option<&mut Rng>) -> Result<(Self, Vec<u32>)> {
        let (pairs, into) = self.paired(rng)?;
        Ok((self.contracted(&pairs, &into)?, into))
    }

    /// Returns pairs of neighbours, both the same vertex where no neighbour is left, and the pair
    /// of each vertex. Vertices choose their partners in a random order, or in their own one, in
    /// which memory is read faster.
    pub fn paired(&self, rng: Option<&mut Rng>) -> Result<(Vec<[u32; 2]>, Vec<u32>)> {
        let n = self.graph.n();
        let mut order: Vec<u32> = reserved(n)?;
        order.extend(0..n as u32);
        if let Some(rng) = rng {
            (1..n).rev().for_each(|i| order.swap(i, (rng.bits() % (i as u64 + 1)) as usize));
        }
        let mut into = repeated(NONE, n)?;
        let mut pairs: Vec<[u32; 2]> = reserved(n)?;
        let mut looks = Looks::default();
        for v in order {
            if into[v as usize] != NONE {
                continue;
            }
            // Heavy edges inside, light vertices together.
            let mut best = (0.0, v);
            for (other, weight) in self.edges(v as usize) {
                let value = f64::from(weight) / f64::from(self.vertices[other]);
                if value > best.0 && into[other] == NONE {
                    best = (value, other as u32);
                }
            }
            into[v as usize] = pairs.len() as u32;
            into[best.1 as usize] = pairs.len() as u32;
            pairs.push([v, best.1]);
            looks.add(self.graph.degree(v as usize))?;
        }
        Ok((pairs, into))
    }

    /// Returns the graph in which the pairs, of which the vertices are `into`, are one vertex each;
    /// both of a pair may be the same.
    fn contracted(&self, pairs: &[[u32; 2]], into: &[u32]) -> Result<Self> {
        let mut coarse = Self::with_room(pairs.len())?;
        // Where the edge to each vertex is, if that is one of the current vertex.
        let mut place = repeated(usize::MAX, pairs.len())?;
        let mut looks = Looks::default();
        for (c, &[v, other]) in pairs.iter().enumerate() {
            let first = coarse.edges.len();
            let members = if v == other { &[v][..] } else { &[v, other] };
            coarse.vertices.push(members.iter().map(|&v| self.vertices[v as usize]).sum());
            for &v in members {
                for (other, weight) in self.edges(v as usize) {
                    let to = into[other] as usize;
                    let place = &mut place[to];
                    if to == c {
                        continue;
                    }
                    if *place < usize::MAX && *place >= first {
                        coarse.edges[*place] += weight;
                    } else {
                        *place = coarse.edges.len();
                        push(&mut coarse.edges, weight)?;
                        push(&mut coarse.graph.neighbours, to as u32)?;
                    }
                }
                looks.add(self.graph.degree(v as usize))?;
            }
            coarse.graph.starts.push(coarse.edges.len());
        }
        Ok(coarse)
    }

    /// Returns the graph of some vertices; `place` has [`NONE`] for all vertices, and has it again
    /// afterwards.
    pub fn of(&self, vertices: &[u32], place: &mut [u32]) -> Result<Self> {
        (0..).zip(vertices).for_each(|(i, &v)| place[v as usize] = i);
        let mut found = Self::with_room(vertices.len())?;
        let mut looks = Looks::default();
        for &v in vertices {
            found.vertices.push(self.vertices[v as usize]);
            for (other, weight) in self.edges(v as usize) {
                if place[other] != NONE {
                    push(&mut found.graph.neighbours, place[other])?;
                    push(&mut found.edges, weight)?;
                }
            }
            found.graph.starts.push(found.edges.len());
            looks.add(self.graph.degree(v as usize))?;
        }
        vertices.iter().for_each(|&v| place[v as usize] = NONE);
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::super::graph::tests::graphs;
    use super::*;

    #[test]
    fn coarser_graphs_keep_the_weights_and_the_edges_between_pairs() {
        for (name, graph) in graphs() {
            let mut finer = Weighted::new(graph).unwrap();
            for mut rng in [None, Some(Rng::new(2))] {
                let (coarser, into) = finer.coarser(rng.as_mut()).unwrap();
                assert_eq!(coarser.total(), finer.total(), "{name}");
                let n = coarser.graph.n();
                let mut expected = vec![0; n * n];
                for (v, &c) in into.iter().enumerate() {
                    for (other, weight) in finer.edges(v).filter(|e| into[e.0] != c) {
                        expected[c as usize * n + into[other] as usize] += weight;
                    }
                }
                let mut found = vec![0; n * n];
                for c in 0..n {
                    coarser.edges(c).for_each(|(other, weight)| found[c * n + other] = weight);
                }
                assert_eq!(found, expected, "{name}");
                finer = coarser;
            }
        }
    }

    #[test]
    fn parts_of_a_graph_have_its_edges() {
        for (name, graph) in graphs() {
            let graph = Weighted::new(graph).unwrap();
            let some: Vec<u32> = (0..graph.graph.n() as u32).filter(|v| v % 3 != 1).collect();
            let mut place = vec![NONE; graph.graph.n()];
            let part = graph.of(&some, &mut place).unwrap();
            assert!(place.iter().all(|&place| place == NONE));
            for (i, &v) in some.iter().enumerate() {
                let found = part.edges(i).map(|(other, weight)| (some[other] as usize, weight));
                let expected = graph.edges(v as usize).filter(|e| e.0 % 3 != 1);
                assert!(found.eq(expected), "{name}");
            }
        }
    }
}
