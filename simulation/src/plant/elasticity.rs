use catamaran::base::{Error, Result, finite, positive};

/// The law by which the modulus of elasticity of a segment follows from its water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Elasticity {
    /// A logistic curve of the relative water content w, scaled to `dry` at w = 0 and `full` at w =
    /// 1: `dry + (full - dry) (s(k (w - x)) - s(-k x)) / (s(k (1 - x)) - s(-k x))`, s the logistic
    /// function.
    Relative {
        /// Modulus without water, in Pa, above 0.
        dry: f64,
        /// Modulus with full cells, in Pa, above `dry`.
        full: f64,
        /// kappa, the steepness, above 0.
        steepness: f64,
        /// chi_0, the relative water content at which the curve is steepest.
        shift: f64,
    },
    /// `full / (1 + exp(-kappa (theta - chi_0)))` of theta in grams, equation 4.9 of the thesis as
    /// printed. The stiffness of a segment that is cut in two changes.
    Literal {
        /// Limit of the modulus for much water, in Pa, above 0.
        full: f64,
        /// kappa, in 1 / g.
        steepness: f64,
        /// chi_0, in g.
        shift: f64,
    },
}

impl Default for Elasticity {
    /// Returns 50 MPa full, 0.3 MPa dry, steepness 10, shift 0.75: soft stems, which lose their
    /// turgor early.
    fn default() -> Self {
        Self::Relative { dry: 3e5, full: 5e7, steepness: 10.0, shift: 0.75 }
    }
}

impl Elasticity {
    /// Computes the modulus of every segment, in Pa, from its water and its water when full, both
    /// in kg.
    ///
    /// ```
    /// use catamaran_simulation::plant::Elasticity;
    ///
    /// let moduli = Elasticity::default().moduli(&[1e-3, 0.0], &[1e-3, 1e-3])?;
    /// assert!((moduli[0] - 5e7).abs() < 1.0 && (moduli[1] - 3e5).abs() < 1.0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] names a constant out of its range, [`Error::Shape`] names `water`.
    pub fn moduli(&self, water: &[f64], full: &[f64]) -> Result<Vec<f64>> {
        self.check()?;
        Error::check_shape("water", (full.len(), 1), (water.len(), 1))?;
        Ok(water.iter().zip(full).map(|(&water, &full)| self.modulus(water, full)).collect())
    }

    pub(super) fn modulus(&self, water: f64, full_water: f64) -> f64 {
        match *self {
            Self::Relative { dry, full, steepness: k, shift: x } => {
                let w = (water / full_water).max(0.0);
                let [low, here, high] = [-x, w - x, 1.0 - x].map(|u| logistic(k * u));
                dry + (full - dry) * (here - low) / (high - low)
            }
            Self::Literal { full, steepness, shift } => {
                full * logistic(steepness * (1e3 * water - shift))
            }
        }
    }

    /// Returns the steepness kappa.
    pub(super) fn steepness(&self) -> f64 {
        let (Self::Relative { steepness, .. } | Self::Literal { steepness, .. }) = *self;
        steepness
    }

    /// Returns the same elasticity with another steepness.
    pub(super) fn with_steepness(mut self, value: f64) -> Self {
        let (Self::Relative { steepness, .. } | Self::Literal { steepness, .. }) = &mut self;
        *steepness = value;
        self
    }

    pub(super) fn check(&self) -> Result<()> {
        match *self {
            Self::Relative { dry, full, steepness, shift } => {
                positive("dry modulus", dry)?;
                positive("steepness", steepness)?;
                if !(full > dry && full.is_finite()) {
                    let why = format!(
                        "must be finite and above the dry modulus of {dry} Pa, is {full} Pa"
                    );
                    return Err(Error::Argument { what: "full modulus", why });
                }
                finite("shift", shift)?;
                let range = logistic(steepness * (1.0 - shift)) - logistic(-steepness * shift);
                if range > 0.0 {
                    return Ok(());
                }
                let why = format!("steepness {steepness} and shift {shift} give a constant");
                Err(Error::Argument { what: "elasticity", why })
            }
            Self::Literal { full, steepness, shift } => {
                positive("full modulus", full)?;
                positive("steepness", steepness)?;
                finite("shift", shift)
            }
        }
    }
}

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_dry_and_full_whatever_the_curve() {
        for (steepness, shift) in [(1.0, 0.0), (8.0, 0.6), (20.0, 0.3), (5.0, -1.0)] {
            let e = Elasticity::Relative { dry: 1e5, full: 1e8, steepness, shift };
            let moduli = e.moduli(&[0.0, 1.0, 2.0], &[2.0; 3]).unwrap();
            assert!((moduli[0] - 1e5).abs() < 1e-3 && (moduli[2] - 1e8).abs() < 1e-3, "{moduli:?}");
            assert!(moduli[0] < moduli[1] && moduli[1] < moduli[2]);
        }
    }

    #[test]
    fn the_literal_curve_is_that_of_equation_4_9() {
        let e = Elasticity::Literal { full: 2.0, steepness: 3.0, shift: 0.0 };
        let moduli = e.moduli(&[0.0, 1e-3], &[1.0; 2]).unwrap();
        assert_eq!(moduli[0], 1.0);
        assert!((moduli[1] - 2.0 / (1.0 + (-3.0_f64).exp())).abs() < 1e-15);
    }

    #[test]
    fn constants_out_of_range_are_named() {
        let flat = Elasticity::Relative { dry: 1.0, full: 2.0, steepness: 1e9, shift: 2.0 };
        assert!(flat.moduli(&[], &[]).unwrap_err().to_string().contains("give a constant"));
        for full in [1.0, 2.0, f64::INFINITY] {
            let law = Elasticity::Relative { dry: 2.0, full, steepness: 1.0, shift: 0.0 };
            let why = "full modulus: must be finite and above the dry modulus of 2 Pa, is";
            let refused = law.moduli(&[], &[]).unwrap_err().to_string();
            assert_eq!(refused, format!("{why} {full} Pa"));
        }
        let nowhere = Elasticity::Relative { dry: 1.0, full: 2.0, steepness: 1.0, shift: f64::NAN };
        let refused = nowhere.moduli(&[], &[]).unwrap_err().to_string();
        assert_eq!(refused, "shift: must be finite, is NaN");
    }
}
