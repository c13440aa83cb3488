use catamaran_geometry::unions::network::{K, Number, Parameter, gemm, normalize};

use super::attention::attend;
use super::layout::{Branch, HEADS, Kind, Layout, POSITIONAL, Stack, WIDTH};
use crate::network::add;

/// Results of a normalization.
#[derive(Debug, Clone)]
pub struct NormTape<T> {
    /// The normalized input, before scale and shift.
    pub unit: Vec<T>,
    /// One over the deviations of the rows of the input.
    pub inverse: Vec<T>,
    /// The normalized input, with scale and shift.
    pub normed: Vec<T>,
}

impl<T: Number> NormTape<T> {
    fn new(tokens: usize) -> Self {
        let zeros = |columns: usize| vec![T::ZERO; tokens * columns];
        Self { unit: zeros(WIDTH), inverse: zeros(1), normed: zeros(WIDTH) }
    }

    fn run(&mut self, norm: [Parameter; 2], parameters: &[T], x: &[T]) {
        let Self { unit, inverse, normed } = self;
        normalize(x, of(parameters, norm), unit, inverse, normed);
    }
}

/// Results of a residual branch.
#[derive(Debug, Clone)]
pub struct BranchTape<T> {
    /// The normalized input.
    pub norm: NormTape<T>,
    /// Queries; empty for hidden neurons.
    pub query: Vec<T>,
    /// Keys and values; empty for hidden neurons.
    pub source: Vec<T>,
    /// Weights of the values for each token; empty for hidden neurons.
    pub probabilities: Vec<T>,
    /// Hidden neurons, rectified, or means of the values.
    pub result: Vec<T>,
}

impl<T: Number> BranchTape<T> {
    fn new(layout: &Branch, tokens: usize) -> Self {
        let zeros = |columns: usize| vec![T::ZERO; tokens * columns];
        let attention = |columns: usize| layout.source.map_or(Vec::new(), |_| zeros(columns));
        Self {
            norm: NormTape::new(tokens),
            query: attention(WIDTH),
            source: attention(2 * WIDTH),
            probabilities: attention(K * HEADS),
            result: zeros(layout.inner[0].columns),
        }
    }

    /// Adds the output of the branch to `x`.
    fn run(&mut self, layout: &Branch, parameters: &[T], embedded: &[T], x: &mut [T]) {
        let Self { norm, query, source, probabilities, result } = self;
        norm.run(layout.norm, parameters, x);
        let inner = of(parameters, layout.inner);
        if let Some(map) = layout.source {
            linear(&norm.normed, inner, query);
            let (tokens, shift) = attended(layout, &norm.normed, embedded);
            linear(tokens, of(parameters, map), source);
            attend([query, source], shift, probabilities, result);
        } else {
            linear(&norm.normed, inner, result);
            result.iter_mut().for_each(|x| *x = if *x > T::ZERO { *x } else { T::ZERO });
        }
        let [weights, bias] = of(parameters, layout.down);
        x.chunks_exact_mut(bias.len()).for_each(|row| add(row, bias));
        product(result, weights, bias.len(), x);
    }
}

/// Returns the tokens to which a branch attends, and the distance, in sequences, to those of the
/// other spectrum of the pair.
pub fn attended<'a, T>(layout: &Branch, own: &'a [T], embedded: &'a [T]) -> (&'a [T], usize) {
    match layout.kind {
        Kind::Other => (embedded, embedded.len() / (2 * K * WIDTH)),
        Kind::Own | Kind::Hidden => (own, 0),
    }
}

/// Results of `T_A` or `T_B`.
#[derive(Debug, Clone)]
pub struct StackTape<T> {
    /// Results of its branches.
    pub branches: Vec<BranchTape<T>>,
    /// The normalized output.
    pub norm: NormTape<T>,
}

impl<T: Number> StackTape<T> {
    fn new(layout: &Stack, tokens: usize) -> Self {
        let branches = layout.branches.iter().map(|branch| BranchTape::new(branch, tokens));
        Self { branches: branches.collect(), norm: NormTape::new(tokens) }
    }

    fn run(&mut self, layout: &Stack, parameters: &[T], embedded: &[T], mut x: Vec<T>) {
        for (branch, layout) in self.branches.iter_mut().zip(&layout.branches) {
            branch.run(layout, parameters, embedded, &mut x);
        }
        self.norm.run(layout.norm, parameters, &x);
    }
}

/// All results of [`forward`] for a number of pairs.
#[derive(Debug, Clone)]
pub struct Tape<T> {
    /// Offsets, `K` for each first spectrum, then `K` for each second one. The caller of
    /// [`forward`] sets them.
    pub offsets: Vec<T>,
    /// Tokens of the offsets.
    pub embedded: Vec<T>,
    /// `T_A`, for all spectra.
    pub first: StackTape<T>,
    /// `T_B`, for the unions.
    pub second: StackTape<T>,
    /// Predicted offsets, `K` for each union.
    pub output: Vec<T>,
}

impl<T: Number> Tape<T> {
    /// Creates the buffers for this number of pairs.
    pub fn new(layout: &Layout, pairs: usize) -> Self {
        Self {
            offsets: vec![T::ZERO; 2 * pairs * K],
            embedded: vec![T::ZERO; 2 * pairs * K * WIDTH],
            first: StackTape::new(&layout.first, 2 * pairs * K),
            second: StackTape::new(&layout.second, pairs * K),
            output: vec![T::ZERO; pairs * K],
        }
    }
}

/// Computes `tape.output` from `tape.offsets`. The outputs of `T_A` for both spectra of a pair are
/// added, so that their order does not matter, bit for bit.
///
/// # Panics
/// When `tape` or `parameters` have another layout.
pub fn forward<T: Number>(layout: &Layout, parameters: &[T], tape: &mut Tape<T>) {
    let positions = &parameters[layout.positions.range()];
    let multiples = &parameters[layout.multiples.range()];
    let tokens = tape.embedded.chunks_exact_mut(WIDTH).zip(&tape.offsets);
    for (i, (token, &offset)) in tokens.enumerate() {
        let (position, rest) = token.split_at_mut(POSITIONAL);
        position.copy_from_slice(&positions[i % K * POSITIONAL..][..POSITIONAL]);
        let factors = multiples.iter().copied().chain([T::ONE]);
        rest.iter_mut().zip(factors).for_each(|(x, factor)| *x = factor * offset);
    }
    let embedded = &tape.embedded;
    tape.first.run(&layout.first, parameters, embedded, embedded.clone());
    let (first, second) = tape.first.norm.normed.split_at(embedded.len() / 2);
    let mut union = first.to_vec();
    add(&mut union, second);
    tape.second.run(&layout.second, parameters, embedded, union);
    linear(&tape.second.norm.normed, of(parameters, layout.head), &mut tape.output);
}

fn of<T>(parameters: &[T], pair: [Parameter; 2]) -> [&[T]; 2] {
    pair.map(|parameter| &parameters[parameter.range()])
}

/// Computes `y := x weights + bias`, with a row for each row of x.
fn linear<T: Number>(x: &[T], [weights, bias]: [&[T]; 2], y: &mut [T]) {
    y.chunks_exact_mut(bias.len()).for_each(|row| row.copy_from_slice(bias));
    product(x, weights, bias.len(), y);
}

/// Computes `y += x weights`.
fn product<T: Number>(x: &[T], weights: &[T], columns: usize, y: &mut [T]) {
    let inner = weights.len() / columns;
    gemm((y.len() / columns, inner, columns), x, (inner, 1), weights, y);
}
