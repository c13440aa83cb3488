//! The learning curve.

use catamaran_training::train::Epoch;

use crate::picture::{Chart, Curve, Upwards};

/// Errors over epochs, on a logarithmic axis.
pub fn chart(history: &[Epoch]) -> Chart<'static> {
    let curve = |name, color, of: fn(&Epoch) -> f64| {
        let points = history.iter().enumerate().map(|(i, epoch)| (i as f64, of(epoch))).collect();
        Curve { name, color, width: 2.0, dashed: false, points }
    };
    Chart {
        across: "epochs",
        last: history.len().saturating_sub(1) as f64,
        upwards: "mean error of logarithms",
        scale: Upwards::Logarithmic,
        curves: vec![
            curve("training", "#1d4ed8", |epoch| epoch.training),
            curve("pairs to choose by", "#b45309", |epoch| epoch.validation),
        ],
    }
}
