use catamaran::base::Rng;
use catamaran_geometry::unions::network::{
    Architecture, K, LayerLayout, LayerTape, Number, Parameter, ParameterLayout, Tape, gemm,
    sigmoid, sum,
};

/// Draws initial parameters: weights are uniform with the variance of Glorot and Bengio (2010), the
/// last layer of each residual branch is smaller the more branches there are, and biases and the
/// head are zero.
pub fn initial_parameters(sizes: &Architecture, seed: u64) -> Vec<f32> {
    let depth = sizes.first_layers + sizes.second_layers;
    random_parameters(&sizes.layout().named, depth, seed)
}

/// Draws the parameters of consecutive matrices with these names, of a network with `depth` layers,
/// as [`initial_parameters`] does.
pub(crate) fn random_parameters(
    named: &[(String, Parameter)],
    depth: usize,
    seed: u64,
) -> Vec<f32> {
    let mut parameters = vec![0.0; named.last().map_or(0, |(_, last)| last.range().end)];
    let mut rng = Rng::new(seed);
    let depth = depth.max(1) as f64;
    for (name, parameter) in named {
        let part = &mut parameters[parameter.range()];
        let limit = (6.0 / (parameter.rows + parameter.columns) as f64).sqrt();
        let mut fill = |limit: f64| {
            part.iter_mut().for_each(|x| *x = (limit * (2.0 * rng.uniform() - 1.0)) as f32);
        };
        match name.rsplit_once('.') {
            Some((_, "bias")) => {}
            Some((layer, _)) if layer.ends_with("norm") => part.fill(1.0),
            Some((layer, _)) if layer.ends_with("down") => fill(limit / depth.sqrt()),
            Some(("head" | "region" | "doubt" | "part.region", _)) => fill(0.1 * limit),
            _ => fill(limit),
        }
    }
    parameters
}

/// The outputs of a forward pass, or a gradient with respect to them, as in [`Tape`].
#[derive(Debug, Clone)]
pub struct Outputs<T> {
    /// The eigenvalues.
    pub output: Vec<T>,
    /// The region of the union.
    pub region: Vec<T>,
    /// The out-of-distribution logit.
    pub ood_logit: Vec<T>,
    /// The regions of the parts.
    pub part_region: Vec<T>,
}

impl<T: Number> Outputs<T> {
    /// Creates zeros for this number of unions, each of `parts` parts.
    pub fn new(sizes: &Architecture, unions: usize, parts: usize) -> Self {
        Self {
            output: vec![T::ZERO; unions * K],
            region: vec![T::ZERO; unions * sizes.modes],
            ood_logit: vec![T::ZERO; unions],
            part_region: vec![T::ZERO; unions * parts * sizes.modes],
        }
    }
}

/// Buffers of back-propagation.
#[derive(Debug, Clone)]
pub struct Backward<T> {
    /// Gradient with respect to the parameters, to which [`Backward::run`] adds.
    pub gradient: Vec<T>,
    transposed: Vec<T>,
}

impl<T: Number> Backward<T> {
    /// Creates the buffers of networks of these sizes.
    pub fn new(sizes: &Architecture) -> Self {
        let largest = sizes.width * (2 * sizes.hidden).max(K).max(sizes.modes);
        Self::with_lengths(sizes.layout().len, largest)
    }

    /// Creates the buffers for `parameters` parameters; the largest matrix of weights has `largest`
    /// elements.
    pub(crate) fn with_lengths(parameters: usize, largest: usize) -> Self {
        Self { gradient: vec![T::ZERO; parameters], transposed: vec![T::ZERO; largest] }
    }

    /// Adds to the gradient with respect to the parameters, given that with respect to the outputs
    /// of the forward pass that filled `tape`.
    pub fn run(
        &mut self,
        layout: &ParameterLayout,
        parameters: &[T],
        tape: &Tape<T>,
        by: &Outputs<T>,
    ) {
        let mut normed = vec![T::ZERO; tape.normed.len()];
        self.linear(parameters, layout.head, &tape.normed, &by.output, Some(&mut normed));
        self.linear(parameters, layout.region, &tape.normed, &by.region, Some(&mut normed));
        self.linear(parameters, layout.ood_logit, &tape.normed, &by.ood_logit, Some(&mut normed));
        let mut x = vec![T::ZERO; normed.len()];
        self.norm(parameters, layout.norm, [&tape.unit, &tape.inverse], &normed, &mut x);
        for (layer, layout) in tape.second.iter().zip(&layout.second).rev() {
            self.layer(layout, parameters, layer, &mut x);
        }
        // The gradient of the sum over the parts is that of each part.
        let union = x.len();
        while x.len() < tape.part_unit.len() {
            x.extend_from_within(..union);
        }
        let (normed, parts) = (&tape.part_normed, &by.part_region);
        let mut own = vec![T::ZERO; normed.len()];
        self.linear(parameters, layout.part_region, normed, parts, Some(&mut own));
        let [unit, inverse] = [&tape.part_unit, &tape.part_inverse];
        self.norm(parameters, layout.part_norm, [unit, inverse], &own, &mut x);
        for (layer, layout) in tape.first.iter().zip(&layout.first).rev() {
            self.layer(layout, parameters, layer, &mut x);
        }
        self.linear(parameters, layout.embedding, &tape.inputs, &x, None);
    }

