use catamaran::unions::network::{K, Number, Parameter, gemm, normalize};

use super::attention::attend;
use super::layout::{Branch, HEADS, Kind, Layout, POSITIONAL, Stack, WIDTH};
use crate::network::add;

/// What a normalisation computed.
#[derive(Debug, Clone)]
pub struct NormTape<T> {
    /// The input, normalised, before scale and shift.
    pub unit: Vec<T>,
    /// One over the deviations of the rows of the input.
    pub inverse: Vec<T>,
    /// The input, normalised, with scale and shift.
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

/// What a residual branch computed.
#[derive(Debug, Clone)]
pub struct BranchTape<T> {
    /// Its input.
    pub norm: NormTape<T>,
    /// Queries; nothing of hidden neurons.
    pub query: Vec<T>,
    /// Keys and values, likewise.
    pub source: Vec<T>,
    /// How much of each value each token takes, likewise.
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

    /// Adds to `x`.
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

/// The tokens that an attention is to, and how many sequences further those of the other spectrum
/// of the same pair are.
pub fn attended<'a, T>(layout: &Branch, own: &'a [T], embedded: &'a [T]) -> (&'a [T], usize) {
    match layout.kind {
        Kind::Other => (embedded, embedded.len() / (2 * K * WIDTH)),
        Kind::Own | Kind::Hidden => (own, 0),
    }
}

/// What `T_A` or `T_B` computed.
#[derive(Debug, Clone)]
pub struct StackTape<T> {
    /// Its branches.
    pub branches: Vec<BranchTape<T>>,
    /// Its output.
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

/// Everything that [`forward`] computes for a number of pairs.
#[derive(Debug, Clone)]
pub struct Tape<T> {
    /// Offsets, `K` for each first spectrum, then `K` for each second one. To be filled in before
    /// [`forward`].
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
    /// For this number of pairs.
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

/// From `tape.offsets` to `tape.output`. What `T_A` gives for both spectra of a pair is added:
/// their order does not matter, bit for bit.
///
/// # Panics
/// When `tape` or `parameters` are of another layout.
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

/// `y := x weights + bias`, a row for each row of x.
fn linear<T: Number>(x: &[T], [weights, bias]: [&[T]; 2], y: &mut [T]) {
    y.chunks_exact_mut(bias.len()).for_each(|row| row.copy_from_slice(bias));
    product(x, weights, bias.len(), y);
}

/// `y += x weights`.
fn product<T: Number>(x: &[T], weights: &[T], columns: usize, y: &mut [T]) {
    let inner = weights.len() / columns;
    gemm((y.len() / columns, inner, columns), x, (inner, 1), weights, y);
}
