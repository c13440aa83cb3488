use catamaran::unions::retrieve;
use catamaran::{Par, Result};

use super::Predictor;
use crate::dataset::{Dataset, Spectrum, TRAIN};

/// Shares of queries that have the right identity among the first 1, 5 and 10 shapes found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Retrieval {
    /// Queries.
    pub queries: usize,
    /// Top-1, top-5 and top-10.
    pub top: [f64; 3],
}

/// Queries the complete shapes of family 0 by spectra of unions that are complete, predicted and
/// true (ShapeDNA). A shape is not asked for itself, nor for shapes of which no other pose is
/// there; samples that were trained on do not ask.
///
/// # Errors
/// Of spectra that are none.
pub fn retrieval(predictor: &dyn Predictor, dataset: &Dataset) -> Result<[Retrieval; 2]> {
    let (samples, shapes) = (&dataset.samples, &dataset.shapes);
    let database: Vec<usize> =
        (0..shapes.spectrum.len()).filter(|&i| shapes.family[i] == 0).collect();
    let complete = dataset.templates.first().map_or(0, |template| template.vertices.len());
    let is_complete = |mask: usize| {
        let found = dataset.templates.first().and_then(|template| template.mask(mask));
        found.is_some_and(|mask| mask.len() == complete)
    };
    let mut counts = [[0; 3]; 2];
    let mut queries = 0;
    for i in 0..samples.part1.len() {
        let asks = samples.split[i] != TRAIN && samples.family[i] == 0 && samples.remeshed[i] == 0;
        if !asks || !is_complete(samples.mask_union[i]) {
            continue;
        }
        let who = (samples.identity[i], samples.pose[i]);
        let others: Vec<usize> = database
            .iter()
            .copied()
            .filter(|&j| (shapes.identity[j], shapes.pose[j]) != who)
            .collect();
        if !others.iter().any(|&j| shapes.identity[j] == who.0) {
            continue;
        }
        let signatures: Vec<Spectrum> = others.iter().map(|&j| shapes.spectrum[j]).collect();
        let predicted = predictor.predict(&samples.part1[i], &samples.part2[i])?;
        queries += 1;
        for (query, counts) in [predicted, samples.union[i]].iter().zip(&mut counts) {
            let found = retrieve(query, &signatures, 10, Par::Seq)?;
            let rank = found.iter().position(|m| shapes.identity[others[m.index]] == who.0);
            for (count, limit) in counts.iter_mut().zip([1, 5, 10]) {
                *count += usize::from(rank.is_some_and(|rank| rank < limit));
            }
        }
    }
    let share = |count: usize| count as f64 / f64::max(1.0, queries as f64);
    Ok(counts.map(|counts| Retrieval { queries, top: counts.map(share) }))
}
