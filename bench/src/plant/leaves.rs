//! Figure 4.6 by real leaves: kohlrabi that dries on a scale.

use catamaran_simulation::plant::{DryingLeaf, LeafOptions, LeafTable, fit_leaves, read_leaves};

use super::Part;
use super::pvldcurve::closure;
use crate::Result;
use crate::curves::Plot;

/// The leaves from this number on are not fitted.
const FIRST_UNSEEN: usize = 9;

/// The first weights of an unseen leaf, from which it is predicted, too.
const FIRST_WEIGHTS: usize = 5;

/// The bars of fitted and of unseen leaves, in grams.
const BARS: [f64; 2] = [0.04, 0.08];

/// Computes figure 4.6 for the leaves of CATAMARAN_DATA, leaf by leaf and in sum; returns `None` if
/// they are not there.
///
/// # Errors
/// The errors of the tables and of the fit.
pub fn leaves() -> Result<Option<Vec<Part>>> {
    let folder = crate::input::data_folder().join("plants/leaves");
    let paths = ["leaf_drying_data.csv", "weather_data.csv", "pressure_volume_data.csv"]
        .map(|name| folder.join(name));
    if !paths.iter().all(|path| path.is_file()) {
        return Ok(None);
    }
    let mut texts = Vec::new();
    for path in &paths {
        texts.push(std::fs::read_to_string(path)?);
    }
    let [drying, air, curves] = [0, 1, 2].map(|i| LeafTable { path: &paths[i], text: &texts[i] });
    let groups = read_leaves(drying, air, Some(curves))?;
    let (mut rows, mut sums, mut plots) = (Vec::new(), Vec::new(), Vec::new());
    for group in &groups {
        let options = LeafOptions::new().prior(group.prior());
        let is_unseen =
            |leaf: &DryingLeaf| leaf.name.parse().is_ok_and(|name: usize| name >= FIRST_UNSEEN);
        let seen: Vec<DryingLeaf> =
            group.leaves.iter().filter(|leaf| !is_unseen(leaf)).cloned().collect();
        let fit = fit_leaves(&seen, &options)?;
        // The largest deviations: of fitted leaves; of unseen ones with constants of their own from
        // all weights, from the first, and from none.
        let mut largest = [0.0_f64; 4];
        let mut series = Vec::new();
        let mut fitted = fit.leaves.iter();
        for (leaf, seconds) in group.leaves.iter().zip(&group.seconds) {
            let (found, early) = match (is_unseen(leaf), fitted.as_slice().first()) {
                (false, Some(found)) => {
                    fitted.next();
                    (found.clone(), [f64::NAN; 2])
                }
                _ => {
                    let rms = |used| fit.unseen(leaf, used, &options).map(|found| 1e3 * found.rms);
                    let found = fit.unseen(leaf, leaf.weights.len(), &options)?;
                    (found, [rms(0)?, rms(FIRST_WEIGHTS)?])
                }
            };
            let of_package = |weights: &[f64]| {
                let leaf = DryingLeaf { weights: weights.to_vec(), ..leaf.clone() };
                closure(&leaf, seconds).map_or([f64::NAN; 2], |p| [p.relative, p.minimum])
            };
            let [measured, modelled] = [&leaf.weights, &found.weights].map(|w| of_package(w));
            let own = if early[0].is_nan() {
                [1e3 * found.rms, 0.0, 0.0, 0.0]
            } else {
                [0.0, 1e3 * found.rms, early[1], early[0]]
            };
            for (largest, own) in largest.iter_mut().zip(own) {
                *largest = largest.max(own);
            }
            let part = if early[0].is_nan() { "fitted" } else { "unseen" };
            rows.push((
                format!("leaf {} of {}, {part}", leaf.name, group.name),
                vec![
                    1e3 * fit.cuticular.value,
                    1e3 * fit.cuticular.error,
                    fit.steepness.value,
                    fit.steepness.error,
                    1e3 * found.open.value,
                    1e3 * found.open.error,
                    found.closing.value,
                    found.closing.error,
                    1e3 * found.rms,
                    early[0],
                    early[1],
                    measured[0],
                    modelled[0],
                    measured[1],
                    modelled[1],
                ],
            ));
            let grams = |weights: &[f64]| -> Vec<(f64, f64)> {
                let hours = seconds.iter().map(|s| s / 3600.0);
                hours.zip(weights.iter().map(|w| 1e3 * (leaf.weights[0] - w))).collect()
            };
            series.push((format!("{}, weighed", leaf.name), grams(&leaf.weights)));
            series.push((format!("{}, {part}", leaf.name), grams(&found.weights)));
        }
        let [lost, scatter] =
            group.prior().map_or([f64::NAN; 2], |prior| [prior.value, prior.error]);
        let [fitted, unseen] = [largest[0] <= BARS[0], largest[1] <= BARS[1]];
        let within = [fitted, unseen].map(|holds| f64::from(u8::from(holds)));
        let errors = fit.rms / options.instrument;
        let mut values = largest.to_vec();
        values.extend(within);
        values.extend([errors, lost, scatter]);
        sums.push((format!("treatment {}", group.name), values));
        plots.push(Plot {
            title: format!(
                "Figure 4.6 by real leaves, treatment {}: water lost in g, and the model",
                group.name
            ),
            across: "h".into(),
            logarithmic: false,
            scattered: false,
            series,
        });
    }
    let columns = [
        "cuticle, mmol / (m^2 s)",
        "+- (cuticle)",
        "steepness",
        "+- (steepness)",
        "open, mmol / (m^2 s)",
        "+- (open)",
        "half closed at",
        "+- (half closed)",
        "rms, g",
        "rms without its weights, g",
        "rms from its first five weights, g",
        "closed at (pvldcurve)",
        "closed at (pvldcurve, by the model's weights)",
        "minimum conductance (pvldcurve), mmol / (m^2 s)",
        "minimum conductance (pvldcurve, by the model's weights), mmol / (m^2 s)",
    ];
    let table = Part {
        figure: "figure 4.6 (leaves)",
        title: "twelve leaves of kohlrabi (R package pvldcurve): cuticle and steepness fitted for \
                each treatment to leaves 1 to 8, open conductance and closing point for each leaf; \
                conductances of one side"
            .into(),
        columns: columns.map(String::from).into(),
        rows,
        plots,
    };
    let columns = [
        "fitted: largest rms, g",
        "unseen, own constants from all weights: largest rms, g",
        "unseen, from the first five weights: largest rms, g",
        "unseen, without weights: largest rms, g",
        "fitted within 0.04 g",
        "unseen within 0.08 g",
        "rms over the error of the scale (above 3: a warning)",
        "turgor lost at",
        "+- (turgor)",
    ];
    let sums = Part {
        figure: "figure 4.6 (treatments)",
        title: "deviations of the leaves of a treatment, which share cuticle and steepness; of \
                unseen leaves these are those of the fitted ones"
            .into(),
        columns: columns.map(String::from).into(),
        rows: sums,
        plots: vec![],
    };
    Ok(Some(vec![table, sums]))
}
