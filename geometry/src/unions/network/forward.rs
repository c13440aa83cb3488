use super::kernel::{Number, gemm, normalize};
use super::{Architecture, FEATURES, INPUTS, K, LayerLayout, OCTAVES, Parameter, ParameterLayout};

/// The intermediate results of a layer, a row for each input: `x + down(a g / (1 + e^-g))` with
/// `(a, g) = up(normalized x)`.
#[derive(Debug, Clone, Default)]
pub struct LayerTape<T> {
    /// The normalized input, before scale and shift.
    pub unit: Vec<T>,
    /// The inverse deviations of the rows of the input.
    pub inverse: Vec<T>,
    /// The normalized input, with scale and shift.
    pub normed: Vec<T>,
    /// Hidden neurons and gates before their product, `2 hidden` in a row.
    pub up: Vec<T>,
    /// Hidden neurons after multiplication by their gates.
    pub hidden: Vec<T>,
}

impl<T: Number> LayerTape<T> {
    fn new(sizes: &Architecture, rows: usize) -> Self {
        let zeros = |columns: usize| vec![T::ZERO; rows * columns];
        Self {
            unit: zeros(sizes.width),
            inverse: zeros(1),
            normed: zeros(sizes.width),
            up: zeros(2 * sizes.hidden),
            hidden: zeros(sizes.hidden),
        }
    }

    /// Replaces `x` by the output of the layer.
    fn run(&mut self, layout: &LayerLayout, parameters: &[T], x: &mut [T]) {
        let norm = of(parameters, layout.norm);
        normalize(x, norm, &mut self.unit, &mut self.inverse, &mut self.normed);
        linear(&self.normed, of(parameters, layout.up), &mut self.up);
        let hidden = layout.down[0].rows;
        for (hidden, up) in
            self.hidden.chunks_exact_mut(hidden).zip(self.up.chunks_exact(2 * hidden))
        {
            let (values, gates) = up.split_at(hidden.len());
            for (hidden, (&value, &gate)) in hidden.iter_mut().zip(values.iter().zip(gates)) {
                *hidden = value * gate * sigmoid(gate);
            }
        }
        let [weights, bias] = of(parameters, layout.down);
        for row in x.chunks_exact_mut(bias.len()) {
            add(row, bias);
        }
        product(&self.hidden, weights, bias.len(), x);
    }
}

/// Returns `1 / (1 + e^-x)`.
pub fn sigmoid<T: Number>(x: T) -> T {
    T::ONE / (T::ONE + (-x).exp())
}

/// Computes the features and their waves, `K x INPUTS` in a row, from each row of `K x FEATURES`.
fn waves<T: Number>(features: &[T], inputs: &mut [T]) {
    let rows = features.chunks_exact(K * FEATURES).zip(inputs.chunks_exact_mut(K * INPUTS));
    for (features, inputs) in rows {
        let (plain, waves) = inputs.split_at_mut(K * FEATURES);
        plain.copy_from_slice(features);
        // The logarithm is the first feature of each eigenvalue.
        let logarithms = features.chunks_exact(FEATURES).map(|row| row[0]);
        for (waves, logarithm) in waves.chunks_exact_mut(2 * OCTAVES).zip(logarithms) {
            let (mut sine, mut cosine) = logarithm.sin_cos();
            for wave in waves.chunks_exact_mut(2) {
                wave.copy_from_slice(&[sine, cosine]);
                let twice = T::from_f64(2.0) * sine;
                (sine, cosine) = (twice * cosine, T::ONE - twice * sine);
            }
        }
    }
}

fn of<T>(parameters: &[T], pair: [Parameter; 2]) -> [&[T]; 2] {
    pair.map(|parameter| &parameters[parameter.range()])
}

/// Computes `y := x weights + bias`, a row for each row of x.
fn linear<T: Number>(x: &[T], [weights, bias]: [&[T]; 2], y: &mut [T]) {
    for row in y.chunks_exact_mut(bias.len()) {
        row.copy_from_slice(bias);
    }
    product(x, weights, bias.len(), y);
}

/// Computes `y += x weights`.
fn product<T: Number>(x: &[T], weights: &[T], columns: usize, y: &mut [T]) {
    let inner = weights.len() / columns;
    gemm((y.len() / columns, inner, columns), x, (inner, 1), weights, y);
}

fn add<T: Number>(sum: &mut [T], x: &[T]) {
    for (sum, &x) in sum.iter_mut().zip(x) {
        *sum += x;
    }
}

