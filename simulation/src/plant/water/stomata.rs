use catamaran::base::{Error, Result, at_least_zero, finite, options};

options! {
    /// Stomata that close as the leaf dries. A leaf of relative water content w loses
    /// `delta A f(w) w` instead of `delta A w`, with the logistic function
    ///
    /// `f(w) = (1 + exp(s (x - 1))) / (1 + exp(s (x - w)))`,
    ///
    /// which is 1 for full cells. One factor for each stimulus of stomata goes back to Jarvis
    /// (1976). This factor is that of Tuzet, Perrier and Leuning (2003) for the water potential,
    /// which is linear in w here. The thesis leaves stomata for future work (section 4.6).
    ///
    /// ```
    /// use catamaran_simulation::plant::Stomata;
    ///
    /// let stomata = Stomata::new().half(0.8).steepness(25.0);
    /// assert_eq!(stomata.openness(1.0), 1.0);
    /// assert!((stomata.openness(0.8) - 0.5).abs() < 0.01 && stomata.openness(0.5) < 1e-3);
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Stomata {
        /// x, the relative water content at which stomata are about half closed.
        half: f64 = 0.8, range "finite";
        /// s, the steepness of the closing; with 0 they stay open.
        steepness: f64 = 25.0, range "at least 0";
    }
}

impl Stomata {
    /// Returns f: the loss of a leaf of this relative water content relative to its loss with open
    /// stomata.
    pub fn openness(&self, relative: f64) -> f64 {
        self.scale() * logistic(self.steepness * (relative - self.half))
    }

    /// Returns the derivative of [`Stomata::openness`].
    pub(super) fn slope(&self, relative: f64) -> f64 {
        let x = self.steepness * (relative - self.half);
        self.scale() * self.steepness * logistic(x) * logistic(-x)
    }

    fn scale(&self) -> f64 {
        1.0 + (self.steepness * (self.half - 1.0)).exp()
    }

    pub(super) fn check(&self) -> Result<()> {
        at_least_zero("steepness of stomata", self.steepness)?;
        finite("half of stomata", self.half)?;
        if self.scale().is_finite() {
            return Ok(());
        }
        let Self { half, steepness } = self;
        let why = format!(
            "exp(steepness (half - 1)) must be finite, with steepness {steepness} and half {half}"
        );
        Err(Error::Argument { what: "stomata", why })
    }
}

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_the_derivative_and_open_stomata_have_none() {
        for (half, steepness) in [(0.8, 25.0), (0.5, 4.0), (0.9, 400.0)] {
            let stomata = Stomata { half, steepness };
            for w in [0.1, 0.5, 0.79, 0.9, 1.0] {
                let h = 1e-6;
                let slope = (stomata.openness(w + h) - stomata.openness(w - h)) / (2.0 * h);
                let size = slope.abs().max(1.0);
                assert!((slope - stomata.slope(w)).abs() < 1e-5 * size, "{slope}");
            }
        }
        let open = Stomata::new().steepness(0.0);
        assert_eq!([0.0, 0.4, 1.0].map(|w| open.openness(w)), [1.0; 3]);
        assert_eq!(open.slope(0.4), 0.0);
    }

    #[test]
    fn constants_out_of_range_are_named() {
        let says = |stomata: Stomata, part: &str| {
            let refused = stomata.check().unwrap_err().to_string();
            assert!(refused.contains(part), "{refused}");
        };
        says(Stomata::new().steepness(-1.0), "steepness of stomata: must be finite and at least 0");
        says(Stomata::new().half(f64::NAN), "half of stomata: must be finite, is NaN");
        says(Stomata::new().half(100.0).steepness(1e3), "with steepness 1000 and half 100");
    }
}
