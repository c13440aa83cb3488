use std::path::Path;

use super::features::PartFeatures;
use super::localizer::Localizer;
use super::network::{
    Architecture, FEATURES, K, Parameter, ParameterLayout, Tape, column_units, forward,
    from_integers, is_quantized, quantize, to_integers,
};
use super::ood::{OodDetector, SYMMETRIC};
use super::spectrum;
use super::tensors::{Tensor, Tensors, to_bytes};
use catamaran::base::{Error, Result};

/// The weights that are part of the library (docs/model-card-unions.md).
const PRETRAINED: &[u8] = include_bytes!("unions.safetensors");

/// Largest logit: beyond it, the probability does not change.
const LARGEST: f64 = 20.0;

/// Number of unions that the network processes at once.
const BATCH: usize = 64;

/// Means and deviations that scale the inputs and outputs of the network to a size of about 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaling {
    /// Means of the features of each eigenvalue of a part, K x FEATURES by rows.
    pub feature_mean: Vec<f32>,
    /// Deviations of the features.
    pub feature_deviation: Vec<f32>,
    /// Means of the logits of union over bound, K.
    pub output_mean: Vec<f32>,
    /// Deviations of the logits.
    pub output_deviation: Vec<f32>,
}

impl Scaling {
    /// Returns the features of a part in units of their deviations, in the form that the network
    /// reads.
    pub fn features(&self, part: &[[f64; FEATURES]; K]) -> [f32; K * FEATURES] {
        let part = part.as_flattened();
        std::array::from_fn(|j| {
            let value = part[j] - f64::from(self.feature_mean[j]);
            (value / f64::from(self.feature_deviation[j])) as f32
        })
    }
}

/// The spectral union operator (thesis, section 2.4). From the first [`K`] Dirichlet eigenvalues of
/// each part of a surface, it predicts those of their union, whatever the geometry, and the
/// position of the union on a template.
///
/// By construction, a prediction is positive and ascending, at most the bound by domain
/// monotonicity (`lambda_i` of the union is at most the smallest one of the parts), the same for
/// all orders of the parts, bit for bit, and homogeneous: it scales with its arguments. Parts are
/// encoded separately and their codes are added, so that the grouping of parts does not matter:
/// unions are associative.
#[derive(Debug, Clone)]
pub struct SpectralUnion {
    sizes: Architecture,
    layout: ParameterLayout,
    parameters: Vec<f32>,
    /// For each quantized weight matrix, the value of one unit in each column.
    units: Vec<Vec<f32>>,
    scaling: Scaling,
    detector: OodDetector,
    localizer: Localizer,
}

impl SpectralUnion {
    /// Creates the network with the weights of the library.
    ///
    /// ```
    /// use catamaran_geometry::unions::SpectralUnion;
    ///
    /// let model = SpectralUnion::pretrained()?;
    /// assert_eq!(SpectralUnion::from_bytes(&model.to_bytes()?)?.parameters(), model.parameters());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// None, unless the build is broken.
    pub fn pretrained() -> Result<Self> {
        Self::from_bytes(PRETRAINED)
    }

    /// Creates the network from trained parameters, in the order of [`Architecture::layout`];
    /// weights are rounded as in files ([`quantize`]).
    ///
    /// # Errors
    /// [`Error::Argument`] and [`Error::Shape`] name the argument that does not fit.
    pub fn new(
        sizes: Architecture,
        mut parameters: Vec<f32>,
        scaling: Scaling,
        detector: OodDetector,
        localizer: Localizer,
    ) -> Result<Self> {
        sizes.check()?;
        let layout = sizes.layout();
        Error::check_shape("parameters", (layout.len, 1), (parameters.len(), 1))?;
        let matrices = layout.named.iter().filter(|(_, parameter)| is_quantized(parameter));
        let of = |(_, parameter): &(String, Parameter)| {
            column_units(&parameters[parameter.range()], parameter.columns)
        };
        let units = matrices.map(of).collect();
        layout
            .named
            .iter()
            .for_each(|(_, parameter)| quantize(parameter, &mut parameters[parameter.range()]));
        Self::assemble(sizes, parameters, units, scaling, detector, localizer)
    }

