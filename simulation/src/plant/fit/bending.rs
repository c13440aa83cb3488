use super::super::Plant;
use super::super::elasticity::Elasticity;
use super::super::rods::Rods;
use super::super::wilt::settle;
use super::levenberg::Minimum;
use super::minima::from_starts;
use super::options::{FitOptions, Measurements};
use catamaran::base::{Progress, Result};

/// Heights as a function of the steepness of each class.
pub(super) struct Bending<'a> {
    pub plant: &'a Plant,
    pub measured: &'a Measurements,
    /// The water at each time, and the water of full cells, in kg.
    pub curve: &'a [Vec<f64>],
    pub full: Vec<f64>,
    pub options: &'a FitOptions<'a>,
}

impl Bending<'_> {
    /// Computes the heights of the highest point, if it was measured, and of each mark, in metres.
    pub fn heights(&self, steepness: &[f64]) -> Result<(Vec<f64>, Vec<Vec<f64>>)> {
        let Measurements { heights: highest, marks, .. } = self.measured;
        let tissue = self.options.elasticity.with_steepness(steepness);
        let mut rods = Rods::new(self.plant, &self.options.rods)?;
        let mut pose = rods.rest_pose();
        let base = self.plant.base()[2];
        let mut found = (Vec::new(), vec![Vec::new(); marks.len()]);
        for water in self.curve {
            rods.set_state(&tissue.moduli(water, &self.full)?, water)?;
            settle(&rods, &mut pose, Progress::none())?;
            if !highest.is_empty() {
                let tails = pose.tails.iter().map(|tail| tail[2]);
                found.0.push(tails.fold(f64::NEG_INFINITY, f64::max) - base);
            }
            for (mark, heights) in marks.iter().zip(&mut found.1) {
                heights.push(pose.tails[mark.node][2] - base);
            }
        }
        Ok(found)
    }

    /// Returns the number of measured heights.
    pub fn count(&self) -> usize {
        let Measurements { heights, marks, .. } = self.measured;
        heights.len() + marks.iter().map(|mark| mark.heights.len()).sum::<usize>()
    }

    fn residuals(&self, x: &[f64]) -> Result<Vec<f64>> {
        let steepness: Vec<f64> = x.iter().map(|x| x.exp()).collect();
        let (heights, marks) = self.heights(&steepness)?;
        let gap = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>();
        let mut residuals = gap(&heights, &self.measured.heights);
        for (found, mark) in marks.iter().zip(&self.measured.marks) {
            residuals.extend(gap(found, &mark.heights));
        }
        Ok(residuals)
    }

    /// Returns the minima that descents from several steepnesses reach.
    pub fn minima(&self, progress: Progress<'_>) -> Result<Vec<Minimum>> {
        let classes = self.options.elasticity.classes();
        let given: Vec<f64> = classes.iter().map(Elasticity::steepness).collect();
        let bounds = vec![self.options.steepness.map(f64::ln); given.len()];
        let starts = starts(&given);
        let starts = starts.iter().map(|start| {
            let logarithms: Vec<f64> = start.iter().map(|k| k.ln()).collect();
            Ok(logarithms)
        });
        from_starts(starts, &|x| self.residuals(x), &bounds, progress)
    }
}

/// Returns start values of the steepness: the given ones, all of them smaller and larger, and, for
/// several classes, each one smaller than the others, because one class may compensate for another.
fn starts(given: &[f64]) -> Vec<Vec<f64>> {
    const SMALLER: f64 = 0.4;
    const LARGER: f64 = 2.5;
    let times = |factor: f64| given.iter().map(|k| factor * k).collect::<Vec<f64>>();
    let mut starts = vec![times(1.0), times(SMALLER), times(LARGER)];
    if given.len() > 1 {
        for class in 0..given.len() {
            let mut start = times(LARGER.sqrt());
            start[class] = SMALLER * given[class];
            starts.push(start);
        }
    }
    starts
}
