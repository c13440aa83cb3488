use catamaran::base::{Error, Result, Rng, options};

options! {
    /// A wind that is uniform over the plant, with gusts.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Wind {
        /// The mean velocity; 0 is still air, which damps motion.
        velocity: [f64; 3] = [0.0; 3], unit "m / s", range "finite";
        /// The turbulence intensity: the standard deviation of each component of the velocity,
        /// relative to the mean speed.
        turbulence: f64 = 0.2, check(at least 0);
        /// The correlation time of gusts: the time in which a gust decays by a factor of e.
        memory: f64 = 1.0, unit "s", check(positive);
        /// Seed of the gusts.
        seed: u64 = 0;
    }
}

/// The wind as a function of time: around the mean, each component is an Ornstein-Uhlenbeck
/// process, stationary from the beginning and exact for every step.
///
/// ```
/// use catamaran_simulation::plant::{Gusts, Wind};
///
/// let mut gusts = Gusts::new(&Wind::new().velocity([3.0, 0.0, 0.0]).turbulence(0.0))?;
/// assert_eq!(gusts.after(0.1), [3.0, 0.0, 0.0]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Gusts {
    wind: Wind,
    rng: Rng,
    /// Deviation from the mean, in standard deviations.
    present: [f64; 3],
}

impl Gusts {
    /// Creates the wind at time 0.
    ///
    /// # Errors
    /// [`Error::Argument`] names an option out of its range.
    pub fn new(wind: &Wind) -> Result<Self> {
        if wind.velocity.iter().any(|x| !x.is_finite()) {
            let why = format!("the velocity must be finite, is {:?}", wind.velocity);
            return Err(Error::Argument { what: "wind", why });
        }
        wind.check_ranges()?;
        let mut rng = Rng::new(wind.seed);
        let present = [(); 3].map(|()| rng.normal());
        Ok(Self { wind: *wind, rng, present })
    }

    /// Advances by `seconds`, and returns the velocity of the air, in m / s.
    pub fn after(&mut self, seconds: f64) -> [f64; 3] {
        let kept = (-seconds / self.wind.memory).exp();
        let fresh = (1.0 - kept * kept).max(0.0).sqrt();
        self.present = self.present.map(|x| kept * x + fresh * self.rng.normal());
        let mean = self.wind.velocity;
        let speed = mean.iter().map(|x| x * x).sum::<f64>().sqrt();
        [0, 1, 2].map(|i| mean[i] + self.wind.turbulence * speed * self.present[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gusts_have_the_mean_the_deviation_and_the_memory_asked_for() {
        let wind = Wind::new().velocity([4.0, 0.0, 3.0]).turbulence(0.3).memory(0.5).seed(3);
        let mut gusts = Gusts::new(&wind).unwrap();
        let count = 40_000;
        let found: Vec<[f64; 3]> = (0..count).map(|_| gusts.after(0.25)).collect();
        let mean = |f: &dyn Fn(usize) -> f64| (0..count - 2).map(f).sum::<f64>() / count as f64;
        for i in 0..3 {
            let off = |k: usize| found[k][i] - wind.velocity[i];
            // A deviation of 1.5 m / s over 20,000 correlation times: errors of about 0.02.
            assert!(mean(&off).abs() < 0.05);
            assert!((mean(&|k| off(k) * off(k)).sqrt() - 1.5).abs() < 0.05);
            let kept = mean(&|k| off(k) * off(k + 2)) / 2.25;
            assert!((kept - (-1.0_f64).exp()).abs() < 0.04, "{kept}");
        }
        assert_eq!(Gusts::new(&wind).unwrap().after(0.25), found[0]);
    }

    #[test]
    fn options_out_of_range_are_named() {
        let says = |wind: Wind, part: &str| {
            assert!(Gusts::new(&wind).unwrap_err().to_string().contains(part));
        };
        says(Wind::new().velocity([f64::NAN, 0.0, 0.0]), "wind");
        says(Wind::new().turbulence(-1.0), "turbulence");
        says(Wind::new().memory(0.0), "memory");
    }
}
