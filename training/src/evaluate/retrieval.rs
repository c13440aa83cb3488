use catamaran::unions::retrieve;
use catamaran::{Par, Result};

use crate::cuts::id;
use crate::dataset::{Dataset, Spectrum, TRAIN};
use crate::families::Family;

/// Shares of queries that have the right identity among the first 1, 5 and 10 shapes found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Retrieval {
    /// Queries.
    pub queries: usize,
    /// Top-1, top-5 and top-10.
    pub top: [f64; 3],
}

/// Shapes found that count.
const FOUND: usize = 10;

impl Retrieval {
    /// Computes the shares from the rank, from 0, of the first right shape of each query; `None`
    /// for a query without a right one among the first 10.
    pub fn of(ranks: &[Option<usize>]) -> Self {
        let within = |limit| ranks.iter().filter(|rank| rank.is_some_and(|r| r < limit)).count();
        let share = |limit| within(limit) as f64 / f64::max(1.0, ranks.len() as f64);
        Self { queries: ranks.len(), top: [1, 5, FOUND].map(share) }
    }
}

/// The spectrum of a complete shape, and whose it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Query {
    /// Identity of the shape.
    pub identity: usize,
    /// Pose of the shape.
    pub pose: usize,
    /// Its spectrum, true or predicted.
    pub spectrum: Spectrum,
}

/// The complete humans of a data set: what is searched.
#[derive(Debug, Clone, PartialEq)]
pub struct Gallery(Vec<Query>);

impl Gallery {
    /// Takes the complete shapes of family 0.
    pub fn new(dataset: &Dataset) -> Self {
        let shapes = &dataset.shapes;
        let people = (0..shapes.spectrum.len()).filter(|&i| shapes.family[i] == 0);
        Self(
            people
                .map(|i| Query {
                    identity: shapes.identity[i],
                    pose: shapes.pose[i],
                    spectrum: shapes.spectrum[i],
                })
                .collect(),
        )
    }

    /// The shapes of which another pose is there: each may ask for it.
    pub fn queries(&self) -> Vec<Query> {
        self.0.iter().copied().filter(|q| self.has_another(q.identity, q.pose)).collect()
    }

    fn has_another(&self, identity: usize, pose: usize) -> bool {
        self.0.iter().any(|shape| shape.identity == identity && shape.pose != pose)
    }

    /// Searches the shapes nearest to each query, the shape of the query itself left out, by
    /// Euclidean distance of signatures, those of queries and those of shapes: the rank of the
    /// first one of the same identity, as in [`Retrieval::of`].
    ///
    /// # Errors
    /// As [`retrieve`].
    pub fn ranks<S: AsRef<[f64]> + Sync>(
        &self,
        queries: &[Query],
        of_query: impl Fn(&Spectrum) -> S,
        of_shape: impl Fn(&Spectrum) -> S,
    ) -> Result<Vec<Option<usize>>> {
        let signatures: Vec<S> = self.0.iter().map(|shape| of_shape(&shape.spectrum)).collect();
        let rank = |query: &Query| {
            let own = of_query(&query.spectrum);
            let found = retrieve(own.as_ref(), &signatures, FOUND + 1, Par::Seq)?;
            let is_another =
                |shape: &&Query| (shape.identity, shape.pose) != (query.identity, query.pose);
            let others = found.iter().map(|found| &self.0[found.index]).filter(is_another);
            Ok(others.take(FOUND).position(|shape| shape.identity == query.identity))
        };
        queries.iter().map(rank).collect()
    }

    /// [`ranks`](Self::ranks) by the distance of the thesis, the Euclidean one of eigenvalues.
    ///
    /// # Errors
    /// As [`retrieve`].
    pub fn euclidean_ranks(&self, queries: &[Query]) -> Result<Vec<Option<usize>>> {
        self.ranks(queries, |spectrum| *spectrum, |spectrum| *spectrum)
    }
}

/// Whether each sample has a complete human as its union, whose mesh is that of the family.
pub(super) fn complete_humans(dataset: &Dataset) -> Vec<bool> {
    let samples = &dataset.samples;
    let vertices = dataset.templates.first().map_or(0, |template| template.vertices.len());
    let complete = id(&vec![true; vertices]);
    let is_one = |i: usize| {
        samples.family[i] == Family::Humanoid.number()
            && samples.remeshed[i] == 0
            && samples.mask_union[i] == complete
    };
    (0..samples.part1.len()).map(is_one).collect()
}

/// The samples that ask for the other poses of their shape: the union is a complete human, another
/// pose of whom is in the gallery, and the sample is not trained on.
pub(super) fn asking(dataset: &Dataset, gallery: &Gallery) -> Vec<usize> {
    let samples = &dataset.samples;
    let complete = complete_humans(dataset);
    let asks = |&i: &usize| {
        complete[i]
            && samples.split[i] != TRAIN
            && gallery.has_another(samples.identity[i], samples.pose[i])
    };
    (0..complete.len()).filter(asks).collect()
}