    /// Replaces the gradient `x` with respect to the output of a layer by that with respect to its
    /// input.
    fn layer(&mut self, layout: &LayerLayout, parameters: &[T], tape: &LayerTape<T>, x: &mut [T]) {
        let mut hidden = vec![T::ZERO; tape.hidden.len()];
        self.linear(parameters, layout.down, &tape.hidden, x, Some(&mut hidden));
        let mut up = vec![T::ZERO; tape.up.len()];
        let count = layout.down[0].rows;
        let rows = up.chunks_exact_mut(2 * count).zip(tape.up.chunks_exact(2 * count));
        for (hidden, (gradient, up)) in hidden.chunks_exact(count).zip(rows) {
            for (i, &hidden) in hidden.iter().enumerate() {
                let (value, gate) = (up[i], up[count + i]);
                let open = sigmoid(gate);
                gradient[i] = hidden * gate * open;
                gradient[count + i] = hidden * value * open * (T::ONE + gate * (T::ONE - open));
            }
        }
        let mut normed = vec![T::ZERO; tape.normed.len()];
        self.linear(parameters, layout.up, &tape.normed, &up, Some(&mut normed));
        self.norm(parameters, layout.norm, [&tape.unit, &tape.inverse], &normed, x);
    }

    /// Propagates through `y = x weights + bias`; adds to `dx`.
    pub(crate) fn linear(
        &mut self,
        parameters: &[T],
        [weights, bias]: [Parameter; 2],
        x: &[T],
        dy: &[T],
        dx: Option<&mut [T]>,
    ) {
        let (inner, columns) = (weights.rows, weights.columns);
        let rows = dy.len() / columns;
        for row in dy.chunks_exact(columns) {
            add(&mut self.gradient[bias.range()], row);
        }
        let gradient = &mut self.gradient[weights.range()];
        gemm((inner, rows, columns), x, (1, inner), dy, gradient);
        let Some(dx) = dx else { return };
        let weights = &parameters[weights.range()];
        let transposed = &mut self.transposed[..inner * columns];
        transpose(weights, columns, transposed);
        gemm((rows, columns, inner), dy, (columns, 1), transposed, dx);
    }

    /// Propagates through layer normalization; adds to `dx`.
    pub(crate) fn norm(
        &mut self,
        parameters: &[T],
        [scale, shift]: [Parameter; 2],
        [unit, inverse]: [&[T]; 2],
        dy: &[T],
        dx: &mut [T],
    ) {
        let width = scale.columns;
        let factors = &parameters[scale.range()];
        let count = T::ONE / T::from_f64(width as f64);
        for (row, dy) in dy.chunks_exact(width).enumerate() {
            let unit = &unit[row * width..(row + 1) * width];
            let dx = &mut dx[row * width..(row + 1) * width];
            add(&mut self.gradient[shift.range()], dy);
            let gradient = &mut self.gradient[scale.range()];
            for j in 0..width {
                gradient[j] += dy[j] * unit[j];
            }
            let mean = sum(width, |j| dy[j] * factors[j]) * count;
            let along = sum(width, |j| dy[j] * factors[j] * unit[j]) * count;
            for j in 0..width {
                dx[j] += inverse[row] * (dy[j] * factors[j] - mean - unit[j] * along);
            }
        }
    }
}

/// Transposes a matrix, square by square.
fn transpose<T: Number>(matrix: &[T], columns: usize, transposed: &mut [T]) {
    const SIDE: usize = 16;
    let rows = matrix.len() / columns;
    for first in (0..rows).step_by(SIDE) {
        for column in (0..columns).step_by(SIDE) {
            for j in column..columns.min(column + SIDE) {
                for i in first..rows.min(first + SIDE) {
                    transposed[j * rows + i] = matrix[i * columns + j];
                }
            }
        }
    }
}

