use catamaran_geometry::unions::network::{K, Number, Parameter};

use super::attention::attend_back;
use super::forward::{BranchTape, NormTape, StackTape, Tape, attended};
use super::layout::{Branch, Kind, LARGEST, Layout, MULTIPLES, POSITIONAL, Stack, WIDTH};
use crate::network::{Backward, add};

/// Buffers of back-propagation.
pub struct Gradient<T>(Backward<T>);

impl<T: Number> Gradient<T> {
    /// Creates the buffers of networks with this layout.
    pub fn new(layout: &Layout) -> Self {
        Self(Backward::with_lengths(layout.len, LARGEST))
    }

    /// Returns the gradient with respect to the parameters, to which [`Gradient::run`] adds.
    pub fn values(&mut self) -> &mut Vec<T> {
        &mut self.0.gradient
    }

    /// Adds to the gradient, given that with respect to the output of the forward pass that filled
    /// `tape`.
    pub fn run(&mut self, layout: &Layout, parameters: &[T], tape: &Tape<T>, by_output: &[T]) {
        let (first, second) = (&tape.first, &tape.second);
        let mut union = vec![T::ZERO; by_output.len() * WIDTH];
        let normed = &second.norm.normed;
        self.0.linear(parameters, layout.head, normed, by_output, Some(&mut union));
        let mut other = vec![T::ZERO; tape.embedded.len()];
        let embedded = (&tape.embedded[..], &mut other[..]);
        let union = self.stack(&layout.second, parameters, second, embedded, &union);
        // The gradient of the sum over both spectra is that of each.
        let embedded = (&tape.embedded[..], &mut other[..]);
        let own = self.stack(&layout.first, parameters, first, embedded, &union.repeat(2));
        add(&mut other, &own);
        for (i, (token, &offset)) in other.chunks_exact(WIDTH).zip(&tape.offsets).enumerate() {
            let (position, rest) = token.split_at(POSITIONAL);
            let start = layout.positions.start + i % K * POSITIONAL;
            add(&mut self.0.gradient[start..start + POSITIONAL], position);
            let multiples = &mut self.0.gradient[layout.multiples.range()];
            for (sum, &by) in multiples.iter_mut().zip(&rest[..MULTIPLES]) {
                *sum += offset * by;
            }
        }
    }

    /// Computes the gradient with respect to the input of `T_A` or `T_B` from that with respect to
    /// its output. Adds the gradient with respect to the embedded tokens, as those of the other
    /// spectrum, to `by_embedded`.
    fn stack(
        &mut self,
        layout: &Stack,
        parameters: &[T],
        tape: &StackTape<T>,
        (embedded, by_embedded): (&[T], &mut [T]),
        by_output: &[T],
    ) -> Vec<T> {
        let mut x = vec![T::ZERO; by_output.len()];
        self.norm(layout.norm, parameters, &tape.norm, by_output, &mut x);
        for (tape, layout) in tape.branches.iter().zip(&layout.branches).rev() {
            self.branch(layout, parameters, tape, (embedded, by_embedded), &mut x);
        }
        x
    }

    /// Replaces the gradient `x` with respect to the output of a residual branch by that with
    /// respect to its input.
    fn branch(
        &mut self,
        layout: &Branch,
        parameters: &[T],
        tape: &BranchTape<T>,
        (embedded, by_embedded): (&[T], &mut [T]),
        x: &mut [T],
    ) {
        let own = &tape.norm.normed;
        let mut normed = vec![T::ZERO; own.len()];
        let mut result = vec![T::ZERO; tape.result.len()];
        self.0.linear(parameters, layout.down, &tape.result, x, Some(&mut result));
        if let Some(map) = layout.source {
            let (tokens, shift) = attended(layout, own, embedded);
            let mut query = vec![T::ZERO; tape.query.len()];
            let mut source = vec![T::ZERO; tape.source.len()];
            let kept = [&tape.query[..], &tape.source, &tape.probabilities];
            attend_back(kept, shift, &result, &mut query, &mut source);
            let by_tokens = if layout.kind == Kind::Other { by_embedded } else { &mut normed };
            self.0.linear(parameters, map, tokens, &source, Some(by_tokens));
            result = query;
        } else {
            for (by, &value) in result.iter_mut().zip(&tape.result) {
                *by = if value > T::ZERO { *by } else { T::ZERO };
            }
        }
        self.0.linear(parameters, layout.inner, own, &result, Some(&mut normed));
        self.norm(layout.norm, parameters, &tape.norm, &normed, x);
    }

    /// Propagates through a normalization; adds to `x`.
    fn norm(
        &mut self,
        layout: [Parameter; 2],
        parameters: &[T],
        tape: &NormTape<T>,
        by_normed: &[T],
        x: &mut [T],
    ) {
        self.0.norm(parameters, layout, [&tape.unit, &tape.inverse], by_normed, x);
    }
}
