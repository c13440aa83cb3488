use std::collections::BTreeSet;

use catamaran::base::Rng;
use catamaran::{Error, Result};
use catamaran_geometry::unions::{K, MetricOptions, RetrievalMetric};

use super::oracle::{log_errors, with_errors};
use super::retrieval::{Gallery, Query, Retrieval, asking, complete_humans};
use super::{Disturbance, ErrorModel, Logs, Predictor, errors_by_index};
use crate::dataset::{Dataset, Spectrum, TRAIN};
use crate::families::CARICATURE;

/// A study of why retrieval with predicted spectra succeeds or fails. The queries are spectra of
/// unions that are complete humans, predicted and true. A shape is not a result of its own query,
/// and shapes without another pose are not queries. Samples of the training are not queries either:
/// metrics are fitted to the errors of their predictions and to their poses.
pub struct RetrievalStudy {
    gallery: Gallery,
    truth: Vec<Query>,
    predicted: Vec<Query>,
    /// Errors of the predictions of complete humans in the training, with their identities.
    errors: Vec<(usize, Logs)>,
    /// Spectra of these humans, one per pose, with their identities.
    poses: Vec<(usize, Spectrum)>,
}

/// The spectra of the queries of a [`RetrievalStudy`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Spectra predicted by the network.
    Predicted,
    /// True spectra of the complete shapes.
    True,
}

/// Number of draws of a disturbance per shape.
const REPEATS: usize = 20;

impl RetrievalStudy {
    /// Predicts the spectra of all queries, and of the complete humans in the training.
    ///
    /// # Errors
    /// When a spectrum is invalid.
    pub fn new(predictor: &dyn Predictor, dataset: &Dataset) -> Result<Self> {
        let samples = &dataset.samples;
        let gallery = Gallery::new(dataset);
        let predict = |i: usize| predictor.predict(&samples.part1[i], &samples.part2[i]);
        let query = |i: usize, spectrum| Query {
            identity: samples.identity[i],
            pose: samples.pose[i],
            spectrum,
        };
        let asking = asking(dataset, &gallery);
        let predicted = asking.iter().map(|&i| Ok(query(i, predict(i)?))).collect::<Result<_>>()?;
        let truth = asking.iter().map(|&i| query(i, samples.union[i])).collect();
        let (mut errors, mut poses, mut seen) = (vec![], vec![], BTreeSet::new());
        for (i, complete) in complete_humans(dataset).into_iter().enumerate() {
            if complete && samples.split[i] == TRAIN && samples.body[i] != CARICATURE {
                let (identity, union) = (samples.identity[i], samples.union[i]);
                errors.push((identity, log_errors(&predict(i)?, &union)));
                if seen.insert((identity, samples.pose[i])) {
                    poses.push((identity, union));
                }
            }
        }
        Ok(Self { gallery, truth, predicted, errors, poses })
    }

    /// Takes complete shapes, each of an identity in a pose, as the gallery and as the poses to
    /// which metrics are fitted, and the predicted spectra of some of them as queries, to whose
    /// errors metrics are fitted: a metric never to those of the identity of its query.
    ///
    /// # Errors
    /// [`Error::Argument`] for a prediction of a shape that is not among the shapes.
    pub fn of_shapes(shapes: Vec<Query>, predicted: Vec<Query>) -> Result<Self> {
        let truth = |query: &Query| {
            let of = (query.identity, query.pose);
            let found = shapes.iter().find(|shape| (shape.identity, shape.pose) == of);
            let why = || format!("identity {} in pose {} is no shape", of.0, of.1);
            found.copied().ok_or_else(|| Error::Argument { what: "predicted", why: why() })
        };
        let truth = predicted.iter().map(truth).collect::<Result<Vec<_>>>()?;
        let errors = predicted.iter().zip(&truth);
        let errors = errors.map(|(p, t)| (p.identity, log_errors(&p.spectrum, &t.spectrum)));
        let errors = errors.collect();
        let poses = shapes.iter().map(|shape| (shape.identity, shape.spectrum)).collect();
        Ok(Self { gallery: Gallery::of(shapes), truth, predicted, errors, poses })
    }

    /// Returns the numbers of samples to which metrics are fitted: of predictions, and of poses.
    pub fn fitted_to(&self) -> [usize; 2] {
        [self.errors.len(), self.poses.len()]
    }

    fn queries(&self, source: Source) -> &[Query] {
        match source {
            Source::Predicted => &self.predicted,
            Source::True => &self.truth,
        }
    }

    /// Searches with the distance of the thesis, the Euclidean distance of the eigenvalues.
    ///
    /// # Errors
    /// When a spectrum is invalid.
    pub fn euclidean(&self, source: Source) -> Result<Retrieval> {
        Ok(Retrieval::of(&self.gallery.euclidean_ranks(self.queries(source))?))
    }

