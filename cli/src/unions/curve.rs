//! The learning curve.

use catamaran_charts::{Axis, Chart, Series};
use catamaran_training::train::Epoch;

/// Draws errors over epochs, on a logarithmic axis.
pub fn chart(history: &[Epoch]) -> Chart {
    let curve = |name, color, of: fn(&Epoch) -> f64| {
        let points = history.iter().enumerate().map(|(i, epoch)| (i as f64, of(epoch))).collect();
        Series::curve(name, color, points)
    };
    Chart::new(
        Axis::whole("epochs").range(0.0, history.len().saturating_sub(1) as f64),
        Axis::log10("mean error of logarithms"),
        vec![
            curve("training", [0x1d, 0x4e, 0xd8], |epoch| epoch.training),
            curve("validation", [0xb4, 0x53, 0x09], |epoch| epoch.validation),
        ],
    )
}