/// All intermediate results of [`forward`] for several unions with the same number of parts. "A row
/// for each part" means the rows of the first parts of all unions, then the rows of the second
/// parts, and so on.
#[derive(Debug, Clone)]
pub struct Tape<T> {
    /// Features, `K x FEATURES` in a row for each part. The caller fills them in before
    /// [`forward`].
    pub features: Vec<T>,
    /// Input of the first layer, `K x INPUTS` in a row for each part.
    pub inputs: Vec<T>,
    /// The layers of the encoder, a row for each part.
    pub first: Vec<LayerTape<T>>,
    /// The layers of the decoder, a row for each union.
    pub second: Vec<LayerTape<T>>,
    /// The normalized output of the last layer.
    pub unit: Vec<T>,
    /// The inverse deviations of its rows.
    pub inverse: Vec<T>,
    /// The normalized output of the last layer, with scale and shift.
    pub normed: Vec<T>,
    /// The output: a number for each eigenvalue of the union.
    pub output: Vec<T>,
    /// Position of the union: coefficients of eigenfunctions of a template.
    pub region: Vec<T>,
    /// The logit of the probability that the parts come from another kind of shape than the
    /// template.
    pub ood_logit: Vec<T>,
    /// The normalized output of the encoder, a row for each part.
    pub part_unit: Vec<T>,
    /// The inverse deviations of its rows.
    pub part_inverse: Vec<T>,
    /// The normalized output of the encoder, with scale and shift.
    pub part_normed: Vec<T>,
    /// Positions of the parts: coefficients, a row for each part.
    pub part_region: Vec<T>,
}

impl<T: Number> Tape<T> {
    /// Allocates the tape of this number of unions, each of `parts` parts.
    pub fn new(sizes: &Architecture, unions: usize, parts: usize) -> Self {
        let layers = |count: usize, rows: usize| -> Vec<LayerTape<T>> {
            (0..count).map(|_| LayerTape::new(sizes, rows)).collect()
        };
        let rows = unions * parts;
        Self {
            features: vec![T::ZERO; rows * K * FEATURES],
            inputs: vec![T::ZERO; rows * K * INPUTS],
            first: layers(sizes.first_layers, rows),
            second: layers(sizes.second_layers, unions),
            unit: vec![T::ZERO; unions * sizes.width],
            inverse: vec![T::ZERO; unions],
            normed: vec![T::ZERO; unions * sizes.width],
            output: vec![T::ZERO; unions * K],
            region: vec![T::ZERO; unions * sizes.modes],
            ood_logit: vec![T::ZERO; unions],
            part_unit: vec![T::ZERO; rows * sizes.width],
            part_inverse: vec![T::ZERO; rows],
            part_normed: vec![T::ZERO; rows * sizes.width],
            part_region: vec![T::ZERO; rows * sizes.modes],
        }
    }
}

/// Computes `tape.output`, the regions and the out-of-distribution logit from `tape.features`. The
/// outputs of the encoder for the parts of a union are added, part by part: the order of two parts
/// does not change the result, bit for bit.
///
/// # Panics
/// When `tape` or `parameters` belong to another architecture.
pub fn forward<T: Number>(
    sizes: &Architecture,
    layout: &ParameterLayout,
    parameters: &[T],
    tape: &mut Tape<T>,
) {
    let rows = tape.features.len() / (K * FEATURES);
    let mut x = vec![T::ZERO; rows * sizes.width];
    waves(&tape.features, &mut tape.inputs);
    linear(&tape.inputs, of(parameters, layout.embedding), &mut x);
    for (layer, layout) in tape.first.iter_mut().zip(&layout.first) {
        layer.run(layout, parameters, &mut x);
    }
    let norm = of(parameters, layout.part_norm);
    let Tape { part_unit, part_inverse, part_normed, .. } = tape;
    normalize(&x, norm, part_unit, part_inverse, part_normed);
    linear(&tape.part_normed, of(parameters, layout.part_region), &mut tape.part_region);
    let mut union = x.split_off(x.len() - tape.unit.len());
    x.chunks_exact(union.len()).for_each(|parts| add(&mut union, parts));
    for (layer, layout) in tape.second.iter_mut().zip(&layout.second) {
        layer.run(layout, parameters, &mut union);
    }
    let norm = of(parameters, layout.norm);
    normalize(&union, norm, &mut tape.unit, &mut tape.inverse, &mut tape.normed);
    linear(&tape.normed, of(parameters, layout.head), &mut tape.output);
    linear(&tape.normed, of(parameters, layout.region), &mut tape.region);
    linear(&tape.normed, of(parameters, layout.ood_logit), &mut tape.ood_logit);
}
