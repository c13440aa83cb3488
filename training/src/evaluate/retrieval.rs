use catamaran::{Par, Result};
use catamaran_geometry::unions::retrieve;

use crate::cuts::id;
use crate::dataset::{Dataset, Spectrum, TRAIN};
use crate::families::Family;

/// Shares of the queries for which the right identity is among the first 1, 5 and 10 results.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Retrieval {
    /// Number of queries.
    pub queries: usize,
    /// Top-1, top-5 and top-10.
    pub top: [f64; 3],
}

/// Number of results per query.
const FOUND: usize = 10;

impl Retrieval {
    /// Computes the shares from the rank, counted from 0, of the first correct result of each
    /// query; `None` for a query without a correct one among the first 10.
    pub fn of(ranks: &[Option<usize>]) -> Self {
        let within = |limit| ranks.iter().filter(|rank| rank.is_some_and(|r| r < limit)).count();
        let share = |limit| within(limit) as f64 / f64::max(1.0, ranks.len() as f64);
        Self { queries: ranks.len(), top: [1, 5, FOUND].map(share) }
    }
}

/// The spectrum of a complete shape, with its identity and pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Query {
    /// Identity of the shape.
    pub identity: usize,
    /// Pose of the shape.
    pub pose: usize,
    /// The spectrum, true or predicted.
    pub spectrum: Spectrum,
}

/// The complete humans of a data set, in which queries search.
#[derive(Debug, Clone, PartialEq)]
pub struct Gallery(Vec<Query>);

impl Gallery {
    /// Collects the complete shapes of family 0.
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

    /// Takes these shapes.
    pub fn of(shapes: Vec<Query>) -> Self {
        Self(shapes)
    }

    /// Returns the shapes that are also there in another pose, as queries.
    pub fn queries(&self) -> Vec<Query> {
        self.0.iter().copied().filter(|q| self.has_another(q.identity, q.pose)).collect()
    }

    fn has_another(&self, identity: usize, pose: usize) -> bool {
        self.0.iter().any(|shape| shape.identity == identity && shape.pose != pose)
    }

    /// Finds the shapes nearest to each query, except the shape of the query itself, by the
    /// Euclidean distance of the signatures of queries and of shapes. Returns the rank of the first
    /// one with the same identity, as in [`Retrieval::of`].
    ///
    /// # Errors
    /// Those of [`retrieve`] and of the signatures.
    pub fn ranks<S: AsRef<[f64]> + Sync>(
        &self,
        queries: &[Query],
        of_query: impl Fn(&Spectrum) -> Result<S>,
        of_shape: impl Fn(&Spectrum) -> Result<S>,
    ) -> Result<Vec<Option<usize>>> {
        let signatures: Vec<S> =
            self.0.iter().map(|shape| of_shape(&shape.spectrum)).collect::<Result<_>>()?;
        let rank = |query: &Query| {
            let own = of_query(&query.spectrum)?;
            let found = retrieve(own.as_ref(), &signatures, FOUND + 1, Par::Seq)?;
            let is_another =
                |shape: &&Query| (shape.identity, shape.pose) != (query.identity, query.pose);
            let others = found.iter().map(|found| &self.0[found.index]).filter(is_another);
            Ok(others.take(FOUND).position(|shape| shape.identity == query.identity))
        };
        queries.iter().map(rank).collect()
    }

    /// Computes [`ranks`](Self::ranks) with the distance of the thesis, the Euclidean distance of
    /// the eigenvalues.
    ///
    /// # Errors
    /// Those of [`retrieve`].
    pub fn euclidean_ranks(&self, queries: &[Query]) -> Result<Vec<Option<usize>>> {
        self.ranks(queries, |spectrum| Ok(*spectrum), |spectrum| Ok(*spectrum))
    }
}

/// Returns for each sample whether its union is a complete human with the mesh of the family.
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

/// Returns the samples that are queries for other poses of their shape: the union is a complete
/// human, the gallery contains it in another pose, and the sample is not in the training.
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
