//! Figure 4.6 as an experiment: two plants on a scale, and one loss rate for both.

use catamaran::base::Rng;
use catamaran_simulation::plant::{
    Conductivity, FitOptions, Measurements, WaterModel, WaterOptions, fit, grams_per_hour,
};

use super::{Part, Subject};
use crate::Result;
use crate::curves::Plot;

/// The loss of the weighed plants, in g / (h m^2), and the scale of their conductance.
const LOSS: f64 = 75.0;
const SCALE: f64 = 4e-10;

/// Resolution of the scale of the thesis, in kg: a centigram.
const RESOLUTION: f64 = 1e-5;

/// Computes figure 4.6: constants fitted to the weights of two plants. The measurements of the
/// thesis are not published, so these weights are those of the model, rounded to a centigram.
///
/// # Errors
/// The errors of the model and of the fit.
pub fn weights(subjects: &[Subject]) -> Result<Part> {
    let mut rng = Rng::new(46);
    let mut rows = Vec::new();
    let mut series = Vec::new();
    for subject in subjects.iter().take(2) {
        let seconds: Vec<f64> = (0..=32).map(|i| 3600.0 * 1.5 * f64::from(i)).collect();
        let options = WaterOptions::new()
            .loss(grams_per_hour(LOSS))
            .conductivity(Conductivity::Pipe { scale: SCALE });
        let model = WaterModel::new(&subject.plant, &options)?;
        let mut weights = Vec::with_capacity(seconds.len());
        for &time in &seconds {
            let water = model.water_after(&model.full(), time, catamaran::Par::all())?;
            weights.push(water.iter().sum::<f64>() + RESOLUTION * rng.normal());
        }
        let measured = Measurements { seconds, weights, ..Measurements::default() };
        let found = fit(&subject.plant, &measured, &FitOptions::new())?;
        let unit = grams_per_hour(1.0);
        let name = subject.name.clone();
        rows.push((
            name.clone(),
            vec![
                found.loss.value / unit,
                found.loss.error / unit,
                found.scale.value,
                found.scale.error,
                1e3 * found.weight_deviation,
            ],
        ));
        let hours = || measured.seconds.iter().map(|s| s / 3600.0);
        let grams = |weights: &[f64]| hours().zip(weights.iter().map(|w| 1e3 * w)).collect();
        series.push((format!("{name}, weighed"), grams(&measured.weights)));
        series.push((format!("{name}, fitted"), grams(&found.weights)));
    }
    let columns = ["delta, g / (h m^2)", "+-", "chi", "+- (chi)", "deviation of a weight, g"];
    Ok(Part {
        figure: "figure 4.6",
        title: format!(
            "delta and chi fitted to the weights of two plants every 1.5 hours; synthetic, off by a centigram, from delta = \
             {LOSS}, chi = {SCALE:e} (the thesis' are not published)"
        ),
        columns: columns.map(String::from).into(),
        rows,
        plots: vec![Plot {
            title: "Figure 4.6: weights in g, and the model fitted to them".into(),
            across: "h".into(),
            logarithmic: false,
            scattered: false,
            series,
        }],
    })
}