    fn assemble(
        sizes: Architecture,
        parameters: Vec<f32>,
        units: Vec<Vec<f32>>,
        scaling: Scaling,
        detector: OodDetector,
        localizer: Localizer,
    ) -> Result<Self> {
        Error::check_shape("localizer", (sizes.modes, 1), (localizer.modes(), 1))?;
        let layout = sizes.layout();
        let lengths = [
            ("feature_mean", &scaling.feature_mean, K * FEATURES),
            ("feature_deviation", &scaling.feature_deviation, K * FEATURES),
            ("output_mean", &scaling.output_mean, K),
            ("output_deviation", &scaling.output_deviation, K),
        ];
        for (what, values, len) in lengths {
            Error::check_shape(what, (len, 1), (values.len(), 1))?;
        }
        if scaling.feature_deviation.iter().any(|x| !x.is_normal()) {
            let why = "must not be zero".into();
            return Err(Error::Argument { what: "feature_deviation", why });
        }
        Ok(Self { sizes, layout, parameters, units, scaling, detector, localizer })
    }

    /// Reads the network from the bytes of a file that [`SpectralUnion::to_bytes`] made. The
    /// example of [`SpectralUnion::pretrained`] shows both.
    ///
    /// # Errors
    /// [`Error::Argument`] describes the defect of the weights.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let tensors = Tensors::new(bytes)?;
        let values = |name: &str, len| tensors.values(name, len);
        let sizes = values("sizes", 5)?;
        let [width, hidden, first_layers, second_layers, modes] =
            std::array::from_fn(|i| sizes[i] as usize);
        let sizes = Architecture { width, hidden, first_layers, second_layers, modes };
        sizes.check()?;
        let mut parameters = Vec::new();
        let mut units = Vec::new();
        for (name, parameter) in sizes.layout().named {
            let mut part = values(&name, parameter.range().len())?;
            if is_quantized(&parameter) {
                let own = values(&format!("{name}.unit"), parameter.columns)?;
                from_integers(&mut part, &own);
                units.push(own);
            }
            parameters.extend(part);
        }
        let scaling = Scaling {
            feature_mean: values("feature_mean", K * FEATURES)?,
            feature_deviation: values("feature_deviation", K * FEATURES)?,
            output_mean: values("output_mean", K)?,
            output_deviation: values("output_deviation", K)?,
        };
        let detector = OodDetector {
            mean: values("familiar_mean", SYMMETRIC)?,
            whitening: values("familiar_whitening", SYMMETRIC * SYMMETRIC)?,
            limit: values("familiar_limit", 1)?[0],
            probability_limit: values("doubt_limit", 1)?[0],
        };
        let localizer = Localizer::from_tensors(&tensors, modes)?;
        Self::assemble(sizes, parameters, units, scaling, detector, localizer)
    }

    /// Reads the network from a file of weights (safetensors).
    ///
    /// # Errors
    /// [`Error::Io`] names the file.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|e| Error::io(path, e))?;
        Self::from_bytes(&bytes).map_err(|e| Error::file(path, e.to_string()))
    }

    /// Returns the bytes of a file of the weights, in the safetensors format; the same weights give
    /// the same bytes.
    ///
    /// # Errors
    /// [`Error::Argument`] when the format can't store the weights.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let Architecture { width, hidden, first_layers, second_layers, modes } = self.sizes;
        let sizes = [width, hidden, first_layers, second_layers, modes].map(|x| x as f32);
        let whole = self.localizer.whole();
        let (scaling, detector) = (&self.scaling, &self.detector);
        let limits = [detector.limit, detector.probability_limit];
        let mut tensors: Vec<(&str, Tensor<'_>)> = vec![
            ("sizes", Tensor::new(5, &sizes)),
            ("feature_mean", Tensor::new(FEATURES, &scaling.feature_mean)),
            ("feature_deviation", Tensor::new(FEATURES, &scaling.feature_deviation)),
            ("output_mean", Tensor::new(K, &scaling.output_mean)),
            ("output_deviation", Tensor::new(K, &scaling.output_deviation)),
            ("familiar_mean", Tensor::new(SYMMETRIC, &detector.mean)),
            ("familiar_whitening", Tensor::new(SYMMETRIC, &detector.whitening)),
            ("familiar_limit", Tensor::new(1, &limits[..1])),
            ("doubt_limit", Tensor::new(1, &limits[1..])),
        ];
        tensors.extend(self.localizer.tensors(&whole));
        let matrices = self.layout.named.iter().filter(|(_, parameter)| is_quantized(parameter));
        let quantized: Vec<_> = matrices
            .zip(&self.units)
            .map(|((name, parameter), units)| {
                let whole = to_integers(&self.parameters[parameter.range()], units);
                (name, format!("{name}.unit"), units, whole)
            })
            .collect();
        for (name, unit, units, whole) in &quantized {
            tensors.push((name, Tensor::whole(units.len(), whole)));
            tensors.push((unit, Tensor::new(units.len(), units)));
        }
        for (name, parameter) in
            self.layout.named.iter().filter(|(_, parameter)| !is_quantized(parameter))
        {
            tensors
                .push((name, Tensor::new(parameter.columns, &self.parameters[parameter.range()])));
        }
        to_bytes(tensors)
    }

    /// Returns the sizes of the network.
    pub fn architecture(&self) -> Architecture {
        self.sizes
    }

    /// Returns the parameters, in the order of [`Architecture::layout`].
    pub fn parameters(&self) -> &[f32] {
        &self.parameters
    }

    /// Returns the scaling of inputs and outputs of the network.
    pub fn scaling(&self) -> &Scaling {
        &self.scaling
    }

    /// Predicts the K first eigenvalues of the union of two parts, from those of the parts, in the
    /// same unit.
    ///
    /// ```
    /// use catamaran_geometry::unions::{K, SpectralUnion};
    ///
    /// let part: Vec<f64> = (1..=K).map(|k| 40.0 * k as f64).collect();
    /// let union = SpectralUnion::pretrained()?.predict(&part, &part)?;
    /// // A larger domain has smaller eigenvalues.
    /// assert!(union.iter().zip(&part).all(|(union, part)| union <= part));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NonFinite`] and [`Error::Argument`] (not positive, not ascending)
    /// name the spectrum at fault, `first` or `second`.
    pub fn predict(&self, first: &[f64], second: &[f64]) -> Result<[f64; K]> {
        let input = PartFeatures::of_pair(first, second)?;
        let tape = self.run(&[&input]);
        Ok(self.union(&input, &tape.output))
    }

    /// Predicts the unions of many pairs of parts: the same as [`SpectralUnion::predict`] of each
    /// pair, bit for bit, in a fraction of the time.
    ///
    /// ```
    /// use catamaran_geometry::unions::{K, SpectralUnion};
    ///
    /// let part = |scale: f64| (1..=K).map(|k| scale * k as f64).collect::<Vec<_>>();
    /// let (first, second) = (part(40.0), part(50.0));
    /// let model = SpectralUnion::pretrained()?;
    /// let unions = model.predict_each(&[[&first, &second], [&second, &second]])?;
    /// assert_eq!(unions[0], model.predict(&first, &second)?);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`SpectralUnion::predict`], for the first invalid pair.
    pub fn predict_each(&self, pairs: &[[&[f64]; 2]]) -> Result<Vec<[f64; K]>> {
        let mut unions = Vec::with_capacity(pairs.len());
        for pairs in pairs.chunks(BATCH) {
            let input = |[first, second]: &[&[f64]; 2]| PartFeatures::of_pair(first, second);
            let inputs = pairs.iter().map(input).collect::<Result<Vec<PartFeatures>>>()?;
            let tape = self.run(&inputs.iter().collect::<Vec<_>>());
            let outputs = inputs.iter().zip(tape.output.chunks_exact(K));
            unions.extend(outputs.map(|(input, output)| self.union(input, output)));
        }
        Ok(unions)
    }

    /// Runs the network on unions with the same number of parts.
    fn run(&self, inputs: &[&PartFeatures]) -> Tape<f32> {
        let parts = inputs[0].features.len();
        let mut tape = Tape::new(&self.sizes, inputs.len(), parts);
        let rows = tape.features.chunks_exact_mut(K * FEATURES);
        let part = |at: usize| &inputs[at % inputs.len()].features[at / inputs.len()];
        rows.enumerate().for_each(|(at, row)| {
            row.copy_from_slice(&self.scaling.features(part(at)));
        });
        forward(&self.sizes, &self.layout, &self.parameters, &mut tape);
        tape
    }

    /// Returns the spectrum that an output of the network stands for.
    fn union(&self, input: &PartFeatures, output: &[f32]) -> [f64; K] {
        let below: [f64; K] = std::array::from_fn(|i| {
            let output = f64::from(output[i] * self.scaling.output_deviation[i]);
            let logit = output + f64::from(self.scaling.output_mean[i]);
            // Extreme weights give NaN.
            let logit = if logit.is_nan() { 0.0 } else { logit.clamp(-LARGEST, LARGEST) };
            input.bound[i] / (1.0 + (-logit).exp())
        });
        spectrum::ascending(&below)
    }

    /// Predicts the eigenvalues of the union of any number of parts. The order of the parts does
    /// not change the result, bit for bit: they are sorted by their eigenvalues. The network was
    /// trained on up to four.
    ///
    /// ```
    /// use catamaran_geometry::unions::{K, SpectralUnion};
    ///
    /// let part = |scale: f64| (1..=K).map(|k| scale * k as f64).collect::<Vec<_>>();
    /// let (first, second, third) = (part(40.0), part(50.0), part(60.0));
    /// let model = SpectralUnion::pretrained()?;
    /// let union = model.predict_all(&[&first, &second, &third])?;
    /// assert_eq!(union, model.predict_all(&[&third, &first, &second])?);
    /// assert!(union.iter().zip(&first).all(|(union, part)| union <= part));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`SpectralUnion::predict`], except that errors name `parts`; [`Error::Argument`] for no
    /// parts.
    pub fn predict_all(&self, parts: &[&[f64]]) -> Result<[f64; K]> {
        let parts = sorted(parts)?;
        if let [part] = parts[..] {
            return Ok(part);
        }
        let input = PartFeatures::new(&parts)?;
        let tape = self.run(&[&input]);
        Ok(self.union(&input, &tape.output))
    }

    /// Predicts the position of the union of any number of parts on the template, as coefficients
    /// of its eigenfunctions, which [`Localizer::on_mesh`] turns into a function. The order of the
    /// parts does not matter, as in [`SpectralUnion::predict_all`].
    ///
    /// ```
    /// use catamaran_geometry::unions::{K, SpectralUnion};
    ///
    /// let part = |scale: f64| (1..=K).map(|k| scale * k as f64).collect::<Vec<_>>();
    /// let (first, second) = (part(40.0), part(50.0));
    /// let model = SpectralUnion::pretrained()?;
    /// let region = model.locate(&[&first, &second])?;
    /// assert_eq!(region.len(), model.localizer().modes());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`SpectralUnion::predict_all`].
    pub fn locate(&self, parts: &[&[f64]]) -> Result<Vec<f32>> {
        let mut parts = sorted(parts)?;
        if let [part] = parts[..] {
            // A single part is the union of itself with itself.
            parts.push(part);
        }
        Ok(self.run(&[&PartFeatures::new(&parts)?]).region)
    }

    /// Returns the template of [`SpectralUnion::locate`].
    pub fn localizer(&self) -> &Localizer {
        &self.localizer
    }

    /// Computes the probability that two parts come from another kind of shape than the template,
    /// among the kinds of the training.
    ///
    /// # Errors
    /// As [`SpectralUnion::predict`].
    pub fn ood_probability(&self, first: &[f64], second: &[f64]) -> Result<f64> {
        Ok(self.ood_probability_of(&PartFeatures::of_pair(first, second)?))
    }

    fn ood_probability_of(&self, input: &PartFeatures) -> f64 {
        let logit = f64::from(self.run(&[input]).ood_logit[0]);
        // Extreme weights give NaN.
        if logit.is_nan() { 1.0 } else { 1.0 / (1.0 + (-logit).exp()) }
    }

    /// Computes the out-of-distribution score of parts: the largest score of all their pairs. The
    /// score of a pair is its Mahalanobis distance from the mean of the training, or its
    /// [probability](SpectralUnion::ood_probability), whichever is larger, each in units of the
    /// limit that 99.5 % of the training pairs do not exceed. A prediction for parts with a score
    /// above 1 is a guess. A score below 1 says nothing about the error: see the measurements in
    /// docs/model-card-unions.md.
    ///
    /// ```
    /// use catamaran_geometry::unions::{K, SpectralUnion};
    ///
    /// // A spectrum that grows too fast is not that of a part of the template.
    /// let part: Vec<f64> = (0..K as i32).map(|k| 4.0_f64.powi(k)).collect();
    /// assert!(SpectralUnion::pretrained()?.ood_score(&[&part, &part])? > 1.0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`SpectralUnion::predict`].
    pub fn ood_score(&self, parts: &[&[f64]]) -> Result<f64> {
        let mut largest: f64 = 0.0;
        for (i, first) in parts.iter().enumerate() {
            for second in &parts[i + 1..] {
                let input = PartFeatures::of_pair(first, second)?;
                let probability = self.ood_probability_of(&input);
                largest = largest.max(self.detector.ood_score(&input.symmetric(), probability));
            }
        }
        Ok(largest)
    }
}

