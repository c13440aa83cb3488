use pulp::{Arch, Simd, WithSimd};

use super::kernel::{Number, gemm, normalize};
use super::{Architecture, FEATURES, K, LayerPlaces, Places};

/// What a layer computed, `K` rows for each sequence.
#[derive(Debug, Clone, Default)]
pub struct LayerTape<T> {
    /// What it was given.
    pub input: Vec<T>,
    /// The input, normalised, before scale and shift.
    pub attention_unit: Vec<T>,
    /// One over the deviations of the rows of the input.
    pub attention_inverse: Vec<T>,
    /// With scale and shift.
    pub attention_normed: Vec<T>,
    /// Queries, keys and values: three times the width.
    pub queries_keys_values: Vec<T>,
    /// For each sequence and head: a row for each key, in it the weights of it for all queries.
    pub attention: Vec<T>,
    /// Values, mixed with these weights.
    pub mixed: Vec<T>,
    /// The input plus what attention adds.
    pub middle: Vec<T>,
    /// As `attention_unit`, of `middle`.
    pub forward_unit: Vec<T>,
    /// As `attention_inverse`, of `middle`.
    pub forward_inverse: Vec<T>,
    /// As `attention_normed`, of `middle`.
    pub forward_normed: Vec<T>,
    /// Hidden neurons, after rectification.
    pub hidden: Vec<T>,
    /// What it gives.
    pub output: Vec<T>,
}

impl<T: Number> LayerTape<T> {
    fn new(sizes: &Architecture, sequences: usize) -> Self {
        let rows = sequences * K;
        let zeros = |columns: usize| vec![T::ZERO; rows * columns];
        let wide = || zeros(sizes.width);
        Self {
            input: wide(),
            attention_unit: wide(),
            attention_inverse: zeros(1),
            attention_normed: wide(),
            queries_keys_values: zeros(3 * sizes.width),
            attention: zeros(sizes.heads * K),
            mixed: wide(),
            middle: wide(),
            forward_unit: wide(),
            forward_inverse: zeros(1),
            forward_normed: wide(),
            hidden: zeros(sizes.hidden),
            output: wide(),
        }
    }

    /// `output` from `input`.
    fn run(&mut self, sizes: &Architecture, places: &LayerPlaces, parameters: &[T]) {
        let of = |pair: [super::Place; 2]| pair.map(|place| &parameters[place.range()]);
        normalize(
            &self.input,
            of(places.attention_norm),
            &mut self.attention_unit,
            &mut self.attention_inverse,
            &mut self.attention_normed,
        );
        linear(&self.attention_normed, of(places.queries_keys_values), &mut self.queries_keys_values);
        Arch::new().dispatch(Attention {
            sizes,
            queries_keys_values: &self.queries_keys_values,
            attention: &mut self.attention,
            mixed: &mut self.mixed,
        });
        linear(&self.mixed, of(places.mix), &mut self.middle);
        add(&mut self.middle, &self.input);
        normalize(
            &self.middle,
            of(places.forward_norm),
            &mut self.forward_unit,
            &mut self.forward_inverse,
            &mut self.forward_normed,
        );
        linear(&self.forward_normed, of(places.up), &mut self.hidden);
        for x in &mut self.hidden {
            *x = if *x > T::ZERO { *x } else { T::ZERO };
        }
        linear(&self.hidden, of(places.down), &mut self.output);
        add(&mut self.output, &self.middle);
    }
}

/// `y := x weights + bias`, a row for each row of x.
fn linear<T: Number>(x: &[T], [weights, bias]: [&[T]; 2], y: &mut [T]) {
    let columns = bias.len();
    let inner = weights.len() / columns;
    for row in y.chunks_exact_mut(columns) {
        row.copy_from_slice(bias);
    }
    gemm((y.len() / columns, inner, columns), x, (inner, 1), weights, y);
}

fn add<T: Number>(sum: &mut [T], x: &[T]) {
    for (sum, &x) in sum.iter_mut().zip(x) {
        *sum += x;
    }
}

/// Scaled dot-product attention (Vaswani et al. 2017), the queries in lanes.
struct Attention<'a, T> {
    sizes: &'a Architecture,
    queries_keys_values: &'a [T],
    attention: &'a mut [T],
    mixed: &'a mut [T],
}

