//! `wilt --fit` with `--weather`: fits conductances and the closing of stomata to drying leaves.

use std::path::Path;

use anyhow::{Context, Result, bail};
use catamaran::base::Progress;
use catamaran::io::Output;
use catamaran_charts::{Axis, Chart, Line, Series};
use catamaran_simulation::plant::{
    DryingLeaf, Estimate, FittedLeaf, LeafGroup, LeafOptions, LeafTable, LeavesFit, fit_leaves,
    read_leaves,
};

use super::fit::{NAMES, write};
use crate::input::TextFile;
use crate::picture::write_chart;
use crate::progress::Bar;
use crate::report::{note, report};

/// Milligrams and millimoles in kilograms and moles.
const MILLIGRAMS: f64 = 1e6;
const MILLIMOLES: f64 = 1e3;
const GRAMS: f64 = 1e3;

/// The first weights of an unseen leaf, from which its constants are found, too.
const FIRST: usize = 5;

/// The tables, and what is done with them.
pub struct Request<'a> {
    pub drying: &'a TextFile,
    pub weather: &'a TextFile,
    pub curves: Option<&'a TextFile>,
    /// The names of leaves that are not fitted.
    pub unseen: &'a [String],
    /// The error of a weight, in kg.
    pub instrument: f64,
}

/// A leaf beside the model.
struct Course<'a> {
    group: &'a str,
    leaf: &'a DryingLeaf,
    seconds: &'a [f64],
    found: FittedLeaf,
    /// The differences of an unseen leaf without any of its weights, and with the first ones.
    early: Option<[f64; 2]>,
}

/// The groups of leaves and their fits.
pub struct Fitted<'a> {
    fits: Vec<(&'a str, LeavesFit)>,
    courses: Vec<Course<'a>>,
}

/// Reads the tables.
pub fn read(request: &Request<'_>) -> Result<Vec<LeafGroup>> {
    let [drying, air] = [request.drying, request.weather].map(Named::read);
    let (drying, air) = (drying?, air?);
    let curves = request.curves.map(Named::read).transpose()?;
    let groups = read_leaves(drying.table(), air.table(), curves.as_ref().map(Named::table))?;
    for name in request.unseen {
        if !groups.iter().any(|group| group.leaves.iter().any(|leaf| leaf.name == *name)) {
            bail!("--unseen {name}: {} has no such leaf", request.drying.name());
        }
    }
    let is_unseen = |leaf: &DryingLeaf| request.unseen.contains(&leaf.name);
    if let Some(group) = groups.iter().find(|group| group.leaves.iter().all(is_unseen)) {
        let (drying, name) = (request.drying.name(), &group.name);
        bail!("--unseen: {drying}: treatment {name:?} has no other leaf, which would be fitted");
    }
    Ok(groups)
}

/// The name and the text of a table.
struct Named {
    name: String,
    text: String,
}

impl Named {
    fn read(file: &TextFile) -> Result<Self> {
        Ok(Self { name: file.name(), text: file.read()? })
    }

    fn table(&self) -> LeafTable<'_> {
        LeafTable { path: Path::new(&self.name), text: &self.text }
    }
}

/// Fits the leaves of each group and reports the constants.
pub fn run<'a>(groups: &'a [LeafGroup], request: &Request<'_>) -> Result<Fitted<'a>> {
    let mut fitted = Fitted { fits: vec![], courses: vec![] };
    let bar = Bar::new("fitting");
    for (i, group) in groups.iter().enumerate() {
        for line in &group.notes {
            note(format_args!("{line}"));
        }
        let (start, count) = (i as f64, groups.len() as f64);
        let update = |done: f64| bar.update((start + done) / count);
        let prior = group.prior();
        let options = LeafOptions::new().instrument(request.instrument).prior(prior);
        let options = options.progress(Progress::new(&update));
        let is_unseen = |leaf: &DryingLeaf| request.unseen.contains(&leaf.name);
        let seen: Vec<DryingLeaf> =
            group.leaves.iter().filter(|leaf| !is_unseen(leaf)).cloned().collect();
        let what = || format!("{}, treatment {:?}", request.drying.name(), group.name);
        let fit = fit_leaves(&seen, &options).with_context(what)?;
        let mut found = fit.leaves.iter();
        for (leaf, seconds) in group.leaves.iter().zip(&group.seconds) {
            let (found, early) = match is_unseen(leaf) {
                false => (found.next().cloned().with_context(what)?, None),
                true => {
                    let rms = |used| fit.unseen(leaf, used, &options).map(|found| found.rms);
                    let early = [rms(0).with_context(what)?, rms(FIRST).with_context(what)?];
                    let found = fit.unseen(leaf, leaf.weights.len(), &options);
                    (found.with_context(what)?, Some(early))
                }
            };
            fitted.courses.push(Course { group: &group.name, leaf, seconds, found, early });
        }
        fitted.fits.push((group.name.as_str(), fit));
    }
    drop(bar);
    for (group, (name, fit)) in groups.iter().zip(&fitted.fits) {
        report_fit(name, fit, group.prior())?;
        for course in fitted.courses.iter().filter(|course| course.group == *name) {
            report_leaf(course)?;
        }
        for warning in &fit.warnings {
            report!("misfit": "warning", group = name, warning = warning; "{name}: {warning}")?;
        }
    }
    Ok(fitted)
}