/// Returns the parts in the order of their eigenvalues.
fn sorted(parts: &[&[f64]]) -> Result<Vec<[f64; K]>> {
    let mut parts: Vec<[f64; K]> =
        parts.iter().map(|part| spectrum::check("parts", part)).collect::<Result<_>>()?;
    let order = |a: &f64, b: &f64| a.total_cmp(b);
    parts.sort_by(|a, b| {
        let differing = a.iter().zip(b).map(|(a, b)| order(a, b)).find(|o| o.is_ne());
        differing.unwrap_or(std::cmp::Ordering::Equal)
    });
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran::base::Rng;

    const SIZES: Architecture =
        Architecture { width: 16, hidden: 24, first_layers: 2, second_layers: 1, modes: 3 };

    /// Returns a network with random weights.
    fn random(seed: u64, size: f64) -> SpectralUnion {
        let mut rng = Rng::new(seed);
        let mut numbers = |n: usize| (0..n).map(|_| (size * rng.normal()) as f32).collect();
        let parameters: Vec<f32> = numbers(SIZES.layout().len);
        let scaling = Scaling {
            feature_mean: numbers(K * FEATURES),
            feature_deviation: vec![1.5; K * FEATURES],
            output_mean: numbers(K),
            output_deviation: vec![2.0; K],
        };
        let pairs: Vec<[f64; SYMMETRIC]> =
            (0..50).map(|_| std::array::from_fn(|_| rng.normal())).collect();
        let detector = OodDetector::fit(&pairs, 1.0).unwrap();
        let localizer = Localizer::new(3, vec![0, 2, 4, 7], vec![0.5; 12], 9).unwrap();
        SpectralUnion::new(SIZES, parameters, scaling, detector, localizer).unwrap()
    }

    /// Returns an ascending sequence with some equal values, over some powers of ten.
    fn spectrum(rng: &mut Rng) -> [f64; K] {
        let mut value = 10_f64.powf(4.0 * rng.uniform() - 2.0);
        std::array::from_fn(|_| {
            value *= if rng.uniform() < 0.2 { 1.0 } else { 1.0 + rng.uniform() };
            value
        })
    }

    #[test]
    fn predictions_are_spectra_below_the_bound_whatever_the_weights_are() {
        let mut rng = Rng::new(1);
        for size in [0.05, 0.5, 10.0, 1e30] {
            let model = random(2, size);
            for _ in 0..50 {
                let (a, b) = (spectrum(&mut rng), spectrum(&mut rng));
                let union = model.predict(&a, &b).unwrap();
                assert!(union.is_sorted() && union[0] > 0.0, "{union:?}");
                for i in 0..K {
                    assert!(union[i] <= a[i].min(b[i]));
                    // Rounded values satisfy the same conditions.
                    assert!(union[i] as f32 <= (a[i] as f32).min(b[i] as f32));
                }
            }
        }
    }

    #[test]
    fn the_order_of_parts_does_not_matter() {
        let (model, mut rng) = (random(3, 0.3), Rng::new(4));
        for _ in 0..20 {
            let parts: Vec<[f64; K]> = (0..4).map(|_| spectrum(&mut rng)).collect();
            let [a, b, c, d] = std::array::from_fn(|i| &parts[i][..]);
            assert_eq!(model.predict(a, b).unwrap(), model.predict(b, a).unwrap());
            assert_eq!(model.ood_score(&[a, b]).unwrap(), model.ood_score(&[b, a]).unwrap());
            assert_eq!(model.predict(a, b).unwrap(), model.predict_all(&[a, b]).unwrap());
            let all = model.predict_all(&[a, b, c, d]).unwrap();
            for order in [[d, c, b, a], [c, a, d, b]] {
                assert_eq!(model.predict_all(&order).unwrap(), all);
                assert_eq!(model.locate(&order).unwrap(), model.locate(&[a, b, c, d]).unwrap());
            }
            assert_eq!(model.locate(&[a]).unwrap(), model.locate(&[a, a]).unwrap());
            assert_eq!(model.predict_all(&[a]).unwrap(), parts[0]);
        }
    }

    #[test]
    fn many_pairs_at_once_are_as_one_by_one() {
        let (model, mut rng) = (random(11, 0.3), Rng::new(12));
        let parts: Vec<[f64; K]> = (0..BATCH + 6).map(|_| spectrum(&mut rng)).collect();
        let mut pairs: Vec<[&[f64]; 2]> = parts.windows(2).map(|w| [&w[0][..], &w[1]]).collect();
        let each = model.predict_each(&pairs).unwrap();
        assert_eq!(each.len(), pairs.len());
        for ([a, b], union) in pairs.iter().zip(&each) {
            assert_eq!(model.predict(a, b).unwrap(), *union);
        }
        assert!(model.predict_each(&[]).unwrap().is_empty());
        pairs[BATCH + 2][1] = &[];
        assert!(model.predict_each(&pairs).unwrap_err().to_string().starts_with("second"));
    }

    #[test]
    fn units_do_not_matter() {
        let (model, mut rng) = (random(5, 0.3), Rng::new(6));
        for _ in 0..20 {
            let (a, b) = (spectrum(&mut rng), spectrum(&mut rng));
            let union = model.predict(&a, &b).unwrap();
            let with = |factor: f64| {
                model.predict(&a.map(|x| factor * x), &b.map(|x| factor * x)).unwrap()
            };
            assert_eq!(with(1024.0), union.map(|x| 1024.0 * x), "powers of two scale exactly");
            for (x, y) in with(3.7).into_iter().zip(union) {
                assert!((x / (3.7 * y) - 1.0).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn files_give_the_same_network_back_and_broken_ones_are_refused() {
        let (model, mut rng) = (random(7, 0.3), Rng::new(8));
        let bytes = model.to_bytes().unwrap();
        let again = SpectralUnion::from_bytes(&bytes).unwrap();
        assert_eq!(again.to_bytes().unwrap(), bytes);
        let (a, b) = (spectrum(&mut rng), spectrum(&mut rng));
        assert_eq!(again.predict(&a, &b).unwrap(), model.predict(&a, &b).unwrap());
        for broken in [&bytes[..50], &bytes[..bytes.len() - 4], &[][..]] {
            assert!(matches!(
                SpectralUnion::from_bytes(broken).unwrap_err(),
                Error::Argument { what: "weights", .. }
            ));
        }
        let mut rotten = bytes.clone();
        // Numbers in single precision come first, after the header.
        let header = u64::from_le_bytes(*bytes.first_chunk().unwrap()) as usize;
        rotten[8 + header..][..4].copy_from_slice(&[0xff; 4]);
        assert!(SpectralUnion::from_bytes(&rotten).unwrap_err().to_string().contains("not finite"));
        assert!(
            SpectralUnion::read(Path::new("/nowhere")).unwrap_err().to_string().contains("nowhere")
        );
    }

    #[test]
    fn what_is_no_spectrum_is_refused_by_name() {
        let model = random(9, 0.3);
        let good: [f64; K] = std::array::from_fn(|i| (i + 1) as f64);
        let mut bad = good;
        bad[4] = 3.0;
        assert!(model.predict(&good, &bad).unwrap_err().to_string().starts_with("second"));
        assert!(model.predict(&good[..19], &good).unwrap_err().to_string().starts_with("first"));
        assert!(model.predict_all(&[&good, &bad]).unwrap_err().to_string().starts_with("parts"));
        assert!(model.predict_all(&[]).unwrap_err().to_string().starts_with("parts"));
    }
}