impl<T: Number> WithSimd for Attention<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Architecture { width, heads, .. } = *self.sizes;
        let depth = width / heads;
        let scale = T::ONE / T::from_f64(depth as f64).sqrt();
        let sequences = self.mixed.len() / (K * width);
        for sequence in 0..sequences {
            let given = &self.queries_keys_values[sequence * K * 3 * width..][..K * 3 * width];
            let mixed = &mut self.mixed[sequence * K * width..][..K * width];
            for head in 0..heads {
                let start = (sequence * heads + head) * K * K;
                let weights = &mut self.attention[start..start + K * K];
                let (weights, _) = weights.as_chunks_mut::<K>();
                weights.fill([T::ZERO; K]);
                for t in head * depth..(head + 1) * depth {
                    let queries: [T; K] =
                        std::array::from_fn(|query| given[query * 3 * width + t] * scale);
                    for (key, scores) in weights.iter_mut().enumerate() {
                        let factor = given[key * 3 * width + width + t];
                        for query in 0..K {
                            scores[query] += factor * queries[query];
                        }
                    }
                }
                softmax(weights);
                for t in head * depth..(head + 1) * depth {
                    let mut lanes = [T::ZERO; K];
                    for (key, weights) in weights.iter().enumerate() {
                        let value = given[key * 3 * width + 2 * width + t];
                        for query in 0..K {
                            lanes[query] += weights[query] * value;
                        }
                    }
                    for query in 0..K {
                        mixed[query * width + t] = lanes[query];
                    }
                }
            }
        }
    }
}

/// Makes the columns exponentials with sum 1.
#[inline(always)]
fn softmax<T: Number>(rows: &mut [[T; K]]) {
    let mut largest = rows[0];
    for row in rows.iter() {
        for lane in 0..K {
            largest[lane] = if row[lane] > largest[lane] { row[lane] } else { largest[lane] };
        }
    }
    let mut total = [T::ZERO; K];
    for row in rows.iter_mut() {
        for lane in 0..K {
            row[lane] = row[lane] - largest[lane];
        }
        T::exp_lanes(row);
        for lane in 0..K {
            total[lane] += row[lane];
        }
    }
    for lane in 0..K {
        total[lane] = T::ONE / total[lane];
    }
    for row in rows.iter_mut() {
        for lane in 0..K {
            row[lane] *= total[lane];
        }
    }
}

/// Everything that [`forward`] computes for a number of pairs.
#[derive(Debug, Clone)]
pub struct Tape<T> {
    /// Tokens, `FEATURES` each: those of the first spectrum of every pair informed about the second, then those of the second
    /// ones informed about the first. To be filled in before [`forward`].
    pub tokens: Vec<T>,
    /// The layers of the first transformer, on twice as many sequences as there are pairs.
    pub first: Vec<LayerTape<T>>,
    /// Those of the second one.
    pub second: Vec<LayerTape<T>>,
    /// What the last layer gave, normalised.
    pub unit: Vec<T>,
    /// One over the deviations of its rows.
    pub inverse: Vec<T>,
    /// With scale and shift.
    pub normed: Vec<T>,
    /// The output: a number for each token of the union.
    pub output: Vec<T>,
}

impl<T: Number> Tape<T> {
    /// For `pairs` pairs.
    pub fn new(sizes: &Architecture, pairs: usize) -> Self {
        let layers = |count: usize, sequences: usize| -> Vec<LayerTape<T>> {
            (0..count).map(|_| LayerTape::new(sizes, sequences)).collect()
        };
        Self {
            tokens: vec![T::ZERO; 2 * pairs * K * FEATURES],
            first: layers(sizes.first_layers, 2 * pairs),
            second: layers(sizes.second_layers, pairs),
            unit: vec![T::ZERO; pairs * K * sizes.width],
            inverse: vec![T::ZERO; pairs * K],
            normed: vec![T::ZERO; pairs * K * sizes.width],
            output: vec![T::ZERO; pairs * K],
        }
    }
}

/// From `tape.tokens` to `tape.output`. Swapping the two spectra of a pair leaves its output as it is, bit for bit: the first
/// transformer runs on both orders, and the two results are added.
///
/// # Panics
/// When `tape` or `parameters` are of another architecture.
pub fn forward<T: Number>(
    sizes: &Architecture,
    places: &Places,
    parameters: &[T],
    tape: &mut Tape<T>,
) {
    let width = sizes.width;
    let position = &parameters[places.position.range()];
    let mut x: Vec<T> = Vec::with_capacity(tape.tokens.len() / FEATURES * width);
    for _ in 0..tape.tokens.len() / (FEATURES * K) {
        x.extend_from_slice(position);
    }
    let shape = (x.len() / width, FEATURES, width);
    gemm(shape, &tape.tokens, (FEATURES, 1), &parameters[places.embedding.range()], &mut x);
    let through = |x: &mut Vec<T>, layers: &mut [LayerTape<T>], places: &[LayerPlaces]| {
        for (layer, places) in layers.iter_mut().zip(places) {
            layer.input.copy_from_slice(x);
            layer.run(sizes, places, parameters);
            x.copy_from_slice(&layer.output);
        }
    };
    through(&mut x, &mut tape.first, &places.first);
    let mut union = x.split_off(x.len() / 2);
    add(&mut union, &x);
    through(&mut union, &mut tape.second, &places.second);
    let norm = places.norm.map(|place| &parameters[place.range()]);
    normalize(&union, norm, &mut tape.unit, &mut tape.inverse, &mut tape.normed);
    let head = places.head.map(|place| &parameters[place.range()]);
    linear(&tape.normed, head, &mut tape.output);
}
