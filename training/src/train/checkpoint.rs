use std::cmp::Ordering;
use std::path::Path;

use catamaran::io::{Array, Output, read_arrays, write_arrays};
use catamaran::{Error, Result};
use catamaran_geometry::unions::Scaling;
use catamaran_geometry::unions::network::Architecture;

use super::{Epoch, State, TrainOptions};
use crate::adam::Adam;

/// The version of the format; files of another version are refused.
const VERSION: usize = 1;

/// Writes the state and the options of a training to an .npz file.
///
/// # Errors
/// [`Error::Io`]; then no file is left behind.
pub fn write_state(output: Output, options: &TrainOptions, state: &State) -> Result<()> {
    let Architecture { width, hidden, first_layers, second_layers, modes } = options.sizes;
    let TrainOptions { batch, epochs, seed, .. } = *options;
    let whole = [width, hidden, first_layers, second_layers, modes, batch, epochs, seed as usize];
    let wide = |values: &[f32]| values.iter().map(|&x| f64::from(x)).collect::<Vec<f64>>();
    let curve = |of: fn(&Epoch) -> f64| state.history.iter().map(of).collect::<Vec<f64>>();
    write_arrays(
        output,
        &[
            ("version", Array::Indices(&[VERSION])),
            ("options", Array::Indices(&whole)),
            ("rates", Array::Vector(&[options.rate, options.decay])),
            ("parameters", Array::Vector(&wide(&state.parameters))),
            ("best", Array::Vector(&wide(&state.best))),
            ("adam_steps", Array::Indices(&[state.adam.steps])),
            ("adam_mean", Array::Vector(&wide(&state.adam.mean))),
            ("adam_square", Array::Vector(&wide(&state.adam.square))),
            ("training", Array::Vector(&curve(|epoch| epoch.training))),
            ("validation", Array::Vector(&curve(|epoch| epoch.validation))),
            ("feature_mean", Array::Vector(&wide(&state.scaling.feature_mean))),
            ("feature_deviation", Array::Vector(&wide(&state.scaling.feature_deviation))),
            ("output_mean", Array::Vector(&wide(&state.scaling.output_mean))),
            ("output_deviation", Array::Vector(&wide(&state.scaling.output_deviation))),
        ],
    )
}

/// Reads a file that [`write_state`] has written.
///
/// # Errors
/// [`Error::Io`] names the array that is missing or invalid, or says that the file is one of an
/// earlier or a later version of catamaran.
pub fn read_state(path: &Path) -> Result<(TrainOptions, State)> {
    let arrays = read_arrays(path)?;
    let broken = |what: &str| Error::file(path, format!("{what}: not part of a training state"));
    let version = match arrays.names().any(|name| name == "version") {
        true => arrays.indices("version")?.first().copied().unwrap_or_default(),
        // Of the first states, which have none.
        false if arrays.names().any(|name| name == "adam_steps") => 0,
        false => return Err(Error::file(path, "is not a training state")),
    };
    match version.cmp(&VERSION) {
        Ordering::Less => {
            return Err(Error::file(path, "was written by an earlier version of catamaran"));
        }
        Ordering::Greater => {
            return Err(Error::file(path, "was written by a later version of catamaran"));
        }
        Ordering::Equal => {}
    }
    let narrow = |name: &str| -> Result<Vec<f32>> {
        Ok(arrays.vector(name)?.iter().map(|&x| x as f32).collect())
    };
    let whole =
        <[usize; 8]>::try_from(arrays.indices("options")?).map_err(|_| broken("options"))?;
    let rates = <[f64; 2]>::try_from(arrays.vector("rates")?).map_err(|_| broken("rates"))?;
    let [width, hidden, first_layers, second_layers, modes, batch, epochs, seed] = whole;
    let sizes = Architecture { width, hidden, first_layers, second_layers, modes };
    let options =
        TrainOptions { sizes, batch, rate: rates[0], decay: rates[1], epochs, seed: seed as u64 };
    let steps = *arrays.indices("adam_steps")?.first().ok_or_else(|| broken("adam_steps"))?;
    let adam = Adam { steps, mean: narrow("adam_mean")?, square: narrow("adam_square")? };
    let curves = arrays.vector("training")?.into_iter().zip(arrays.vector("validation")?);
    let history = curves.map(|(training, validation)| Epoch { training, validation }).collect();
    let scaling = Scaling {
        feature_mean: narrow("feature_mean")?,
        feature_deviation: narrow("feature_deviation")?,
        output_mean: narrow("output_mean")?,
        output_deviation: narrow("output_deviation")?,
    };
    let (parameters, best) = (narrow("parameters")?, narrow("best")?);
    let state = State { parameters, adam, best, history, scaling };
    Ok((options, state))
}
