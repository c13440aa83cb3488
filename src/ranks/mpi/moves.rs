//! Rows that move to the ranks of their domains, and back.

use faer::{Mat, MatRef};
use sprs::{CsMat, CsMatView};

use super::call::Call;
use super::domains::{Domains, SpreadGraph};
use super::exchange::{Rows, exchange, exchange_numbers, gather_lists};
use crate::base::{Result, reserved};
use crate::dense::zeros;
use crate::sparse::Mass;

/// A distribution of rows by domains: each rank has those of its domain, and then some of the
/// interface. All rows have new numbers, in the order of the ranks.
pub(super) struct Moves {
    /// The new distribution.
    pub rows: Rows,
    /// The number of rows of each rank that are in its domain, which are its first ones.
    pub inner: Vec<usize>,
    /// For each rank, which of this rank's old rows go there, and which of its new ones come from
    /// there.
    outgoing: Vec<Vec<usize>>,
    incoming: Vec<Vec<usize>>,
    /// The new numbers of this rank's old rows, and, by old numbers, of those that they touch on
    /// other ranks.
    own: Vec<usize>,
    others: Vec<(usize, usize)>,
    first: usize,
}

impl Moves {
    /// Creates the distribution by the domains of a graph with these rows.
    pub fn new(
        call: &Call<'_>,
        rows: &Rows,
        graph: &SpreadGraph,
        domains: &Domains,
    ) -> Result<Self> {
        let ranks = rows.ranks();
        let mut outgoing = vec![Vec::new(); ranks];
        let mut counts = vec![0.0; 2 * ranks];
        for between in [false, true] {
            for (i, &domain) in domains.of.iter().enumerate() {
                if domains.between[i] == between {
                    outgoing[domain].push(i);
                    counts[2 * domain + usize::from(between)] += 1.0;
                }
            }
        }
        // What each rank sends to each one: rows of the domain, and of the interface.
        let (counts, _) = gather_lists(call, &counts)?;
        let count =
            |from: usize, to: usize, kind: usize| counts[2 * (from * ranks + to) + kind] as usize;
        let sum =
            |to: usize, kind: usize| (0..ranks).map(|from| count(from, to, kind)).sum::<usize>();
        let inner: Vec<usize> = (0..ranks).map(|to| sum(to, 0)).collect();
        let between: Vec<usize> = (0..ranks).map(|to| sum(to, 1)).collect();
        let rank = call.world.rank();
        let rows_of = Rows::new(call, inner[rank] + between[rank])?;
        // Those of a kind follow each other by the ranks that had them.
        let places = |from: usize, to: usize| {
            let before = |kind| (0..from).map(|from| count(from, to, kind)).sum::<usize>();
            let [first, second] = [before(0), inner[to] + before(1)];
            (first..first + count(from, to, 0)).chain(second..second + count(from, to, 1))
        };
        let incoming = (0..ranks).map(|from| places(from, rank).collect()).collect();
        let mut own = vec![0; domains.of.len()];
        for (to, rows) in outgoing.iter().enumerate() {
            let first = rows_of.of(to).start;
            rows.iter().zip(places(rank, to)).for_each(|(&i, place)| own[i] = first + place);
        }
        let first = rows.own().start;
        let entry = |i: usize, j: usize| if j == 0 { first + i } else { own[i] };
        let numbers = Mat::from_fn(own.len(), 2, |i, j| entry(i, j) as f64);
        let numbers = graph.spread.extended(call, numbers.as_ref())?;
        let others = (own.len()..numbers.nrows())
            .map(|i| (numbers[(i, 0)] as usize, numbers[(i, 1)] as usize))
            .collect();
        Ok(Self { rows: rows_of, inner, outgoing, incoming, own, others, first })
    }

    /// Returns the new number of a row that is this rank's, or that one of this rank's touches.
    fn number(&self, row: usize) -> usize {
        match row.checked_sub(self.first).and_then(|i| self.own.get(i)) {
            Some(&number) => number,
            None => self.others[self.others.partition_point(|&(other, _)| other < row)].1,
        }
    }

