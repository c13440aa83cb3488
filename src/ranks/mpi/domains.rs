//! Rows of a sparse matrix in domains that do not touch, one for each rank. No rank sees the whole
//! graph: each one makes its own rows coarser, all divide the coarsest graph alike, and then move
//! rows at the borders (Karypis and Kumar, A parallel algorithm for multilevel graph partitioning
//! and sparse matrix ordering, 1998).

use faer::Mat;
use sprs::{CsMat, CsMatView};

use super::call::Call;
use super::exchange::{Rows, all_gather, gather_lists};
use super::spread::{SpreadMatrix, gather_matrix};
use crate::base::{Result, reserved};
use crate::sparse::{Mass, paired, separator, shared};

/// Vertices for each rank of the graph that every rank divides.
const COARSEST: usize = 1024;

/// How much heavier than the mean a domain may become, relative to it.
const SLACK: f64 = 0.04;

/// Rounds in which vertices at the borders of domains move.
const ROUNDS: usize = 8;

/// The domains of this rank's rows.
pub(super) struct Domains {
    /// The rank of each row's domain, or of the domain that it is beside.
    pub of: Vec<usize>,
    /// Whether the row is in the interface, which separates the domains.
    pub between: Vec<bool>,
}

impl Domains {
    /// Divides the rows of a graph among the ranks, about equally many for each.
    pub fn new(call: &Call<'_>, rows: &Rows, graph: &SpreadGraph) -> Result<Self> {
        let of = graph.divided(call, rows)?;
        let between = graph.separator(call, rows, &of)?;
        Ok(Self { of, between })
    }
}

/// The rows of this rank of a graph, with weights of its vertices and edges.
pub(super) struct SpreadGraph {
    /// Own vertices x all vertices.
    edges: CsMat<f64>,
    pub spread: SpreadMatrix,
    weights: Vec<f64>,
}

impl SpreadGraph {
    fn new(
        call: &Call<'_>,
        rows: &Rows,
        edges: Result<CsMat<f64>>,
        weights: Vec<f64>,
    ) -> Result<Self> {
        let edges = call.meet(edges)?;
        let spread = SpreadMatrix::new(call, rows, edges.view())?;
        Ok(Self { edges, spread, weights })
    }

    /// Creates the graph of the entries of a pencil beside its diagonal.
    pub fn of_pencil(
        call: &Call<'_>,
        rows: &Rows,
        stiffness: CsMatView<'_, f64>,
        mass: &Mass,
    ) -> Result<Self> {
        let first = rows.own().start;
        let entries = stiffness.nnz() + if let Mass::Full(m) = mass { m.nnz() } else { 0 };
        let edges = (|| {
            let (mut starts, mut columns) = (vec![0], reserved::<usize>(entries)?);
            let mut row: Vec<usize> = Vec::new();
            for i in 0..stiffness.rows() {
                row.clear();
                row.extend(stiffness.outer_view(i).iter().flat_map(|row| row.indices()));
                if let Mass::Full(matrix) = mass {
                    row.extend(matrix.outer_view(i).iter().flat_map(|row| row.indices()));
                }
                row.retain(|&j| j != first + i);
                row.sort_unstable();
                row.dedup();
                columns.extend_from_slice(&row);
                starts.push(columns.len());
            }
            let ones = vec![1.0; columns.len()];
            Ok(CsMat::new((stiffness.rows(), rows.count()), starts, columns, ones))
        })();
        Self::new(call, rows, edges, vec![1.0; stiffness.rows()])
    }

