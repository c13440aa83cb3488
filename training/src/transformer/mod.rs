//! The network of the thesis (section 2.4), for comparison: a [`Predictor`] that is trained on the
//! same pairs as the network of [`catamaran_geometry::unions`], and is not shipped.
//!
//! Each eigenvalue is a token of 32 numbers: 16 learned ones for its position, 15 learned multiples
//! of its offset from the previous eigenvalue, and the offset. `T_A` (8 heads, 6 layers, 64 hidden
//! neurons) turns the tokens of each spectrum into ones that know the other spectrum; the two
//! results are added; `T_B` (8 heads, 3 layers, 32 hidden neurons) and a linear map turn the sum
//! into the offsets of the union. The loss is the mean squared error of their cumulative sums. The
//! optimizer is Adam with rate 2e-4, weight decay 1e-5, cosine annealing with restarts after 10,
//! 30, 70, ... epochs, and gradients of norm at most 10.
//!
//! The thesis leaves these points open:
//!
//! - "`T_A(x1|x2)`" is a decoder as in Vaswani et al. (2017): each layer attends to the tokens of
//!   the same spectrum, then to the embedded tokens of the other one; the hidden neurons follow.
//! - Tokens are normalized before each layer, not after (Xiong et al. 2020), which is more stable,
//!   and after the last layer of `T_A` and `T_B`. There is no dropout, and hidden neurons are
//!   rectified.
//! - A step has 128 pairs.
//! - Predicted offsets are not restricted in training. In a prediction, negative offsets are
//!   replaced by zero, and the first one is at least 0.001, so that the result is a spectrum; it
//!   need not be below the bound.
//!
//! Differences from the thesis:
//!
//! - Both spectra and the union are divided by a 20th of the smaller one of the two 20th
//!   eigenvalues, so that offsets are about 1 and the result does not depend on the unit of length.
//! - Areas of parts are not disturbed, and the parameters with the least loss on the pairs of the
//!   validation are kept.

mod attention;
mod backward;
mod forward;
mod layout;
mod train;

use std::ops::ControlFlow;
use std::path::Path;

use catamaran::io::{Array, Output, read_arrays, write_arrays};
use catamaran::{Error, Result};
use catamaran_geometry::unions::network::K;

pub use train::{Losses, TransformerOptions};

use crate::dataset::Spectrum;
use crate::evaluate::Predictor;
use crate::train::{LEAST_SHARE, Pair};
use forward::{Tape, forward};
use layout::{LAYERS, Layout};

/// The network of the thesis, trained.
#[derive(Debug, Clone)]
pub struct Transformer {
    layout: Layout,
    parameters: Vec<f32>,
}

/// Two spectra in units of the network.
struct Input {
    /// Divisor of the eigenvalues.
    scale: f64,
    /// Differences of the eigenvalues of both spectra.
    offsets: [[f32; K]; 2],
}

impl Input {
    fn new(first: &Spectrum, second: &Spectrum) -> Result<Self> {
        let scale = first[K - 1].min(second[K - 1]) / K as f64;
        if !(scale > 0.0 && first.iter().chain(second).all(|x| x.is_finite())) {
            let why = "must be finite, with positive eigenvalues".into();
            return Err(Error::Argument { what: "spectrum", why });
        }
        let offsets = [first, second].map(|values| {
            std::array::from_fn(|i| {
                let before = if i == 0 { 0.0 } else { values[i - 1] };
                ((values[i] - before) / scale) as f32
            })
        });
        Ok(Self { scale, offsets })
    }
}

impl Transformer {
    /// Trains on pairs, and keeps the parameters with the least loss on the pairs of `validation`.
    /// After each epoch, numbered from 0, `watch` receives the losses, and may end the training.
    ///
    /// # Errors
    /// [`Error::Argument`] when there are no pairs; when a spectrum is invalid.
    pub fn train(
        training: &[Pair],
        validation: &[Pair],
        options: &TransformerOptions,
        watch: impl FnMut(usize, Losses) -> ControlFlow<()>,
    ) -> Result<Self> {
        train::train(Layout::new(LAYERS), [training, validation], options, watch)
    }

    /// Writes the parameters to an .npz file.
    ///
    /// # Errors
    /// [`Error::Io`]; then no file is left behind.
    pub fn write(&self, output: Output) -> Result<()> {
        let wide: Vec<f64> = self.parameters.iter().map(|&x| f64::from(x)).collect();
        write_arrays(output, &[("transformer", Array::Vector(&wide))])
    }

    /// Reads a file that [`Transformer::write`] has written.
    ///
    /// # Errors
    /// [`Error::Io`] when the array does not exist, or belongs to another network.
    pub fn read(path: &Path) -> Result<Self> {
        let layout = Layout::new(LAYERS);
        let wide = read_arrays(path)?.vector("transformer")?;
        let parameters: Vec<f32> = wide.iter().map(|&x| x as f32).collect();
        if parameters.len() != layout.len || parameters.iter().any(|x| !x.is_finite()) {
            let why = format!("`transformer` must be {} finite numbers", layout.len);
            return Err(Error::file(path, why));
        }
        Ok(Self { layout, parameters })
    }
}

impl Predictor for Transformer {
    fn name(&self) -> &str {
        "thesis transformer"
    }

    fn predict(&self, first: &Spectrum, second: &Spectrum) -> Result<Spectrum> {
        let input = Input::new(first, second)?;
        let mut tape = Tape::new(&self.layout, 1);
        tape.offsets.copy_from_slice(input.offsets.as_flattened());
        forward(&self.layout, &self.parameters, &mut tape);
        let mut value = 0.0;
        Ok(std::array::from_fn(|i| {
            let least = if i == 0 { LEAST_SHARE } else { 0.0 };
            value += f64::from(tape.output[i]).max(least);
            value * input.scale
        }))
    }
}

#[cfg(test)]
mod tests;