/// Returns the value of an estimate and its error.
fn shown(Estimate { value, error }: Estimate, scale: f64, digits: usize) -> String {
    let value = scale * value;
    match error {
        e if e.is_nan() => format!("{value:.digits$} (at a bound)"),
        e if e.is_infinite() => format!("{value:.digits$} (not determined)"),
        e => format!("{value:.digits$} +- {:.digits$}", scale * e),
    }
}

fn report_fit(name: &str, fit: &LeavesFit, prior: Option<Estimate>) -> Result<()> {
    let rms = GRAMS * fit.rms;
    let (cuticular, steepness) = (fit.cuticular, fit.steepness);
    let turgor =
        prior.map_or(String::new(), |prior| format!("; turgor lost at {}", shown(prior, 1.0, 3)));
    report!(
        "treatment",
        name = name,
        cuticular_mmol = MILLIMOLES * cuticular.value,
        cuticular_error = MILLIMOLES * cuticular.error,
        steepness = steepness.value,
        steepness_error = steepness.error,
        turgor_loss = prior.map(|prior| prior.value),
        rms_grams = rms;
        "{name}: cuticle {} mmol/(m^2 s), steepness {}{turgor}; rms {rms:.4} g",
        shown(cuticular, MILLIMOLES, 3),
        shown(steepness, 1.0, 1)
    )
}

fn report_leaf(course: &Course<'_>) -> Result<()> {
    let (name, found) = (&course.leaf.name, &course.found);
    let rms = GRAMS * found.rms;
    let early = course.early.map(|early| early.map(|rms| GRAMS * rms));
    let unseen = early.map_or(String::new(), |[none, first]| {
        format!("; unseen: {none:.4} g without its weights, {first:.4} g from its first {FIRST}")
    });
    report!(
        "leaf",
        name = name,
        open_mmol = MILLIMOLES * found.open.value,
        open_error = MILLIMOLES * found.open.error,
        closing = found.closing.value,
        closing_error = found.closing.error,
        rms_grams = rms,
        unseen_rms_grams = early;
        "{name}: open {} mmol/(m^2 s), half closed at {}; rms {rms:.4} g{unseen}",
        shown(found.open, MILLIMOLES, 1),
        shown(found.closing, 1.0, 3)
    )
}

impl Fitted<'_> {
    /// Writes the constants, the weights beside the model, and a picture of both.
    pub fn write(&self, file: impl Fn(&str) -> Result<Output>) -> Result<()> {
        let mut text = "treatment,leaf,constant,value,standard_error,unit\n".to_string();
        let mut line = |group: &str, leaf: &str, constant: &str, e: Estimate, unit: &str| {
            text += &format!("{group},{leaf},{constant},{},{},{unit}\n", e.value, e.error);
        };
        for (name, fit) in &self.fits {
            line(name, "", "cuticular", fit.cuticular, "mol/(m^2 s)");
            line(name, "", "steepness", fit.steepness, "1");
        }
        for Course { group, leaf, found, .. } in &self.courses {
            line(group, &leaf.name, "open", found.open, "mol/(m^2 s)");
            line(group, &leaf.name, "closing", found.closing, "1");
        }
        write(file(NAMES[0])?, &text)?;
        write(file(NAMES[1])?, &self.table())?;
        write_chart(file(NAMES[2])?, &self.chart())
    }

    /// Returns the weights beside the model, as CSV.
    fn table(&self) -> String {
        let mut text = "treatment,leaf,use,time_h,weight_g,model_g,difference_mg\n".to_string();
        for Course { group, leaf, seconds, found, early } in &self.courses {
            let part = if early.is_some() { "unseen" } else { "fitted" };
            for ((second, weight), model) in seconds.iter().zip(&leaf.weights).zip(&found.weights) {
                let hours = second / 3600.0;
                text += &format!("{group},{},{part},{hours},", leaf.name);
                let difference = MILLIGRAMS * (model - weight);
                text += &format!("{},{},{difference:.3}\n", GRAMS * weight, GRAMS * model);
            }
        }
        text
    }

    /// Draws the weights as parts of those with full cells: lines are the model, dots the scale.
    fn chart(&self) -> Chart {
        let mut curves = Vec::new();
        let (mut hours, mut lightest): (f64, f64) = (0.0, 1.0);
        for (i, (name, _)) in self.fits.iter().enumerate() {
            let of_group = self.courses.iter().filter(|course| course.group == *name);
            // The legend names the first line of each kind.
            let mut named = [false; 2];
            for Course { leaf, seconds, found, early, .. } in of_group {
                let points = |weights: &[f64]| -> Vec<(f64, f64)> {
                    let part = |weight: &f64| weight / leaf.saturated;
                    seconds.iter().map(|s| s / 3600.0).zip(weights.iter().map(part)).collect()
                };
                let (model, scale) = (points(&found.weights), points(&leaf.weights));
                for (hour, part) in &scale {
                    (hours, lightest) = (hours.max(*hour), lightest.min(*part));
                }
                let kind = usize::from(early.is_some());
                let title = match std::mem::replace(&mut named[kind], true) {
                    false => format!("{name} {}", ["fitted", "unseen"][kind]),
                    true => String::new(),
                };
                let (line, color) = ([Line::Solid, Line::Dashed][kind], Series::color(i));
                curves.push(Series { line, ..Series::curve(title, color, model) });
                let dots = Series::curve("", color, scale);
                curves.push(Series { line: Line::None, dots: true, ..dots });
            }
        }
        Chart::new(
            Axis::linear("hours").range(0.0, hours.max(f64::MIN_POSITIVE)),
            Axis::linear("weight as a part of that with full cells")
                .range((lightest - 0.02).max(0.0), 1.02),
            curves,
        )
    }
}