    /// Searches with a [`RetrievalMetric`] that is fitted to the samples of the training; for true
    /// spectra, without errors. The identity of a query is excluded from the fit of its metric.
    ///
    /// # Errors
    /// Those of [`RetrievalMetric::fit`].
    pub fn by_likelihood(&self, source: Source, options: &MetricOptions) -> Result<Retrieval> {
        let errors = match source {
            Source::Predicted => &self.errors[..],
            Source::True => &[],
        };
        self.search(self.queries(source), errors, options)
    }

    fn search(
        &self,
        queries: &[Query],
        errors: &[(usize, Logs)],
        options: &MetricOptions,
    ) -> Result<Retrieval> {
        let mut ranks = Vec::new();
        let identities: BTreeSet<usize> = queries.iter().map(|query| query.identity).collect();
        for identity in identities {
            let own: Vec<Query> =
                queries.iter().copied().filter(|query| query.identity == identity).collect();
            let poses = self.poses.iter().copied().filter(|(other, _)| *other != identity);
            let (identities, spectra): (Vec<usize>, Vec<Spectrum>) = poses.unzip();
            let errors = errors.iter().filter(|(other, _)| *other != identity);
            let errors: Vec<Vec<f64>> = errors.map(|(_, error)| error.to_vec()).collect();
            let metric = RetrievalMetric::fit(&spectra, &identities, &errors, options)?;
            ranks.extend(self.gallery.ranks(
                &own,
                |s| metric.of_query(s),
                |s| metric.of_shape(s),
            )?);
        }
        Ok(Retrieval::of(&ranks))
    }

    /// Computes the mean relative errors of the predictions of the queries, for the eigenvalues 2
    /// to 20.
    pub fn errors_by_index(&self) -> [f64; K - 1] {
        let [found, truth] = [&self.predicted, &self.truth]
            .map(|queries| queries.iter().map(|query| query.spectrum).collect::<Vec<_>>());
        errors_by_index(&found, &truth)
    }

    /// Returns the errors of the predictions of the queries, as a model.
    ///
    /// # Errors
    /// Those of [`ErrorModel::fit`], also when there are no queries.
    pub fn error_model(&self) -> Result<ErrorModel> {
        ErrorModel::fit(&self.query_errors())
    }

    fn query_errors(&self) -> Vec<Logs> {
        let pairs = self.predicted.iter().zip(&self.truth);
        pairs.map(|(found, truth)| log_errors(&found.spectrum, &truth.spectrum)).collect()
    }

    /// Searches with true spectra of complete shapes, each disturbed 20 times, with the distance of
    /// the thesis, and with a metric that is fitted to such disturbances.
    ///
    /// # Errors
    /// Those of [`RetrievalMetric::fit`].
    pub fn disturbed(
        &self,
        disturbance: &Disturbance<'_>,
        options: &MetricOptions,
        seed: u64,
    ) -> Result<[Retrieval; 2]> {
        let queries = disturbance.queries(&self.gallery.queries(), REPEATS, seed);
        let mut rng = Rng::new(seed + 1);
        let error = |&(identity, spectrum): &(usize, Spectrum)| {
            (identity, log_errors(&disturbance.apply(&spectrum, &mut rng), &spectrum))
        };
        let errors: Vec<_> = self.poses.iter().map(error).collect();
        self.both(&queries, &errors, options)
    }

    /// Searches with predicted spectra whose errors (of logarithms) are multiplied by a factor, as
    /// are the errors to which metrics are fitted. The results are as in
    /// [`RetrievalStudy::disturbed`].
    ///
    /// # Errors
    /// Those of [`RetrievalMetric::fit`].
    pub fn improved(&self, factor: f64, options: &MetricOptions) -> Result<[Retrieval; 2]> {
        let queries = self.truth.iter().zip(self.query_errors());
        let queries: Vec<Query> = queries
            .map(|(query, errors)| {
                let spectrum = with_errors(&query.spectrum, &errors, factor);
                Query { spectrum, ..*query }
            })
            .collect();
        let errors = self.errors.iter().map(|(who, error)| (*who, error.map(|x| factor * x)));
        self.both(&queries, &errors.collect::<Vec<_>>(), options)
    }

    fn both(
        &self,
        queries: &[Query],
        errors: &[(usize, Logs)],
        options: &MetricOptions,
    ) -> Result<[Retrieval; 2]> {
        let euclidean = Retrieval::of(&self.gallery.euclidean_ranks(queries)?);
        Ok([euclidean, self.search(queries, errors, options)?])
    }
}

#[cfg(test)]
mod tests {
    use catamaran::faer::Mat;

    use super::*;
    use crate::cuts::id;
    use crate::dataset::{TEST_A, Template};

    /// Number of identities: more than a metric without one of them needs.
    const IDENTITIES: usize = 45;

