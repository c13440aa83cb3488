//! The water, compared with numbers of 100 bits.

use catamaran::Par;
use catamaran_simulation::plant::{Bdf6, Start, WaterOptions, read};

use super::reference::Coefficients;
use super::{Part, Subject};
use crate::Result;

/// Returns the largest relative error of the water of any node at the half-time, at the usual
/// conductance, also of plant006 (8,961 nodes).
///
/// # Errors
/// The errors of the model, and of plant006 if its file exists and can't be read.
pub fn accuracy(subjects: &[Subject]) -> Result<Part> {
    let path = crate::input::data_folder().join("plants/plant006.txt");
    let large = match path.is_file() {
        true => Some(Subject::new("plant006".into(), read(&path)?)?),
        false => None,
    };
    let mut rows = Vec::new();
    for subject in subjects.iter().chain(&large) {
        let full = subject.model.full();
        let seconds = subject.half_time();
        let coefficients = Coefficients::new(&subject.plant, &WaterOptions::default());
        let exact = coefficients.water_by_contour(&full, seconds);
        let error = |water: &[f64]| {
            let errors = water.iter().zip(&exact).map(|(x, y)| (x / y - 1.0).abs());
            errors.fold(0.0, f64::max)
        };
        let rates = coefficients.fastest_rate() * seconds;
        let mut row = vec![rates, error(&subject.model.water_after(&full, seconds, Par::all())?)];
        for (count, start) in
            [(16, Start::Radau), (16, Start::Exact), (64, Start::Radau), (256, Start::Radau)]
        {
            let step = seconds / f64::from(count);
            let mut bdf = Bdf6::new(&subject.model, &full, step, start, Par::all())?;
            (0..count).for_each(|_| bdf.step());
            row.push(error(&bdf.water()));
        }
        rows.push((format!("{} ({} nodes)", subject.name, subject.plant.len()), row));
    }
    let columns =
        ["norm of S t, at most", "water_after", "16 steps of BDF6", "16, exact start", "64", "256"];
    Ok(Part {
        figure: "accuracy",
        title: "largest relative error of the water of a node at the half-time, chi = 1e-9, against a contour integral in 100 \
                bits"
            .into(),
        columns: columns.map(String::from).into(),
        rows,
        plots: vec![],
    })
}
