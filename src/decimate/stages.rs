use crate::base::{Error, Flow, Progress, Result};

/// The progress of a sequence of stages, each with its share of the time.
#[derive(Clone, Copy)]
pub(super) struct Stages<'a> {
    progress: Option<Progress<'a>>,
    from: f64,
    to: f64,
}

impl<'a> Stages<'a> {
    pub fn new(progress: Option<Progress<'a>>) -> Self {
        Self { progress, from: 0.0, to: 1.0 }
    }

    /// The part between these fractions of this one.
    pub fn part(&self, from: f64, to: f64) -> Self {
        let at = |fraction: f64| self.from + fraction * (self.to - self.from);
        Self { progress: self.progress, from: at(from), to: at(to) }
    }

    /// Tells that this fraction is done.
    pub fn report(&self, fraction: f64) -> Result<()> {
        let Some(progress) = self.progress else { return Ok(()) };
        match progress(self.from + fraction.clamp(0.0, 1.0) * (self.to - self.from)) {
            Flow::Continue => Ok(()),
            Flow::Cancel => Err(Error::Cancelled),
        }
    }
}