    /// Creates identities that differ slightly in each eigenvalue, each in two poses that differ
    /// much in size. Each shape has a sample in the training and a query.
    fn dataset() -> Dataset {
        let mut dataset = Dataset::default();
        dataset.templates.push(Template {
            vertices: vec![[0.0; 3]; 4],
            faces: vec![],
            mirror: vec![],
            mass: vec![],
            eigenvalues: vec![],
            eigenfunctions: Mat::zeros(0, 0),
            masks: vec![],
            mask_words: vec![],
        });
        let Dataset { samples, shapes, .. } = &mut dataset;
        let mut rng = Rng::new(6);
        let mut own = [[0.0; K]; IDENTITIES];
        own.iter_mut().flatten().for_each(|x| *x = 0.01 * rng.normal());
        let all = (0..IDENTITIES).flat_map(|identity| [(identity, 0), (identity, 1)]);
        for (identity, pose) in all {
            let size = 0.3 * rng.normal();
            let spectrum: Spectrum =
                std::array::from_fn(|i| i as f64 * (own[identity][i] + size).exp());
            shapes.spectrum.push(spectrum);
            shapes.family.push(0);
            shapes.identity.push(identity);
            shapes.pose.push(pose);
            for split in [TRAIN, TEST_A] {
                samples.part1.push(spectrum);
                samples.part2.push(spectrum);
                samples.union.push(spectrum);
                samples.family.push(0);
                samples.identity.push(identity);
                samples.body.push(0);
                samples.pose.push(pose);
                samples.mask_union.push(id(&[true; 4]));
                samples.remeshed.push(0);
                samples.split.push(split);
            }
        }
        dataset
    }

    /// Predicts a multiple of the first part.
    struct Multiple(f64);

    impl Predictor for Multiple {
        fn name(&self) -> &str {
            "multiple"
        }

        fn predict(&self, first: &Spectrum, _: &Spectrum) -> Result<Spectrum> {
            Ok(first.map(|x| self.0 * x))
        }
    }

    const COUNT: usize = 2 * IDENTITIES;

    #[test]
    fn the_metric_finds_what_poses_hide_from_euclidean_distances() {
        let study = RetrievalStudy::new(&Multiple(1.01), &dataset()).unwrap();
        assert_eq!(study.fitted_to(), [COUNT, COUNT]);
        for source in [Source::Predicted, Source::True] {
            let euclidean = study.euclidean(source).unwrap();
            assert!(euclidean.queries == COUNT && euclidean.top[0] < 0.2, "{euclidean:?}");
            for scale_free in [false, true] {
                let options = MetricOptions::new().scale_free(scale_free);
                let found = study.by_likelihood(source, &options).unwrap();
                assert_eq!((found.queries, found.top), (COUNT, [1.0; 3]));
            }
        }
        let errors = study.errors_by_index();
        assert!(errors.iter().all(|error| (error - 0.01).abs() < 1e-12));
    }

    #[test]
    fn a_study_of_shapes_is_that_of_a_data_set_of_them() {
        let dataset = dataset();
        let of_dataset = RetrievalStudy::new(&Multiple(1.01), &dataset).unwrap();
        let shapes = Gallery::new(&dataset).queries();
        let predicted =
            |query: &Query| Query { spectrum: query.spectrum.map(|x| 1.01 * x), ..*query };
        let predicted: Vec<Query> = shapes.iter().map(predicted).collect();
        let study = RetrievalStudy::of_shapes(shapes.clone(), predicted.clone()).unwrap();
        assert_eq!(study.fitted_to(), [COUNT, COUNT]);
        let options = MetricOptions::new();
        for source in [Source::Predicted, Source::True] {
            let found = study.euclidean(source).unwrap();
            assert_eq!(found, of_dataset.euclidean(source).unwrap());
            let found = study.by_likelihood(source, &options).unwrap();
            assert_eq!(found, of_dataset.by_likelihood(source, &options).unwrap());
        }
        let refused = RetrievalStudy::of_shapes(shapes[1..].to_vec(), predicted).err().unwrap();
        assert!(refused.to_string().contains("identity 0 in pose 0"), "{refused}");
    }

    #[test]
    fn errors_may_be_improved_and_added() {
        let options = MetricOptions::new();
        let study = RetrievalStudy::new(&Multiple(1.01), &dataset()).unwrap();
        let [euclidean, metric] = study.improved(1.0, &options).unwrap();
        assert_eq!(euclidean, study.euclidean(Source::Predicted).unwrap());
        assert_eq!(metric, study.by_likelihood(Source::Predicted, &options).unwrap());
        let nothing = Disturbance::Independent(0.0);
        let [euclidean, metric] = study.disturbed(&nothing, &options, 1).unwrap();
        assert!(euclidean.queries == COUNT * REPEATS && euclidean.top[0] < 0.2, "{euclidean:?}");
        assert_eq!(metric.top, [1.0; 3]);
        // The noise is as large as the differences of the identities.
        let noise = Disturbance::Independent(0.01);
        let [_, metric] = study.disturbed(&noise, &options, 1).unwrap();
        assert!(metric.top[0] < 0.98 && metric.top[0] > 0.6, "{metric:?}");
    }
}
