//! One call of the C interface with arguments that bytes choose, valid ones and others: the status
//! is an error whose message names the argument, and all memory is as before, or results are within
//! their bounds of plain loops, and nothing else has changed.

mod accumulators;
mod buffers;
pub mod choices;
mod complex;
mod entries;
mod float_env;
mod gram;
mod oracle;
mod ortho;
mod params;
mod products;
mod refusal;
mod rows;
mod spectra;
mod structs;

use choices::Choices;

/// Makes the call that these bytes choose.
///
/// # Panics
/// When it does not do what the header says.
pub fn call(bytes: &[u8]) {
    let choices = &mut Choices::new(bytes);
    match choices.below(16) {
        0 | 1 => products::call::<f64>(choices),
        2 | 3 => products::call::<f32>(choices),
        4 => products::mixed(choices),
        5 => complex::call::<f64>(choices),
        6 => complex::call::<f32>(choices),
        7 => rows::dense::<f64>(choices),
        8 => rows::dense::<f32>(choices),
        9 => rows::sparse::<f64>(choices),
        10 => rows::sparse::<f32>(choices),
        11 => accumulators::call(choices),
        12 => gram::call(choices),
        13 => ortho::call(choices),
        14 => spectra::call(choices),
        _ => structs::call(choices),
    }
}