/// Adds `x` to `sum`.
pub(crate) fn add<T: Number>(sum: &mut [T], x: &[T]) {
    for (sum, &x) in sum.iter_mut().zip(x) {
        *sum += x;
    }
}

#[cfg(test)]
mod tests {
    use catamaran_geometry::unions::network::{FEATURES, forward};

    use super::*;

    /// Returns a weighted sum of the outputs of a network for random features, and its gradient.
    fn value_and_gradient(
        sizes: &Architecture,
        parts: usize,
        parameters: &[f64],
    ) -> (f64, Vec<f64>) {
        const UNIONS: usize = 2;
        let layout = sizes.layout();
        let mut tape = Tape::new(sizes, UNIONS, parts);
        let mut rng = Rng::new(4);
        tape.features.iter_mut().for_each(|x| *x = rng.normal());
        let mut weights = Outputs::new(sizes, UNIONS, parts);
        let Outputs { output, region, ood_logit, part_region } = &mut weights;
        for x in [output, region, ood_logit, part_region].into_iter().flatten() {
            *x = rng.normal();
        }
        forward(sizes, &layout, parameters, &mut tape);
        let found = [&tape.output, &tape.region, &tape.ood_logit, &tape.part_region];
        let Outputs { output, region, ood_logit, part_region } = &weights;
        let by = [output, region, ood_logit, part_region];
        let value = found.into_iter().flatten().zip(by.into_iter().flatten());
        let value = value.map(|(a, b)| a * b).sum();
        let mut backward = Backward::new(sizes);
        backward.run(&layout, parameters, &tape, &weights);
        (value, backward.gradient)
    }

    #[test]
    fn gradients_are_those_of_finite_differences() {
        for (first_layers, second_layers, parts) in [(1, 0, 2), (2, 1, 3), (0, 1, 1), (0, 0, 2)] {
            let sizes =
                Architecture { width: 8, hidden: 12, first_layers, second_layers, modes: 7 };
            let mut rng = Rng::new(2);
            let mut parameters: Vec<f64> = initial_parameters(&sizes, 1)
                .iter()
                .map(|&x| f64::from(x) + 0.2 * rng.normal())
                .collect();
            let (_, gradient) = value_and_gradient(&sizes, parts, &parameters);
            for (name, parameter) in sizes.layout().named {
                for _ in 0..4 {
                    let at =
                        parameter.start + (rng.uniform() * parameter.range().len() as f64) as usize;
                    let before = parameters[at];
                    let step = 1e-6;
                    let mut at_step = |sign: f64| {
                        parameters[at] = before + sign * step;
                        value_and_gradient(&sizes, parts, &parameters).0
                    };
                    let slope = (at_step(1.0) - at_step(-1.0)) / (2.0 * step);
                    parameters[at] = before;
                    let error = (slope - gradient[at]).abs();
                    assert!(
                        error < 1e-6 * (1.0 + slope.abs()),
                        "{name} {at}: {slope} is not {}",
                        gradient[at]
                    );
                }
            }
        }
    }

    #[test]
    fn gradients_in_single_precision_are_close_to_those_in_double() {
        let sizes = Architecture { first_layers: 1, second_layers: 1, ..Architecture::default() };
        let layout = sizes.layout();
        let parameters = initial_parameters(&sizes, 3);
        let mut rng = Rng::new(8);
        let features: Vec<f32> = (0..2 * K * FEATURES).map(|_| rng.normal() as f32).collect();
        let mut single = Tape::<f32>::new(&sizes, 1, 2);
        single.features.copy_from_slice(&features);
        forward(&sizes, &layout, &parameters, &mut single);
        let mut backward = Backward::new(&sizes);
        let ones = Outputs { output: vec![1.0; K], ..Outputs::new(&sizes, 1, 2) };
        backward.run(&layout, &parameters, &single, &ones);

        let exact: Vec<f64> = parameters.iter().map(|&x| f64::from(x)).collect();
        let mut double = Tape::<f64>::new(&sizes, 1, 2);
        double.features = features.iter().map(|&x| f64::from(x)).collect();
        forward(&sizes, &layout, &exact, &mut double);
        let mut reference = Backward::new(&sizes);
        let ones = Outputs { output: vec![1.0; K], ..Outputs::new(&sizes, 1, 2) };
        reference.run(&layout, &exact, &double, &ones);
        let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
        let difference = norm(
            &mut backward.gradient.iter().zip(&reference.gradient).map(|(&a, b)| f64::from(a) - b),
        );
        assert!(difference < 1e-5 * norm(&mut reference.gradient.iter().copied()), "{difference}");
    }
}