    /// Returns the domain of each vertex.
    fn divided(&self, call: &Call<'_>, rows: &Rows) -> Result<Vec<usize>> {
        let count = rows.ranks();
        let mut domain = None;
        if rows.count() > COARSEST * count {
            let (pairs, into) = call.meet(paired(self.spread.rows(), &self.weights))?;
            let coarse_rows = Rows::new(call, pairs.len())?;
            // Where the neighbours of vertices are on other ranks, few find a partner.
            if 10 * coarse_rows.count() <= 9 * rows.count() {
                let coarse = self.coarser(call, &coarse_rows, &pairs, &into)?;
                let found = coarse.divided(call, &coarse_rows)?;
                domain = Some(into.iter().map(|&c| found[c as usize]).collect());
            }
        }
        let mut domain = match domain {
            Some(domain) => domain,
            None => self.divided_alike(call, rows)?,
        };
        self.refine(call, &mut domain, count)?;
        Ok(domain)
    }

    /// Returns the domains that every rank finds in the whole graph.
    fn divided_alike(&self, call: &Call<'_>, rows: &Rows) -> Result<Vec<usize>> {
        let count = rows.ranks();
        let lens: Vec<usize> = (0..count).map(|rank| rows.of(rank).len()).collect();
        let edges = gather_matrix(call, rows, self.edges.view())?;
        let weights = all_gather(call, &self.weights, &lens)?;
        let share = call.meet(shared(edges.view(), &weights, count))?;
        Ok(share[rows.own()].iter().map(|&domain| domain as usize).collect())
    }

    /// Returns the graph in which pairs of this rank's vertices are one vertex.
    fn coarser(
        &self,
        call: &Call<'_>,
        coarse_rows: &Rows,
        pairs: &[[u32; 2]],
        into: &[u32],
    ) -> Result<Self> {
        let first = coarse_rows.own().start;
        let number = Mat::from_fn(into.len(), 1, |v, _| (first + into[v] as usize) as f64);
        let number = self.spread.extended(call, number.as_ref())?;
        let local = self.spread.rows();
        let edges = (|| {
            let (mut starts, mut columns) = (vec![0], reserved::<usize>(local.nnz())?);
            let mut weights = reserved::<f64>(local.nnz())?;
            let mut row: Vec<(usize, f64)> = Vec::new();
            for (c, &[v, other]) in pairs.iter().enumerate() {
                row.clear();
                for &v in &[v, other][usize::from(v == other)..] {
                    let entries = local.outer_view(v as usize);
                    let entries = entries.iter().flat_map(|row| row.iter());
                    row.extend(entries.map(|(j, &weight)| (number[(j, 0)] as usize, weight)));
                }
                row.retain(|&(column, _)| column != first + c);
                row.sort_unstable_by_key(|&(column, _)| column);
                for &(column, weight) in &row {
                    let is_new = columns.len() == starts[c] || columns.last() != Some(&column);
                    if is_new {
                        columns.push(column);
                        weights.push(0.0);
                    }
                    *weights.last_mut().expect("pushed if there was none") += weight;
                }
                starts.push(columns.len());
            }
            Ok(CsMat::new((pairs.len(), coarse_rows.count()), starts, columns, weights))
        })();
        let weight = |&[v, other]: &[u32; 2]| match v == other {
            true => self.weights[v as usize],
            false => self.weights[v as usize] + self.weights[other as usize],
        };
        Self::new(call, coarse_rows, edges, pairs.iter().map(weight).collect())
    }