    /// Returns the new rows of this rank of a matrix of which it has the old ones, in new numbers.
    pub fn matrix(&self, call: &Call<'_>, matrix: CsMatView<'_, f64>) -> Result<CsMat<f64>> {
        let pack = |rows: &Vec<usize>| -> Result<Vec<f64>> {
            let row = |&i: &usize| matrix.outer_view(i).expect("a row of this rank");
            let len = rows.iter().map(|i| 1 + 2 * row(i).nnz()).sum();
            let mut packed = reserved(len)?;
            // Numbers of rows are exact as floating-point numbers.
            for row in rows.iter().map(row) {
                packed.push(row.nnz() as f64);
                packed.extend(row.indices().iter().map(|&j| self.number(j) as f64));
                packed.extend_from_slice(row.data());
            }
            Ok(packed)
        };
        let outgoing = self.outgoing.iter().map(pack).collect::<Result<Vec<_>>>();
        let outgoing = call.meet(outgoing)?;
        let lens: Vec<usize> = outgoing.iter().map(Vec::len).collect();
        let incoming = exchange(call, outgoing, &exchange_numbers(call, &lens)?)?;
        let mut rows: Vec<(usize, &[f64], &[f64])> = reserved(self.rows.own().len())?;
        for (places, packed) in self.incoming.iter().zip(&incoming) {
            let mut rest = &packed[..];
            for &place in places {
                let len = rest[0] as usize;
                let (row, others) = rest[1..].split_at(2 * len);
                let (columns, entries) = row.split_at(len);
                rows.push((place, columns, entries));
                rest = others;
            }
        }
        rows.sort_unstable_by_key(|&(place, ..)| place);
        let count = rows.iter().map(|(_, columns, _)| columns.len()).sum();
        let (mut starts, mut indices) = (reserved(rows.len() + 1)?, reserved(count)?);
        let mut data = reserved(count)?;
        starts.push(0);
        let mut sorted: Vec<(usize, f64)> = Vec::new();
        for (_, columns, entries) in rows {
            sorted.clear();
            sorted.extend(columns.iter().map(|&j| j as usize).zip(entries.iter().copied()));
            sorted.sort_unstable_by_key(|&(j, _)| j);
            indices.extend(sorted.iter().map(|&(j, _)| j));
            data.extend(sorted.iter().map(|&(_, x)| x));
            starts.push(indices.len());
        }
        Ok(CsMat::new((self.rows.own().len(), self.rows.count()), starts, indices, data))
    }

    /// Returns the new rows of this rank of a mass of which it has the old ones.
    pub fn mass(&self, call: &Call<'_>, mass: &Mass) -> Result<Mass> {
        Ok(match mass {
            Mass::Full(matrix) => Mass::Full(self.matrix(call, matrix.view())?),
            Mass::Lumped(masses) => {
                let masses = MatRef::from_column_major_slice(masses, masses.len(), 1);
                let moved = carry(call, masses, &self.outgoing, &self.incoming)?;
                Mass::Lumped(moved.col(0).iter().copied().collect())
            }
        })
    }

    /// Returns the old rows of this rank of vectors of which it has the new ones.
    pub fn back(&self, call: &Call<'_>, x: MatRef<'_, f64>) -> Result<Mat<f64>> {
        carry(call, x, &self.incoming, &self.outgoing)
    }
}

/// Sends rows of X to each rank, and puts those that each rank sends into their places.
fn carry(
    call: &Call<'_>,
    x: MatRef<'_, f64>,
    from: &[Vec<usize>],
    to: &[Vec<usize>],
) -> Result<Mat<f64>> {
    let pack = |rows: &Vec<usize>| -> Result<Vec<f64>> {
        let mut packed = reserved(rows.len() * x.ncols())?;
        x.col_iter().for_each(|x| packed.extend(rows.iter().map(|&i| x[i])));
        Ok(packed)
    };
    let outgoing = call.meet(from.iter().map(pack).collect::<Result<Vec<_>>>())?;
    let lens: Vec<usize> = to.iter().map(|rows| rows.len() * x.ncols()).collect();
    let incoming = exchange(call, outgoing, &lens)?;
    let mut moved = zeros(to.iter().map(Vec::len).sum(), x.ncols())?;
    for (rows, entries) in to.iter().zip(incoming) {
        for (j, column) in entries.chunks_exact(rows.len().max(1)).enumerate() {
            rows.iter().zip(column).for_each(|(&i, &entry)| moved[(i, j)] = entry);
        }
    }
    Ok(moved)
}
