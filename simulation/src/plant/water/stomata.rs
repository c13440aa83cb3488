use std::f64::consts::LN_2;

use catamaran::base::{Result, above, at_least_zero, options, within};

options! {
    /// Stomata that close as the leaf dries. A leaf of relative water content w loses
    /// `delta A F(w) w` instead of `delta A w`, with
    ///
    /// `F(w) = c + (1 - c) f(w)`, `f(w) = 2^(exp(s (x - 1)) - exp(s (x - w)))`,
    ///
    /// which is 1 for full cells and falls to c, the share of the cuticle, when stomata are closed.
    /// One factor for each stimulus of stomata goes back to Jarvis (1976). The curve f is that of
    /// Gompertz (1825): stomata begin to close slowly and end abruptly, as those of the leaves of
    /// docs/algorithms/plant.md do. The tail of a logistic function would stand for the loss
    /// through the cuticle. The thesis leaves stomata for future work (section 4.6).
    ///
    /// ```
    /// use catamaran_simulation::plant::Stomata;
    ///
    /// let stomata = Stomata::new().half(0.8).steepness(25.0);
    /// assert_eq!(stomata.openness(1.0), 1.0);
    /// assert!((stomata.openness(0.8) - 0.5).abs() < 0.01 && stomata.openness(0.5) < 1e-3);
    /// assert_eq!(stomata.cuticular(0.02).openness(0.3), 0.02);
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Stomata {
        /// x, the relative water content at which stomata are about half closed.
        half: f64 = 0.8, range "above 0, at most 1";
        /// s, the steepness of the closing; with 0 they stay open.
        steepness: f64 = 25.0, range "at least 0";
        /// c, the loss through the cuticle, relative to that of full cells with open stomata.
        cuticular: f64 = 0.0, range "from 0 to 1";
    }
}

impl Stomata {
    /// Returns F: the loss of a leaf of this relative water content relative to its loss with open
    /// stomata.
    pub fn openness(&self, relative: f64) -> f64 {
        self.cuticular + (1.0 - self.cuticular) * self.opening(relative)
    }

    /// Returns the derivative of [`Stomata::openness`].
    pub(super) fn slope(&self, relative: f64) -> f64 {
        match self.opening(relative) {
            // The other factor may be infinite.
            0.0 => 0.0,
            open => (1.0 - self.cuticular) * open * LN_2 * self.steepness * self.dryness(relative),
        }
    }

    /// Returns f.
    fn opening(&self, relative: f64) -> f64 {
        (self.dryness(1.0) - self.dryness(relative)).exp2()
    }

    fn dryness(&self, relative: f64) -> f64 {
        (self.steepness * (self.half - relative)).exp()
    }

    pub(super) fn check(&self) -> Result<()> {
        at_least_zero("steepness of stomata", self.steepness)?;
        above("half of stomata", self.half, 0.0, 1.0)?;
        within("cuticular share of stomata", self.cuticular, 0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_the_derivative_and_open_stomata_have_none() {
        for (half, steepness) in [(0.8, 25.0), (0.5, 4.0), (0.9, 400.0)] {
            let stomata = Stomata { half, steepness, cuticular: 0.1 };
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
    fn dry_leaves_lose_through_the_cuticle_alone() {
        for (half, steepness) in [(0.8, 25.0), (0.5, 100.0), (0.9, 1e5)] {
            let stomata = Stomata { half, steepness, cuticular: 0.03 };
            assert!((stomata.openness(1.0) - 1.0).abs() < 1e-15);
            assert_eq!((stomata.openness(0.1), stomata.slope(0.1)), (0.03, 0.0));
            let mut before = 1.0 + 1e-15;
            for i in (0..=100).rev() {
                let open = stomata.openness(0.01 * f64::from(i));
                assert!((0.03..=before).contains(&open), "{open}");
                before = open;
            }
        }
    }

    #[test]
    fn constants_out_of_range_are_named() {
        let says = |stomata: Stomata, part: &str| {
            let refused = stomata.check().unwrap_err().to_string();
            assert!(refused.contains(part), "{refused}");
        };
        says(Stomata::new().steepness(-1.0), "steepness of stomata: must be finite and at least 0");
        let share = "cuticular share of stomata: must be from 0 to 1";
        says(Stomata::new().cuticular(1.5), share);
        says(Stomata::new().cuticular(f64::NAN), share);
        for half in [f64::NAN, 0.0, 1.001, 2.5] {
            says(Stomata::new().half(half), "half of stomata: must be above 0 and at most 1, is ");
        }
    }
}