    /// Moves vertices at the borders of domains where that leaves less weight of edges between
    /// domains, in one round to domains of higher numbers and in the next to those of lower ones:
    /// neighbours on different ranks do not change places.
    fn refine(&self, call: &Call<'_>, domain: &mut [usize], count: usize) -> Result<()> {
        let local = self.spread.rows();
        // The weights of the domains, and the number of moves.
        let mut sums = Mat::<f64>::zeros(count + 1, 1);
        for (&domain, weight) in domain.iter().zip(&self.weights) {
            sums[(domain, 0)] += weight;
        }
        call.sum(sums.as_mut())?;
        let total: f64 = (0..count).map(|d| sums[(d, 0)]).sum();
        let most = (1.0 + SLACK) * total / count as f64;
        let mut in_vain = 0;
        let mut near: Vec<(usize, f64)> = Vec::new();
        for round in 0..ROUNDS {
            let own = Mat::from_fn(domain.len(), 1, |v, _| domain[v] as f64);
            let all = self.spread.extended(call, own.as_ref())?;
            let mut all: Vec<usize> = all.col(0).iter().map(|&domain| domain as usize).collect();
            let mut moved = Mat::<f64>::zeros(count + 1, 1);
            for v in 0..domain.len() {
                let row = local.outer_view(v).expect("as many rows as vertices");
                let own = all[v];
                if row.indices().iter().all(|&j| all[j] == own) {
                    continue;
                }
                near.clear();
                for (j, &weight) in row.iter() {
                    match near.iter_mut().find(|(domain, _)| *domain == all[j]) {
                        Some((_, sum)) => *sum += weight,
                        None => near.push((all[j], weight)),
                    }
                }
                let inside = near.iter().find(|(domain, _)| *domain == own).map_or(0.0, |n| n.1);
                let weight = self.weights[v];
                let mut best = (inside, own);
                for &(to, beside) in near.iter().filter(|n| (n.0 > own) == round.is_multiple_of(2))
                {
                    // Each rank fills its part of what a domain may still take.
                    let room = (most - sums[(to, 0)]) / count as f64;
                    if to != own && beside > best.0 && moved[(to, 0)] + weight <= room {
                        best = (beside, to);
                    }
                }
                if best.1 != own {
                    moved[(own, 0)] -= weight;
                    moved[(best.1, 0)] += weight;
                    moved[(count, 0)] += 1.0;
                    all[v] = best.1;
                }
            }
            domain.copy_from_slice(&all[..domain.len()]);
            call.sum(moved.as_mut())?;
            in_vain = if moved[(count, 0)] == 0.0 { in_vain + 1 } else { 0 };
            if in_vain == 2 {
                break;
            }
            sums += &moved;
        }
        Ok(())
    }

    /// Returns for each of this rank's vertices whether it separates domains: without these, no
    /// edge is between two domains.
    fn separator(&self, call: &Call<'_>, rows: &Rows, domain: &[usize]) -> Result<Vec<bool>> {
        let own = rows.own();
        let entry = |v: usize, j: usize| if j == 0 { domain[v] } else { own.start + v };
        let ends = Mat::from_fn(domain.len(), 2, |v, j| entry(v, j) as f64);
        let ends = self.spread.extended(call, ends.as_ref())?;
        let mut cut = Vec::new();
        for (v, row) in self.spread.rows().outer_iterator().enumerate() {
            for &other in row.indices().iter().filter(|&&j| ends[(j, 0)] != ends[(v, 0)]) {
                let mut edge = [v, other];
                edge.sort_unstable_by(|&a, &b| ends[(a, 0)].total_cmp(&ends[(b, 0)]));
                cut.extend(edge.into_iter().flat_map(|v| [ends[(v, 1)], ends[(v, 0)]]));
            }
        }
        let (cut, _) = gather_lists(call, &cut)?;
        let (cut, _) = cut.as_chunks::<4>();
        // Both ends, with their domains, among all vertices at borders.
        let mut places: Vec<(usize, u32)> = cut
            .iter()
            .flat_map(|&[v, domain, other, beside]| [(v, domain), (other, beside)])
            .map(|(v, domain)| (v as usize, domain as u32))
            .collect();
        places.sort_unstable();
        places.dedup();
        let place = |v: f64| places.partition_point(|&(other, _)| other < v as usize) as u32;
        let mut edges: Vec<[u32; 2]> =
            cut.iter().map(|&[v, _, other, _]| [place(v), place(other)]).collect();
        edges.sort_unstable();
        edges.dedup();
        let shares: Vec<u32> = places.iter().map(|&(_, domain)| domain).collect();
        let found = call.meet(separator(&edges, &shares))?;
        let mut between = vec![false; domain.len()];
        for (&(v, _), found) in places.iter().zip(found) {
            if own.contains(&v) {
                between[v - own.start] = found;
            }
        }
        Ok(between)
    }
}
